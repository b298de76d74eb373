//! Catmull–Clark subdivision of a mesh, with creases and boundaries by the usual rules. \[CatmullClark78\]
//! \[DeRoseKassTruong98\]
//!
//! An edge is sharp where it is on the border, where it has more than two faces, or where its faces meet at more than
//! an angle. A vertex with two sharp edges moves along them as a cubic B-spline does; one with more, or at a corner
//! of the border, stays. After the last step every vertex is moved to where it would go in the limit.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::{Attribute, Face, Mesh};

use super::{Account, Deviation, Surface, Tessellation};
use crate::SkinError;

/// How a mesh is subdivided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subdivision {
    /// How often; each step makes n quads of a face of n corners. From 1 to 10.
    pub levels: u32,
    /// Edges stay sharp where the normals of their faces differ by more than this, in degrees; 180 for none.
    pub crease_angle: f32,
}

impl Default for Subdivision {
    /// Twice, without creases.
    fn default() -> Self {
        Self { levels: 2, crease_angle: 180.0 }
    }
}

/// Steps beyond the last one, against whose limit points the mesh is measured.
const FINER: u32 = 2;

/// Subdivides `mesh`. Texture coordinates and vertex attributes are interpolated linearly, materials inherited;
/// normals are left out, as flat as they were.
///
/// # Errors
/// A mesh or a number out of its domain, or more faces than 32-bit indices can name.
pub fn subdivide(mesh: &Mesh, subdivision: &Subdivision) -> Result<Tessellation, SkinError> {
    mesh.validate()?;
    let &Subdivision { levels, crease_angle } = subdivision;
    let fault = |field, expected| SkinError::Surface { surface: "subdivision", field, expected };
    if !(1..=10).contains(&levels) {
        return Err(fault("levels", "must be from 1 to 10"));
    }
    if !(0.0..=180.0).contains(&crease_angle) {
        return Err(fault("crease_angle", "must be from 0 to 180 degrees"));
    }
    let corners: usize = mesh.faces.iter().map(|f| f.corners().len()).sum();
    let count = corners.checked_mul(1 << (2 * levels)).filter(|&n| 4 * n < Face::NONE as usize);
    if count.is_none() {
        return Err(SkinError::TooLarge { mesh: mesh.name.clone(), what: "vertices", count: usize::MAX });
    }
    let mut cage = Cage::new(mesh, crease_angle);
    for _ in 0..levels {
        cage = cage.step().0;
    }
    let mesh = cage.clone().finish();
    Ok(Tessellation { mesh, surface: Surface::Limit(Limit(cage)) })
}

/// What further subdivision of a mesh comes near to.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Limit(Cage);

impl Limit {
    /// How far the mesh is from what it is after some more steps.
    pub(super) fn deviation(&self) -> Deviation {
        let Self(cage) = self;
        let mut finer = cage.clone();
        let mut steps = Vec::new();
        // The measure is for what it costs: not on more than some millions of faces.
        if cage.mesh.faces.len() < 1 << 20 {
            for _ in 0..FINER {
                let (next, edges) = finer.step();
                finer = next;
                steps.push(edges);
            }
        }
        cage.deviation(&finer, &steps).finish()
    }
}

/// The points that steps put on edges, by their lower and higher vertex.
type EdgePoints = HashMap<Ends, u32>;

/// An edge by its lower and its higher vertex.
type Ends = (u32, u32);

/// A mesh on its way to the limit surface.
#[derive(Clone, Debug, PartialEq)]
struct Cage {
    mesh: Mesh,
    positions: Vec<DVec3>,
    /// The sharp edges, by their lower and higher vertex.
    sharp: HashSet<Ends>,
}

/// What an edge needs to know of its faces.
#[derive(Clone, Copy)]
struct Edge {
    /// Which of all edges it is.
    index: u32,
    /// The sum of the centres of its faces.
    centres: DVec3,
    /// How many there are.
    faces: u32,
}

/// What a vertex needs to know of what is around it.
#[derive(Clone, Copy, Default)]
struct Around {
    /// Its faces.
    faces: u32,
    /// Its edges.
    edges: u32,
    /// The sum of the centres of its faces.
    centres: DVec3,
    /// The sum of the other ends of its edges.
    ends: DVec3,
    /// The sum of the corners opposite of it in its quads.
    opposite: DVec3,
    /// Its sharp edges.
    sharp: u32,
    /// The sum of their other ends.
    sharp_ends: DVec3,
}

fn key(a: u32, b: u32) -> Ends {
    (a.min(b), a.max(b))
}

