//! Surfaces that are given by a function of two parameters in `[0,1]`.

use core::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3};

use crate::SkinError;

/// A surface over `[0,1]²`, seen from outside where ∂/∂u × ∂/∂v points. Lengths are in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Parametric {
    /// A rectangle about the origin in the plane y = 0, facing +Y; u along +X, v along −Z.
    Plane {
        /// Its sides.
        size: [f32; 2],
    },
    /// A sphere about the origin; u around the Y axis, v from the lower pole to the upper.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A torus about the Y axis; u around it, v around the tube from its outer equator upwards.
    Torus {
        /// Radius of the tube's axis.
        major: f32,
        /// Radius of the tube, less than `major`.
        minor: f32,
    },
    /// A bicubic Bézier patch.
    Bezier {
        /// 16 control points, row by row; u along a row.
        points: Vec<Vec3>,
    },
    /// A uniform bicubic B-spline surface.
    BSpline {
        /// Control points, row by row; u along a row.
        points: Vec<Vec3>,
        /// How many are in a row: 4 or more, and 4 rows or more.
        columns: usize,
    },
    /// Heights over a rectangle as [`Parametric::Plane`] has it, smoothly between samples. \[CatmullRom74\]
    Heightfield {
        /// The rectangle's sides.
        size: [f32; 2],
        /// Heights, row by row from v = 1 downwards, as an image has them; the outermost lie on the sides.
        heights: Vec<f32>,
        /// How many are in a row: 2 or more, and 2 rows or more.
        columns: usize,
    },
}

/// Magnitudes stay below this.
const LIMIT: f32 = 1e12;

