//! The light that what was hit sends to the eye: the materials and lights of the cone tracer, shadows by rays.

use std::ops::Range;

use glam::{DVec3, Vec3};
use pelage_geom::{Material, Ray};

use super::Lighting;
use super::content::Filling;
use super::medium;
use super::sample::{Points, Use, cosine_around, flight, towards_disk};
use super::stream::{Hit, Met, Query, Stream};
use super::world::World;
use crate::Camera;
use crate::cone::gloss::Gloss;
use crate::surface::SurfaceHit;

/// A point that is seen, ready to be lit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub pixel: [u32; 2],
    /// Which of the pixel's samples.
    sample: u32,
    point: DVec3,
    /// Where shadow rays start.
    lifted: DVec3,
    /// Unit vector to the eye.
    view: Vec3,
    /// Shading normal and the triangle's own, unit length, on the side of the eye.
    normal: Vec3,
    flat: Vec3,
    albedo: Vec3,
    gloss: Gloss,
    emissive: Vec3,
}

impl Seen {
    /// Content of a box.
    pub(super) fn content(world: &World, ray: &Ray, hit: &Hit, pixel: [u32; 2], sample: u32) -> Self {
        let scene = world.scene;
        let (coat, _) = scene.patch(hit.patch);
        let filled = world.filled(hit.patch);
        let (carrier, (filling, tile)) = (&filled.carrier, filled.tile(hit.copy));
        let texel = coat.texels.of(&tile);
        let view = -ray.direction.as_vec3();
        let point = ray.at(hit.t);
        let (normal, flat, color, off) = match (filling, hit.met) {
            (Filling::Triangles(content), Met::Triangle { piece, flat }) => {
                let piece = &content.pieces[piece as usize];
                let facing = |n: Vec3, to: Vec3| if n.dot(to) < 0.0 { -n } else { n };
                let flat = facing(flat.normalize_or(view), view);
                let normal = facing(carrier.normal(hit.at, &tile, &piece.corners).unwrap_or(flat), flat);
                // Triangles are exact in the box's frame: off them by what rounding in the scene may amount to.
                (normal, flat, piece.color, 1e-8 * carrier.radius + scene.rounding())
            }
            // A density is lit on the side of its normal, from wherever it is seen, and has no surface to be off.
            (Filling::Density(medium), _) => {
                let normal = medium::normal(medium, carrier, &tile, hit.at);
                let color = medium.density.color(carrier.in_texel(&tile, hit.at));
                (normal, normal, color, 0.0)
            }
            // No ray meets triangles in a density, or the reverse.
            (Filling::Triangles(_), Met::Density) => (view, view, Vec3::ZERO, 0.0),
        };
        Self {
            pixel,
            sample,
            point,
            lifted: point + off * flat.as_dvec3(),
            view,
            normal,
            flat,
            albedo: color * tile.tint * world.worn(hit.patch, hit.at),
            gloss: Gloss::new(texel.specular, texel.roughness),
            emissive: Vec3::ZERO,
        }
    }

    /// How far it is along the view axis, in scene units.
    pub(super) fn depth(&self, camera: &Camera) -> f32 {
        (self.point - camera.position.as_dvec3()).dot(camera.forward().as_dvec3()) as f32
    }

    /// An opaque surface.
    pub(super) fn surface(world: &World, ray: &Ray, hit: &SurfaceHit, pixel: [u32; 2], sample: u32) -> Self {
        let scene = world.scene;
        let fallback = Material::default();
        let material = scene.materials.get(hit.material.0 as usize).unwrap_or(&fallback);
        let view = -ray.direction.as_vec3();
        // Seen from behind, the surface shows its other side.
        let side = if hit.geometric_normal.dot(view) < 0.0 { -1.0 } else { 1.0 };
        let flat = side * hit.geometric_normal;
        Self {
            pixel,
            sample,
            point: hit.point,
            lifted: hit.lifted[usize::from(side < 0.0)] + scene.rounding() * flat.as_dvec3(),
            view,
            normal: side * hit.normal,
            flat,
            albedo: scene.colour_of(material, hit.uv, 0.0),
            gloss: Gloss::new(material.specular, material.roughness),
            emissive: material.emissive,
        }
    }
}

