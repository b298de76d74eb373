//! The reflectance of a voxel, summed over points of its surface.

use std::sync::LazyLock;

use glam::Vec3;

use super::facing::{FACINGS, Facing};
use super::nodes::{FIT, NODES, node};
use super::{Node, PAIRS, brightness, pair};
use crate::packed::bytes;
use crate::surfel::{Surfel, on_disk};

/// A point of the surface as a level sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) surfel: Surfel,
    /// The surface that it stands for, in any unit.
    pub(crate) weight: f32,
}

/// The reflectance of one voxel.
pub(crate) struct Measured {
    pub(super) nodes: [Node; NODES],
    pub(super) facings: [Facing; FACINGS],
    pub(super) largest: [f32; 2],
    pub(super) tables: Vec<u8>,
}

/// About so many points are asked for their highlight, which takes longer than all else.
const HIGHLIGHTS: usize = 800;

/// What is summed of the points that are seen from a node.
#[derive(Clone, Copy, Default)]
struct Sums {
    seen: f32,
    /// The same without what the fit takes from a node for another's sake.
    weight: f32,
    color: Vec3,
    normal: Vec3,
    sky: [(f32, Vec3); 2],
}

impl Measured {
    /// Of points, and the exponent of their highlight if they have one.
    pub(crate) fn new(points: &[Point], exponent: Option<f32>) -> Self {
        let mut sums = [Sums::default(); NODES];
        let mut facings = [(Vec3::ZERO, 0.0); FACINGS];
        let mut tables = vec![vec![0.0_f32; PAIRS]; if exponent.is_some() { 2 } else { 1 }];
        let mut both = vec![0.0_f32; PAIRS];
        let step = points.len() / HIGHLIGHTS + 1;
        for (i, Point { surfel, weight }) in points.iter().enumerate() {
            let (normal, color) = (surfel.normal(), surfel.color());
            let open = |d: Vec3| if surfel.sees(d) { normal.dot(d) } else { 0.0 };
            let seen = FIT.of(open);
            let around = surfel.open_around();
            let near = |d: Vec3| match normal.dot(d) {
                cosine if cosine > 0.0 => cosine * around[Surfel::cell(on_disk(normal, d))],
                _ => 0.0,
            };
            seen_and_lit(&seen, &FIT.of(near), &mut both);
            let bright = weight * brightness(color);
            tables[0].iter_mut().zip(&both).for_each(|(sum, both)| *sum += bright * both);
            if let (Some(exponent), Some(table), 0) = (exponent, tables.get_mut(1), i % step) {
                let weight = weight * step as f32;
                for ((sum, both), pair) in table.iter_mut().zip(&both).zip(PAIR.iter()) {
                    if *both != 0.0 {
                        *sum += weight * both * normal.dot(pair.half).max(0.0).powf(exponent);
                    }
                }
            }
            let sky = surfel.sky();
            let mut visible = 0.0;
            for (sums, seen) in sums.iter_mut().zip(seen) {
                sums.seen += weight * seen;
                let weight = weight * seen.max(0.0);
                visible += weight;
                sums.weight += weight;
                sums.color += weight * color;
                sums.normal += weight * normal;
                for (sum, (open, directions)) in sums.sky.iter_mut().zip(sky) {
                    sum.0 += weight * open;
                    sum.1 += weight * directions;
                }
            }
            let (sum, weight) = &mut facings[Facing::number(normal)];
            *sum += visible * normal;
            *weight += visible;
        }
        let most = sums.iter().fold(f32::MIN_POSITIVE, |most, sums| most.max(sums.seen));
        let nodes = sums.map(|sums| Node::new(&sums, most));
        let roots = nodes.map(|node| node.root() * most.sqrt());
        let mut largest = [0.0; 2];
        let mut packed = Vec::with_capacity(PAIRS * tables.len());
        for (table, largest) in tables.iter_mut().zip(&mut largest) {
            for a in 0..NODES {
                for b in 0..=a {
                    let entry = &mut table[pair(a, b)];
                    let both = roots[a] * roots[b];
                    *entry = if both > 0.0 { entry.max(0.0) / both } else { 0.0 };
                    *largest = f32::max(*largest, *entry);
                }
            }
            let whole = largest.max(f32::MIN_POSITIVE);
            packed.extend(table.iter().map(|entry| (255.0 * (entry / whole).sqrt()).round() as u8));
        }
        Self { nodes, facings: Facing::all(&facings), largest, tables: packed }
    }
}

/// How much of a point is seen from one node and lit from the other, of each pair, where `seen` is seen from each alone and `near`
/// is open just beside.
///
/// From two directions that are nearer to each other than the width of a mask's cell, a point is open or not alike: more alike than it is,
/// for a gap may be narrower. There what lies beside counts for one of the two; where they are one and the same, [`Reflectance`] knows
/// better anyway.
///
/// [`Reflectance`]: super::Reflectance
fn seen_and_lit(seen: &[f32; NODES], near: &[f32; NODES], both: &mut [f32]) {
    let mut rows = both;
    let mut pairs = &PAIR[..];
    for a in 0..NODES {
        let (row, next) = rows.split_at_mut(a + 1);
        let (of_row, others) = pairs.split_at(a + 1);
        for (((both, pair), seen_b), near_b) in row.iter_mut().zip(of_row).zip(seen).zip(near) {
            let apart = seen[a] * seen_b;
            let beside = 0.5 * (seen[a] * near_b + near[a] * seen_b);
            *both = apart + pair.near * (beside - apart);
        }
        (rows, pairs) = (next, others);
    }
}

/// What is known of a pair of nodes.
struct Pair {
    /// Half-way between them.
    half: Vec3,
    /// How much they are so near to each other that one mask's cell may hold both, 0 to 1.
    near: f32,
}

static PAIR: LazyLock<Vec<Pair>> = LazyLock::new(|| {
    let pair = |a: Vec3, b: Vec3| {
        // A cell is some .25 wide, and what is interpolated spreads by a node or two.
        let x = (1.5 - (a - b).length() / 0.5).clamp(0.0, 1.0);
        Pair { half: (a + b).normalize_or_zero(), near: x * x * (3.0 - 2.0 * x) }
    };
    (0..NODES).flat_map(|a| (0..=a).map(move |b| pair(node(a), node(b)))).collect()
});

impl Node {
    fn new(sums: &Sums, most: f32) -> Self {
        let Sums { seen, weight, color, normal, sky } = *sums;
        if seen <= 0.0 || weight <= 0.0 {
            return Self::default();
        }
        let part = 1.0 / weight;
        let byte = |part: f32| (255.0 * part).round() as u8;
        let signed = |v: Vec3| v.to_array().map(|x| (127.0 * x).round() as i8);
        Self {
            root: byte((seen / most).sqrt()),
            color: bytes((color * part).clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt)),
            normal: signed(normal * part),
            sky: sky.map(|(open, sum)| (byte(open * part), signed(sum * part))),
        }
    }
}
