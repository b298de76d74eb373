//! The light that opaque surfaces send to the eye, under and beside coats. [seed §6.2]

use glam::{DVec3, Vec3};
use pelage_geom::{Cone, Material, Ray};

use super::composite::SeenSurface;
use super::deep_shadow::LightCone;
use super::gloss::Gloss;
use super::shade::{SKY_SPREAD, Shader};
use super::shadow::{Correlation, ShadowCone, is_blocked};
use crate::light::Incoming;
use crate::{Environment, Scene, Settings};

impl Shader {
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
        if is_shadowed && scene.environment != Environment::BLACK {
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
        for (index, light) in scene.lights.iter().enumerate() {
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
                    if is_blocked(scene, &ray, f64::from(incoming.distance)) {
                        continue;
                    }
                }
                reflected += point.weight * incoming.irradiance * lit;
                towards = Some(incoming);
            }
            let Some(Incoming { direction, distance, spread, .. }) = towards else { continue };
            let arriving = if is_shadowed {
                let cone = coats(direction, distance, spread);
                let fineness = cone.cone.width;
                let of = LightCone { light: index, cone, normal: flat, fineness };
                self.shadows.of_light(scene, settings, &of)
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
        let gloss = Gloss::new(material.specular, material.roughness);
        gloss.reflected(self.albedo(scene, material), normal, to_light, half)
    }
}

/// Surfaces that less than the first part of a ray reaches are lit by one cone of sky, from the second part on by five.
const HARDLY_SEEN: [f32; 2] = [0.05, 0.15];
