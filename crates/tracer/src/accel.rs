//! The bounding volume hierarchies: the one file that knows obvhs. [`Accel`] answers rays one by one; [`Tree`] is
//! walked from outside.

use std::ops::Range;
use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{builder::build_bvh2, node::Bvh2Node};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray as BvhRay, RayHit};
use pelage_geom::Ray;
use rayon::prelude::*;

use crate::hash::Drawn;

/// obvhs lets a ray meet nothing nearer to its origin than .0001 scene units: it starts that much before, and more.
const RUN_UP: f64 = 2e-4;

/// Finds the primitives whose bounds a ray may meet.
pub(crate) struct Accel {
    bvh: CwBvh,
    members: Members,
    /// The largest coordinate in magnitude, in scene units: what the rounding of a ray to `f32` scales with.
    extent: f64,
}

impl Accel {
    /// Builds the tree over finite bounds.
    pub(crate) fn new(bounds: Vec<[Vec3; 2]>) -> Self {
        let Leaves { bounds: leaves, leaf_of, extent } = Leaves::new(&bounds);
        drop(bounds);
        // One a leaf: to ask a box whose own bounds the ray does not meet costs more than a leaf.
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        let mut bvh = match leaves.as_slice() {
            [] => CwBvh::default(),
            leaves => build_cwbvh(leaves, params, &mut Duration::default()),
        };
        let members = Members::new(&leaf_of, std::mem::take(&mut bvh.primitive_indices));
        Self { bvh, members, extent: f64::from(extent) }
    }

    /// Calls `visit` for every primitive whose bounds the ray may meet before `t_max`, in no particular order.
    pub(crate) fn candidates(&self, ray: &Ray, t_max: f64, mut visit: impl FnMut(u32)) {
        if let Some((ray, _)) = self.bvh_ray(ray, t_max) {
            self.bvh.ray_traverse_anyhit(ray, |_, leaf| {
                for &primitive in self.members.of(leaf..leaf + 1) {
                    visit(primitive);
                }
            });
        }
    }

    /// The closest hit: `intersect` gives the distance at which the ray meets a primitive, if it does so before
    /// the distance it is given. Returns that distance and the primitive; of equal ones, the primitive of the
    /// smallest index.
    pub(crate) fn closest(
        &self,
        ray: &Ray,
        t_max: f64,
        mut intersect: impl FnMut(u32, f64) -> Option<f64>,
    ) -> Option<(f64, u32)> {
        let (bvh_ray, start) = self.bvh_ray(ray, t_max)?;
        let mut closest: Option<(f64, u32)> = None;
        self.bvh.ray_traverse(bvh_ray, &mut RayHit::none(), |bvh_ray, leaf| {
            let mut end = bvh_ray.tmax;
            for &primitive in self.members.of(leaf..leaf + 1) {
                let limit = closest.map_or(t_max, |(t, _)| t);
                // Equal distances are let through, so that the order of the tree decides nothing.
                if let Some(t) = intersect(primitive, limit.next_up().min(t_max))
                    && closest.is_none_or(|(best, i)| t < best || (t == best && primitive < i))
                {
                    closest = Some((t, primitive));
                    end = (((t - start) * (1.0 + 1e-6)) as f32).next_up();
                }
            }
            end
        });
        closest
    }

    /// Whether anything is in the way before `t_max`.
    pub(crate) fn any(
        &self,
        ray: &Ray,
        t_max: f64,
        mut intersect: impl FnMut(u32, f64) -> Option<f64>,
    ) -> bool {
        let Some((bvh_ray, _)) = self.bvh_ray(ray, t_max) else { return false };
        !self.bvh.ray_traverse_miss(bvh_ray, |bvh_ray, leaf| {
            let hit = self
                .members
                .of(leaf..leaf + 1)
                .iter()
                .any(|&primitive| intersect(primitive, t_max).is_some());
            if hit { -1.0 } else { bvh_ray.tmax }
        })
    }

    /// The ray in the tree's precision, started close to the tree: far away, an `f32` origin would miss by more
    /// than the margin. Also returns how far the origin has moved. `None` where the ray cannot meet the tree.
    fn bvh_ray(&self, ray: &Ray, t_max: f64) -> Option<(BvhRay, f64)> {
        if self.bvh.nodes.is_empty() {
            return None;
        }
        let start = (ray.origin.length() - 2.0 * self.extent).clamp(0.0, t_max.max(0.0)) - RUN_UP;
        let origin = ray.at(start).as_vec3a();
        // Adding 0 makes −0 of it 0: obvhs takes the signs of −0 and of its inverse for different ones.
        let direction = ray.direction.as_vec3a() + Vec3A::ZERO;
        if !(origin.is_finite() && direction.is_finite()) {
            return None;
        }
        let end = ((t_max - start) * (1.0 + 1e-6)) as f32;
        (end >= 0.0).then(|| (BvhRay::new(origin, direction, 0.0, end.next_up()), start))
    }
}

/// A binary tree over bounds, for those who walk it themselves.
pub(crate) struct Tree {
    /// The root first; none for a tree over nothing.
    pub nodes: Vec<Node>,
    members: Members,
}

