//! From a density to voxels: which cells hold some of it, and, for each cell of each level, where it lies in it and
//! how much light passes it from each direction.

use glam::{UVec3, Vec3};
use pelage_geom::Symmetric3;
use rayon::prelude::*;

use super::table::Table;
use crate::Voxel;
use crate::bricks::demorton;
use crate::coverage::{Sight, extinction, fit};
use crate::grid::{Frame, Grid, larger};
use crate::packed::{Packed, snapped_box, snapped_slab};
use crate::region::Region;

/// Of each level down to `depth`, the Morton codes of the cells that hold something, ascending.
///
/// What would take less than 1/1000 of the light in the finest voxel is nothing.
pub(crate) fn cells(table: &Table, depth: u32) -> Vec<Vec<u32>> {
    const LEAST: f64 = 1e-3;
    let holds = |code: u32, level: u32| {
        let [lo, hi] = bounds(code, level);
        table.density.extinction_at(f64::from(table.highest(lo, hi))) * (0.5_f64).powi(depth as i32) > LEAST
    };
    let mut finest = vec![0];
    for level in 1..=depth {
        let children = finest.par_iter().flat_map_iter(|code| (8 * code)..(8 * code + 8));
        finest = children.filter(|&code| holds(code, level)).collect();
    }
    let mut levels = vec![finest];
    for level in 0..depth as usize {
        let mut parents: Vec<u32> = levels[level].iter().map(|code| code >> 3).collect();
        parents.dedup();
        levels.push(parents);
    }
    levels.reverse();
    levels
}

/// The box of a cell, in texel coordinates.
pub(crate) fn bounds(code: u32, level: u32) -> [Vec3; 2] {
    let edge = 1.0 / (1 << level) as f32;
    let lo = UVec3::from_array(demorton(code)).as_vec3() * edge;
    [lo, lo + edge]
}

/// What measuring a voxel reuses.
#[derive(Default)]
struct Scratch {
    heights: Vec<f32>,
    grid: Grid,
    lengths: Vec<f32>,
    ray: Vec<(f32, f32)>,
    sights: Vec<Sight>,
}

/// The voxels of a level, looked at along `frames` by about `side`² rays each.
pub(crate) fn level(
    table: &Table,
    codes: &[u32],
    level: u32,
    frames: &[Frame],
    side: usize,
    report: &(dyn Fn(usize) + Sync),
) -> Vec<Packed> {
    let measured = codes.par_iter().map_init(Scratch::default, |scratch, &code| {
        let [lo, hi] = bounds(code, level);
        let region = region(table, lo, hi.x - lo.x, &mut scratch.heights);
        let cell = Cell { lo, edge: hi.x - lo.x };
        let voxel = voxel(table, cell, &region, frames, side, scratch);
        report(1);
        Packed::new(&voxel)
    });
    measured.collect()
}

/// Where a voxel stands: its lower corner and its edge, in texel units.
#[derive(Clone, Copy)]
struct Cell {
    lo: Vec3,
    edge: f32,
}

/// The part of a cell in which there is something, in its frame: to a quarter of its edge, at coarse levels to a
/// thirty-second.
fn region(table: &Table, lo: Vec3, edge: f32, heights: &mut Vec<f32>) -> Region {
    let parts = ((table.resolution as f32 * edge) as usize).clamp(4, 32);
    let n = parts + 1;
    let point = |i: usize| Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32) / parts as f32;
    heights.clear();
    heights.extend((0..n * n * n).map(|i| table.height(lo + edge * point(i))));
    let none = -0.5 * table.density.softness() as f32;
    let [mut first, mut last] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    for (i, _) in heights.iter().enumerate().filter(|(_, height)| **height > none) {
        first = first.min(point(i));
        last = last.max(point(i));
    }
    // Between the points it may reach out to the next; where none is inside, anywhere.
    let margin = 1.0 / parts as f32;
    let found = first.x <= last.x;
    let [first, last] = if found { [first - margin, last + margin] } else { [Vec3::ZERO, Vec3::ONE] };
    let [lo, hi] = snapped_box(first.max(Vec3::ZERO), last.min(Vec3::ONE));
    Region { lo, hi, normal: Vec3::Z, slab: snapped_slab([lo.z, hi.z]) }
}

fn voxel(
    table: &Table,
    cell: Cell,
    region: &Region,
    frames: &[Frame],
    side: usize,
    scratch: &mut Scratch,
) -> Voxel {
    let mut sights = core::mem::take(&mut scratch.sights);
    sights.clear();
    sights.extend(frames.iter().filter_map(|&frame| look(table, cell, region, frame, side, scratch)));
    let weight: f32 = sights.iter().map(|sight| sight.weight).sum();
    let color: Vec3 = sights.iter().map(|sight| sight.color).sum();
    let albedo = if weight > 0.0 { color / weight } else { table.color(cell.lo + 0.5 * cell.edge) };
    let sigma = if sights.is_empty() { Symmetric3::ZERO } else { fit(&sights) };
    scratch.sights = sights;
    Voxel {
        sigma,
        lo: region.lo,
        hi: region.hi,
        slab_normal: region.normal,
        slab: region.slab,
        albedo: albedo.clamp(Vec3::ZERO, Vec3::ONE),
    }
}

/// Looks at a voxel along a direction: the extinction that lets as much light pass as the density does, and the colour
/// that is seen from both ends.
fn look(
    table: &Table,
    cell: Cell,
    region: &Region,
    frame: Frame,
    side: usize,
    scratch: &mut Scratch,
) -> Option<Sight> {
    let Scratch { grid, lengths, ray, .. } = scratch;
    grid.aim(region, frame, side);
    let (count, mean) = grid.lengths(lengths);
    if count == 0.0 {
        return None;
    }
    let (mut passed, mut seen, mut color) = (0.0, 0.0, Vec3::ZERO);
    let point = |i: usize, at: f32| cell.lo + cell.edge * grid.point(i / grid.columns, i % grid.columns, at);
    for (i, (&enter, &leave)) in grid.enter.iter().zip(&grid.leave).enumerate() {
        let length = leave - enter;
        if length <= 0.0 {
            continue;
        }
        let samples = larger((length * cell.edge * table.samples).ceil(), 2.0);
        let step = length / samples;
        ray.clear();
        let mut through = 1.0;
        for sample in 0..samples as u32 {
            let at = enter + step * (sample as f32 + 0.5);
            let depth = table.extinction(point(i, at)) * step * cell.edge;
            if depth > 0.0 {
                ray.push((at, (-depth).exp()));
                through *= (-depth).exp();
            }
        }
        passed += through;
        // What is seen from an end has the colour of where it lies on average.
        let mut look = |ray: &mut dyn Iterator<Item = &(f32, f32)>| {
            let (mut through, mut place) = (1.0, 0.0);
            for &(at, passing) in ray {
                place += through * (1.0 - passing) * at;
                through *= passing;
            }
            let stopped = 1.0 - through;
            if stopped > 0.0 {
                color += stopped * table.color(point(i, place / stopped));
                seen += stopped;
            }
        };
        look(&mut ray.iter());
        look(&mut ray.iter().rev());
    }
    let sigma = extinction(lengths, count, mean, (passed / count).max(1e-5));
    let footprint = 0.5 * grid.footprint();
    Some(Sight { direction: frame.direction, sigma, color: footprint * color, weight: footprint * seen })
}
