//! Fur: tapered strands grown from the surface.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::clumps::Clumps;
use super::parameter::{at_most_triangles, check, parameters};
use super::scatter::{LOOSELY, scattered};
use super::tube::tube;
use super::variant::{elements, seed_of};
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

parameters! {
    /// Strands, with undercoat between them. Colours are near-neutral in the presets: the tint of a coat multiplies them.
    pub struct Fur {
        /// Which of the many furs with these settings.
        seed: u64,
        /// Which of the variants: they differ inside of a copy, but are the same where they go on in the next.
        variant: u32,
        /// Strands in a copy, undercoat included.
        count: u32 in 1..=1_000_000 ["strands"],
        /// Length of a strand, along it; tips stay below the texel's top.
        length: f32 in 0..=1 ["texel edges"],
        /// Relative variation of the length.
        length_variation: f32 in 0..=1,
        /// Radius of a strand at its root.
        root_radius: f32 in 0..=0.5 ["texel edges"],
        /// Radius of a strand at its tip; 0 for a point.
        tip_radius: f32 in 0..=0.5 ["texel edges"],
        /// Relative variation of the radius between strands.
        radius_variation: f32 in 0..=1,
        /// How the fur is combed: mean slope along s and t over the whole strand. Roots stand steeper, tips lie lower.
        lean: Vec2 in -10..=10 ["texel edges a texel edge"],
        /// How strongly strands wind: the slope of their bends.
        curl: f32 in 0..=10 ["texel edges a texel edge"],
        /// How often strands wind on their way.
        curl_turns: f32 in 0..=16 ["turns"],
        /// Slope of the small kinks from piece to piece of a strand.
        frizz: f32 in 0..=10 ["texel edges a texel edge"],
        /// How far tips are drawn to the middle of their lock.
        clump: f32 in 0..=1,
        /// Strands in a lock.
        clump_size: u32 in 1..=10_000 ["strands"],
        /// Fraction of the strands that are undercoat: shorter, finer, more curled.
        undercoat: f32 in 0..=1,
        /// Length of the undercoat over that of the other strands.
        undercoat_length: f32 in 0..=1,
        /// Colour of the undercoat at its tips; its roots have the colour of the others.
        undercoat_color: Vec3 in 0..=1,
        /// Colour at the root.
        root_color: Vec3 in 0..=1,
        /// Colour at the tip.
        tip_color: Vec3 in 0..=1,
        /// Where along a strand it is half one colour and half the other.
        color_midpoint: f32 in 0.05..=0.95,
        /// Relative variation of brightness between strands.
        color_variation: f32 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
        /// Straight pieces of a strand.
        segments: u32 in 1..=32 ["pieces"],
        /// Sides of a strand's cross-section.
        sides: u32 in 3..=16 ["sides"],
    }
}

impl Fur {
    /// Long, soft, in loose locks. Upright: the skin's own vectors comb it.
    pub fn long() -> Self {
        Self {
            seed: 1,
            variant: 0,
            count: 1100,
            length: 0.92,
            length_variation: 0.25,
            root_radius: 0.008,
            tip_radius: 0.002,
            radius_variation: 0.3,
            lean: Vec2::ZERO,
            curl: 0.25,
            curl_turns: 1.0,
            frizz: 0.0,
            clump: 0.8,
            clump_size: 12,
            undercoat: 0.45,
            undercoat_length: 0.5,
            undercoat_color: Vec3::new(0.89, 0.88, 0.87),
            root_color: Vec3::new(0.6, 0.58, 0.56),
            tip_color: Vec3::new(0.97, 0.96, 0.95),
            color_midpoint: 0.5,
            color_variation: 0.2,
            specular: 0.08,
            roughness: 0.4,
            segments: 7,
            sides: 3,
        }
    }

    /// Short and smooth, hardly curled.
    pub fn short() -> Self {
        Self {
            count: 1500,
            length: 0.8,
            length_variation: 0.15,
            root_radius: 0.01,
            curl: 0.12,
            clump: 0.35,
            undercoat: 0.35,
            segments: 5,
            ..Self::long()
        }
    }

    /// Dense, even and matt, like velvet or a soft toy.
    pub fn plush() -> Self {
        Self {
            count: 1600,
            length: 0.75,
            length_variation: 0.12,
            root_radius: 0.009,
            tip_radius: 0.006,
            radius_variation: 0.15,
            curl: 0.45,
            frizz: 0.1,
            clump: 0.2,
            undercoat: 0.5,
            root_color: Vec3::new(0.66, 0.65, 0.64),
            specular: 0.03,
            roughness: 0.6,
            segments: 5,
            ..Self::long()
        }
    }