/// A node of a [`Tree`].
pub(crate) struct Node {
    /// The smallest and largest coordinates below it, a few units in the last place apart from what they bound.
    pub bounds: [Vec3A; 2],
    /// Of a leaf its first place among the tree's leaves, and how many it takes; of an inner node its first child,
    /// the second following it, and 0.
    first: u32,
    count: u32,
}

impl Tree {
    /// Builds the tree over finite bounds.
    pub(crate) fn new(bounds: &[[Vec3; 2]]) -> Self {
        let Leaves { bounds: leaves, leaf_of, .. } = Leaves::new(bounds);
        if leaves.is_empty() {
            return Self { nodes: vec![], members: Members::new(&[], vec![]) };
        }
        let bvh = build_bvh2(&leaves, BvhBuildParams::medium_build(), &mut Duration::default());
        let node = |n: &Bvh2Node| Node {
            bounds: [n.aabb.min, n.aabb.max],
            first: n.first_index,
            count: n.prim_count,
        };
        let nodes = bvh.nodes.iter().map(node).collect();
        Self { nodes, members: Members::new(&leaf_of, bvh.primitive_indices) }
    }

    /// The two nodes below a node, if it is not a leaf.
    pub(crate) fn children(&self, node: &Node) -> Option<[u32; 2]> {
        (node.count == 0).then_some([node.first, node.first + 1])
    }

    /// The primitives of a leaf.
    pub(crate) fn members_of(&self, node: &Node) -> &[u32] {
        self.members.of(node.first as usize..(node.first + node.count) as usize)
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + self.members.memory()
    }
}

/// What a tree is built over: primitives with the same bounds share a leaf, because the builder's time is quadratic
/// in coincident ones.
struct Leaves {
    bounds: Vec<Aabb>,
    /// By primitive.
    leaf_of: Vec<u32>,
    /// The largest coordinate in magnitude.
    extent: f32,
}

impl Leaves {
    fn new(bounds: &[[Vec3; 2]]) -> Self {
        let first = first_alike(bounds);
        // A few units in the last place around each box make up for the rounding of the ray to `f32`.
        let extent = bounds.par_iter().map(|[lo, hi]| lo.abs().max(hi.abs()).max_element());
        let extent = extent.reduce(|| 0.0, f32::max);
        let margin = Vec3A::splat(8.0 * f32::EPSILON * extent);
        let mut leaves = Vec::with_capacity(bounds.len());
        let mut leaf_of: Vec<u32> = Vec::with_capacity(bounds.len());
        for (i, (&[lo, hi], &first)) in bounds.iter().zip(&first).enumerate() {
            if first as usize == i {
                leaf_of.push(leaves.len() as u32);
                leaves.push(Aabb::new(Vec3A::from(lo) - margin, Vec3A::from(hi) + margin));
            } else {
                leaf_of.push(leaf_of[first as usize]);
            }
        }
        Self { bounds: leaves, leaf_of, extent }
    }
}

/// By primitive the first one with the same bounds.
fn first_alike(bounds: &[[Vec3; 2]]) -> Vec<u32> {
    let hash = |[lo, hi]: &[Vec3; 2]| {
        let word = |x: f32, y: f32| u64::from(x.to_bits()) << 32 | u64::from(y.to_bits());
        Drawn::from([word(lo.x, lo.y), word(lo.z, hi.x), word(hi.y, hi.z)]).bits()
    };
    let mut hashed: Vec<(u64, u32)> =
        bounds.par_iter().enumerate().map(|(i, bounds)| (hash(bounds), i as u32)).collect();
    hashed.par_sort_unstable();
    let mut first: Vec<u32> = (0..bounds.len() as u32).collect();
    for (&(one, i), &(other, j)) in hashed.iter().zip(hashed.iter().skip(1)) {
        if one == other && bounds[i as usize] == bounds[j as usize] {
            first[j as usize] = first[i as usize];
        }
    }
    first
}

/// Primitives in the order of the tree's leaves, so that its own indices lead straight to them.
struct Members {
    /// Leaf `i` of the tree holds `list[first[i]..first[i + 1]]`; empty where each leaf holds one.
    first: Vec<u32>,
    list: Vec<u32>,
}

