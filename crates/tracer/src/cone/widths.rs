//! How wide a cone from a point to a light is, where lines of the light stand for it.

use std::f64::consts::SQRT_2;

use pelage_geom::Cone;

use super::light_lines::LightLines;
use super::shadow::ShadowCone;
use crate::Scene;

/// A cone widens by no more octaves than these: it is wider than anything then.
pub(super) const MOST_STEPS: i32 = 24;

/// How wide a cone from a point to a light is: by octaves, the further from the point.
pub(super) struct Widths {
    /// The octave that it begins with.
    pub octave: i32,
    /// Scene units by unit of width: of the sun's cones those of [`Scene::edge`], so that voxels of boxes like most are as
    /// wide as a whole octave; a lamp's are as wide as they are far from it.
    unit: f64,
    /// Its width at the point, in units, and what it gains by unit of distance.
    width: f64,
    spread: f64,
    /// How far a lamp is, which it narrows towards; infinite for the sun.
    distance: f64,
}

impl Widths {
    pub fn new(lines: &LightLines, scene: &Scene, shadow: &ShadowCone) -> Self {
        let (unit, distance) = match lines {
            LightLines::Sun { .. } => (scene.edge, f64::INFINITY),
            LightLines::Lamp { .. } => (shadow.end, shadow.end),
        };
        let Cone { width, spread } = shadow.cone;
        let (width, spread) = (width / unit, spread / unit);
        Self { octave: octave(width), unit, width, spread, distance }
    }

    /// The cone of the light's line that stands for the cone after `step` octaves.
    pub fn cone(&self, step: i32) -> Cone {
        let width = f64::from(self.octave + step).exp2();
        match self.distance == f64::INFINITY {
            true => Cone { width: width * self.unit, spread: 0.0 },
            false => Cone { width: 0.0, spread: width },
        }
    }

    /// The distance from the point at which the cone has widened by half an octave more than `step` of them.
    pub fn end(&self, step: i32) -> f64 {
        if step == MOST_STEPS {
            return f64::INFINITY;
        }
        let more = (SQRT_2 * f64::from(self.octave + step).exp2() - self.width).max(f64::MIN_POSITIVE);
        match self.distance == f64::INFINITY {
            // width + spread · d
            true => more / self.spread,
            // As seen from the lamp: width + spread · d · distance / (distance − d), as `spread` is per `unit`.
            false => self.distance * more / (self.spread * self.distance + more),
        }
    }
}

/// The nearest power of 2.
fn octave(width: f64) -> i32 {
    width.log2().round().clamp(-500.0, 500.0) as i32
}
