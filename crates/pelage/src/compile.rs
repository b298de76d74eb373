//! From a described scene to one that can be rendered, in stages that callers can time: [`Loaded::new`],
//! [`Loaded::bake`], [`Loaded::extrude`], [`Loaded::compile`].

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use glam::{EulerRot, Mat4, Quat, Vec2, Vec3};
use pelage_geom::Mesh;
use pelage_skin::{Skin, SkinOptions, extrude};
use pelage_texel::{BuildOptions, Fur, Procedure, Texel, build};
use pelage_tracer::{
    Camera, Coat, Description, Environment, Film, Light, Progress, Rect, Scene, Settings, render,
};

use crate::choices::Background;
use crate::compose::{Backdrop, over};
use crate::error::{Error, FieldError};
use crate::import::{Files, ImportOptions, Imported, import};
use crate::names;
use crate::output::{Display, ExrOptions, Format, OutputError, write_exr, write_png};
use crate::scene_file::{CameraEntry, FurEntry, LightEntry, SceneFile, SkinEntry, TexelEntry};
use crate::staging;

/// A scene whose files have been read.
#[derive(Debug)]
pub struct Loaded {
    /// What was described.
    pub file: SceneFile,
    /// What the mesh files hold, each mesh where it stands in the scene.
    pub imported: Imported,
    /// Which faces of which meshes each skin stands on.
    dressed: Vec<Vec<Selection>>,
}

/// The faces of a mesh that wear a skin.
#[derive(Clone, Debug)]
struct Selection {
    mesh: usize,
    /// By face.
    selected: Vec<bool>,
}

/// A skin on a mesh.
#[derive(Clone, Debug)]
pub struct Dressed {
    /// Which entry of [`SceneFile::skin`] it comes from.
    pub entry: usize,
    /// Which mesh of [`Imported::meshes`] it stands on.
    pub mesh: usize,
    /// Its boxes, and the report of their making.
    pub skin: Skin,
}

/// A scene that can be rendered.
pub struct Prepared {
    /// What is seen.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
    /// How.
    pub settings: Settings,
    /// How radiance is shown.
    pub display: Display,
    /// The light of the surroundings, which may be the background too.
    pub environment: Environment,
    /// What was asked to stand behind; `None` leaves it to the format.
    pub background: Option<Background>,
}

impl Loaded {
    /// Reads the mesh files of a scene, puts them in their places and finds what the skins stand on.
    ///
    /// # Errors
    /// A file that cannot be read, a field out of its domain, a name that nothing has.
    pub fn new(file: SceneFile) -> Result<Self, Error> {
        file.validate()?;
        let mut imported = Imported::default();
        for entry in &file.geometry {
            let options = ImportOptions {
                up: entry.up,
                unit: entry.unit,
                allow_dirs: file.allow_dirs.clone(),
                ..ImportOptions::default()
            };
            let files = Files::around(&file.path, &file.allow_dirs, options.limits)?;
            let path = match files.resolve(&entry.file) {
                // Messages name files as the user knows them.
                Ok(_) => file.folder().join(&entry.file),
                Err(fault) => {
                    let reason = format!("`{}` {fault}", entry.file);
                    return Err(FieldError { file: file.path.clone(), field: "geometry".into(), reason }.into());
                }
            };
            let mut part = import(&path, &options)?;
            place(&mut part, entry.scale, entry.rotate, entry.translate);
            imported.append(part);
        }
        for mesh in &imported.meshes {
            mesh.validate().map_err(|e| crate::import::Fault::Mesh(e).at(&file.path, crate::import::Place::File))?;
        }
        let dressed = file
            .skin
            .iter()
            .enumerate()
            .map(|(i, skin)| select(&file, i, skin, &imported))
            .collect::<Result<_, _>>()?;
        Ok(Self { file, imported, dressed })
    }