impl Parametric {
    /// Its name, as in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Bezier { .. } => "bezier",
            Self::BSpline { .. } => "bspline",
            Self::Heightfield { .. } => "heightfield",
        }
    }

    /// Checks that the surface is one.
    ///
    /// # Errors
    /// The first field that is out of its domain.
    pub fn validate(&self) -> Result<(), SkinError> {
        let length = |x: f32| x > 0.0 && x <= LIMIT;
        let sides = |size: [f32; 2]| size.into_iter().all(length);
        let finite = |points: &[Vec3]| points.iter().all(|p| p.abs().cmple(Vec3::splat(LIMIT)).all());
        const LENGTH: &str = "must be positive and at most 1e12";
        const POINTS: &str = "must be finite";
        let rows = |count: usize, columns: usize| count.checked_div(columns).filter(|n| n * columns == count);
        let checks: &[(bool, &'static str, &'static str)] = &match self {
            Self::Plane { size } => vec![(sides(*size), "size", LENGTH)],
            Self::Sphere { radius } => vec![(length(*radius), "radius", LENGTH)],
            Self::Torus { major, minor } => vec![
                (length(*major), "major", LENGTH),
                (length(*minor) && minor < major, "minor", "must be positive and less than `major`"),
            ],
            Self::Bezier { points } => vec![
                (points.len() == 16, "points", "must hold 16 control points"),
                (finite(points), "points", POINTS),
            ],
            Self::BSpline { points, columns } => vec![
                (*columns >= 4, "columns", "must be 4 or more"),
                (
                    rows(points.len(), *columns).is_some_and(|n| n >= 4),
                    "points",
                    "must fill 4 rows of `columns` points, or more",
                ),
                (finite(points), "points", POINTS),
            ],
            Self::Heightfield { size, heights, columns } => vec![
                (sides(*size), "size", LENGTH),
                (*columns >= 2, "columns", "must be 2 or more"),
                (
                    rows(heights.len(), *columns).is_some_and(|n| n >= 2),
                    "heights",
                    "must fill 2 rows of `columns` heights, or more",
                ),
                (heights.iter().all(|h| h.abs() <= LIMIT), "heights", POINTS),
            ],
        };
        match checks.iter().find(|(ok, ..)| !ok) {
            Some(&(_, field, expected)) => Err(SkinError::Surface { surface: self.name(), field, expected }),
            None => Ok(()),
        }
    }

    /// The point at parameters in `[0,1]²`, of a surface that is valid.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let (u, v) = (at.x, at.y);
        let level = |size: &[f32; 2], height: f64| {
            DVec3::new((u - 0.5) * f64::from(size[0]), height, (0.5 - v) * f64::from(size[1]))
        };
        match self {
            Self::Plane { size } => level(size, 0.0),
            Self::Sphere { radius } => {
                let ((sin, cos), (height, across)) = ((TAU * u).sin_cos(), (PI * (v - 0.5)).sin_cos());
                f64::from(*radius) * DVec3::new(across * cos, height, -across * sin)
            }
            Self::Torus { major, minor } => {
                let ((sin, cos), (height, out)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
                let (major, minor) = (f64::from(*major), f64::from(*minor));
                let radius = major + minor * out;
                DVec3::new(radius * cos, minor * height, -radius * sin)
            }
            Self::Bezier { points } => {
                let net = |i: usize, j: usize| points[4 * j + i].as_dvec3();
                combined(bernstein(u), bernstein(v), net)
            }
            Self::BSpline { points, columns } => {
                let (i, fu) = span(u, columns - 3);
                let (j, fv) = span(v, points.len() / columns - 3);
                combined(b_spline(fu), b_spline(fv), |a, b| points[(j + b) * columns + i + a].as_dvec3())
            }
            Self::Heightfield { size, heights, columns } => {
                let rows = heights.len() / columns;
                let (i, fu) = span(u, columns - 1);
                let (j, fv) = span(1.0 - v, rows - 1);
                // The first and the last sample stand for those beyond.
                let near =
                    |k: usize, offset: usize, count: usize| (k + offset).saturating_sub(1).min(count - 1);
                let height = |a: usize, b: usize| {
                    DVec3::splat(f64::from(heights[near(j, b, rows) * columns + near(i, a, *columns)]))
                };
                level(size, combined(catmull_rom(fu), catmull_rom(fv), height).x)
            }
        }
    }

    /// Whether u = 1 is u = 0, and v = 1 is v = 0.
    pub(super) fn closed(&self) -> [bool; 2] {
        match self {
            Self::Sphere { .. } => [true, false],
            Self::Torus { .. } => [true, true],
            _ => [false, false],
        }
    }

    /// Whether all of v = 0 is one point, and all of v = 1.
    pub(super) fn has_poles(&self) -> bool {
        matches!(self, Self::Sphere { .. })
    }

    /// The fewest patches along u and v that follow the surface at all.
    pub(super) fn coarsest(&self) -> [usize; 2] {
        match self {
            Self::Plane { .. } | Self::Bezier { .. } => [1, 1],
            Self::Sphere { .. } => [4, 2],
            Self::Torus { .. } => [4, 4],
            Self::BSpline { points, columns } => [columns - 3, points.len() / columns - 3],
            Self::Heightfield { heights, columns, .. } => [columns - 1, heights.len() / columns - 1],
        }
    }
}

/// Which of `count` equal spans of `[0,1]` a parameter is in, and where in it.
fn span(x: f64, count: usize) -> (usize, f64) {
    let x = x.clamp(0.0, 1.0) * count as f64;
    let i = (x as usize).min(count - 1);
    (i, x - i as f64)
}

fn combined(a: [f64; 4], b: [f64; 4], net: impl Fn(usize, usize) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (j, y) in b.into_iter().enumerate() {
        for (i, x) in a.into_iter().enumerate() {
            sum += x * y * net(i, j);
        }
    }
    sum
}

fn bernstein(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [y * y * y, 3.0 * x * y * y, 3.0 * x * x * y, x * x * x]
}

fn b_spline(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    let (x2, x3) = (x * x, x * x * x);
    [y * y * y, 3.0 * x3 - 6.0 * x2 + 4.0, 3.0 * (x + x2 - x3) + 1.0, x3].map(|w| w / 6.0)
}

fn catmull_rom(x: f64) -> [f64; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [-x + 2.0 * x2 - x3, 2.0 - 5.0 * x2 + 3.0 * x3, x + 4.0 * x2 - 3.0 * x3, x3 - x2].map(|w| 0.5 * w)
}
