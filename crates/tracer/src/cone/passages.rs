//! Which boxes a ray goes through, and from where to where. [seed §4.1]

use glam::DVec3;
use pelage_geom::{Passage, Ray, RayFrame};

use crate::Scene;

/// A ray inside one box, from one wall to another (or to where the ray starts or ends).
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxPassage {
    /// The box, among all of the scene.
    pub patch: u32,
    /// Distances, in scene units.
    pub t: [f64; 2],
    /// Box coordinates.
    pub u: [DVec3; 2],
}

/// Collects the passages of `ray` through all boxes between `t_min` and `t_max`, in order of entry.
pub(crate) fn collect(scene: &Scene, ray: &Ray, t_min: f64, t_max: f64, out: &mut Vec<BoxPassage>) {
    out.clear();
    let frame = RayFrame::new(ray);
    scene.boxes.candidates(ray, t_max, |patch| {
        scene.hexahedron(patch).passages_in(&frame, t_min, t_max, |Passage { t, u }| {
            out.push(BoxPassage { patch, t, u });
        });
    });
    // The tree visits in an order of its own; the box's number decides between equal entries.
    out.sort_unstable_by(|a, b| a.t[0].total_cmp(&b.t[0]).then(a.patch.cmp(&b.patch)));
}
