//! The explicit content of all boxes, triangle by triangle.

use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::carrier::Carrier;
use super::content::{Filling, Piece};
use super::world::World;
use super::{Fineness, ReferenceError, ReferenceSettings};
use crate::Scene;
use crate::variety::Tile;

/// A triangle of explicit geometry, where it stands in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Its corners, in scene units.
    pub corners: [Vec3; 3],
    /// Unit normals at the corners: of the curved content that the triangle stands for, or of the mesh. Content is
    /// seen from both sides: its normals are on the side from which the corners wind counter-clockwise.
    pub normals: [Vec3; 3],
    /// Linear albedo at the corners: with the coat's tint and what the surface below wears.
    pub colors: [Vec3; 3],
}

/// What an expansion has of one texel of one coat, or of all opaque meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The texel's name, or `surfaces`.
    pub name: String,
    /// How many triangles it has.
    pub triangles: u64,
    /// The smallest and largest coordinates of their corners.
    pub bounds: [Vec3; 2],
    /// Roughness of its highlight, as in glTF.
    pub roughness: f32,
}

/// A scene as explicit triangles: the opaque meshes, and the content of every coat carried into its boxes.
///
/// It is counted when it is made, and each triangle is made only when it is visited, so that a file of any size may be
/// written of it, or refused beforehand.
pub struct Expansion<'a> {
    world: World<'a>,
    parts: Vec<Part>,
    /// Of each part but the last.
    origins: Vec<Origin>,
}

/// Which content a part is.
struct Origin {
    boxes: Range<u32>,
    /// Which of the coat's texels.
    texel: usize,
}

impl<'a> Expansion<'a> {
    /// Counts what `scene` expands to when its triangles are cut until they are within `fineness` of the curved
    /// content.
    ///
    /// # Errors
    /// Texels without source, whose source is not sound, or that are densities.
    pub fn new(scene: &'a Scene, fineness: Fineness) -> Result<Self, ReferenceError> {
        for (coat, c) in scene.coats.iter().enumerate() {
            if let Some((texel, _)) =
                c.texels.texels.iter().find(|(texel, _)| texel.source().density().is_some())
            {
                return Err(ReferenceError::Density { coat, texel: texel.name.clone() });
            }
        }
        let world = World::new(scene, fineness, ReferenceSettings::default().memory)?;
        let (mut parts, mut origins) = (Vec::new(), Vec::new());
        for (coat, boxes) in scene.boxes_of_coats().enumerate() {
            let texels = &scene.coats[coat].texels.texels;
            for (number, (texel, _)) in texels.iter().enumerate() {
                let counted = boxes.clone().into_par_iter().map(|patch| {
                    let mut size = Size::NONE;
                    visit_box(&world, patch, number, &mut |_, carrier, triangle| {
                        size.add(&triangle.map(|u| (carrier.point(u) + carrier.centre).as_vec3()));
                    });
                    size
                });
                let size = counted.reduce(|| Size::NONE, Size::with);
                parts.push(size.part(&texel.name, texel.roughness));
                origins.push(Origin { boxes: boxes.clone(), texel: number });
            }
        }
        let mut size = Size::NONE;
        scene.surfaces.triangles().for_each(|t| size.add(&t.corners));
        parts.push(size.part("surfaces", 0.6));
        Ok(Self { world, parts, origins })
    }

    /// The coats in their order, each of their texels in theirs, then the opaque meshes.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Triangles in all.
    pub fn triangles(&self) -> u64 {
        self.parts.iter().map(|part| part.triangles).sum()
    }

    /// Makes the triangles of a part (an index of [`Expansion::parts`]), in an order that never changes; ends with the
    /// first error that `visit` gives.
    pub fn visit<E>(&self, part: usize, mut visit: impl FnMut(&Carried) -> Result<(), E>) -> Result<(), E> {
        let scene = self.world.scene;
        let mut outcome = Ok(());
        let Some(Origin { boxes, texel }) = self.origins.get(part) else {
            let mut triangles = scene.surfaces.triangles();
            return triangles.try_for_each(|t| {
                let material = scene.materials.get(t.material.0 as usize);
                let color = |uv: Vec2| material.map_or(Vec3::ONE, |m| scene.colour_of(m, uv, 0.0));
                visit(&Carried { corners: t.corners, normals: t.normals, colors: t.uvs.map(color) })
            });
        };
        for patch in boxes.clone() {
            visit_box(&self.world, patch, *texel, &mut |at, carrier, triangle| {
                if outcome.is_ok() {
                    outcome = visit(&carried(&self.world, patch, at, carrier, triangle));
                }
            });
            if outcome.is_err() {
                break;
            }
        }
        outcome
    }
}

/// A piece of a texel's content, in one of its copies.
#[derive(Clone, Copy)]
struct Copied<'a> {
    piece: &'a Piece,
    tile: &'a Tile,
}

/// Visits the flat triangles of one of the texels of a box, in box coordinates.
fn visit_box(world: &World, patch: u32, texel: usize, visit: &mut dyn FnMut(Copied, &Carrier, &[DVec3; 3])) {
    let filled = world.filled(patch);
    let carrier = &filled.carrier;
    let mut open = Vec::new();
    for t in carrier.copies[1].clone() {
        for s in carrier.copies[0].clone() {
            let (Filling::Triangles(content), tile) = filled.tile([s, t]) else { continue };
            if tile.texel != texel {
                continue;
            }
            for piece in &content.pieces {
                let at = Copied { piece, tile: &tile };
                carrier.clipped(&tile, &piece.corners, |part| open.push((part, 0)));
                while let Some((triangle, halvings)) = open.pop() {
                    match carrier.halves(&triangle, halvings) {
                        Some(halves) => open.extend(halves.map(|half| (half, halvings + 1))),
                        None => visit(at, carrier, &triangle),
                    }
                }
            }
        }
    }
}

fn carried(world: &World, patch: u32, at: Copied, carrier: &Carrier, triangle: &[DVec3; 3]) -> Carried {
    let corners = triangle.map(|u| (carrier.point(u) + carrier.centre).as_vec3());
    let [a, b, c] = triangle.map(|u| carrier.point(u));
    let flat = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3();
    let normals = triangle.map(|u| {
        let normal = carrier.normal(u, at.tile, &at.piece.corners).unwrap_or(flat);
        if normal.dot(flat) < 0.0 { -normal } else { normal }
    });
    let color = at.piece.color * at.tile.tint;
    Carried { corners, normals, colors: triangle.map(|u| color * world.worn(patch, u)) }
}

/// How much there is of something.
#[derive(Clone, Copy)]
struct Size {
    triangles: u64,
    bounds: [Vec3; 2],
}

impl Size {
    const NONE: Self = Self { triangles: 0, bounds: [Vec3::INFINITY, Vec3::NEG_INFINITY] };

    fn add(&mut self, corners: &[Vec3; 3]) {
        self.triangles += 1;
        let [lo, hi] = &mut self.bounds;
        for &p in corners {
            (*lo, *hi) = (lo.min(p), hi.max(p));
        }
    }

    fn with(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.bounds, other.bounds);
        Self { triangles: self.triangles + other.triangles, bounds: [a.min(c), b.max(d)] }
    }

    fn part(self, name: &str, roughness: f32) -> Part {
        let bounds = if self.triangles > 0 { self.bounds } else { [Vec3::ZERO; 2] };
        Part { name: name.to_owned(), triangles: self.triangles, bounds, roughness }
    }
}
