//! Content without surfaces: something that absorbs light here more, there less.
//!
//! A [`Density`] is a hypertexture [PerlinHoffert89]: a simple shape with a soft boundary, which noise pushes in and
//! out. All of it follows from one function, the height h of a point under the boundary:
//!
//! ```text
//! h(x) = size − distance(x) + amplitude · N(x)       texel edges, positive inside
//! ρ(x) = density · gain(h / softness + ½)            extinction: a step dx takes the part ρ |dx| of the light
//! n(x) = −∇h / |∇h|                                  where ρ changes this is −∇ρ / |∇ρ|
//! ```
//!
//! It is lit as a Lambertian surface across n: a point in which the light of irradiance E (across its way) arrives from
//! the direction l sends color/π · E · max(0, n·l) everywhere alike. Extinction does not depend on the direction in the
//! texel, and in a bent box is, as all depth, that of the step in texel space [method §4].
//!
//! ```text
//! Density ─ table ─► heights on a lattice ─┬─ measure ─► voxels of every level
//!                                          └─ scatter ─► scatterers: what of it is seen and lit from where
//! ```
//!
//! What is built is measured in a table of h, fine enough for the noise; the reference asks the density itself.

pub(crate) mod measure;
mod noise;
pub(crate) mod scatter;
pub(crate) mod table;

use glam::{DVec3, Vec3};

use crate::Hypertexture;
use noise::Noise;

/// A density in `[0, 1]³`, which repeats in s and t.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    parameters: Hypertexture,
    octaves: Vec<Octave>,
}

/// Noise of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Octave {
    noise: Noise,
    /// Cells along a texel edge.
    frequency: f64,
    /// Its part of the whole; the sum over all octaves is 1.
    weight: f64,
}

impl Density {
    /// The density that `parameters` describe; of parameters that do not
    /// [`validate`](crate::Procedure::validate) it is anything at all.
    pub fn new(parameters: &Hypertexture) -> Self {
        let octaves = 0..parameters.octaves.min(16);
        let weight = |i: u32| f64::from(parameters.persistence).powi(i as i32);
        let whole: f64 = octaves.clone().map(weight).sum();
        let octave = |i: u32| {
            let frequency = parameters.frequency.saturating_mul(1 << i);
            let noise = Noise::new(parameters.seed, i.into(), frequency);
            Octave { noise, frequency: f64::from(frequency), weight: weight(i) / whole }
        };
        Self { parameters: parameters.clone(), octaves: octaves.map(octave).collect() }
    }

    /// The finest noise's cells along a texel edge.
    pub(crate) fn finest(&self) -> f64 {
        self.octaves.iter().map(|octave| octave.frequency).fold(1.0, f64::max)
    }

    /// Width of the boundary, in texel edges.
    pub(crate) fn softness(&self) -> f64 {
        f64::from(self.parameters.softness)
    }

    /// Specular albedo, and roughness of the highlight.
    pub fn material(&self) -> [f32; 2] {
        [self.parameters.specular, self.parameters.roughness]
    }

    /// How far a point lies inside the undisturbed shape, in texel edges.
    fn depth(&self, p: DVec3) -> f64 {
        let Hypertexture { size, height, roundness, .. } = self.parameters;
        let d = p - DVec3::new(0.5, 0.5, f64::from(height));
        let across = f64::from(roundness) * d.truncate().length_squared();
        f64::from(size) - (across + d.z * d.z).sqrt()
    }

    /// How far a point of `[0, 1]³` lies under the boundary, in texel edges; negative outside it.
    pub fn height(&self, p: DVec3) -> f64 {
        let fold = f64::from(self.parameters.turbulence);
        let sum: f64 = self
            .octaves
            .iter()
            .map(|octave| octave.weight * folded(octave.noise.at(octave.frequency * p), fold))
            .sum();
        self.depth(p) + f64::from(self.parameters.amplitude) * sum
    }

    /// The part of the full density at a height, 0 to 1.
    fn fill(&self, height: f64) -> f64 {
        gain((height / self.softness() + 0.5).clamp(0.0, 1.0), f64::from(self.parameters.gain))
    }

    /// Extinction at a height, per texel edge.
    pub(crate) fn extinction_at(&self, height: f64) -> f64 {
        f64::from(self.parameters.density) * self.fill(height)
    }

    /// Extinction at a point of `[0, 1]³`, per texel edge.
    pub fn extinction(&self, p: DVec3) -> f64 {
        self.extinction_at(self.height(p))
    }

    /// Linear albedo at a point: from the outer colour on what the noise pushes out of the shape to the inner one in
    /// what it cuts into it.
    pub fn color(&self, p: DVec3) -> Vec3 {
        let Hypertexture { amplitude, softness, inner_color, outer_color, .. } = self.parameters;
        let reach = f64::from(amplitude) + 0.5 * f64::from(softness);
        let inside = (0.5 + 0.5 * self.depth(p) / reach).clamp(0.0, 1.0);
        outer_color.lerp(inner_color, inside as f32)
    }

