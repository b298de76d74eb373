//! Deep shadow maps: what the light meets along a line through all coats, found once and kept for all points behind it.
//! [Lokovic00]
//!
//! A pixel shows a handful of voxels, and each would send a cone to each light; but seen from the light, those of
//! neighbouring pixels stand behind each other. So the light's lines are sorted into cells as wide as a pixel is where the
//! light falls ([`light_lines`](super::light_lines)): about one for each pixel. What a line holds hangs on its cell alone,
//! not on who asked first: neither threads nor tiles nor crops change a picture.
//!
//! Of a line it is known at once which boxes it goes through, and what it meets in each when a point behind asks first:
//! points ask from themselves towards the light, as far as anything is left of it.
//!
//! A light that is no point needs cones that widen towards it: the further, the wider, by octaves, each from a line of
//! cells as much wider.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

use glam::{DVec3, Vec3};
use pelage_geom::Ray;

use super::composite::KeyHasher;
use super::light_lines::{LightLines, Place};
use super::march::{Beam, march, through};
use super::passages::{self, BoxPassage};
use super::shadow::ShadowCone;
use super::widths::{MOST_STEPS, Widths};
use super::{Blend, Trail};
use crate::hash::Drawn;
use crate::{Scene, Settings};

/// More layers and lines than these are not kept: some megabytes for each thread.
const MOST_LAYERS: usize = 1 << 16;
const MOST_LINES: usize = 1 << 14;

/// A cone to a light of the scene, for which a line of the light may stand.
pub(crate) struct LightCone {
    /// Which light.
    pub light: usize,
    pub cone: ShadowCone,
    /// Unit normal of the surface along which its point may move and stay what it is: its own, or that below the coat.
    pub normal: Vec3,
    /// About how wide the cells are of which points share a line, in scene units.
    pub fineness: f64,
}

/// Which line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct LineKey {
    light: u32,
    face: u8,
    /// The width of cells, and that of the cone, as powers of 2 (times [`Scene::edge`], of the sun's cones).
    octaves: [i16; 2],
    cell: [i64; 2],
}

impl Hash for LineKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { light, face, octaves: [cells, width], cell: [x, y] } = *self;
        let octaves = u64::from(cells as u16) << 16 | u64::from(width as u16);
        state.write_u64(octaves << 32 ^ u64::from(face) << 29 ^ u64::from(light));
        state.write_u64((x as u64).rotate_left(32) ^ y as u64);
    }
}

/// What the light meets of one voxel.
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// Where it enters and leaves it, from where it entered the box.
    near: f32,
    far: f32,
    /// Optical depth, and what gets through it.
    depth: f32,
    through: f32,
    /// As of a [`Piece`](super::Piece).
    even: f32,
    level: u8,
}

/// What the light meets of one box.
#[derive(Clone, Copy, Debug)]
struct Part {
    passage: BoxPassage,
    /// Its layers: from which on, and to which; `None` as long as nobody has asked for them.
    layers: Option<[u32; 2]>,
}

/// The lines of all lights that were asked for lately.
#[derive(Default)]
pub(super) struct DeepShadows {
    /// Of each light of the scene, once one was asked for; `None` of a sun that shines nowhere.
    rasters: Vec<Option<LightLines>>,
    /// The parts of each line: from which on, and to which.
    lines: HashMap<LineKey, [u32; 2], BuildHasherDefault<KeyHasher>>,
    /// In order of entry, line by line.
    parts: Vec<Part>,
    layers: Vec<Layer>,
    passages: Vec<BoxPassage>,
}

impl DeepShadows {
    /// The part of a light that the coats let through to the begin of a cone, by a line of the light.
    pub fn transmittance(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        of: &LightCone,
        trail: &mut Trail,
    ) -> f32 {
        if self.rasters.is_empty() {
            self.rasters.extend(scene.lights.iter().map(|light| LightLines::new(light, scene)));
        }
        let Some(lines) = self.rasters[of.light] else { return 1.0 };
        let shadow = &of.cone;
        let place = lines.place(shadow.origin);
        let widths = Widths::new(&lines, scene, shadow);
        let cells = octave_of_cells(&place, of.fineness);
        let mut blend = Blend::START;
        let mut reached = shadow.start;
        for step in 0..=MOST_STEPS {
            let size = f64::from(cells + step).exp2();
            let cell = (place.at / size).floor();
            let ray = lines.line(place.face, (cell + 0.5) * size);
            let here = match step {
                0 => level_with(&ray, shadow.origin, of.normal.as_dvec3()),
                // So much wider than what it begins with, it is off any surface that a plane stands for.
                _ => beside(&ray, shadow.origin),
            };
            if here <= reached {
                break;
            }
            let end = widths.end(step);
            let key = LineKey {
                light: of.light as u32,
                face: place.face,
                octaves: [(cells + step) as i16, (widths.octave + step) as i16],
                cell: [cell.x as i64, cell.y as i64],
            };
            let cone = widths.cone(step);
            let beam = Beam { ray: &ray, cone: &cone, settings };
            let [first, last] = self.parts_of(scene, key, &ray, trail);
            // From the point on, as far as anything is left of the light.
            for index in (first..last).rev() {
                let [enter, leave] = self.parts[index as usize].passage.t;
                if enter >= here - reached || leave <= here - end {
                    continue;
                }
                let (here, from, to) = (here - enter, here - enter - end, here - enter - reached);
                let (here, from, to) = (here as f32, from as f32, to as f32);
                for layer in self.layers_of(scene, index, beam, trail).iter().rev() {
                    let (near, far) = (layer.near.max(from), layer.far.min(to));
                    if near >= far {
                        continue;
                    }
                    let whole = near == layer.near && far == layer.far;
                    let part = if whole { 1.0 } else { (far - near) / (layer.far - layer.near) };
                    let part = part * shadow.correlation.factor(here - far, here - near);
                    // What counts in full is known already.
                    let passed = if part == 1.0 {
                        layer.through
                    } else {
                        through(settings.opacity, part * layer.depth)
                    };
                    blend.pass(layer.level, layer.even, passed);
                }
                if blend.transmittance() < settings.min_transmittance {
                    return 0.0;
                }
            }
            reached = end;
        }
        blend.transmittance()
    }

