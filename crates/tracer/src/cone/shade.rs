//! The light that a seen voxel or surface sends to the eye. [seed §5.2, §6.1c, method §7]

use glam::{DVec3, Mat3, Vec2, Vec3};
use pelage_geom::{Cone, Material, Ray, material::exponent_of_roughness};
use std::f32::consts::{FRAC_1_PI, PI};

use pelage_texel::{Level, Scatterers, Surfel, Voxel};

use super::composite::{SeenSurface, SeenVoxel};
use super::path::{lattice_inverse, to_box};
use super::shadow::{Correlation, ShadowBuffers, ShadowCone};
use crate::light::Incoming;
use crate::scene::Coat;
use crate::{Counts, Environment, Scene, Settings};

/// Lights what a pixel sees; holds the buffers of the shadow cones.
#[derive(Default)]
pub(crate) struct Shader {
    shadows: ShadowBuffers,
    surfels: Vec<Surfel>,
    visible: Vec<Visible>,
    /// Where the pixel sees each of its boxes.
    places: Vec<SeenPlace>,
}

/// The mean of what a pixel sees of one box.
struct SeenPlace {
    patch: u32,
    weight: f32,
    /// Texel coordinates.
    at: Vec3,
    /// The direction of its rays, scene space.
    direction: Vec3,
    /// The edge of its voxels, in texel units.
    edge: f32,
    /// What of the light from below reaches it, once it is known.
    below: Option<f32>,
}

impl SeenPlace {
    fn new(voxel: &SeenVoxel) -> Self {
        let SeenVoxel { key, weight, at, direction, .. } = *voxel;
        Self { patch: key.patch, weight, at, direction, edge: edge_of(voxel), below: None }
    }

    fn add(&mut self, voxel: &SeenVoxel) {
        self.weight += voxel.weight;
        let part = voxel.weight / self.weight.max(f32::MIN_POSITIVE);
        self.at = self.at.lerp(voxel.at, part);
        self.direction = self.direction.lerp(voxel.direction, part);
        self.edge += part * (edge_of(voxel) - self.edge);
    }
}

fn edge_of(voxel: &SeenVoxel) -> f32 {
    1.0 / (1_u32 << voxel.key.level) as f32
}

