//! Meshes over the parameters of a surface: a grid of lines u = constant and v = constant, so that neighbours
//! share whole edges however unevenly the lines lie.

use glam::{DVec2, DVec3, Vec2};
use pelage_geom::{Face, MaterialId, Mesh};
use rayon::prelude::*;

use super::{Account, Bounds, Deviation, Parametric, Surface, Tessellation};
use crate::SkinError;

/// Straight pieces of which an arc is measured; for an eighth of a turn they miss 1e-5 of it.
const PIECES: usize = 24;

/// A surface by `nu` × `nv` patches, evenly in its parameters; numbers are raised to the least that makes a surface.
///
/// # Errors
/// A surface that is none, or more patches than 32-bit indices can name.
pub fn uniform(surface: &Parametric, nu: usize, nv: usize) -> Result<Tessellation, SkinError> {
    surface.validate()?;
    let least = if surface.closed()[0] { [3, if surface.closed()[1] { 3 } else { 2 }] } else { [1, 1] };
    let lines = [nu.max(least[0]), nv.max(least[1])].map(even);
    check_size(surface, &lines, u32::MAX as usize / 4)?;
    Ok(tessellation(surface, lines))
}

fn tessellation(surface: &Parametric, lines: [Vec<f64>; 2]) -> Tessellation {
    Tessellation { mesh: mesh(surface, &lines), surface: Surface::Parametric(surface.clone(), lines) }
}

/// A surface by as few grid lines as keep its deviation within `bounds`, where halving intervals of u or v finds them:
/// lines are close where the surface bends.
///
/// # Errors
/// A surface or bounds that are none, or [`SkinError::TooFine`] where more patches would be needed than `bounds` allow.
pub fn adaptive(surface: &Parametric, bounds: &Bounds) -> Result<Tessellation, SkinError> {
    surface.validate()?;
    bounds.validate().map_err(|(field, expected)| SkinError::Surface {
        surface: "bounds",
        field,
        expected,
    })?;
    let mut lines = surface.coarsest().map(even);
    loop {
        check_size(surface, &lines, bounds.most_patches.min(u32::MAX as usize / 4))?;
        let split = [wanted_splits(surface, &lines, bounds, 0), wanted_splits(surface, &lines, bounds, 1)];
        if !split.iter().flatten().any(|s| *s) {
            return Ok(tessellation(surface, lines));
        }
        for (lines, split) in lines.iter_mut().zip(split) {
            *lines = halved(lines, &split);
        }
    }
}

/// n + 1 values from 0 to 1.
fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// The same lines, and one in the middle of each interval that is to be split.
fn halved(lines: &[f64], split: &[bool]) -> Vec<f64> {
    let mut finer = Vec::with_capacity(2 * lines.len());
    for (ends, &split) in lines.windows(2).zip(split) {
        finer.push(ends[0]);
        finer.extend(split.then_some(0.5 * (ends[0] + ends[1])));
    }
    finer.extend(lines.last());
    finer
}

fn check_size(surface: &Parametric, lines: &[Vec<f64>; 2], most: usize) -> Result<(), SkinError> {
    let patches = (lines[0].len() - 1).saturating_mul(lines[1].len() - 1);
    if patches > most {
        return Err(SkinError::TooFine { surface: surface.name(), patches, most });
    }
    Ok(())
}

/// Which intervals along `axis` are too long: those with an edge along them that is too far from its arc, and,
/// where a patch's area is what is wrong, those along which its arcs bend the more.
fn wanted_splits(surface: &Parametric, lines: &[Vec<f64>; 2], bounds: &Bounds, axis: usize) -> Vec<bool> {
    let (along, across) = (&lines[axis], &lines[1 - axis]);
    let place = |axis: usize, x: f64, y: f64| if axis == 0 { DVec2::new(x, y) } else { DVec2::new(y, x) };
    let bend = |axis: usize, x: [f64; 2], y: f64| {
        let (chord, arc) = edge(surface, place(axis, x[0], y), place(axis, x[1], y));
        (arc - chord, if arc > 0.0 { (arc - chord) / arc } else { 0.0 })
    };
    (0..along.len() - 1)
        .into_par_iter()
        .map(|i| {
            let interval = [along[i], along[i + 1]];
            let is_off = |y: f64| {
                let (metres, relative) = bend(axis, interval, y);
                metres > bounds.arc_metres || relative > bounds.arc
            };
            // Through the middles of the patches too: what only bulges between straight sides is seen there.
            let edge_is_off = across.iter().any(|&y| is_off(y))
                || across.windows(2).any(|ends| is_off(0.5 * (ends[0] + ends[1])));
            let patch_is_off = |j: usize| {
                let other = [across[j], across[j + 1]];
                let corners = [interval, other];
                let [u, v] = if axis == 0 { corners } else { [corners[1], corners[0]] };
                let (flat, curved) = areas(surface, u, v);
                let error = (curved - flat).abs();
                let off = error > bounds.area_square_metres || (curved > 0.0 && error > bounds.area * curved);
                let most = |axis: usize, x: [f64; 2], y: [f64; 2]| {
                    bend(axis, x, y[0]).0.max(bend(axis, x, 0.5 * (y[0] + y[1])).0).max(bend(axis, x, y[1]).0)
                };
                off && most(axis, interval, other) >= 0.5 * most(1 - axis, other, interval)
            };
            edge_is_off || (0..across.len() - 1).any(patch_is_off)
        })
        .collect()
}

