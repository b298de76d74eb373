//! Fur: tapered strands grown from the surface.

use core::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::domain::{COUNT, Domain, RADIUS, SEGMENTS, SLOPE, UNIT, at_most_triangles};
use super::scatter::scattered;
use crate::random::Random;
use crate::{BuildError, Geometry, Procedure};

/// Fur over one tile. Lengths are in texel edges: the tile is 1 wide, the texel 1 high.
///
/// Colours are near-neutral in the presets: the tint of a coat multiplies them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Fur {
    /// Which of the many furs with these settings.
    pub seed: u64,
    /// Strands in the tile, undercoat included: 1 to 10⁶.
    pub count: u32,
    /// Length of a strand, along it; tips stay below the texel's top.
    pub length: f32,
    /// Relative variation of the length, 0 to 1.
    pub length_variation: f32,
    /// Radius at the root.
    pub root_radius: f32,
    /// Radius at the tip; 0 for a point.
    pub tip_radius: f32,
    /// Mean slope (s and t per unit of w) over the whole strand: roots stand steeper, tips lie lower.
    pub lean: Vec2,
    /// Slope of the random bends of each strand.
    pub curl: f32,
    /// How far tips are drawn to the middle of their lock, 0 to 1.
    pub clump: f32,
    /// Fraction of the strands that are undercoat: half as long, finer, more curled, 0 to 1.
    pub undercoat: f32,
    /// Linear albedo at the root.
    pub root_color: Vec3,
    /// Linear albedo at the tip.
    pub tip_color: Vec3,
    /// Relative variation of brightness between strands, 0 to 1.
    pub color_variation: f32,
    /// Specular albedo, 0 to 1.
    pub specular: f32,
    /// Roughness of the highlight, 0 to 1.
    pub roughness: f32,
    /// Straight pieces a strand, 1 to 32.
    pub segments: u32,
    /// Sides of a strand's cross-section, 3 to 16.
    pub sides: u32,
}

impl Fur {
    /// Long, soft, in loose locks. Upright: the skin's own vectors comb it.
    pub fn long() -> Self {
        Self {
            seed: 1,
            count: 1100,
            length: 0.92,
            length_variation: 0.25,
            root_radius: 0.008,
            tip_radius: 0.002,
            lean: Vec2::ZERO,
            curl: 0.25,
            clump: 0.8,
            undercoat: 0.45,
            root_color: Vec3::new(0.6, 0.58, 0.56),
            tip_color: Vec3::new(0.97, 0.96, 0.95),
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
            curl: 0.45,
            clump: 0.2,
            undercoat: 0.5,
            root_color: Vec3::new(0.66, 0.65, 0.64),
            specular: 0.03,
            roughness: 0.6,
            segments: 5,
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
            curl: 0.2,
            clump: 0.3,
            undercoat: 0.0,
            segments: 4,
            ..Self::long()
        }
    }

    /// The middles of the locks, with about twelve strands each.
    fn locks(&self) -> Vec<Vec2> {
        let count = (self.count / 12).max(1);
        (0..count).map(|i| scattered(i, count, &mut Random::new(self.seed ^ 0x10c5, i.into()))).collect()
    }

