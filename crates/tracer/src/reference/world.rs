//! What the reference renderer knows of a scene: the explicit content of every coat, and where its boxes are.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use pelage_skin::Anchor;
use pelage_texel::Texel;

use super::carrier::Carrier;
use super::content::{Content, Filling, Missing, geometry_of};
use super::medium::Medium;
use super::{Fineness, ReferenceError};
use crate::accel::Tree;
use crate::variety::Tile;
use crate::{Coat, Scene};

/// A scene with the explicit content of its texels.
pub(super) struct World<'a> {
    pub scene: &'a Scene,
    /// Of each coat, by texel; equal texels share one.
    contents: Vec<Vec<Arc<Filling>>>,
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
        let mut known = Known { by_texel: HashMap::new(), needed: 0, memory };
        let contents = (scene.coats.iter().enumerate())
            .map(|(coat, c)| c.texels.texels.iter().map(|(texel, _)| known.content(coat, texel)).collect())
            .collect::<Result<Vec<_>, _>>()?;
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
    pub(super) fn filled(&self, patch: u32) -> Filled<'_> {
        let (coat, p) = self.scene.patch(patch);
        let hexahedron = self.scene.hexahedron(patch);
        let contents = &self.contents[self.scene.coat_index(patch)];
        let bounds = coat.skin.bounds(self.scene.patch_index(patch));
        let height = hexahedron.map().sides().z;
        let tolerance = self.fineness.tolerance(bounds, height);
        let every_copy = coat.texels.plain().is_none() || contents.iter().any(|c| c.is_periodic());
        let carrier = Carrier::new(hexahedron, &p.lattice, every_copy, tolerance);
        Filled { contents, carrier, coat, anchor: p.anchor }
    }

    /// What the content of a box is multiplied by at box coordinates, in all copies: the coat's tint, what was painted on the skin, and the colour of the surface
    /// below where the coat wears it.
    pub(super) fn worn(&self, patch: u32, at: DVec3) -> Vec3 {
        let (coat, p) = self.scene.patch(patch);
        let material = self.scene.materials.get(p.material.0 as usize).filter(|_| coat.wears_material);
        let (index, u) = (self.scene.patch_index(patch), at.as_vec3());
        let tint = coat.tint * coat.skin.color(index, [u.x, u.y]);
        let Some(material) = material else { return tint };
        let uvs = coat.skin.uvs.as_ref().and_then(|uvs| uvs.get(index));
        let Some(&[a, b, c, d]) = uvs else { return tint * material.base_color };
        let uv = if p.is_prism() {
            a + u.x * (b - a) + u.y * (c - a)
        } else {
            a.lerp(b, u.x).lerp(c.lerp(d, u.x), u.y)
        };
        tint * self.scene.colour_of(material, uv, 0.0)
    }
}

/// What a box holds.
pub(super) struct Filled<'a> {
    /// By texel of the coat.
    contents: &'a [Arc<Filling>],
    /// What carries it into the box.
    pub carrier: Carrier,
    coat: &'a Coat,
    anchor: Anchor,
}

impl<'a> Filled<'a> {
    /// What stands in a copy, and how.
    pub(super) fn tile(&self, copy: [i32; 2]) -> (&'a Filling, Tile) {
        let tile = match self.coat.texels.plain() {
            Some(_) => Tile::upright(copy),
            None => self.coat.texels.tile(&self.anchor, copy),
        };
        (&self.contents[tile.texel], tile)
    }

    /// Whether nothing stands in any copy.
    pub(super) fn is_empty(&self) -> bool {
        self.contents.iter().all(|content| content.is_empty())
    }
}

/// The contents made so far.
struct Known {
    by_texel: HashMap<*const Texel, Arc<Filling>>,
    /// Bytes that they take, and may take.
    needed: u64,
    memory: u64,
}

impl Known {
    /// The explicit content of a texel of a coat.
    fn content(&mut self, coat: usize, texel: &Arc<Texel>) -> Result<Arc<Filling>, ReferenceError> {
        if let Some(content) = self.by_texel.get(&Arc::as_ptr(texel)) {
            return Ok(content.clone());
        }
        let filling = if let Some(density) = texel.source().density() {
            Filling::Density(Medium::new(density, texel.periodic))
        } else {
            let name = || texel.name.clone();
            let geometry = geometry_of(texel).map_err(|missing| match missing {
                Missing::Source => ReferenceError::Source { coat, texel: name() },
                Missing::Unsound(reason) => ReferenceError::Content { coat, texel: name(), reason },
            })?;
            // Asked before it is made: a triangle takes this much with its part of the tree, at least.
            self.check(self.needed + 100 * geometry.triangles.len() as u64)?;
            Filling::Triangles(Content::new(&geometry, texel.periodic))
        };
        self.needed += filling.memory();
        self.check(self.needed)?;
        let filling = Arc::new(filling);
        self.by_texel.insert(Arc::as_ptr(texel), filling.clone());
        Ok(filling)
    }

    fn check(&self, needed: u64) -> Result<(), ReferenceError> {
        let memory = self.memory;
        if needed > memory { Err(ReferenceError::Memory { needed, memory }) } else { Ok(()) }
    }
}
