//! The meshes of a described scene: read from files or made from surfaces, subdivided, and put in their places.

use glam::{EulerRot, Mat3, Mat4, Quat, Vec3};
use pelage_geom::Material;
use pelage_skin::SkinError;
use pelage_skin::tessellate::{
    Parametric, Subdivision, Tessellation, adaptive, smooth_normals, subdivide, uniform,
};
use pelage_tracer::Light;

use crate::error::{Error, Field};
use crate::import::{Fault, Files, ImportOptions, Imported, Place, Textures, import};
use crate::scene_file::{GeometryEntry, SceneFile, SurfaceEntry};

/// What entry `index` of the geometry describes.
pub(super) fn load(file: &SceneFile, index: usize) -> Result<Imported, Error> {
    let (entry, field) = (&file.geometry[index], format!("geometry[{index}]"));
    match &entry.surface {
        None => match &entry.file {
            Some(reference) => read(file, reference, entry, &format!("{field}.file")),
            None => Err(file.fault(field, "needs either a `file` or a `surface`").into()),
        },
        Some(surface) => {
            let mut part = tessellated(file, entry, surface, &field)?;
            shape(&mut part, file, entry, &field)?;
            Ok(part)
        }
    }
}

/// The surface of an entry as a mesh of one material.
fn tessellated(
    file: &SceneFile,
    entry: &GeometryEntry,
    surface: &SurfaceEntry,
    field: &str,
) -> Result<Imported, Error> {
    let surface = parametric(file, surface, field)?;
    let made = match (&entry.errors, entry.patches) {
        (Some(bounds), _) => adaptive(&surface, bounds),
        (None, Some([nu, nv])) => uniform(&surface, nu as usize, nv as usize),
        (None, None) => uniform(&surface, 32, 32),
    };
    let Tessellation { mut mesh, .. } = made.map_err(|source| fault(file, field, source))?;
    let name = entry.name.clone().unwrap_or_else(|| surface.name().to_owned());
    mesh.name.clone_from(&name);
    smooth_normals(&mut mesh, 60.0);
    let base_color = entry.color.map_or(Vec3::splat(0.5), Vec3::from);
    let materials = vec![Material { name, base_color, ..Material::default() }];
    Ok(Imported { meshes: vec![mesh], materials, ..Imported::default() })
}

fn parametric(file: &SceneFile, surface: &SurfaceEntry, field: &str) -> Result<Parametric, Error> {
    Ok(match surface.clone() {
        SurfaceEntry::Plane { size } => Parametric::Plane { size },
        SurfaceEntry::Sphere { radius } => Parametric::Sphere { radius },
        SurfaceEntry::Torus { major, minor } => Parametric::Torus { major, minor },
        SurfaceEntry::Bezier { points } => Parametric::Bezier { points },
        SurfaceEntry::Bspline { points, columns } => {
            Parametric::BSpline { points, columns: columns as usize }
        }
        SurfaceEntry::Heightfield { image, size, height } => {
            let files = Files::around(&file.path, &file.allow_dirs, ImportOptions::default().limits)?;
            let field = format!("{field}.surface.heightfield.image");
            let values = Textures::default().open_values(&image, &files);
            let values = values.map_err(|fault| file.referred(&field, &image, fault))?;
            let [columns, rows] = values.size();
            if columns < 2 || rows < 2 {
                let reason =
                    format!("`{image}` has {columns} × {rows} pixels, and heights need 2 × 2 or more");
                return Err(file.fault(field, reason).into());
            }
            let heights = values.pixels().iter().map(|p| height * (p.x + p.y + p.z) / 3.0).collect();
            Parametric::Heightfield { size, heights, columns }
        }
    })
}

fn fault(file: &SceneFile, field: &str, source: SkinError) -> Error {
    let part = match &source {
        SkinError::Surface { surface, field, .. } => format!(".surface.{surface}.{field}"),
        SkinError::TooFine { .. } => ".errors".into(),
        _ => String::new(),
    };
    // What the field is, the message says already.
    let span = file.field(&format!("{field}{part}")).span;
    Error::Skin { field: Field { span, ..file.field(field) }, source: Box::new(source) }
}

