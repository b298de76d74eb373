//! What a coarse voxel reflects, tabulated: the light that it sends to any eye of that from any direction.
//!
//! Of a voxel that holds a whole tuft, hardly a tenth of the surface is seen from anywhere, and of that a part is lit: a
//! few hundred surfels leave some ten that matter, and a picture of noise; groups of them with one normal each lose the
//! light that this normal turns away from. So the coarsest levels keep the sums themselves. For points of weight w,
//! normal n, brightness c and mask M, and directions v to the eye and l to the light,
//!
//! ```text
//! S(v) = Σ w (n·v)⁺ M(v)                      what is seen
//! D(v, l) = Σ w c (n·v)⁺ M(v) (n·l)⁺ M(l)     what is seen and lit
//! ```
//!
//! and D / S is what is reflected. D takes either way alike. Both are kept at the [`nodes`] of a net of directions,
//! between which is interpolated, as the functions of that kind that come nearest to them. A highlight has a table like
//! D, in which each point counts by its (n·h)^m too.

mod facing;
mod measure;
mod nodes;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

pub(crate) use facing::{FACING_BYTES, FACINGS};
use facing::{Facing, Facings};
pub(crate) use measure::{Measured, Point};
pub(crate) use nodes::NODES;
use nodes::around;

use crate::packed::unit;

/// Pairs of nodes in any order, and each with itself.
const PAIRS: usize = NODES * (NODES + 1) / 2;

/// Where a pair stands in a table.
#[inline]
fn pair(a: usize, b: usize) -> usize {
    let (low, high) = (a.min(b), a.max(b));
    high * (high + 1) / 2 + low
}

/// Bytes of a voxel's tables.
pub(crate) fn table_bytes(glossy: bool) -> usize {
    if glossy { 2 * PAIRS } else { PAIRS }
}

/// The distance between unit vectors to the eye and to the light at which hardly more of what is seen is lit than of the rest.
const APART: f32 = 0.08;

/// How long the mean of unit normals is of a voxel whose normals begin to agree, and of one where they do.
const FACING_ALIKE: [f32; 2] = [0.9, 0.98];

/// What is known of a node: of what is seen from there, or lit. 15 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Node {
    /// The root of S, as a part of the voxel's largest.
    root: u8,
    /// Mean colour, square roots.
    color: [u8; 3],
    /// Mean normal, of any length up to 1.
    normal: [i8; 3],
    /// What is open of the hemispheres, above and below the surface that the texel stands on, and the mean of the open
    /// directions: as [`Surfel::sky`](crate::Surfel::sky).
    sky: [(u8, [i8; 3]); 2],
}

const NODE_BYTES: usize = 15;

/// The reflectances of a level's voxels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Reflectances {
    /// Whether there is a table of highlights too.
    glossy: bool,
    /// [`NODES`] of each voxel.
    nodes: Vec<Node>,
    /// Of each voxel.
    facings: Vec<Facings>,
    /// The largest entries of each voxel's tables.
    largest: Vec<[f32; 2]>,
    /// Of each voxel D over the roots of S at both nodes, as a part of the largest, square roots: [`PAIRS`]. Then the same of
    /// highlights.
    tables: Vec<u8>,
}

/// What a file holds: 8 bytes of the largest entries, then [`NODES`] nodes, [`FACINGS`] facings and
/// [`table_bytes`] of tables, all of each voxel.
pub(crate) struct Parts<L, N, F, T> {
    pub(crate) largest: L,
    pub(crate) nodes: N,
    pub(crate) facings: F,
    pub(crate) tables: T,
}

/// What a voxel of a coarse level shows to an eye.
#[derive(Clone, Debug)]
pub struct Reflectance<'a> {
    nodes: &'a [Node],
    facings: &'a Facings,
    largest: [f32; 2],
    /// Of D, and of highlights.
    tables: [&'a [u8]; 2],
    /// The nodes around the eye, and what the entries with them count for.
    entries: [(usize, f32); 4],
    /// The same nodes, and how near they are.
    nearest: [(usize, f32); 4],
    eye: Vec3,
    /// Mean linear albedo of what is seen.
    pub color: Vec3,
    /// Mean of its unit normals (texel space): the shorter, the less they agree.
    pub normal: Vec3,
    /// What nothing near blocks of the cosine-weighted hemispheres of what is seen, as [`Surfel::sky`](crate::Surfel::sky).
    pub sky: [(f32, Vec3); 2],
}

