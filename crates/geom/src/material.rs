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
    /// How much of the surface is there.
    pub alpha: Alpha,
}

/// How much of a surface is there. Texels are made from what is; an opaque mesh is rendered whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// How it is understood.
    pub mode: AlphaMode,
    /// Multiplies the texture's, in `[0,1]`.
    pub factor: f32,
    /// A texture whose three channels all hold alpha; found through the texture coordinates of the base colour.
    pub texture: Option<TextureId>,
}

/// What alpha means. \[glTF §3.9.4\]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing: all is there.
    #[default]
    Opaque,
    /// What is below this is cut away, the rest is there.
    Mask(f32),
    /// The fraction of the surface that is there.
    Blend,
}

impl Default for Alpha {
    /// All is there.
    fn default() -> Self {
        Self { mode: AlphaMode::Opaque, factor: 1.0, texture: None }
    }
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
            alpha: Alpha::default(),
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
