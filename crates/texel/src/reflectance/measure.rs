//! The reflectance of a voxel, summed over points of its surface.

use std::sync::LazyLock;

use glam::Vec3;

use super::brightness;
use super::facing::{FACINGS, Facing};
use super::nodes::{FIT, NODES, node};
use super::table::{Node, PAIRS, pair};
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
    pub(super) largest: f32,
    pub(super) table: Vec<u8>,
}

/// What is seen and lit from two nodes is at most the mean of what is from either, a geometric one; a little more where it is what
/// lies beside that counts.
const MOST_ALIKE: f32 = 1.5;

/// A fit rings by less than this far from where a point is seen: it is left out.
const NOTHING: f32 = 2e-3;

/// What is summed of the points that are seen from a node.
#[derive(Clone, Copy, Default)]
struct Sums {
    seen: f32,
    /// What is both seen and lit from there, as brightness.
    lit: f32,
    /// What is seen without what the fit takes from a node for another's sake.
    weight: f32,
    color: Vec3,
    normal: Vec3,
    sky: [(f32, Vec3); 2],
}

impl Measured {
    /// Of points.
    pub(crate) fn new(points: &[Point]) -> Self {
        let mut sums = [Sums::default(); NODES];
        let mut facings = [(Vec3::ZERO, 0.0); FACINGS];
        let mut table = vec![0.0_f32; PAIRS];
        let near_pairs = &*NEAR;
        for Point { surfel, weight } in points {
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
            let reached: Vec<usize> = (0..NODES).filter(|&a| seen[a] != 0.0 || near[a] != 0.0).collect();
            for (i, &a) in reached.iter().enumerate() {
                for &b in &reached[..=i] {
                    let entry = pair(a, b);
                    let both = seen_and_lit([seen[a], seen[b]], [near[a], near[b]], near_pairs[entry]);
                    table[entry] += bright * both;
                }
            }
            let sky = surfel.sky();
            let mut visible = 0.0;
            for (sums, seen) in sums.iter_mut().zip(seen) {
                sums.seen += weight * seen;
                sums.lit += bright * seen * seen;
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
        let most_lit = sums.iter().fold(f32::MIN_POSITIVE, |most, sums| most.max(sums.lit));
        let nodes = sums.map(|sums| Node::new(&sums, most, most_lit));
        let scales = nodes.map(|node| node.scale() * most_lit.sqrt());
        for a in 0..NODES {
            for b in 0..=a {
                let (entry, both) = (&mut table[pair(a, b)], scales[a] * scales[b]);
                *entry = if both > 0.0 { (entry.max(0.0) / both).min(MOST_ALIKE) } else { 0.0 };
            }
        }
        let largest = table.iter().fold(f32::MIN_POSITIVE, |largest, entry| largest.max(*entry));
        let root = |entry: &f32| (255.0 * (entry / largest).sqrt()).round() as u8;
        let table = table.iter().map(root).collect();
        Self { nodes, facings: Facing::all(&facings), largest: largest * most_lit / most, table }
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
fn seen_and_lit(seen: [f32; 2], near: [f32; 2], nearness: f32) -> f32 {
    let apart = seen[0] * seen[1];
    let beside = 0.5 * (seen[0] * near[1] + near[0] * seen[1]);
    apart + nearness * (beside - apart)
}

/// How much the nodes of each pair are so near to each other that one mask's cell may hold both, 0 to 1.
static NEAR: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let near = |a: Vec3, b: Vec3| {
        // A cell is some .25 wide, and what is interpolated spreads by a node or two.
        let x = (1.5 - (a - b).length() / 0.5).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    (0..NODES).flat_map(|a| (0..=a).map(move |b| near(node(a), node(b)))).collect()
});

impl Node {
    fn new(sums: &Sums, most: f32, most_lit: f32) -> Self {
        let Sums { seen, lit, weight, color, normal, sky } = *sums;
        if weight <= 0.0 {
            return Self::default();
        }
        let part = 1.0 / weight;
        let byte = |part: f32| (255.0 * part).round() as u8;
        let signed = |v: Vec3| v.to_array().map(|x| (127.0 * x).round() as i8);
        Self {
            root: byte((seen / most).max(0.0).sqrt()),
            scale: byte((lit / most_lit).sqrt().sqrt()),
            color: bytes((color * part).clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt)),
            normal: signed(normal * part),
            sky: sky.map(|(open, sum)| (byte(open * part), signed(sum * part))),
        }
    }
}