impl Cage {
    fn new(mesh: &Mesh, crease_angle: f32) -> Self {
        let mut faces_at: HashMap<Ends, Vec<usize>> = HashMap::new();
        for (face, f) in mesh.faces.iter().enumerate() {
            let corners = f.corners();
            for (k, &a) in corners.iter().enumerate() {
                faces_at.entry(key(a, corners[(k + 1) % corners.len()])).or_default().push(face);
            }
        }
        let cosine = crease_angle.to_radians().cos();
        let normal = |face: usize| mesh.area_vector(face).normalize_or_zero();
        let is_sharp = |faces: &[usize]| match faces {
            &[a, b] => crease_angle < 180.0 && normal(a).dot(normal(b)) < cosine,
            _ => true,
        };
        let sharp = faces_at.into_iter().filter(|(_, faces)| is_sharp(faces)).map(|(edge, _)| edge);
        let positions = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        Self { mesh: Mesh { normals: None, colors: None, ..mesh.clone() }, positions, sharp: sharp.collect() }
    }

    /// Every edge once, in the order of the faces, and what is known of it.
    fn edges(&self, centres: &[DVec3]) -> (Vec<Ends>, HashMap<Ends, Edge>) {
        let mut order = Vec::with_capacity(2 * self.mesh.faces.len());
        let mut edges = HashMap::with_capacity(2 * self.mesh.faces.len());
        for (face, centre) in self.mesh.faces.iter().zip(centres) {
            let corners = face.corners();
            for (k, &a) in corners.iter().enumerate() {
                let edge = key(a, corners[(k + 1) % corners.len()]);
                let edge = edges.entry(edge).or_insert_with(|| {
                    order.push(edge);
                    Edge { index: order.len() as u32 - 1, centres: DVec3::ZERO, faces: 0 }
                });
                edge.centres += *centre;
                edge.faces += 1;
            }
        }
        (order, edges)
    }

    fn centres(&self) -> Vec<DVec3> {
        let point = |i: &u32| self.positions[*i as usize];
        let centre = |f: &Face| f.corners().iter().map(point).sum::<DVec3>() / f.corners().len() as f64;
        self.mesh.faces.iter().map(centre).collect()
    }

    fn around(&self, order: &[Ends], centres: &[DVec3]) -> Vec<Around> {
        let mut around = vec![Around::default(); self.positions.len()];
        for (face, centre) in self.mesh.faces.iter().zip(centres) {
            let corners = face.corners();
            for (k, &v) in corners.iter().enumerate() {
                let at = &mut around[v as usize];
                at.faces += 1;
                at.centres += *centre;
                at.opposite += self.positions[corners[(k + 2) % corners.len()] as usize];
            }
        }
        for &(a, b) in order {
            let sharp = self.sharp.contains(&(a, b));
            for (v, other) in [(a, b), (b, a)] {
                let (at, end) = (&mut around[v as usize], self.positions[other as usize]);
                at.edges += 1;
                at.ends += end;
                if sharp {
                    at.sharp += 1;
                    at.sharp_ends += end;
                }
            }
        }
        around
    }

    /// One step, and the points that it put on edges.
    fn step(&self) -> (Self, EdgePoints) {
        let centres = self.centres();
        let (order, edges) = self.edges(&centres);
        let around = self.around(&order, &centres);
        let (vertices, first_centre) = (self.positions.len(), self.positions.len() + order.len());
        let mut positions = Vec::with_capacity(first_centre + centres.len());
        positions.extend(self.positions.iter().zip(&around).map(|(p, a)| a.moved(*p)));
        positions.extend(order.iter().map(|edge| {
            let (a, b) = (self.positions[edge.0 as usize], self.positions[edge.1 as usize]);
            let Edge { centres, faces, .. } = edges[edge];
            if self.sharp.contains(edge) { 0.5 * (a + b) } else { (a + b + centres) / f64::from(2 + faces) }
        }));
        positions.extend(&centres);

        let on_edge = |a: u32, b: u32| vertices as u32 + edges[&key(a, b)].index;
        let mut sharp = HashSet::with_capacity(2 * self.sharp.len());
        for &(a, b) in &self.sharp {
            let middle = on_edge(a, b);
            sharp.insert(key(a, middle));
            sharp.insert(key(middle, b));
        }
        let mut mesh = Mesh { name: self.mesh.name.clone(), ..Mesh::default() };
        let mut uvs = self.mesh.uvs.as_ref().map(|_| Vec::new());
        for (f, face) in self.mesh.faces.iter().enumerate() {
            let (corners, n) = (face.corners(), face.corners().len());
            for (k, &corner) in corners.iter().enumerate() {
                let (next, before) = (corners[(k + 1) % n], corners[(k + n - 1) % n]);
                let quad =
                    [corner, on_edge(corner, next), (first_centre + f) as u32, on_edge(before, corner)];
                mesh.faces.push(Face::quad(quad, face.material));
                if let (Some(finer), Some(uvs)) = (&mut uvs, &self.mesh.uvs) {
                    let uv = &uvs[f];
                    let centre = uv[..n].iter().copied().sum::<Vec2>() / n as f32;
                    let [next, before] = [(k + 1) % n, (k + n - 1) % n].map(|i| 0.5 * (uv[k] + uv[i]));
                    finer.push([uv[k], next, centre, before]);
                }
            }
        }
        mesh.uvs = uvs;
        mesh.attributes = self.mesh.attributes.iter().map(|a| self.finer(a, &order)).collect();
        let edge_points = order.iter().map(|&(a, b)| ((a, b), on_edge(a, b))).collect();
        (Self { mesh, positions, sharp }, edge_points)
    }

