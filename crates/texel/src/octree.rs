//! The frozen texel: every level of the octree, coarsest first, each one flat allocation a kind (see
//! [`bricks`](crate::bricks) and [`packed`](crate::packed) for the bytes).

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::bearings::Bearings;
use crate::bricks::{Bricks, demorton, morton};
use crate::compact::Compact;
use crate::exposure::Shown;
use crate::packed::Packed;
use crate::reflectance::{Reflectance, Reflectances};
use crate::scatterer::{Cloud, Scatterers};
use crate::surfel::Surfels;
use crate::{Balance, BuildError, Crossing, Line, Source, Step, Surfel, TexelError, Voxel, Walk};

/// One level: `2^l` voxels a side, of which only the occupied ones are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    bricks: Bricks,
    content: Content,
    /// What the voxels reflect, where they are coarse.
    reflectances: Reflectances,
    /// Points of a density.
    cloud: Cloud,
    /// How much of the upper hemisphere each voxel sees, 1/255; nothing where an ancestor says it.
    openness: Vec<u8>,
    /// By how much more light its voxels send than they say, where that is known.
    balance: Option<Balance>,
    /// By how much deeper they are than they say, where that is known.
    bearings: Option<Bearings>,
    periodic: bool,
}

/// What stands in the cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    /// As it was measured.
    Exact(Vec<Packed>, Surfels),
    /// In little room.
    Compact(Compact),
}

impl Level {
    pub(crate) fn new(bricks: Bricks, voxels: Vec<Packed>, periodic: bool) -> Self {
        Self::of_parts(bricks, Content::Exact(voxels, Surfels::default()), Vec::new(), periodic)
    }

    pub(crate) fn of_parts(bricks: Bricks, content: Content, openness: Vec<u8>, periodic: bool) -> Self {
        Self {
            bricks,
            content,
            reflectances: Reflectances::default(),
            cloud: Cloud::default(),
            openness,
            balance: None,
            bearings: None,
            periodic,
        }
    }

    pub(crate) fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    pub(crate) fn content(&self) -> &Content {
        &self.content
    }

    pub(crate) fn openness(&self) -> &[u8] {
        &self.openness
    }

    pub(crate) fn reflectances(&self) -> &Reflectances {
        &self.reflectances
    }

    pub(crate) fn cloud(&self) -> &Cloud {
        &self.cloud
    }

    /// Voxels a side.
    pub fn resolution(&self) -> u32 {
        self.bricks.resolution()
    }

    /// Whether it goes on beyond its borders in s and t.
    pub(crate) fn is_periodic(&self) -> bool {
        self.periodic
    }

    /// How many voxels are occupied.
    pub fn len(&self) -> usize {
        self.bricks.len() as usize
    }

    /// Whether no voxel is.
    pub fn is_empty(&self) -> bool {
        self.bricks.len() == 0
    }

    /// The voxel of an index given by [`find`](Self::find) or [`walk`](Self::walk).
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    #[inline]
    pub fn voxel(&self, index: u32) -> Voxel {
        match &self.content {
            Content::Exact(voxels, _) => voxels[index as usize].unpack(),
            Content::Compact(compact) => compact.unpack(index as usize),
        }
    }

