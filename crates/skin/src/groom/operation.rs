//! What can be done to a skin's vectors: plain data.

use glam::{Vec2, Vec3};

/// One thing that is done to the vectors of a skin, each of which goes from where its boxes stand to where they
/// reach. Lengths are in metres, directions of any length but zero, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Operation {
    /// Multiplies lengths. Positive, at most 1000.
    Scale(f32),
    /// Sets lengths. Positive.
    Height(f32),
    /// Turns all the same way.
    Tilt(Tilt),
    /// Lays the vectors along a field on the surface.
    Comb(Comb),
    /// Parts them at a plane.
    Part(Part),
    /// Lays them in a whorl.
    Swirl(Swirl),
    /// Disorders them.
    Noise(Noise),
    /// Bends them down, −Y: the tangent of the angle where the surface is vertical. From 0 to 100.
    Gravity(f32),
    /// Bends them as a gust does at one moment.
    Wind(Wind),
    /// Cuts off what is beyond a plane.
    Trim(Plane),
    /// Draws them together in locks.
    Clump(Clump),
    /// Evens out their directions and lengths.
    Smooth(Smooth),
    /// Thins the skin out: multiplies the part of its boxes that stay, from 0 to 1. Which ones is drawn, box by box,
    /// once all steps are done; so thinning is as fine as the patches are.
    Density(f32),
    /// Moves where they reach.
    Move(Vec3),
    /// Turns them about an axis.
    Turn(Turn),
}

/// Turns vectors towards one direction, by an angle, but not past it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Tilt {
    /// Where to.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub towards: Vec3,
    /// From 0 to 180.
    pub angle: f32,
}

/// Lays vectors along a field: where it runs along the surface, they end up at `angle` from the normal; where it
/// runs against the surface they stay upright, and all between follows smoothly.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comb {
    /// Which way.
    pub along: Field,
    /// From the normal; from 0 to 85.
    #[cfg_attr(feature = "serde", serde(default = "sixty"))]
    pub angle: f32,
}

/// Directions on a surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Field {
    /// The same everywhere.
    Vector(#[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))] Vec3),
    /// That of the nearest piece of a curve through two points or more.
    Curve(#[cfg_attr(feature = "schema", schemars(with = "Vec<[f32; 3]>"))] Vec<Vec3>),
    /// In texture coordinates: `[1, 0]` is the way in which u grows.
    Uv(#[cfg_attr(feature = "schema", schemars(with = "[f32; 2]"))] Vec2),
    /// Away from a point.
    AwayFrom(#[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))] Vec3),
}

/// A parting: vectors lean away from a plane on either side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Part {
    /// A point of the plane.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub point: Vec3,
    /// The plane's normal: across the parting.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub across: Vec3,
    /// How far vectors lean; from 0 to 85.
    #[cfg_attr(feature = "serde", serde(default = "forty_five"))]
    pub angle: f32,
    /// How far from the plane they lean in full. Positive.
    pub width: f32,
    /// How far from the plane they no longer do; more than `width`.
    pub reach: f32,
}

/// A whorl: vectors lean around a centre, or away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Swirl {
    /// Where.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub centre: Vec3,
    /// What it turns about; counter-clockwise seen from where it points to.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub axis: Vec3,
    /// How far it reaches, measured across the axis. Positive.
    pub radius: f32,
    /// How far vectors lean at half the radius; from 0 to 85.
    #[cfg_attr(feature = "serde", serde(default = "sixty"))]
    pub angle: f32,
    /// 0 for straight outwards, 90 for round and round; from −180 to 180.
    #[cfg_attr(feature = "serde", serde(default = "sixty"))]
    pub pitch: f32,
}

/// Disorder, by gradient noise over the surface. \[Perlin85\]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Noise {
    /// Relative change of lengths; from 0 to 0.95.
    #[cfg_attr(feature = "serde", serde(default))]
    pub height: f32,
    /// Change of direction; from 0 to 85.
    #[cfg_attr(feature = "serde", serde(default))]
    pub tilt: f32,
    /// How far apart its bumps are. Positive.
    pub size: f32,
    /// Which of the many.
    #[cfg_attr(feature = "serde", serde(default))]
    pub seed: u32,
}

