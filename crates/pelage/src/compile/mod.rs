//! From a described scene to one that can be rendered, in stages that callers can time: [`Loaded::new`],
//! [`Loaded::bake`], [`Loaded::extrude`], [`Loaded::compile`].

mod cage;
mod dress;
mod geometry;
mod groom;
mod prepared;
mod texel;

use std::sync::Arc;

use glam::Vec3;
use pelage_skin::groom::Step;
use pelage_texel::Texel;
use pelage_tracer::reference::ReferenceSettings;
use pelage_tracer::{Camera, Coat, Description, Environment, Light, Rect, Scene, Settings, Variety};

pub use dress::Dressed;
use dress::Selection;
use geometry::{read, resolve};
pub use prepared::Prepared;

use crate::choices::Method;
use crate::error::{Error, FieldError};
use crate::import::Imported;
use crate::output::Display;
use crate::scene_file::{CameraEntry, LightEntry, SceneFile, SkinEntry, VarietyEntry};
use crate::staging;

/// Takes a mistake: to give it back, which ends everything, or to go on without what is wrong.
pub(crate) type Note<'a> = &'a mut dyn FnMut(Error) -> Result<(), Error>;

/// A scene whose files have been read.
#[derive(Debug)]
pub struct Loaded {
    /// What was described.
    pub file: SceneFile,
    /// What the mesh files hold, each mesh where it stands in the scene.
    pub imported: Imported,
    /// Which faces of which meshes each skin stands on.
    dressed: Vec<Vec<Selection>>,
    /// What is done to the boxes of each skin.
    grooms: Vec<Vec<Step>>,
    /// The texels that are in files.
    texels: Vec<texel::Known>,
    /// Which entry of the geometry each mesh comes from.
    origins: Vec<usize>,
}

impl Loaded {
    /// Reads the mesh files of a scene, puts them in their places and finds what the skins stand on.
    ///
    /// # Errors
    /// A file that cannot be read, a field out of its domain, a name that nothing has.
    pub fn new(file: SceneFile) -> Result<Self, Error> {
        file.validate()?;
        Self::load(file, &mut Err)
    }

    /// The same of a scene whose numbers are in their domains. What is wrong is left out if `note` lets it go on.
    pub(crate) fn load(file: SceneFile, note: Note<'_>) -> Result<Self, Error> {
        let mut imported = Imported::default();
        let mut origins = Vec::new();
        for i in 0..file.geometry.len() {
            match geometry::load(&file, i) {
                Ok(part) => {
                    origins.extend(part.meshes.iter().map(|_| i));
                    imported.append(part);
                }
                Err(error) => note(error)?,
            }
        }
        let texels = texel::read_all(&file, note)?;
        let (mut dressed, mut grooms) = (Vec::new(), Vec::new());
        for (i, skin) in file.skin.iter().enumerate() {
            let mut selections = match dress::select(&file, i, skin, &imported) {
                Ok(selections) => selections,
                Err(error) => {
                    note(error)?;
                    Vec::new()
                }
            };
            if let Some(entry) = &skin.cage
                && let Err(error) = cage::put_on(&mut selections, &file, i, entry, &mut imported, &origins)
            {
                note(error)?;
                selections.clear();
            }
            grooms.push(groom::steps(&file, i, &selections, &imported, note)?);
            dressed.push(selections);
        }
        if let Some(CameraEntry::Named(name)) = &file.camera
            && let Err(error) = camera_named(&file, &imported.cameras, name)
        {
            note(error.into())?;
        }
        Ok(Self { file, imported, dressed, grooms, texels, origins })
    }