impl Shader {
    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        self.shadows.take_counts()
    }

    /// Begins with the voxels of another pixel.
    pub fn begin(&mut self, voxels: &[SeenVoxel]) {
        self.places.clear();
        for voxel in voxels {
            match self.places.iter_mut().find(|place| place.patch == voxel.key.patch) {
                Some(place) => place.add(voxel),
                None => self.places.push(SeenPlace::new(voxel)),
            }
        }
    }

    /// The radiance of a voxel's visible matter towards the eye.
    pub fn voxel(&mut self, scene: &Scene, settings: &Settings, seen: &SeenVoxel) -> Vec3 {
        let (coat, patch) = scene.patch(seen.key.patch);
        let (texel, tile) = coat.standing(patch, seen.key.copy());
        let level = texel.level(u32::from(seen.key.level));
        let voxel = level.voxel(seen.voxel);
        let hexahedron = scene.hexahedron(seen.key.patch);
        let scale = level.resolution() as f32;

        // The shaded point, and the map around it.
        let u = to_box(&patch.lattice, seen.at).as_dvec3();
        let point = hexahedron.map().point(u);
        let to_lattice = Mat3::from_cols(patch.lattice.u.extend(0.0), patch.lattice.v.extend(0.0), Vec3::Z);
        // Where copies differ, on to the texel of this one.
        let to_texel = tile.map_or(to_lattice, |tile| tile.steps().as_mat3() * to_lattice);
        let jacobian = hexahedron.map().jacobian(u).as_mat3() * to_texel.inverse();
        let inverse = jacobian.inverse();
        if !inverse.is_finite() {
            return Vec3::ZERO; // the corner of a box that has no volume there: it has no normals either
        }
        let view = -seen.direction.normalize_or(Vec3::NEG_Y);

        let tint = coat.tint * surface_colour(scene, coat, seen, u.as_vec3(), 1.0 / scale);
        let tint = tile.map_or(tint, |tile| tile.tint * tint);
        let [specular, exponent] = [texel.specular, exponent_of_roughness(texel.roughness)];
        self.surfels.clear();
        self.surfels.extend(level.surfels(seen.voxel));
        let facing =
            Facing { view: (inverse * view).normalize_or_zero(), cofactor: inverse.transpose(), tint };
        facing.collect(&self.surfels, &mut self.visible);
        facing.collect_lobes(level, seen.voxel, &mut self.visible);
        let scatterers = level.scatterers(seen.voxel);
        facing.collect_scatterers(scatterers, &mut self.visible);
        if self.visible.is_empty() {
            facing.collect_ellipsoid(&voxel, settings.normals, &mut self.visible);
        }
        let whole: f32 = self.visible.iter().map(|v| v.weight).sum();
        // Of the sky, the masks say what is near, the openness there what is above beyond that, and a cone what is
        // below: as a rule, the surface that the coat stands on.
        let lit_from_below = settings.shadows
            && scene.environment != Environment::BLACK
            && self.visible.first().is_some_and(|v| v.point.is_some());
        let below = if lit_from_below { self.below(scene, settings, seen.key.patch) } else { 0.0 };
        let openness = texel.openness(seen.key.level.into(), seen.key.within().into());
        let surfels = &self.surfels;
        let sky = |v: &Visible| match v.point {
            Some(point) if settings.shadows => {
                let beyond = [openness, below];
                let halves = match point {
                    Point::Surfel(i) => surfels[i as usize].sky(),
                    Point::Lobe(i) => level.lobe_sky(i),
                    Point::Scatterer(i) => scatterers.sky(i as usize),
                };
                (halves.into_iter().zip(beyond))
                    .map(|((open, sum), beyond)| {
                        let turned = (jacobian * sum).normalize_or_zero() * sum.length();
                        beyond * scene.environment.gathered(open, turned)
                    })
                    .sum()
            }
            _ => scene.environment.mean_radiance(v.normal) * if settings.shadows { openness } else { 1.0 },
        };
        let mut radiance = Vec3::ZERO;
        if scene.environment != Environment::BLACK {
            radiance = self.visible.iter().map(|v| v.weight * v.color * sky(v)).sum::<Vec3>() / whole;
        }
        let holds_shadows = Scatterers::hold_shadows(seen.key.level.into());
        for light in &scene.lights {
            let Some(incoming) = light.incoming(point.as_vec3()) else { continue };
            let to_light = incoming.direction;
            let half = (view + to_light).normalize_or_zero();
            let towards = (inverse * to_light).normalize_or_zero();
            let lit = |v: &Visible| match v.point {
                Some(Point::Surfel(i)) if settings.shadows => surfels[i as usize].lit(facing.view, towards),
                Some(Point::Lobe(i)) if settings.shadows => level.lobe(i).lit(facing.view, towards),
                Some(Point::Scatterer(i)) if settings.shadows && holds_shadows => {
                    scatterers.transmittance(i as usize, towards)
                }
                _ => 1.0,
            };
            let reflected: Vec3 = (self.visible.iter())
                .map(|v| {
                    v.weight * lit(v) * reflection(v.color, specular, exponent, v.normal, to_light, half)
                })
                .sum();
            let reflected = reflected / whole;
            if reflected == Vec3::ZERO {
                continue;
            }
            let mut arriving = 1.0;
            if settings.shadows {
                // What is near is in the masks, or in the maps.
                let edge = 1.0 / scale;
                let (near, apart) = if scatterers.is_empty() {
                    (Surfel::reach(edge), SURFACES_APART)
                } else if holds_shadows {
                    (Scatterers::reach(seen.key.level.into()), 0.0)
                } else {
                    (0.0, DENSITIES_APART * edge)
                };
                let start = near / (inverse * to_light).length();
                arriving = self.shadows.transmittance(
                    scene,
                    settings,
                    &ShadowCone {
                        origin: point,
                        direction: to_light.as_dvec3().normalize(),
                        start: f64::from(start),
                        end: f64::from(incoming.distance),
                        cone: Cone {
                            width: f64::from(jacobian.determinant().abs().cbrt() / scale),
                            spread: f64::from(incoming.spread),
                        },
                        correlation: correlation(&inverse, view, to_light, apart),
                    },
                );
            }
            radiance += arriving * incoming.irradiance * reflected;
        }
        radiance
    }

    /// What of the light from below reaches what the pixel sees of a box: it is a small part of all light, and much the
    /// same for all of that.
    fn below(&mut self, scene: &Scene, settings: &Settings, patch: u32) -> f32 {
        let Some(i) = self.places.iter().position(|place| place.patch == patch) else { return 0.0 };
        let &SeenPlace { at, direction, edge, below, .. } = &self.places[i];
        below.unwrap_or_else(|| {
            let (_, standing) = scene.patch(patch);
            let map = scene.hexahedron(patch).map();
            let u = to_box(&standing.lattice, at).as_dvec3();
            let jacobian = map.jacobian(u).as_mat3() * lattice_inverse(&standing.lattice);
            // Half-way between straight down, where upright strands hide nothing, and where what is seen faces.
            let up = jacobian.z_axis.normalize_or_zero();
            let down = (-direction.normalize_or_zero() - up).normalize_or_zero();
            let width = jacobian.determinant().abs().cbrt() * edge;
            let below = self.light_below(scene, settings, map.point(u), down, width);
            self.places[i].below = Some(below);
            below
        })
    }

    /// What of the light from below reaches a point of a coat past what is near: nothing, where a surface lies under it.
    fn light_below(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        origin: DVec3,
        down: Vec3,
        width: f32,
    ) -> f32 {
        let direction = down.as_dvec3();
        let reach = f64::from(2.0 * scene.reach);
        if direction == DVec3::ZERO || scene.surfaces.blocked(&Ray { origin, direction }, reach) {
            return 0.0;
        }
        let cone = Cone { width: f64::from(width), spread: f64::from(SKY_SPREAD) };
        let start = f64::from(2.0 * width);
        let shadow =
            ShadowCone { origin, direction, start, end: reach, cone, correlation: Correlation::NONE };
        self.shadows.through_coats(scene, settings, &shadow)
    }

    /// The light that points of opaque surfaces send to the eye, weighed. What coats let through to points that lie
    /// beside each other ([`SeenSurface::is_beside`]) is asked once for all of them.
    pub fn surfaces(&mut self, scene: &Scene, settings: &Settings, seen: &[SeenSurface]) -> Vec3 {
        let groups = seen.chunk_by(|a, b| a.is_beside(b));
        groups.map(|group| self.neighbours(scene, settings, group)).sum()
    }

    /// The same for points beside each other.
    fn neighbours(&mut self, scene: &Scene, settings: &Settings, seen: &[SeenSurface]) -> Vec3 {
        let Some(first) = seen.first() else { return Vec3::ZERO };
        let whole: f32 = seen.iter().map(|s| s.weight).sum();
        let mean = |of: &dyn Fn(&SeenSurface) -> f64| {
            seen.iter().map(|s| f64::from(s.weight / whole) * of(s)).sum::<f64>()
        };
        let origin = DVec3::new(mean(&|s| s.off().x), mean(&|s| s.off().y), mean(&|s| s.off().z));
        let origin = if origin.is_finite() { origin } else { first.off() };
        let flat = first.flat();
        let coats = |direction: Vec3, end: f32, spread: f32| ShadowCone {
            origin: origin + scene.rounding() * flat.as_dvec3(),
            direction: direction.as_dvec3().normalize(),
            start: 0.0,
            end: f64::from(end),
            cone: Cone { width: f64::from(first.width), spread: f64::from(spread) },
            correlation: Correlation::NONE,
        };
        let is_shadowed = settings.shadows && scene.reach > 0.0;
        let mut open = 1.0;
        if is_shadowed {
            // Wide cones through the coats around stand for the sky; under a coat that nearly hides the surface, one
            // does, and the others come in gradually, so that no step shows.
            let mut sky =
                |up: Vec3| self.shadows.through_coats(scene, settings, &coats(up, scene.reach, SKY_SPREAD));
            open = sky(flat);
            let reached = mean(&|s| s.reached.into()) as f32;
            let well = ((reached - HARDLY_SEEN[0]) / (HARDLY_SEEN[1] - HARDLY_SEEN[0])).clamp(0.0, 1.0);
            if well > 0.0 {
                let across = flat.any_orthonormal_vector();
                let around = [across, -across, flat.cross(across), -flat.cross(across)];
                let tilted: f32 = around.iter().map(|&side| sky((flat + side).normalize())).sum();
                open += well * ((open + tilted) / 5.0 - open);
            }
        }
        let mut radiance: Vec3 = seen.iter().map(|s| s.weight * s.unlit(scene, open)).sum();
        for light in &scene.lights {
            let mut reflected = Vec3::ZERO;
            let mut towards = None;
            for point in seen {
                let Some(incoming) = light.incoming(point.hit.point.as_vec3()) else { continue };
                let lit = point.reflected(scene, incoming.direction);
                if lit == Vec3::ZERO || point.flat().dot(incoming.direction) <= 0.0 {
                    continue;
                }
                if settings.shadows {
                    // An edge of a shadow that an opaque mesh casts may pass between the points.
                    let off = point.off() + scene.rounding() * point.flat().as_dvec3();
                    let ray = Ray { origin: off, direction: incoming.direction.as_dvec3().normalize() };
                    let ray = Ray { origin: ray.at(scene.rounding()), ..ray };
                    if scene.surfaces.blocked(&ray, f64::from(incoming.distance) - scene.rounding()) {
                        continue;
                    }
                }
                reflected += point.weight * incoming.irradiance * lit;
                towards = Some(incoming);
            }
            let Some(Incoming { direction, distance, spread, .. }) = towards else { continue };
            let arriving = if is_shadowed {
                self.shadows.through_coats(scene, settings, &coats(direction, distance, spread))
            } else {
                1.0
            };
            radiance += arriving * reflected;
        }
        radiance
    }
}

