//! One unit vector a vertex, from all the faces around it, whatever their texture coordinates: the direction in
//! which the skin grows there.
//!
//! Faces count by their angle at the vertex, so that the vector does not depend on how a surface is cut into
//! faces. [ThürmerWüthrich98] At a sharp or crowded corner that mean can lie behind one of the faces, whose box
//! would be folded at any height; there the direction is taken that the faces see best. [AubryLöhner08]

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use pelage_geom::Face;
use rayon::prelude::*;

use crate::Patch;
use crate::polygon::Polygon;

/// Normals cancel where their weighted sum is shorter than this fraction of the sum of the weights.
const CANCELLED: f64 = 1e-6;

/// The mean is replaced where its cosine with one of the normals is below this.
const HARDLY_SEEN: f64 = 0.1;

/// Steps towards the centre of the smallest cap that holds the normals; the error falls as one over their
/// number. [BadoiuClarkson03]
const CAP_STEPS: usize = 256;

/// The vectors of a surface.
pub(crate) struct Vectors {
    /// Unit length by vertex; zero for a vertex without faces.
    pub unit: Vec<Vec3>,
    /// Whose normals cancel; each follows its first face.
    pub cancelled: Vec<u32>,
    /// Which were turned from the mean.
    pub turned: Vec<u32>,
}

/// A face's normal at one of its vertices, and its angle there.
#[derive(Clone, Copy)]
struct Corner {
    vertex: u32,
    normal: DVec3,
    angle: f64,
}

/// Computes the vectors at `positions`, from patches and from the faces that get none but count too.
pub(crate) fn vectors(positions: &[Vec3], patches: &[Patch], bystanders: &[Polygon]) -> Vectors {
    let of_patches = patches.par_iter().flat_map_iter(|patch| corners(patch.outline(), positions));
    let of_bystanders = bystanders.par_iter().flat_map_iter(|polygon| corners(polygon.vertices, positions));
    // In the order of the faces: sums come out the same for any number of threads.
    let all: Vec<Corner> = of_patches.chain(of_bystanders).collect();

    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for c in &all {
        let (sum, weight) = &mut sums[c.vertex as usize];
        *sum += c.angle * c.normal;
        *weight += c.angle;
    }
    let mut result = Vectors { unit: Vec::new(), cancelled: Vec::new(), turned: Vec::new() };
    let mut unit: Vec<DVec3> = sums.par_iter().map(|(sum, _)| sum.normalize_or_zero()).collect();
    let mut hardly_seen: HashMap<u32, Vec<DVec3>> = HashMap::new();
    for (i, (sum, weight)) in sums.iter().enumerate() {
        if *weight > 0.0 && sum.length() <= CANCELLED * weight {
            result.cancelled.push(i as u32);
            unit[i] = DVec3::ZERO;
        }
    }
    for c in &all {
        let direction = &mut unit[c.vertex as usize];
        if *direction == DVec3::ZERO {
            *direction = c.normal;
        }
        if direction.dot(c.normal) < HARDLY_SEEN {
            hardly_seen.entry(c.vertex).or_default();
        }
    }
    for c in if hardly_seen.is_empty() { &[][..] } else { &all } {
        if let Some(normals) = hardly_seen.get_mut(&c.vertex) {
            normals.push(c.normal);
        }
    }
    for (vertex, normals) in hardly_seen {
        let least = |n: DVec3| normals.iter().map(|m| n.dot(*m)).fold(f64::INFINITY, f64::min);
        let best = best_seen(&normals);
        if least(best) > least(unit[vertex as usize]).max(0.0) {
            unit[vertex as usize] = best;
            result.turned.push(vertex);
        }
    }
    result.turned.sort_unstable();
    result.unit = unit.into_iter().map(|n| n.as_vec3()).collect();
    result
}

/// The corners of one face, given counter-clockwise; those without an angle have no normal and are dropped.
fn corners(outline: [u32; 4], positions: &[Vec3]) -> impl Iterator<Item = Corner> + use<> {
    let n = if outline[3] == Face::NONE { 3 } else { 4 };
    let p = |i: usize| positions[outline[i % n] as usize].as_dvec3();
    let mut found = [None; 4];
    for i in 0..n {
        let (after, before) = (p(i + 1) - p(i), p(i + n - 1) - p(i));
        let cross = after.cross(before);
        let normal = cross.normalize_or_zero();
        if normal != DVec3::ZERO {
            found[i] =
                Some(Corner { vertex: outline[i], normal, angle: cross.length().atan2(after.dot(before)) });
        }
    }
    found.into_iter().flatten()
}

/// The direction whose least cosine with `normals` is greatest: the centre of their smallest enclosing cap.
fn best_seen(normals: &[DVec3]) -> DVec3 {
    let mut centre = normals.iter().sum::<DVec3>() / normals.len() as f64;
    for step in 1..=CAP_STEPS {
        let far = |n: &DVec3| centre.distance_squared(*n);
        let Some(farthest) = normals.iter().max_by(|a, b| far(a).total_cmp(&far(b))) else { break };
        centre += (*farthest - centre) / (step + 1) as f64;
    }
    centre.normalize_or_zero()
}
