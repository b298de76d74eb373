//! A scatterer: a point of a density, what it sends back, and how much light reaches it from where.
//!
//! A density has no surface that hides one side of it: a point inside is seen from everywhere, more or less. So where
//! surfaces have [surfels](crate::Surfel), a density has points of equal share of what it sends back, each with the
//! transmittance T of the density around it in all directions. What is seen of a voxel from v and lit from l is
//!
//! ```text
//! Σ w T(v) · c (n·l)⁺ T(l)  /  Σ w T(v)
//! ```
//!
//! Where few voxels hold the texel all its shadows are in T. From level 3 on T(l) is left to the shadow cone, which goes
//! through the same voxels as the cone to the eye: seen through fog and lit through the same fog, errors of both cancel.
//! Beyond level 5 voxels are so small that T(v) is left out too.

use glam::{Vec2, Vec3};

use crate::packed::{folded, unfolded};
use crate::sample::Sample;

/// A point of a density. 6 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scatterer(pub(crate) Sample);

impl Scatterer {
    /// A point of unit `normal` and linear `color` with the part `weight` (0 to 1) of the heaviest of its voxel.
    pub(crate) fn new(normal: Vec3, color: Vec3, weight: f32) -> Self {
        Self(Sample::new(normal, color, weight))
    }

    /// Unit normal, out of the density; texel space.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.0.normal()
    }

    /// Linear albedo.
    #[inline]
    pub fn color(&self) -> Vec3 {
        self.0.color()
    }

    /// What it stands for, as a part of what the voxel's heaviest does.
    #[inline]
    pub fn weight(&self) -> f32 {
        self.0.weight()
    }
}

/// The direction (unit length) of each corner of an octahedral map of `side` cells along an axis: opposite points of an
/// edge are one direction.
pub(crate) fn directions(side: usize) -> impl Iterator<Item = Vec3> {
    (0..(side + 1).pow(2)).map(move |i| {
        let corner = [i % (side + 1), i / (side + 1)].map(|c| 2.0 * c as f32 / side as f32 - 1.0);
        folded(Vec2::from_array(corner))
    })
}

/// The scatterers of a voxel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scatterers<'a> {
    all: &'a [Scatterer],
    /// Of each in turn the transmittances in the corners of its map.
    maps: &'a [u8],
    /// Cells of a map along an axis; 0 where there is none.
    side: usize,
}

impl<'a> Scatterers<'a> {
    /// The last level whose scatterers know what passes their surroundings.
    pub(crate) const MAPPED: u32 = 5;

    /// How far the scatterers of a level know their surroundings, in texel units: two voxels, at level 1 as far as at level 0.
    pub fn reach(level: u32) -> f32 {
        match level {
            0..2 => 2.0,
            2..=Self::MAPPED => 2.0 * 0.5_f32.powi(level as i32),
            _ => 0.0,
        }
    }

    /// Whether the scatterers of a level say what light reaches them from within [`Scatterers::reach`]; else a shadow
    /// cone from the point itself does.
    pub fn hold_shadows(level: u32) -> bool {
        level < 3
    }

    /// Cells of the maps of a level along an axis.
    pub(crate) fn side(level: u32) -> usize {
        match level {
            0..3 => 16,
            3..=Self::MAPPED => 8,
            _ => 0,
        }
    }

    /// The points.
    pub fn points(&self) -> &'a [Scatterer] {
        self.all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The part of the light that passes between point `i` and its surroundings in the unit direction `d` of texel space;
    /// all, where it is not known.
    #[inline]
    pub fn transmittance(&self, i: usize, d: Vec3) -> f32 {
        let row = self.side + 1;
        let Some(map) = self.maps.get(i * row * row..(i + 1) * row * row).filter(|_| self.side > 0) else {
            return 1.0;
        };
        let p = unfolded(d);
        let place = |c: f32| 0.5 * (c + 1.0) * self.side as f32;
        let (x, y) = (place(p.x), place(p.y));
        let cell = |c: f32| (c.max(0.0) as usize).min(self.side - 1);
        let (i, j) = (cell(x), cell(y));
        let (a, b) = (x - i as f32, y - j as f32);
        let at = |i: usize, j: usize| f32::from(map[j * row + i]);
        let along = |j: usize| at(i, j) + a * (at(i + 1, j) - at(i, j));
        (along(j) + b * (along(j + 1) - along(j))) * (1.0 / 255.0)
    }

    /// What reaches point `i` of its cosine-weighted hemisphere, from above and from below the surface that the texel
    /// stands on: the part of the hemisphere, and the sum of its directions (texel space), weighted alike.
    pub fn sky(&self, i: usize) -> [(f32, Vec3); 2] {
        // Equal parts of the hemisphere under the cosine: stratified in sin², turned by the golden angle.
        const DIRECTIONS: usize = 24;
        const GOLDEN: f32 = 2.399_963_2;
        let mut halves = [(0.0, Vec3::ZERO); 2];
        let Some(point) = self.all.get(i) else { return halves };
        let n = point.normal();
        let (x, y) = n.any_orthonormal_pair();
        for k in 0..DIRECTIONS {
            let sin2 = (k as f32 + 0.5) / DIRECTIONS as f32;
            let (sin, cos) = (GOLDEN * k as f32).sin_cos();
            let d = sin2.sqrt() * (cos * x + sin * y) + (1.0 - sin2).sqrt() * n;
            let open = self.transmittance(i, d) / DIRECTIONS as f32;
            let (part, sum) = &mut halves[usize::from(d.z < 0.0)];
            *part += open;
            *sum += open * d;
        }
        halves
    }
}