    /// An attribute of the next step's vertices: the same, the means of edges, the means of faces.
    fn finer(&self, attribute: &Attribute, order: &[Ends]) -> Attribute {
        let value = |i: u32| attribute.values[i as usize];
        let mut values = attribute.values.clone();
        values.extend(order.iter().map(|&(a, b)| 0.5 * (value(a) + value(b))));
        let mean = |f: &Face| f.corners().iter().map(|&i| value(i)).sum::<f32>() / f.corners().len() as f32;
        values.extend(self.mesh.faces.iter().map(mean));
        Attribute { name: attribute.name.clone(), values }
    }

    /// Where the vertices go in the limit.
    fn limit(&self) -> Vec<DVec3> {
        let centres = self.centres();
        let (order, _) = self.edges(&centres);
        let around = self.around(&order, &centres);
        let all_quads = self.mesh.faces.iter().all(Face::is_quad);
        let limit = |(p, a): (&DVec3, &Around)| if all_quads { a.limit(*p) } else { *p };
        self.positions.iter().zip(&around).map(limit).collect()
    }

    fn finish(mut self) -> Mesh {
        self.mesh.positions = self.limit().into_iter().map(|p| p.as_vec3()).collect::<Vec<Vec3>>();
        self.mesh
    }

    /// The errors of this mesh's limit points against those of one that is `steps` finer.
    fn deviation(&self, finer: &Self, steps: &[EdgePoints]) -> Account {
        let mut account = Account::default();
        if steps.is_empty() {
            return account;
        }
        let (coarse, fine) = (self.limit(), finer.limit());
        let children: usize = 4_usize.pow(steps.len() as u32 - 1);
        let mut child = 0;
        for face in &self.mesh.faces {
            let (corners, n) = (face.corners(), face.corners().len());
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % n];
                let mut chain = vec![a, b];
                for points in steps {
                    chain = (chain.windows(2))
                        .flat_map(|e| [Some(e[0]), points.get(&key(e[0], e[1])).copied()])
                        .chain([Some(b)])
                        .flatten()
                        .collect();
                }
                let arc = chain.windows(2).map(|e| fine[e[0] as usize].distance(fine[e[1] as usize])).sum();
                account.edge(coarse[a as usize].distance(coarse[b as usize]), arc);
            }
            let area = |positions: &[DVec3], f: &Face| {
                let corners = f.corners();
                let p = |i: usize| positions[corners[i % corners.len()] as usize];
                0.5 * (p(2) - p(0)).cross(p(3) - p(1)).length()
            };
            let range = child..child + n * children;
            child = range.end;
            account.patch(area(&coarse, face), finer.mesh.faces[range].iter().map(|f| area(&fine, f)).sum());
        }
        account
    }
}

impl Around {
    /// Whether the vertex stays: where sharp edges meet that are not one line, and at a corner of the border.
    fn is_corner(&self) -> bool {
        self.sharp > 2 || self.faces <= 1 || (self.sharp == 2 && self.edges == 2)
    }

    fn moved(&self, p: DVec3) -> DVec3 {
        if self.is_corner() {
            return p;
        }
        if self.sharp == 2 {
            return 0.75 * p + 0.125 * self.sharp_ends;
        }
        // The mean of the faces' centres, twice that of the edges' middles, and n − 3 times the vertex.
        let n = f64::from(self.edges);
        let middles = 0.5 * (p + self.ends / n);
        (self.centres / f64::from(self.faces) + 2.0 * middles + (n - 3.0) * p) / n
    }

    /// The limit of a vertex all of whose faces are quads. \[HalsteadKassDeRose93\]
    fn limit(&self, p: DVec3) -> DVec3 {
        if self.is_corner() {
            return p;
        }
        if self.sharp == 2 {
            return (4.0 * p + self.sharp_ends) / 6.0;
        }
        let n = f64::from(self.edges);
        (n * n * p + 4.0 * self.ends + self.opposite) / (n * (n + 5.0))
    }
}