impl Members {
    /// `leaf_of` tells by primitive which leaf it was given to the builder with, `order` in which order the builder has
    /// put those.
    fn new(leaf_of: &[u32], order: Vec<u32>) -> Self {
        if order.len() == leaf_of.len() {
            return Self { first: vec![], list: order };
        }
        let mut place = vec![0_u32; order.len()];
        for (position, &i) in order.iter().enumerate() {
            place[i as usize] = position as u32;
        }
        let mut first = vec![0_u32; order.len() + 1];
        for &l in leaf_of {
            first[place[l as usize] as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut list = vec![0_u32; leaf_of.len()];
        for (primitive, &l) in leaf_of.iter().enumerate() {
            let slot = &mut next[place[l as usize] as usize];
            list[*slot as usize] = primitive as u32;
            *slot += 1;
        }
        Self { first, list }
    }

    /// The primitives in some leaves.
    #[inline]
    fn of(&self, leaves: Range<usize>) -> &[u32] {
        if self.first.is_empty() {
            &self.list[leaves]
        } else {
            &self.list[self.first[leaves.start] as usize..self.first[leaves.end] as usize]
        }
    }

    /// Bytes held.
    fn memory(&self) -> usize {
        size_of_val(self.first.as_slice()) + size_of_val(self.list.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn unit_box(at: Vec3) -> [Vec3; 2] {
        [at, at + Vec3::ONE]
    }

    fn visited(accel: &Accel, origin: DVec3, direction: DVec3, t_max: f64) -> Vec<u32> {
        let mut found = vec![];
        accel.candidates(&Ray { origin, direction: direction.normalize() }, t_max, |i| found.push(i));
        found.sort_unstable();
        found
    }

    #[test]
    fn nothing_one_and_all_the_same() {
        let x = DVec3::X;
        let from = DVec3::new(-5.0, 0.5, 0.5);
        assert!(visited(&Accel::new(vec![]), from, x, f64::INFINITY).is_empty());
        let one = Accel::new(vec![unit_box(Vec3::ZERO)]);
        assert_eq!(visited(&one, from, x, f64::INFINITY), [0]);
        assert!(visited(&one, from, x, 4.0).is_empty());
        assert!(visited(&one, from, -x, f64::INFINITY).is_empty());
        let same = Accel::new(vec![unit_box(Vec3::ZERO); 20_000]);
        assert_eq!(visited(&same, from, x, f64::INFINITY).len(), 20_000);
    }

    #[test]
    fn what_ends_close_to_the_start_of_a_ray_is_found() {
        let one = Accel::new(vec![unit_box(Vec3::ZERO)]);
        assert_eq!(visited(&one, DVec3::new(1.0 - 1e-5, 0.5, 0.5), DVec3::X, f64::INFINITY), [0]);
        // And what is so small that all of it is close.
        let small = Accel::new(vec![[Vec3::ZERO, Vec3::splat(1e-6)]]);
        assert_eq!(visited(&small, DVec3::new(-1e-6, 5e-7, 5e-7), DVec3::X, 1e-5), [0]);
    }

    #[test]
    fn agrees_with_brute_force_near_and_far() {
        // A 20 × 20 sheet of unit boxes, apart by 1.5, seen by rays from near and from very far.
        let bounds: Vec<_> = (0..400)
            .map(|i| unit_box(Vec3::new((i % 20) as f32 * 1.5, 0.0, (i / 20) as f32 * 1.5)))
            .collect();
        let accel = Accel::new(bounds.clone());
        for i in 0..2000_u32 {
            let a = f64::from(i) * 2.399_963;
            let target = DVec3::new(15.0 + 14.0 * a.cos(), 0.5, 15.0 + 14.0 * (1.7 * a).sin());
            let away = DVec3::new(a.sin(), 0.2 + (0.3 * a).cos().abs(), a.cos()).normalize();
            let distance = if i % 2 == 0 { 30.0 } else { 1e6 };
            let found = visited(&accel, target + distance * away, -away, f64::INFINITY);
            for (j, &[lo, hi]) in bounds.iter().enumerate() {
                let inside = |t: f64| {
                    let p = target - t * away;
                    p.cmpge(lo.as_dvec3()).all() && p.cmple(hi.as_dvec3()).all()
                };
                // Any sample of the ray inside a box proves that it had to be visited.
                if (-400..400).any(|k| inside(f64::from(k) * 0.05)) {
                    assert!(found.contains(&(j as u32)), "ray {i} lost box {j}");
                }
            }
        }
    }

    #[test]
    fn every_primitive_is_in_one_leaf_below_bounds_that_hold_it() {
        // Some of them coincide, and share a leaf.
        let bounds: Vec<_> =
            (0..500).map(|i| unit_box(Vec3::splat((i % 400) as f32) * Vec3::new(0.7, 0.1, 0.3))).collect();
        let tree = Tree::new(&bounds);
        let mut found = vec![];
        let mut open = vec![(0_u32, [Vec3A::NEG_INFINITY, Vec3A::INFINITY])];
        while let Some((node, [lo, hi])) = open.pop() {
            let node = &tree.nodes[node as usize];
            assert!(node.bounds[0].cmpge(lo).all() && node.bounds[1].cmple(hi).all());
            match tree.children(node) {
                Some(children) => open.extend(children.map(|child| (child, node.bounds))),
                None => found.extend(tree.members_of(node).iter().map(|&i| (i, node.bounds))),
            }
        }
        found.sort_unstable_by_key(|(i, _)| *i);
        assert_eq!(found.len(), bounds.len());
        for (expected, (i, [lo, hi])) in found.into_iter().enumerate() {
            assert_eq!(i as usize, expected);
            let [a, b] = bounds[expected].map(Vec3A::from);
            assert!(a.cmpge(lo).all() && b.cmple(hi).all());
        }
        assert!(Tree::new(&[]).nodes.is_empty());
    }
}
