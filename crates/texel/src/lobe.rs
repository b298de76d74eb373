//! A lobe: what a coarse voxel shows of its surface to one direction, of all that faces alike, and from where that is
//! lit.
//!
//! Of a voxel that holds a whole tuft, hardly a tenth of the surface is seen from anywhere, and of that a part is lit: a
//! few hundred surfels leave some ten that matter, and a picture of noise. So the coarsest levels sort the surface by
//! direction first: for each of 72 directions to the eye, the surface that is seen from there, in groups that face
//! alike, each with the *part* of it that is open towards every square of its hemisphere.

use std::ops::Range;

use glam::{IVec2, Vec2, Vec3, vec2};
use rayon::prelude::*;

use crate::sample::{Sample, snapped_normal};
use crate::surfel::{Surfel, from_disk, on_disk};

/// The surface that faces alike, of what is seen of a voxel from one direction. 22 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobe {
    /// The part that is open through each cell of the disk, in thirds: two bits, four cells a byte, the lowest bits first.
    /// (Fewer, larger cells blur what counts: what the eye sees is open near the eye.)
    open: [u8; CELLS / 4],
    sample: Sample,
}

const CELLS: usize = Surfel::SIDE * Surfel::SIDE;

/// A point of the surface as a level sees it: what lobes (and surfels) are made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) surfel: Surfel,
    /// The surface that it stands for, in any unit.
    pub(crate) weight: f32,
}

impl Lobe {
    /// Of points and their shares of what is seen.
    fn new(points: &[(Point, f32)], largest: f32) -> Self {
        let share: f32 = points.iter().map(|p| p.1).sum();
        let mean = |of: &dyn Fn(&Surfel) -> Vec3| {
            points.iter().map(|(point, share)| *share * of(&point.surfel)).sum::<Vec3>() / share
        };
        let facing = snapped_normal(mean(&Surfel::normal).normalize_or(points[0].0.surfel.normal()));
        let mut open = [0; CELLS / 4];
        // What rounding takes from a cell the next one gets: in dense content most are open by less than half a step.
        let mut left = 0.0;
        for cell in 0..CELLS {
            let d = from_disk(facing, [cell % Surfel::SIDE, cell / Surfel::SIDE]);
            // Of the light that all of it would take up if it faced as their mean does.
            let lit = |(point, share): &(Point, f32)| match point.surfel.sees(d) {
                true => share * point.surfel.normal().dot(d),
                false => 0.0,
            };
            let part = (points.iter().map(lit).sum::<f32>() / (share * facing.dot(d))).min(1.0) + left;
            let thirds = (3.0 * part).round().clamp(0.0, 3.0);
            left = part - thirds / 3.0;
            open[cell / 4] |= (thirds as u8) << (2 * (cell % 4));
        }
        Self { open, sample: Sample::new(facing, mean(&Surfel::color), (share / largest).min(1.0)) }
    }

    /// Normal, colour and weight.
    #[inline]
    pub(crate) fn sample(&self) -> Sample {
        self.sample
    }

    /// The cells and the sample.
    pub(crate) fn to_bytes(self) -> [u8; 22] {
        let sample = self.sample.to_bytes();
        std::array::from_fn(|i| if i < 16 { self.open[i] } else { sample[i - 16] })
    }

    /// What [`to_bytes`](Self::to_bytes) made bytes of.
    pub(crate) fn from_bytes(bytes: [u8; 22]) -> Self {
        Self {
            open: std::array::from_fn(|i| bytes[i]),
            sample: Sample::from_bytes(std::array::from_fn(|i| bytes[16 + i])),
        }
    }

