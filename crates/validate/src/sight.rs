//! What a camera has in view: the place on a coat that validation looks at, and how large the boxes and voxels are there.

use glam::{Mat2, Mat3, Vec2, Vec3};
use pelage::compile::Prepared;
use pelage::geom::{Footprint, texel_footprint};
use pelage::skin::Patch;
use pelage::tracer::{Coat, Lod, Rays, RenderError, Settings, render};

/// A place on a coat near the middle of what a scene's camera sees, turned like most of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// The place, in scene units.
    pub target: Vec3,
    /// Unit vector out of the surface, in the mean over all that is seen of it: the suns stand for the whole view.
    pub normal: Vec3,
    /// Unit vector from the camera to it.
    pub direction: Vec3,
    /// Side of the median box of all coats: the root of its area half way up, in scene units.
    pub box_width: f32,
    /// How far a coat reaches from its surface, in scene units.
    pub reach: f32,
    /// Smallest and largest coordinates of all coats.
    pub bounds: [Vec3; 2],
    /// The finest level of the texel there.
    pub depth: u32,
    /// Texel steps to scene steps, there.
    jacobian: Mat3,
    rule: Footprint,
}

/// Why there is nothing to look at.
#[derive(Debug, thiserror::Error)]
pub enum SightError {
    /// The scene has no coat, or only coats without boxes.
    #[error("nothing grows in the scene: there is no box to validate")]
    NoCoat,
    /// No coat is in the camera's view.
    #[error("the camera sees no coat")]
    NotSeen,
    /// The settings of the scene cannot be used.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Columns and rows of the small picture that tells what is in view.
const GLANCE: u32 = 96;

/// Places that the target is chosen from, and the mean normal taken over, at most.
const MOST_PLACES: usize = 256;

impl Sight {
    /// Looks through the camera of `prepared`.
    pub fn of(prepared: &Prepared) -> Result<Self, SightError> {
        let coats = prepared.scene.coats();
        let stands: Vec<(Stand, &Coat, &Patch)> = coats
            .iter()
            .flat_map(|coat| coat.skin.patches.iter().map(move |patch| (Stand::of(coat, patch), coat, patch)))
            .collect();
        let bounds = coats
            .iter()
            .flat_map(|coat| (0..coat.skin.len()).map(|patch| coat.skin.bounds(patch)))
            .reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)])
            .ok_or(SightError::NoCoat)?;
        let mut sides: Vec<f32> = stands.iter().map(|(stand, ..)| stand.side()).collect();
        let middle = sides.len() / 2;
        let (_, &mut box_width, _) = sides.select_nth_unstable_by(middle, f32::total_cmp);
        let reach = coats
            .iter()
            .flat_map(|coat| coat.skin.base.iter().zip(&coat.skin.top))
            .map(|(base, top)| base.distance(*top))
            .fold(0.0, f32::max);

        // The box that a place is in. What is farther from the middle of every box is in none: the ground, a wall.
        let box_at = |place: Vec3| {
            let away = |(stand, ..): &&(Stand, &Coat, &Patch)| stand.middle.distance(place);
            let nearest = stands.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            nearest.filter(|b| away(b) <= b.0.radius)
        };
        // Some of the places, in the order of their distance from the middle of the picture.
        let places = in_view(prepared)?;
        let seen: Vec<(Vec3, &(Stand, &Coat, &Patch))> = places
            .iter()
            .step_by(places.len().div_ceil(MOST_PLACES).max(1))
            .filter_map(|&place| Some((place, box_at(place)?)))
            .collect();
        let normal = seen.iter().map(|(_, (stand, ..))| stand.normal()).sum::<Vec3>().normalize_or_zero();
        // Near the middle, and turned like the whole: one order counts as much as the other.
        let unlike = |k: usize| k as f32 / seen.len() as f32 - seen[k].1.0.normal().dot(normal);
        let best = (0..seen.len()).min_by(|&a, &b| unlike(a).total_cmp(&unlike(b)));
        let &(target, (stand, coat, patch)) = best.and_then(|k| seen.get(k)).ok_or(SightError::NotSeen)?;
        let rule = match prepared.settings.lod {
            Lod::Footprint(rule) => rule,
            Lod::Level(_) => Footprint::Auto,
        };
        Ok(Self {
            target,
            normal: normal.try_normalize().unwrap_or_else(|| stand.normal()),
            direction: (target - prepared.camera.position).normalize_or(prepared.camera.forward()),
            box_width,
            reach,
            bounds,
            depth: coat.texels.depth(),
            jacobian: stand.texel_jacobian(patch),
            rule,
        })
    }

    /// The continuous level that a pixel as wide as `width` (scene units) at the target reads there, if there were any
    /// number of levels.
    pub fn level(&self, width: f32) -> f32 {
        -texel_footprint(self.rule, &self.jacobian, self.direction, width).log2()
    }

    /// The width of a pixel at the target, in scene units, that reads the continuous `level` there.
    pub fn width_at(&self, level: f32) -> f32 {
        // The footprint is proportional to the width.
        (self.level(1.0) - level).exp2()
    }
}

