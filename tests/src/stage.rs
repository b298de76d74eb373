//! Where coats are judged against their geometry: white content on a flat and on a bent skin, three suns, and cameras
//! that see a box so many pixels wide.

use std::ops::ControlFlow;
use std::sync::Arc;

use pelage::geom::Material;
use pelage::geom::glam::Vec3;
use pelage::skin::{Skin, SkinOptions, extrude, surface};
use pelage::texel::{Fur, Geometry, Grass, Leaves, Procedure, Sheet, Texel};
use pelage::tracer::reference::{self, Lighting, ReferenceSettings};
use pelage::tracer::{Camera, Coat, Description, Environment, Film, Light, Rect, Scene, Settings};

use crate::{mean_alpha, picture};

/// What is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// One tilted plane.
    Sheet,
    /// Leaves in mid-air, turned anyhow.
    Leaves,
    /// A meadow.
    Grass,
    /// Thin separate hairs.
    Fur,
}

impl Content {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sheet, Self::Leaves, Self::Grass, Self::Fur];

    /// Its triangles: white, so that every error of light shows in full, and without a highlight.
    pub fn geometry(self) -> Geometry {
        let mut geometry = match self {
            Self::Sheet => Sheet::tilted().geometry(),
            Self::Leaves => Leaves { tilt: 1.0, ..Leaves::green() }.geometry(),
            Self::Grass => Grass::meadow().geometry(),
            Self::Fur => Fur::hair().geometry(),
        };
        geometry.colors.fill(Vec3::ONE);
        geometry.specular = 0.0;
        geometry
    }
}

/// Boxes a side of the skins, each about one scene unit wide and high.
pub const BOXES: u32 = 24;

/// A level skin about the origin.
pub fn flat() -> Skin {
    let mesh = surface::plane(BOXES as f32, BOXES, BOXES);
    extrude(&mesh, &|_| true, &SkinOptions::per_patch(1.0)).expect("a plane extrudes")
}

/// A skin over hills and hollows of radius 2½, whose boxes are twisted and combed to 40°.
pub fn bent() -> Skin {
    let mut mesh = surface::plane(BOXES as f32, BOXES, BOXES);
    for p in &mut mesh.positions {
        p.y = 0.4 * (p.x + 0.6 * p.z).sin() * (0.3 + 0.5 * p.z).cos();
    }
    let lean = Vec3::new(40_f32.to_radians().tan(), 0.0, 0.0);
    extrude(&mesh, &|_| true, &SkinOptions { lean, ..SkinOptions::per_patch(1.0) })
        .expect("gentle hills extrude")
}

/// A scene of nothing but one coat, without light.
pub fn coat(skin: Skin, texel: Arc<Texel>) -> Scene {
    Scene::new(Description {
        meshes: vec![],
        coats: vec![Coat { skin, texels: texel.into(), tint: Vec3::ONE, wears_material: false }],
        materials: vec![Material { base_color: Vec3::ONE, ..Material::default() }],
        textures: vec![],
        lights: vec![],
        environment: Environment::BLACK,
    })
    .expect("the scene is sound")
}

/// The direction from the middle of the skin at `azimuth` and `elevation`, in degrees.
fn towards(azimuth: f32, elevation: f32) -> Vec3 {
    let (up, along) = elevation.to_radians().sin_cos();
    let (x, z) = azimuth.to_radians().sin_cos();
    Vec3::new(along * x, up, along * z)
}

/// The azimuth of the eye, in degrees: along no row of boxes.
const AZIMUTH: f32 = 10.0;

/// Suns with hard shadows and no sky: from the side, 13° from an eye at `elevation` degrees, and from behind.
pub fn suns(elevation: f32) -> [Lighting; 3] {
    [towards(AZIMUTH + 90.0, 40.0), towards(AZIMUTH + 7.0, elevation + 11.0), towards(AZIMUTH + 185.0, 35.0)]
        .map(|sun| Lighting {
            lights: vec![Light::Directional { direction: -sun, illuminance: Vec3::splat(3.0), angle: 0.0 }],
            environment: Environment::BLACK,
        })
}