    /// Puts everything together. `texels` is what [`Loaded::bake`] returned, `skins` what [`Loaded::extrude`] did.
    ///
    /// # Errors
    /// A camera that no file has; parts that do not make a scene.
    pub fn compile(self, texels: &[Vec<Arc<Texel>>], skins: Vec<Dressed>) -> Result<Prepared, Error> {
        let Self { file, imported, origins, .. } = self;
        // Meshes that wear the same skin have copies of their own.
        let mut worn = vec![0_u32; file.skin.len()];
        let coats = skins
            .into_iter()
            .filter_map(|dressed| {
                let (entry, worn) = (file.skin.get(dressed.entry)?, worn.get_mut(dressed.entry)?);
                *worn += 1;
                Some(Coat {
                    skin: dressed.skin,
                    texels: variety(entry, texels.get(dressed.entry)?, *worn - 1),
                    tint: Vec3::from(entry.tint),
                    wears_material: entry.wears_material,
                })
            })
            .collect();
        let mut lights: Vec<Light> = file.light.iter().map(light_of).collect();
        lights.extend(imported.lights);
        let environment = match file.environment {
            Some(e) => Environment { sky: Vec3::from(e.sky), ground: Vec3::from(e.ground) },
            None if lights.is_empty() => {
                lights.push(staging::sun());
                staging::sky()
            }
            None => Environment::BLACK,
        };
        let visible = |&origin: &usize| file.geometry[origin].visible;
        let meshes = imported.meshes.into_iter().zip(&origins);
        let description = Description {
            meshes: meshes.filter(|(_, origin)| visible(origin)).map(|(mesh, _)| mesh).collect(),
            coats,
            materials: imported.materials,
            textures: imported.textures,
            lights: lights.clone(),
            environment,
        };
        let scene = Scene::new(description)?;
        let bounds = scene.bounds().unwrap_or([Vec3::ZERO; 2]);
        let camera = camera_of(&file, &imported.cameras, bounds)?;
        let render = &file.render;
        let quality = Settings::of(render.quality);
        let settings = Settings {
            size: render.size,
            crop: render.crop.map(|[x0, x1, y0, y1]| Rect { x: x0, y: y0, width: x1 - x0, height: y1 - y0 }),
            rays: render.rays.unwrap_or(quality.rays),
            path: render.path,
            lod: render.lod,
            opacity: render.opacity,
            shadows: render.shadows,
            ..quality
        };
        let reference = (render.method == Method::Reference).then(|| {
            let Settings { size, crop, shadows, .. } = settings;
            let default = ReferenceSettings::default();
            ReferenceSettings {
                size,
                crop,
                shadows,
                samples: render.spp.unwrap_or(default.samples),
                ..default
            }
        });
        let [lo, hi] = bounds;
        let automatic = staging::exposure(&lights, &environment, 0.5 * (lo + hi));
        let display = Display { exposure: automatic * render.exposure.exp2(), tone: render.tone };
        Ok(Prepared {
            scene,
            camera,
            settings,
            reference,
            display,
            environment,
            background: render.background,
        })
    }
}

/// How the texels of a skin stand in the copies on the `mesh`-th of the meshes that wear it.
fn variety(entry: &SkinEntry, texels: &[Arc<Texel>], mesh: u32) -> Variety {
    let weights = entry.texels().map(|(_, weight)| weight);
    let VarietyEntry { turns, mirrors, height, color, seed } = entry.variety;
    // Far apart, so that no mesh has what another has under the next seed.
    let seed = seed.wrapping_add(mesh.wrapping_mul(0x9e37_79b9));
    Variety { texels: texels.iter().cloned().zip(weights).collect(), turns, mirrors, height, color, seed }
}

fn light_of(entry: &LightEntry) -> Light {
    match *entry {
        LightEntry::Directional { direction, illuminance, angle } => Light::Directional {
            direction: Vec3::from(direction),
            illuminance: Vec3::from(illuminance),
            angle: angle.to_radians(),
        },
        LightEntry::Point { position, intensity, radius } => {
            Light::Point { position: Vec3::from(position), intensity: Vec3::from(intensity), radius }
        }
        LightEntry::Spot { position, direction, intensity, inner, outer, radius } => Light::Spot {
            position: Vec3::from(position),
            direction: Vec3::from(direction),
            intensity: Vec3::from(intensity),
            inner: inner.to_radians(),
            outer: outer.to_radians(),
            radius,
        },
    }
}