/// How a box stands, half way up.
struct Stand {
    middle: Vec3,
    jacobian: Mat3,
    /// From the middle to the farthest corner.
    radius: f32,
}

impl Stand {
    fn of(coat: &Coat, patch: &Patch) -> Self {
        let corner = |i: &u32| (coat.skin.base[*i as usize], coat.skin.top[*i as usize]);
        let corners: Vec<(Vec3, Vec3)> = patch.corners().iter().map(corner).collect();
        let middle = corners.iter().map(|(a, b)| 0.5 * (*a + *b)).sum::<Vec3>() / corners.len() as f32;
        let radius = corners.iter().flat_map(|(a, b)| [a, b]).map(|p| p.distance(middle)).fold(0.0, f32::max);
        let half_way: Vec<Vec3> = corners.iter().map(|(a, b)| 0.5 * (*a + *b)).collect();
        // Box order: A, B along u, C along v, D.
        let (u, v) = match half_way[..] {
            [a, b, c, d] => (0.5 * (b - a + d - c), 0.5 * (c - a + d - b)),
            [a, b, c] => (b - a, c - a),
            _ => (Vec3::ZERO, Vec3::ZERO),
        };
        let w = corners.iter().map(|(a, b)| *b - *a).sum::<Vec3>() / corners.len() as f32;
        Self { middle, jacobian: Mat3::from_cols(u, v, w), radius }
    }

    /// Side of the square as large as the box is half way up; of a prism, twice as large.
    fn side(&self) -> f32 {
        self.jacobian.x_axis.cross(self.jacobian.y_axis).length().sqrt()
    }

    fn normal(&self) -> Vec3 {
        let normal = self.jacobian.x_axis.cross(self.jacobian.y_axis).normalize_or(Vec3::Y);
        if normal.dot(self.jacobian.z_axis) < 0.0 { -normal } else { normal }
    }

    /// Texel steps to scene steps: the box's, after the inverse of its lattice.
    fn texel_jacobian(&self, patch: &Patch) -> Mat3 {
        let lattice = Mat2::from_cols(patch.lattice.u, patch.lattice.v).inverse();
        let along = |step: Vec2| self.jacobian.x_axis * step.x + self.jacobian.y_axis * step.y;
        Mat3::from_cols(along(lattice.x_axis), along(lattice.y_axis), self.jacobian.z_axis)
    }
}

/// The places that the camera sees, the nearest to the middle of the picture first.
fn in_view(prepared: &Prepared) -> Result<Vec<Vec3>, SightError> {
    // Pixels that are square, in a picture of the same shape.
    let [width, height] = prepared.settings.size;
    let scale = GLANCE as f32 / width.max(height) as f32;
    let size = [width, height].map(|n| ((n as f32 * scale) as u32).max(1));
    let settings = Settings { size, crop: None, rays: Rays::One, shadows: false, ..prepared.settings };
    let camera = &prepared.camera;
    let film = render(&prepared.scene, camera, &settings, &|_| std::ops::ControlFlow::Continue(()))?;
    let mut seen: Vec<(f32, Vec3)> = Vec::new();
    for y in 0..size[1] {
        for x in 0..size[0] {
            let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let Some(pixel) = film.get(x, y).filter(|p| p.alpha >= 0.5 && p.depth.is_finite()) else {
                continue;
            };
            let (ray, _) = camera.cone(centre, size);
            let direction = ray.direction.as_vec3();
            let place = camera.position + direction * (pixel.depth / direction.dot(camera.forward()));
            let from_middle = (centre - 0.5 * Vec2::new(size[0] as f32, size[1] as f32)).length_squared();
            seen.push((from_middle, place));
        }
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(seen.into_iter().map(|(_, place)| place).collect())
}
