//! A surfel: a point of the surface inside a voxel, and where it can be seen from.
//!
//! One ellipsoid says how matter is turned, not what of it shows: from the side a tuft shows its tips, a tube only its
//! near half, and what the eye sees through a gap the light reaches through the same gap. So a voxel of geometry holds
//! a few points of its surface [Pfister00], one side each, with a mask of the directions in which nothing near blocks
//! them. What is seen of the voxel from v and lit from l is then a sum over its surfels:
//!
//! ```text
//! Σ w (n·v)⁺ M(v) · c (n·l)⁺ M(l)  /  Σ w (n·v)⁺ M(v)
//! ```
//!
//! with the masks M in the directions of texel space. An affine map keeps what blocks what, so bent boxes need no other
//! masks; only the cosine to the light is taken in the scene.

use std::sync::LazyLock;

use glam::{Vec3, Vec4};

use crate::sample::Sample;

/// A point of the surface, seen from one side. 14 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surfel {
    /// A bit a cell, row after row, little endian.
    open: [u8; 8],
    sample: Sample,
}

impl Surfel {
    /// How far the masks of voxels of edge `edge` look, in texel units like it: what is nearer does not count again as
    /// a shadow. Two voxels, and a little further, because strands that stand next to each other hide alike however
    /// finely they are cut.
    pub fn reach(edge: f32) -> f32 {
        2.0 * edge + 0.04
    }

    /// One that is not there: it is seen from nowhere.
    pub const NOWHERE: Self = Self { open: [0; 8], sample: Sample::NONE };

    /// Cells of the mask along each axis of the disk.
    pub(crate) const SIDE: usize = 8;

    /// A surfel of unit `normal` and linear `color`, which stands for the part `weight` (0 to 1) of the largest of its
    /// voxel.
    pub(crate) fn new(normal: Vec3, color: Vec3, weight: f32, open: u64) -> Self {
        Self::of_parts(Sample::new(normal, color, weight), open)
    }

    /// From its two parts.
    #[inline]
    pub(crate) fn of_parts(sample: Sample, open: u64) -> Self {
        Self { open: open.to_le_bytes(), sample }
    }

    /// Normal, colour and weight.
    pub(crate) fn sample(&self) -> Sample {
        self.sample
    }

    #[inline]
    pub(crate) fn mask(&self) -> u64 {
        u64::from_le_bytes(self.open)
    }

    /// The mask by squares of 2 × 2 cells, if those of each are alike.
    pub(crate) fn coarse_mask(&self) -> Option<u16> {
        // Each square's lowest cell says it for all four.
        let lowest = self.mask() & 0x0055_0055_0055_0055;
        let alike = lowest | lowest << 1;
        let alike = alike | alike << 8;
        let square = |i: u32| (lowest >> (16 * (i / 4) + 2 * (i % 4)) & 1) as u16;
        (alike == self.mask()).then(|| (0..16).fold(0, |mask, i| mask | square(i) << i))
    }

    /// Mask and sample.
    pub(crate) fn to_bytes(self) -> [u8; 14] {
        let sample = self.sample.to_bytes();
        std::array::from_fn(|i| if i < 8 { self.open[i] } else { sample[i - 8] })
    }

    /// What [`to_bytes`](Self::to_bytes) made bytes of.
    pub(crate) fn from_bytes(bytes: [u8; 14]) -> Self {
        Self {
            open: std::array::from_fn(|i| bytes[i]),
            sample: Sample::from_bytes(std::array::from_fn(|i| bytes[8 + i])),
        }
    }

