//! The light that a seen voxel sends to the eye. [seed §5.2, §6.1c, method §7]

use glam::{Mat3, Vec2, Vec3};
use pelage_geom::{Cone, Ray};
use pelage_texel::{Scatterers, Surfel};

use super::below::Below;
use super::composite::SeenVoxel;
use super::deep_shadow::LightCone;
use super::facing::{Facing, Towards};
use super::gloss::Gloss;
use super::path::to_box;
use super::shadow::{Correlation, ShadowBuffers, ShadowCone, is_blocked};
use crate::scene::Coat;
use crate::{Counts, Environment, Scene, Settings};

/// Lights what a pixel sees; holds the buffers of the shadow cones.
#[derive(Default)]
pub(crate) struct Shader {
    pub(super) shadows: ShadowBuffers,
    facing: Facing,
    below: Below,
    /// Of the pixel at hand.
    cone: Cone,
}

impl Shader {
    /// What was done since this was asked last.
    pub fn take_counts(&mut self) -> Counts {
        self.shadows.take_counts()
    }

    /// Begins with the voxels of another pixel, and its cone.
    pub fn begin(&mut self, voxels: &[SeenVoxel], cone: Cone) {
        self.below.begin(voxels);
        self.cone = cone;
    }

    /// The radiance of a voxel's visible matter towards the eye.
    pub fn voxel(&mut self, scene: &Scene, settings: &Settings, seen: &SeenVoxel) -> Vec3 {
        let mut radiance = Vec3::ZERO;
        let of_sky = self.light(scene, settings, seen, |_, of_light| radiance += of_light);
        radiance + of_sky
    }

    /// The same, light by light: what it sends of the sky, and to `each` the number of a light and what it sends of that.
    pub fn light(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        seen: &SeenVoxel,
        mut each: impl FnMut(usize, Vec3),
    ) -> Vec3 {
        let (coat, patch) = scene.patch(seen.key.patch);
        let (texel, tile) = coat.standing(patch, seen.key.copy());
        let level = texel.level(u32::from(seen.key.level));
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
        let Self { shadows, facing, below, cone } = self;
        facing.view = (inverse * view).normalize_or_zero();
        facing.jacobian = jacobian;
        facing.cofactor = inverse.transpose();
        facing.tint = tint;
        facing.gloss = Gloss::new(texel.specular, texel.roughness);
        facing.shadows = settings.shadows;
        facing.environment = Some(scene.environment).filter(|e| *e != Environment::BLACK);
        facing.lights.clear();
        facing.lights.extend(scene.lights.iter().enumerate().filter_map(|(index, light)| {
            let incoming = light.incoming(point.as_vec3())?;
            let towards = (inverse * incoming.direction).normalize_or_zero();
            Some(Towards::new(index, incoming, towards, view))
        }));
        facing.begin();

        facing.add_surfels(level, seen.voxel);
        facing.add_reflectance(level, seen.voxel);
        let scatterers = level.scatterers(seen.voxel);
        let holds_shadows = Scatterers::hold_shadows(seen.key.level.into());
        facing.add_scatterers(scatterers, holds_shadows);
        if facing.is_blank() {
            facing.add_ellipsoid(&level.voxel(seen.voxel), settings.normals);
        }

        let [mut of_sky, from_below] = facing.sky();
        if settings.shadows {
            // Of the sky, the masks say what is near, the openness there what is above beyond that, and a cone what is
            // below: as a rule, the surface that the coat stands on.
            of_sky *= texel.openness(seen.key.level.into(), seen.key.within().into());
            if from_below != Vec3::ZERO {
                of_sky += from_below * below.of(shadows, scene, settings, seen.key.patch);
            }
        }
        // What is near is in the masks, or in the maps.
        let edge = 1.0 / scale;
        let (near, apart) = if scatterers.is_empty() {
            (Surfel::reach(edge), SURFACES_APART)
        } else if holds_shadows {
            (Scatterers::reach(seen.key.level.into()), 0.0)
        } else {
            (0.0, DENSITIES_APART * edge)
        };
        let width = f64::from(jacobian.determinant().abs().cbrt() * edge);
        let balance = level.balance().filter(|_| settings.shadows);
        for light in &facing.lights {
            let Towards { index, incoming, .. } = light;
            let reflected = facing.reflected(light);
            if reflected == Vec3::ZERO {
                continue;
            }
            let to_light = incoming.direction;
            let direction = to_light.as_dvec3().normalize();
            let mut arriving = 1.0;
            if settings.shadows {
                // Opaque meshes are no part of the voxel's own matter: they are asked from the point itself.
                let end = f64::from(incoming.distance);
                if is_blocked(scene, &Ray { origin: point, direction }, end) {
                    continue;
                }
                let shadow = ShadowCone {
                    origin: point,
                    direction,
                    start: f64::from(near / (inverse * to_light).length()),
                    end,
                    cone: Cone { width, spread: f64::from(incoming.spread) },
                    correlation: correlation(&inverse, view, to_light, apart),
                };
                // A density shadows itself from the point on, and a light beside the eye shines through the gap that it
                // is seen through: both ask for the point itself.
                let alike =
                    shadow.correlation.factor(shadow.start as f32, shadow.start as f32) < HARDLY_ALIKE;
                arriving = if alike || !scatterers.is_empty() {
                    shadows.through_coats(scene, settings, &shadow)
                } else {
                    let normal = facing.along().normalize_or_zero();
                    let fineness = cone.width(seen.t.into());
                    let of = LightCone { light: *index, cone: shadow, normal, fineness };
                    shadows.of_light(scene, settings, &of)
                };
            }
            // What the level as a whole sends too little or too much of.
            let balance = balance.map_or(1.0, |balance| balance.factor(facing.view, light.towards));
            each(*index, balance * arriving * incoming.irradiance * reflected);
        }
        of_sky
    }
}

/// Widening of a cone that stands for a fifth of the sky.
pub(super) const SKY_SPREAD: f32 = 0.8;

/// Where a depth next to what the masks know counts less than this, the ways to the eye and to the light are so much alike
/// that a line beside them is no match: at the finest levels, where they are less than 35° apart.
const HARDLY_ALIKE: f32 = 0.75;

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
