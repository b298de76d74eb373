//! What each voxel of a density sends back: its scatterers, and at coarse levels what reaches them.

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::measure::bounds;
use super::table::Table;
use crate::bricks::morton;
use crate::coverage::ICOSAHEDRON;
use crate::random::Random;
use crate::scatterer::{Cloud, Scatterer, Scatterers, directions};

/// A level's points.
#[derive(Clone, Copy)]
struct Sampling {
    /// Places looked at, along each edge of a voxel.
    side: usize,
    /// Points tried, chosen by the extinction there.
    tried: usize,
    /// Points looked around from, chosen by how much light reaches them from a few directions.
    mapped: usize,
    /// Points kept, chosen by how much does from all.
    kept: usize,
}

impl Sampling {
    /// Of a level, where level 0 is given 32 times `points`, and each level a quarter of the one before, down to a few.
    fn of(level: u32, points: u32) -> Self {
        let [side, least] = match level {
            0 => [32, 64],
            1 => [24, 64],
            2 => [16, 48],
            3 => [8, 24],
            4 => [6, 8],
            5 => [5, 4],
            6 => [4, 4],
            7 => [3, 2],
            _ => [2, 1],
        };
        let kept = ((32 * points as usize) >> (2 * level).min(31)).max(least);
        // What is dense is dark inside: hardly any of its points are seen.
        let [tried, mapped] = if level <= Scatterers::MAPPED { [32 * kept, 2 * kept] } else { [kept; 2] };
        Self { side, tried, mapped, kept }
    }
}

/// The scatterers of a level's voxels.
pub(crate) fn level(table: &Table, codes: &[u32], level: u32, points: u32) -> Cloud {
    let sampling = Sampling::of(level, points);
    let around: Vec<Vec3> =
        directions(Scatterers::side(level)).map(|d| d * Scatterers::reach(level)).collect();
    let each = codes.par_iter().map(|&code| {
        let random = &mut Random::new(u64::from(level) << 32 | u64::from(code), 0x5ca7);
        let points = tried(table, bounds(code, level), sampling, random);
        let scatterer = |p: Vec3, weight| Scatterer::new(table.normal(p.as_dvec3()), table.color(p), weight);
        if Scatterers::side(level) == 0 {
            return (points.into_iter().map(|p| scatterer(p, 1.0)).collect(), Vec::new());
        }
        let first: Vec<Vec3> =
            ICOSAHEDRON.iter().flat_map(|d| [-d, *d]).map(|d| d * Scatterers::reach(level)).collect();
        let open = |from: Vec3, steps: &[Vec3]| -> f32 {
            steps.iter().map(|&step| table.transmittance(from, step)).sum::<f32>() / steps.len() as f32
        };
        let tried = points.iter().map(|&p| (1.0, open(p, &first)));
        let mapped = thinned(tried, sampling.mapped, random);
        let maps: Vec<Vec<u8>> = mapped.iter().map(|&(i, _)| map(table, points[i], &around)).collect();
        let mean =
            |map: &[u8]| map.iter().map(|&byte| f32::from(byte)).sum::<f32>() / (255.0 * map.len() as f32);
        let weighed = mapped.iter().zip(&maps).map(|((_, weight), map)| (*weight, mean(map)));
        let kept = thinned(weighed, sampling.kept, random);
        let heaviest = kept.iter().fold(f32::MIN_POSITIVE, |most, &(_, weight)| most.max(weight));
        let maps = kept.iter().flat_map(|&(i, _)| maps[i].iter().copied()).collect();
        (
            kept.into_iter().map(|(i, weight)| scatterer(points[mapped[i].0], weight / heaviest)).collect(),
            maps,
        )
    });
    Cloud::new(each.collect(), Scatterers::side(level))
}

/// Points of a box by the extinction there; none where there is none.
fn tried(table: &Table, [lo, hi]: [Vec3; 2], sampling: Sampling, random: &mut Random) -> Vec<Vec3> {
    let Sampling { side, tried, .. } = sampling;
    let mut sum = 0.0;
    // Those near each other after each other: any few of them are spread over the box.
    let mut cells: Vec<[u32; 3]> =
        (0..side.pow(3)).map(|i| [i % side, i / side % side, i / side / side].map(|c| c as u32)).collect();
    cells.sort_unstable_by_key(|&cell| morton(cell));
    let places: Vec<(Vec3, f32)> = cells
        .into_iter()
        .map(|cell| {
            let cell = UVec3::from_array(cell).as_vec3();
            let within = Vec3::new(random.unit(), random.unit(), random.unit());
            let p = lo + (hi - lo) * (cell + within) / side as f32;
            sum += table.extinction(p);
            (p, sum)
        })
        .collect();
    if sum <= 0.0 {
        return Vec::new();
    }
    let chosen = (0..tried).map(|i| {
        let wanted = sum * (i as f32 + random.unit()) / tried as f32;
        let place = places.partition_point(|place| place.1 <= wanted);
        places[place.min(places.len() - 1)].0
    });
    chosen.collect()
}

/// What passes from a point to the ends of the steps `around` it.
fn map(table: &Table, from: Vec3, around: &[Vec3]) -> Vec<u8> {
    around.iter().map(|&step| (255.0 * table.transmittance(from, step)).round() as u8).collect()
}

/// At most `most` of some points, of each of which is told what it stands for and how much light reaches it: those that more
/// does rather, and what each stands for then. Evenly spread along the order in which they are given.
fn thinned(points: impl Iterator<Item = (f32, f32)>, most: usize, random: &mut Random) -> Vec<(usize, f32)> {
    // Those in the dark are not so rare that one of them would count for very many.
    const DARK: f32 = 0.02;
    let points: Vec<(f32, f32)> = points.map(|(weight, open)| (weight, open + DARK)).collect();
    let whole: f32 = points.iter().map(|(weight, share)| weight * share).sum();
    let step = whole / most.min(points.len()) as f32;
    let mut next = step * random.unit();
    let mut sum = 0.0;
    let mut kept = Vec::with_capacity(most);
    for (i, (weight, share)) in points.into_iter().enumerate() {
        let mut times = 0.0;
        sum += weight * share;
        while next < sum {
            next += step;
            times += 1.0;
        }
        if times > 0.0 {
            kept.push((i, times / share));
        }
    }
    kept
}
