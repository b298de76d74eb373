//! Texels ready for use: built, and their light balanced.

use pelage_texel::{BuildError, BuildOptions, Source, Texel};

/// How much of the time building takes, about; the rest balances.
const BUILDING: f32 = 0.8;

/// Builds a texel as [`pelage_texel::build`] does, and [balances](pelage_tracer::balance) its light. `progress` is told the
/// fraction done, 0 to 1, from any thread.
///
/// # Errors
/// As [`pelage_texel::build`].
pub fn build(
    name: &str,
    source: impl Into<Source>,
    options: &BuildOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<Texel, BuildError> {
    let texel = pelage_texel::build(name, source, options, &|f| progress(BUILDING * f))?;
    let balanced = pelage_tracer::balance(texel, &|f| progress(BUILDING + (1.0 - BUILDING) * f));
    progress(1.0);
    Ok(balanced)
}
