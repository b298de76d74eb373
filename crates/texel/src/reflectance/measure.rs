//! The reflectance of a voxel, summed over points of its surface.

use std::sync::LazyLock;

use glam::Vec3;

use super::facing::{FACINGS, Facing};
use super::nodes::{FIT, NODES, node};
use super::{Node, PAIRS, brightness, pair};
use crate::packed::bytes;
use crate::surfel::{Surfel, axes, place};

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

/// A fit rings by less than this far from where a point is seen: it is left out.
const NOTHING: f32 = 2e-3;

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
        let (pairs, step) = (&*PAIR, points.len() / HIGHLIGHTS + 1);
        for (i, Point { surfel, weight }) in points.iter().enumerate() {
            let (normal, color) = (surfel.normal(), surfel.color());
            let around = surfel.open_around();
            let axes = axes(normal);
            let [mut seen, mut near] = FIT.of_each(|d| {
                let cosine = normal.dot(d);
                if cosine <= 0.0 {
                    return [0.0; 2];
                }
                let cell = Surfel::cell(place(&axes, d));
                [if surfel.mask() >> cell & 1 != 0 { cosine } else { 0.0 }, cosine * around[cell]]
            });
            seen.iter_mut().chain(&mut near).filter(|x| x.abs() < NOTHING).for_each(|x| *x = 0.0);
            let bright = weight * brightness(color);
            let highlight = exponent.filter(|_| i % step == 0).map(|m| (m, weight * step as f32));
            let reached: Vec<usize> = (0..NODES).filter(|&a| seen[a] != 0.0 || near[a] != 0.0).collect();
            for (i, &a) in reached.iter().enumerate() {
                for &b in &reached[..=i] {
                    let entry = pair(a, b);
                    let both = seen_and_lit([seen[a], seen[b]], [near[a], near[b]], &pairs[entry]);
                    tables[0][entry] += bright * both;
                    if let (Some((exponent, weight)), Some(table)) = (highlight, tables.get_mut(1)) {
                        let peak = normal.dot(pairs[entry].half).max(0.0).powf(exponent);
                        table[entry] += weight * both * peak;
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

/// How much of a point is seen from one node of a pair and lit from the other, where `seen` is seen from each alone and `near` is
/// open just beside.
///
/// From two directions that are nearer to each other than a mask's cell is wide, a point is open or not alike: too often, for a
/// gap may be narrower. There what lies beside counts for one of the two; where they are one and the same, [`Reflectance`] knows
/// better anyway.
///
/// [`Reflectance`]: super::Reflectance
#[inline]
fn seen_and_lit(seen: [f32; 2], near: [f32; 2], pair: &Pair) -> f32 {
    let apart = seen[0] * seen[1];
    let beside = 0.5 * (seen[0] * near[1] + near[0] * seen[1]);
    apart + pair.near * (beside - apart)
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