/// How much of a light a voxel reflects.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// The mean of albedo times cosine over what is seen; what is not lit counts as 0.
    pub diffuse: Vec3,
    /// The mean of cosine times (n·h)^m, h half-way between eye and light.
    pub gloss: f32,
}

impl Reflectances {
    pub(crate) fn new(glossy: bool, each: Vec<Measured>) -> Self {
        let mut all = Self { glossy, ..Self::default() };
        for Measured { nodes, facings, largest, tables } in each {
            all.nodes.extend(nodes);
            all.facings.push(Facings::new(facings));
            all.largest.push(largest);
            all.tables.extend(tables);
        }
        all
    }

    /// Whether the level has any.
    pub(crate) fn is_there(&self) -> bool {
        !self.nodes.is_empty()
    }

    /// What a voxel shows to the unit vector `eye` of texel space; `None` if nothing of it is seen from there, or if
    /// nothing is known of it.
    #[inline]
    pub(crate) fn of(&self, voxel: u32, eye: Vec3) -> Option<Reflectance<'_>> {
        let voxel = voxel as usize;
        let nodes = self.nodes.get(voxel * NODES..(voxel + 1) * NODES)?;
        let largest = *self.largest.get(voxel)?;
        let size = table_bytes(self.glossy);
        let tables = self.tables.get(voxel * size..(voxel + 1) * size)?.split_at(PAIRS);
        let nearest = around(eye);
        let (mut entries, mut whole) = (nearest, 0.0);
        for (node, weight) in &mut entries {
            let root = nodes[*node].root();
            *weight *= root;
            whole += *weight * root;
        }
        if whole == 0.0 {
            return None;
        }
        for (_, weight) in &mut entries {
            *weight /= whole;
        }
        let mut shown = Reflectance {
            nodes,
            facings: self.facings.get(voxel)?,
            largest,
            tables: tables.into(),
            entries,
            nearest,
            eye,
            color: Vec3::ZERO,
            normal: Vec3::ZERO,
            sky: Default::default(),
        };
        for (node, weight) in entries {
            let node = &nodes[node];
            let part = weight * node.root();
            shown.color += part * node.color();
            shown.normal += part * signed(node.normal);
            for (sum, (open, directions)) in shown.sky.iter_mut().zip(node.sky) {
                sum.0 += part * byte(open);
                sum.1 += part * signed(directions);
            }
        }
        Some(shown)
    }

    /// Whether they have tables of highlights.
    pub(crate) fn are_glossy(&self) -> bool {
        self.glossy
    }

    /// What a file holds of them.
    pub(crate) fn parts(
        &self,
    ) -> Parts<
        impl ExactSizeIterator<Item = [u8; 8]>,
        impl ExactSizeIterator<Item = [u8; NODE_BYTES]>,
        impl ExactSizeIterator<Item = [u8; FACING_BYTES]>,
        &[u8],
    > {
        let largest = self.largest.iter().map(|[diffuse, gloss]| {
            let ([a, b, c, d], [e, f, g, h]) = (diffuse.to_le_bytes(), gloss.to_le_bytes());
            [a, b, c, d, e, f, g, h]
        });
        let facings = (0..self.facings.len() * FACINGS)
            .map(|i| self.facings[i / FACINGS].all()[i % FACINGS].to_bytes());
        Parts { largest, nodes: self.nodes.iter().map(|node| node.to_bytes()), facings, tables: &self.tables }
    }

    /// From what [`parts`](Self::parts) gave, of as many voxels each; `None` if an entry is negative or no number.
    pub(crate) fn from_parts(
        glossy: bool,
        parts: Parts<
            impl Iterator<Item = [u8; 8]>,
            impl Iterator<Item = [u8; NODE_BYTES]>,
            impl Iterator<Item = [u8; FACING_BYTES]>,
            Vec<u8>,
        >,
    ) -> Option<Self> {
        let Parts { largest, nodes, facings, tables } = parts;
        let largest: Vec<[f32; 2]> = largest
            .map(|[a, b, c, d, e, f, g, h]| [[a, b, c, d], [e, f, g, h]].map(f32::from_le_bytes))
            .collect();
        let sound = largest.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
        let facings: Vec<Facing> = facings.map(Facing::from_bytes).collect();
        let facings = facings.as_chunks().0.into_par_iter().map(|facings| Facings::new(*facings));
        let nodes = nodes.map(Node::from_bytes);
        sound.then(|| Self { glossy, nodes: nodes.collect(), facings: facings.collect(), largest, tables })
    }

    pub(crate) fn memory(&self) -> usize {
        let nodes = size_of_val(&self.nodes[..]) + self.facings.iter().map(Facings::memory).sum::<usize>();
        nodes + size_of_val(&self.largest[..]) + self.tables.len()
    }
}