    /// Points of the surface in the voxel of that index; none where nothing of it can be seen.
    #[inline]
    pub fn surfels(&self, index: u32) -> impl Iterator<Item = Surfel> + '_ {
        let (exact, compact) = match &self.content {
            Content::Exact(_, surfels) => (surfels.of(index), None),
            Content::Compact(compact) => (&[][..], Some(compact.surfels_of(index as usize))),
        };
        exact.iter().copied().chain(compact.into_iter().flatten())
    }

    /// What the voxel of that index shows to the eye, a unit vector of texel space. `None` where nothing of it is seen from
    /// there, in fine levels, which have surfels, and in those of a density.
    #[inline]
    pub fn reflectance(&self, index: u32, eye: Vec3) -> Option<Reflectance<'_>> {
        self.reflectances.of(index, eye)
    }

    /// Points of the density in the voxel of that index; none where the content has surfaces.
    #[inline]
    pub fn scatterers(&self, index: u32) -> Scatterers<'_> {
        self.cloud.of(index)
    }

    /// What `line` (in voxels of this level) meets in the voxel of one step of its walk; `None` where it misses the matter.
    ///
    /// # Panics
    /// If the step is not of this level: its voxel not below [`len`](Self::len).
    #[inline]
    pub fn cross(&self, line: &Line, step: &Step) -> Option<Crossing> {
        let (index, range) = (step.voxel as usize, [step.enter, step.leave]);
        let crossing = match &self.content {
            Content::Exact(voxels, _) => line.cross(&voxels[index], step.cell, range),
            Content::Compact(compact) => line.cross(&compact.voxel(index), step.cell, range),
        };
        let Some(bearings) = &self.bearings else { return crossing };
        let Crossing { range, depth } = crossing?;
        let factor = bearings.factor(line.step.into(), step.voxel, step.cell.z, self.resolution());
        Some(Crossing { range, depth: factor * depth })
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
        self.walk_along(&Line::new(from, to - from), [0.0, 1.0])
    }

    /// The same along a line, between two of its parameters.
    #[inline]
    pub fn walk_along(&self, line: &Line, range: [f32; 2]) -> Walk<'_> {
        Walk::new(&self.bricks, self.periodic, line, range)
    }

    /// As [`walk_along`](Self::walk_along), in one copy only: nothing is met beyond its borders, even in a periodic texel.
    #[inline]
    pub fn walk_alone(&self, line: &Line, range: [f32; 2]) -> Walk<'_> {
        Walk::new(&self.bricks, false, line, range)
    }

    /// By how much more light the voxels send to the eye than they say; nothing where the texel has not been balanced.
    #[inline]
    pub fn balance(&self) -> Option<&Balance> {
        self.balance.as_ref()
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        let content = match &self.content {
            Content::Exact(voxels, surfels) => size_of_val(voxels.as_slice()) + surfels.memory(),
            Content::Compact(compact) => compact.memory(),
        };
        self.bricks.memory()
            + content
            + self.reflectances.memory()
            + self.cloud.memory()
            + self.openness.len()
            + self.bearings.as_ref().map_or(0, |bearings| bearings.logs().len())
            + self.balance.as_ref().map_or(0, |balance| size_of_val(balance.nodes()))
    }

    /// Keeps it in little room, if it is fine enough that nobody sees the difference.
    fn compacted(self) -> Self {
        match &self.content {
            // Levels of reflectances are few voxels.
            Content::Exact(..) if self.reflectances.is_there() => self,
            Content::Exact(voxels, surfels) => match Compact::new(voxels, surfels) {
                Some(compact) => Self { content: Content::Compact(compact), ..self },
                None => self,
            },
            Content::Compact(_) => self,
        }
    }

    /// Of a level as it was measured.
    pub(crate) fn set_shown(&mut self, shown: Shown) {
        match (shown, &mut self.content) {
            (Shown::Surfels(measured), Content::Exact(_, surfels)) => *surfels = measured,
            (Shown::Surfels(_), Content::Compact(_)) => {}
            (Shown::Reflectances(reflectances), _) => self.reflectances = reflectances,
        }
    }

    pub(crate) fn set_reflectances(&mut self, reflectances: Reflectances) {
        self.reflectances = reflectances;
    }

    /// Of a level as it was measured; else none.
    pub(crate) fn voxels_mut(&mut self) -> &mut [Packed] {
        match &mut self.content {
            Content::Exact(voxels, _) => voxels,
            Content::Compact(_) => &mut [],
        }
    }

    pub(crate) fn set_cloud(&mut self, cloud: Cloud) {
        self.cloud = cloud;
    }

    pub(crate) fn bearings(&self) -> Option<&Bearings> {
        self.bearings.as_ref()
    }

    pub(crate) fn set_bearings(&mut self, bearings: Option<Bearings>) {
        self.bearings = bearings;
    }

    pub(crate) fn set_balance(&mut self, balance: Option<Balance>) {
        self.balance = balance;
    }

    pub(crate) fn set_openness(&mut self, openness: Vec<u8>) {
        self.openness = openness;
    }

    /// What does not fit, or is out of its domain, if anything.
    fn fault(&self) -> Option<LevelFault> {
        let structure = |what| Some(LevelFault::Structure(what));
        if let Some(what) = self.bricks.fault() {
            return structure(what);
        }
        let voxels = match &self.content {
            Content::Exact(voxels, _) => voxels.len(),
            Content::Compact(compact) => compact.voxels.len(),
        };
        if voxels != self.len() {
            return structure("voxels are not as many as occupied cells");
        }
        if !self.openness.is_empty() && self.openness.len() != voxels {
            return structure("openness is not known of every voxel");
        }
        if let Content::Compact(compact) = &self.content
            && let Some(what) = compact.fault()
        {
            return structure(what);
        }
        let fault = |i| self.voxel(i).fault().map(|field| LevelFault::Voxel(i, field));
        (0..voxels as u32).into_par_iter().with_min_len(4096).find_map_first(fault)
    }
}