    /// Unit normal, on the side that is seen; texel space.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.sample.normal()
    }

    /// Linear albedo.
    #[inline]
    pub fn color(&self) -> Vec3 {
        self.sample.color()
    }

    /// The surface that it stands for, as a part of that of the voxel's largest.
    #[inline]
    pub fn weight(&self) -> f32 {
        self.sample.weight()
    }

    /// What nothing near blocks of its cosine-weighted hemisphere, above and below the surface that the texel stands on:
    /// the part of the hemisphere, and the sum of its directions (texel space), weighted alike.
    pub fn sky(&self) -> [(f32, Vec3); 2] {
        let (normal, open) = (self.normal(), self.mask());
        let [x, y] = axes(normal);
        let below = cells_below(Vec3::new(x.z, y.z, normal.z));
        let half = |cells: u64| {
            let [a, b, along, open] = (moments(cells) / WHOLE).to_array();
            (open, a * x + b * y + along * normal)
        };
        [half(open & !below), half(open & below)]
    }

    /// Whether nothing near blocks it towards the unit vector `d` of texel space; `false` for those behind it.
    #[inline]
    pub fn sees(&self, d: Vec3) -> bool {
        let normal = self.normal();
        // A cell holds what is between whole numbers: the part after the point is dropped.
        normal.dot(d) > 0.0 && self.is_open(on_disk(normal, d))
    }

    /// How far it is open towards the light, 0 to 1, where the eye sees it (unit vectors to both, texel space).
    ///
    /// Counted from the cell in which the eye is, so that nothing stands between the light and what is seen where both
    /// directions are one, and the more they part the less they have to do with each other.
    #[inline]
    pub fn lit(&self, eye: Vec3, light: Vec3) -> f32 {
        let normal = self.normal();
        if normal.dot(light) <= 0.0 {
            return 0.0;
        }
        let (eye, light) = (on_disk(normal, eye), on_disk(normal, light));
        let [x, y] = [eye[0].floor() + light[0] - eye[0], eye[1].floor() + light[1] - eye[1]];
        let ([i, j], [a, b]) = ([x.floor(), y.floor()], [x - x.floor(), y - y.floor()]);
        let open = |x: f32, y: f32| f32::from(u8::from(self.is_open([x, y])));
        let row = |y: f32| open(i, y) + a * (open(i + 1.0, y) - open(i, y));
        row(j) + b * (row(j + 1.0) - row(j))
    }

    /// The bit of the cell at a column and row; of the nearest, outside.
    #[inline]
    fn is_open(&self, at: [f32; 2]) -> bool {
        let cell = |c: f32| (c.max(0.0) as u32).min(Self::SIDE as u32 - 1);
        let (column, row) = (cell(at[0]), cell(at[1]));
        self.mask() >> (Self::SIDE as u32 * row + column) & 1 != 0
    }
}

/// Cells inside the disk.
const WHOLE: f32 = 52.0;

/// The directions through the middles of every four cells that follow each other: along the axes of the disk and along
/// the normal; zero outside the disk.
static CELLS: LazyLock<[[Vec4; 3]; 16]> = LazyLock::new(|| {
    let direction = |cell: usize| {
        let (a, b) = (middle(cell % Surfel::SIDE), middle(cell / Surfel::SIDE));
        let rest = 1.0 - a * a - b * b;
        if rest < 0.0 { Vec3::ZERO } else { Vec3::new(a, b, rest.sqrt()) }
    };
    std::array::from_fn(|four| {
        std::array::from_fn(|axis| Vec4::from_array(std::array::from_fn(|i| direction(4 * four + i)[axis])))
    })
});

/// Of every four cells, and by which of them are taken: the sum of their directions, and how many lie in the disk.
static MOMENTS: LazyLock<[[Vec4; 16]; 16]> = LazyLock::new(|| {
    let of = |four: usize, i: usize| {
        let [a, b, along] = CELLS[four].map(|axis| axis[i]);
        Vec4::new(a, b, along, if along > 0.0 { 1.0 } else { 0.0 })
    };
    let sum = |four: usize, taken: usize| (0..4).filter(|i| taken >> i & 1 != 0).map(|i| of(four, i)).sum();
    std::array::from_fn(|four| std::array::from_fn(|taken| sum(four, taken)))
});