impl SeenSurface {
    /// Whether both lie on the same even piece of a surface, no further apart than a few of the cone's widths.
    fn is_beside(&self, other: &Self) -> bool {
        let [a, b] = [&self.hit, &other.hit];
        let apart = (a.point - b.point).length() as f32;
        a.material == b.material && self.flat().dot(other.flat()) > 0.95 && apart < 4.0 * self.width
    }

    /// 1 where the eye sees the front, −1 where the back: that is what it shows then.
    fn side(&self) -> f32 {
        if self.hit.geometric_normal.dot(-self.direction) < 0.0 { -1.0 } else { 1.0 }
    }

    /// The triangle's own normal on the side that is seen.
    fn flat(&self) -> Vec3 {
        self.side() * self.hit.geometric_normal
    }

    /// Where shadow cones start.
    fn off(&self) -> DVec3 {
        self.hit.lifted[usize::from(self.side() < 0.0)]
    }

    fn albedo(&self, scene: &Scene, material: &Material) -> Vec3 {
        scene.colour_of(material, self.hit.uv, self.width * self.hit.uv_density)
    }

    /// What it sends to the eye without any light, of a sky of which the part `open` is open.
    fn unlit(&self, scene: &Scene, open: f32) -> Vec3 {
        let material = scene.material(self.hit.material);
        let sky = scene.environment.mean_radiance(self.side() * self.hit.normal);
        material.emissive + open * self.albedo(scene, material) * sky
    }

