//! Pile: carpet, of yarn that is twisted from fibres and stands in tufts on a grid.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::curve::around;
use super::parameter::{at_most_triangles, check, parameters};
use super::tube::{tangent, tube};
use super::variant::{elements, seed_of};
use super::within::plant;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Carpet: tufts of twisted yarn, cut or looped. Colours are near-neutral in the presets: the tint of a coat multiplies
    /// them.
    pub struct Pile {
        /// Which of the many carpets with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Tufts along each edge of a copy; their square stands in it.
        tufts: u32 in 1..=100 ["tufts"],
        /// Height of the pile.
        height: f32 in 0..=1 ["texel edges"],
        /// Relative variation of the height.
        height_variation: f32 in 0..=1,
        /// How far tufts stand off the grid, over the distance between neighbours.
        jitter: f32 in 0..=1,
        /// Fraction of the tufts that are loops; the others are cut.
        loops: f32 in 0..=1,
        /// Mean slope of the tufts along s and t: the lie of the pile. Loops have none.
        lean: Vec2 in -10..=10 ["texel edges a texel edge"],
        /// How far cut tufts bend, each its own way: slope at their ends.
        bend: f32 in 0..=10 ["texel edges a texel edge"],
        /// Thickness of the yarn over the distance between neighbours.
        thickness: f32 in 0..=2,
        /// How much wider a cut yarn is at its end, where its fibres open, than at its root.
        bloom: f32 in 0..=4,
        /// Plies that are twisted into a yarn.
        plies: u32 in 1..=8 ["plies"],
        /// Turns of the plies around each other along a tuft.
        twist: f32 in -32..=32 ["turns"],
        /// Fibres in a yarn.
        fibers: u32 in 1..=1000 ["fibres"],
        /// Radius of a fibre.
        fiber_radius: f32 in 0..=0.1 ["texel edges"],
        /// Colour at the root.
        root_color: Vec3 in 0..=1,
        /// Colour at the end of a cut tuft, and at the top of a loop.
        tip_color: Vec3 in 0..=1,
        /// Relative variation of brightness between tufts, and half as much between the fibres of one.
        color_variation: f32 in 0..=1,
        /// Fraction of the tufts that are of another colour.
        accent: f32 in 0..=1,
        /// Their colour.
        accent_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
        /// Straight pieces of a fibre.
        segments: u32 in 1..=64 ["pieces"],
    }
}

/// Sides of a fibre.
const SIDES: u32 = 3;

impl Pile {
    /// Cut pile of twisted yarn.
    pub fn cut() -> Self {
        Self {
            seed: 1,
            variant: 0,
            tufts: 8,
            height: 0.85,
            height_variation: 0.06,
            jitter: 0.25,
            loops: 0.0,
            lean: Vec2::ZERO,
            bend: 0.18,
            thickness: 0.8,
            bloom: 0.35,
            plies: 2,
            twist: 1.5,
            fibers: 20,
            fiber_radius: 0.007,
            root_color: Vec3::new(0.5, 0.48, 0.45),
            tip_color: Vec3::new(0.92, 0.9, 0.86),
            color_variation: 0.12,
            accent: 0.0,
            accent_color: Vec3::new(0.35, 0.3, 0.25),
            specular: 0.02,
            roughness: 0.6,
            segments: 8,
        }
    }

    /// Uncut loops in rows, in two colours.
    pub fn loops() -> Self {
        Self {
            tufts: 6,
            height: 0.75,
            height_variation: 0.08,
            jitter: 0.15,
            loops: 1.0,
            thickness: 0.62,
            plies: 3,
            twist: 2.5,
            fibers: 21,
            fiber_radius: 0.008,
            accent: 0.15,
            segments: 16,
            ..Self::cut()
        }
    }

    /// Long heavy yarn that lies over.
    pub fn shag() -> Self {
        Self {
            tufts: 7,
            height: 0.9,
            height_variation: 0.15,
            jitter: 0.6,
            bend: 0.6,
            thickness: 0.85,
            bloom: 0.5,
            twist: 3.0,
            fibers: 22,
            segments: 12,
            ..Self::cut()
        }
    }