/// The sum of the directions of some cells, and how many of them lie in the disk.
fn moments(cells: u64) -> Vec4 {
    let mut sum = Vec4::ZERO;
    for (four, sums) in MOMENTS.iter().enumerate() {
        sum += sums[(cells >> (4 * four)) as usize & 15];
    }
    sum
}

/// The cells whose directions go down, where `up` has these components along the axes of the disk and the normal.
fn cells_below(up: Vec3) -> u64 {
    let mut below = 0;
    for (four, [a, b, along]) in CELLS.iter().enumerate() {
        let height = *a * up.x + *b * up.y + *along * up.z;
        below |= u64::from(height.cmplt(Vec4::ZERO).bitmask()) << (4 * four);
    }
    below
}

/// The middle of a row or column of the mask, from −1 to 1.
const fn middle(i: usize) -> f32 {
    (i as f32 + 0.5) * (2.0 / Surfel::SIDE as f32) - 1.0
}

/// Where a direction on the side of `normal` lies on the mask: the disk under the hemisphere in 8 × 8 squares, so that
/// each holds as much cosine-weighted light as any other.
#[inline]
pub(crate) fn on_disk(normal: Vec3, d: Vec3) -> [f32; 2] {
    place(&axes(normal), d)
}

/// The same, by the axes of the disk.
#[inline]
fn place(axes: &[Vec3; 2], d: Vec3) -> [f32; 2] {
    axes.map(|axis| (0.5 * axis.dot(d) + 0.5) * Surfel::SIDE as f32)
}

/// The axes of the disk.
#[inline]
fn axes(normal: Vec3) -> [Vec3; 2] {
    let (x, y) = normal.any_orthonormal_pair();
    [x, y]
}

/// The direction at a point of the square around the disk, `[−1, 1]²`, drawn in to where the hemisphere is.
pub(crate) fn direction(normal: Vec3, [x, y]: [f32; 2]) -> Vec3 {
    // Along the horizon itself the surface would block what it sees.
    const WIDEST: f32 = 0.995;
    let scale = (WIDEST / x.hypot(y)).min(1.0);
    let [x, y] = [scale * x, scale * y];
    let [a, b] = axes(normal);
    x * a + y * b + (1.0 - x * x - y * y).sqrt() * normal
}

/// The surfels of a level's voxels, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surfels {
    /// Where each voxel's begin, and the end; empty where no voxel has any.
    first: Vec<u32>,
    all: Vec<Surfel>,
}

impl Surfels {
    pub(crate) fn new(each: Vec<Vec<Surfel>>) -> Self {
        let mut first = Vec::with_capacity(each.len() + 1);
        let mut count = 0;
        first.push(count);
        for surfels in &each {
            count += surfels.len() as u32;
            first.push(count);
        }
        Self::of_parts(first, each.concat())
    }

    /// Where no voxel has any, it takes no room.
    fn of_parts(first: Vec<u32>, all: Vec<Surfel>) -> Self {
        if all.is_empty() { Self::default() } else { Self { first, all } }
    }

    /// From the number that each voxel has, and all of them; `None` if these are not as many together.
    pub(crate) fn from_counts(counts: &[u16], all: Vec<Surfel>) -> Option<Self> {
        let mut first = Vec::with_capacity(counts.len() + 1);
        let mut sum = 0_u32;
        first.push(sum);
        for &count in counts {
            sum = sum.checked_add(count.into())?;
            first.push(sum);
        }
        (sum as usize == all.len()).then(|| Self::of_parts(first, all))
    }

    /// All of them, in the order of their voxels.
    pub(crate) fn all(&self) -> &[Surfel] {
        &self.all
    }

    #[inline]
    pub(crate) fn of(&self, voxel: u32) -> &[Surfel] {
        let voxel = voxel as usize;
        match self.first.get(voxel..voxel + 2) {
            Some(&[start, end]) => self.all.get(start as usize..end as usize).unwrap_or(&[]),
            _ => &[],
        }
    }

