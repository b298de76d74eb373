//! What the parameters of the kinds may be.

use core::fmt::Display;

use crate::BuildError;

/// A closed range of numbers, and how messages call it.
#[derive(Clone, Copy)]
pub(super) struct Domain {
    lo: f64,
    hi: f64,
    name: &'static str,
}

/// Fractions, albedos, and lengths in texel edges.
pub(super) const UNIT: Domain = Domain::new(0.0, 1.0, "0 to 1");
/// Things in a tile.
pub(super) const COUNT: Domain = Domain::new(1.0, 1e6, "1 to 1000000");
/// Straight pieces along a strand or blade.
pub(super) const SEGMENTS: Domain = Domain::new(1.0, 32.0, "1 to 32");
/// Half a thickness, in texel edges.
pub(super) const RADIUS: Domain = Domain::new(0.0, 0.5, "0 to 0.5");
/// s and t per unit of w, or the reverse.
pub(super) const SLOPE: Domain = Domain::new(-10.0, 10.0, "-10 to 10");

impl Domain {
    pub(super) const fn new(lo: f64, hi: f64, name: &'static str) -> Self {
        Self { lo, hi, name }
    }

    /// Names the field whose value lies outside, or is no number.
    pub(super) fn check<T: Into<f64> + Display + Copy>(
        self,
        field: &'static str,
        value: T,
    ) -> Result<(), BuildError> {
        if (self.lo..=self.hi).contains(&value.into()) {
            return Ok(());
        }
        // The number as it is written: 1.2 as f32 is 1.2000000476837158 as f64.
        let value = value.to_string().parse().unwrap_or(value.into());
        Err(BuildError::Parameter { field, value, domain: self.name })
    }

    /// The same for each component of a vector or colour.
    pub(super) fn check_each(self, field: &'static str, values: &[f32]) -> Result<(), BuildError> {
        values.iter().try_for_each(|&value| self.check(field, value))
    }
}

/// Refuses what would be so many triangles that building them is no longer a matter of minutes and gigabytes.
pub(super) fn at_most_triangles(things: u32, of_each: u32) -> Result<(), BuildError> {
    /// 50 million: 2.4 GB of corners and colours.
    const MOST: u64 = 50_000_000;
    let count = u64::from(things) * u64::from(of_each);
    if count > MOST { Err(BuildError::Heavy { count, most: MOST }) } else { Ok(()) }
}
