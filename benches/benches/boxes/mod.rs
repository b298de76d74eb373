//! Seeded boxes and rays to measure on: mild (corners jittered by a tenth) and strong (top twisted and sheared).
#![allow(dead_code, reason = "each bench is its own crate and uses a part of this")]

use pelage::geom::glam::{DVec3, Quat, Vec3};
use pelage::geom::{Ray, Trilinear};

/// How many of everything a bench cycles through: enough that branches are not learnt by heart.
pub const COUNT: usize = 1024;

/// Makes one box.
pub type Make = fn(&mut Random) -> Trilinear;

/// The two kinds of boxes.
pub const KINDS: [(&str, Make); 2] = [("mild", Random::mild), ("strong", Random::strong)];

/// SplitMix64. [Steele14]
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * (0.5 * f64::EPSILON)
    }

    pub fn inside(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    pub fn direction(&mut self) -> DVec3 {
        (self.inside() - 0.5).normalize_or(DVec3::X)
    }

    pub fn mild(&mut self) -> Trilinear {
        let mut map = Trilinear::identity();
        for c in &mut map.corners {
            *c += (0.2 * (self.inside() - 0.5)).as_vec3();
        }
        map
    }

    pub fn strong(&mut self) -> Trilinear {
        let mut map = self.mild();
        let turn = Quat::from_rotation_z((2.0 * self.unit() - 1.0) as f32);
        let shear = Vec3::new(0.7, 0.0, 0.0);
        let centre = Vec3::new(0.5, 0.5, 0.0);
        for c in &mut map.corners[4..] {
            *c = turn * (*c - centre) + centre + shear;
        }
        map
    }

    /// A ray through the scene point `target`, from a few units before it.
    pub fn ray_through(&mut self, target: DVec3) -> Ray {
        let direction = self.direction();
        Ray { origin: target - 4.0 * direction, direction }
    }
}
