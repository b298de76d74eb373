//! What a coarse voxel reflects, tabulated: the light that it sends to any eye of that from any direction.
//!
//! Of a voxel that holds a whole tuft, hardly a tenth of the surface is seen from anywhere, and of that a part is lit: a
//! few hundred surfels leave some ten that matter, and a picture of noise; groups of them with one normal each lose the
//! light that this normal turns away from. So the coarsest levels keep the sums themselves. For points of weight w,
//! normal n, mask M and brightness c, and directions v to the eye and l to the light,
//!
//! ```text
//! S(v) = Σ w (n·v)⁺ M(v)                      what is seen
//! D(v, l) = Σ w c (n·v)⁺ M(v) (n·l)⁺ M(l)     what is seen and lit
//! ```
//!
//! and D / S is what is reflected. D takes either way alike. Both are kept at the [`nodes`] of a net of directions,
//! between which is interpolated. M is asked of the geometry itself, by [rays](outlook) towards the cells of that net. What
//! nodes are too far apart for, highlights for one, is told by how the surface [faces](facing).

mod facing;
mod measure;
mod nodes;
mod outlook;
mod table;

use glam::{Mat3, Vec3};

pub(crate) use facing::FACINGS;
use facing::Facings;
pub(crate) use measure::{Measured, Tally};
use nodes::aside;
pub(crate) use nodes::{NODES, UPPER, around, direction_above};
pub(crate) use outlook::{Outlook, TABLED};
use table::{Node, byte, pair};
pub(crate) use table::{PAIRS, Parts, Reflectances};

/// The distance between unit vectors to the eye and to the light at which hardly more of what is seen is lit than of the rest.
const APART: f32 = 0.05;

/// How far apart unit vectors to the eye and to the light are up to which nodes are taken as far apart as they, and from which on each
/// for itself.
const BESIDE: [f32; 2] = [0.4, 0.8];

/// How long the mean of unit normals is of a voxel whose normals begin to agree, and of one where they do.
const FACING_ALIKE: [f32; 2] = [0.9, 0.98];

/// What a voxel of a coarse level shows to an eye.
#[derive(Clone, Debug)]
pub struct Reflectance<'a> {
    nodes: &'a [Node],
    facings: &'a Facings,
    largest: f32,
    table: &'a [u8],
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

/// How a voxel is bent, for one light. A normal n of texel space becomes J⁻ᵀn, and its cosine to a light in the direction L of the
/// scene (n·l) |J⁻¹L| / |J⁻ᵀn|, where l is the direction of J⁻¹L.
#[derive(Clone, Copy, Debug)]
pub struct Bend {
    /// J⁻¹: from steps in the scene to steps in the texel.
    pub inverse: Mat3,
    /// |J⁻¹L|, of the unit vector L to the light, scene space.
    pub length: f32,
    /// Of a highlight: the unit vector half-way between those to the eye and to the light, scene space, and the exponent m.
    pub highlight: Option<(Vec3, f32)>,
}

/// How much of a light a voxel reflects.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// The mean of albedo times cosine over what is seen; what is not lit counts as 0.
    pub diffuse: Vec3,
    /// The mean of cosine times (n·h)^m, h half-way between eye and light.
    pub gloss: f32,
}

impl Reflectance<'_> {
    /// What is reflected of a light in the direction `light`, a unit vector of texel space.
    ///
    /// Nothing stands between the light and what is seen where eye and light are in one direction. In a gap as wide as
    /// those between strands, a third as deep as the texel is high, the two have little to do with each other from a few
    /// degrees on: the tables are too coarse for that.
    #[inline]
    pub fn lit(&self, light: Vec3, bend: &Bend) -> Lit {
        let nearest = around(light);
        let mut around = nearest;
        let (mut color, mut whole) = (Vec3::ZERO, 0.0);
        for (node, weight) in &mut around {
            let node = &self.nodes[*node];
            let part = *weight * node.root().powi(2);
            *weight *= node.scale();
            color += part * node.color();
            whole += part;
        }
        if whole == 0.0 {
            return Lit { diffuse: Vec3::ZERO, gloss: 0.0 };
        }
        let known = faces_alike(self.normal);
        let entry = |a: usize, b: usize| {
            let root = byte(self.table[pair(a, b)]);
            self.largest * root * root
        };
        let mut diffuse = 0.0;
        for (a, eye) in self.entries {
            diffuse += around.iter().map(|(b, light)| eye * light * entry(a, *b)).sum::<f32>();
        }
        // Near the eye D varies with how far the light is from it far more than with where both are.
        let [from, to] = BESIDE;
        let beside = ((to - (self.eye - light).length()) / (to - from)).clamp(0.0, 1.0) * (1.0 - known);
        if let Some(each) = aside(self.eye, light).filter(|_| beside > 0.0) {
            let mut sum = 0.0;
            for ((a, eye), around) in self.entries.iter().zip(each) {
                let of = |(b, light): (usize, f32)| eye * light * self.nodes[b].scale() * entry(*a, b);
                sum += around.map(of).iter().sum::<f32>();
            }
            diffuse += beside * (sum - diffuse);
        }
        // What is both seen and lit has about as much of either's colour.
        let color = 0.5 * (self.color + color / whole);
        let white = diffuse / brightness(color);
        let [mut bent, mut highlight] = self.facings.bent(self.eye, light, bend);
        let all = self.color * (self.normal.dot(light).max(0.0) * bent);
        // The more alike all of it faces, the better its normals say what nodes cannot.
        if known > 0.0 {
            let both = [(self.eye, &self.nearest), (light, &nearest)];
            let exact = self.facings.correction(both, bend);
            highlight *= 1.0 + known * (exact / bent - 1.0);
            bent += known * (exact - bent);
        }
        let alike = (-(self.eye - light).length() / APART).exp();
        Lit { diffuse: (color * (bent * white)).lerp(all, alike), gloss: highlight * white }
    }
}

