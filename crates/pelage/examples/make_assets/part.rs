//! Surfaces of quads, and the OBJ files that hold them.

use std::collections::HashMap;
use std::f32::consts::TAU;
use std::fmt::Write;

use glam::{Mat3, Vec3, vec3};

/// A surface of quads. What wears a skin has no texture coordinates, so that each face is as wide as the texel is laid
/// out for it.
pub struct Part {
    name: &'static str,
    positions: Vec<Vec3>,
    quads: Vec<[usize; 4]>,
    /// Whether it has normals of its own: what is smooth and wears nothing.
    smooth: bool,
}

impl Part {
    fn new(name: &'static str) -> Self {
        Self { name, positions: Vec::new(), quads: Vec::new(), smooth: false }
    }

    pub fn smooth(self) -> Self {
        Self { smooth: true, ..self }
    }

    /// A cube of `n` × `n` faces on each side, its points carried from the unit sphere by `shape`.
    pub fn ball(name: &'static str, n: usize, shape: impl Fn(Vec3) -> Vec3) -> Self {
        let mut part = Self::new(name);
        // Points on an edge of the cube belong to two or three sides: found again by their place on its lattice.
        let mut known: HashMap<[i32; 3], usize> = HashMap::new();
        let side = n as i32;
        for axis in 0..3 {
            for end in [-side, side] {
                let mut point = |i: usize, j: usize| {
                    let mut place = [0; 3];
                    place[axis] = end;
                    place[(axis + 1) % 3] = 2 * i as i32 - side;
                    place[(axis + 2) % 3] = 2 * j as i32 - side;
                    *known.entry(place).or_insert_with(|| {
                        // Equal angles rather than equal steps: faces of like size.
                        let even = place.map(|x| (x as f32 / side as f32 * 0.125 * TAU).tan());
                        part.positions.push(shape(Vec3::from(even).normalize()));
                        part.positions.len() - 1
                    })
                };
                for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                    let mut quad = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                    if end < 0 {
                        quad.reverse();
                    }
                    part.quads.push(quad);
                }
            }
        }
        part
    }

    /// A tube that is closed around (`columns`), and along as well if it is a `ring`: `point` takes the fractions
    /// around and along.
    pub fn tube(
        name: &'static str,
        [columns, rows]: [usize; 2],
        ring: bool,
        point: impl Fn(f32, f32) -> Vec3,
    ) -> Self {
        let mut part = Self::new(name);
        let points = if ring { rows } else { rows + 1 };
        for (i, j) in (0..columns * points).map(|k| (k % columns, k / columns)) {
            part.positions.push(point(i as f32 / columns as f32, j as f32 / rows as f32));
        }
        let at = |i: usize, j: usize| i % columns + columns * (j % points);
        for (i, j) in (0..columns * rows).map(|k| (k % columns, k / columns)) {
            part.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        part
    }

    /// A rectangle: `point` takes the fractions along its sides; it faces up if they go along +X and −Z.
    pub fn sheet(name: &'static str, [columns, rows]: [usize; 2], point: impl Fn(f32, f32) -> Vec3) -> Self {
        let mut part = Self::new(name);
        let width = columns + 1;
        for (i, j) in (0..width * (rows + 1)).map(|k| (k % width, k / width)) {
            part.positions.push(point(i as f32 / columns as f32, j as f32 / rows as f32));
        }
        for (i, j) in (0..columns * rows).map(|k| (k % columns, k / columns)) {
            let a = i + width * j;
            part.quads.push([a, a + 1, a + 1 + width, a + width]);
        }
        part
    }

    fn centre(&self, quad: &[usize; 4]) -> Vec3 {
        quad.iter().map(|&v| self.positions[v]).sum::<Vec3>() / 4.0
    }

    /// Twice the area, across the face.
    fn across(&self, [a, b, c, d]: &[usize; 4]) -> Vec3 {
        (self.positions[*c] - self.positions[*a]).cross(self.positions[*d] - self.positions[*b])
    }

    /// The mean of the faces around each vertex.
    fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for quad in &self.quads {
            let across = self.across(quad);
            quad.iter().for_each(|&v| normals[v] += across);
        }
        normals.into_iter().map(Vec3::normalize_or_zero).collect()
    }
}

