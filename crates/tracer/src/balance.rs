//! Texels whose light is balanced: held, level by level, against the light that their geometry sends.
//!
//! A texel stands among its copies on a level surface. It is looked at from directions spread over the hemisphere, each with
//! suns of which some stand near the eye, once as explicit geometry ([`reference`](crate::reference)) and once as voxels of
//! each level, by the very code that makes pictures. What is left between the two is [fitted](Balance::fit).

use std::f32::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{Vec2, Vec3};
use pelage_geom::evenly;
use pelage_skin::{Anchor, Lattice, Patch, Skin};
use pelage_texel::{Balance, Shown, Source, Texel};
use rayon::prelude::*;

use crate::cone::composite::View;
use crate::cone::shade::Shader;
use crate::hash::Drawn;
use crate::reference::{Judge, Lighting};
use crate::render::see;
use crate::{Camera, Coat, Description, Environment, Light, Rays, Scene, Settings};

/// Directions from which a texel is looked at, and suns for each.
const VIEWS: usize = 96;
const SUNS: usize = 6;

/// How far from the eye the first suns are, about, in radians; the others are anywhere.
const NEAR: [f32; 3] = [0.08, 0.25, 0.5];

/// Eye and suns are at least this high, as heights of unit vectors: lower ones see across more copies than there are.
const LOWEST: f32 = 0.1;

/// Copies on each side of the one that is looked at.
const COPIES: f32 = 20.0;

/// From how far it is looked at, in texels: far enough to be from one direction.
const DISTANCE: f32 = 200.0;

/// How many texels fit into the height of a picture.
const ACROSS: u32 = 4;

/// Rays that see the geometry, from each direction.
const SAMPLES: usize = 2048;

/// Balances a texel: a level that is too dark or too bright from some direction, in some light, sends by so much more or
/// less of it.
///
/// What cannot be judged stays as it is: a texel that has forgotten its source, or that holds nothing, or more than the judge
/// may take ([`ReferenceSettings::memory`](crate::reference::ReferenceSettings::memory)), and one that stands alone, whose
/// surroundings are anyone's guess. The result has the same bits for any number of threads. `progress` is
/// told the fraction done, from any thread.
pub fn balance(texel: Texel, progress: &(dyn Fn(f32) + Sync)) -> Texel {
    let blank = texel.levels().first().is_none_or(|level| level.is_empty());
    if blank || !texel.periodic || *texel.source() == Source::Unknown {
        return texel;
    }
    let texel = Arc::new(texel);
    let balances = measured(&texel, progress);
    Arc::unwrap_or_clone(texel).balanced(balances)
}

fn measured(texel: &Arc<Texel>, progress: &(dyn Fn(f32) + Sync)) -> Vec<Option<Balance>> {
    let levels = 0..=texel.depth();
    let (Some(scene), first) = (stage(texel, vec![]), Sight::new(0)) else { return vec![] };
    let Ok(judge) = Judge::new(&scene, &first.camera, first.size(FINE)) else { return vec![] };
    let done = AtomicUsize::new(0);
    let look = |i: usize| {
        let sight = Sight::new(i);
        let source = sight.of_source(&judge);
        let shown = levels.clone().map(|level| sight.of_level(texel, level).beside(&source, &sight));
        let shown: Vec<[Shown; SUNS]> = shown.collect();
        progress((1 + done.fetch_add(1, Ordering::Relaxed)) as f32 / VIEWS as f32);
        shown
    };
    let seen: Vec<Vec<[Shown; SUNS]>> = (0..VIEWS).into_par_iter().map(look).collect();
    let of_level = |level: u32| -> Option<Balance> {
        let pairs: Vec<Shown> = seen.iter().flat_map(|levels| levels[level as usize]).collect();
        Balance::fit(&pairs)
    };
    levels.map(of_level).collect()
}

/// What was seen along some rays: under each sun, the brightness of each ray.
struct Look {
    /// How much of the surface is covered.
    alpha: f32,
    rays: Vec<[f32; SUNS]>,
}

