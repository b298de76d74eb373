//! A connected piece of a surface, and the seams that it is cut open along.

use std::collections::HashMap;

use glam::DVec3;

use crate::disjoint::DisjointSets;
use crate::polygon::{Polygon, Surface};
use crate::quad;

/// No half-edge, or no corner.
pub(super) const NONE: u32 = u32::MAX;

/// Polygons that are connected through edges. The corner `k` of polygon `p`, and the half-edge from there to the next
/// corner, is number 4p + k.
pub(super) struct Sheet {
    /// Which polygons of the surface these are.
    pub polygons: Vec<u32>,
    /// By half-edge its vertex; [`NONE`] for the fourth of a triangle.
    pub vertices: Vec<u32>,
    /// By vertex.
    pub positions: Vec<DVec3>,
    /// By polygon.
    pub normals: Vec<DVec3>,
    /// By half-edge the one that runs the other way in the polygon beyond; [`NONE`] at a border.
    pub twin: Vec<u32>,
    /// By half-edge whether the sheet is cut along it; twins agree.
    pub cut: Vec<bool>,
}

/// The sheet cut open: vertices on a cut are several.
pub(super) struct Opened {
    /// By corner of the sheet its vertex here; [`NONE`] for the fourth of a triangle.
    pub vertices: Vec<u32>,
    /// By vertex a corner of the sheet that is there.
    pub corners: Vec<u32>,
    /// Vertices − edges + faces: 1 for a disk.
    pub characteristic: i64,
}

/// The sheets of a surface, in the order of their first polygons. Edges of more than two polygons, or of two that are
/// turned against each other, are borders.
pub(super) fn sheets(surface: &Surface) -> Vec<Sheet> {
    let twin = twins(&surface.polygons);
    let mut sheet_of = vec![NONE; surface.polygons.len()];
    let mut sheets: Vec<Vec<u32>> = Vec::new();
    for first in 0..surface.polygons.len() {
        if sheet_of[first] != NONE {
            continue;
        }
        let number = sheets.len() as u32;
        let mut polygons = vec![first as u32];
        sheet_of[first] = number;
        let mut next = 0;
        while let Some(&p) = polygons.get(next) {
            next += 1;
            for &beyond in twin[4 * p as usize..][..4].iter().filter(|&&t| t != NONE) {
                let q = beyond / 4;
                if sheet_of[q as usize] == NONE {
                    sheet_of[q as usize] = number;
                    polygons.push(q);
                }
            }
        }
        polygons.sort_unstable();
        sheets.push(polygons);
    }
    let mut local = vec![NONE; surface.polygons.len()];
    for polygons in &sheets {
        for (i, &p) in polygons.iter().enumerate() {
            local[p as usize] = i as u32;
        }
    }
    sheets.into_iter().map(|polygons| Sheet::new(surface, polygons, &twin, &local)).collect()
}

/// By half-edge of all polygons its twin.
fn twins(polygons: &[Polygon]) -> Vec<u32> {
    let mut edges = Vec::with_capacity(4 * polygons.len());
    for (p, polygon) in polygons.iter().enumerate() {
        let (corners, n) = (polygon.corners(), polygon.corners().len());
        for k in 0..n {
            let (a, b) = (corners[k], corners[(k + 1) % n]);
            edges.push((a.min(b), a.max(b), a > b, (4 * p + k) as u32));
        }
    }
    edges.sort_unstable();
    let mut twin = vec![NONE; 4 * polygons.len()];
    for faces in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [a, b] = faces
            && a.2 != b.2
        {
            (twin[a.3 as usize], twin[b.3 as usize]) = (b.3, a.3);
        }
    }
    twin
}

impl Sheet {
    fn new(surface: &Surface, polygons: Vec<u32>, twin: &[u32], local: &[u32]) -> Self {
        let mut number = HashMap::new();
        let mut sheet = Self {
            vertices: Vec::with_capacity(4 * polygons.len()),
            positions: Vec::new(),
            normals: Vec::with_capacity(polygons.len()),
            twin: Vec::with_capacity(4 * polygons.len()),
            cut: vec![false; 4 * polygons.len()],
            polygons,
        };
        for &p in &sheet.polygons {
            let polygon = &surface.polygons[p as usize];
            sheet.normals.push(polygon.area_vector(&surface.positions).normalize_or_zero());
            for k in 0..4 {
                let vertex = polygon.vertices[k];
                sheet.vertices.push(if vertex == NONE {
                    NONE
                } else {
                    *number.entry(vertex).or_insert_with(|| {
                        sheet.positions.push(surface.positions[vertex as usize].as_dvec3());
                        sheet.positions.len() as u32 - 1
                    })
                });
                let beyond = twin[4 * p as usize + k];
                sheet.twin.push(if beyond == NONE {
                    NONE
                } else {
                    4 * local[beyond as usize / 4] + beyond % 4
                });
            }
        }
        sheet
    }

    /// All half-edges.
    pub fn half_edges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.vertices.len()).filter(|&h| self.vertices[h] != NONE)
    }

    /// The next half-edge around the same polygon.
    pub fn next(&self, h: usize) -> usize {
        let (first, k) = (h & !3, h & 3);
        let n = if self.vertices[first + 3] == NONE { 3 } else { 4 };
        first + (k + 1) % n
    }

    /// The vertices at its two ends.
    pub fn ends(&self, h: usize) -> [usize; 2] {
        [h, self.next(h)].map(|h| self.vertices[h] as usize)
    }

    /// Whether the sheet ends there, by itself or because it is cut.
    pub fn is_open(&self, h: usize) -> bool {
        self.twin[h] == NONE || self.cut[h]
    }

    /// Cuts along a half-edge and its twin.
    pub fn cut_along(&mut self, h: usize) {
        self.cut[h] = true;
        if self.twin[h] != NONE {
            self.cut[self.twin[h] as usize] = true;
        }
    }

    /// The triangles that its polygons are made of, by corner, and the polygon of each.
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(2 * self.polygons.len());
        for first in (0..self.vertices.len()).step_by(4) {
            if self.vertices[first + 3] == NONE {
                triangles.push([first, first + 1, first + 2]);
            } else {
                let points = [0, 1, 2, 3].map(|k| self.positions[self.vertices[first + k] as usize]);
                triangles.extend(quad::halves(points).map(|pick| pick.map(|k| first + k)));
            }
        }
        triangles
    }

    /// The sheet as it is cut: corners are one vertex where they meet over edges that are whole.
    pub fn opened(&self) -> Opened {
        let mut sets = DisjointSets::new(self.vertices.len());
        let (mut edges, mut faces) = (0_i64, 0_i64);
        for h in self.half_edges() {
            faces += i64::from(h & 3 == 0);
            let twin = self.twin[h] as usize;
            if self.is_open(h) {
                edges += 1;
            } else if h < twin {
                edges += 1;
                for (a, b) in [(h, self.next(twin)), (self.next(h), twin)] {
                    sets.join(a as u32, b as u32);
                }
            }
        }
        let mut opened =
            Opened { vertices: vec![NONE; self.vertices.len()], corners: Vec::new(), characteristic: 0 };
        for h in self.half_edges() {
            let first = sets.root(h as u32) as usize;
            if first == h {
                opened.vertices[h] = opened.corners.len() as u32;
                opened.corners.push(h as u32);
            } else {
                // The root is the smallest of its class, so it has its number already.
                opened.vertices[h] = opened.vertices[first];
            }
        }
        opened.characteristic = opened.corners.len() as i64 - edges + faces;
        opened
    }
}