/// What can be wrong with a level: its lists, or a field of a voxel.
enum LevelFault {
    Structure(&'static str),
    Voxel(u32, &'static str),
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

    /// A texel of no level: what its source says can be asked of it, by the reference renderer for one, and cones see
    /// nothing in it.
    ///
    /// # Errors
    /// What [`build`](crate::build()) would refuse of the source.
    pub fn unbaked(name: &str, source: impl Into<Source>) -> Result<Self, BuildError> {
        let source = source.into();
        let material = source.sound_content()?.material();
        Ok(Self::new(name, source, material, true, Vec::new()))
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

    /// Fraction of the cosine-weighted upper hemisphere (around +w) that the texel leaves open above a voxel of level
    /// `l` in `cell`, 0 to 1. It varies slowly: fine voxels have that of an ancestor.
    pub fn openness(&self, l: u32, cell: IVec3) -> f32 {
        let known = self.levels.iter().take(l as usize + 1).rposition(|level| !level.openness.is_empty());
        let open = known.and_then(|known| {
            let level = &self.levels[known];
            let voxel = level.find(cell >> (l as usize - known) as i32)?;
            level.openness.get(voxel as usize)
        });
        open.map_or(1.0, |&open| f32::from(open) * (1.0 / 255.0))
    }

    /// The same texel, its levels balanced by what is given for each, coarsest first; where there is none, as they are.
    pub fn balanced(mut self, balances: impl IntoIterator<Item = Option<Balance>>) -> Self {
        let mut balances = balances.into_iter();
        self.levels.iter_mut().for_each(|level| level.set_balance(balances.next().flatten()));
        self
    }

    /// The same texel, its fine levels in a third of the room: what is rounded away shows in no picture.
    pub fn compacted(mut self) -> Self {
        self.levels = self.levels.into_iter().map(Level::compacted).collect();
        self
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
        self.validate_properties()?;
        for (l, level) in self.levels.iter().enumerate() {
            let structure = |what| TexelError::Structure { level: l as u32, what };
            if level.resolution() != 1 << l {
                return Err(structure("the resolution is not 2^level"));
            }
            if level.periodic != self.periodic {
                return Err(structure("the level wraps otherwise than the texel"));
            }
            match level.fault() {
                Some(LevelFault::Structure(what)) => return Err(structure(what)),
                Some(LevelFault::Voxel(voxel, field)) => {
                    return Err(TexelError::Voxel { level: l as u32, voxel, field });
                }
                None => {}
            }
        }
        for (l, pair) in self.levels.windows(2).enumerate() {
            self.validate_family(l as u32, &pair[0], &pair[1])?;
        }
        Ok(())
    }

    /// Checks the numbers of its material.
    pub(crate) fn validate_properties(&self) -> Result<(), TexelError> {
        let fields = [("specular", self.specular), ("roughness", self.roughness)];
        let wrong = fields.into_iter().find(|(_, value)| !(0.0..=1.0).contains(value));
        wrong.map_or(Ok(()), |(field, _)| Err(TexelError::Material { field }))
    }

    /// Checks that the cells of a level are the parents of the next one's.
    fn validate_family(&self, level: u32, parents: &Level, children: &Level) -> Result<(), TexelError> {
        let mut stored = parents.cells().map(morton);
        let mut wanted = children.bricks.parents();
        loop {
            match (stored.next(), wanted.next()) {
                (None, None) => return Ok(()),
                (a, b) if a == b => {}
                // Both ascend: the lower one is not among the others.
                (a, b) => {
                    let alone = a.unwrap_or(u32::MAX).min(b.unwrap_or(u32::MAX));
                    return Err(TexelError::Orphan { level, cell: demorton(alone) });
                }
            }
        }
    }
}
