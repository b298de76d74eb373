//! From geometry to a texel, every level measured from the geometry itself.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use crate::bricks::Bricks;
use crate::coverage::{ICOSAHEDRON, SIXTEEN, Sight, fit};
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
    /// Side of the square ray grids at levels above 6, from 6 directions.
    pub fine_rays: u32,
    /// Side of the square ray grids at levels 4 to 6, from 16 directions; twice that below.
    pub coarse_rays: u32,
}

impl BuildOptions {
    /// Depth 5, few rays: to look at content while it is being made.
    pub fn preview() -> Self {
        Self { depth: 5, periodic: true, fine_rays: 8, coarse_rays: 8 }
    }

    /// Depth 7 (128³).
    pub fn standard() -> Self {
        Self { depth: 7, periodic: true, fine_rays: 8, coarse_rays: 12 }
    }

    /// Depth 8 (256³), many rays.
    pub fn fine() -> Self {
        Self { depth: 8, periodic: true, fine_rays: 12, coarse_rays: 16 }
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

    /// Directions and side of the ray grids of a level.
    fn sampling(&self, level: u32) -> (&'static [Vec3], usize) {
        match level {
            7.. => (&ICOSAHEDRON, self.fine_rays as usize),
            4..7 => (&SIXTEEN, self.coarse_rays as usize),
            ..4 => (&SIXTEEN, 2 * self.coarse_rays as usize),
        }
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self::standard()
    }
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
    let clock0 = std::time::Instant::now();
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
    eprintln!("PROF vox {:?}", clock0.elapsed());
    let mut lists = vec![finest];
    for above in 0..options.depth as usize {
        lists.push(lists[above].parents());
    }
    lists.reverse();
    eprintln!("PROF lists {:?}", clock0.elapsed());
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
        let clock = std::time::Instant::now();
        let voxels = measure_level(&facets, cells, level, options, &report);
        eprintln!("PROF {level}: {:?} {} cells {} entries", clock.elapsed(), cells.codes().len(), cells.entry_count());
        Level::new(Bricks::new(1 << level, cells.codes()), voxels, options.periodic)
    });
    let texel = Texel::new(name, [geometry.specular, geometry.roughness], options.periodic, levels.collect());
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
}

fn measure_level(
    facets: &[Facet],
    cells: &Cells,
    level: u32,
    options: &BuildOptions,
    report: &(dyn Fn(usize) + Sync),
) -> Vec<Voxel> {
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
            let voxel = measure_voxel(scratch, options.sampling(level));
            report(1);
            voxel
        })
        .collect()
}

fn measure_voxel(scratch: &mut Scratch, (directions, side): (&'static [Vec3], usize)) -> Voxel {
    let Scratch { triangles, colors, parts, view } = scratch;
    let Some(region) = Region::new(triangles, parts) else {
        return Voxel::clear();
    };
    let look = |view: &mut View, &direction: &Vec3| {
        Sight::new(&mut view.raster, &mut view.lengths, &region, triangles, colors, direction, side)
    };
    // A voxel of many triangles is worth sharing between threads; one of few is not.
    let sights: Vec<Sight> = if triangles.len() > 2000 {
        let sights = directions.par_iter().map_init(View::default, |view, d| look(view, d));
        sights.flatten().collect()
    } else {
        directions.iter().filter_map(|d| look(view, d)).collect()
    };
    let seen: f32 = sights.iter().map(|sight| sight.weight).sum();
    let color: Vec3 = sights.iter().map(|sight| sight.color).sum();
    let albedo = if seen > 0.0 { color / seen } else { colors.iter().sum::<Vec3>() / colors.len() as f32 };
    Voxel {
        sigma: fit(&sights),
        lo: region.lo,
        hi: region.hi,
        slab_normal: region.normal,
        slab: region.slab,
        albedo: albedo.clamp(Vec3::ZERO, Vec3::ONE),
        kappa: 0.5,
        openness: 1.0,
    }
}
