//! Spheres on a lattice: curved content whose coverage is known from every side.

use core::f32::consts::{PI, TAU};

use glam::{UVec3, Vec2, Vec3};

use super::parameter::{at_most_triangles, check, parameters};
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// `side`³ equal spheres, each in the middle of its cell of the texel.
    pub struct Spheres {
        /// Spheres along each edge of the texel.
        side: u32 in 1..=64 ["spheres"],
        /// Radius over half the distance between neighbours: 1 for spheres that touch.
        fill: f32 in 0..=1,
        /// Their colour.
        color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
        /// Rings of triangles from pole to pole; twice as many around.
        rings: u32 in 2..=256 ["rings"],
    }
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
        check(&self.parameters())?;
        at_most_triangles(u64::from(self.side.pow(3)) * u64::from(4 * self.rings * (self.rings - 1)))
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
