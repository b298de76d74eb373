//! The frozen texel: every level of the octree, coarsest first, each one flat allocation a kind (see
//! [`bricks`](crate::bricks) and [`packed`](crate::packed) for the bytes).

use glam::{IVec3, Vec3};

use crate::bricks::Bricks;
use crate::packed::Packed;
use crate::surfel::Surfels;
use crate::{Crossing, Line, Source, Surfel, TexelError, Voxel, Walk};

/// One level: `2^l` voxels a side, of which only the occupied ones are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    bricks: Bricks,
    voxels: Vec<Packed>,
    surfels: Surfels,
    periodic: bool,
}

impl Level {
    pub(crate) fn new(bricks: Bricks, voxels: Vec<Packed>, periodic: bool) -> Self {
        Self { bricks, voxels, surfels: Surfels::default(), periodic }
    }

    /// Voxels a side.
    pub fn resolution(&self) -> u32 {
        self.bricks.resolution()
    }

    /// How many voxels are occupied.
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether no voxel is.
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// The voxel of an index given by [`find`](Self::find) or [`walk`](Self::walk).
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    #[inline]
    pub fn voxel(&self, index: u32) -> Voxel {
        self.voxels[index as usize].unpack()
    }

    /// Points of the surface in the voxel of that index; none where nothing of it can be seen.
    #[inline]
    pub fn surfels(&self, index: u32) -> &[Surfel] {
        self.surfels.of(index)
    }

    /// What `line` (in voxels of this level) meets between the parameters `range` in the voxel `index`, standing in
    /// `cell`; `None` where it misses the matter.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    #[inline]
    pub fn cross(&self, index: u32, line: &Line, cell: IVec3, range: [f32; 2]) -> Option<Crossing> {
        line.cross(&self.voxels[index as usize], cell, range)
    }

    /// The voxel in a cell: s and t wrap if the texel is periodic; `None` outside it or where it is empty.
    pub fn find(&self, cell: IVec3) -> Option<u32> {
        let size = self.resolution() as i32;
        let inside = |c: i32| (0..size).contains(&c);
        if !inside(cell.z) || !(self.periodic || inside(cell.x) && inside(cell.y)) {
            return None;
        }
        self.bricks.find(cell & (size - 1))
    }

    /// The occupied cells, in the order of their voxels.
    pub fn cells(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.bricks.cells()
    }

    /// The occupied cells along a segment, in order.
    ///
    /// `from` and `to` in voxels of this level (texel coordinates × resolution), s and t unbounded in a
    /// periodic texel. Nothing is met by segments that are not finite or end beyond 2²² voxels.
    #[inline]
    pub fn walk(&self, from: Vec3, to: Vec3) -> Walk<'_> {
        Walk::new(&self.bricks, self.periodic, from, to)
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.bricks.memory() + size_of_val(self.voxels.as_slice()) + self.surfels.memory()
    }

    pub(crate) fn set_surfels(&mut self, surfels: Surfels) {
        self.surfels = surfels;
    }

    pub(crate) fn voxels_mut(&mut self) -> &mut [Packed] {
        &mut self.voxels
    }
}

/// A cube of content, [0, 1]³ in (s, t, w), w away from the surface, with data at every level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Texel {
    /// What it is called.
    pub name: String,
    /// Specular albedo of its material, 0 to 1.
    pub specular: f32,
    /// Roughness of its highlight, 0 to 1.
    pub roughness: f32,
    /// Whether it repeats in s and t.
    pub periodic: bool,
    source: Source,
    levels: Vec<Level>,
}

impl Texel {
    pub(crate) fn new(
        name: &str,
        source: Source,
        material: [f32; 2],
        periodic: bool,
        levels: Vec<Level>,
    ) -> Self {
        let [specular, roughness] = material;
        Self { name: name.to_owned(), specular, roughness, periodic, source, levels }
    }

    /// What it was made from.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The same texel, its source forgotten.
    pub fn without_source(mut self) -> Self {
        self.source = Source::Unknown;
        self
    }

    /// The finest level's number.
    pub fn depth(&self) -> u32 {
        self.levels.len().saturating_sub(1) as u32
    }

    /// Every level, coarsest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Level `l`: `2^l` voxels a side.
    ///
    /// # Panics
    /// If `l` is above [`depth`](Self::depth).
    #[inline]
    pub fn level(&self, l: u32) -> &Level {
        &self.levels[l as usize]
    }

    pub(crate) fn levels_mut(&mut self) -> &mut [Level] {
        &mut self.levels
    }

    /// Bytes held by all levels.
    pub fn memory(&self) -> usize {
        self.levels.iter().map(Level::memory).sum()
    }

    /// Checks every invariant: sizes, ranks, empty cubes, that a cell is occupied exactly where one of its
    /// children is, and the domain of every number.
    ///
    /// # Errors
    /// The first fault found, with its level and cell or voxel.
    pub fn validate(&self) -> Result<(), TexelError> {
        if self.levels.is_empty() {
            return Err(TexelError::Structure { level: 0, what: "there is no level" });
        }
        for (l, level) in self.levels.iter().enumerate() {
            let structure = |what| TexelError::Structure { level: l as u32, what };
            if level.resolution() != 1 << l {
                return Err(structure("the resolution is not 2^level"));
            }
            if level.periodic != self.periodic {
                return Err(structure("the level wraps otherwise than the texel"));
            }
            if let Some(what) = level.bricks.fault() {
                return Err(structure(what));
            }
            if level.bricks.len() as usize != level.voxels.len() {
                return Err(structure("voxels are not as many as occupied cells"));
            }
            for (voxel, stored) in level.voxels.iter().enumerate() {
                if let Some(field) = stored.unpack().fault() {
                    return Err(TexelError::Voxel { level: l as u32, voxel: voxel as u32, field });
                }
            }
        }
        for (l, pair) in self.levels.windows(2).enumerate() {
            self.validate_family(l as u32, &pair[0], &pair[1])?;
        }
        Ok(())
    }

    fn validate_family(&self, level: u32, parents: &Level, children: &Level) -> Result<(), TexelError> {
        let signed = |cell: [u32; 3]| IVec3::from_array(cell.map(|c| c as i32));
        for cell in children.cells() {
            let parent = cell.map(|c| c / 2);
            if parents.bricks.find(signed(parent)).is_none() {
                return Err(TexelError::Orphan { level, cell: parent });
            }
        }
        for cell in parents.cells() {
            let child = |i: i32| IVec3::new(i & 1, i >> 1 & 1, i >> 2 & 1) + 2 * signed(cell);
            if (0..8).all(|i| children.bricks.find(child(i)).is_none()) {
                return Err(TexelError::Orphan { level, cell });
            }
        }
        Ok(())
    }
}