    /// What it sends to the eye of the light from a direction.
    fn reflected(&self, scene: &Scene, to_light: Vec3) -> Vec3 {
        let material = scene.material(self.hit.material);
        let half = (to_light - self.direction).normalize_or_zero();
        let normal = self.side() * self.hit.normal;
        reflection(
            self.albedo(scene, material),
            material.specular,
            material.exponent(),
            normal,
            to_light,
            half,
        )
    }
}

/// Surfaces that less than the first part of a ray reaches are lit by one cone of sky, from the second part on by five.
const HARDLY_SEEN: [f32; 2] = [0.05, 0.15];

/// Widening of a cone that stands for a fifth of the sky.
const SKY_SPREAD: f32 = 0.8;

/// Diffuse + specular of one normal, times the cosine to the light. The factor keeps the specular albedo at or
/// under k_s. [method §7]
pub(crate) fn reflection(
    albedo: Vec3,
    specular: f32,
    exponent: f32,
    normal: Vec3,
    to_light: Vec3,
    half: Vec3,
) -> Vec3 {
    let cosine = normal.dot(to_light);
    if cosine <= 0.0 {
        return Vec3::ZERO;
    }
    let mut reflected = albedo * FRAC_1_PI;
    if specular > 0.0 {
        let m = exponent;
        let norm = (m + 2.0) * (m + 4.0) / (8.0 * PI * (m + (-0.5 * m).exp2()));
        reflected += specular * norm * normal.dot(half).max(0.0).powf(m);
    }
    cosine * reflected
}

