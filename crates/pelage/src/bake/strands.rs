//! How thick strands are, and what they wear along themselves.

use glam::{Vec2, Vec3, Vec4};
use pelage_geom::AlphaMode;

use super::paint::{Corner, Paint};
use super::placing::Placing;
use super::tube::Knot;
use super::{BakeFault, ContentOptions};
use crate::import::{Imported, Strand};

/// The radii of strands that have none of their own, at their beginning and at their end, in units of the model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Thickness {
    root: f32,
    tip: f32,
}

impl Thickness {
    pub(super) fn new(model: &Imported, options: &ContentOptions) -> Result<Self, BakeFault> {
        let count = model.strands.iter().filter(|strand| strand.radii.is_none()).count();
        match options.radius {
            Some(root) => Ok(Self { root, tip: options.tip_radius.unwrap_or(root) }),
            None if count > 0 => Err(BakeFault::Radius { count }),
            None => Ok(Self::default()),
        }
    }

    /// The smallest and largest coordinates of a model, its strands as thick as they are, or `None` without any.
    pub(super) fn bounds(self, model: &Imported) -> Option<[Vec3; 2]> {
        let strands = model.strands.iter().filter_map(|strand| {
            let thickest = self.radii(strand).fold(0.0, f32::max);
            let first = [*strand.points.first()?; 2];
            let [low, high] = strand.points.iter().fold(first, |[low, high], &p| [low.min(p), high.max(p)]);
            Some([low - thickest, high + thickest])
        });
        strands.chain(model.bounds()).reduce(|[a, b], [low, high]| [a.min(low), b.max(high)])
    }

    /// The radius at each point.
    fn radii(self, strand: &Strand) -> impl Iterator<Item = f32> + '_ {
        let lengths = strand.points.windows(2).map(|pair| pair[0].distance(pair[1]));
        let whole = lengths.clone().sum::<f32>().max(f32::MIN_POSITIVE);
        let along = std::iter::once(0.0).chain(lengths.scan(0.0, |sum: &mut f32, length| {
            *sum += length;
            Some(*sum)
        }));
        let tapered = along.map(move |at| self.root + (self.tip - self.root) * (at / whole).min(1.0));
        tapered
            .enumerate()
            .map(|(i, r)| strand.radii.as_ref().and_then(|radii| radii.get(i)).map_or(r, |&r| r))
    }

    /// The parts of a strand that are there, in texel space: alpha below a mask's cutoff ends them, that of a blend
    /// makes them thinner. `cut` is told whether alpha took anything away.
    pub(super) fn knots(
        self,
        strand: &Strand,
        paint: &Paint,
        placing: Placing,
        cut: &mut bool,
    ) -> Vec<Vec<Knot>> {
        let mut parts = vec![Vec::new()];
        for (i, (&point, radius)) in strand.points.iter().zip(self.radii(strand)).enumerate() {
            let uv = strand.uvs.as_ref().and_then(|uvs| uvs.get(i)).copied().unwrap_or(Vec2::ZERO);
            let color = strand.colors.as_ref().and_then(|colors| colors.get(i)).copied().unwrap_or(Vec4::ONE);
            let at = Corner { position: placing.apply(point), uv, color };
            let alpha = paint.alpha(&at, 0.0);
            let part = match paint.mode() {
                AlphaMode::Opaque => 1.0,
                AlphaMode::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
                AlphaMode::Blend => alpha.clamp(0.0, 1.0),
            };
            *cut |= part < 1.0;
            if part == 0.0 {
                parts.push(Vec::new());
            } else if let Some(knots) = parts.last_mut() {
                let radius = part * radius * placing.scale();
                knots.push(Knot { position: at.position, radius, color: paint.color(&at, 0.0) });
            }
        }
        parts.retain(|knots| knots.len() > 1);
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_taper_with_the_length() {
        let points = vec![Vec3::ZERO, Vec3::X, 4.0 * Vec3::X];
        let bare = Strand { points: points.clone(), ..Strand::default() };
        let own = Strand { points, radii: Some(vec![3.0, 2.0, 1.0]), ..Strand::default() };
        let thickness = Thickness { root: 0.4, tip: 0.0 };
        let close = |a: Vec<f32>, b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(close(thickness.radii(&bare).collect(), [0.4, 0.3, 0.0]));
        assert!(close(thickness.radii(&own).collect(), [3.0, 2.0, 1.0]));
        let model = Imported { strands: vec![bare, own], ..Imported::default() };
        assert_eq!(thickness.bounds(&model), Some([Vec3::splat(-3.0), Vec3::new(7.0, 3.0, 3.0)]));
        let fault = Thickness::new(&model, &ContentOptions::default()).unwrap_err();
        assert_eq!(fault, BakeFault::Radius { count: 1 });
    }
}