/// Wind at one moment: a steady part, and gusts that travel with it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Wind {
    /// Where it blows to.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub direction: Vec3,
    /// The tangent of the angle by which it bends what it blows across; from 0 to 100.
    pub strength: f32,
    /// How much gusts add and take away, relative to `strength`; from 0 to 10.
    #[cfg_attr(feature = "serde", serde(default))]
    pub gust: f32,
    /// How far apart gusts are. Positive.
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub size: f32,
    /// How fast they travel, in metres a second.
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub speed: f32,
    /// The moment, in seconds.
    #[cfg_attr(feature = "serde", serde(default))]
    pub time: f32,
    /// Which of the many.
    #[cfg_attr(feature = "serde", serde(default))]
    pub seed: u32,
}

/// A plane; what its normal points to is beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plane {
    /// A point of it.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub point: Vec3,
    /// Its normal.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub normal: Vec3,
}

/// Locks: what stands in one cell of a random partition of the surface \[Worley96\] leans together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Clump {
    /// How far apart locks are. Positive.
    pub size: f32,
    /// How far tips move to the middle of their lock; from 0 to 1.
    pub amount: f32,
    /// Which of the many.
    #[cfg_attr(feature = "serde", serde(default))]
    pub seed: u32,
}

/// Steps in each of which a vector moves towards the mean of its neighbours'.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Smooth {
    /// At most 1000.
    #[cfg_attr(feature = "serde", serde(default = "four"))]
    pub steps: u32,
    /// How far in each; from 0 to 1.
    #[cfg_attr(feature = "serde", serde(default = "half"))]
    pub amount: f32,
}

/// A rotation of vectors about their own feet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Turn {
    /// What about; counter-clockwise seen from where it points to.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub axis: Vec3,
    /// From −180 to 180.
    pub angle: f32,
}

/// A field that is out of its domain: its name, as in `tilt.angle`, and what it should hold.
pub type Misfit = (&'static str, &'static str);

/// Magnitudes stay below this, so that products of three fit in an `f32`.
const LIMIT: f32 = 1e12;
const LENGTH: &str = "must be positive and at most 1e12";
const DIRECTION: &str = "must be finite and not zero";
const POINT: &str = "must be finite";
const LEANING: &str = "must be from 0 to 85 degrees";
const TANGENT: &str = "must be from 0 to 100";