    /// The middle of a tuft's yarn, root first.
    fn spine(&self, root: Vec2, looped: bool, height: f32, random: &mut Random) -> Vec<Vec3> {
        let bend = self.lean + Vec2::from_angle(TAU * random.unit()) * self.bend * random.unit().sqrt();
        let foot = 0.5 / self.tufts as f32;
        let piece = |k: u32| k as f32 / self.segments as f32;
        (0..=self.segments)
            .map(|k| {
                let x = piece(k);
                if looped {
                    // Up, over to the next stitch of its row, and down: steep at its feet.
                    let (sine, cosine) = (0.5 * TAU * x).sin_cos();
                    (root - Vec2::X * (foot * cosine)).extend(height * sine.max(0.0).sqrt().min(1.0))
                } else {
                    (root + bend * (height * x * x)).extend(height * x)
                }
            })
            .collect()
    }

    fn tuft(&self, i: u32, geometry: &mut Geometry) {
        let mut tuft = Geometry::default();
        let random = &mut Random::new(self.seed, i.into());
        let [column, row] = [i % self.tufts, i / self.tufts];
        let spacing = 1.0 / self.tufts as f32;
        // Rows are staggered.
        let even = Vec2::new(column as f32 + if row % 2 == 0 { 0.25 } else { 0.75 }, row as f32 + 0.5);
        let off = Vec2::new(random.signed(), random.signed()) * (0.5 * self.jitter);
        let looped = random.unit() < self.loops;
        let height = (self.height * (1.0 + self.height_variation * random.signed())).min(0.98);
        let shade = 1.0 + self.color_variation * random.signed();
        let accent = random.unit() < self.accent;
        let turn = TAU * random.unit();
        let root = (even + off) * spacing;
        let spine = self.spine(root, looped, height, random);
        let yarn = 0.5 * self.thickness * spacing;
        // A ply fills the yarn's width with the others of it.
        let [ply_at, ply_radius] = if self.plies > 1 { [0.5 * yarn, 0.5 * yarn] } else { [0.0, yarn] };
        for j in 0..self.fibers {
            let plies = self.plies.max(1);
            let ply = TAU * (j % plies) as f32 / plies as f32;
            // Fibres fill the disk of their ply evenly. [Vogel79]
            let within = (j / plies) as f32 + 0.5;
            let of = (self.fibers as f32 / plies as f32).max(1.0);
            let [ring, place] = [ply_radius * (within / of).min(1.0).sqrt(), within * 2.399_963];
            let fiber_shade = shade * (1.0 + 0.5 * self.color_variation * random.signed());
            let frizz = Vec2::new(random.signed(), random.signed());
            let points: Vec<Vec3> = (0..spine.len())
                .map(|k| {
                    let x = k as f32 / self.segments as f32;
                    let axis = tangent(&spine, k);
                    let angle = turn + TAU * self.twist * x;
                    let open = if looped { 1.0 } else { 1.0 + self.bloom * x * x * x };
                    // Plies turn one way, fibres within a ply the other: that is what holds yarn together.
                    let offset =
                        Vec2::from_angle(ply + angle) * ply_at + Vec2::from_angle(place - angle) * ring;
                    let offset = (offset + frizz * (0.15 * yarn * x)) * open;
                    spine[k] + around_loop(axis, offset, looped)
                })
                .collect();
            let top = if accent { self.accent_color } else { self.tip_color };
            let color = |x: f32| {
                let height = if looped { (0.5 * TAU * x).sin() } else { x };
                self.root_color.min(top).lerp(top, height) * fiber_shade
            };
            let radius = |x: f32| self.fiber_radius * if looped { 1.0 } else { 1.0 - 0.5 * x * x };
            tube(&mut tuft, &points, SIDES, TAU * random.unit(), radius, color);
        }
        plant(geometry, tuft, root.extend(0.0));
    }
}

/// `offset` across a yarn whose direction is `axis`, in a frame that does not turn over along a loop.
fn around_loop(axis: Vec3, offset: Vec2, looped: bool) -> Vec3 {
    if looped {
        // A loop lies in a plane: t is across it everywhere.
        Vec3::Y * offset.y + axis.cross(Vec3::Y) * offset.x
    } else {
        let length = offset.length();
        let side = (offset.extend(0.0) - axis * offset.extend(0.0).dot(axis)).normalize_or(around(axis, 0.0));
        side * length
    }
}

impl Default for Pile {
    fn default() -> Self {
        Self::cut()
    }
}

impl Procedure for Pile {
    fn name(&self) -> &'static str {
        "pile"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        let fiber = 2 * self.segments * SIDES;
        at_most_triangles(u64::from(self.tufts.pow(2)) * u64::from(self.fibers) * u64::from(fiber))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        let grow = |i: u32, geometry: &mut Geometry| self.tuft(i, geometry);
        elements(geometry, self.tufts * self.tufts, self.variant, grow, |i, geometry| own.tuft(i, geometry))
    }
}
