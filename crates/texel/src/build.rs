//! From geometry to a texel, every level measured from the geometry itself.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use crate::bricks::Bricks;
use crate::coverage::{ICOSAHEDRON, SIXTEEN, Sight, fit};
use crate::openness;
use crate::own_shadow::{Seen, kappa};
use crate::packed::Packed;
use crate::raster::Raster;
use crate::region::Region;
use crate::voxelise::{Cells, Facet, tile};
use crate::{BuildError, Geometry, Level, Texel, Voxel};

/// How a texel is built.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// The finest level, 1 to 9: `2^depth` voxels a side.
    pub depth: u32,
    /// Whether the content repeats in s and t.
    pub periodic: bool,
    /// Side of the square ray grids at levels 6 and above, from 6 directions.
    pub fine_rays: u32,
    /// Side of the square ray grids at levels 3 to 5 (from 6 directions at level 5, 16 below); eight times that
    /// below level 3, where there are few voxels.
    pub coarse_rays: u32,
}

impl BuildOptions {
    /// Depth 5 (32³): to look at content while it is being made.
    pub fn preview() -> Self {
        Self { depth: 5, periodic: true, fine_rays: 6, coarse_rays: 8 }
    }

    /// Depth 7 (128³).
    pub fn standard() -> Self {
        Self { depth: 7, periodic: true, fine_rays: 6, coarse_rays: 8 }
    }

    /// Depth 8 (256³), many rays.
    pub fn fine() -> Self {
        Self { depth: 8, periodic: true, fine_rays: 10, coarse_rays: 16 }
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
        Ok(())
    }

    /// How the voxels of a level are looked at.
    fn sampling(&self, level: u32) -> Sampling {
        let [fine, coarse] = [self.fine_rays, self.coarse_rays].map(|side| side as usize);
        match level {
            7.. => Sampling { directions: &ICOSAHEDRON, side: fine, points: 1 },
            6 => Sampling { directions: &ICOSAHEDRON, side: fine, points: 2 },
            5 => Sampling { directions: &ICOSAHEDRON, side: coarse, points: 3 },
            3..5 => Sampling { directions: &SIXTEEN, side: coarse, points: 4 },
            ..3 => Sampling { directions: &SIXTEEN, side: 8 * coarse, points: 8 },
        }
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self::standard()
    }
}

/// How the voxels of a level are looked at.
#[derive(Clone, Copy)]
struct Sampling {
    directions: &'static [Vec3],
    /// Side of the square ray grid of each direction.
    side: usize,
    /// Visible points kept from each direction, to measure the own shadow.
    points: usize,
}

/// Builds a texel. `progress` is told the fraction done, 0 to 1, from any thread.
///
/// Geometry without area in the texel gives an empty texel, in which every walk meets nothing. The result has
/// the same bits for any number of threads.
///
/// # Errors
/// Numbers out of their domain, with their field or triangle; geometry beyond 32-bit indices.
pub fn build(
    name: &str,
    geometry: &Geometry,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Texel, BuildError> {
    geometry.validate()?;
    options.validate()?;
    progress(0.0);
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
    let total = lists.iter().map(|cells| cells.codes().len()).sum::<usize>().max(1);
    let done = AtomicUsize::new(0);
    let report = |cells: usize| {
        let before = done.fetch_add(cells, Ordering::Relaxed);
        let percent = |cells: usize| 100 * cells / total;
        if percent(before + cells) > percent(before) {
            progress((before + cells) as f32 / total as f32);
        }
    };
    let levels = (0..).zip(&lists).map(|(level, cells)| {
        let voxels = measure_level(&facets, cells, level, options, &report);
        Level::new(Bricks::new(1 << level, cells.codes()), voxels, options.periodic)
    });
    let mut texel =
        Texel::new(name, [geometry.specular, geometry.roughness], options.periodic, levels.collect());
    openness::fill(&mut texel);
    progress(1.0);
    Ok(texel)
}

/// What looking along a direction needs.
#[derive(Default)]
struct View {
    raster: Raster,
    lengths: Vec<f32>,
}

/// What measuring a voxel needs and the next voxel reuses.
#[derive(Default)]
struct Scratch {
    triangles: Vec<[Vec3; 3]>,
    colors: Vec<Vec3>,
    parts: Vec<Vec3>,
    view: View,
    seen: Vec<Seen>,
}

fn measure_level(
    facets: &[Facet],
    cells: &Cells,
    level: u32,
    options: &BuildOptions,
    report: &(dyn Fn(usize) + Sync),
) -> Vec<Packed> {
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
            let seed = u64::from(level) << 32 | i as u64;
            let voxel = measure_voxel(scratch, options.sampling(level), scale.recip(), seed);
            report(1);
            Packed::new(&voxel)
        })
        .collect()
}

/// Measures the voxel of edge `edge` (texel units) whose triangles are in `scratch`, in its frame.
fn measure_voxel(scratch: &mut Scratch, sampling: Sampling, edge: f32, seed: u64) -> Voxel {
    let Sampling { directions, side, points } = sampling;
    let Scratch { triangles, colors, parts, view, seen } = scratch;
    let Some(region) = Region::new(triangles, parts) else {
        return Voxel::clear();
    };
    let look = |view: &mut View, &direction: &Vec3| {
        Sight::new(&mut view.raster, &mut view.lengths, &region, triangles, colors, direction, side, points)
    };
    // A voxel of many triangles is worth sharing between threads; one of few is not.
    let sights: Vec<Sight> = if triangles.len() > 2000 {
        let sights = directions.par_iter().map_init(View::default, |view, d| look(view, d));
        sights.flatten().collect()
    } else {
        directions.iter().filter_map(|d| look(view, d)).collect()
    };
    let weight: f32 = sights.iter().map(|sight| sight.weight).sum();
    let color: Vec3 = sights.iter().map(|sight| sight.color).sum();
    let albedo =
        if weight > 0.0 { color / weight } else { colors.iter().sum::<Vec3>() / colors.len() as f32 };
    let mut voxel = Voxel {
        sigma: fit(&sights),
        lo: region.lo,
        hi: region.hi,
        slab_normal: region.normal,
        slab: region.slab,
        albedo: albedo.clamp(Vec3::ZERO, Vec3::ONE),
        kappa: 0.0,
        openness: 1.0,
    };
    seen.clear();
    seen.extend(sights.iter().flat_map(|sight| &sight.points));
    voxel.kappa = kappa(&voxel, triangles, seen, edge, seed);
    voxel
}