/// A part of what the eye sees of a voxel.
struct Visible {
    /// Unit normal on the seen side, scene space.
    normal: Vec3,
    color: Vec3,
    /// How much of what is seen, up to a factor common to all.
    weight: f32,
    /// Which part of the voxel it is, if one.
    point: Option<Point>,
}

/// What a voxel holds, by its number.
#[derive(Clone, Copy)]
enum Point {
    Surfel(u32),
    Lobe(u32),
    Scatterer(u32),
}

/// How a voxel is looked at.
struct Facing {
    /// Unit vector to the eye, texel space.
    view: Vec3,
    /// J⁻ᵀ: carries normals into the scene.
    cofactor: Mat3,
    /// Multiplies its colours.
    tint: Vec3,
}

impl Facing {
    /// The surfels that the eye sees.
    fn collect(&self, surfels: &[Surfel], visible: &mut Vec<Visible>) {
        visible.clear();
        let one = |(i, surfel): (usize, &Surfel)| {
            let normal = surfel.normal();
            Visible {
                normal: (self.cofactor * normal).normalize_or_zero(),
                color: surfel.color() * self.tint,
                weight: surfel.weight() * normal.dot(self.view),
                point: Some(Point::Surfel(i as u32)),
            }
        };
        visible.extend(surfels.iter().enumerate().filter(|(_, s)| s.sees(self.view)).map(one));
        // Seen through a gap that the masks are too coarse for.
        if visible.is_empty() {
            let faces = |(_, s): &(usize, &Surfel)| s.normal().dot(self.view) > 0.0;
            visible.extend(surfels.iter().enumerate().filter(faces).map(one));
        }
    }

    /// The lobes that are seen from here.
    fn collect_lobes(&self, level: &Level, voxel: u32, visible: &mut Vec<Visible>) {
        for (share, lobes) in level.lobes(voxel, self.view) {
            let whole: f32 = lobes.clone().map(|i| level.lobe(i).weight()).sum();
            visible.extend(lobes.map(|i| {
                let lobe = level.lobe(i);
                Visible {
                    normal: (self.cofactor * lobe.normal()).normalize_or_zero(),
                    color: lobe.color() * self.tint,
                    weight: share * lobe.weight() / whole,
                    point: Some(Point::Lobe(i)),
                }
            }));
        }
    }

    /// The scatterers, by how much of each passes to the eye.
    fn collect_scatterers(&self, scatterers: Scatterers, visible: &mut Vec<Visible>) {
        visible.extend(scatterers.points().iter().enumerate().map(|(i, point)| Visible {
            normal: (self.cofactor * point.normal()).normalize_or_zero(),
            color: point.color() * self.tint,
            // Where hardly anything passes, all count alike.
            weight: point.weight() * scatterers.transmittance(i, self.view).max(1e-4),
            point: Some(Point::Scatterer(i as u32)),
        }));
    }

