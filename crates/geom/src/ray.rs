//! A half-line through the scene.

use glam::DVec3;

/// A ray: where it starts and where it goes. Positions are scene units, in `f64`, so that a far origin costs
/// nothing of a near hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` = 0.
    pub origin: DVec3,
    /// Unit length, so that `t` is a distance.
    pub direction: DVec3,
}

impl Ray {
    /// A ray from `origin` along `direction`, which is normalised.
    ///
    /// Returns `None` if `direction` is zero or a number is not finite.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let direction = direction.try_normalize()?;
        (origin.is_finite() && direction.is_finite()).then_some(Self { origin, direction })
    }

    /// The point at distance `t`, in scene units.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn t_is_a_distance() {
        let ray = Ray::new(DVec3::ONE, DVec3::new(0.0, 3.0, 4.0)).expect("a usable direction");
        // The 3-4-5 triangle.
        assert!(ray.at(5.0).distance(DVec3::new(1.0, 4.0, 5.0)) < 1e-15);
    }

    #[test]
    fn refuses_what_has_no_direction() {
        assert!(Ray::new(DVec3::ZERO, DVec3::ZERO).is_none());
        assert!(Ray::new(DVec3::ZERO, DVec3::NAN).is_none());
        assert!(Ray::new(DVec3::INFINITY, DVec3::X).is_none());
    }
}