/// How much the normals agree whose mean this is, 0 to 1.
fn faces_alike(normal: Vec3) -> f32 {
    let [least, most] = FACING_ALIKE;
    ((normal.length() - least) / (most - least)).clamp(0.0, 1.0)
}

/// What tables weigh points by: their brightness, that of what is seen and lit as a rule being greater. Black ones too have to be
/// known, for their highlights.
fn brightness(color: Vec3) -> f32 {
    const OF_BLACK: f32 = 0.02;
    OF_BLACK + color.element_sum() * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn of<'a>(points: impl IntoIterator<Item = &'a Outlook>) -> Reflectances {
        let mut tally = Tally::new();
        points.into_iter().for_each(|point| tally.add(0, point));
        Reflectances::new(vec![tally.measured()])
    }

    /// White points that nothing blocks, alike but for their directions.
    fn open(normal: Vec3, count: usize, random: &mut Random) -> Vec<Outlook> {
        (0..count)
            .filter_map(|_| Outlook::new(normal, Vec3::ONE, 1.0, random, |_, _| f32::INFINITY))
            .collect()
    }

    /// As it is.
    fn straight(eye: Vec3, light: Vec3, exponent: f32) -> Bend {
        Bend { inverse: Mat3::IDENTITY, length: 1.0, highlight: Some(((eye + light).normalize(), exponent)) }
    }

    #[test]
    fn an_open_plane_reflects_the_cosine() {
        // Of white: the cosine to the light itself, nothing of light from behind, and a highlight of (n·h)^20. Facings make up for what a cosine is off
        // between nodes; a byte a number leaves some hundredths.
        let random = &mut Random::new(8, 0);
        for _ in 0..50 {
            let normal = random.direction();
            let all = of(&open(normal, 200, random));
            for _ in 0..20 {
                let [eye, light] = [(); 2].map(|()| random.direction());
                let Some(shown) = all.of(0, eye).filter(|_| normal.dot(eye) > 0.1) else { continue };
                assert!((shown.color - 1.0).length() < 1e-6 && (shown.normal - normal).length() < 0.01);
                let lit = shown.lit(light, &straight(eye, light, 20.0));
                let cosine = normal.dot(light).max(0.0);
                // Below the horizon there are fewer nodes.
                let most = if eye.z.min(light.z) < 0.0 { 0.07 } else { 0.03 };
                assert!((lit.diffuse.x - cosine).abs() < most, "{normal} {eye} {light} {lit:?} {cosine}");
                let peak = normal.dot((eye + light).normalize()).max(0.0).powi(20);
                let off = lit.gloss - cosine * peak;
                assert!(off.abs() < most + 0.01, "{normal} {eye} {light} {lit:?} {peak}");
            }
        }
    }

    #[test]
    fn two_sides_of_a_wall_know_of_their_own_light() {
        // A wall, red to the left and blue to the right: who sees the red side sees no light of the right.
        let random = &mut Random::new(11, 0);
        let mut side = |normal, color| {
            let points = open(normal, 200, random);
            points.into_iter().map(move |point| Outlook { color, ..point })
        };
        let all: Vec<Outlook> = side(Vec3::X, Vec3::X).chain(side(-Vec3::X, Vec3::Z)).collect();
        let all = of(&all);
        let (left, right) = (Vec3::new(0.8, 0.1, 0.6).normalize(), Vec3::new(-0.8, 0.2, 0.5).normalize());
        let shown = all.of(0, left).expect("it is seen");
        assert!((shown.color - Vec3::X).length() < 0.01);
        assert!(shown.lit(right, &straight(left, right, 0.0)).diffuse.length() < 0.01);
        let light = Vec3::new(0.8, -0.5, 0.3).normalize();
        let lit = shown.lit(light, &straight(left, light, 0.0)).diffuse;
        assert!((lit.x - 0.808).abs() < 0.06 && lit.z < 0.02, "{lit}");
    }

    #[test]
    fn a_bent_plane_reflects_as_the_plane_that_it_becomes() {
        // A floor, sheared into a slope: its normal is J⁻ᵀz, its cosine that of the slope, its highlight too.
        let all = of(&open(Vec3::Z, 200, &mut Random::new(12, 0)));
        let jacobian =
            Mat3::from_cols(Vec3::new(1.0, 0.0, 0.6), Vec3::new(0.0, 1.4, 0.0), Vec3::new(0.3, 0.0, 1.0));
        let inverse = jacobian.inverse();
        let normal = (inverse.transpose() * Vec3::Z).normalize();
        let eye = (normal + Vec3::new(0.3, 0.4, 0.0)).normalize();
        for light in [Vec3::new(-0.5, 0.1, 0.6), Vec3::new(0.1, -0.7, 0.7), Vec3::new(-0.9, 0.3, 0.3)] {
            let light = light.normalize();
            let half = (eye + light).normalize();
            let bend = Bend { inverse, length: (inverse * light).length(), highlight: Some((half, 30.0)) };
            let shown = all.of(0, (inverse * eye).normalize()).expect("it is seen");
            let lit = shown.lit((inverse * light).normalize(), &bend);
            let cosine = normal.dot(light);
            let peak = cosine * normal.dot(half).powi(30);
            assert!((lit.diffuse.x - cosine).abs() < 0.03, "{light} {lit:?} {cosine}");
            assert!((lit.gloss - peak).abs() < 0.03, "{light} {lit:?} {peak}");
        }
    }

    #[test]
    fn a_ball_shines_as_all_of_its_normals_do() {
        // Normals all around, none hidden. The mean of (n·v)(n·l)(n·h)^m over those that are seen, by (n·v), is known
        // of the normals themselves; facings are 54, and bells.
        let random = &mut Random::new(10, 0);
        let normals: Vec<Vec3> = (0..4000).map(|_| random.direction()).collect();
        let points: Vec<Outlook> = normals.iter().flat_map(|n| open(*n, 1, random)).collect();
        let all = of(&points);
        let eye = Vec3::new(0.5, 0.2, 0.7).normalize();
        for light in [
            Vec3::new(-0.4, 0.1, 0.9),
            Vec3::new(0.9, -0.3, 0.2),
            Vec3::new(0.1, 0.9, -0.2),
            Vec3::new(-0.8, -0.1, 0.1),
            Vec3::new(0.3, -0.9, 0.5),
            Vec3::new(1.0, 0.9, 0.1),
        ] {
            let light = light.normalize();
            let bend = straight(eye, light, 25.0);
            let half = (eye + light).normalize();
            let (mut seen, mut shines) = (0.0, 0.0);
            for n in &normals {
                let part = n.dot(eye).max(0.0);
                seen += part;
                shines += part * n.dot(light).max(0.0) * n.dot(half).max(0.0).powi(25);
            }
            let found = all.of(0, eye).expect("it is seen").lit(light, &bend).gloss;
            let truth = shines / seen;
            assert!((found - truth).abs() < 0.15 * truth + 0.001, "{light}: {found} {truth}");
        }
    }

    #[test]
    fn bytes_return() {
        let random = &mut Random::new(9, 0);
        // Each blocked on one side.
        let mut point = || {
            let [normal, side] = [(); 2].map(|()| random.direction());
            let color = Vec3::splat(random.unit());
            let distance = |d: Vec3, _| if d.dot(side) > 0.0 { f32::INFINITY } else { 0.0 };
            Outlook::new(normal, color, 1.0, random, distance)
        };
        let points: Vec<Outlook> = (0..20).filter_map(|_| point()).collect();
        let all = of(&points);
        let Parts { largest, nodes, facings, tables } = all.parts();
        let parts = Parts { largest, nodes, facings, tables: tables.to_vec() };
        assert_eq!(Reflectances::from_parts(parts).as_ref(), Some(&all));
        let Parts { nodes, facings, tables, .. } = all.parts();
        let largest = [(-1.0_f32).to_le_bytes()].into_iter();
        let parts = Parts { largest, nodes, facings, tables: tables.to_vec() };
        assert!(Reflectances::from_parts(parts).is_none());
    }
}
