//! Where an operation acts: a weight from 0 to 1 at each vertex of a skin.

use std::sync::Arc;

use glam::Vec3;
use pelage_geom::{MaterialId, Texture};
use rayon::prelude::*;

use crate::{Skin, SkinError};

/// A weight over a skin. Those of one step multiply.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// Where the weight is 1.
    pub region: Region,
    /// Takes 1 minus the weight instead.
    pub invert: bool,
}

/// Where a mask is 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// Within `radius` of `centre`, falling smoothly to 0 over `falloff` beyond it (metres, by where boxes stand).
    Sphere {
        /// Its centre.
        centre: Vec3,
        /// Not negative.
        radius: f32,
        /// Not negative; 0 for a hard edge.
        falloff: f32,
    },
    /// Between two corners, falling smoothly to 0 over `falloff` beyond them (metres, by where boxes stand).
    Box {
        /// The smallest coordinates.
        min: Vec3,
        /// The largest.
        max: Vec3,
        /// Not negative; 0 for a hard edge.
        falloff: f32,
    },
    /// The vertices of patches that wear one of these materials.
    Materials(Vec<MaterialId>),
    /// The vertices of these patches, by their index in the skin.
    Patches(Vec<u32>),
    /// These vertices, by their index in the skin.
    Vertices(Vec<u32>),
    /// The value of the vertex attribute of this name, between 0 and 1.
    Attribute(String),
    /// The brightness of an image's channel at the texture coordinates, between 0 and 1; the mean, where a vertex has
    /// several.
    Image {
        /// The image, linear.
        texture: Arc<Texture>,
        /// Which part of its colour.
        channel: Channel,
    },
}

/// What of a colour is a weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Channel {
    /// The mean of red, green and blue.
    #[default]
    Mean,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

impl Channel {
    fn of(self, color: Vec3) -> f32 {
        match self {
            Self::Mean => (color.x + color.y + color.z) / 3.0,
            Self::Red => color.x,
            Self::Green => color.y,
            Self::Blue => color.z,
        }
    }
}

impl Mask {
    /// 1 in `region`, 0 elsewhere.
    pub fn new(region: Region) -> Self {
        Self { region, invert: false }
    }

    /// 0 in `region`, 1 elsewhere.
    pub fn outside(region: Region) -> Self {
        Self { region, invert: true }
    }

    /// The weight at each vertex of `skin`, from 0 to 1.
    ///
    /// # Errors
    /// A radius or falloff that is negative, an index that does not exist, an attribute that the skin has not, an
    /// image on a skin without texture coordinates.
    pub fn weights(&self, skin: &Skin) -> Result<Vec<f32>, SkinError> {
        let mut weights = self.region.weights(skin)?;
        if self.invert {
            weights.par_iter_mut().for_each(|w| *w = 1.0 - *w);
        }
        Ok(weights)
    }
}

/// The product of `masks` at each vertex of `skin`; 1 without any.
pub(super) fn product(masks: &[Mask], skin: &Skin) -> Result<Vec<f32>, SkinError> {
    let mut product = vec![1.0; skin.base.len()];
    for mask in masks {
        let weights = mask.weights(skin)?;
        product.par_iter_mut().zip(&weights).for_each(|(p, w)| *p *= w);
    }
    Ok(product)
}

impl Region {
    fn weights(&self, skin: &Skin) -> Result<Vec<f32>, SkinError> {
        let count = skin.base.len();
        let at_each = |f: &(dyn Fn(Vec3) -> f32 + Sync)| skin.base.par_iter().map(|&p| f(p)).collect();
        let fault = |what: String| SkinError::Mask { reason: what };
        let at_some = |vertices: &mut dyn Iterator<Item = u32>| {
            let mut weights = vec![0.0; count];
            for v in vertices {
                weights[v as usize] = 1.0;
            }
            weights
        };
        match self {
            &Self::Sphere { centre, radius, falloff } => {
                if !(centre.is_finite() && radius >= 0.0 && falloff >= 0.0) {
                    return Err(fault("a sphere needs a radius and a falloff that are not negative".into()));
                }
                Ok(at_each(&|p| fading(p.distance(centre) - radius, falloff)))
            }
            &Self::Box { min, max, falloff } => {
                if !(min.cmple(max).all() && falloff >= 0.0) {
                    return Err(fault("a box needs min ≤ max and a falloff that is not negative".into()));
                }
                Ok(at_each(&|p| fading((min - p).max(p - max).max(Vec3::ZERO).length(), falloff)))
            }
            Self::Materials(ids) => {
                let worn = skin.patches.iter().filter(|patch| ids.contains(&patch.material));
                Ok(at_some(&mut worn.flat_map(|patch| patch.corners()).copied()))
            }
            Self::Patches(indices) => {
                if let Some(index) = indices.iter().find(|&&i| i as usize >= skin.len()) {
                    return Err(fault(format!("patch {index} does not exist: there are {}", skin.len())));
                }
                let chosen = indices.iter().map(|&i| &skin.patches[i as usize]);
                Ok(at_some(&mut chosen.flat_map(|patch| patch.corners()).copied()))
            }
            Self::Vertices(indices) => {
                if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
                    return Err(fault(format!("vertex {index} does not exist: there are {count}")));
                }
                Ok(at_some(&mut indices.iter().copied()))
            }
            Self::Attribute(name) => {
                let found = skin.attributes.iter().find(|a| a.name == *name);
                let values = &found.ok_or_else(|| SkinError::NoAttribute { name: name.clone() })?.values;
                Ok(values.iter().map(|x| x.clamp(0.0, 1.0)).collect())
            }
            Self::Image { texture, channel } => by_image(skin, texture, *channel)
                .ok_or_else(|| fault("an image needs texture coordinates, and the mesh has none".into())),
        }
    }
}

/// 1 up to a `distance` of 0, then smoothly down to 0 at `falloff`.
fn fading(distance: f32, falloff: f32) -> f32 {
    match distance {
        d if d <= 0.0 => 1.0,
        d if d < falloff => {
            let x = 1.0 - d / falloff;
            x * x * (3.0 - 2.0 * x)
        }
        _ => 0.0,
    }
}

fn by_image(skin: &Skin, texture: &Texture, channel: Channel) -> Option<Vec<f32>> {
    let uvs = skin.uvs.as_ref()?;
    let mut sums = vec![(0.0_f32, 0.0_f32); skin.base.len()];
    for (patch, uvs) in skin.patches.iter().zip(uvs) {
        for (&v, &uv) in patch.corners().iter().zip(uvs) {
            let (sum, count) = &mut sums[v as usize];
            *sum += channel.of(texture.sample(uv, 0.0)).clamp(0.0, 1.0);
            *count += 1.0;
        }
    }
    Some(sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { 0.0 }).collect())
}