/// Subdivides all that an entry holds and puts it in its place.
fn shape(part: &mut Imported, file: &SceneFile, entry: &GeometryEntry, field: &str) -> Result<(), Error> {
    if entry.subdivide > 0 {
        let subdivision = Subdivision { levels: entry.subdivide, crease_angle: entry.crease_angle };
        for mesh in &mut part.meshes {
            *mesh = subdivide(mesh, &subdivision).map_err(|source| fault(file, field, source))?.mesh;
            smooth_normals(mesh, entry.crease_angle);
        }
    }
    place(part, entry.scale, entry.rotate, entry.translate);
    Ok(())
}

/// Reads the mesh file that `field` of a scene refers to, and puts it where `entry` says.
pub(super) fn read(
    file: &SceneFile,
    reference: &str,
    entry: &GeometryEntry,
    field: &str,
) -> Result<Imported, Error> {
    let options = ImportOptions {
        up: entry.up,
        unit: entry.unit,
        allow_dirs: file.allow_dirs.clone(),
        ..ImportOptions::default()
    };
    let path = file.path.with_file_name(reference);
    // A mesh file that is itself the scene was named by the user, wherever a link of that name leads.
    if path != file.path {
        resolve(file, reference, field)?;
    }
    let mut part = import(&path, &options)?;
    shape(&mut part, file, entry, field)?;
    for mesh in &part.meshes {
        mesh.validate().map_err(|e| Fault::Mesh(e).at(&path, Place::File))?;
    }
    Ok(part)
}

/// Checks that the file that `field` of a scene refers to is there, under the scene's folder or one that is allowed.
pub(super) fn resolve(file: &SceneFile, reference: &str, field: &str) -> Result<(), Error> {
    let files = Files::around(&file.path, &file.allow_dirs, ImportOptions::default().limits)?;
    files.resolve(reference).map(|_| ()).map_err(|fault| file.referred(field, reference, fault))
}