    /// Unit normal, texel space.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.sample.normal()
    }

    /// Linear albedo.
    #[inline]
    pub fn color(&self) -> Vec3 {
        self.sample.color()
    }

    /// How much is seen of it, as a part of the largest that is seen from the same direction.
    #[inline]
    pub fn weight(&self) -> f32 {
        self.sample.weight()
    }

    /// How alike the ways to the eye and to the light are (unit vectors to both, texel space), 0 to 1.
    ///
    /// Nothing stands between the light and what is seen where both directions are one: in a gap as wide as those
    /// between strands, a third as deep as the texel is high, they have little to do with each other from a few degrees on.
    #[inline]
    pub fn alike(eye: Vec3, light: Vec3) -> f32 {
        (-(eye - light).length() / APART).exp()
    }

    /// The part of it that nothing near hides from the light (a unit vector to it, texel space), of what the eye sees of
    /// it when their ways are [`alike`](Self::alike); 0 for light from behind.
    #[inline]
    pub fn lit(&self, alike: f32, light: Vec3) -> f32 {
        let normal = self.normal();
        if normal.dot(light) <= 0.0 {
            return 0.0;
        }
        let [x, y] = on_disk(normal, light);
        let (x, y) = (x - 0.5, y - 0.5);
        let ([i, j], [a, b]) = ([x.floor(), y.floor()], [x - x.floor(), y - y.floor()]);
        let row = |y: f32| (1.0 - a) * self.open([i, y]) + a * self.open([i + 1.0, y]);
        let open = (1.0 - b) * row(j) + b * row(j + 1.0);
        open + (1.0 - open) * alike
    }

    /// What nothing near blocks of its cosine-weighted hemisphere, as [`Surfel::sky`].
    fn sky(&self) -> [(f32, Vec3); 2] {
        crate::surfel::sky(self.normal(), |cell| self.at(cell))
    }

    #[inline]
    fn open(&self, at: [f32; 2]) -> f32 {
        let cell = |c: f32| (c.max(0.0) as usize).min(Surfel::SIDE - 1);
        self.at([cell(at[0]), cell(at[1])])
    }

    #[inline]
    fn at(&self, [column, row]: [usize; 2]) -> f32 {
        self.part(Surfel::SIDE * row + column)
    }

    /// The part that is open through a cell.
    #[inline]
    pub(crate) fn part(&self, cell: usize) -> f32 {
        f32::from(self.open[cell / 4] >> (2 * (cell % 4)) & 3) * (1.0 / 3.0)
    }
}

/// The distance between unit vectors to the eye and to the light at which hardly more of what is seen is lit than of the rest.
const APART: f32 = 0.08;

/// Directions to the eye along each side of the map of a hemisphere, of which there are two: what is seen from just
/// above the horizon has nothing to do with what is seen from below it.
const SIDE: i32 = 6;

/// Directions in a hemisphere.
const DIRECTIONS: i32 = SIDE * SIDE;

/// The lobes of a level's voxels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lobes {
    /// Where those of each voxel and direction begin, and the end; empty in levels that have none.
    first: Vec<u32>,
    all: Vec<Lobe>,
    /// What each sees of the sky: to sum it takes longer than all else that lights a lobe.
    skies: Vec<Sky>,
}

/// What a lobe sees of the sky, above and below the surface: the part of the hemisphere in 1/255, and the sum of its
/// directions in 1/127.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sky([(u8, [i8; 3]); 2]);

impl Sky {
    fn new([above, below]: [(f32, Vec3); 2]) -> Self {
        let sum = |s: f32| (127.0 * s).round() as i8;
        let half = |(open, v): (f32, Vec3)| ((255.0 * open).round() as u8, [sum(v.x), sum(v.y), sum(v.z)]);
        Self([half(above), half(below)])
    }

    #[inline]
    fn unpack(self) -> [(f32, Vec3); 2] {
        let Self([above, below]) = self;
        let half = |(open, [x, y, z]): (u8, [i8; 3])| {
            (f32::from(open) * (1.0 / 255.0), Vec3::new(x.into(), y.into(), z.into()) * (1.0 / 127.0))
        };
        [half(above), half(below)]
    }
}

impl Lobes {
    /// From what each voxel has for each direction.
    pub(crate) fn new(each: &[Vec<Vec<Lobe>>]) -> Self {
        let mut first = vec![0];
        let mut all = Vec::new();
        for lobes in each.iter().flatten() {
            all.extend_from_slice(lobes);
            first.push(all.len() as u32);
        }
        Self::of_parts(first, all)
    }

    fn of_parts(first: Vec<u32>, all: Vec<Lobe>) -> Self {
        let skies = all.par_iter().map(|lobe| Sky::new(lobe.sky())).collect();
        Self { first, all, skies }
    }

    /// What a voxel shows to each direction; at most `most` lobes each.
    pub(crate) fn of_voxel(points: &[Point], most: usize) -> Vec<Vec<Lobe>> {
        (0..2 * DIRECTIONS)
            .map(|i| {
                let (hemisphere, cell) = (i / DIRECTIONS, IVec2::new(i % SIDE, i % DIRECTIONS / SIDE));
                seen_from(points, if hemisphere == 0 { 1.0 } else { -1.0 }, cell, most)
            })
            .collect()
    }