    pub(crate) fn memory(&self) -> usize {
        size_of_val(self.first.as_slice()) + size_of_val(self.all.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::sample::snapped_normal;

    #[test]
    fn fourteen_bytes() {
        assert_eq!(size_of::<Surfel>(), 14);
    }

    /// [`Surfel::sky`], cell by cell.
    fn sky(surfel: Surfel) -> [(f32, Vec3); 2] {
        let [x, y] = axes(surfel.normal());
        let mut halves = [(0.0, Vec3::ZERO); 2];
        for cell in (0..64).filter(|cell| surfel.mask() >> cell & 1 != 0) {
            let (a, b) = (middle(cell % Surfel::SIDE), middle(cell / Surfel::SIDE));
            if a.hypot(b) < 1.0 {
                let d = a * x + b * y + (1.0 - a * a - b * b).sqrt() * surfel.normal();
                let (open, sum) = &mut halves[usize::from(d.z < 0.0)];
                (*open, *sum) = (*open + 1.0 / WHOLE, *sum + d / WHOLE);
            }
        }
        halves
    }

    #[test]
    fn the_open_sky_of_a_wall_is_half() {
        // An open floor sees all of its hemisphere, whose cosine-weighted mean direction is ⅔ of its normal; a wall the
        // upper half: ½, and of its directions' heights the mean over the half is ∫ cos²θ sin θ … = 4/(3π) · ½ = .212.
        let [(open, sum), (below, _)] = Surfel::new(Vec3::Z, Vec3::ONE, 1.0, u64::MAX).sky();
        assert!(
            (open - 1.0).abs() < 1e-6 && (sum - Vec3::Z * 2.0 / 3.0).length() < 0.02 && below == 0.0,
            "{open} {sum}"
        );
        // Counted by fours as cell by cell.
        let surfel =
            Surfel::new(Vec3::new(0.6, -0.3, 0.5).normalize(), Vec3::ONE, 1.0, 0x3c7e_f0ff_81c3_6699);
        for ((a, v), (b, w)) in surfel.sky().into_iter().zip(sky(surfel)) {
            assert!((a - b).abs() < 1e-6 && (v - w).length() < 1e-6);
        }
        let halves = Surfel::new(Vec3::X, Vec3::ONE, 1.0, u64::MAX).sky();
        for ((open, sum), side) in halves.into_iter().zip([1.0, -1.0]) {
            assert!((open - 0.5).abs() < 0.02 && (side * sum.z - 0.212).abs() < 0.02, "{open} {sum}");
        }
        assert_eq!(Surfel::new(Vec3::X, Vec3::ONE, 1.0, 0).sky()[0].0, 0.0);
    }

    #[test]
    fn a_cell_holds_the_directions_of_its_square() {
        let random = &mut Random::new(1, 0);
        for _ in 0..20_000 {
            let n = random.direction();
            let n = snapped_normal(n);
            let (x, y) = (random.signed(), random.signed());
            let d = direction(n, [x, y]);
            assert!((d.length() - 1.0).abs() < 1e-5 && d.dot(n) > 0.0);
            let at = |v: f32| ((0.5 * v + 0.5) * 8.0) as usize;
            if x.hypot(y) < 0.99
                && ((4.0 * x).fract().abs() - 0.5).abs() < 0.49
                && ((4.0 * y).fract().abs() - 0.5).abs() < 0.49
            {
                let [column, row] = [at(x), at(y)];
                let surfel = Surfel::new(n, Vec3::ONE, 1.0, 1 << (8 * row + column));
                assert!(surfel.sees(d) && !surfel.sees(-d));
                assert!(!Surfel::new(n, Vec3::ONE, 1.0, !(1 << (8 * row + column))).sees(d));
            }
        }
    }
}
