//! A sample of what reflects light: which way it faces, its colour, and for how much it stands. In six bytes, which
//! surfels and scatterers share.

use glam::{Vec2, Vec3};

use crate::packed::{bytes, folded, unfolded, unit};

/// Steps of an octahedral coordinate from 0 to 1, of about half a degree each.
pub(crate) const STEPS: f32 = 127.0;

/// A normal, a colour and a weight.
///
/// ```text
/// byte 0  normal  2 × i8  octahedral, 1/127
///      2  colour  3 × u8  square roots, 1/255
///      5  weight  u8      1/255 of the largest beside it
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sample {
    normal: [i8; 2],
    color: [u8; 3],
    weight: u8,
}

impl Sample {
    /// Of unit `normal` and linear `color`, which stands for the part `weight` (0 to 1) of the largest beside it.
    pub(crate) fn new(normal: Vec3, color: Vec3, weight: f32) -> Self {
        Self {
            normal: octahedral(normal),
            color: bytes(color.map(f32::sqrt)),
            // Nothing that is there weighs nothing.
            weight: (255.0 * weight).round().max(1.0) as u8,
        }
    }

    /// One that stands for nothing.
    pub(crate) const NONE: Self = Self { normal: [0; 2], color: [0; 3], weight: 0 };

    /// From what the methods below give.
    pub(crate) fn of_parts(normal: [i8; 2], color: [u8; 3], weight: u8) -> Self {
        Self { normal, color, weight }
    }

    /// The normal's point on the octahedron.
    pub(crate) fn octahedral(self) -> [i8; 2] {
        self.normal
    }

    /// Square roots of the albedo, 1/255.
    pub(crate) fn root_color(self) -> [u8; 3] {
        self.color
    }

    /// The weight in 1/255.
    #[inline]
    pub(crate) fn weight_byte(self) -> u8 {
        self.weight
    }

    /// Unit normal.
    #[inline]
    pub(crate) fn normal(self) -> Vec3 {
        normal(self.normal)
    }

    /// Linear albedo.
    #[inline]
    pub(crate) fn color(self) -> Vec3 {
        let root = unit(self.color);
        root * root
    }

    /// What it stands for, as a part of the largest beside it.
    #[inline]
    pub(crate) fn weight(self) -> f32 {
        f32::from(self.weight) * (1.0 / 255.0)
    }

    /// The bytes as they are drawn above.
    pub(crate) fn to_bytes(self) -> [u8; 6] {
        let ([x, y], [r, g, b]) = (self.normal.map(i8::cast_unsigned), self.color);
        [x, y, r, g, b, self.weight]
    }

    /// What [`to_bytes`](Self::to_bytes) made bytes of.
    pub(crate) fn from_bytes([x, y, r, g, b, weight]: [u8; 6]) -> Self {
        Self { normal: [x, y].map(u8::cast_signed), color: [r, g, b], weight }
    }
}

/// The unit vector's point on the octahedron, unfolded into a square [Cigolle14].
pub(crate) fn octahedral(n: Vec3) -> [i8; 2] {
    unfolded(n).to_array().map(|c| (STEPS * c).round() as i8)
}

/// The unit vector of a point.
#[inline]
pub(crate) fn normal(square: [i8; 2]) -> Vec3 {
    let [x, y] = square;
    folded(Vec2::new(x.into(), y.into()) * (1.0 / STEPS))
}

/// The nearest direction that a sample can have.
pub(crate) fn snapped_normal(n: Vec3) -> Vec3 {
    normal(octahedral(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn six_bytes_return() {
        assert_eq!(size_of::<Sample>(), 6);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            assert_eq!(snapped_normal(axis), axis);
        }
        let random = &mut Random::new(9, 0);
        for _ in 0..20_000 {
            let n = random.direction();
            let color = Vec3::new(random.unit(), random.unit(), random.unit());
            let sample = Sample::new(n, color, random.unit());
            // Half a step of two coordinates and one of the third, at least 1/√3 away.
            assert!((sample.normal() - n).length() < 1.5_f32.sqrt() * 3.0_f32.sqrt() / STEPS);
            assert_eq!(snapped_normal(sample.normal()), sample.normal());
            // Half a step of a square root: at most 1/255 of the whole.
            assert!((sample.color() - color).abs().max_element() < 1.0 / 250.0);
            assert_eq!(Sample::from_bytes(sample.to_bytes()), sample);
        }
    }
}