    /// The boxes that a line goes through.
    fn parts_of(&mut self, scene: &Scene, key: LineKey, ray: &Ray, trail: &mut Trail) -> [u32; 2] {
        if let Some(known) = self.lines.get(&key) {
            return *known;
        }
        if self.layers.len() > MOST_LAYERS || self.lines.len() > MOST_LINES {
            self.lines.clear();
            self.parts.clear();
            self.layers.clear();
        }
        trail.counts.light_cones += 1;
        passages::collect(scene, ray, 0.0, f64::INFINITY, &mut self.passages);
        let first = self.parts.len() as u32;
        self.parts.extend(self.passages.iter().map(|&passage| Part { passage, layers: None }));
        let parts = [first, self.parts.len() as u32];
        self.lines.insert(key, parts);
        parts
    }

    /// What the light meets of a box, until next to nothing would be left of it.
    fn layers_of(&mut self, scene: &Scene, index: u32, beam: Beam, trail: &mut Trail) -> &[Layer] {
        let Part { passage, layers } = self.parts[index as usize];
        let [first, end] = layers.unwrap_or_else(|| {
            let first = self.layers.len();
            trail.chords.clear();
            march(scene, beam, &passage, 1.0, beam.settings.min_transmittance, trail);
            for piece in trail.pieces() {
                let [near, far] = trail.chords[piece.chord as usize].distances(piece.range);
                self.layers.push(Layer {
                    near: (near - passage.t[0]) as f32,
                    far: (far - passage.t[0]) as f32,
                    depth: piece.depth,
                    through: piece.through,
                    even: piece.even,
                    level: piece.key.level,
                });
            }
            let layers = [first as u32, self.layers.len() as u32];
            self.parts[index as usize].layers = Some(layers);
            layers
        });
        &self.layers[first as usize..end as usize]
    }
}

/// How wide cells are for a point, as a power of 2 in units of the raster: one of the two next to `fineness`, drawn for
/// each of the wider cells. So nearly all points of a line agree, and where a picture is zoomed, a few cells at a time
/// give way to others.
fn octave_of_cells(place: &Place, fineness: f64) -> i32 {
    let octave = (fineness / place.scale).log2().clamp(-500.0, 500.0);
    let finer = octave.floor();
    let cell = (place.at / (finer + 1.0).exp2()).floor();
    let drawn = Drawn::from([u64::from(place.face), cell.x as i64 as u64, cell.y as i64 as u64]).unit();
    finer as i32 + i32::from(f64::from(drawn) < octave - finer)
}

/// Where a line that passes beside a point meets the plane through the point with the normal: a point of a surface stays
/// on it, and one at the top of a coat at its top. Where the line goes along the plane, not far from the point.
fn level_with(line: &Ray, point: DVec3, normal: DVec3) -> f64 {
    let beside = beside(line, point);
    let aside = point - line.at(beside);
    let further = aside.dot(normal) / line.direction.dot(normal);
    let most = MOST_FURTHER * aside.length();
    beside + if further.is_finite() { further.clamp(-most, most) } else { 0.0 }
}

/// Where a line passes a point.
fn beside(line: &Ray, point: DVec3) -> f64 {
    (point - line.origin).dot(line.direction)
}

