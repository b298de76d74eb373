//! Seeded random boxes and rays for the suites beside it.
#![allow(dead_code, reason = "each suite is its own crate and uses a part of this")]

use pelage_geom::glam::{DVec3, Quat, Vec3};
use pelage_geom::{Ray, Trilinear};

/// SplitMix64. [Steele14]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In `[0,1)`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (0.5 * f64::EPSILON)
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In the cube `[-half, half]³`.
    pub fn cube(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }

    /// In the unit cube.
    pub fn inside(&mut self) -> DVec3 {
        DVec3::splat(0.5) + self.cube(0.5)
    }

    /// Evenly on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.between(-1.0, 1.0), self.between(0.0, core::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// A ray through the point `target`, starting up to `distance` before it.
    pub fn ray_through(&mut self, target: DVec3, distance: f64) -> Ray {
        let direction = self.direction();
        Ray { origin: target - direction * self.between(0.0, distance), direction }
    }

    /// A unit cube whose corners are each moved by up to `jitter` along each axis.
    pub fn jittered(&mut self, jitter: f64) -> Trilinear {
        let mut map = Trilinear::identity();
        for c in &mut map.corners {
            *c += self.cube(jitter).as_vec3();
        }
        map
    }

    /// A box whose top is twisted by up to 60° and sheared by up to 0.7, then jittered by a tenth.
    pub fn strong(&mut self) -> Trilinear {
        let mut map = self.jittered(0.1);
        let angle = self.between(-1.05, 1.05) as f32;
        let shear = Vec3::new(self.between(-0.7, 0.7) as f32, self.between(-0.7, 0.7) as f32, 0.0);
        let centre = Vec3::new(0.5, 0.5, 0.0);
        for c in &mut map.corners[4..] {
            *c = Quat::from_rotation_z(angle) * (*c - centre) + centre + shear;
        }
        map
    }

    /// Undeformed to strong, in turn.
    pub fn any_box(&mut self) -> Trilinear {
        match self.below(4) {
            0 => self.jittered(0.1),
            1 => self.jittered(0.2),
            2 => self.jittered(0.35),
            _ => self.strong(),
        }
    }
}
