//! glTF materials. [glTF §3.9]
//!
//! | field | becomes |
//! |---|---|
//! | base colour factor and texture | base colour; KHR_texture_transform moves the texture coordinates |
//! | metalness, roughness | a metal loses its diffuse light as far as it is smooth: × 1 − metalness·(1 − roughness); a rough one looks diffuse in its own colour, and reflections of surroundings are not traced |
//! | dielectric | specular albedo 0.04, times KHR_materials_specular's factor; 0 where KHR_materials_unlit |
//! | emissive factor and strength | emission |
//! | alpha mode, cutoff, factor, and the alpha of the base colour's texture | alpha; the texture only for content |
//!
//! Without a texture that can be decoded, the factors alone. Metalness is taken as 0 where a texture gives it.

use std::collections::HashMap;

use glam::{Mat2, Vec2, Vec3};
use gltf::json;
use json::material::AlphaMode as FileAlphaMode;
use json::texture::Info;
use json::validation::Checked;
use pelage_geom::{Alpha, AlphaMode, Material, TextureId};

use super::super::image::Textures;
use super::super::{Fault, ImportError, Place, Warning};
use super::buffers::{Document, fetch};

/// Which texture coordinates the base colour uses, and how they are moved: uv ↦ `linear` uv + `offset`, both
/// with v downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvMap {
    pub(super) set: u32,
    linear: Mat2,
    offset: Vec2,
}

impl Default for UvMap {
    fn default() -> Self {
        Self { set: 0, linear: Mat2::IDENTITY, offset: Vec2::ZERO }
    }
}

impl UvMap {
    /// The moved coordinates, v upwards; `None` if they are not finite.
    pub(super) fn apply(&self, uv: Vec2) -> Option<Vec2> {
        let moved = self.linear * uv + self.offset;
        moved.is_finite().then_some(Vec2::new(moved.x, 1.0 - moved.y))
    }
}

/// Materials and what they need, in the order of the file.
#[derive(Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    pub(super) uv_maps: Vec<UvMap>,
    pub(super) textures: Textures,
    /// By image index: each is decoded once, and so is each fault found.
    by_image: HashMap<(usize, Channels), Option<TextureId>>,
    /// Whether alpha textures are wanted.
    content: bool,
}

/// Which channels of an image are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channels {
    Color,
    Alpha,
}