/// What the mesh has, and what the surface has there.
type Measured = (f64, f64);

/// The lengths of the chord and of the arc between two parameters.
fn edge(surface: &Parametric, from: DVec2, to: DVec2) -> Measured {
    let point = |k: usize| surface.point(from.lerp(to, k as f64 / PIECES as f64));
    let mut last = point(0);
    let (first, mut arc) = (last, 0.0);
    for k in 1..=PIECES {
        let next = point(k);
        arc += last.distance(next);
        last = next;
    }
    (first.distance(last), arc)
}

/// The areas of the bilinear patch over a rectangle of parameters, and of the surface itself.
fn areas(surface: &Parametric, u: [f64; 2], v: [f64; 2]) -> Measured {
    const CELLS: usize = 12;
    let at = |x: f64, y: f64| DVec2::new(u[0] + x * (u[1] - u[0]), v[0] + y * (v[1] - v[0]));
    let corner = |i: usize, j: usize| surface.point(at(i as f64, j as f64));
    let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
    let flat = |x: f64, y: f64| corners[0].lerp(corners[1], x).lerp(corners[2].lerp(corners[3], x), y);
    let curved = |x: f64, y: f64| surface.point(at(x, y));
    (area_of_cells(CELLS, &flat), area_of_cells(CELLS, &curved))
}

/// The area of n × n flat cells on a surface over `[0,1]²`.
fn area_of_cells(n: usize, point: &dyn Fn(f64, f64) -> DVec3) -> f64 {
    let row = |j: usize| (0..=n).map(|i| point(i as f64 / n as f64, j as f64 / n as f64)).collect::<Vec<_>>();
    let (mut area, mut below) = (0.0, row(0));
    for j in 1..=n {
        let above = row(j);
        for i in 0..n {
            area += 0.5 * (above[i + 1] - below[i]).cross(above[i] - below[i + 1]).length();
        }
        below = above;
    }
    area
}

pub(super) fn deviation(surface: &Parametric, [us, vs]: &[Vec<f64>; 2]) -> Deviation {
    let rows: Vec<[Vec<Measured>; 2]> = (0..vs.len())
        .into_par_iter()
        .map(|j| {
            let at = |i: usize, j: usize| DVec2::new(us[i], vs[j]);
            let mut edges: Vec<_> = (1..us.len()).map(|i| edge(surface, at(i - 1, j), at(i, j))).collect();
            let mut patches = Vec::new();
            if j + 1 < vs.len() {
                edges.extend((0..us.len()).map(|i| edge(surface, at(i, j), at(i, j + 1))));
                let column = |i: usize| areas(surface, [us[i - 1], us[i]], [vs[j], vs[j + 1]]);
                patches.extend((1..us.len()).map(column));
            }
            [edges, patches]
        })
        .collect();
    let mut account = Account::default();
    for [edges, patches] in rows {
        edges.into_iter().for_each(|(chord, arc)| account.edge(chord, arc));
        patches.into_iter().for_each(|(flat, curved)| account.patch(flat, curved));
    }
    account.finish()
}

/// The mesh over grid lines; where the surface closes, its last vertices are its first ones, and around a pole patches
/// are triangles.
fn mesh(surface: &Parametric, [us, vs]: &[Vec<f64>; 2]) -> Mesh {
    let [closed_u, closed_v] = surface.closed();
    let (nu, nv) = (us.len() - 1, vs.len() - 1);
    let (columns, rows) = (nu + usize::from(!closed_u), nv + usize::from(!closed_v));
    let poles = surface.has_poles();
    let mut mesh = Mesh { name: surface.name().into(), uvs: Some(Vec::new()), ..Mesh::default() };
    let mut index = vec![0; columns * rows];
    for j in 0..rows {
        for i in 0..columns {
            if i == 0 || !(poles && (j == 0 || j == nv)) {
                mesh.positions.push(surface.point(DVec2::new(us[i], vs[j])).as_vec3());
            }
            index[j * columns + i] = mesh.positions.len() as u32 - 1;
        }
    }
    let vertex = |i: usize, j: usize| index[j % rows * columns + i % columns];
    for j in 0..nv {
        for i in 0..nu {
            let around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let vertices = around.map(|(i, j)| vertex(i, j));
            let uvs = around.map(|(i, j)| Vec2::new(us[i] as f32, vs[j] as f32));
            // At a pole two corners are one, halfway between its texture coordinates.
            let (face, uvs) = if vertices[0] == vertices[1] {
                (triangle(vertices, [0, 2, 3]), [0.5 * (uvs[0] + uvs[1]), uvs[2], uvs[3], Vec2::ZERO])
            } else if vertices[2] == vertices[3] {
                (triangle(vertices, [0, 1, 2]), [uvs[0], uvs[1], 0.5 * (uvs[2] + uvs[3]), Vec2::ZERO])
            } else {
                (Face::quad(vertices, MaterialId(0)), uvs)
            };
            mesh.faces.push(face);
            mesh.uvs.get_or_insert_default().push(uvs);
        }
    }
    mesh
}

fn triangle(vertices: [u32; 4], pick: [usize; 3]) -> Face {
    Face::triangle(pick.map(|i| vertices[i]), MaterialId(0))
}