impl Reflectance<'_> {
    /// What is reflected of a light, by a voxel that is bent: `inverse` maps steps of the scene to steps of the texel, and a
    /// unit vector to the light to one `length` long in the direction of the unit vector `light`.
    ///
    /// Nothing stands between the light and what is seen where eye and light are in one direction. In a gap as wide as
    /// those between strands, a third as deep as the texel is high, the two have little to do with each other from a few
    /// degrees on: the tables are too coarse for that.
    #[inline]
    pub fn lit(&self, light: Vec3, inverse: &Mat3, length: f32) -> Lit {
        let nearest = around(light);
        let mut around = nearest;
        let (mut color, mut whole) = (Vec3::ZERO, 0.0);
        for (node, weight) in &mut around {
            let node = &self.nodes[*node];
            *weight *= node.root();
            let part = *weight * node.root();
            color += part * node.color();
            whole += part;
        }
        if whole == 0.0 {
            return Lit { diffuse: Vec3::ZERO, gloss: 0.0 };
        }
        let between = |table: &[u8]| -> f32 {
            let mut sum = 0.0;
            for (a, eye) in self.entries {
                for (b, light) in around {
                    let root = byte(table[pair(a, b)]);
                    sum += eye * light * root * root;
                }
            }
            sum
        };
        let [diffuse, gloss] = self.tables;
        let diffuse = self.largest[0] * between(diffuse);
        let gloss = if gloss.is_empty() { 0.0 } else { self.largest[1] * between(gloss) };
        // What is both seen and lit has about as much of either's colour.
        let color = 0.5 * (self.color + color / whole);
        let diffuse = color * (diffuse / brightness(color).max(f32::MIN_POSITIVE));
        // The more alike all of it faces, the better its normals say what nodes cannot.
        let bent = self.facings.bent(self.eye, light, inverse, length);
        let [least, most] = FACING_ALIKE;
        let known = ((self.normal.length() - least) / (most - least)).clamp(0.0, 1.0);
        let mut corrected = bent;
        if known > 0.0 {
            let both = [(self.eye, &self.nearest), (light, &nearest)];
            corrected += known * (self.facings.correction(both, inverse, length) - bent);
        }
        let alike = (-(self.eye - light).length() / APART).exp();
        let all = self.color * (self.normal.dot(light).max(0.0) * bent);
        Lit { diffuse: (corrected * diffuse).lerp(all, alike), gloss: corrected * gloss }
    }
}

/// What tables weigh colours by.
fn brightness(color: Vec3) -> f32 {
    color.element_sum() * (1.0 / 3.0)
}

impl Node {
    #[inline]
    fn root(&self) -> f32 {
        byte(self.root)
    }

    #[inline]
    fn color(&self) -> Vec3 {
        let root = unit(self.color);
        root * root
    }

    fn to_bytes(self) -> [u8; NODE_BYTES] {
        let Self { root, color: [r, g, b], normal: n, sky: [(above, up), (below, down)] } = self;
        let [[nx, ny, nz], [ux, uy, uz], [dx, dy, dz]] = [n, up, down].map(|v| v.map(|x| x as u8));
        [root, r, g, b, nx, ny, nz, above, ux, uy, uz, below, dx, dy, dz]
    }

    fn from_bytes(bytes: [u8; NODE_BYTES]) -> Self {
        let [root, r, g, b, nx, ny, nz, above, ux, uy, uz, below, dx, dy, dz] = bytes;
        let [normal, up, down] = [[nx, ny, nz], [ux, uy, uz], [dx, dy, dz]].map(|v| v.map(|x| x as i8));
        Self { root, color: [r, g, b], normal, sky: [(above, up), (below, down)] }
    }
}

/// A byte as a number in `[0, 1]`.
#[inline]
fn byte(byte: u8) -> f32 {
    f32::from(byte) * (1.0 / 255.0)
}

/// Bytes as numbers in `[−1, 1]`.
#[inline]
fn signed([x, y, z]: [i8; 3]) -> Vec3 {
    Vec3::new(x.into(), y.into(), z.into()) * (1.0 / 127.0)
}

#[cfg(test)]
mod tests {
    use super::nodes::node;
    use super::*;
    use crate::Surfel;
    use crate::random::Random;

