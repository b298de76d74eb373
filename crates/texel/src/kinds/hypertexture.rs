//! Hypertexture: a soft shape whose boundary noise pushes in and out. [PerlinHoffert89]

use glam::Vec3;

use super::parameter::{check, parameters};
use crate::{BuildError, Density, Geometry, Procedure};

parameters! {
    /// A shape without a surface: dense inside, nothing outside, and between them a soft boundary that Perlin's noise
    /// displaces. It has no triangles: it is a density.
    pub struct Hypertexture {
        /// Which of the many alike.
        seed: u64,
        /// Half the thickness of the shape: the radius of a ball.
        size: f32 in 0..=1 ["texel edges"],
        /// w of its middle.
        height: f32 in 0..=1 ["texel edges"],
        /// 1 for a ball, 0 for a layer across the whole tile, between them a lens.
        roundness: f32 in 0..=1,
        /// Width of the boundary, across which it goes from nothing to full.
        softness: f32 in 0.01..=1 ["texel edges"],
        /// How far noise displaces the boundary.
        amplitude: f32 in 0..=1 ["texel edges"],
        /// How often the coarsest noise changes along an edge.
        frequency: u32 in 1..=64 ["cells a texel edge"],
        /// How many noises are summed up, each half as large in size as the one before.
        octaves: u32 in 1..=7,
        /// Amplitude of each octave over that of the one before.
        persistence: f32 in 0..=1,
        /// How much of each octave is folded over: 0 for smooth noise, 1 for turbulence, which billows.
        turbulence: f32 in 0..=1,
        /// How steep the middle of the boundary is: 0.5 for a linear ramp, nearer to 1 for a harder one.
        gain: f32 in 0.05..=0.95,
        /// Extinction where it is full: how often light is stopped over an edge.
        density: f32 in 0..=1000 ["per texel edge"],
        /// Its colour in what noise cuts into the shape.
        inner_color: Vec3 in 0..=1,
        /// Its colour on what noise pushes out of it.
        outer_color: Vec3 in 0..=1,
        /// Specular albedo.
        specular: f32 in 0..=1,
        /// Roughness of the highlight.
        roughness: f32 in 0..=1,
    }
}

impl Hypertexture {
    /// The most cells along an edge that the finest octave may have: the table that a texel is measured in holds four
    /// points a cell.
    const FINEST: u32 = 64;

    /// A ball with hardly any noise.
    pub fn calm() -> Self {
        Self {
            seed: 1,
            size: 0.36,
            height: 0.5,
            roundness: 1.0,
            softness: 0.06,
            amplitude: 0.04,
            frequency: 4,
            octaves: 4,
            persistence: 0.5,
            turbulence: 0.0,
            gain: 0.5,
            density: 60.0,
            inner_color: Vec3::new(0.36, 0.1, 0.03),
            outer_color: Vec3::new(0.95, 0.68, 0.3),
            specular: 0.0,
            roughness: 1.0,
        }
    }

    /// A ball that noise has made a rock.
    pub fn rough() -> Self {
        Self { size: 0.34, amplitude: 0.13, ..Self::calm() }
    }

    /// A ball that noise tears apart.
    pub fn wild() -> Self {
        Self { size: 0.3, amplitude: 0.3, softness: 0.08, ..Self::calm() }
    }

    /// A layer of billowing clouds.
    pub fn clouds() -> Self {
        Self {
            size: 0.16,
            height: 0.4,
            roundness: 0.0,
            softness: 0.12,
            amplitude: 0.24,
            frequency: 2,
            octaves: 5,
            turbulence: 1.0,
            density: 40.0,
            inner_color: Vec3::splat(0.9),
            outer_color: Vec3::splat(0.97),
            ..Self::calm()
        }
    }

    /// Its density.
    pub fn density(&self) -> Density {
        Density::new(self)
    }
}

impl Default for Hypertexture {
    fn default() -> Self {
        Self::calm()
    }
}

impl Procedure for Hypertexture {
    fn name(&self) -> &'static str {
        "hypertexture"
    }

    fn validate(&self) -> Result<(), BuildError> {
        check(&self.parameters())?;
        let finest = u64::from(self.frequency) << (self.octaves - 1);
        if finest > u64::from(Self::FINEST) {
            let domain = "1 to 7, and few enough that frequency · 2^(octaves − 1) is at most 64";
            return Err(BuildError::Parameter { field: "octaves", value: self.octaves.into(), domain });
        }
        Ok(())
    }

    /// None: it has no surface.
    fn geometry(&self) -> Geometry {
        Geometry { specular: self.specular, roughness: self.roughness, ..Geometry::default() }
    }
}