/// What lies on a surface, as thick as `thickness` says at a point with a normal: the faces below it, and those that it
/// reaches up to.
pub fn crust(name: &'static str, below: &Part, thickness: impl Fn(Vec3, Vec3) -> f32) -> [Part; 2] {
    let mut base = Part::new(name);
    let mut top = Part::new(name);
    let normals = below.normals();
    let thick: Vec<f32> = below.positions.iter().zip(&normals).map(|(&p, &n)| thickness(p, n)).collect();
    let mut known = HashMap::new();
    for quad in below.quads.iter().filter(|quad| quad.iter().any(|&v| thick[v] > 0.0)) {
        let quad = quad.map(|v| {
            *known.entry(v).or_insert_with(|| {
                base.positions.push(below.positions[v]);
                // Its edge is a low step: a box has some height everywhere.
                top.positions.push(below.positions[v] + normals[v] * thick[v].max(0.004));
                base.positions.len() - 1
            })
        });
        base.quads.push(quad);
        top.quads.push(quad);
    }
    [base, top]
}

/// An OBJ file in the making.
pub struct Obj {
    pub text: String,
    positions: usize,
    normals: usize,
}

impl Obj {
    pub fn new(materials: &str) -> Self {
        let text = format!("# Made by crates/pelage/examples/make_assets\nmtllib {materials}\n");
        Self { text, positions: 0, normals: 0 }
    }

    fn line(&mut self, keyword: &str, v: Vec3) {
        // Adding zero turns −0 into 0.
        let v = (v * 1e4).round() / 1e4 + Vec3::ZERO;
        let _ = writeln!(self.text, "{keyword} {} {} {}", v.x, v.y, v.z);
    }

    /// Adds a part of one material.
    pub fn add(&mut self, part: &Part, material: &str) {
        self.add_by(part, |_, _| material);
    }

    /// Adds a part whose faces have the material of their centre and normal.
    pub fn add_by<'a>(&mut self, part: &Part, material: impl Fn(Vec3, Vec3) -> &'a str) {
        let _ = writeln!(self.text, "o {}", part.name);
        part.positions.iter().for_each(|p| self.line("v", *p));
        if part.smooth {
            part.normals().iter().for_each(|n| self.line("vn", *n));
        }
        let mut faces: Vec<(&str, &[usize; 4])> = part
            .quads
            .iter()
            .map(|quad| (material(part.centre(quad), part.across(quad).normalize_or_zero()), quad))
            .collect();
        faces.sort_by_key(|(material, _)| *material);
        let mut current = "";
        for (material, quad) in faces {
            if material != current {
                let _ = writeln!(self.text, "usemtl {material}");
                current = material;
            }
            self.text.push('f');
            for v in quad {
                let _ = write!(self.text, " {}", self.positions + v + 1);
                if part.smooth {
                    let _ = write!(self.text, "//{}", self.normals + v + 1);
                }
            }
            self.text.push('\n');
        }
        self.positions += part.positions.len();
        if part.smooth {
            self.normals += part.positions.len();
        }
    }
}

/// Smooth bumps: a sum of waves of all directions, about −1 to 1.
pub fn bumps(p: Vec3, scale: f32) -> f32 {
    let waves = [
        vec3(1.0, 0.3, 0.2),
        vec3(-0.4, 1.1, 0.5),
        vec3(0.6, -0.5, 1.2),
        vec3(-1.3, -0.7, 0.4),
        vec3(0.3, 0.8, -1.4),
    ];
    let wave = |(i, w): (usize, &Vec3)| (p.dot(*w) * scale * (1.0 + 0.4 * i as f32) + 1.7 * i as f32).sin();
    waves.iter().enumerate().map(wave).sum::<f32>() * 0.4
}

/// A ball that stands on the ground.
pub fn ellipsoid(name: &'static str, n: usize, at: Vec3, size: Vec3, turn: Mat3) -> Part {
    Part::ball(name, n, move |d| at + turn * (d * size))
}
