//! What a voxel sends to the eye of the light that reaches it: a sum over the points of its surface, its reflectance, the points
//! of its density, or normals of its ellipsoid, four at a time.

use glam::{Mat3, Vec3};
use pelage_geom::Vec3x4;
use pelage_texel::{Bend, Level, Samples, Scatterers, Surfel, SurfelsX4, Voxel};
use wide::f32x4;

use super::gloss::Gloss;
use crate::Environment;
use crate::light::Incoming;

/// How a voxel is looked at and lit, and what it sends back.
#[derive(Default)]
pub(super) struct Facing {
    /// Unit vector to the eye, texel space.
    pub view: Vec3,
    /// From texel steps to scene steps.
    pub jacobian: Mat3,
    /// Its inverse, transposed: carries normals into the scene.
    pub cofactor: Mat3,
    /// Multiplies its colours.
    pub tint: Vec3,
    pub gloss: Gloss,
    /// Whether its parts shadow each other.
    pub shadows: bool,
    /// The light of the surroundings; `None` where it is black.
    pub environment: Option<Environment>,
    /// The other lights that shine here.
    pub lights: Vec<Towards>,
    sums: Sums,
}

/// A light as a voxel sees it.
pub(super) struct Towards {
    /// Its place among those of the scene.
    pub index: usize,
    pub incoming: Incoming,
    /// Unit vector to it, texel space.
    pub towards: Vec3,
    /// Unit vector half-way between those to it and to the eye, scene space.
    pub half: Vec3,
    /// What is reflected of it, weighed; per unit of illuminance.
    reflected: Vec3x4,
}

impl Towards {
    /// A light from which `incoming` arrives, along `towards` of texel space; `view` is the unit vector to the eye, scene
    /// space.
    pub fn new(index: usize, incoming: Incoming, towards: Vec3, view: Vec3) -> Self {
        let half = (view + incoming.direction).normalize_or_zero();
        Self { index, incoming, towards, half, reflected: Vec3x4::default() }
    }
}

/// What is summed over the parts that the eye sees.
#[derive(Default)]
struct Sums {
    /// How much of them is seen, up to a factor that all have in common.
    weight: f32x4,
    /// What is reflected of the surroundings, weighed: of those above and of those below the surface that the texel
    /// stands on.
    sky: [Vec3x4; 2],
    /// Normals (texel space), weighed.
    normal: Vec3x4,
}

/// How long the mean of unit normals is of parts that begin to face alike, and of those that do. Of what is seen of a
/// sphere it is ⅔ long, of an upright cylinder π/4.
const FACING_ALIKE: [f32; 2] = [0.85, 0.95];

/// Of four hemispheres: how much is open, and the sums of the open directions (texel space), above and below.
type Halves = [(f32x4, Vec3x4); 2];

/// Of one.
type Half = (f32, Vec3);

impl Facing {
    /// Forgets the last voxel's sums.
    pub fn begin(&mut self) {
        self.sums = Sums::default();
    }

    /// Whether nothing of the voxel is seen so far.
    pub fn is_blank(&self) -> bool {
        self.sums.weight == f32x4::ZERO
    }

    /// The normal (scene space, of any length) of the surface along which what is seen stays what it is: of parts that face
    /// alike their own, else that of the surface that the texel stands on.
    pub fn along(&self) -> Vec3 {
        let mean = self.sums.normal.sum() / self.sums.weight.reduce_add();
        let [least, most] = FACING_ALIKE;
        let alike = ((mean.length() - least) / (most - least)).clamp(0.0, 1.0);
        self.cofactor * Vec3::Z.lerp(mean.normalize_or(Vec3::Z), alike)
    }

    /// What is sent back of the surroundings above and below, of all that is open.
    pub fn sky(&self) -> [Vec3; 2] {
        let whole = self.sums.weight.reduce_add();
        let [above, below] = &self.sums.sky;
        [above.sum() / whole, below.sum() / whole]
    }

    /// What is sent back of a light, per unit of illuminance.
    pub fn reflected(&self, light: &Towards) -> Vec3 {
        light.reflected.sum() / self.sums.weight.reduce_add()
    }

