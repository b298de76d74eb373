//! How light is reflected by a surface: Lambert's cosine and a highlight. [method §7]

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use pelage_geom::Vec3x4;
use pelage_geom::material::exponent_of_roughness;
use wide::f32x4;

/// A highlight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gloss {
    /// What it reflects where it is brightest, as a radiance of unit illuminance; 0 of what is matt.
    height: f32,
    exponent: f32,
}

impl Gloss {
    /// Of a material with this specular albedo and roughness, both from 0 to 1. The factor between albedo and height
    /// keeps what is reflected in all at or under the albedo.
    pub fn new(specular: f32, roughness: f32) -> Self {
        if specular == 0.0 {
            return Self::default();
        }
        Self::of_exponent(specular, exponent_of_roughness(roughness))
    }

    fn of_exponent(specular: f32, exponent: f32) -> Self {
        let m = exponent;
        let norm = (m + 2.0) * (m + 4.0) / (8.0 * PI * (m + (-0.5 * m).exp2()));
        Self { height: specular * norm, exponent }
    }

    /// The exponent of the highlight, if there is one.
    pub fn exponent(self) -> Option<f32> {
        (self.height > 0.0).then_some(self.exponent)
    }

    /// What unit illuminance from `to_light` becomes: diffuse and specular of one normal, times the cosine to the light.
    /// `half` is half-way between the directions to the light and to the eye; all of unit length.
    #[inline]
    pub fn reflected(self, albedo: Vec3, normal: Vec3, to_light: Vec3, half: Vec3) -> Vec3 {
        let cosine = normal.dot(to_light);
        if cosine <= 0.0 {
            return Vec3::ZERO;
        }
        let mut reflected = albedo * FRAC_1_PI;
        if self.height > 0.0 {
            reflected += self.height * normal.dot(half).max(0.0).powf(self.exponent);
        }
        cosine * reflected
    }

    /// The mean of [`reflected`](Self::reflected) over several normals: of `albedo` times cosine, and of cosine times the
    /// highlight of height 1.
    #[inline]
    pub fn reflected_mean(self, albedo: Vec3, highlight: f32) -> Vec3 {
        albedo * FRAC_1_PI + self.height * highlight
    }

    /// [`reflected`](Self::reflected) of four normals and their albedos.
    #[inline]
    pub fn reflected_x4(self, albedo: Vec3x4, normal: Vec3x4, to_light: Vec3, half: Vec3) -> Vec3x4 {
        let cosine = normal.dot(Vec3x4::splat(to_light)).max(f32x4::ZERO);
        let mut reflected = albedo * f32x4::splat(FRAC_1_PI);
        if self.height > 0.0 {
            let near = normal.dot(Vec3x4::splat(half)).max(f32x4::ZERO).to_array();
            let highlight = near.map(|near| self.height * near.powf(self.exponent));
            reflected += Vec3x4::splat(Vec3::ONE) * f32x4::new(highlight);
        }
        reflected * cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_conserves_energy() {
        // ∫ specular cos dω over the hemisphere, seen along the normal, by the midpoint rule: at most k_s, and
        // not far below it for a narrow lobe.
        for (exponent, least) in [(2.0, 0.55), (20.0, 0.85), (400.0, 0.97)] {
            let gloss = Gloss::of_exponent(1.0, exponent);
            let (n, m) = (2000, 64);
            let mut albedo = 0.0_f64;
            for i in 0..n {
                let cosine = (i as f32 + 0.5) / n as f32;
                for j in 0..m {
                    let (sin, cos) = (j as f32 / m as f32 * 2.0 * PI).sin_cos();
                    let s = (1.0 - cosine * cosine).sqrt();
                    let to_light = Vec3::new(s * cos, s * sin, cosine);
                    let half = (Vec3::Z + to_light).normalize();
                    albedo += f64::from(gloss.reflected(Vec3::ZERO, Vec3::Z, to_light, half).x);
                }
            }
            albedo *= 2.0 * std::f64::consts::PI / f64::from(n * m);
            assert!(albedo <= 1.001 && albedo >= least, "exponent {exponent}: albedo {albedo}");
        }
    }

    #[test]
    fn four_normals_are_one_and_one() {
        let light = Vec3::new(0.3, 0.9, -0.2).normalize();
        let normals = [Vec3::X, Vec3::Y, -Vec3::Z, -Vec3::Y].map(|n| (n + 0.3 * light).normalize());
        let half = (light + Vec3::Z).normalize();
        for gloss in [Gloss::new(0.0, 0.5), Gloss::new(0.3, 0.4)] {
            let albedo = Vec3::new(0.1, 0.5, 0.9);
            let four = gloss.reflected_x4(Vec3x4::splat(albedo), Vec3x4::new(normals), light, half);
            let one = normals.map(|n| gloss.reflected(albedo, n, light, half));
            assert!((four.sum() - one.into_iter().sum::<Vec3>()).length() < 1e-6);
            assert_eq!(four.y.to_array().map(|y| y > 0.0), one.map(|v| v.y > 0.0));
        }
    }
}
