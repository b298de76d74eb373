//! How much of a light arrives: a cone through skins and past opaque meshes. [seed §6.1b]

use glam::DVec3;
use pelage_geom::{Cone, Ray};

use super::Trail;
use super::deep_shadow::{DeepShadows, LightCone};
use super::march::{Beam, march, through};
use super::passages::{self, BoxPassage};
use super::{Blend, Piece};
use crate::{Counts, Scene, Settings};

/// A cone from a shaded point towards a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowCone {
    /// The shaded point, scene space.
    pub origin: DVec3,
    /// Unit vector to the light.
    pub direction: DVec3,
    /// From where on things count, in scene units: a voxel does not shadow itself here.
    pub start: f64,
    /// How far the light is.
    pub end: f64,
    /// The cone's width; as wide as what is shaded, and widening with the light's size.
    pub cone: Cone,
    /// How alike the ways to the eye and to the light still are.
    pub correlation: Correlation,
}

/// What is seen is seen through a gap, and near it the light comes through the same gap: depth close to the shaded
/// point counts less, the more the two directions agree. A depth that lies at distances `[x, y]` counts
/// F = 1 − e^−qx (1 − e^−q(y−x)) / (q (y − x)), where 1/q is the distance over which the two ways part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correlation {
    /// Per scene unit; infinite where the ways have nothing to do with each other.
    pub q: f32,
}

impl Correlation {
    /// Everything counts in full: for cones from surfaces.
    pub const NONE: Self = Self { q: f32::INFINITY };

    /// F for a depth between the distances `x` and `y` from the shaded point.
    #[inline]
    pub fn factor(self, x: f32, y: f32) -> f32 {
        // e^−20 is below the last place of 1.
        if self.q * x > 20.0 || self.q == f32::INFINITY {
            return 1.0;
        }
        1.0 - (-self.q * x).exp() * decay(self.q * (y - x))
    }
}

/// φ(x) = (1 − e^−x) / x, by its series near zero. Also for negative x.
#[inline]
pub(crate) fn decay(x: f32) -> f32 {
    if x.abs() < 1e-2 { 1.0 - 0.5 * x + x * x / 6.0 } else { -(-x).exp_m1() / x }
}

/// Buffers of shadow cones, reused.
#[derive(Default)]
pub(crate) struct ShadowBuffers {
    passages: Vec<BoxPassage>,
    trail: Trail,
    deep: DeepShadows,
}

impl ShadowBuffers {
    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.trail.counts)
    }

    /// The part of a light of the scene that the coats let through, by one of its lines.
    pub fn of_light(&mut self, scene: &Scene, settings: &Settings, of: &LightCone) -> f32 {
        self.deep.transmittance(scene, settings, of, &mut self.trail)
    }

    /// The part of a light from anywhere that the coats let through.
    pub fn through_coats(&mut self, scene: &Scene, settings: &Settings, shadow: &ShadowCone) -> f32 {
        let ray = Ray { origin: shadow.origin, direction: shadow.direction };
        let beam = Beam { ray: &ray, cone: &shadow.cone, settings };
        let mut blend = Blend::START;
        self.trail.counts.light_cones += 1;
        passages::collect(scene, &ray, shadow.start, shadow.end, &mut self.passages);
        for passage in &self.passages {
            // A walk ends by depths that are not yet weighed by their correlation: it must go on for longer than what
            // counts, which may be a quarter of them.
            let correlated = shadow.correlation.factor(passage.t[0] as f32, passage.t[1] as f32) < 1.0;
            let least = settings.min_transmittance.powi(if correlated { 4 } else { 1 });
            self.trail.chords.clear();
            march(scene, beam, passage, blend.transmittance(), least, &mut self.trail);
            for piece in self.trail.pieces() {
                let passed = passed(&self.trail, piece, settings, shadow.correlation);
                blend.pass(piece.key.level, piece.even, passed);
            }
            if blend.transmittance() < settings.min_transmittance {
                return 0.0;
            }
        }
        blend.transmittance()
    }
}

/// Whether an opaque mesh stands between the start of a ray, which may lie on one, and the distance `end`.
pub(crate) fn is_blocked(scene: &Scene, ray: &Ray, end: f64) -> bool {
    let off = scene.rounding();
    scene.surfaces.blocked(&Ray { origin: ray.at(off), ..*ray }, end - off)
}

fn passed(trail: &Trail, piece: &Piece, settings: &Settings, correlation: Correlation) -> f32 {
    let [near, far] = trail.distances(piece);
    let factor = correlation.factor(near, far);
    // Beyond the neighbourhood nothing is correlated, and what gets through is known.
    if factor == 1.0 { piece.through } else { through(settings.opacity, factor * piece.depth) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_limits() {
        // The same way (q = 0): nothing counts. No relation: everything. Far away: everything.
        assert!(Correlation { q: 0.0 }.factor(0.0, 5.0).abs() < 1e-6);
        assert_eq!(Correlation::NONE.factor(0.0, 1.0), 1.0);
        assert!((Correlation { q: 2.0 }.factor(50.0, 51.0) - 1.0).abs() < 1e-6);
        // F is the mean of 1 − e^−qs over [x, y]: midpoint rule with q = 3 over [0.2, 0.9].
        let n = 10_000;
        let mean: f64 = (0..n)
            .map(|i| 1.0 - (-3.0 * (0.2 + 0.7 * (f64::from(i) + 0.5) / f64::from(n))).exp())
            .sum::<f64>()
            / f64::from(n);
        assert!((f64::from(Correlation { q: 3.0 }.factor(0.2, 0.9)) - mean).abs() < 1e-5);
    }

    #[test]
    fn decay_is_smooth_through_zero() {
        for x in [-0.0101_f32, -0.0099, 0.0, 0.0099, 0.0101, 3.0, -2.0] {
            let exact = if x == 0.0 { 1.0 } else { (1.0 - (-f64::from(x)).exp()) / f64::from(x) };
            assert!((f64::from(decay(x)) - exact).abs() < 1e-5 * exact, "{x}");
        }
    }
}
