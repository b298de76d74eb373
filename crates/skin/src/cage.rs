//! A *cage*: the skin between two meshes of the same faces. Corner k of a face in the base and corner k of the same
//! face in the top are two corners of its box, wherever they lie. [Neyret98 §3]
//!
//! Faces are matched by their order, corners by theirs: vertices are not, because importers weld them by position,
//! and what coincides in one mesh need not in the other. A vertex of the base that meets several tops is several
//! vertices of the skin.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use pelage_geom::{Face, Mesh};

use crate::extrude::cover;
use crate::polygon::{Place, place};
use crate::{Skin, SkinError, SkinOptions};

/// Covers the faces of `base` for which `selected` holds with boxes that reach to the same faces of `top`.
///
/// All else is as for [`extrude`](crate::extrude): a quad gets one box or two prisms, decided by the base, except that
/// a base with a concave corner is no reason to cut a box that is valid as it is; where
/// every face of n corners becomes n quads, they divide the boxes that were given; folded boxes are treated as
/// `options` say, and mending draws their tops towards the base. Materials and texture coordinates are the base's.
/// The height that [`SkinOptions::aspect`] refers to is [`mean_height`]; [`SkinOptions::height`] is not read.
///
/// # Errors
/// Those of `extrude`; a `top` that is unusable, or has other faces than `base`, with the first that differs;
/// a [`SkinOptions::lean`] other than zero.
pub fn cage(
    base: &Mesh,
    top: &Mesh,
    selected: &dyn Fn(usize) -> bool,
    options: &SkinOptions,
) -> Result<Skin, SkinError> {
    base.validate()?;
    top.validate().map_err(SkinError::Top)?;
    if options.lean != Vec3::ZERO {
        return Err(SkinError::Option {
            option: "lean",
            value: options.lean.length(),
            expected: "it must be zero, as a cage has its own vectors",
        });
    }
    let torn_vertices = same_faces(base, top)?;
    // Where the top lies on the base, all boxes are folded at whatever height.
    let height = mean_height(base, top, selected).max(f32::MIN_POSITIVE);
    let (mesh, tops) = with_tops(base, top);
    let mut skin = cover(&mesh, Some(tops), selected, &SkinOptions { height, ..*options })?;
    skin.report.torn_vertices = torn_vertices;
    Ok(skin)
}

/// The mean distance of the corners of `base`'s selected faces from those of the same faces of `top`, in metres; zero
/// without any.
pub fn mean_height(base: &Mesh, top: &Mesh, selected: &dyn Fn(usize) -> bool) -> f32 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (face, (below, above)) in base.faces.iter().zip(&top.faces).enumerate() {
        if !selected(face) {
            continue;
        }
        for (&b, &t) in below.corners().iter().zip(above.corners()) {
            if let (Some(b), Some(t)) = (base.positions.get(b as usize), top.positions.get(t as usize)) {
                sum += b.as_dvec3().distance(t.as_dvec3());
                count += 1;
            }
        }
    }
    if count > 0 { (sum / f64::from(count)) as f32 } else { 0.0 }
}

/// Fails at the first face that differs; otherwise counts the vertices of the base that have several tops.
///
/// Welding may merge vertices of either mesh, so one place may go with many of the other mesh. But where a place
/// that has several partners is paired with one that has several too, no welding explains it.
fn same_faces(base: &Mesh, top: &Mesh) -> Result<usize, SkinError> {
    let names = || (base.name.clone(), top.name.clone());
    let corners = |face: &Face| face.corners().len();
    for (face, (below, above)) in base.faces.iter().zip(&top.faces).enumerate() {
        let (base_corners, top_corners) = (corners(below), corners(above));
        if base_corners != top_corners {
            let (base, top) = names();
            return Err(SkinError::CageCorners { base, top, face, base_corners, top_corners });
        }
    }
    let (base_faces, top_faces) = (base.faces.len(), top.faces.len());
    if base_faces != top_faces {
        let (base, top) = names();
        return Err(SkinError::CageFaces { base, top, base_faces, top_faces });
    }
    let pairs = || {
        base.faces.iter().zip(&top.faces).enumerate().flat_map(|(face, (below, above))| {
            below.corners().iter().zip(above.corners()).enumerate().map(move |(corner, (&b, &t))| {
                let places = (place(base.positions[b as usize]), place(top.positions[t as usize]));
                ((face, corner), places)
            })
        })
    };
    let torn = with_several(pairs().map(|(_, (b, t))| (b, t)));
    let joined = with_several(pairs().map(|(_, (b, t))| (t, b)));
    match pairs().find(|(_, (b, t))| torn.contains(b) && joined.contains(t)) {
        Some(((face, corner), _)) => {
            let (base, top) = names();
            Err(SkinError::CageVertices { base, top, face, corner })
        }
        None => Ok(torn.len()),
    }
}

/// The first members of `pairs` that are paired with more than one second.
fn with_several(pairs: impl Iterator<Item = (Place, Place)>) -> HashSet<Place> {
    let mut partner = HashMap::new();
    pairs.filter(|&(a, b)| *partner.entry(a).or_insert(b) != b).map(|(a, _)| a).collect()
}

/// The base with one vertex for each top, and those tops; the first top that a vertex meets keeps its number. Vertices
/// without a face are their own tops.
fn with_tops(base: &Mesh, top: &Mesh) -> (Mesh, Vec<Vec3>) {
    let mut mesh = base.clone();
    let mut tops: Vec<Option<Vec3>> = vec![None; base.positions.len()];
    let mut further = HashMap::new();
    for (face, above) in mesh.faces.iter_mut().zip(&top.faces) {
        for (vertex, &t) in face.vertices.iter_mut().zip(above.corners()) {
            let (b, point) = (*vertex as usize, top.positions[t as usize]);
            if place(*tops[b].get_or_insert(point)) != place(point) {
                *vertex = *further.entry((b, place(point))).or_insert_with(|| {
                    mesh.positions.push(base.positions[b]);
                    for attribute in &mut mesh.attributes {
                        let value = attribute.values[b];
                        attribute.values.push(value);
                    }
                    tops.push(Some(point));
                    (tops.len() - 1) as u32
                });
            }
        }
    }
    let tops = tops.into_iter().zip(&mesh.positions).map(|(t, p)| t.unwrap_or(*p)).collect();
    (mesh, tops)
}