    /// The lobes that a voxel shows to the unit vector `eye`, those of the four nearest directions: the part that each
    /// direction has of the picture, and its lobes.
    #[inline]
    pub(crate) fn seen(&self, voxel: u32, eye: Vec3) -> [(f32, Range<u32>); 4] {
        let at = (on_square(eye) * 0.5 + 0.5) * SIDE as f32 - 0.5;
        let (cell, part) = (at.floor(), at - at.floor());
        let hemisphere = 2 * voxel as usize + usize::from(eye.z < 0.0);
        let mut seen = [const { (0.0, 0..0) }; 4];
        let mut whole = 0.0;
        for (i, (share, range)) in seen.iter_mut().enumerate() {
            let corner = IVec2::new(i as i32 & 1, i as i32 >> 1);
            let near = |corner: i32, part: f32| if corner == 0 { 1.0 - part } else { part };
            let (x, y) = (near(corner.x, part.x), near(corner.y, part.y));
            let direction = (cell.as_ivec2() + corner).clamp(IVec2::ZERO, IVec2::splat(SIDE - 1));
            let entry = hemisphere * DIRECTIONS as usize + (direction.y * SIDE + direction.x) as usize;
            if let Some(&[start, end]) = self.first.get(entry..entry + 2)
                && start < end
            {
                (*share, *range) = (x * y, start..end);
                whole += *share;
            }
        }
        for (share, _) in &mut seen {
            *share /= f32::max(whole, f32::MIN_POSITIVE);
        }
        seen
    }

    /// All of them, in the order of their voxels and directions.
    #[inline]
    pub(crate) fn all(&self) -> &[Lobe] {
        &self.all
    }

    /// What a lobe sees of the sky, as [`Lobe::sky`], to some 1/200.
    #[inline]
    pub(crate) fn sky(&self, number: u32) -> [(f32, Vec3); 2] {
        self.skies[number as usize].unpack()
    }

    /// Whether the level has any.
    pub(crate) fn is_there(&self) -> bool {
        !self.first.is_empty()
    }

    /// How many lobes each voxel has for each direction.
    pub(crate) fn counts(&self) -> impl ExactSizeIterator<Item = u8> + '_ {
        self.first.windows(2).map(|pair| (pair[1] - pair[0]) as u8)
    }

    /// How many counts as many voxels have.
    pub(crate) fn count(voxels: usize) -> Option<usize> {
        voxels.checked_mul(2 * DIRECTIONS as usize)
    }

    /// From what [`counts`](Self::counts) and [`all`](Self::all) gave; `None` where they do not fit.
    pub(crate) fn from_tables(counts: impl Iterator<Item = u8>, all: Vec<Lobe>) -> Option<Self> {
        let mut first = vec![0_u32];
        let mut sum = 0_u32;
        for count in counts {
            sum = sum.checked_add(count.into())?;
            first.push(sum);
        }
        (sum as usize == all.len()).then(|| Self::of_parts(first, all))
    }

    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.first[..]) + size_of_val(&self.all[..]) + size_of_val(&self.skies[..])
    }
}

/// The lobes of what is seen from a cell of the directions, on the side of the surface that `side` is the sign of.
fn seen_from(points: &[Point], side: f32, cell: IVec2, most: usize) -> Vec<Lobe> {
    // Four directions in the cell.
    let directions = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(x, y)| {
        let at = (cell.as_vec2() + vec2(x, y)) / SIDE as f32;
        from_square(2.0 * at - 1.0, side)
    });
    let share = |point: &Point| -> f32 {
        let facing = |d: &Vec3| if point.surfel.sees(*d) { point.surfel.normal().dot(*d) } else { 0.0 };
        point.weight * directions.iter().map(facing).sum::<f32>()
    };
    let mut seen: Vec<(Point, f32)> =
        points.iter().map(|p| (*p, share(p))).filter(|(_, share)| *share > 0.0).collect();
    // Groups of normals in cells of about 20°.
    let group = |p: &Point| {
        let normal = p.surfel.normal();
        let at = (on_square(normal) * 0.5 + 0.5) * 5.999;
        (normal.z < 0.0, at.x as u32, at.y as u32)
    };
    seen.sort_by_key(|(p, _)| group(p));
    let mut groups: Vec<Vec<(Point, f32)>> =
        seen.chunk_by(|a, b| group(&a.0) == group(&b.0)).map(<[_]>::to_vec).collect();
    let size = |g: &[(Point, f32)]| g.iter().map(|p| p.1).sum::<f32>();
    groups.sort_by(|a, b| size(b).total_cmp(&size(a)));
    while groups.len() > most {
        // The lightest joins the one that faces most like it.
        let Some(lightest) = groups.pop() else { break };
        let facing = |g: &[(Point, f32)]| {
            g.iter().map(|(p, s)| *s * p.surfel.normal()).sum::<Vec3>().normalize_or_zero()
        };
        let normal = facing(&lightest);
        let nearest =
            groups.iter_mut().max_by(|a, b| facing(a).dot(normal).total_cmp(&facing(b).dot(normal)));
        if let Some(group) = nearest {
            group.extend(lightest);
        }
    }
    let largest = groups.iter().map(|g| size(g)).fold(f32::MIN_POSITIVE, f32::max);
    groups.iter().map(|g| Lobe::new(g, largest)).collect()
}

