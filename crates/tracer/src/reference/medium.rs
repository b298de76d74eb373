//! The density of a texel as the reference sees it: an octree of bounds, and free flights of rays through a box.
//!
//! A ray is stopped where a Poisson process along it has its first event, of the rate at which the density takes light.
//! The process is made of one in each cell of the octree, whose rate is a bound there, and of whose events only as many
//! are kept as the density is of the bound (delta tracking [Woodcock65]). Nothing is stepped through and nothing
//! biased. A cell is found by the bounds of its image under T; where in it an event lies, by Newton's method for T, whose
//! derivatives are differences: T is linear along each coordinate.

use glam::{DMat3, DVec3, Vec3};
use pelage_geom::hash::finish;
use pelage_texel::Density;

use super::carrier::Carrier;
use crate::variety::Tile;

/// A density and the most that each cell of its octree holds.
pub(super) struct Medium {
    pub density: Density,
    /// The most extinction (per texel edge) in each cell: levels from one cell to 2^DEPTH a side.
    most: Vec<Vec<f64>>,
    /// Whether it repeats in s and t.
    pub periodic: bool,
}

/// A cell of the octree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub level: u32,
    pub at: [u32; 3],
}

impl Cell {
    pub(super) const ROOT: Self = Self { level: 0, at: [0; 3] };

    /// Its lower corner and its edge, in texel units.
    pub(super) fn place(self) -> (DVec3, f64) {
        let edge = 0.5_f64.powi(self.level as i32);
        (edge * DVec3::from_array(self.at.map(f64::from)), edge)
    }

    /// Child 0 to 7: bits by axis.
    pub(super) fn child(self, i: usize) -> Self {
        let at = [0, 1, 2].map(|axis| 2 * self.at[axis] + (i >> axis & 1) as u32);
        Self { level: self.level + 1, at }
    }

    fn index(self) -> usize {
        let [x, y, z] = self.at.map(|c| c as usize);
        x + (y << self.level) + (z << (2 * self.level))
    }
}

impl Medium {
    /// The finest cells: 32 a side.
    pub(super) const DEPTH: u32 = 5;

    pub(super) fn new(density: Density, periodic: bool) -> Self {
        let side = 1_u32 << Self::DEPTH;
        let finest = (0..side.pow(3)).map(|i| {
            let cell = Cell { level: Self::DEPTH, at: [i % side, i / side % side, i / side / side] };
            let (lo, edge) = cell.place();
            // A billionth for the rounding of what the cell's points are found by.
            density.most(lo + 0.5 * edge, (0.75_f64.sqrt() + 1e-9) * edge)
        });
        let mut most = vec![finest.collect::<Vec<f64>>()];
        for level in (0..Self::DEPTH).rev() {
            let side = 1_u32 << level;
            let below: &Vec<f64> = &most[most.len() - 1];
            let cells = (0..side.pow(3)).map(|i| {
                let cell = Cell { level, at: [i % side, i / side % side, i / side / side] };
                (0..8).map(|i| below[cell.child(i).index()]).fold(0.0, f64::max)
            });
            let cells = cells.collect();
            most.push(cells);
        }
        most.reverse();
        Self { density, most, periodic }
    }

    /// The most extinction in a cell, per texel edge.
    pub(super) fn most(&self, cell: Cell) -> f64 {
        self.most[cell.level as usize][cell.index()]
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> u64 {
        self.most.iter().map(|level| size_of_val(level.as_slice()) as u64).sum()
    }
}

/// Random numbers of one ray in one cell of one box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(ray: u64, patch: u32, copy: [i32; 2], cell: Cell) -> Self {
        let words = [
            u64::from(patch),
            (copy[0] as u32 as u64) << 32 | u64::from(copy[1] as u32),
            u64::from(cell.level) << 32 | cell.index() as u64,
        ];
        Self(words.into_iter().fold(ray, |hash, word| finish(hash ^ word)))
    }

    /// Uniform in (0, 1]. [Steele14]
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        ((finish(self.0) >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }
}

/// A cell's image in a box.
pub(super) struct Image<'a> {
    medium: &'a Medium,
    carrier: &'a Carrier,
    /// Which copy of the texel.
    tile: &'a Tile,
    lo: DVec3,
    edge: f64,
    /// The most extinction in it, per texel edge.
    most: f64,
    /// From scene directions to steps in the texel, at the middle and the corners.
    inverses: [DMat3; 9],
}

/// What the rate of a cell's process is above the largest that its corners say: between them the way through a bent box
/// may be a little longer.
const MARGIN: f64 = 1.25;

impl<'a> Image<'a> {
    pub(super) fn new(medium: &'a Medium, carrier: &'a Carrier, tile: &'a Tile, cell: Cell) -> Self {
        let (lo, edge) = cell.place();
        let inverses = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| {
            let within = DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
            let within = if i == 8 { DVec3::splat(0.5) } else { within };
            carrier.tangents(tile, carrier.in_box(tile, lo + edge * within)).inverse()
        });
        Self { medium, carrier, tile, lo, edge, most: medium.most(cell), inverses }
    }

    /// Where a ray (relative to the box's frame) is first stopped between the distances `from` and `to`: the distance, and
    /// the point in box coordinates.
    pub(super) fn flight(
        &self,
        origin: DVec3,
        direction: DVec3,
        [mut from, to]: [f64; 2],
        mut random: Random,
    ) -> Option<(f64, DVec3)> {
        let steps = self.inverses.iter().map(|inverse| (*inverse * direction).length());
        let rate = MARGIN * self.most * steps.filter(|step| step.is_finite()).fold(0.0, f64::max);
        if rate <= 0.0 {
            return None;
        }
        loop {
            from -= random.unit().ln() / rate;
            if from > to {
                return None;
            }
            let chance = random.unit();
            let Some((u, p, step)) = self.find(origin + from * direction, direction) else { continue };
            if chance * rate < self.medium.density.extinction(p) * step {
                return Some((from, u));
            }
        }
    }

    /// Box and texel coordinates of a point, and how far a ray's unit of distance goes in the texel there; `None` outside
    /// the cell or the box.
    fn find(&self, point: DVec3, direction: DVec3) -> Option<(DVec3, DVec3, f64)> {
        /// Newton's steps: a cell of a box is nearly affine.
        const STEPS: usize = 12;
        let mut p = self.lo + 0.5 * self.edge;
        for _ in 0..STEPS {
            let u = self.carrier.in_box(self.tile, p);
            let inverse = self.carrier.tangents(self.tile, u).inverse();
            let off = inverse * (point - self.carrier.point(u));
            if !off.is_finite() {
                return None;
            }
            // Texel edges.
            if off.abs().max_element() < 1e-10 {
                let inside = p.cmpge(self.lo).all() && p.cmplt(self.lo + self.edge).all();
                return (inside && self.carrier.holds(u)).then(|| (u, p, (inverse * direction).length()));
            }
            p += off;
        }
        None
    }
}

/// The unit normal of the density at box coordinates, in the scene: the gradient goes by the inverse transpose, whose
/// columns are the cross products of the tangents, over the determinant: negative where the texel is mirrored.
pub(super) fn normal(medium: &Medium, carrier: &Carrier, tile: &Tile, u: DVec3) -> Vec3 {
    let n = medium.density.normal(carrier.in_texel(tile, u));
    let t = carrier.tangents(tile, u);
    let cofactor =
        DMat3::from_cols(t.y_axis.cross(t.z_axis), t.z_axis.cross(t.x_axis), t.x_axis.cross(t.y_axis));
    (t.determinant().signum() * (cofactor * n)).normalize_or(DVec3::Y).as_vec3()
}