/// The scatterers of a level's voxels, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cloud {
    /// Where each voxel's begin, and the end; empty where no voxel has any.
    first: Vec<u32>,
    all: Vec<Scatterer>,
    /// Of each its map, if the level has maps.
    maps: Vec<u8>,
    /// Cells of a map along an axis; 0 where there is none.
    side: usize,
}

impl Cloud {
    /// From each voxel's points and their maps of `side` cells along an axis.
    pub(crate) fn new(each: Vec<(Vec<Scatterer>, Vec<u8>)>, side: usize) -> Self {
        let mut cloud = Self { first: vec![0], side, ..Self::default() };
        for (points, maps) in each {
            cloud.all.extend(points);
            cloud.maps.extend(maps);
            cloud.first.push(cloud.all.len() as u32);
        }
        cloud
    }

    #[inline]
    pub(crate) fn of(&self, voxel: u32) -> Scatterers<'_> {
        let voxel = voxel as usize;
        let Some(&[start, end]) = self.first.get(voxel..voxel + 2) else { return Scatterers::default() };
        let [start, end] = [start as usize, end as usize];
        let map = (self.side + 1).pow(2);
        Scatterers {
            all: self.all.get(start..end).unwrap_or(&[]),
            maps: self.maps.get(start * map..end * map).unwrap_or(&[]),
            side: self.side,
        }
    }

    /// Whether it is of a level of density: others have none.
    pub(crate) fn is_there(&self) -> bool {
        !self.first.is_empty()
    }

    /// All points in the order of their voxels, their maps, and the cells of a map along an axis.
    pub(crate) fn tables(&self) -> (&[Scatterer], &[u8], usize) {
        (&self.all, &self.maps, self.side)
    }

    /// How many points each voxel has.
    pub(crate) fn counts(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.first.windows(2).map(|pair| pair[1] - pair[0])
    }

    /// From what [`counts`](Self::counts) and [`tables`](Self::tables) gave; `None` where they do not fit.
    pub(crate) fn from_tables(
        counts: impl Iterator<Item = u32>,
        all: Vec<Scatterer>,
        maps: Vec<u8>,
        side: usize,
    ) -> Option<Self> {
        let mut first = vec![0_u32];
        let mut sum = 0_u32;
        for count in counts {
            sum = sum.checked_add(count)?;
            first.push(sum);
        }
        let mapped =
            if side == 0 { Some(0) } else { all.len().checked_mul(side.checked_add(1)?.checked_pow(2)?) };
        let fits = sum as usize == all.len() && mapped == Some(maps.len());
        fits.then_some(Self { first, all, maps, side })
    }

    pub(crate) fn memory(&self) -> usize {
        size_of_val(self.first.as_slice())
            + size_of_val(self.all.as_slice())
            + size_of_val(self.maps.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn six_bytes() {
        assert_eq!(size_of::<Scatterer>(), 6);
    }

    #[test]
    fn a_map_is_smooth_across_its_seams() {
        // Interpolated over cells of up to .6 radians each way, T = ½ + ½ d·a, of curvature ½, is wrong by up to
        // 2 · ½ · .6²/8; and the two sides of the octahedron's folded edges agree.
        let axis = Vec3::new(0.48, -0.6, 0.64);
        let map = directions(8).map(|d| (255.0 * (0.5 + 0.5 * d.dot(axis))).round() as u8).collect();
        let cloud = Cloud::new(vec![(vec![Scatterer::new(Vec3::Z, Vec3::ONE, 1.0)], map)], 8);
        let scatterers = cloud.of(0);
        let random = &mut Random::new(5, 0);
        for _ in 0..10_000 {
            let d = random.direction();
            let t = scatterers.transmittance(0, d);
            assert!((t - 0.5 - 0.5 * d.dot(axis)).abs() < 0.05, "{d}: {t}");
            let near = (d + 1e-4 * Vec3::new(random.signed(), random.signed(), random.signed())).normalize();
            assert!((scatterers.transmittance(0, near) - t).abs() < 1e-3);
        }
        assert!(cloud.of(1).is_empty());
    }

    #[test]
    fn the_open_sky_of_a_wall_is_half() {
        // As of a surfel: an open floor sees all of its hemisphere, of mean direction ⅔ n; a wall a half from above.
        let points = [Vec3::Z, Vec3::X].map(|n| Scatterer::new(n, Vec3::ONE, 1.0)).to_vec();
        let cloud = Cloud::new(vec![(points, vec![])], 0);
        let [(open, sum), (below, _)] = cloud.of(0).sky(0);
        assert!((open - 1.0).abs() < 1e-5 && (sum - Vec3::Z * 2.0 / 3.0).length() < 0.05, "{open} {sum}");
        assert_eq!(below, 0.0);
        for (open, sum) in cloud.of(0).sky(1) {
            assert!((open - 0.5).abs() < 0.05 && (sum.z.abs() - 0.212).abs() < 0.03, "{open} {sum}");
        }
    }
}