    /// The surfels that the eye sees.
    pub fn add_surfels(&mut self, level: &Level, voxel: u32) {
        let eye = self.view;
        // Those that are seen are gathered first, since most are not.
        let (mut seen, mut count) = ([Surfel::NOWHERE; 4], 0);
        let mut four = [Surfel::NOWHERE; 4];
        let mut surfels = level.surfels(voxel);
        loop {
            let mut filled = 0;
            for (slot, surfel) in four.iter_mut().zip(&mut surfels) {
                *slot = surfel;
                filled += 1;
            }
            if filled == 0 {
                break;
            }
            let sees = SurfelsX4::new(&four[..filled]).sees(eye);
            for (_, surfel) in four.iter().enumerate().filter(|(i, _)| sees >> i & 1 != 0) {
                seen[count] = *surfel;
                count += 1;
                if count == seen.len() {
                    self.add_four_surfels(&seen);
                    count = 0;
                }
            }
            if filled < four.len() {
                break;
            }
        }
        self.add_four_surfels(&seen[..count]);
        // Seen through a gap that the masks are too coarse for.
        if self.is_blank() {
            let faces = |surfel: &Surfel| surfel.normal().dot(eye) > 0.0;
            level.surfels(voxel).filter(faces).for_each(|surfel| self.add_four_surfels(&[surfel]));
        }
    }

    /// At most four.
    fn add_four_surfels(&mut self, seen: &[Surfel]) {
        if seen.is_empty() {
            return;
        }
        let (eye, surfels) = (self.view, SurfelsX4::new(seen));
        let Samples { normal, color, weight } = surfels.samples;
        let weight = weight * normal.dot(Vec3x4::splat(eye));
        let lit = |light: &Towards| surfels.lit(eye, light.towards);
        let sky = || Some(side_by_side(|i| seen.get(i).map(Surfel::sky)));
        self.add(normal, color, weight, lit, sky);
    }

    /// What a voxel of a coarse level reflects. Without shadows it has nothing to say: they are in it.
    pub fn add_reflectance(&mut self, level: &Level, voxel: u32) {
        let Some(reflectance) = level.reflectance(voxel, self.view).filter(|_| self.shadows) else { return };
        self.sums.weight += once(1.0);
        self.sums.normal += alone(reflectance.normal);
        let tint = self.tint;
        if let Some(environment) = &self.environment {
            for (sum, (open, directions)) in self.sums.sky.iter_mut().zip(reflectance.sky) {
                let turned = (self.jacobian * directions).normalize_or_zero() * directions.length();
                *sum += environment.gathered(once(open), alone(turned)) * alone(tint * reflectance.color);
            }
        }
        let inverse = self.cofactor.transpose();
        for light in &mut self.lights {
            let length = (inverse * light.incoming.direction).length();
            let bend = Bend { inverse, length, highlight: self.gloss.exponent().map(|m| (light.half, m)) };
            let lit = reflectance.lit(light.towards, &bend);
            light.reflected += alone(self.gloss.reflected_mean(tint * lit.diffuse, lit.gloss));
        }
    }

    /// The scatterers, by how much of each passes to the eye. `holds_shadows` where they say which light reaches them.
    pub fn add_scatterers(&mut self, scatterers: Scatterers, holds_shadows: bool) {
        for (begin, four) in (0..).step_by(4).zip(scatterers.points().chunks(4)) {
            let point = |i: usize| four.get(i);
            let vectors = |of: &dyn Fn(usize) -> Vec3| Vec3x4::new([of(0), of(1), of(2), of(3)]);
            let numbers = |of: &dyn Fn(usize) -> f32| f32x4::new([of(0), of(1), of(2), of(3)]);
            // Where hardly anything passes, all count alike.
            let weight = |i: usize| {
                let passes = || scatterers.transmittance(begin + i, self.view).max(1e-4);
                point(i).map_or(0.0, |point| point.weight() * passes())
            };
            let weight = numbers(&weight);
            let normal = vectors(&|i| point(i).map_or(Vec3::Z, |point| point.normal()));
            let color = vectors(&|i| point(i).map_or(Vec3::ZERO, |point| point.color()));
            let lit = |light: &Towards| match holds_shadows {
                true => numbers(&|i| scatterers.transmittance(begin + i, light.towards)),
                false => f32x4::ONE,
            };
            let sky = |i: usize| point(i).map(|_| scatterers.sky(begin + i));
            self.add(normal, color, weight, lit, || Some(side_by_side(sky)));
        }
    }