/// A point moves along the light by at most so many times what its line is aside.
const MOST_FURTHER: f64 = 3.0;

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use pelage_geom::Cone;
    use pelage_skin::{SkinOptions, extrude, surface};
    use pelage_texel::{BuildOptions, Grass, build};

    use super::super::path::lattice_inverse;
    use super::super::shadow::{Correlation, ShadowBuffers};
    use super::*;
    use crate::{Coat, Description, Environment, Light};

    /// A ring of thin grass under some lights.
    fn scene(lights: Vec<Light>) -> Scene {
        let grass = Grass { count: 24, segments: 1, ..Grass::meadow() };
        let options = BuildOptions { depth: 3, ..BuildOptions::standard() };
        let texel = build("grass", grass, &options, &|_| ()).expect("grass grows");
        let mesh = surface::torus(1.0, 0.4, 24, 12);
        let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.2)).expect("a torus extrudes");
        Scene::new(Description {
            meshes: vec![],
            coats: vec![Coat { skin, texels: texel.into(), tint: Vec3::ONE, wears_material: false }],
            materials: vec![],
            textures: vec![],
            lights,
            environment: Environment::BLACK,
        })
        .expect("a sound scene")
    }

    /// Cones to a light from points all over the coat, as wide as a voxel of level 3.
    fn cones(scene: &Scene, light: usize) -> Vec<LightCone> {
        let mut drawn = Drawn::from([7]);
        let cone = |_| {
            let patch = (drawn.unit() * scene.box_count() as f32) as u32;
            let u = DVec3::new(drawn.unit().into(), drawn.unit().into(), drawn.unit().into());
            let map = scene.hexahedron(patch).map();
            let (origin, jacobian) = (map.point(u), map.jacobian(u).as_mat3());
            let incoming = scene.lights[light].incoming(origin.as_vec3())?;
            let texel = jacobian * lattice_inverse(&scene.patch(patch).1.lattice);
            let width = f64::from(texel.determinant().abs().cbrt() / 8.0);
            let cone = ShadowCone {
                origin,
                direction: incoming.direction.as_dvec3().normalize(),
                start: 0.5 * width,
                end: incoming.distance.into(),
                cone: Cone { width, spread: incoming.spread.into() },
                correlation: Correlation::NONE,
            };
            let normal = jacobian.x_axis.cross(jacobian.y_axis).normalize_or_zero();
            Some(LightCone { light, cone, normal, fineness: width })
        };
        (0..3000).filter_map(cone).collect()
    }

    #[test]
    fn lines_of_the_light_agree_with_cones_to_it() {
        let sun = |angle| Light::Directional {
            direction: Vec3::new(-1.0, -2.0, -0.5),
            illuminance: Vec3::ONE,
            angle,
        };
        let lamp = |radius| Light::Point { position: Vec3::new(0.3, 1.4, 0.2), intensity: Vec3::ONE, radius };
        let scene = scene(vec![sun(0.0), sun(0.3), lamp(0.0), lamp(0.3)]);
        let (settings, mut buffers) = (Settings::default(), ShadowBuffers::default());
        for light in 0..scene.lights.len() {
            let cones = cones(&scene, light);
            let exact: Vec<f32> =
                cones.iter().map(|of| buffers.through_coats(&scene, &settings, &of.cone)).collect();
            let mut found = |fineness: f64| -> Vec<f32> {
                let by_cells = |of: &LightCone| {
                    let of = LightCone { fineness: fineness * of.fineness, ..*of };
                    buffers.of_light(&scene, &settings, &of)
                };
                cones.iter().map(by_cells).collect()
            };
            let mean = |list: &[f32]| list.iter().sum::<f32>() / list.len() as f32;
            let error = |list: &[f32]| {
                (list.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / list.len() as f32)
                    .sqrt()
            };
            let [coarse, fine] = [found(1.0), found(0.125)];
            // Points move to the middle of their cells, which is fair on the mean and the closer the smaller they are.
            let exact_mean = mean(&exact);
            assert!((0.2..0.8).contains(&exact_mean));
            assert!((mean(&coarse) - exact_mean).abs() < 0.015 * exact_mean, "light {light}");
            assert!((mean(&fine) - exact_mean).abs() < 0.01 * exact_mean, "light {light}");
            assert!(error(&fine) < 0.7 * error(&coarse), "light {light}");
        }
    }

    #[test]
    fn cells_are_as_wide_as_asked_on_the_mean() {
        let mut drawn = Drawn::from([5]);
        for fineness in [0.25, 0.3, 0.7, 1.0, 1.9] {
            let octaves = (0..20_000).map(|_| {
                let at = 1e3 * DVec2::new(drawn.signed().into(), drawn.signed().into());
                octave_of_cells(&Place { face: 0, at, scale: 2.0 }, 2.0 * fineness)
            });
            let mean = octaves.map(f64::from).sum::<f64>() / 20_000.0;
            assert!((mean - fineness.log2()).abs() < 0.02, "{fineness}: {mean}");
        }
    }

    #[test]
    fn who_asks_first_changes_nothing() {
        let sun = Light::Directional { direction: Vec3::NEG_Y, illuminance: Vec3::ONE, angle: 0.1 };
        let scene = scene(vec![sun]);
        let (settings, cones) = (Settings::default(), cones(&scene, 0));
        let ask = |buffers: &mut ShadowBuffers, of: &LightCone| buffers.of_light(&scene, &settings, of);
        let mut one = ShadowBuffers::default();
        let forth: Vec<f32> = cones.iter().map(|cone| ask(&mut one, cone)).collect();
        let mut other = ShadowBuffers::default();
        let mut back: Vec<f32> = cones.iter().rev().map(|cone| ask(&mut other, cone)).collect();
        back.reverse();
        assert_eq!(forth, back);
        let alone = cones.iter().map(|cone| ask(&mut ShadowBuffers::default(), cone));
        assert!(alone.eq(forth));
    }
}