/// A camera, and the part of its picture that shows the middle of the skin.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Where from.
    pub camera: Camera,
    /// Width and height of the whole picture, in pixels.
    pub size: [u32; 2],
    /// What of it is looked at.
    pub crop: Rect,
}

impl Shot {
    /// From `elevation` degrees, where a box is `width` pixels wide; at most `most` pixels a side are looked at, and
    /// nothing within a quarter of the skin of its border.
    pub fn new(elevation: f32, width: f32, most: u32) -> Self {
        let (fov, size) = (0.1_f32, 1024_u32);
        let distance = size as f32 / width / (2.0 * (0.5 * fov).tan());
        // Off the grid: else the rays of every pixel would meet the same part of every box.
        let target = Vec3::new(0.013, 0.4, 0.027);
        let eye = target + distance * towards(AZIMUTH, elevation);
        let side = ((0.5 * BOXES as f32 * width) as u32).min(most) & !1;
        let first = (size - side) / 2;
        Self {
            camera: Camera::look_at(eye, target, Vec3::Y, fov),
            size: [size, size],
            crop: Rect { x: first, y: first, width: side, height: side },
        }
    }

    /// The cone picture; `settings` need not say its size.
    pub fn cone(&self, scene: &Scene, settings: &Settings) -> Film {
        picture(scene, &self.camera, &Settings { size: self.size, crop: Some(self.crop), ..*settings })
    }

    /// The pictures of the geometry under each of `lightings`.
    pub fn truth(&self, scene: &Scene, lightings: &[Lighting], samples: u32, shadows: bool) -> Vec<Film> {
        let settings = ReferenceSettings {
            size: self.size,
            crop: Some(self.crop),
            samples,
            shadows,
            ..ReferenceSettings::default()
        };
        reference::render_under(scene, &self.camera, &settings, lightings, &|_| ControlFlow::Continue(()))
            .expect("the texel knows its source")
    }
}

/// Mean radiance of a picture, of its first channel.
pub fn mean_radiance(film: &Film) -> f32 {
    film.pixels.iter().map(|p| p.color.x).sum::<f32>() / film.pixels.len() as f32
}

/// How a cone picture under one lighting compares with the truth.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Mean alpha over the truth's.
    pub alpha: f32,
    /// Mean radiance over the truth's.
    pub energy: f32,
    /// What is too much of the mean radiance, over the truth's under the first lighting: of light from behind next to
    /// nothing is seen, and it is judged by the light from the side.
    pub excess: f32,
    /// Root mean square difference of radiance over the truth's mean under the first lighting.
    pub rmse: f32,
}

/// Compares what a cone picture shows with the truth, under each of `lightings`.
pub fn judge(
    scene: &mut Scene,
    shot: &Shot,
    lightings: &[Lighting],
    settings: &Settings,
    samples: u32,
) -> Vec<Outcome> {
    let truths = shot.truth(scene, lightings, samples, settings.shadows);
    let first = truths.first().map_or(f32::NAN, mean_radiance);
    lightings
        .iter()
        .zip(&truths)
        .map(|(lighting, truth)| {
            scene.set_lighting(lighting.clone()).expect("the lights are sound");
            let cone = shot.cone(scene, settings);
            let [seen, shown] = [&cone, truth].map(mean_radiance);
            let pairs = cone.pixels.iter().zip(&truth.pixels);
            let squares: f32 = pairs.map(|(a, b)| (a.color.x - b.color.x).powi(2)).sum();
            Outcome {
                alpha: mean_alpha(&cone) / mean_alpha(truth),
                energy: seen / shown,
                excess: (seen - shown) / first,
                rmse: (squares / truth.pixels.len() as f32).sqrt() / first,
            }
        })
        .collect()
}