/// Lights what is seen, many points at once; holds the buffers of the shadow rays.
#[derive(Default)]
pub(super) struct Shader {
    queries: Vec<Query>,
    /// What a shadow ray brings if nothing is in its way, and to which point.
    brought: Vec<(u32, Vec3)>,
}

impl Shader {
    /// The radiance that each point sends to the eye under `lighting`.
    pub(super) fn light(
        &mut self,
        world: &World,
        stream: &mut Stream,
        lighting: &Lighting,
        seed: u32,
        shadows: bool,
        seen: &[Seen],
    ) -> Vec<Vec3> {
        let mut radiance: Vec<Vec3> = seen.iter().map(|s| s.emissive).collect();
        if !shadows {
            for (radiance, s) in radiance.iter_mut().zip(seen) {
                *radiance += s.albedo * lighting.environment.mean_radiance(s.normal);
            }
        } else if lighting.environment != crate::Environment::BLACK {
            self.begin();
            for (i, s) in seen.iter().enumerate() {
                let point = Points::new(s.pixel, seed, Use::Sky).get(s.sample);
                let direction = cosine_around(s.normal, point);
                if s.flat.dot(direction) > 0.0 {
                    let brought = s.albedo * lighting.environment.radiance(direction);
                    let flight = flight(s.pixel, seed, Use::Sky, s.sample);
                    self.ask((i, s), direction, f64::INFINITY, flight, brought);
                }
            }
            self.collect(world, stream, true, &mut radiance);
        }
        for (number, light) in (0_u32..).zip(&lighting.lights) {
            self.begin();
            for (i, s) in seen.iter().enumerate() {
                let Some(incoming) = light.incoming(s.point.as_vec3()) else { continue };
                let point = Points::new(s.pixel, seed, Use::Light(number)).get(s.sample);
                let towards = towards_disk(incoming.direction, 0.5 * incoming.spread, point);
                let direction = towards.normalize_or(incoming.direction);
                if s.flat.dot(direction) <= 0.0 {
                    continue;
                }
                let half = (s.view + direction).normalize_or_zero();
                let reflected = s.gloss.reflected(s.albedo, s.normal, direction, half);
                if reflected != Vec3::ZERO {
                    let end = f64::from(incoming.distance * towards.length());
                    let flight = flight(s.pixel, seed, Use::Light(number), s.sample);
                    self.ask((i, s), direction, end, flight, incoming.irradiance * reflected);
                }
            }
            self.collect(world, stream, shadows, &mut radiance);
        }
        radiance
    }

    fn begin(&mut self) {
        self.queries.clear();
        self.brought.clear();
    }

    fn ask(&mut self, (i, s): (usize, &Seen), direction: Vec3, end: f64, flight: u64, brought: Vec3) {
        let ray = Ray { origin: s.lifted, direction: direction.as_dvec3().normalize() };
        self.queries.push(Query { ray, end, flight, hit: None });
        self.brought.push((i as u32, brought));
    }

    /// Adds what the shadow rays bring where nothing is in their way.
    fn collect(&mut self, world: &World, stream: &mut Stream, shadows: bool, radiance: &mut [Vec3]) {
        if shadows {
            stream.trace(world, &mut self.queries, true);
        }
        for (query, &(i, brought)) in self.queries.iter().zip(&self.brought) {
            let blocked =
                shadows && (query.hit.is_some() || world.scene.surfaces.blocked(&query.ray, query.end));
            if !blocked {
                radiance[i as usize] += brought;
            }
        }
    }
}

/// Samples `range` of every pixel of a tile: what each sees, if it sees anything.
pub(super) fn look(
    world: &World,
    stream: &mut Stream,
    queries: &mut [Query],
    pixels: &[[u32; 2]],
    samples: Range<u32>,
) -> Vec<Seen> {
    stream.trace(world, queries, false);
    let places = samples.flat_map(|sample| pixels.iter().map(move |&pixel| (pixel, sample)));
    queries
        .iter()
        .zip(places)
        .filter_map(|(query, (pixel, sample))| {
            let nearer = query.hit.map_or(query.end, |hit| hit.t);
            match (world.scene.surfaces.closest(&query.ray, nearer), &query.hit) {
                (Some(surface), _) => Some(Seen::surface(world, &query.ray, &surface, pixel, sample)),
                (None, Some(hit)) => Some(Seen::content(world, &query.ray, hit, pixel, sample)),
                (None, None) => None,
            }
        })
        .collect()
}
