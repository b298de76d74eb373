//! All faces and strands of a model, piece by piece, in the order of the file.

use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{Vec2, Vec3, Vec4};
use pelage_geom::{MaterialId, Mesh, TextureId};
use pelage_texel::Geometry;
use rayon::prelude::*;

use super::cut::{Extent, Fineness, Pieces, cut};
use super::extremes::Extremes;
use super::paint::{Corner, Paint};
use super::placing::Placing;
use super::strands::Thickness;
use super::tube::tube;
use super::{BakeFault, ContentOptions};
use crate::import::{Imported, Strand};

/// The most triangles that a model becomes: a gigabyte of them.
const MOST: usize = 20_000_000;

/// Faces, or strands, that one thread takes at a time.
const CHUNK: usize = 256;

/// A model, and how it becomes pieces.
pub(super) struct Assembly<'a> {
    model: &'a Imported,
    placing: Placing,
    thickness: Thickness,
    tile: bool,
    resolution: u32,
    /// Of each texture that is worn.
    extremes: Vec<Option<Extremes<'a>>>,
}

/// Pieces, and the area that wears each material.
type Worn = (Pieces, BTreeMap<MaterialId, f64>);

impl<'a> Assembly<'a> {
    pub(super) fn new(
        model: &'a Imported,
        options: &ContentOptions,
        placing: Placing,
        thickness: Thickness,
    ) -> Self {
        let mut is_worn = vec![false; model.textures.len()];
        let textures = model.materials.iter().flat_map(|m| [m.base_color_texture, m.alpha.texture]);
        for TextureId(id) in textures.flatten() {
            if let Some(worn) = is_worn.get_mut(id as usize) {
                *worn = true;
            }
        }
        let textures = model.textures.par_iter().zip(is_worn);
        let extremes = textures.map(|(texture, worn)| worn.then(|| Extremes::new(texture))).collect();
        let (tile, resolution) = (options.tile, options.resolution);
        Self { model, placing, thickness, tile, resolution, extremes }
    }

    /// What of the texel's space is kept.
    pub(super) fn extent(&self) -> Extent {
        Extent::new(self.tile)
    }

    /// All pieces, and the area of each material.
    pub(super) fn pieces(
        &self,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Pieces, Vec<(MaterialId, f64)>), BakeFault> {
        let find = |TextureId(id)| self.extremes.get(id as usize).and_then(Option::as_ref);
        let paints: Vec<Paint> = self.model.materials.iter().map(|m| Paint::new(m, find)).collect();
        let meshes = &self.model.meshes;
        let total = meshes.iter().map(|mesh| mesh.faces.len()).sum::<usize>() + self.model.strands.len();
        let done = AtomicUsize::new(0);
        let report = |more: usize| {
            let done = done.fetch_add(more, Ordering::Relaxed) + more;
            progress(done as f32 / total.max(1) as f32);
        };
        let mut worn = Worn::default();
        for mesh in meshes {
            let name = || format!("mesh `{}`", mesh.name);
            self.check_reach(&name, &mesh.positions)?;
            let add = |face, worn: &mut Worn| self.face(mesh, face, &paints, worn);
            gather(&name, mesh.faces.len(), &add, &report, &mut worn)?;
        }
        let strands = &self.model.strands;
        let name = || "its strands".to_owned();
        for strand in strands {
            self.check_reach(&name, &strand.points)?;
        }
        let add = |i: usize, worn: &mut Worn| self.strand(&strands[i], i, &paints, worn);
        gather(&name, strands.len(), &add, &report, &mut worn)?;
        let (pieces, areas) = worn;
        Ok((pieces, areas.into_iter().collect()))
    }

    /// Refuses what wraps from too far away to be placed within a voxel.
    fn check_reach(&self, name: &dyn Fn() -> String, points: &[Vec3]) -> Result<(), BakeFault> {
        let limit = Geometry::REACH;
        let reach = |&p: &Vec3| self.placing.apply(p).truncate().abs().max_element();
        let distance = points.iter().map(reach).fold(0.0, f32::max);
        if self.tile && distance > limit {
            return Err(BakeFault::Far { what: name(), distance, limit });
        }
        Ok(())
    }

    fn face(&self, mesh: &Mesh, index: usize, paints: &[Paint], (pieces, areas): &mut Worn) {
        let face = &mesh.faces[index];
        let Some(paint) = paints.get(face.material.0 as usize) else { return };
        let corner = |i: usize| Corner {
            position: self.placing.apply(mesh.positions[face.vertices[i] as usize]),
            uv: mesh.uvs.as_ref().map_or(Vec2::ZERO, |uvs| uvs[index][i]),
            color: mesh.colors.as_ref().map_or(Vec4::ONE, |colors| colors[index][i]),
        };
        let halves: &[[usize; 3]] = if face.is_quad() { &[[0, 1, 2], [0, 2, 3]] } else { &[[0, 1, 2]] };
        let before = pieces.area;
        for half in halves {
            let fineness = Fineness::new(self.resolution);
            cut(&half.map(corner), paint, self.extent(), fineness, MOST, pieces);
        }
        *areas.entry(face.material).or_default() += pieces.area - before;
    }

    fn strand(&self, strand: &Strand, index: usize, paints: &[Paint], (pieces, areas): &mut Worn) {
        let Some(paint) = paints.get(strand.material.0 as usize) else { return };
        // Each turned its own way, by the golden angle: together, few-sided tubes are as round as hair.
        let turn = TAU * (index as f64 * 0.618_033_988_749_895).fract() as f32;
        let before = pieces.area;
        for knots in self.thickness.knots(strand, paint, self.placing, &mut pieces.cut) {
            tube(&knots, turn, self.resolution, self.extent(), pieces);
        }
        *areas.entry(strand.material).or_default() += pieces.area - before;
    }
}

/// Adds `count` things, in their order, as many threads as there are taking some at a time.
fn gather(
    name: &dyn Fn() -> String,
    count: usize,
    add: &(dyn Fn(usize, &mut Worn) + Sync),
    report: &(dyn Fn(usize) + Sync),
    worn: &mut Worn,
) -> Result<(), BakeFault> {
    let found = AtomicUsize::new(worn.0.triangles.len());
    let chunk = |chunk: usize| {
        let things = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
        let mut worn = Worn::default();
        for thing in things.clone() {
            // Past the limit there is nothing but the message left to do.
            if found.load(Ordering::Relaxed) <= MOST {
                let before = worn.0.triangles.len();
                add(thing, &mut worn);
                found.fetch_add(worn.0.triangles.len() - before, Ordering::Relaxed);
            }
        }
        report(things.len());
        worn
    };
    let chunks: Vec<Worn> = (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
    if found.into_inner() > MOST {
        return Err(BakeFault::Triangles { what: name(), limit: MOST });
    }
    append(worn, chunks);
    Ok(())
}

fn append((pieces, areas): &mut Worn, chunks: Vec<Worn>) {
    let more = chunks.iter().map(|(pieces, _)| pieces.triangles.len()).sum();
    pieces.triangles.reserve_exact(more);
    pieces.colors.reserve_exact(more);
    for (mut part, worn) in chunks {
        pieces.triangles.append(&mut part.triangles);
        pieces.colors.append(&mut part.colors);
        pieces.area += part.area;
        pieces.cut |= part.cut;
        for (material, area) in worn {
            *areas.entry(material).or_default() += area;
        }
    }
}
