//! Spheres on a lattice: curved content whose coverage is known from every side.

use core::f32::consts::{PI, TAU};

use glam::{UVec3, Vec2, Vec3};

use super::domain::{Domain, UNIT, at_most_triangles};
use crate::{BuildError, Geometry, Procedure};

/// `side`³ equal spheres, each in the middle of its cell of the texel.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Spheres {
    /// Spheres along each edge of the texel, 1 to 64.
    pub side: u32,
    /// Radius over half the distance between neighbours, 0 to 1: 1 for spheres that touch.
    pub fill: f32,
    /// Linear albedo.
    pub color: Vec3,
    /// Specular albedo, 0 to 1.
    pub specular: f32,
    /// Roughness of the highlight, 0 to 1.
    pub roughness: f32,
    /// Rings of triangles from pole to pole, 2 to 256; twice as many around.
    pub rings: u32,
}

impl Spheres {
    /// Eight, with gaps.
    pub fn lattice() -> Self {
        Self { side: 2, fill: 0.8, color: Vec3::new(0.6, 0.5, 0.3), specular: 0.0, roughness: 1.0, rings: 16 }
    }

    fn sphere(&self, centre: Vec3, radius: f32, geometry: &mut Geometry) {
        let around = self.rings.saturating_mul(2);
        let point = |i: u32, j: u32| {
            let (ring, height) = (PI * j as f32 / self.rings as f32).sin_cos();
            // The last meridian is the first, to the bit.
            let azimuth = TAU * (i % around) as f32 / around as f32;
            centre + radius * (Vec2::from_angle(azimuth) * ring).extend(-height)
        };
        for j in 0..self.rings {
            for i in 0..around {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| point(i, j));
                if j > 0 {
                    geometry.push([a, b, c], self.color);
                }
                if j + 1 < self.rings {
                    geometry.push([a, c, d], self.color);
                }
            }
        }
    }
}

impl Default for Spheres {
    fn default() -> Self {
        Self::lattice()
    }
}

impl Procedure for Spheres {
    fn name(&self) -> &'static str {
        "spheres"
    }

    fn validate(&self) -> Result<(), BuildError> {
        Domain::new(1.0, 64.0, "1 to 64").check("side", self.side)?;
        UNIT.check("fill", self.fill)?;
        UNIT.check_each("color", self.color.as_ref())?;
        UNIT.check("specular", self.specular)?;
        UNIT.check("roughness", self.roughness)?;
        Domain::new(2.0, 256.0, "2 to 256").check("rings", self.rings)?;
        at_most_triangles(self.side.pow(3), 4 * self.rings * (self.rings - 1))
    }

    fn geometry(&self) -> Geometry {
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let n = self.side;
        for i in 0..n.saturating_pow(3) {
            let cell = UVec3::new(i % n, i / n % n, i / n / n);
            let centre = (cell.as_vec3() + 0.5) / n as f32;
            self.sphere(centre, 0.5 * self.fill / n as f32, &mut geometry);
        }
        geometry
    }
}