    /// Builds the texel of each skin; equal ones are built once. `progress` is told the fraction done.
    ///
    /// # Errors
    /// Numbers of a texel out of their domain.
    pub fn bake(&self, progress: &(dyn Fn(f32) + Sync)) -> Result<Vec<Arc<Texel>>, Error> {
        let mut texels: Vec<Arc<Texel>> = Vec::new();
        let count = self.file.skin.len() as f32;
        for (i, entry) in self.file.skin.iter().enumerate() {
            let known = self.file.skin[..i].iter().position(|earlier| earlier.texel == entry.texel);
            let texel = match known {
                Some(same) => texels[same].clone(),
                None => {
                    let TexelEntry::Fur(fur) = &entry.texel;
                    let field = || format!("{}: skin[{i}].texel", self.file.path.display());
                    let fraction = |f: f32| progress((i as f32 + f) / count);
                    Arc::new(bake_fur(fur, &fraction).map_err(|source| Error::Texel { field: field(), source })?)
                }
            };
            texels.push(texel);
        }
        Ok(texels)
    }

    /// Raises the boxes of each skin on each mesh that wears it.
    ///
    /// # Errors
    /// What [`extrude`] refuses.
    pub fn extrude(&self) -> Result<Vec<Dressed>, Error> {
        let mut skins = Vec::new();
        for (entry, (skin, selections)) in self.file.skin.iter().zip(&self.dressed).enumerate() {
            let meshes = || selections.iter().filter_map(|s| self.imported.meshes[s.mesh].bounds());
            let options = SkinOptions {
                tiling: skin.tiling,
                aspect: skin.aspect,
                folds: skin.folds,
                ..SkinOptions::new(skin.height.unwrap_or_else(|| height_for(meshes())))
            };
            for Selection { mesh, selected } in selections {
                let skin = extrude(&self.imported.meshes[*mesh], &|face| selected[face], &options).map_err(
                    |source| {
                        let field = format!("{}: skin[{entry}]", self.file.path.display());
                        Error::Skin { field, source }
                    },
                )?;
                skins.push(Dressed { entry, mesh: *mesh, skin });
            }
        }
        Ok(skins)
    }