    /// Unit vector out of the density at a point, by central differences of the height.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        // Texel edges: of noise of 64 cells an edge, differences miss 1e-6.
        const STEP: f64 = 1e-5;
        let slope = |axis: DVec3| self.height(p - STEP * axis) - self.height(p + STEP * axis);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Z)
    }

    /// The most extinction that there may be within `radius` of a point, per texel edge: the shape's height never changes
    /// faster than the distance, and noise is bounded and of bounded slope. \[Hart96\]
    pub fn most(&self, p: DVec3, radius: f64) -> f64 {
        let fold = f64::from(self.parameters.turbulence);
        let noise: f64 = self
            .octaves
            .iter()
            .map(|octave| {
                let change = Noise::STEEPEST * octave.frequency * radius;
                // Where the noise may take its whole range, it need not be asked.
                let [lo, hi] = if change > 2.0 * Noise::MOST {
                    [-Noise::MOST, Noise::MOST]
                } else {
                    let value = octave.noise.at(octave.frequency * p);
                    [(value - change).max(-Noise::MOST), (value + change).min(Noise::MOST)]
                };
                // Folded noise is convex: it is largest at an end.
                octave.weight * folded(lo, fold).max(folded(hi, fold))
            })
            .sum();
        self.extinction_at(self.depth(p) + radius + f64::from(self.parameters.amplitude) * noise)
    }
}

/// Noise of which the part `fold` is folded over at 0: 2 |n| − ½, whose mean is as near 0. [Perlin85]
fn folded(noise: f64, fold: f64) -> f64 {
    noise + fold * (2.0 * noise.abs() - 0.5 - noise)
}

/// Perlin's gain: a line for `g` = ½, steeper in the middle above it, flatter below; as a rational function, without
/// logarithms. [PerlinHoffert89, Schlick94]
fn gain(x: f64, g: f64) -> f64 {
    let k = (1.0 / (1.0 - g) - 2.0) * (1.0 - 2.0 * x);
    if x < 0.5 { x / (k + 1.0) } else { (k - x) / (k - 1.0) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn gain_is_a_line_at_a_half_and_steeper_above() {
        for i in 0..=10 {
            let x = f64::from(i) / 10.0;
            assert!((gain(x, 0.5) - x).abs() < 1e-12);
            // Symmetric about the middle, and of gain g: gain(¼) = (1 − g)/2, by definition.
            assert!((gain(1.0 - x, 0.8) - 1.0 + gain(x, 0.8)).abs() < 1e-12);
        }
        assert!((gain(0.25, 0.8) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn without_noise_it_is_the_shape() {
        let ball = Hypertexture { amplitude: 0.0, gain: 0.5, ..Hypertexture::calm() };
        let density = Density::new(&ball);
        let [size, softness, full] = [ball.size, ball.softness, ball.density].map(f64::from);
        for i in 0..=40 {
            let distance = 0.5 * f64::from(i) / 40.0;
            let p = DVec3::splat(0.5) + distance * DVec3::new(0.48, -0.6, 0.64);
            // A ramp of width `softness` about `size`.
            let expected = full * ((size - distance) / softness + 0.5).clamp(0.0, 1.0);
            assert!((density.extinction(p) - expected).abs() < 1e-9 * full);
            if i > 0 {
                assert!(density.normal(p).dot(DVec3::new(0.48, -0.6, 0.64)) > 1.0 - 1e-6);
            }
        }
    }

    proptest! {
        #[test]
        fn nothing_exceeds_the_bound(
            at in prop::array::uniform3(0.0_f64..1.0),
            offset in prop::array::uniform3(-1.0_f64..1.0),
            radius in 1e-3_f64..0.3,
            preset in 0..3_usize,
        ) {
            let preset = [Hypertexture::calm, Hypertexture::rough, Hypertexture::clouds][preset]();
            let density = Density::new(&preset);
            let p = DVec3::from_array(at);
            let q = p + radius * DVec3::from_array(offset).normalize_or_zero();
            prop_assert!(density.extinction(q) <= density.most(p, radius) + 1e-9);
            prop_assert!(density.most(p, radius) <= f64::from(preset.density));
        }

        #[test]
        fn it_repeats(at in prop::array::uniform3(0.0_f64..1.0)) {
            // The noise does; the shape is asked in the tile only.
            let density = Density::new(&Hypertexture { roundness: 0.0, ..Hypertexture::wild() });
            let p = DVec3::from_array(at);
            prop_assert!((density.height(p + DVec3::new(1.0, -1.0, 0.0)) - density.height(p)).abs() < 1e-9);
        }
    }
}