    /// `count` normals (1 to 16) of the visible half of the voxel's ellipsoid, equal parts of what is seen.
    fn collect_ellipsoid(&self, voxel: &Voxel, count: u32, visible: &mut Vec<Visible>) {
        visible.clear();
        let seen = voxel.normals().visible(if self.view == Vec3::ZERO { Vec3::Z } else { self.view });
        let count = count.clamp(1, 16);
        for i in 0..count {
            // The first `count` points of Hammersley's set, centred in their strata.
            let x = (i as f32 + 0.5) / count as f32;
            let y = (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32 + 0.5 / count as f32;
            visible.push(Visible {
                normal: (self.cofactor * seen.sample([x, y.fract()])).normalize_or_zero(),
                color: voxel.albedo * self.tint,
                weight: 1.0,
                point: None,
            });
        }
    }
}

/// How quickly the ways to the eye and to the light part, beyond what the masks hold, in texel units: strands that stand
/// next to each other are some .03 apart. Measured on leaves, blades and hairs. [docs/notes/fidelity.md]
const SURFACES_APART: f32 = 0.03;

/// The same in a density, in voxel edges: it has no gaps, but what is seen of a voxel lies nearer to the eye than its
/// middle, and to a light beside it. Measured on hypertextures.
const DENSITIES_APART: f32 = 0.04;

/// How alike the ways to the eye and to the light are, where those that are `apart` (texel units) have nothing to do with
/// each other.
fn correlation(inverse: &Mat3, view: Vec3, to_light: Vec3, apart: f32) -> Correlation {
    if apart == 0.0 {
        return Correlation::NONE;
    }
    Correlation { q: (*inverse * (to_light - view)).length() / apart }
}

/// The colour that was painted on the skin below a voxel, and that of the surface there, where the coat wears it.
fn surface_colour(scene: &Scene, coat: &Coat, seen: &SeenVoxel, u: Vec3, edge: f32) -> Vec3 {
    if coat.skin.colors.is_none() && !coat.wears_material {
        return Vec3::ONE;
    }
    let index = scene.patch_index(seen.key.patch);
    let painted = coat.skin.color(index, [u.x, u.y]);
    let patch = &coat.skin.patches[index];
    let material = scene.materials.get(patch.material.0 as usize).filter(|_| coat.wears_material);
    let Some(material) = material else { return painted };
    let Some(uvs) = coat.skin.uvs.as_ref().and_then(|uvs| uvs.get(index)) else {
        return painted * material.base_color;
    };
    let [a, b, c, d] = *uvs;
    let prism = patch.is_prism();
    let uv = if prism { a + u.x * (b - a) + u.y * (c - a) } else { a.lerp(b, u.x).lerp(c.lerp(d, u.x), u.y) };
    // A voxel's edge in units of uv: box units per texel unit are one over the lattice's axes.
    let per_texel = |along: Vec2, axis: Vec2| along.length() / axis.length().max(f32::MIN_POSITIVE);
    let footprint = edge * per_texel(b - a, patch.lattice.u).max(per_texel(c - a, patch.lattice.v));
    painted * scene.colour_of(material, uv, footprint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_conserves_energy() {
        // ∫ specular cos dω over the hemisphere, seen along the normal, by the midpoint rule: at most k_s, and
        // not far below it for a narrow lobe.
        for (exponent, least) in [(2.0, 0.55), (20.0, 0.85), (400.0, 0.97)] {
            let (n, m) = (2000, 64);
            let mut albedo = 0.0_f64;
            for i in 0..n {
                let cosine = (i as f32 + 0.5) / n as f32;
                for j in 0..m {
                    let (sin, cos) = (j as f32 / m as f32 * 2.0 * PI).sin_cos();
                    let s = (1.0 - cosine * cosine).sqrt();
                    let to_light = Vec3::new(s * cos, s * sin, cosine);
                    let half = (Vec3::Z + to_light).normalize();
                    albedo += f64::from(reflection(Vec3::ZERO, 1.0, exponent, Vec3::Z, to_light, half).x);
                }
            }
            albedo *= 2.0 * std::f64::consts::PI / f64::from(n * m);
            assert!(albedo <= 1.001 && albedo >= least, "exponent {exponent}: albedo {albedo}");
        }
    }
}