    /// Tight crimped locks, like a lamb's.
    pub fn fleece() -> Self {
        Self {
            count: 1500,
            length: 1.0,
            length_variation: 0.15,
            root_radius: 0.007,
            tip_radius: 0.005,
            curl: 1.1,
            curl_turns: 3.0,
            frizz: 0.12,
            clump: 0.95,
            clump_size: 36,
            undercoat: 0.25,
            undercoat_length: 0.6,
            undercoat_color: Vec3::new(0.8, 0.78, 0.74),
            root_color: Vec3::new(0.62, 0.58, 0.52),
            specular: 0.02,
            roughness: 0.7,
            segments: 14,
            ..Self::long()
        }
    }

    /// Thin separate hairs, as sparse as those that a test can count: 400 of 24 triangles each.
    pub fn hair() -> Self {
        Self {
            count: 400,
            length: 0.9,
            length_variation: 0.15,
            root_radius: 0.006,
            tip_radius: 0.003,
            radius_variation: 0.0,
            curl: 0.2,
            clump: 0.3,
            undercoat: 0.0,
            segments: 4,
            ..Self::long()
        }
    }

    /// The points of strand `i`, root first, and what is the strand's own.
    fn strand(&self, i: u32, locks: &Clumps) -> (Vec<Vec3>, Strand) {
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.count, LOOSELY, random);
        let under = random.unit() < self.undercoat;
        let [size, bend] = if under { [self.undercoat_length, 1.8] } else { [1.0, 1.0] };
        let length = size * self.length * (1.0 + self.length_variation * random.signed());
        let length = length.clamp(0.0, 0.98);
        let lock = locks.nearest(root);
        let to_lock = lock.middle - root;
        let own = Vec2::from_angle(TAU * random.unit()) * self.curl * bend * random.unit().sqrt();
        // Strands of a tight lock wind together.
        let with_lock = Random::new(self.seed ^ 0xc0de, lock.number.into()).unit();
        let phase = TAU * (with_lock + (1.0 - self.clump) * random.unit());
        let turns = self.curl_turns * (1.0 + 0.4 * (1.0 - 0.7 * self.clump) * random.signed());
        let wave = 0.7 * self.curl * bend;
        let shade = 1.0 + self.color_variation * random.signed();
        let thickness = 1.0 + self.radius_variation * random.signed();
        let segments = self.segments;
        let mut point = root.extend(0.0);
        let mut points = vec![point];
        for k in 0..segments {
            let x = (k as f32 + 0.5) / segments as f32;
            let pull = to_lock * (self.clump * 2.0 * x / length.max(1e-3));
            let kink = Vec2::new(random.signed(), random.signed()) * self.frizz;
            let slope = self.lean * 2.0 * x
                + own
                + Vec2::from_angle(phase + TAU * turns * x) * wave * x
                + kink
                + pull;
            point += slope.extend(1.0).normalize() * (length / segments as f32);
            points.push(point);
        }
        let thickness = if under { 0.75 * thickness } else { thickness };
        (points, Strand { under, thickness, shade })
    }

    /// Grows strand after strand.
    fn strands(&self) -> impl Fn(u32, &mut Geometry) + '_ {
        let locks = Clumps::new(self.count / self.clump_size.max(1), self.seed ^ 0x10c5);
        move |i, geometry| {
            let (points, Strand { under, thickness, shade }) = self.strand(i, &locks);
            let radius = |x: f32| (self.root_radius + (self.tip_radius - self.root_radius) * x) * thickness;
            let tip_color = if under { self.undercoat_color } else { self.tip_color };
            let color = |x: f32| {
                // Half-way at the midpoint. [Schlick94]
                let x = x / ((1.0 / (1.0 - self.color_midpoint) - 2.0) * (1.0 - x) + 1.0);
                let blend = x * x * (3.0 - 2.0 * x);
                self.root_color.lerp(tip_color, blend) * shade
            };
            // Each strand turned its own way: together, few-sided tubes are as round as fur.
            let turn = TAU * Random::new(self.seed ^ 0x7ab5, i.into()).unit();
            tube(geometry, &points, self.sides, turn, radius, color);
        }
    }
}

/// What is a strand's own: whether it is undercoat, and its factors of radius and brightness.
struct Strand {
    under: bool,
    thickness: f32,
    shade: f32,
}

impl Default for Fur {
    fn default() -> Self {
        Self::long()
    }
}

impl Procedure for Fur {
    fn name(&self) -> &'static str {
        "fur"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        at_most_triangles(u64::from(self.count) * u64::from(2 * self.segments * self.sides))
    }

    fn geometry(&self) -> Geometry {
        let geometry = Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let own = Self { seed: seed_of(self.seed, self.variant), ..self.clone() };
        elements(geometry, self.count, self.variant, self.strands(), own.strands())
    }
}
