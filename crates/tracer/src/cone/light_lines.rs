//! The lines of a light: those of the sun parallel, those of a lamp from one point, sorted into the cells of a raster that
//! lies across them. Points in one cell share its line.

use glam::{DVec2, DVec3};
use pelage_geom::Ray;

use crate::{Light, Scene};

/// The raster across the lines of a light.
#[derive(Clone, Copy, Debug)]
pub(super) enum LightLines {
    /// A plane across the sun's light, in scene units.
    Sun {
        /// The way the light travels.
        travel: DVec3,
        /// The axes of the plane.
        axes: [DVec3; 2],
        /// Where the lines begin: no part of the scene lies before it along `travel`.
        begin: f64,
    },
    /// The faces of a cube around a lamp, each from −1 to 1 (and a little beyond).
    Lamp {
        /// Where the lamp is.
        position: DVec3,
    },
}

/// Where on the raster a point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// The face of the cube: the axis along which it lies, and 3 more on its negative side; 0 for the sun.
    pub face: u8,
    pub at: DVec2,
    /// Scene units by unit of the raster.
    pub scale: f64,
}

impl LightLines {
    /// Those of a light, in a scene of these bounds; `None` of a sun that shines nowhere.
    pub fn new(light: &Light, scene: &Scene) -> Option<Self> {
        match *light {
            Light::Directional { direction, .. } => {
                let travel = direction.as_dvec3().try_normalize()?;
                let (a, b) = travel.any_orthonormal_pair();
                let [lo, hi] = scene.bounds().unwrap_or_default();
                let (centre, size) = (0.5 * (lo + hi).as_dvec3(), (hi - lo).as_dvec3());
                let begin = centre.dot(travel) - 0.5 * size.length();
                Some(Self::Sun { travel, axes: [a, b], begin })
            }
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                Some(Self::Lamp { position: position.as_dvec3() })
            }
        }
    }

    /// Where a point is.
    pub fn place(&self, point: DVec3) -> Place {
        match *self {
            Self::Sun { axes: [a, b], .. } => {
                Place { face: 0, at: DVec2::new(point.dot(a), point.dot(b)), scale: 1.0 }
            }
            Self::Lamp { position } => {
                let to = point - position;
                let axis = to.abs().max_position();
                let scale = to[axis].abs().max(f64::MIN_POSITIVE);
                let at = DVec2::new(to[(axis + 1) % 3], to[(axis + 2) % 3]) / scale;
                Place { face: axis as u8 + 3 * u8::from(to[axis] < 0.0), at, scale }
            }
        }
    }

    /// The line through a place, from the light on.
    pub fn line(&self, face: u8, at: DVec2) -> Ray {
        match *self {
            Self::Sun { travel, axes: [a, b], begin } => {
                Ray { origin: at.x * a + at.y * b + begin * travel, direction: travel }
            }
            Self::Lamp { position } => {
                let mut direction = DVec3::ZERO;
                let axis = usize::from(face % 3);
                direction[axis] = if face < 3 { 1.0 } else { -1.0 };
                direction[(axis + 1) % 3] = at.x;
                direction[(axis + 2) % 3] = at.y;
                Ray { origin: position, direction: direction.normalize() }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pelage_geom::{Face, MaterialId, Mesh};
    use proptest::prelude::*;

    use super::*;
    use crate::{Description, Environment};

    fn vector(size: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
    }

    fn scene() -> Scene {
        let corners = [[-3.0, -3.0, -3.0], [3.0, 3.0, 3.0], [3.0, -3.0, 0.0]].map(Vec3::from_array);
        let face = Face::triangle([0, 1, 2], MaterialId::default());
        let mesh = Mesh { positions: corners.to_vec(), faces: vec![face], ..Mesh::default() };
        Scene::new(Description {
            meshes: vec![mesh],
            coats: vec![],
            materials: vec![],
            textures: vec![],
            lights: vec![],
            environment: Environment::BLACK,
        })
        .expect("a sound scene")
    }

    proptest! {
        #[test]
        fn a_point_lies_on_the_line_of_its_place(point in vector(3.0), light in vector(4.0)) {
            prop_assume!(light.length() > 0.1 && (point - light).length() > 0.1);
            let scene = scene();
            let sun = Light::Directional { direction: light.as_vec3(), illuminance: Vec3::ONE, angle: 0.0 };
            let lamp = Light::Point { position: light.as_vec3(), intensity: Vec3::ONE, radius: 0.0 };
            for light in [sun, lamp] {
                let lines = LightLines::new(&light, &scene).expect("it shines");
                let Place { face, at, scale } = lines.place(point);
                let line = lines.line(face, at);
                let along = (point - line.origin).dot(line.direction);
                prop_assert!(along > 0.0, "the line begins before all of the scene");
                prop_assert!((line.at(along) - point).length() < 1e-5);
                // A step on the raster is `scale` times as wide there, or less where the raster is seen aslant.
                let beside = lines.line(face, at + DVec2::new(1e-3, 0.0));
                let apart = (beside.at((point - beside.origin).dot(beside.direction)) - point).length();
                prop_assert!(apart < 1.001e-3 * scale && apart > 0.5e-3 * scale, "{apart} {scale}");
            }
        }
    }
}
