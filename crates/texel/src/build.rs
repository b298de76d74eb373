//! From geometry to a texel, every level measured from the geometry itself.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use pelage_geom::Symmetric3;
use rayon::prelude::*;

use crate::bearings::Bearings;
use crate::bricks::Bricks;
use crate::calibrate::calibrate;
use crate::coverage::{ICOSAHEDRON, Matter, SIXTEEN, Sight, View, fit};
use crate::density::table::Table;
use crate::density::{measure, scatter};
use crate::exposure;
use crate::grid::Frame;
use crate::openness;
use crate::packed::Packed;
use crate::region::{Parts, Region};
use crate::sightline::Sightline;
use crate::source::Content;
use crate::surroundings::Surroundings;
use crate::voxelise::{Cells, Facet, tile};
use crate::{BuildError, Density, Geometry, Level, Scatterers, Source, Surfel, Texel, Voxel};

/// How many sightlines each level is held against.
const SIGHTLINES: usize = 1 << 15;

/// How many, for each of [`BuildOptions::points`], from each of the directions in which coarse levels are held against them once more.
const SIGHTLINES_A_BEARING: usize = 170;

/// How many facets the cells that rays go through hold on the mean: of fewer, and more cells, the walk costs more than the tests that it
/// saves (docs/notes/baking.md).
const FACETS_A_CELL: f32 = 8.0;

/// How a texel is built.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// The finest level, 1 to 9: `2^depth` voxels a side.
    pub depth: u32,
    /// Whether the content repeats in s and t.
    pub periodic: bool,
    /// Side of the square ray grids at levels 6 and above, from 6 directions.
    pub fine_rays: u32,
    /// Side of the square ray grids at levels 3 to 5 (from 6 directions at level 5, 16 below); four times that at
    /// level 2 and eight times below, where there are few voxels.
    pub coarse_rays: u32,
    /// Points of the surface that are looked around from in each voxel of level 4, on each side; the levels above
    /// choose among them.
    pub points: u32,
}

impl BuildOptions {
    /// Depth 5 (32³): to look at content while it is being made.
    pub fn preview() -> Self {
        Self { depth: 5, periodic: true, fine_rays: 6, coarse_rays: 8, points: 12 }
    }

    /// Depth 7 (128³).
    pub fn standard() -> Self {
        Self { depth: 7, periodic: true, fine_rays: 6, coarse_rays: 8, points: 24 }
    }

    /// Depth 8 (256³), many rays.
    pub fn fine() -> Self {
        Self { depth: 8, periodic: true, fine_rays: 10, coarse_rays: 16, points: 48 }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] for the first that is out of its domain.
    pub fn validate(&self) -> Result<(), BuildError> {
        if !(1..=9).contains(&self.depth) {
            let value = self.depth.into();
            return Err(BuildError::Parameter { field: "depth", value, domain: "1 to 9" });
        }
        for (field, value) in [("fine_rays", self.fine_rays), ("coarse_rays", self.coarse_rays)] {
            if !(4..=256).contains(&value) {
                return Err(BuildError::Parameter { field, value: value.into(), domain: "4 to 256" });
            }
        }
        if !(4..=4096).contains(&self.points) {
            let value = self.points.into();
            return Err(BuildError::Parameter { field: "points", value, domain: "4 to 4096" });
        }
        Ok(())
    }

    /// How the voxels of a level are looked at.
    fn sampling(&self, level: u32) -> Sampling {
        let [fine, coarse] = [self.fine_rays, self.coarse_rays].map(|side| side as usize);
        let (directions, side) = match level {
            6.. => (ICOSAHEDRON.as_slice(), fine),
            5 => (ICOSAHEDRON.as_slice(), coarse),
            3..5 => (SIXTEEN.as_slice(), coarse),
            2 => (SIXTEEN.as_slice(), 4 * coarse),
            ..2 => (SIXTEEN.as_slice(), 8 * coarse),
        };
        Sampling { frames: directions.iter().map(|&d| Frame::new(d)).collect(), side }
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self::standard()
    }
}

/// How the voxels of a level are looked at.
struct Sampling {
    frames: Vec<Frame>,
    /// Side of the square ray grid of each direction.
    side: usize,
}