impl Look {
    fn mean(rays: &[[f32; SUNS]], sun: usize) -> f32 {
        rays.iter().map(|ray| ray[sun]).sum::<f32>() / rays.len().max(1) as f32
    }

    /// Beside the source, of which the first rays are the same: where those few happen to be bright, they are as bright here.
    /// [Owen13]
    fn beside(&self, source: &Look, sight: &Sight) -> [Shown; SUNS] {
        let few = &source.rays[..self.rays.len().min(source.rays.len())];
        // How much of the surface is covered is another matter.
        let part = if self.alpha > 0.0 { source.alpha / self.alpha } else { 0.0 };
        std::array::from_fn(|sun| {
            let [here, there, all] = [&self.rays, few, &source.rays].map(|rays| Self::mean(rays, sun));
            let (mut both, mut own) = (0.0, f32::MIN_POSITIVE);
            for (a, b) in self.rays.iter().zip(few) {
                both += (a[sun] - here) * (b[sun] - there);
                own += (b[sun] - there).powi(2);
            }
            let voxels = part * (here + both / own * (all - there));
            Shown { eye: sight.eye, light: sight.suns[sun], voxels, source: all }
        })
    }
}

/// The texel among its copies, in a scene whose coordinates are those of the texel.
fn stage(texel: &Arc<Texel>, lights: Vec<Light>) -> Option<Scene> {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(COPIES * x, COPIES * y, z);
    let around = |z: f32| [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| corner(x, y, z));
    let patch = Patch {
        vertices: [0, 1, 2, 3],
        face: 0,
        material: Default::default(),
        lattice: Lattice {
            origin: Vec2::splat(-COPIES),
            u: 2.0 * COPIES * Vec2::X,
            v: 2.0 * COPIES * Vec2::Y,
        },
        anchor: Anchor::default(),
    };
    let skin =
        Skin { base: around(0.0).into(), top: around(1.0).into(), patches: vec![patch], ..Skin::default() };
    let coat = Coat { skin, texels: texel.clone().into(), tint: Vec3::ONE, wears_material: false };
    let description = Description {
        meshes: vec![],
        coats: vec![coat],
        materials: vec![],
        textures: vec![],
        lights,
        environment: Environment::BLACK,
    };
    Scene::new(description).ok()
}

/// Pixels as wide as the voxels of levels below this one hold much of the texel.
const COARSE: u32 = 3;

/// The level whose voxels are as wide as the pixels in which the geometry is looked at.
const FINE: u32 = 8;

/// One look at the texel, and the suns that it is lit by, one at a time.
struct Sight {
    eye: Vec3,
    suns: [Vec3; SUNS],
    camera: Camera,
    /// Of what is drawn at random.
    number: usize,
}

impl Sight {
    fn new(number: usize) -> Self {
        let mut drawn = Drawn::from([number as u64, 0xba1a]);
        // Even in height: what is seen flat varies most.
        let height = (number as f32 + 0.5) / VIEWS as f32;
        let eye = upwards(LOWEST + (1.0 - LOWEST) * height, drawn.unit());
        let suns = std::array::from_fn(|k| {
            loop {
                let sun = match NEAR.get(k) {
                    Some(angle) => {
                        let (a, b) = eye.any_orthonormal_pair();
                        let aside = Vec2::from_angle(2.0 * PI * drawn.unit());
                        (eye + angle * (0.5 + drawn.unit()) * (aside.x * a + aside.y * b)).normalize()
                    }
                    None => upwards(LOWEST + (1.0 - LOWEST) * drawn.unit(), drawn.unit()),
                };
                if sun.z >= LOWEST {
                    break sun;
                }
            }
        });
        let target = Vec3::new(drawn.unit(), drawn.unit(), 0.5);
        let (up, _) = eye.any_orthonormal_pair();
        let fov = 2.0 * (0.5 * ACROSS as f32 / DISTANCE).atan();
        Self { eye, suns, camera: Camera::look_at(target + DISTANCE * eye, target, up, fov), number }
    }