/// The camera asked for; else the first of the mesh files; else one that sees everything.
fn camera_of(
    file: &SceneFile,
    cameras: &[(String, Camera)],
    bounds: [Vec3; 2],
) -> Result<Camera, FieldError> {
    let [width, height] = file.render.size.map(|n| n.max(1) as f32);
    let framed = |view: &staging::View| staging::camera(bounds, view, width / height);
    match (&file.camera, cameras) {
        (Some(CameraEntry::LookAt(c)), _) => {
            let [eye, target, up] = [c.eye, c.target, c.up].map(Vec3::from);
            Ok(Camera::look_at(eye, target, up, c.fov.to_radians()))
        }
        (Some(CameraEntry::Framed(view)), _) => Ok(framed(view)),
        (Some(CameraEntry::Named(name)), _) => camera_named(file, cameras, name),
        (None, [(_, first), ..]) => Ok(*first),
        (None, []) => Ok(framed(&staging::View::default())),
    }
}

fn camera_named(file: &SceneFile, cameras: &[(String, Camera)], name: &str) -> Result<Camera, FieldError> {
    cameras
        .iter()
        .find(|(n, _)| n == name)
        .map(|&(_, camera)| camera)
        .ok_or_else(|| file.unknown("camera.named", "camera", name, cameras.iter().map(|(n, _)| n.as_str())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_1_SQRT_2;

    /// Two unit quads side by side, of two materials, in a folder of their own.
    fn loaded(scene: &str) -> Result<Loaded, Error> {
        loaded_with(&[], scene)
    }

    /// The same with more files.
    fn loaded_with(files: &[(&str, &str)], scene: &str) -> Result<Loaded, Error> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).expect("a file");
        }
        let obj = "o Sheet\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 0 -1\nv 1 0 -1\nv 0 0 -1\n\
                   usemtl left\nf 1 2 5 6\nusemtl right\nf 2 3 4 5\n";
        std::fs::write(folder.path().join("sheet.obj"), obj).expect("a file");
        Loaded::new(SceneFile::parse(scene, &folder.path().join("scene.toml"))?)
    }

    const SHEET: &str = "geometry = [{ file = \"sheet.obj\" }]\n";

    #[test]
    fn names_select_faces() {
        let boxes = |on: &str| {
            let scene = loaded(&format!("{SHEET}[[skin]]\non = {on}\nheight = 0.1\n")).expect("a scene");
            scene.extrude().expect("skins").iter().map(|d| d.skin.report.boxes).sum::<usize>()
        };
        assert_eq!(boxes("\"right\""), 1);
        assert_eq!(boxes("[\"right\", \"left\"]"), 2);
        assert_eq!(boxes("\"Sheet\""), 2);
        assert_eq!(boxes("[]"), 2);
    }

    #[test]
    fn copies_are_as_wide_as_asked_without_texture_coordinates() {
        // Faces of 1 m, copies of 1.5 · 0.05 = 0.075 m: 13.3 of them.
        let scene = loaded(&format!("{SHEET}[[skin]]\nheight = 0.05\n")).expect("a scene");
        assert_eq!(scene.extrude().expect("skins")[0].skin.report.tiling, 13.0);
        let scene = loaded(&format!("{SHEET}[[skin]]\nheight = 0.05\ntiling = 2\n")).expect("a scene");
        assert_eq!(scene.extrude().expect("skins")[0].skin.report.tiling, 2.0);
    }

    #[test]
    fn the_default_height_is_six_per_cent_of_half_the_diagonal() {
        let scene = loaded(&format!("{SHEET}[[skin]]\n")).expect("a scene");
        let skin = &scene.extrude().expect("skins")[0].skin;
        // The sheet is 2 m × 1 m.
        let height = skin.base[0].distance(skin.top[0]);
        assert!((height - 0.06 * 0.5 * 5_f32.sqrt()).abs() < 1e-6, "{height}");
    }

    #[test]
    fn unseen_meshes_wear_skins_but_are_not_there() {
        // A coat of nothing: a spheres texel of no radius.
        let skin = "[[skin]]\nheight = 0.1\ntexel.spheres = { side = 1, fill = 0, resolution = 2 }\n";
        let alpha = |visible: bool| {
            let geometry = format!("geometry = [{{ file = \"sheet.obj\", visible = {visible} }}]\n");
            let camera =
                "camera.look_at = { eye = [1, 3, -0.5], target = [1, 0, -0.5], up = [0, 0, -1], fov = 10 }\n";
            let render = "[render]\nsize = [2, 2]\n";
            let loaded = loaded(&format!("{geometry}{camera}{skin}{render}")).expect("a scene");
            let (texels, skins) = (loaded.bake(&|_| {}).expect("texels"), loaded.extrude().expect("skins"));
            assert_eq!(skins[0].skin.report.boxes, 2);
            let prepared = loaded.compile(&texels, skins).expect("a scene");
            let film = prepared.render(&|_| std::ops::ControlFlow::Continue(())).expect("a film");
            film.pixels.iter().map(|p| p.alpha).sum::<f32>() / 4.0
        };
        assert_eq!(alpha(true), 1.0);
        assert_eq!(alpha(false), 0.0);
    }

    #[test]
    fn equal_texels_are_built_once() {
        let fur =
            |seed: u32| format!("[[skin]]\ntexel.fur = {{ resolution = 4, count = 50, seed = {seed} }}\n");
        let scene = loaded(&format!("{SHEET}{}{}{}", fur(1), fur(2), fur(1))).expect("a scene");
        let texels = scene.bake(&|_| {}).expect("texels");
        assert!(Arc::ptr_eq(&texels[0][0], &texels[2][0]) && !Arc::ptr_eq(&texels[0][0], &texels[1][0]));
    }

    /// The sheet, 0.2 m higher.
    const TOP: &str =
        "o Sheet\nv 0 .2 0\nv 1 .2 0\nv 2 .2 0\nv 2 .2 -1\nv 1 .2 -1\nv 0 .2 -1\nf 1 2 5 6\nf 2 3 4 5\n";

    #[test]
    fn cages_stand_where_their_meshes_do() {
        let geometry =
            "geometry = [{ file = \"sheet.obj\", scale = 2, rotate = [0, 0, 90], translate = [0, 0, 7] }]\n";
        let scene = loaded_with(&[("top.obj", TOP)], &format!("{geometry}[[skin]]\ncage = \"top.obj\"\n"));
        let skins = scene.and_then(|scene| scene.extrude()).expect("a skin");
        let skin = &skins[0].skin;
        assert_eq!((skin.report.boxes, skin.report.torn_vertices), (2, 0));
        // Twice 0.2 m along +Y, turned about z to −X.
        for (base, top) in skin.base.iter().zip(&skin.top) {
            assert!((*top - *base).distance(-0.4 * Vec3::X) < 1e-6, "{base} {top}");
        }
        // Copies of 1.5 · 0.4 m on faces of 2 m: 3.3 of them.
        assert_eq!(skin.report.tiling, 3.0);
    }

    #[test]
    fn cages_that_make_no_sense_are_named() {
        let two = format!(
            "{TOP}{}",
            TOP.replace("Sheet", "Other").replace("f 1 2 5 6\nf 2 3 4 5", "f -6 -5 -2 -1")
        );
        let one_face = TOP.replace("f 2 3 4 5\n", "");
        let files = [("top.obj", TOP), ("two.obj", &two), ("one.obj", &one_face)];
        for (cage, message) in [
            ("'missing.obj'", "skin[0].cage: refers to `missing.obj`, which cannot be read: "),
            ("'../top.obj'", "skin[0].cage: refers to `../top.obj`, which is outside of the scene's folder"),
            (
                "'one.obj'",
                "mesh `Sheet` has 2 faces and the top of its cage, `Sheet`, has 1: face 1 is in one",
            ),
            (
                "{ file = 'two.obj', mesh = 'Shet' }",
                "skin[0].cage: in `two.obj`, there is no mesh `Shet`: did you mean `Sheet`?",
            ),
            (
                "{ file = 'two.obj', mesh = 'Other' }",
                "mesh `Sheet` has 2 faces and the top of its cage, `Other`",
            ),
            ("'top.obj'\nheight = 0.1", "skin[0].height: must be left out beside `cage`"),
            ("'top.obj'\nlean = [0, 0, 1]", "skin[0].lean: must be left out beside `cage`"),
            ("{ file = 'top.obj', mesh = '' }", "skin[0].cage.mesh: must not be an empty name"),
            ("3", "a path, or a table with `file` and `mesh`"),
        ] {
            let scene = loaded_with(&files, &format!("{SHEET}[[skin]]\ncage = {cage}\n"));
            let error = scene.and_then(|scene| scene.extrude()).expect_err(cage).to_string();
            assert!(error.contains(message), "{cage}: {error}");
            assert!(error.contains("scene.toml") && !error.contains('\n'), "{error}");
        }
        // By the name of the mesh below, where there are several.
        let scene = loaded_with(&files, &format!("{SHEET}[[skin]]\ncage = \"two.obj\"\n"));
        assert_eq!(scene.and_then(|scene| scene.extrude()).expect("a skin")[0].skin.len(), 2);
    }

    #[test]
    fn a_cage_is_for_one_mesh() {
        let twice = |translate: &str| {
            format!(
                "geometry = [{{ file = \"sheet.obj\" }}, {{ file = \"sheet.obj\", translate = {translate} }}]\n"
            )
        };
        // The same file in two places: each has its own.
        let scene = loaded_with(
            &[("top.obj", TOP)],
            &format!("{}[[skin]]\ncage = \"top.obj\"\n", twice("[0, 5, 0]")),
        );
        let skins = scene.and_then(|scene| scene.extrude()).expect("two skins");
        assert!((skins[1].skin.top[0].y, skins[0].skin.top[0].y) == (5.2, 0.2));
        let pair =
            TOP.to_owned() + &TOP.replace("Sheet", "Other").replace("f 1 2 5 6\nf 2 3 4 5", "f -6 -5 -2 -1");
        let scene = loaded_with(
            &[("top.obj", TOP), ("pair.obj", &pair)],
            "geometry = [{ file = \"pair.obj\" }]\n[[skin]]\ncage = \"top.obj\"\n",
        );
        let error = scene.expect_err("two meshes").to_string();
        let expected = "skin[0].cage: is for one mesh, but `Sheet` and `Other` wear it: name one in `on`";
        assert!(error.ends_with(expected), "{error}");
    }

    #[test]
    fn meshes_are_scaled_then_turned_then_moved() {
        let scene = loaded(
            "geometry = [{ file = \"sheet.obj\", scale = 2, rotate = [90, 0, 45], translate = [0, 0, 7] }]",
        )
        .expect("a scene");
        // The corner (2, 0, −1) becomes (4, 0, −2); about x by 90°: (4, 2, 0); about z by 45°: (2, 6, 0) / √2.
        let expected = Vec3::new(2.0 * FRAC_1_SQRT_2, 6.0 * FRAC_1_SQRT_2, 7.0);
        let corner = scene.imported.meshes[0].positions.iter().any(|p| p.distance(expected) < 1e-5);
        assert!(corner, "{:?}", scene.imported.meshes[0].positions);
    }

    #[test]
    fn the_sun_shines_where_nothing_else_does() {
        let lights = |more: &str| {
            let prepared =
                loaded(&format!("{SHEET}{more}")).and_then(|l| l.compile(&[], vec![])).expect("a scene");
            (prepared.environment, prepared.display.exposure)
        };
        let (sky, exposure) = lights("");
        assert_eq!(sky, staging::sky());
        let (black, _) = lights("[[light]]\npoint = { position = [1, 9, 0], intensity = [1, 1, 1] }\n");
        assert_eq!(black, Environment::BLACK);
        // A white surface under a white sky of radiance 1 needs no exposure but its own; a stop doubles that.
        let white = "[environment]\nsky = [1, 1, 1]\nground = [1, 1, 1]\n";
        assert!((lights(white).1 - staging::WHITE).abs() < 1e-6);
        assert!((lights("[render]\nexposure = 1\n").1 / exposure - 2.0).abs() < 1e-6);
    }
}
