//! What the reference renderer knows of a scene: the explicit content of every coat, and where its boxes are.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use pelage_texel::Texel;

use super::carrier::Carrier;
use super::content::{Content, Filling, Missing, geometry_of};
use super::medium::Medium;
use super::{Fineness, ReferenceError};
use crate::Scene;
use crate::accel::Tree;

/// A scene with the explicit content of its texels.
pub(super) struct World<'a> {
    pub scene: &'a Scene,
    /// By coat; equal texels share one.
    contents: Vec<Arc<Filling>>,
    /// Over all boxes, relative to the middle of the scene.
    pub boxes: Tree,
    /// The middle of all boxes, in the scene.
    pub centre: DVec3,
    /// Half the diagonal of the bounds of all boxes.
    pub radius: f64,
    fineness: Fineness,
}

impl<'a> World<'a> {
    /// Cuts the content of every texel to its tile. No more than `memory` bytes are used.
    pub(super) fn new(scene: &'a Scene, fineness: Fineness, memory: u64) -> Result<Self, ReferenceError> {
        let mut known: HashMap<*const Texel, Arc<Filling>> = HashMap::new();
        let mut contents = Vec::with_capacity(scene.coats.len());
        let mut needed = 0;
        for (coat, c) in scene.coats.iter().enumerate() {
            if let Some(content) = known.get(&Arc::as_ptr(&c.texel)) {
                contents.push(content.clone());
                continue;
            }
            let texel = c.texel.name.clone();
            if let Some(density) = c.texel.source().density() {
                let content = Arc::new(Filling::Density(Medium::new(density, c.texel.periodic)));
                needed += content.memory();
                known.insert(Arc::as_ptr(&c.texel), content.clone());
                contents.push(content);
                continue;
            }
            let geometry = geometry_of(&c.texel).map_err(|missing| match missing {
                Missing::Source => ReferenceError::Source { coat, texel: texel.clone() },
                Missing::Unsound(reason) => ReferenceError::Content { coat, texel: texel.clone(), reason },
            })?;
            // Asked before it is made: a triangle takes this much with its part of the tree, at least.
            let least = needed + 100 * geometry.triangles.len() as u64;
            let check = |needed| {
                if needed > memory { Err(ReferenceError::Memory { needed, memory }) } else { Ok(()) }
            };
            check(least)?;
            let content = Arc::new(Filling::Triangles(Content::new(&geometry, c.texel.periodic)));
            needed += content.memory();
            check(needed)?;
            known.insert(Arc::as_ptr(&c.texel), content.clone());
            contents.push(content);
        }
        let bounds: Vec<[Vec3; 2]> =
            scene.coats.iter().flat_map(|c| (0..c.skin.len()).map(|patch| c.skin.bounds(patch))).collect();
        let around =
            bounds.iter().copied().reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)]).unwrap_or_default();
        let [lo, hi] = around.map(|p| p.as_dvec3());
        let centre = 0.5 * (lo + hi);
        let local = |p: Vec3| (p.as_dvec3() - centre).as_vec3();
        let bounds: Vec<[Vec3; 2]> = bounds.into_iter().map(|b| b.map(local)).collect();
        Ok(Self {
            scene,
            contents,
            boxes: Tree::new(&bounds),
            centre,
            radius: 0.5 * (hi - lo).length(),
            fineness,
        })
    }

    /// What a box holds, and what carries it there.
    pub(super) fn filled(&self, patch: u32) -> (&Filling, Carrier) {
        let (coat, p) = self.scene.patch(patch);
        let hexahedron = self.scene.hexahedron(patch);
        let content = &self.contents[self.scene.coat_index(patch)];
        let bounds = coat.skin.bounds(self.scene.patch_index(patch));
        let height = hexahedron.map().sides().z;
        let tolerance = self.fineness.tolerance(bounds, height);
        (content, Carrier::new(hexahedron, &p.lattice, content.is_periodic(), tolerance))
    }

    /// What the content of a box is multiplied by at box coordinates: the coat's tint, and the colour of the surface
    /// below where the coat wears it.
    pub(super) fn worn(&self, patch: u32, at: DVec3) -> Vec3 {
        let (coat, p) = self.scene.patch(patch);
        let material = self.scene.materials.get(p.material.0 as usize).filter(|_| coat.wears_material);
        let Some(material) = material else { return coat.tint };
        let uvs = coat.skin.uvs.as_ref().and_then(|uvs| uvs.get(self.scene.patch_index(patch)));
        let Some(&[a, b, c, d]) = uvs else { return coat.tint * material.base_color };
        let u = at.as_vec3();
        let uv = if p.is_prism() {
            a + u.x * (b - a) + u.y * (c - a)
        } else {
            a.lerp(b, u.x).lerp(c.lerp(d, u.x), u.y)
        };
        coat.tint * self.scene.colour_of(material, uv, 0.0)
    }
}
