//! Four surfels side by side, each lane as [`Surfel`] has it alone.

use glam::Vec3;
use pelage_geom::Vec3x4;
use wide::{f32x4, i32x4};

use crate::packed::folded_x4;
use crate::sample::{STEPS, Sample};
use crate::surfel::Surfel;

/// Four samples side by side.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    /// Unit normals.
    pub normal: Vec3x4,
    /// Linear albedos.
    pub color: Vec3x4,
    /// What each stands for, as a part of the largest beside it.
    pub weight: f32x4,
}

impl Samples {
    #[inline]
    pub(crate) fn new(four: [Sample; 4]) -> Self {
        let [a, b, c, d] = four;
        let octahedral = |axis: usize| {
            let of = |sample: Sample| sample.octahedral()[axis];
            let [a, b, c, d] = [of(a), of(b), of(c), of(d)];
            f32x4::new([a.into(), b.into(), c.into(), d.into()]) * f32x4::splat(1.0 / STEPS)
        };
        let bytes = |a: u8, b: u8, c: u8, d: u8| {
            f32x4::new([a.into(), b.into(), c.into(), d.into()]) * f32x4::splat(1.0 / 255.0)
        };
        let color = |channel: usize| {
            let of = |sample: Sample| sample.root_color()[channel];
            let root = bytes(of(a), of(b), of(c), of(d));
            root * root
        };
        Self {
            normal: folded_x4([octahedral(0), octahedral(1)]),
            color: Vec3x4 { x: color(0), y: color(1), z: color(2) },
            weight: bytes(a.weight_byte(), b.weight_byte(), c.weight_byte(), d.weight_byte()),
        }
    }
}

/// Four surfels side by side.
#[derive(Clone, Copy, Debug)]
pub struct SurfelsX4 {
    /// What each faces, its colour and its weight.
    pub samples: Samples,
    open: [u64; 4],
    axes: [Vec3x4; 2],
}

impl SurfelsX4 {
    /// At most four; what is missing is not seen from anywhere.
    #[inline]
    pub fn new(surfels: &[Surfel]) -> Self {
        let surfel = |i: usize| surfels.get(i).copied().unwrap_or(Surfel::NOWHERE);
        let [a, b, c, d] = [surfel(0), surfel(1), surfel(2), surfel(3)];
        let samples = Samples::new([a.sample(), b.sample(), c.sample(), d.sample()]);
        let open = [a.mask(), b.mask(), c.mask(), d.mask()];
        Self { open, samples, axes: samples.normal.any_orthonormal_pair() }
    }

    /// [`Surfel::sees`] of each: bit i is that of the i-th.
    #[inline]
    pub fn sees(&self, d: Vec3) -> u32 {
        let d = Vec3x4::splat(d);
        let facing = self.samples.normal.dot(d).simd_gt(f32x4::ZERO).to_bitmask();
        if facing == 0 {
            return 0;
        }
        let [x, y] = on_disk_x4(&self.axes, d);
        let (x, y) = (cells(x.trunc_int()), cells(y.trunc_int()));
        let open = |i: usize| (self.open[i] >> (Surfel::SIDE as i32 * y[i] + x[i]) & 1) as u32;
        facing & (open(0) | open(1) << 1 | open(2) << 2 | open(3) << 3)
    }

    /// [`Surfel::lit`] of each.
    #[inline]
    pub fn lit(&self, eye: Vec3, light: Vec3) -> f32x4 {
        let (eye, light) = (Vec3x4::splat(eye), Vec3x4::splat(light));
        let facing = self.samples.normal.dot(light).simd_gt(f32x4::ZERO);
        let (eye, light) = (on_disk_x4(&self.axes, eye), on_disk_x4(&self.axes, light));
        let place = |axis: usize| f32x4::from_i32x4(eye[axis].trunc_int()) + light[axis] - eye[axis];
        let corners = Corners::new([place(0), place(1)]);
        let open = |i: usize, cell: usize| (self.open[i] >> cell & 1) as f32;
        facing & corners.between(open)
    }
}

