//! From a mesh to its skin: along its normals, or as far as was given. [Neyret98 §3] [seed §4.1]

use glam::Vec3;
use pelage_geom::{Attribute, Face, Mesh};

use crate::dressing::{self, Plan};
use crate::polygon::{self, Surface};
use crate::settle::{Wanted, settle};
use crate::{Border, Folds, Layout, Patch, Report, Skin, SkinError, SkinOptions};
use crate::{conformal, normals, refine};

/// Covers the faces of `mesh` for which `selected` holds with a skin.
///
/// A quad gets one box, or two prisms where its texture coordinates or its shape ask for it; a triangle gets
/// one prism. Without texture coordinates to lay the texel out by, and with a triangle among the
/// faces, every face of n corners becomes n quads first. All that was out of the ordinary is in
/// [`Skin::report`]; a skin may come out empty where every box was left out.
///
/// # Errors
/// A mesh or an option out of its domain, nothing to cover, [`Layout::Uv`] without texture coordinates, or, under
/// [`Folds::Refuse`], a folded box.
pub fn extrude(
    mesh: &Mesh,
    selected: &dyn Fn(usize) -> bool,
    options: &SkinOptions,
) -> Result<Skin, SkinError> {
    mesh.validate()?;
    cover(mesh, None, selected, options)
}

/// The way from a valid mesh to its skin; `tops`, one a vertex, are where the boxes reach, by default along the normals.
pub(crate) fn cover(
    mesh: &Mesh,
    tops: Option<Vec<Vec3>>,
    selected: &dyn Fn(usize) -> bool,
    options: &SkinOptions,
) -> Result<Skin, SkinError> {
    options.validate()?;
    if options.layout == Layout::Uv && mesh.uvs.is_none() {
        return Err(SkinError::NoUvs { mesh: mesh.name.clone() });
    }
    let mut report = Report::default();
    let mut surface = polygon::collect(mesh, tops, selected, options.border == Border::Mesh, &mut report);
    if surface.polygons.is_empty() {
        let (faces, zero_area) = (mesh.faces.len(), report.zero_area_faces.len());
        return Err(SkinError::NothingSelected { mesh: mesh.name.clone(), faces, zero_area });
    }
    if options.layout == Layout::Conformal {
        let (faces, most) = (surface.polygons.len(), conformal::MOST_FACES);
        if faces > most {
            return Err(SkinError::ConformalSize { mesh: mesh.name.clone(), faces, most });
        }
        let coordinates = conformal::coordinates(&surface);
        surface.polygons.iter_mut().zip(coordinates).for_each(|(polygon, laid)| polygon.laid = laid);
    }
    let plan = Plan::new(&surface, mesh.uvs.is_some(), options);
    report.refined = matches!(plan, Plan::PerPatch { .. }) && refine::has_triangles(&surface);
    check_size(mesh, &surface, report.refined)?;
    if report.refined {
        surface = refine::refine(surface);
    }
    polygon::count_edges(&surface.polygons, &mut report);

    let (mut patches, uvs) = dressing::dress(&surface, plan, options, &mut report);
    if mesh.uvs.is_some() && options.layout == Layout::Auto && matches!(plan, Plan::PerPatch { .. }) {
        report.zero_area_uvs = patches.len();
    }
    let (tops, cancelled, turned) = match surface.tops.take() {
        Some(tops) => (tops, Vec::new(), Vec::new()),
        None => {
            let vectors = normals::vectors(&surface.positions, &patches, &surface.bystanders);
            let reach = |(p, n): (&Vec3, &Vec3)| *p + options.height * tilted(*n, options.lean);
            let tops = surface.positions.iter().zip(&vectors.unit).map(reach).collect();
            (tops, vectors.cancelled, vectors.turned)
        }
    };
    let used = number_vertices(&surface, &mut patches);
    let (base, full) = (gather(&surface.positions, &used), gather(&tops, &used));
    let among_used = |all: &[u32]| -> Vec<u32> {
        all.iter().filter_map(|v| used.binary_search(v).ok()).map(|i| i as u32).collect()
    };
    report.cancelled_normals = among_used(&cancelled);
    report.turned_normals = among_used(&turned).len();

    let wanted = Wanted { base: &base, top: &full, upright: None };
    let settled = settle(wanted, &patches, |_| false, &options.mending());
    if let (Folds::Refuse, Some(&first)) = (options.folds, settled.folds.first()) {
        return Err(SkinError::Folded { mesh: mesh.name.clone(), count: settled.folds.len(), first });
    }
    let uvs = mesh.uvs.is_some().then_some(uvs);
    let of_used = |a: &Attribute| Attribute { name: a.name.clone(), values: gather(&a.values, &used) };
    let attributes = surface.attributes.iter().map(of_used).collect();
    let mut skin = Skin { base, top: Vec::new(), patches, uvs, attributes, colors: None, report };
    settled.apply(&mut skin);
    skin.report.copy_width = copy_width(&skin.patches, &skin.base);
    Ok(skin)
}

/// Refuses a surface whose skin might have more vertices or patches than indices can name.
fn check_size(mesh: &Mesh, surface: &Surface, refined: bool) -> Result<(), SkinError> {
    let faces = surface.polygons.len() + surface.bystanders.len();
    // A quad that is not convex is the worst: five edges and two centres, six quads of perhaps two prisms each.
    let (more_vertices, patches_each) = if refined { (7 * faces, 12) } else { (0, 2) };
    for (what, count) in
        [("vertices", surface.positions.len() + more_vertices), ("patches", patches_each * faces)]
    {
        if count >= Face::NONE as usize {
            return Err(SkinError::TooLarge { mesh: mesh.name.clone(), what, count });
        }
    }
    Ok(())
}

/// Numbers the vertices that `patches` use, in their order, and returns what each was in `surface`.
fn number_vertices(surface: &Surface, patches: &mut [Patch]) -> Vec<u32> {
    let mut place = vec![Face::NONE; surface.positions.len()];
    for &v in patches.iter().flat_map(Patch::corners) {
        place[v as usize] = 0;
    }
    let used: Vec<u32> = (0..place.len() as u32).filter(|&v| place[v as usize] == 0).collect();
    for (i, &v) in used.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    for v in patches.iter_mut().flat_map(|p| &mut p.vertices).filter(|v| **v != Face::NONE) {
        *v = place[*v as usize];
    }
    used
}

/// A unit normal tilted by the part of `lean` across it; unit length.
fn tilted(normal: Vec3, lean: Vec3) -> Vec3 {
    (normal + lean.reject_from_normalized(normal.normalize_or(Vec3::Y))).normalize_or(normal)
}

fn gather<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&i| values[i as usize]).collect()
}

/// Mean side of a copy of the texel, in metres: the root of the area of the base over the copies on it.
fn copy_width(patches: &[Patch], base: &[Vec3]) -> f32 {
    let (mut area, mut copies) = (0.0, 0.0);
    for patch in patches {
        let outline = patch.outline();
        let p = |i: usize| {
            base[if outline[i] == Face::NONE { outline[0] } else { outline[i] } as usize].as_dvec3()
        };
        area += 0.5 * (p(2) - p(0)).cross(p(3) - p(1)).length();
        let determinant = f64::from(patch.lattice.determinant().abs());
        copies += if patch.is_prism() { 0.5 * determinant } else { determinant };
    }
    if copies > 0.0 { (area / copies).sqrt() as f32 } else { 0.0 }
}