/// Builds a texel from triangles, or from a kind that grows them or is a density, and keeps its source.
/// `progress` is told the fraction done, 0 to 1, from any thread.
///
/// Geometry without area in the texel gives an empty texel, in which every walk meets nothing. The result has
/// the same bits for any number of threads.
///
/// # Errors
/// Numbers out of their domain, with their field or triangle; geometry beyond 32-bit indices.
pub fn build(
    name: &str,
    source: impl Into<Source>,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Texel, BuildError> {
    build_exact(name, source, options, progress).map(Texel::compacted)
}

/// The same, with every level as it was measured: three times as large, to compare with.
///
/// # Errors
/// As [`build`].
pub fn build_exact(
    name: &str,
    source: impl Into<Source>,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Texel, BuildError> {
    build_source(name, source.into(), options, progress)
}

fn build_source(
    name: &str,
    source: Source,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Texel, BuildError> {
    options.validate()?;
    let content = source.sound_content()?;
    let material = content.material();
    progress(0.0);
    let texel = match content {
        Content::Triangles(geometry) => {
            let levels = levels_of_triangles(&geometry, options, progress)?;
            let mut texel = Texel::new(name, source, material, options.periodic, levels);
            openness::fill(&mut texel, 5, |l| Surfel::reach(0.5_f32.powi(l as i32)));
            texel
        }
        Content::Density(density) => {
            let levels = levels_of_density(&density, options, progress);
            let mut texel = Texel::new(name, source, material, options.periodic, levels);
            openness::fill(&mut texel, Scatterers::MAPPED + 1, Scatterers::reach);
            texel
        }
    };
    progress(1.0);
    Ok(texel)
}

/// Tells `progress` each hundredth of `total` cells.
fn in_percent(total: usize, progress: &(dyn Fn(f32) + Sync)) -> impl Fn(usize) + Sync {
    let done = AtomicUsize::new(0);
    let total = total.max(1);
    move |cells| {
        let before = done.fetch_add(cells, Ordering::Relaxed);
        let percent = |cells: usize| 100 * cells / total;
        if percent(before + cells) > percent(before) {
            progress((before + cells) as f32 / total as f32);
        }
    }
}

fn levels_of_triangles(
    geometry: &Geometry,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Vec<Level>, BuildError> {
    let facets = tile(&geometry.triangles, &geometry.colors, options.periodic);
    if u32::try_from(facets.len()).is_err() {
        return Err(BuildError::TooMany { what: "triangles", count: facets.len() });
    }
    let finest = Cells::new(&facets, 1 << options.depth);
    if u32::try_from(finest.entry_count()).is_err() {
        return Err(BuildError::TooMany { what: "triangles in cells", count: finest.entry_count() });
    }
    let mut lists = vec![finest];
    for above in 0..options.depth as usize {
        lists.push(lists[above].parents());
    }
    lists.reverse();
    let total = lists.iter().map(|cells| cells.codes().len()).sum::<usize>() + exposure::work(&lists);
    let report = in_percent(total, progress);
    let levels = (0..).zip(&lists).map(|(level, cells)| {
        let voxels = measure_level(&facets, cells, level, options, &report);
        Level::new(Bricks::new(1 << level, cells.codes()), voxels, options.periodic)
    });
    let mut levels: Vec<Level> = levels.collect();
    let grid = lists.iter().rposition(|cells| cells.facets_a_cell() >= FACETS_A_CELL).unwrap_or(0);
    let scene = Surroundings::new(&facets, &lists[grid], 1 << grid, options.periodic);
    let first_hit = |_, from, to| scene.first_hit(from, to);
    let sightlines = Sightline::of_all_slopes(SIGHTLINES, options.periodic, first_hit);
    for level in &mut levels {
        calibrate(level, &sightlines);
    }
    turn(&mut levels, options, first_hit);
    let shown = exposure::measure(&facets, &lists, &scene, options.points, &report);
    for (level, shown) in levels.iter_mut().zip(shown) {
        level.set_shown(shown);
    }
    Ok(levels)
}

fn levels_of_density(
    density: &Density,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Vec<Level> {
    let table = Table::new(density, options.periodic);
    let lists = measure::cells(&table, options.depth);
    let report = in_percent(lists.iter().map(Vec::len).sum(), progress);
    // How far light goes: of as many sightlines, depths as even as their places.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let first_hit = |i: usize, from, to| {
        let free = -(1.0 - (0.5 + GOLDEN * i as f64).fract()).ln();
        table.first_hit(from, to, free as f32)
    };
    let sightlines = Sightline::of_all_slopes(SIGHTLINES, options.periodic, first_hit);
    let levels = (0..).zip(&lists).map(|(l, codes)| {
        let Sampling { frames, side } = options.sampling(l);
        // A density changes evenly across fine voxels.
        let side = if l < 6 { side } else { side.min(4) };
        let voxels = measure::level(&table, codes, l, &frames, side, &report);
        let mut level = Level::new(Bricks::new(1 << l, codes), voxels, options.periodic);
        calibrate(&mut level, &sightlines);
        level.set_cloud(scatter::level(&table, codes, l, options.points));
        level
    });
    let mut levels: Vec<Level> = levels.collect();
    turn(&mut levels, options, first_hit);
    levels
}

/// Makes the depths of coarse levels right along each direction too. Where the texel ends, sightlines pass beside what a
/// voxel holds: that makes no holes in it.
fn turn(levels: &mut [Level], options: &BuildOptions, first_hit: impl Fn(usize, Vec3, Vec3) -> f32 + Sync) {
    if options.periodic {
        let count = SIGHTLINES_A_BEARING * options.points as usize;
        let sightlines = Sightline::of_all_bearings(count, true, first_hit);
        let coarse = levels.par_iter_mut().take(Bearings::LEVELS);
        coarse.for_each(|level| level.set_bearings(Some(Bearings::fit(level, &sightlines))));
    }
}

/// What measuring a voxel needs and the next voxel reuses.
#[derive(Default)]
struct Scratch {
    triangles: Vec<[Vec3; 3]>,
    colors: Vec<Vec3>,
    parts: Parts,
    view: View,
    sights: Vec<Sight>,
}

fn measure_level(
    facets: &[Facet],
    cells: &Cells,
    level: u32,
    options: &BuildOptions,
    report: &(dyn Fn(usize) + Sync),
) -> Vec<Packed> {
    let sampling = options.sampling(level);
    (0..cells.codes().len())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| {
            let scale = (1 << level) as f32;
            let corner = cells.cell(i).as_vec3();
            scratch.triangles.clear();
            scratch.colors.clear();
            for facet in cells.facets(i).map(|id| &facets[id]) {
                scratch.triangles.push(facet.corners.map(|p| p * scale - corner));
                scratch.colors.push(facet.color);
            }
            let voxel = measure_voxel(scratch, &sampling);
            report(1);
            Packed::new(&voxel)
        })
        .collect()
}

/// Measures the voxel whose triangles are in `scratch`, in its frame.
fn measure_voxel(scratch: &mut Scratch, sampling: &Sampling) -> Voxel {
    let Scratch { triangles, colors, parts, view, sights } = scratch;
    parts.clip(triangles);
    let Some(region) = Region::new(parts) else {
        return Voxel::clear();
    };
    sights.clear();
    let color = colors.first().copied().filter(|first| colors.iter().all(|color| color == first));
    let matter = Matter { region: &region, parts, triangles, colors, color };
    let mut voxel = Voxel {
        sigma: Symmetric3::ZERO,
        lo: region.lo,
        hi: region.hi,
        slab_normal: region.normal,
        slab: region.slab,
        albedo: Vec3::ZERO,
    };
    if region.is_planar() {
        // A plane covers the same fraction of its slab from everywhere.
        sights.extend(view.look_face_on(matter, sampling.side));
        if let Some(sight) = sights.first() {
            voxel.sigma = Symmetric3::outer(region.normal) * sight.sigma.powi(2);
        }
    } else {
        // A voxel of many triangles is worth sharing between threads; one of few is not.
        if triangles.len() > 2000 {
            let look = |view: &mut View, frame: &Frame| view.look(matter, *frame, sampling.side);
            let apart = sampling.frames.par_iter().map_init(View::default, look);
            sights.extend(apart.collect::<Vec<_>>().into_iter().flatten());
        } else {
            sights
                .extend(sampling.frames.iter().filter_map(|&frame| view.look(matter, frame, sampling.side)));
        }
        voxel.sigma = fit(sights);
    }
    let weight: f32 = sights.iter().map(|sight| sight.weight).sum();
    let sum: Vec3 = sights.iter().map(|sight| sight.color).sum();
    let mean = || colors.iter().sum::<Vec3>() / colors.len() as f32;
    let albedo = if weight > 0.0 { sum / weight } else { mean() };
    voxel.albedo = albedo.clamp(Vec3::ZERO, Vec3::ONE);
    voxel
}
