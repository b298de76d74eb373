//! The paper's own numerical rules, kept as plain references for the faster and safer ones. [seed §5.1]
//!
//! They are what the paper prints, with one addition: a bound on the iterations, since both can go on for ever.

use glam::DVec3;

use crate::{DTrilinear, Ray};

/// `InvT`: the box coordinates of the scene point `x`, by plain Newton iteration from the centre until
/// ‖X − T(U)‖ < `eps` scene units. [seed §5.1]
///
/// Returns `None` after `iterations` steps, or where the Jacobian is singular.
pub fn inv_t(map: &DTrilinear, x: DVec3, eps: f64, iterations: usize) -> Option<DVec3> {
    let mut u = DVec3::splat(0.5);
    for _ in 0..iterations {
        let missing = x - map.point(u);
        if missing.length() < eps {
            return Some(u);
        }
        u += map.jacobian(u).inverse() * missing;
        if !u.is_finite() {
            return None;
        }
    }
    None
}

/// `Atteint_Tranche`: where the ray meets the wall u_`axis` = `c`, as its distance and box coordinates, by Newton
/// iteration along the ray from the distance `start`, each step calling [`inv_t`]. [seed §5.1]
///
/// `eps` is scene units for the inversion and box units for the wall. Where the ray runs along the wall the paper
/// takes a step of one unit. Returns `None` after `iterations` steps, or where an inversion fails; `axis` is 0, 1
/// or 2.
pub fn reach_wall(
    map: &DTrilinear,
    axis: usize,
    c: f64,
    ray: &Ray,
    start: f64,
    eps: f64,
    iterations: usize,
) -> Option<(f64, DVec3)> {
    let along = |u: DVec3| [u.x, u.y, u.z].get(axis).copied();
    let mut t = start;
    for _ in 0..iterations {
        let u = inv_t(map, ray.at(t), eps, iterations)?;
        let missing = c - along(u)?;
        if missing.abs() < eps {
            return Some((t, u));
        }
        let speed = along(map.jacobian(u).inverse() * ray.direction)?;
        t += if speed != 0.0 { missing / speed } else { 1.0 };
        if !t.is_finite() {
            return None;
        }
    }
    None
}
