//! What a surface looks like: the part of glTF's material model that a diffuse + specular shader can use.

use glam::Vec3;

use crate::TextureId;

/// An index into a scene's materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// Diffuse + specular, in linear Rec. 709 colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What the file called it; may be empty.
    pub name: String,
    /// Diffuse albedo k_d in `[0,1]`, multiplied by the texture where there is one.
    pub base_color: Vec3,
    /// A texture for the base colour.
    pub base_color_texture: Option<TextureId>,
    /// Specular albedo k_s in `[0,1]`.
    pub specular: f32,
    /// Perceptual roughness in `(0,1]`, as in glTF: α = roughness².
    pub roughness: f32,
    /// Light given off, in radiance.
    pub emissive: Vec3,
}

impl Default for Material {
    /// A matt light grey.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::splat(0.8),
            base_color_texture: None,
            specular: 0.0,
            roughness: 0.6,
            emissive: Vec3::ZERO,
        }
    }
}

impl Material {
    /// The Blinn–Phong exponent whose lobe is as wide as a microfacet lobe of this roughness:
    /// m = 2/α² − 2 with α = roughness².
    pub fn exponent(&self) -> f32 {
        exponent_of_roughness(self.roughness)
    }
}

/// The Blinn–Phong exponent m = 2/α² − 2, α = `roughness`², capped at 10⁴ where the lobe is a mirror's.
pub fn exponent_of_roughness(roughness: f32) -> f32 {
    let alpha = (roughness * roughness).clamp(0.014, 1.0);
    (2.0 / (alpha * alpha) - 2.0).min(1e4)
}
