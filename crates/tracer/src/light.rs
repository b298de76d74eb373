//! Lights, in the units of glTF's KHR_lights_punctual, and the light of the sky. [KHRLights]

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use pelage_geom::Vec3x4;
use wide::f32x4;

/// A light with a place or a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// The sun.
    Directional {
        /// The way the light travels; any length but zero.
        direction: Vec3,
        /// Illuminance of a surface that faces the light, in lux, by colour.
        illuminance: Vec3,
        /// Full angle under which the light is seen, in radians: widens the shadow cones.
        angle: f32,
    },
    /// A small sphere that shines in all directions.
    Point {
        /// Its centre, in scene units.
        position: Vec3,
        /// Luminous intensity in candela, by colour.
        intensity: Vec3,
        /// Radius in scene units: widens the shadow cones.
        radius: f32,
    },
    /// A point light with a cone.
    Spot {
        /// Its place, in scene units.
        position: Vec3,
        /// The axis of its cone, away from the light; any length but zero.
        direction: Vec3,
        /// Luminous intensity on the axis in candela, by colour.
        intensity: Vec3,
        /// Half angle within which the light is full, in radians.
        inner: f32,
        /// Half angle beyond which there is none, in radians; at least `inner`, at most π/2.
        outer: f32,
        /// Radius in scene units: widens the shadow cones.
        radius: f32,
    },
}

/// What arrives at a point from a light, if nothing is in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incoming {
    /// Unit vector to the light.
    pub direction: Vec3,
    /// How far the light is, in scene units; infinite for the sun.
    pub distance: f32,
    /// Illuminance of a surface that faces the light.
    pub irradiance: Vec3,
    /// By how much a cone to the light widens with each unit of length.
    pub spread: f32,
}

impl Light {
    /// Says what is wrong with the light's numbers, if anything is.
    pub fn check(&self) -> Result<(), &'static str> {
        let (numbers, direction, colour): (&[f32], Option<Vec3>, Vec3) = match self {
            Self::Directional { direction, illuminance, angle } => {
                (&[*angle], Some(*direction), *illuminance)
            }
            Self::Point { position, intensity, radius } => {
                (&[position.x, position.y, position.z, *radius], None, *intensity)
            }
            Self::Spot { position, direction, intensity, inner, outer, radius } => {
                (&[position.x, position.y, position.z, *radius, *inner, *outer], Some(*direction), *intensity)
            }
        };
        if !numbers.iter().all(|x| x.is_finite()) || !colour.is_finite() {
            return Err("it holds a number that is not finite");
        }
        if colour.min_element() < 0.0 {
            return Err("its colour is negative");
        }
        if direction.is_some_and(|d| d.try_normalize().is_none()) {
            return Err("its direction has no length");
        }
        match *self {
            Self::Directional { angle, .. } if !(0.0..PI).contains(&angle) => {
                Err("its angle must lie in [0, π)")
            }
            Self::Point { radius, .. } | Self::Spot { radius, .. } if radius < 0.0 => {
                Err("its radius is negative")
            }
            Self::Spot { inner, outer, .. }
                if !(0.0 <= inner && inner <= outer && outer <= FRAC_PI_2 + 1e-4) =>
            {
                Err("its cone must have 0 ≤ inner ≤ outer ≤ π/2")
            }
            _ => Ok(()),
        }
    }

    /// What arrives at `point`; `None` where the light does not shine.
    pub fn incoming(&self, point: Vec3) -> Option<Incoming> {
        match *self {
            Self::Directional { direction, illuminance, angle } => {
                let direction = -direction.try_normalize()?;
                Some(Incoming {
                    direction,
                    distance: f32::INFINITY,
                    irradiance: illuminance,
                    spread: 2.0 * (0.5 * angle).tan(),
                })
            }
            Self::Point { position, intensity, radius } => incoming_from(position, intensity, radius, point),
            Self::Spot { position, direction, intensity, inner, outer, radius } => {
                let incoming = incoming_from(position, intensity, radius, point)?;
                let cosine = (-incoming.direction).dot(direction.try_normalize()?);
                // The falloff that KHR_lights_punctual recommends.
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
                let falloff = ((cosine - outer.cos()) * scale).clamp(0.0, 1.0).powi(2);
                (falloff > 0.0).then(|| Incoming { irradiance: falloff * incoming.irradiance, ..incoming })
            }
        }
    }
}