/// The four cells of each mask that a place (not below −8) lies between, and how far it is on from the first.
struct Corners {
    columns: [[i32; 4]; 2],
    rows: [[i32; 4]; 2],
    part: [f32x4; 2],
}

impl Corners {
    #[inline]
    fn new(place: [f32x4; 2]) -> Self {
        // A number that is not negative is cut off downwards.
        let side = Surfel::SIDE as i32;
        let below = |c: f32x4| (c + f32x4::splat(side as f32)).trunc_int() - i32x4::splat(side);
        let [x, y] = [below(place[0]), below(place[1])];
        let next = |cell: i32x4| cells(cell + i32x4::ONE);
        let part = [place[0] - f32x4::from_i32x4(x), place[1] - f32x4::from_i32x4(y)];
        Self { columns: [cells(x), next(x)], rows: [cells(y), next(y)], part }
    }

    /// The mean of what is `open` of each mask in its four cells (row · 8 + column), weighed by their nearness.
    #[inline]
    fn between(&self, open: impl Fn(usize, usize) -> f32) -> f32x4 {
        let corner = |row: usize, column: usize| {
            let [rows, columns] = [&self.rows[row], &self.columns[column]];
            let at = |i: usize| open(i, Surfel::SIDE * rows[i] as usize + columns[i] as usize);
            f32x4::new([at(0), at(1), at(2), at(3)])
        };
        let [a, b] = self.part;
        let row = |row: usize| {
            let (first, second) = (corner(row, 0), corner(row, 1));
            first + a * (second - first)
        };
        let (first, second) = (row(0), row(1));
        first + b * (second - first)
    }
}

/// Rows or columns of a mask; of those outside, the nearest.
#[inline]
fn cells(c: i32x4) -> [i32; 4] {
    c.max(i32x4::ZERO).min(i32x4::splat(Surfel::SIDE as i32 - 1)).to_array()
}

/// [`on_disk`] of each.
#[inline]
fn on_disk_x4(axes: &[Vec3x4; 2], d: Vec3x4) -> [f32x4; 2] {
    let half = f32x4::splat(0.5);
    let place = |axis: &Vec3x4| (half * axis.dot(d) + half) * f32x4::splat(Surfel::SIDE as f32);
    [place(&axes[0]), place(&axes[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn four_samples_are_one_and_one() {
        let random = &mut Random::new(5, 0);
        for _ in 0..2000 {
            let four = std::array::from_fn(|_| {
                let n = random.direction();
                let color = Vec3::new(random.unit(), random.unit(), random.unit());
                Sample::new(n, color, random.unit())
            });
            let samples = Samples::new(four);
            assert!(samples.normal == Vec3x4::new(four.map(Sample::normal)));
            assert!(samples.color == Vec3x4::new(four.map(Sample::color)));
            assert_eq!(samples.weight.to_array(), four.map(Sample::weight));
        }
    }

    #[test]
    fn four_surfels_are_one_and_one() {
        let random = &mut Random::new(6, 0);
        for _ in 0..2000 {
            let four: [Surfel; 4] = std::array::from_fn(|_| {
                let halves: [u64; 2] = std::array::from_fn(|_| (random.unit() * 4e9) as u64);
                Surfel::new(random.direction(), Vec3::splat(0.5), 1.0, halves[0] << 32 | halves[1])
            });
            let (eye, light) = (random.direction(), random.direction());
            let surfels = SurfelsX4::new(&four);
            let seen: u32 = four.iter().enumerate().map(|(i, s)| u32::from(s.sees(eye)) << i).sum();
            assert_eq!(surfels.sees(eye), seen);
            for (a, b) in surfels.lit(eye, light).to_array().into_iter().zip(four) {
                assert!((a - b.lit(eye, light)).abs() < 1e-6);
            }
            assert_eq!(SurfelsX4::new(&four[..2]).sees(eye), seen & 3);
        }
    }
}