/// Scales, turns and moves all that a file holds.
fn place(part: &mut Imported, scale: f32, rotate: [f32; 3], translate: [f32; 3]) {
    let [x, y, z] = rotate.map(f32::to_radians);
    // About x, then y, then z, all fixed axes.
    let rotation = Quat::from_euler(EulerRot::ZYX, z, y, x);
    let transform =
        Mat4::from_scale_rotation_translation(Vec3::splat(scale), rotation, Vec3::from(translate));
    if transform == Mat4::IDENTITY {
        return;
    }
    for mesh in &mut part.meshes {
        mesh.transform(transform);
    }
    for (_, camera) in &mut part.cameras {
        camera.position = transform.transform_point3(camera.position);
        camera.orientation = Mat3::from_quat(rotation) * camera.orientation;
    }
    for light in &mut part.lights {
        match light {
            Light::Directional { direction, .. } => *direction = rotation * *direction,
            Light::Point { position, radius, .. } => {
                *position = transform.transform_point3(*position);
                *radius *= scale;
            }
            Light::Spot { position, direction, radius, .. } => {
                *position = transform.transform_point3(*position);
                *direction = rotation * *direction;
                *radius *= scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::Loaded;

    fn loaded(files: &[(&str, &[u8])], scene: &str) -> Result<Loaded, Error> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).expect("a file");
        }
        Loaded::new(SceneFile::parse(scene, &folder.path().join("scene.toml"))?)
    }

    #[test]
    fn surfaces_are_meshes_with_a_name_and_a_colour() {
        let torus = "surface = { torus = { major = 1, minor = 0.4 } }";
        let scene = format!(
            "geometry = [{{ {torus}, patches = [12, 8] }}, \
             {{ {torus}, errors = {{ arc = 0.05 }}, name = 'Ring', color = [1, 0, 0], translate = [0, 5, 0] }}]"
        );
        let Imported { meshes, materials, .. } = loaded(&[], &scene).expect("a scene").imported;
        assert_eq!((meshes[0].name.as_str(), meshes[0].faces.len()), ("torus", 96));
        assert_eq!((meshes[1].name.as_str(), materials[1].name.as_str()), ("Ring", "Ring"));
        assert_eq!((materials[0].base_color, materials[1].base_color), (Vec3::splat(0.5), Vec3::X));
        assert!(meshes[1].positions.iter().all(|p| p.y > 4.5) && meshes[1].normals.is_some());
        // By name, like any mesh.
        let dressed = loaded(&[], &format!("{scene}\n[[skin]]\non = 'Ring'\nheight = 0.1")).expect("a scene");
        let skins = dressed.extrude().expect("a skin");
        assert_eq!((skins.len(), skins[0].mesh), (1, 1));
    }

    #[test]
    fn files_are_subdivided_before_they_are_placed() {
        let quad = b"o Q\nv 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nf 1 2 3 4\n";
        let scene = "geometry = [{ file = 'q.obj', subdivide = 2, translate = [0, 3, 0] }]";
        let mesh = &loaded(&[("q.obj", quad)], scene).expect("a scene").imported.meshes[0];
        assert_eq!((mesh.faces.len(), mesh.positions.len()), (16, 25));
        assert!(mesh.positions.contains(&Vec3::new(1.0, 3.0, -1.0)));
    }

    #[test]
    fn heights_come_from_an_image() {
        let mut png = std::io::Cursor::new(Vec::new());
        // Black on the left, white on the right, half grey between.
        let image = image::GrayImage::from_fn(3, 2, |x, _| image::Luma([[0, 128, 255][x as usize]]));
        image.write_to(&mut png, image::ImageFormat::Png).expect("an image");
        let scene = "geometry = [{ surface = { heightfield = { image = 'h.png', size = [2, 1], height = 4 } }, patches = [2, 1] }]";
        let loaded = loaded(&[("h.png", png.get_ref())], scene).expect("a scene");
        for p in &loaded.imported.meshes[0].positions {
            let expected = [0.0, 4.0 * 128.0 / 255.0, 4.0][(p.x + 1.0).round() as usize];
            assert!((p.y - expected).abs() < 1e-5, "{p}");
        }
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (entry, message) in [
            ("", "geometry[0]: needs either a `file` or a `surface`"),
            (
                "file = 'a.obj', surface = { sphere = { radius = 1 } }",
                "geometry[0]: needs either a `file` or",
            ),
            ("file = 'a.obj', patches = [1, 2]", "geometry[0].patches: is of surfaces only"),
            ("file = 'a.obj', subdivide = 11", "geometry[0].subdivide: must be at most 10"),
            ("surface = { sphere = { radius = -1 } }", "geometry[0]: sphere: radius must be positive"),
            (
                "surface = { sphere = { radius = 1 } }, patches = [0, 1]",
                "geometry[0].patches: must be at least 1",
            ),
            (
                "surface = { sphere = { radius = 1 } }, errors = { arc = 0 }",
                "geometry[0].errors.arc: must be positive",
            ),
            (
                "surface = { sphere = { radius = 1 } }, errors = { arc = 1e-6 }",
                "geometry[0]: sphere: at least ",
            ),
            (
                "surface = { ball = { radius = 1 } }",
                "scene.toml:1:27: geometry[0].surface: there is no kind `ball`: there are `",
            ),
            (
                "surface = { bezier = { points = [] } }",
                "geometry[0]: bezier: points must hold 16 control points",
            ),
            (
                "surface = { heightfield = { image = 'no.png', size = [1, 1], height = 1 } }",
                "geometry[0].surface.heightfield.image: refers to `no.png`, which cannot be read",
            ),
        ] {
            let error = loaded(&[], &format!("geometry = [{{ {entry} }}]")).expect_err(entry).to_string();
            assert!(error.contains(message) && !error.contains('\n'), "{entry}: {error}");
        }
    }
}
