//! What can be set of a kind: one table for its fields, their documentation, their domains and [`check`].

use core::fmt;

use glam::{Vec2, Vec3};

use crate::BuildError;

/// A parameter of a kind of content: what it means, what it may be, and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in scene files.
    pub name: &'static str,
    /// What it means, in a sentence or two.
    pub meaning: &'static str,
    /// What its numbers count or measure; empty for what has no unit.
    pub unit: &'static str,
    /// What each of its numbers may be.
    pub domain: Domain,
    /// What it is.
    pub value: Value,
}

/// A closed range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// The least.
    pub lo: f64,
    /// The greatest.
    pub hi: f64,
    /// How messages call the range: `0 to 1`.
    pub name: &'static str,
}

impl Domain {
    /// Of whole numbers of which one is as good as another.
    pub const ANY: Self = Self { lo: 0.0, hi: u64::MAX as f64, name: "any whole number" };
}

/// What a parameter is. It is displayed as scene files write it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Whole(u64),
    /// A number.
    Number(f32),
    /// Two numbers, along s and t.
    Pair(Vec2),
    /// A linear albedo: red, green, blue.
    Color(Vec3),
}

impl Value {
    /// Its numbers as they are written: 1.2 as f32 is 1.2000000476837158 as f64.
    fn numbers(self) -> Vec<f64> {
        let written = |numbers: &[f32]| {
            numbers.iter().map(|x| x.to_string().parse().unwrap_or(f64::from(*x))).collect::<Vec<_>>()
        };
        match self {
            Self::Whole(n) => vec![n as f64],
            Self::Number(x) => written(&[x]),
            Self::Pair(pair) => written(pair.as_ref()),
            Self::Color(color) => written(color.as_ref()),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(n) => n.fmt(f),
            Self::Number(x) => x.fmt(f),
            Self::Pair(Vec2 { x, y }) => write!(f, "[{x}, {y}]"),
            Self::Color(Vec3 { x, y, z }) => write!(f, "[{x}, {y}, {z}]"),
        }
    }
}

impl From<u64> for Value {
    fn from(n: u64) -> Self {
        Self::Whole(n)
    }
}

impl From<u32> for Value {
    fn from(n: u32) -> Self {
        Self::Whole(n.into())
    }
}

impl From<f32> for Value {
    fn from(x: f32) -> Self {
        Self::Number(x)
    }
}

impl From<Vec2> for Value {
    fn from(pair: Vec2) -> Self {
        Self::Pair(pair)
    }
}

impl From<Vec3> for Value {
    fn from(color: Vec3) -> Self {
        Self::Color(color)
    }
}

/// Names the first parameter with a number outside of its domain, or that is none.
pub(super) fn check(parameters: &[Parameter]) -> Result<(), BuildError> {
    for &Parameter { name: field, domain: Domain { lo, hi, name: domain }, value, .. } in parameters {
        if let Some(value) = value.numbers().into_iter().find(|x| !(lo..=hi).contains(x)) {
            return Err(BuildError::Parameter { field, value, domain });
        }
    }
    Ok(())
}

/// Refuses what would be so many triangles that building them is no longer a matter of minutes and gigabytes.
pub(super) fn at_most_triangles(count: u64) -> Result<(), BuildError> {
    /// 50 million: 2.4 GB of corners and colours.
    const MOST: u64 = 50_000_000;
    if count > MOST { Err(BuildError::Heavy { count, most: MOST }) } else { Ok(()) }
}

/// Declares the parameters of a kind, once: the struct with its documentation, `ABOUT`, and `parameters`, which tells
/// of each what it means, its unit and its domain.
///
/// A field is `name: type in least..=greatest ["unit"]`, the unit where it has one, and no domain where any value
/// will do. The documentation is shown by programs too: plain sentences, without links.
macro_rules! parameters {
    (
        $(#[doc = $about:literal])+
        pub struct $kind:ident {$(
            $(#[doc = $meaning:literal])+
            $name:ident: $type:ident $(in $lo:literal..=$hi:literal $([$unit:literal])?)?,
        )+}
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq)]
        // In the files of earlier versions parameters are missing that came later: they are as in the first preset.
        #[cfg_attr(
            feature = "serde",
            derive(serde::Serialize, serde::Deserialize),
            serde(default, deny_unknown_fields)
        )]
        pub struct $kind {$(
            $(#[doc = $meaning])+
            $(#[doc = concat!("\n\nFrom ", $lo, " to ", $hi, $(" ", $unit,)? ".")])?
            pub $name: $type,
        )+}

        impl $kind {
            /// What it is, in a sentence or two.
            pub const ABOUT: &str = concat!($($about),+).trim_ascii();

            /// What can be set, and what it is set to, in the order of the fields.
            pub fn parameters(&self) -> Vec<crate::kinds::Parameter> {
                use crate::kinds::parameter::{Domain, Parameter, Value};
                vec![$(Parameter {
                    name: stringify!($name),
                    meaning: concat!($($meaning),+).trim_ascii(),
                    unit: concat!($($($unit)?)?),
                    domain: [
                        $(Domain { lo: $lo as f64, hi: $hi as f64, name: concat!($lo, " to ", $hi) },)?
                        Domain::ANY,
                    ][0],
                    value: Value::from(self.$name),
                }),+]
            }
        }
    };
}

pub(super) use parameters;