/// Where a direction lies on the map of its hemisphere, [−1, 1]², whose border is the horizon. [Cigolle14]
fn on_square(n: Vec3) -> Vec2 {
    let p = n.truncate() / n.abs().element_sum().max(f32::MIN_POSITIVE);
    vec2(p.x + p.y, p.x - p.y)
}

/// The direction at a point of the map, on a side of the surface (1 or −1).
fn from_square(at: Vec2, side: f32) -> Vec3 {
    let p = 0.5 * vec2(at.x + at.y, at.x - at.y);
    p.extend(side * (1.0 - p.x.abs() - p.y.abs())).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn twenty_two_bytes() {
        assert_eq!(size_of::<Lobe>(), 22);
    }

    #[test]
    fn the_map_of_directions_returns() {
        let random = &mut Random::new(3, 0);
        for _ in 0..1000 {
            let d = Vec3::new(random.signed(), random.signed(), random.signed()).normalize_or(Vec3::X);
            assert!((from_square(on_square(d), d.z.signum()) - d).length() < 1e-5);
        }
    }

    #[test]
    fn lobes_say_what_their_points_do() {
        // A floor whose cells are open where x > 0 (the disk's axes are the plane's), and one that is open everywhere,
        // three times as large: from above, ¾ + ¼ of it is lit from x > 0, and ¾ from x < 0.
        let floor = |open| Surfel::new(Vec3::Z, Vec3::splat(0.5), 1.0, open);
        let along = from_disk(Vec3::Z, [7, 4]);
        let half = (0..64).filter(|c| from_disk(Vec3::Z, [c % 8, c / 8]).dot(along) > 0.0);
        let half = half.fold(0_u64, |mask, cell| mask | 1 << cell);
        let up = from_disk(Vec3::Z, [4, 4]);
        assert!(floor(half).sees(up));
        let points =
            [Point { surfel: floor(half), weight: 1.0 }, Point { surfel: floor(u64::MAX), weight: 3.0 }];
        let lobes = Lobes::new(&[Lobes::of_voxel(&points, 8)]);
        let seen = lobes.seen(0, up);
        assert!((seen.iter().map(|s| s.0).sum::<f32>() - 1.0).abs() < 1e-5);
        for (share, range) in seen {
            for lobe in &lobes.all()[range.start as usize..range.end as usize] {
                assert!((lobe.normal() - Vec3::Z).length() < 1e-3 && share > 0.0);
                assert!((lobe.color() - 0.5).length() < 0.01);
            }
        }
        // From where the first is open, both are seen alike; far from the eye, ¼ of what is seen is dark.
        let lit = |eye: Vec3, light: Vec3| {
            let alike = Lobe::alike(eye, light);
            let of = |(share, range): (f32, Range<u32>)| {
                share * lobes.all()[range.start as usize].lit(alike, light)
            };
            lobes.seen(0, eye).into_iter().map(of).sum::<f32>()
        };
        let back = Vec3::new(-along.x, -along.y, along.z);
        // A cell is told in thirds, and what that takes from one the next ones get: of eight cells, a third of one at most.
        let mean = |eye: Vec3, light: Vec3| {
            let first = if light == along { 6 } else { 0 };
            let cells = (2..6).flat_map(|row| [[first, row], [first + 1, row]]);
            cells.map(|cell| lit(eye, from_disk(Vec3::Z, cell))).sum::<f32>() / 8.0
        };
        for (eye, light, expected) in [(along, along, 1.0), (along, back, 0.75), (back, along, 1.0)] {
            let lit = mean(eye, light);
            assert!((lit - expected).abs() < 1.0 / 24.0 + 1e-3, "{lit}");
        }
        assert_eq!(lobes.seen(0, -Vec3::Z).map(|s| s.0).iter().sum::<f32>(), 0.0);
    }
}