    /// Puts everything together. `texels` is what [`Loaded::bake`] returned, `skins` what [`Loaded::extrude`] did.
    ///
    /// # Errors
    /// A camera that no file has; parts that do not make a scene.
    pub fn compile(self, texels: &[Arc<Texel>], skins: Vec<Dressed>) -> Result<Prepared, Error> {
        let Self { file, imported, .. } = self;
        let coats = skins
            .into_iter()
            .filter_map(|dressed| {
                let entry = file.skin.get(dressed.entry)?;
                Some(Coat {
                    skin: dressed.skin,
                    texel: texels.get(dressed.entry)?.clone(),
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
        let description = Description {
            meshes: imported.meshes,
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
        let settings = Settings {
            size: render.size,
            crop: render.crop.map(|[x0, x1, y0, y1]| Rect { x: x0, y: y0, width: x1 - x0, height: y1 - y0 }),
            rays: render.rays,
            path: render.path,
            lod: render.lod,
            opacity: render.opacity,
            shadows: render.shadows,
            ..Settings::default()
        };
        let [lo, hi] = bounds;
        let automatic = staging::exposure(&lights, &environment, 0.5 * (lo + hi));
        let display = Display { exposure: automatic * render.exposure.exp2(), tone: render.tone };
        Ok(Prepared { scene, camera, settings, display, environment, background: render.background })
    }
}

impl Prepared {
    /// Renders the film; [`render`] with what was described.
    ///
    /// # Errors
    /// Settings out of their domain; a stop, with the partial film.
    pub fn render(&self, progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Result<Film, Error> {
        Ok(render(&self.scene, &self.camera, &self.settings, progress)?)
    }

    /// Writes the film, its background behind it: a PNG as a screen shows it, an EXR as linear radiance.
    ///
    /// # Errors
    /// [`OutputError`]; a file of that name is then what it was before.
    pub fn write(&self, film: &Film, path: &Path, format: Format) -> Result<(), OutputError> {
        let film = over(film, &self.camera, &self.backdrop(format));
        match format {
            Format::Png => write_png(&film, path, &self.display),
            Format::Exr => write_exr(&film, path, &ExrOptions { camera: Some(self.camera) }),
        }
    }

    fn backdrop(&self, format: Format) -> Backdrop {
        match (self.background, format) {
            (Some(Background::Sky), _) | (None, Format::Png) => Backdrop::Sky(self.environment),
            (Some(Background::None), _) | (None, Format::Exr) => Backdrop::Transparent,
            (Some(Background::Color(srgb)), format) => {
                let linear = Vec3::from(srgb.map(|x| crate::import::srgb_to_linear(f32::from(x) / 255.0)));
                Backdrop::Color(match format {
                    // So that the screen shows just this colour, whatever the exposure.
                    Format::Png => self.display.radiance_of(linear),
                    Format::Exr => linear,
                })
            }
        }
    }
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
        camera.orientation = glam::Mat3::from_quat(rotation) * camera.orientation;
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

/// The faces that a skin's names select, by mesh.
fn select(file: &SceneFile, index: usize, skin: &SkinEntry, imported: &Imported) -> Result<Vec<Selection>, Error> {
    let Imported { meshes, materials, .. } = imported;
    let wears = |mesh: &Mesh, name: &str| {
        mesh.name == name
            || mesh.faces.iter().any(|f| materials.get(f.material.0 as usize).is_some_and(|m| m.name == name))
    };
    for name in &skin.on {
        if !meshes.iter().any(|mesh| wears(mesh, name)) {
            let known = meshes.iter().map(|m| m.name.as_str()).chain(materials.iter().map(|m| m.name.as_str()));
            let reason = names::unknown("mesh or material", name, known);
            return Err(FieldError { file: file.path.clone(), field: format!("skin[{index}].on"), reason }.into());
        }
    }
    let selected = |mesh: &Mesh| -> Vec<bool> {
        let whole = skin.on.is_empty() || skin.on.contains(&mesh.name);
        let by_material: Vec<bool> = materials.iter().map(|m| skin.on.contains(&m.name)).collect();
        mesh.faces.iter().map(|f| whole || by_material.get(f.material.0 as usize) == Some(&true)).collect()
    };
    Ok(meshes
        .iter()
        .enumerate()
        .map(|(i, mesh)| Selection { mesh: i, selected: selected(mesh) })
        .filter(|s| s.selected.contains(&true))
        .collect())
}

/// 6 % of half the diagonal around the meshes that wear a skin: fur that is seen as fur, and no more.
fn height_for(bounds: impl Iterator<Item = [Vec3; 2]>) -> f32 {
    let around = bounds.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)]);
    around.map_or(0.0, |[lo, hi]| 0.06 * 0.5 * (hi - lo).length()).max(f32::MIN_POSITIVE)
}

fn bake_fur(entry: &FurEntry, progress: &(dyn Fn(f32) + Sync)) -> Result<Texel, pelage_texel::BuildError> {
    let preset = entry.preset.fur();
    let fur = Fur {
        seed: entry.seed.unwrap_or(preset.seed),
        count: entry.count.unwrap_or(preset.count),
        length: entry.length.unwrap_or(preset.length),
        root_radius: entry.root_radius.unwrap_or(preset.root_radius),
        lean: entry.lean.map_or(preset.lean, Vec2::from),
        curl: entry.curl.unwrap_or(preset.curl),
        clump: entry.clump.unwrap_or(preset.clump),
        root_color: entry.root_color.map_or(preset.root_color, Vec3::from),
        tip_color: entry.tip_color.map_or(preset.tip_color, Vec3::from),
        ..preset
    };
    let options = BuildOptions { depth: entry.resolution.ilog2(), ..BuildOptions::standard() };
    build(fur.name(), &fur.geometry()?, &options, progress)
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
fn camera_of(file: &SceneFile, cameras: &[(String, Camera)], bounds: [Vec3; 2]) -> Result<Camera, FieldError> {
    let [width, height] = file.render.size.map(|n| n.max(1) as f32);
    let framed = |view: &staging::View| staging::camera(bounds, view, width / height);
    match (&file.camera, cameras) {
        (Some(CameraEntry::LookAt(c)), _) => {
            let [eye, target, up] = [c.eye, c.target, c.up].map(Vec3::from);
            Ok(Camera::look_at(eye, target, up, c.fov.to_radians()))
        }
        (Some(CameraEntry::Framed(view)), _) => Ok(framed(view)),
        (Some(CameraEntry::Named(name)), _) => {
            cameras.iter().find(|(n, _)| n == name).map(|&(_, camera)| camera).ok_or_else(|| {
                let reason = names::unknown("camera", name, cameras.iter().map(|(n, _)| n.as_str()));
                FieldError { file: file.path.clone(), field: "camera.named".into(), reason }
            })
        }
        (None, [(_, first), ..]) => Ok(*first),
        (None, []) => Ok(framed(&staging::View::default())),
    }
}