fn incoming_from(position: Vec3, intensity: Vec3, radius: f32, point: Vec3) -> Option<Incoming> {
    let to = position - point;
    let distance = to.length();
    let direction = to.try_normalize()?;
    // Inside the light's own sphere the inverse square law would run away.
    let squared = (distance * distance).max(radius * radius).max(f32::MIN_POSITIVE);
    Some(Incoming {
        direction,
        distance,
        irradiance: intensity / squared,
        spread: 2.0 * radius / distance.max(radius).max(f32::MIN_POSITIVE),
    })
}

/// The light of the surroundings: a radiance that goes smoothly from the ground's below to the sky's above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Radiance from straight above.
    pub sky: Vec3,
    /// Radiance from straight below.
    pub ground: Vec3,
}

impl Environment {
    /// No light from anywhere.
    pub const BLACK: Self = Self { sky: Vec3::ZERO, ground: Vec3::ZERO };

    /// The same radiance from everywhere.
    pub fn uniform(radiance: Vec3) -> Self {
        Self { sky: radiance, ground: radiance }
    }

    /// The radiance that arrives from `direction` (unit length): linear in its height.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.ground.lerp(self.sky, 0.5 + 0.5 * direction.y)
    }

    /// The cosine-weighted mean radiance over the hemisphere around `normal`, that is irradiance / π.
    ///
    /// The mean of ω·y over that hemisphere is (2/3) n·y.
    pub fn mean_radiance(&self, normal: Vec3) -> Vec3 {
        self.ground.lerp(self.sky, 0.5 + normal.y / 3.0)
    }

    /// [`mean_radiance`](Self::mean_radiance) around each of four normals.
    #[inline]
    pub(crate) fn mean_radiance_x4(&self, normal: Vec3x4) -> Vec3x4 {
        let height = f32x4::splat(0.5) + normal.y * f32x4::splat(1.0 / 3.0);
        Vec3x4::splat(self.ground) + Vec3x4::splat(self.sky - self.ground) * height
    }

    /// Four sums of the radiance over directions that weigh `open` in all, and whose weighted sum is `direction`.
    #[inline]
    pub(crate) fn gathered(&self, open: f32x4, direction: Vec3x4) -> Vec3x4 {
        let (mean, rise) = (0.5 * (self.sky + self.ground), 0.5 * (self.sky - self.ground));
        Vec3x4::splat(mean) * open + Vec3x4::splat(rise) * direction.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_4;

    #[test]
    fn inverse_square_and_cone() {
        let spot = Light::Spot {
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            intensity: Vec3::splat(8.0),
            inner: 0.5 * FRAC_PI_4,
            outer: FRAC_PI_4,
            radius: 0.0,
        };
        // 8 cd at 2 m on the axis: 2 lux; outside the cone: nothing.
        let below = spot.incoming(Vec3::new(0.0, -2.0, 0.0)).expect("inside the cone");
        assert!((below.irradiance - Vec3::splat(2.0)).length() < 1e-6);
        assert_eq!(below.direction, Vec3::Y);
        assert!(spot.incoming(Vec3::new(3.0, -2.0, 0.0)).is_none());
    }

    #[test]
    fn mean_radiance_is_the_integral() {
        // Midpoint rule over the hemisphere around +Y: ∫ L cos dω / π with L = ½ + ½ cos θ gives ½ + ½·2/3 = 5/6.
        let sky = Environment { sky: Vec3::ONE, ground: Vec3::ZERO };
        let n = 1000;
        let sum: f32 = (0..n)
            .map(|i| {
                let cosine = ((i as f32 + 0.5) / n as f32).sqrt(); // equal steps of cos²: cosine-weighted
                sky.radiance(Vec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0)).x
            })
            .sum();
        assert!((sum / n as f32 - 5.0 / 6.0).abs() < 1e-4);
        assert!((sky.mean_radiance(Vec3::Y).x - 5.0 / 6.0).abs() < 1e-6);
        let normals = [Vec3::Y, Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.8, 0.0)];
        for (four, n) in sky.mean_radiance_x4(Vec3x4::new(normals)).x.to_array().into_iter().zip(normals) {
            assert!((four - sky.mean_radiance(n).x).abs() < 1e-6);
        }
        // Of a whole open hemisphere ⅔ of its axis is the sum of its directions: the same mean.
        let sums = Vec3x4::new(normals.map(|n| n * (2.0 / 3.0)));
        for (four, n) in sky.gathered(f32x4::ONE, sums).x.to_array().into_iter().zip(normals) {
            assert!((four - sky.mean_radiance(n).x).abs() < 1e-6);
        }
    }
}