impl Operation {
    /// Checks that every number is in its domain.
    ///
    /// # Errors
    /// The first field that is not.
    pub fn validate(&self) -> Result<(), Misfit> {
        let length = |x: f32| x > 0.0 && x <= LIMIT;
        let within = |x: f32, lo: f32, hi: f32| (lo..=hi).contains(&x);
        let point = |p: Vec3| p.abs().cmple(Vec3::splat(LIMIT)).all();
        let direction = |d: Vec3| point(d) && d.try_normalize().is_some();
        let checks: &[(bool, &'static str, &'static str)] = &match self {
            Self::Scale(x) => vec![(length(*x) && *x <= 1e3, "scale", "must be positive and at most 1000")],
            Self::Height(x) => vec![(length(*x), "height", LENGTH)],
            Self::Gravity(x) => vec![(within(*x, 0.0, 100.0), "gravity", TANGENT)],
            Self::Density(x) => vec![(within(*x, 0.0, 1.0), "density", "must be from 0 to 1")],
            Self::Move(by) => vec![(point(*by), "move", POINT)],
            Self::Tilt(Tilt { towards, angle }) => vec![
                (direction(*towards), "tilt.towards", DIRECTION),
                (within(*angle, 0.0, 180.0), "tilt.angle", "must be from 0 to 180 degrees"),
            ],
            Self::Comb(Comb { along, angle }) => {
                let (ok, field, domain) = match along {
                    Field::Vector(v) => (direction(*v), "comb.along.vector", DIRECTION),
                    Field::Uv(d) => (direction(d.extend(0.0)), "comb.along.uv", DIRECTION),
                    Field::AwayFrom(p) => (point(*p), "comb.along.away_from", POINT),
                    Field::Curve(points) => {
                        let runs = points.windows(2).any(|ends| ends[0] != ends[1]);
                        let ok = runs && points.iter().all(|p| point(*p));
                        (ok, "comb.along.curve", "must hold two different finite points or more")
                    }
                };
                vec![(ok, field, domain), (within(*angle, 0.0, 85.0), "comb.angle", LEANING)]
            }
            Self::Part(p) => vec![
                (point(p.point), "part.point", POINT),
                (direction(p.across), "part.across", DIRECTION),
                (within(p.angle, 0.0, 85.0), "part.angle", LEANING),
                (length(p.width), "part.width", LENGTH),
                (p.reach > p.width && p.reach <= LIMIT, "part.reach", "must be more than `width`"),
            ],
            Self::Swirl(s) => vec![
                (point(s.centre), "swirl.centre", POINT),
                (direction(s.axis), "swirl.axis", DIRECTION),
                (length(s.radius), "swirl.radius", LENGTH),
                (within(s.angle, 0.0, 85.0), "swirl.angle", LEANING),
                (within(s.pitch, -180.0, 180.0), "swirl.pitch", "must be from -180 to 180 degrees"),
            ],
            Self::Noise(n) => vec![
                (within(n.height, 0.0, 0.95), "noise.height", "must be from 0 to 0.95"),
                (within(n.tilt, 0.0, 85.0), "noise.tilt", LEANING),
                (length(n.size), "noise.size", LENGTH),
            ],
            Self::Wind(w) => vec![
                (direction(w.direction), "wind.direction", DIRECTION),
                (within(w.strength, 0.0, 100.0), "wind.strength", TANGENT),
                (within(w.gust, 0.0, 10.0), "wind.gust", "must be from 0 to 10"),
                (length(w.size), "wind.size", LENGTH),
                (within(w.speed, -LIMIT, LIMIT), "wind.speed", POINT),
                (within(w.time, -LIMIT, LIMIT), "wind.time", POINT),
            ],
            Self::Trim(plane) => vec![
                (point(plane.point), "trim.point", POINT),
                (direction(plane.normal), "trim.normal", DIRECTION),
            ],
            Self::Clump(c) => vec![
                (length(c.size), "clump.size", LENGTH),
                (within(c.amount, 0.0, 1.0), "clump.amount", "must be from 0 to 1"),
            ],
            Self::Smooth(s) => vec![
                (s.steps <= 1000, "smooth.steps", "must be at most 1000"),
                (within(s.amount, 0.0, 1.0), "smooth.amount", "must be from 0 to 1"),
            ],
            Self::Turn(t) => vec![
                (direction(t.axis), "turn.axis", DIRECTION),
                (within(t.angle, -180.0, 180.0), "turn.angle", "must be from -180 to 180 degrees"),
            ],
        };
        match checks.iter().find(|(ok, ..)| !ok) {
            Some(&(_, field, domain)) => Err((field, domain)),
            None => Ok(()),
        }
    }

    /// Whether what it does may lay vectors flatter than [`GroomOptions::steepest`](super::GroomOptions::steepest):
    /// where single vectors are moved, what was asked for is done.
    pub(super) fn is_exact(&self) -> bool {
        matches!(
            self,
            Self::Density(_)
                | Self::Scale(_)
                | Self::Height(_)
                | Self::Trim(_)
                | Self::Move(_)
                | Self::Turn(_)
        )
    }
}

#[cfg(feature = "serde")]
fn sixty() -> f32 {
    60.0
}
#[cfg(feature = "serde")]
fn forty_five() -> f32 {
    45.0
}
#[cfg(feature = "serde")]
fn one() -> f32 {
    1.0
}
#[cfg(feature = "serde")]
fn four() -> u32 {
    4
}
#[cfg(feature = "serde")]
fn half() -> f32 {
    0.5
}
