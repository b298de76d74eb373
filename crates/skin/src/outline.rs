//! The edges of a skin's boxes, with how far each corner is from folding: for looking at.

use glam::{DVec3, Vec3};

use crate::Skin;
use crate::patch::map;

/// Points and the lines between them. Each vertex of the skin is two points: where its boxes stand, and, behind all of
/// those, where they reach; the line between the two is its vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Metres.
    pub points: Vec<Vec3>,
    /// By point the least det J of the boxes that have it for a corner, in cubic metres per box; 0 without a box.
    pub determinants: Vec<f32>,
    /// By point the least scaled Jacobian of those boxes: det J over the lengths of its columns, 1 for a right-angled
    /// corner and not positive for a folded one. \[Knupp00\]
    pub qualities: Vec<f32>,
    /// Pairs of points, each once; the lower index first.
    pub edges: Vec<[u32; 2]>,
}

impl Skin {
    /// The edges of all boxes.
    pub fn outline(&self) -> Outline {
        let count = self.base.len();
        let mut determinants = vec![f64::INFINITY; 2 * count];
        let mut qualities = vec![f64::INFINITY; 2 * count];
        let mut edges = Vec::new();
        for patch in &self.patches {
            let map = map(&patch.vertices, &self.base, &self.top);
            for (k, &v) in patch.corners().iter().enumerate() {
                for w in 0..2 {
                    let jacobian = map.jacobian(DVec3::new((k & 1) as f64, (k >> 1) as f64, w as f64));
                    let determinant = jacobian.determinant();
                    let lengths: f64 = [jacobian.x_axis, jacobian.y_axis, jacobian.z_axis]
                        .map(DVec3::length)
                        .iter()
                        .product();
                    let point = v as usize + w * count;
                    determinants[point] = determinants[point].min(determinant);
                    let quality = if lengths > 0.0 { determinant / lengths } else { 0.0 };
                    qualities[point] = qualities[point].min(quality);
                }
            }
            let (outline, n) = (patch.outline(), patch.corners().len());
            for k in 0..n {
                let (a, b) = (outline[k], outline[(k + 1) % n]);
                let top = count as u32;
                edges.extend([[a.min(b), a.max(b)], [a.min(b) + top, a.max(b) + top], [a, a + top]]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let told =
            |list: Vec<f64>| list.into_iter().map(|x| if x.is_finite() { x as f32 } else { 0.0 }).collect();
        Outline {
            points: self.base.iter().chain(&self.top).copied().collect(),
            determinants: told(determinants),
            qualities: told(qualities),
            edges,
        }
    }

    /// Bytes that the boxes take: vertices, patches, texture coordinates and attributes.
    pub fn bytes(&self) -> usize {
        let uvs = self.uvs.as_ref().map_or(0, |uvs| size_of_val(uvs.as_slice()));
        let attributes: usize = self.attributes.iter().map(|a| size_of_val(a.values.as_slice())).sum();
        size_of_val(self.base.as_slice())
            + size_of_val(self.top.as_slice())
            + size_of_val(self.patches.as_slice())
            + uvs
            + attributes
    }
}