    /// `count` normals (1 to 16) of the visible half of the voxel's ellipsoid, equal parts of what is seen.
    pub fn add_ellipsoid(&mut self, voxel: &Voxel, count: u32) {
        let seen = voxel.normals().visible(if self.view == Vec3::ZERO { Vec3::Z } else { self.view });
        let count = count.clamp(1, 16);
        let color = Vec3x4::splat(voxel.albedo);
        for begin in (0..count).step_by(4) {
            let normal = |i: u32| {
                let i = begin + i;
                // The first `count` points of Hammersley's set, centred in their strata.
                let x = (i as f32 + 0.5) / count as f32;
                let y = (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32 + 0.5 / count as f32;
                seen.sample([x, y.fract()])
            };
            let weight = |i: u32| if begin + i < count { 1.0 } else { 0.0 };
            let normals = Vec3x4::new([normal(0), normal(1), normal(2), normal(3)]);
            let weights = f32x4::new([weight(0), weight(1), weight(2), weight(3)]);
            self.add(normals, color, weights, |_| f32x4::ONE, || None);
        }
    }

    /// Adds four parts that face `normal` (texel space): `lit` says how much of each a light reaches from what is near, and
    /// `sky` what is open of their hemispheres, if that is known.
    #[inline]
    fn add(
        &mut self,
        normal: Vec3x4,
        color: Vec3x4,
        weight: f32x4,
        lit: impl Fn(&Towards) -> f32x4,
        sky: impl FnOnce() -> Option<Halves>,
    ) {
        let color = color * Vec3x4::splat(self.tint);
        self.sums.weight += weight;
        self.sums.normal += normal * weight;
        if let Some(environment) = &self.environment {
            let [above, below] = &mut self.sums.sky;
            match self.shadows.then(sky).flatten() {
                Some(halves) => {
                    for (sum, (open, directions)) in [above, below].into_iter().zip(halves) {
                        let turned = directions.carried(&self.jacobian).normalize_or_zero();
                        *sum += color * environment.gathered(open, turned * directions.length()) * weight;
                    }
                }
                None => {
                    let normal = normal.carried(&self.cofactor).normalize_or_zero();
                    *above += color * environment.mean_radiance_x4(normal) * weight;
                }
            }
        }
        for light in &mut self.lights {
            let facing = normal.dot(Vec3x4::splat(light.towards)).simd_gt(f32x4::ZERO);
            if !facing.any() {
                continue;
            }
            let lit = if self.shadows { lit(light) } else { f32x4::ONE };
            let normal = normal.carried(&self.cofactor).normalize_or_zero();
            let reflected = self.gloss.reflected_x4(color, normal, light.incoming.direction, light.half);
            light.reflected += reflected * ((weight * lit) & facing);
        }
    }
}

/// A number in the first of four lanes.
fn once(x: f32) -> f32x4 {
    f32x4::new([x, 0.0, 0.0, 0.0])
}

/// A vector in the first of four lanes.
fn alone(v: Vec3) -> Vec3x4 {
    Vec3x4::new([v, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO])
}

/// Of up to four parts.
#[inline]
fn side_by_side(sky: impl Fn(usize) -> Option<[Half; 2]>) -> Halves {
    let one = |i: usize| sky(i).unwrap_or_default();
    let [a, b, c, d] = [one(0), one(1), one(2), one(3)];
    let half = |i: usize| {
        let [a, b, c, d] = [a[i], b[i], c[i], d[i]];
        (f32x4::new([a.0, b.0, c.0, d.0]), Vec3x4::new([a.1, b.1, c.1, d.1]))
    };
    [half(0), half(1)]
}
