//! Quads over the zero of a signed distance: surface nets [Gibson98], then drawn tight.

use std::collections::HashMap;

use glam::{IVec3, Vec3, ivec3};

/// A closed surface of quads, counter-clockwise seen from outside.
pub struct Net {
    pub positions: Vec<Vec3>,
    pub quads: Vec<[usize; 4]>,
}

/// How often vertices move towards the middle of their neighbours and back onto the surface.
const TIGHTENING: usize = 12;

impl Net {
    /// The surface where `distance` (metres, negative inside) is zero, between two corners, in quads about `size` wide.
    pub fn new([lo, hi]: [Vec3; 2], size: f32, distance: &dyn Fn(Vec3) -> f32) -> Self {
        let cells = ((hi - lo) / size).ceil().as_ivec3();
        let at = |i: IVec3| lo + size * i.as_vec3();
        let mut inside = HashMap::new();
        for z in 0..=cells.z {
            for y in 0..=cells.y {
                for x in 0..=cells.x {
                    inside.insert(ivec3(x, y, z), distance(at(ivec3(x, y, z))) < 0.0);
                }
            }
        }
        let is_inside = |i: IVec3| inside.get(&i) == Some(&true);
        let mut net = Self { positions: Vec::new(), quads: Vec::new() };
        let mut number = HashMap::new();
        // Around each edge of the grid that crosses the surface, its four cells are a quad.
        for z in 1..cells.z {
            for y in 1..cells.y {
                for x in 1..cells.x {
                    for axis in 0..3 {
                        let from = ivec3(x, y, z);
                        let mut step = IVec3::ZERO;
                        step[axis] = 1;
                        if is_inside(from) == is_inside(from + step) {
                            continue;
                        }
                        let (mut u, mut v) = (IVec3::ZERO, IVec3::ZERO);
                        u[(axis + 1) % 3] = 1;
                        v[(axis + 2) % 3] = 1;
                        let mut around = [from - u - v, from - v, from, from - u];
                        if !is_inside(from) {
                            around.reverse();
                        }
                        net.quads.push(around.map(|cell| {
                            *number.entry(cell).or_insert_with(|| {
                                net.positions.push(at(cell) + 0.5 * size);
                                net.positions.len() - 1
                            })
                        }));
                    }
                }
            }
        }
        net.tighten(distance, size);
        net
    }

    fn tighten(&mut self, distance: &dyn Fn(Vec3) -> f32, size: f32) {
        let onto = |p: Vec3| {
            let h = 0.05 * size;
            let slope = |axis: Vec3| distance(p + h * axis) - distance(p - h * axis);
            let normal = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or_zero();
            p - distance(p).clamp(-0.5 * size, 0.5 * size) * normal
        };
        for _ in 0..TIGHTENING {
            let mut sums = vec![(Vec3::ZERO, 0.0); self.positions.len()];
            for quad in &self.quads {
                for k in 0..4 {
                    let (sum, count) = &mut sums[quad[k]];
                    *sum += self.positions[quad[(k + 1) % 4]] + self.positions[quad[(k + 3) % 4]];
                    *count += 2.0;
                }
            }
            for (p, (sum, count)) in self.positions.iter_mut().zip(sums) {
                *p = onto(onto(p.lerp(sum / count, 0.6)));
            }
        }
    }

    pub fn centre(&self, quad: &[usize; 4]) -> Vec3 {
        quad.iter().map(|&v| self.positions[v]).sum::<Vec3>() / 4.0
    }

    /// The unit normal of a quad.
    pub fn normal(&self, [a, b, c, d]: &[usize; 4]) -> Vec3 {
        let p = &self.positions;
        (p[*c] - p[*a]).cross(p[*d] - p[*b]).normalize_or_zero()
    }
}