    /// A picture whose pixels are as wide as the voxels of a level.
    fn size(&self, level: u32) -> [u32; 2] {
        [ACROSS << level; 2]
    }

    fn lights(&self) -> [Light; SUNS] {
        self.suns.map(|sun| Light::Directional { direction: -sun, illuminance: Vec3::splat(PI), angle: 0.0 })
    }

    /// Pixels spread evenly over one copy.
    fn pixels(&self, count: usize, level: u32) -> Vec<[u32; 2]> {
        let [width, height] = self.size(level);
        let pixel = ACROSS as f32 / height as f32;
        let axes = self.camera.orientation;
        let place = |i: usize| {
            let p = (evenly(i + self.number * SAMPLES) - 0.5).as_vec2().extend(0.0);
            [
                (0.5 * width as f32 + p.dot(axes.x_axis) / pixel) as u32,
                (0.5 * height as f32 - p.dot(axes.y_axis) / pixel) as u32,
            ]
        };
        (0..count).map(place).collect()
    }

    /// What the geometry shows.
    fn of_source(&self, judge: &Judge) -> Look {
        let lightings =
            self.lights().map(|light| Lighting { lights: vec![light], environment: Environment::BLACK });
        let pixels = self.pixels(SAMPLES, FINE);
        let (seen, shown) = judge.samples_under(&self.camera, self.size(FINE), &pixels, &lightings);
        let rays =
            (0..pixels.len()).map(|i| std::array::from_fn(|sun| shown[sun][i].element_sum())).collect();
        Look { alpha: seen as f32 / pixels.len() as f32, rays }
    }

    /// What the voxels of a level show.
    fn of_level(&self, texel: &Arc<Texel>, level: u32) -> Look {
        let Some(scene) = stage(texel, self.lights().into()) else {
            return Look { alpha: 0.0, rays: vec![] };
        };
        let (rays, count) = if level < COARSE { (Rays::Sixteen, 12) } else { (Rays::One, 160) };
        let settings = Settings { size: self.size(level), rays, lit_voxels: 16, ..Settings::default() };
        let (mut view, mut shader) = (View::default(), Shader::default());
        let mut alpha = 0.0;
        let look = |at: [u32; 2]| {
            alpha += 1.0 - see(&scene, &self.camera, &settings, at, &mut view);
            view.merge();
            view.choose(settings.lit_voxels as usize);
            let (_, cone) = self.camera.cone(Vec2::from(at.map(|x| x as f32 + 0.5)), settings.size);
            shader.begin(&view.voxels, cone);
            let mut sums = [0.0; SUNS];
            for voxel in &view.voxels {
                shader.light(&scene, &settings, voxel, |sun, radiance| {
                    sums[sun] += voxel.weight * radiance.element_sum();
                });
            }
            sums
        };
        let rays = self.pixels(count, level).into_iter().map(look).collect();
        Look { alpha: alpha / count as f32, rays }
    }
}

/// A unit vector of a height, any way around.
fn upwards(height: f32, around: f32) -> Vec3 {
    (Vec2::from_angle(2.0 * PI * around) * (1.0 - height * height).max(0.0).sqrt()).extend(height)
}

#[cfg(test)]
mod tests {
    use pelage_texel::{BuildOptions, Grass, build};

    use super::*;

    #[test]
    fn the_same_bits_on_any_number_of_threads_and_nothing_without_a_source() {
        let grass = Grass { count: 6, ..Grass::lawn() };
        let options = BuildOptions { depth: 3, ..BuildOptions::preview() };
        let texel = build("grass", grass, &options, &|_| ()).expect("grass is sound");
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| balance(texel.clone(), &|_| ()))
        };
        let balanced = on(1);
        assert!(balanced.levels().iter().all(|level| level.balance().is_some()));
        assert!(balanced == on(3));
        let unknown = texel.without_source();
        assert!(balance(unknown.clone(), &|_| ()) == unknown);
    }
}