    fn of(points: &[Point], exponent: Option<f32>) -> Reflectances {
        Reflectances::new(exponent.is_some(), vec![Measured::new(points, exponent)])
    }

    #[test]
    fn an_open_plane_reflects_the_cosine() {
        // Of white: the cosine to the light itself, and nothing of light from behind. Facings make up for what a cosine is off
        // between nodes; a byte a number leaves some hundredths.
        let random = &mut Random::new(8, 0);
        let mut direction =
            || Vec3::new(random.signed(), random.signed(), random.signed()).normalize_or(Vec3::X);
        for _ in 0..50 {
            let surfel = Surfel::new(direction(), Vec3::ONE, 1.0, u64::MAX);
            let normal = surfel.normal();
            let all = of(&[Point { surfel, weight: 2.0 }], None);
            for _ in 0..20 {
                let [eye, light] = [(); 2].map(|()| direction());
                let Some(shown) = all.of(0, eye).filter(|_| normal.dot(eye) > 0.1) else { continue };
                assert!((shown.color - 1.0).length() < 1e-6 && (shown.normal - normal).length() < 0.01);
                let lit = shown.lit(light, &Mat3::IDENTITY, 1.0);
                let cosine = normal.dot(light).max(0.0);
                assert!((lit.diffuse.x - cosine).abs() < 0.04, "{normal} {eye} {light} {lit:?} {cosine}");
                assert_eq!(lit.gloss, 0.0);
            }
        }
    }

    #[test]
    fn two_sides_of_a_wall_know_of_their_own_light() {
        // A wall, red to the left and blue to the right: who sees the red side sees no light of the right.
        let side = |normal, color| Point { surfel: Surfel::new(normal, color, 1.0, u64::MAX), weight: 1.0 };
        let all = of(&[side(Vec3::X, Vec3::X), side(-Vec3::X, Vec3::Z)], None);
        let (left, right) = (Vec3::new(0.8, 0.1, 0.6).normalize(), Vec3::new(-0.8, 0.2, 0.5).normalize());
        let shown = all.of(0, left).expect("it is seen");
        assert!((shown.color - Vec3::X).length() < 0.01);
        assert!(shown.lit(right, &Mat3::IDENTITY, 1.0).diffuse.length() < 0.01);
        let lit = shown.lit(Vec3::new(0.8, -0.5, 0.3).normalize(), &Mat3::IDENTITY, 1.0).diffuse;
        assert!((lit.x - 0.808).abs() < 0.06 && lit.z < 0.02, "{lit}");
    }

    #[test]
    fn a_highlight_is_where_the_light_is_mirrored() {
        // Light along the mirrored way: h = n, and cosine · 1 is reflected; elsewhere (n·h)^m of it, with m = 20.
        let floor = Point { surfel: Surfel::new(Vec3::Z, Vec3::ONE, 1.0, u64::MAX), weight: 1.0 };
        let all = of(&[floor], Some(20.0));
        let (mut sums, mut exact) = (0.0, 0.0);
        for (a, b) in (0..NODES / 2).flat_map(|a| (0..NODES / 2).map(move |b| (node(a), node(b)))) {
            sums += all.of(0, a).expect("it is seen").lit(b, &Mat3::IDENTITY, 1.0).gloss;
            exact += b.z * (a + b).normalize().z.powi(20);
        }
        assert!((sums / exact - 1.0).abs() < 0.02, "{sums} {exact}");
    }

    #[test]
    fn bytes_return() {
        let random = &mut Random::new(9, 0);
        let mut point = || {
            let normal = Vec3::new(random.signed(), random.signed(), random.signed()).normalize_or(Vec3::X);
            let open = (random.unit() * 4e9) as u64 * 0x1_0000_0001;
            Point { surfel: Surfel::new(normal, Vec3::splat(random.unit()), 1.0, open), weight: 1.0 }
        };
        let points: Vec<Point> = (0..20).map(|_| point()).collect();
        let all = of(&points, Some(12.0));
        let Parts { largest, nodes, facings, tables } = all.parts();
        let parts = Parts { largest, nodes, facings, tables: tables.to_vec() };
        assert_eq!(Reflectances::from_parts(true, parts).as_ref(), Some(&all));
        let Parts { nodes, facings, tables, .. } = all.parts();
        let largest = [(-1.0_f32).to_le_bytes(), [0; 4]].concat().try_into().into_iter();
        let parts = Parts { largest, nodes, facings, tables: tables.to_vec() };
        assert!(Reflectances::from_parts(true, parts).is_none());
    }
}