    /// The points of strand `i`, root first, and the strand's own factors of radius and brightness.
    fn strand(&self, i: u32, locks: &Locks) -> (Vec<Vec3>, f32, f32) {
        let random = &mut Random::new(self.seed, i.into());
        let root = scattered(i, self.count, random);
        let under = random.unit() < self.undercoat;
        let [size, bend] = if under { [0.5, 1.8] } else { [1.0, 1.0] };
        let length = size * self.length * (1.0 + self.length_variation * random.signed());
        let length = length.clamp(0.0, 0.98);
        let to_lock = locks.nearest(root) - root;
        let own = Vec2::from_angle(TAU * random.unit()) * self.curl * bend * random.unit().sqrt();
        let [phase, turns] = [TAU * random.unit(), 0.6 + 0.8 * random.unit()];
        let wave = 0.7 * self.curl * bend;
        let shade = 1.0 + self.color_variation * random.signed();
        let segments = self.segments;
        let mut point = root.extend(0.0);
        let mut points = vec![point];
        for k in 0..segments {
            let x = (k as f32 + 0.5) / segments as f32;
            let pull = to_lock * (self.clump * 2.0 * x / length.max(1e-3));
            let slope =
                self.lean * 2.0 * x + own + Vec2::from_angle(phase + TAU * turns * x) * wave * x + pull;
            point += slope.extend(1.0).normalize() * (length / segments as f32);
            points.push(point);
        }
        (points, if under { 0.75 } else { 1.0 }, if under { 0.92 * shade } else { shade })
    }
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
        COUNT.check("count", self.count)?;
        UNIT.check("length", self.length)?;
        UNIT.check("length_variation", self.length_variation)?;
        RADIUS.check("root_radius", self.root_radius)?;
        RADIUS.check("tip_radius", self.tip_radius)?;
        SLOPE.check_each("lean", self.lean.as_ref())?;
        Domain::new(0.0, 10.0, "0 to 10").check("curl", self.curl)?;
        UNIT.check("clump", self.clump)?;
        UNIT.check("undercoat", self.undercoat)?;
        UNIT.check_each("root_color", self.root_color.as_ref())?;
        UNIT.check_each("tip_color", self.tip_color.as_ref())?;
        UNIT.check("color_variation", self.color_variation)?;
        UNIT.check("specular", self.specular)?;
        UNIT.check("roughness", self.roughness)?;
        SEGMENTS.check("segments", self.segments)?;
        Domain::new(3.0, 16.0, "3 to 16").check("sides", self.sides)?;
        at_most_triangles(self.count, 2 * self.segments * self.sides)
    }

    fn geometry(&self) -> Geometry {
        let mut geometry =
            Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() };
        let locks = Locks::new(self.locks());
        for i in 0..self.count {
            let (points, thickness, shade) = self.strand(i, &locks);
            let radius = |x: f32| (self.root_radius + (self.tip_radius - self.root_radius) * x) * thickness;
            let color = |x: f32| {
                let blend = x * x * (3.0 - 2.0 * x);
                (self.root_color.lerp(self.tip_color, blend) * shade).clamp(Vec3::ZERO, Vec3::ONE)
            };
            // Each strand turned its own way: together, few-sided tubes are as round as fur.
            let turn = TAU * Random::new(self.seed ^ 0x7ab5, i.into()).unit();
            tube(&mut geometry, &points, self.sides, turn, radius, color);
        }
        geometry
    }
}

/// A tube along a curve, its sides turned by `turn` radians about it: `radius` and `color` at a fraction of it, 0
/// at its first point.
fn tube(
    geometry: &mut Geometry,
    points: &[Vec3],
    sides: u32,
    turn: f32,
    radius: impl Fn(f32) -> f32,
    color: impl Fn(f32) -> Vec3,
) {
    let last = points.len().saturating_sub(1);
    let tangent = |k: usize| (points[(k + 1).min(last)] - points[k.saturating_sub(1)]).normalize_or(Vec3::Z);
    // One frame carried along the curve, so that the sides do not twist.
    let mut right = tangent(0).any_orthonormal_vector();
    let mut ring: Vec<Vec3> = Vec::new();
    for (k, &point) in points.iter().enumerate() {
        let along = tangent(k);
        right = (right - along * along.dot(right)).normalize_or(along.any_orthonormal_vector());
        let up = along.cross(right);
        let r = radius(k as f32 / last as f32);
        let next: Vec<Vec3> = (0..sides)
            .map(|side| Vec2::from_angle(turn + TAU * side as f32 / sides as f32) * r)
            .map(|p| point + right * p.x + up * p.y)
            .collect();
        if k > 0 {
            let color = color((k as f32 - 0.5) / last as f32);
            for side in 0..sides as usize {
                let beside = (side + 1) % sides as usize;
                let [a, b, c, d] = [ring[side], ring[beside], next[beside], next[side]];
                geometry.push([a, b, c], color);
                if c != d {
                    geometry.push([a, c, d], color);
                }
            }
        }
        ring = next;
    }
}

/// The middles of the locks, sorted into a grid over the periodic tile to find the nearest.
struct Locks {
    side: usize,
    cells: Vec<Vec<Vec2>>,
}

impl Locks {
    fn new(middles: Vec<Vec2>) -> Self {
        let side = ((middles.len() as f32 / 2.0).sqrt() as usize).max(1);
        let mut cells = vec![Vec::new(); side * side];
        for p in middles {
            let [x, y] = [p.x, p.y].map(|c| ((c * side as f32) as usize).min(side - 1));
            cells[x + side * y].push(p);
        }
        Self { side, cells }
    }

    /// The nearest middle, in whichever copy of the tile it lies; `p` itself if none is near.
    fn nearest(&self, p: Vec2) -> Vec2 {
        let side = self.side as i32;
        let at = (p * side as f32).floor().as_ivec2();
        let mut best = (f32::INFINITY, p);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let [x, y] = [at.x + dx, at.y + dy];
                let tile = Vec2::new(x.div_euclid(side) as f32, y.div_euclid(side) as f32);
                let cell = x.rem_euclid(side) + side * y.rem_euclid(side);
                for &middle in &self.cells[cell as usize] {
                    let distance = p.distance_squared(middle + tile);
                    if distance < best.0 {
                        best = (distance, middle + tile);
                    }
                }
            }
        }
        best.1
    }
}