impl Materials {
    /// With `content`, alpha textures too.
    pub(super) fn read(
        document: &Document,
        content: bool,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, ImportError> {
        let mut materials = Self { content, ..Self::default() };
        for (i, material) in document.root.materials.iter().enumerate() {
            materials.add(document, i, material, warnings)?;
        }
        // What a primitive without a material wears, behind all others.
        materials.list.push(Material { base_color: Vec3::splat(0.8), ..Material::default() });
        materials.uv_maps.push(UvMap::default());
        Ok(materials)
    }

    fn add(
        &mut self,
        document: &Document,
        i: usize,
        material: &json::Material,
        warnings: &mut Vec<Warning>,
    ) -> Result<(), ImportError> {
        let pbr = &material.pbr_metallic_roughness;
        let extensions = material.extensions.as_ref();
        let roughness = pbr.roughness_factor.0;
        let metalness = if pbr.metallic_roughness_texture.is_some() { 0.0 } else { pbr.metallic_factor.0 };
        let [r, g, b, a] = pbr.base_color_factor.0;
        let factor = Vec3::new(r, g, b);
        let emissive = Vec3::from(material.emissive_factor.0)
            * extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
        let specular =
            0.04 * extensions.and_then(|e| e.specular.as_ref()).map_or(1.0, |s| s.specular_factor.0);
        let Checked::Valid(mode) = material.alpha_mode else {
            let fault = Fault::Syntax("has an unknown alphaMode".into());
            return Err(document.fault(format!("materials[{i}]"), fault));
        };
        let cutoff = material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
        let numbers = [roughness, metalness, specular, a, cutoff];
        if !(factor.is_finite() && emissive.is_finite() && numbers.iter().all(|x| x.is_finite())) {
            let fault = Fault::NotANumber("a factor of the material".into());
            return Err(document.fault(format!("materials[{i}]"), fault));
        }
        let (metalness, roughness) = (metalness.clamp(0.0, 1.0), roughness.clamp(0.01, 1.0));
        let mut uv_map = UvMap::default();
        let mut texture = None;
        let mut alpha = Alpha {
            mode: match mode {
                FileAlphaMode::Opaque => AlphaMode::Opaque,
                FileAlphaMode::Mask => AlphaMode::Mask(cutoff),
                FileAlphaMode::Blend => AlphaMode::Blend,
            },
            factor: a.clamp(0.0, 1.0),
            texture: None,
        };
        if let Some(info) = &pbr.base_color_texture {
            uv_map = uv_map_of(info);
            texture = self.texture(document, info, i, Channels::Color, warnings)?;
            if self.content && alpha.mode != AlphaMode::Opaque {
                alpha.texture = self.texture(document, info, i, Channels::Alpha, warnings)?;
            }
        }
        let unlit = extensions.is_some_and(|e| e.unlit.is_some());
        let base_color = factor.clamp(Vec3::ZERO, Vec3::ONE);
        let brightness = base_color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let specular =
            specular.clamp(0.0, 1.0) * (1.0 - metalness) + brightness * metalness * (1.0 - roughness);
        self.list.push(Material {
            name: material.name.clone().unwrap_or_default(),
            base_color: base_color * (1.0 - metalness * (1.0 - roughness)),
            base_color_texture: texture,
            specular: if unlit { 0.0 } else { specular },
            roughness,
            emissive: emissive.max(Vec3::ZERO),
            alpha,
        });
        self.uv_maps.push(uv_map);
        Ok(())
    }

    fn texture(
        &mut self,
        document: &Document,
        info: &Info,
        material: usize,
        channels: Channels,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<TextureId>, ImportError> {
        let field = format!("materials[{material}].pbrMetallicRoughness.baseColorTexture");
        let texture = document.get(&document.root.textures, info.index, "texture", &field)?;
        let image_index = texture.source.value();
        if let Some(&known) = self.by_image.get(&(image_index, channels)) {
            return Ok(known);
        }
        let image = document.get(&document.root.images, texture.source, "image", &field)?;
        let image_field = format!("images[{image_index}]");
        let mut decode = |bytes: &[u8]| match channels {
            Channels::Color => self.textures.decode(bytes, document.files).map(Some),
            Channels::Alpha => self.textures.decode_alpha(bytes, document.files, false),
        };
        let decoded = match (image.buffer_view, &image.uri) {
            (Some(view), _) => decode(document.view(view)?.0),
            (None, Some(uri)) => fetch(uri, document.files).and_then(|bytes| decode(&bytes)),
            (None, None) => Err(Fault::Syntax("has neither `uri` nor `bufferView`".into())),
        };
        let known = match decoded {
            Ok(id) => id,
            // A bomb is refused; anything else costs colours and no geometry.
            Err(fault @ Fault::Limit { .. }) => return Err(document.fault(image_field, fault)),
            // Said of the colours already.
            Err(_) if channels == Channels::Alpha => None,
            Err(fault) => {
                warnings.push(Warning {
                    file: document.path.to_owned(),
                    place: Place::Field(image_field),
                    message: format!("the texture is left out: {fault}"),
                });
                None
            }
        };
        self.by_image.insert((image_index, channels), known);
        Ok(known)
    }
}

/// KHR_texture_transform: scale, then rotate counter-clockwise in (u, v downwards), then move.
fn uv_map_of(info: &Info) -> UvMap {
    let Some(transform) = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()) else {
        return UvMap { set: info.tex_coord, ..UvMap::default() };
    };
    let (sin, cos) = transform.rotation.0.sin_cos();
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    UvMap {
        set: transform.tex_coord.unwrap_or(info.tex_coord),
        linear: rotation * Mat2::from_diagonal(Vec2::from(transform.scale.0)),
        offset: Vec2::from(transform.offset.0),
    }
}
