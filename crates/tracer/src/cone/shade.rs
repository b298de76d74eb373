//! The light that a seen voxel sends to the eye. [seed §5.2, §6.1c, method §7]

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Mat3, Vec2, Vec3};
use pelage_geom::{Cone, material::exponent_of_roughness};
use pelage_texel::{Scatterers, Surfel};

use super::below::Below;
use super::composite::SeenVoxel;
use super::facing::{Facing, Point, Visible};
use super::path::to_box;
use super::shadow::{Correlation, ShadowBuffers, ShadowCone};
use crate::scene::Coat;
use crate::{Counts, Environment, Scene, Settings};

/// Lights what a pixel sees; holds the buffers of the shadow cones.
#[derive(Default)]
pub(crate) struct Shader {
    pub(super) shadows: ShadowBuffers,
    surfels: Vec<Surfel>,
    visible: Vec<Visible>,
    below: Below,
}

impl Shader {
    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        self.shadows.take_counts()
    }

    /// Begins with the voxels of another pixel.
    pub fn begin(&mut self, voxels: &[SeenVoxel]) {
        self.below.begin(voxels);
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
        let below = if lit_from_below {
            self.below.of(&mut self.shadows, scene, settings, seen.key.patch)
        } else {
            0.0
        };
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
}

/// Widening of a cone that stands for a fifth of the sky.
pub(super) const SKY_SPREAD: f32 = 0.8;

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
