//! Which levels of the texel a cone reads: the footprint pulled back through the Jacobian. [seed §4.2, Williams83]

use glam::{Mat3, Vec3};
use pelage_geom::{Cone, texel_footprint};

use crate::Lod;

/// Two neighbouring levels and the weight of the finer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    /// The coarser level, `2^coarse` voxels a side.
    pub coarse: u32,
    /// Weight of level `coarse + 1`, in `[0, 1)`; at 0 only the coarser is read.
    pub blend: f32,
}

impl Band {
    /// The finest level that has any weight.
    pub fn finest(self) -> u32 {
        self.coarse + u32::from(self.blend > 0.0)
    }

    /// The levels that have any weight, with it.
    pub fn levels(self) -> impl Iterator<Item = (u32, f32)> {
        let coarse = (self.coarse, 1.0 - self.blend);
        [coarse, (self.coarse + 1, self.blend)].into_iter().filter(|(_, weight)| *weight > 0.0)
    }

    /// The band of a continuous level λ, where a texel has levels `0..=depth`.
    pub fn of(lambda: f32, depth: u32) -> Self {
        let lambda = lambda.clamp(0.0, depth as f32);
        let coarse = lambda as u32;
        // 1/256 of a level shows in no picture, and reading one level costs half of two.
        let blend = lambda - coarse as f32;
        match blend {
            _ if blend < 1.0 / 256.0 => Self { coarse, blend: 0.0 },
            _ if blend > 255.0 / 256.0 => Self { coarse: coarse + 1, blend: 0.0 },
            _ => Self { coarse, blend },
        }
    }
}

/// The continuous level λ = −log₂(footprint in texel units) for a cone at distance `t`, where `jacobian` maps texel
/// steps to scene steps. Not clamped: negative where one texel is smaller than the footprint.
pub(crate) fn lambda(lod: Lod, jacobian: &Mat3, direction: Vec3, cone: &Cone, t: f64) -> f32 {
    match lod {
        Lod::Level(level) => level as f32,
        Lod::Footprint(rule) => {
            let footprint = texel_footprint(rule, jacobian, direction, cone.width(t) as f32);
            // A cone of no width reads the finest level; a singular Jacobian the coarsest.
            if footprint.is_nan() { 0.0 } else { -footprint.max(f32::MIN_POSITIVE).log2() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands() {
        assert_eq!(Band::of(-3.0, 7), Band { coarse: 0, blend: 0.0 });
        assert_eq!(Band::of(9.5, 7), Band { coarse: 7, blend: 0.0 });
        assert_eq!(Band::of(2.25, 7), Band { coarse: 2, blend: 0.25 });
        assert_eq!(Band::of(2.001, 7), Band { coarse: 2, blend: 0.0 });
        assert_eq!(Band::of(2.999, 7), Band { coarse: 3, blend: 0.0 });
        assert_eq!((Band::of(2.25, 7).finest(), Band::of(2.0, 7).finest()), (3, 2));
    }

    #[test]
    fn a_cone_as_wide_as_a_voxel_reads_its_level() {
        // A box of side 2, and a cone 1/4 wide: 1/8 of the texel, level 3.
        let cone = Cone { width: 0.25, spread: 0.0 };
        let jacobian = Mat3::from_diagonal(Vec3::splat(2.0));
        let level = lambda(Lod::default(), &jacobian, Vec3::Z, &cone, 7.0);
        assert!((level - 3.0).abs() < 1e-5);
    }
}
