//! Simple surfaces to try skins on: quads, counter-clockwise seen from outside, neighbours sharing vertices.
//!
//! Numbers of faces are raised to the least that makes a surface (1, or 3 around a torus).

use core::f32::consts::TAU;
use std::collections::HashMap;

use glam::{IVec3, Vec2, Vec3};
use pelage_geom::{Face, MaterialId, Mesh};

/// A square of side `size` metres about the origin, in the plane y = 0 facing +Y, of `nu` × `nv` quads.
///
/// Its texture coordinates run over `[0,1]²`, u along +X and v along −Z.
pub fn plane(size: f32, nu: u32, nv: u32) -> Mesh {
    let (nu, nv) = (nu.max(1), nv.max(1));
    let uv = |i: u32, j: u32| Vec2::new(i as f32 / nu as f32, j as f32 / nv as f32);
    let mut mesh = Mesh { name: "plane".into(), uvs: Some(Vec::new()), ..Mesh::default() };
    for j in 0..=nv {
        for i in 0..=nu {
            let at = size * (uv(i, j) - 0.5);
            mesh.positions.push(Vec3::new(at.x, 0.0, -at.y));
        }
    }
    let index = |i: u32, j: u32| j * (nu + 1) + i;
    for (i, j) in cells(nu, nv) {
        let around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        push(&mut mesh, around.map(|(i, j)| index(i, j)), around.map(|(i, j)| uv(i, j)));
    }
    mesh
}

/// A torus about the Y axis, of `nu` quads around the axis and `nv` around the tube (`major` and `minor` are the
/// two radii, in metres).
///
/// Its texture coordinates run over `[0,1]²`: u around the axis, v around the tube from its outer equator upwards.
/// They jump from 1 to 0 at a seam where the vertices do not.
pub fn torus(major: f32, minor: f32, nu: u32, nv: u32) -> Mesh {
    let (nu, nv) = (nu.max(3), nv.max(3));
    let mut mesh = Mesh { name: "torus".into(), uvs: Some(Vec::new()), ..Mesh::default() };
    for j in 0..nv {
        for i in 0..nu {
            let (around, tube) = (TAU * i as f32 / nu as f32, TAU * j as f32 / nv as f32);
            let radius = major + minor * tube.cos();
            mesh.positions.push(Vec3::new(radius * around.cos(), minor * tube.sin(), -radius * around.sin()));
        }
    }
    let index = |i: u32, j: u32| (j % nv) * nu + i % nu;
    let uv = |i: u32, j: u32| Vec2::new(i as f32 / nu as f32, j as f32 / nv as f32);
    for (i, j) in cells(nu, nv) {
        let around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        push(&mut mesh, around.map(|(i, j)| index(i, j)), around.map(|(i, j)| uv(i, j)));
    }
    mesh
}

/// A sphere of `radius` metres about the origin: a cube of n × n quads a side, blown up; without texture
/// coordinates. Its quads are near squares of nearly equal size everywhere.
pub fn cube_sphere(radius: f32, n: u32) -> Mesh {
    let n = n.clamp(1, 1 << 14) as i32;
    let mut mesh = Mesh { name: "cube sphere".into(), ..Mesh::default() };
    // Vertices by their place on the cube [−n, n]³, which the six sides share along its edges.
    let mut index = HashMap::new();
    for side in 0..6 {
        for (i, j) in cells(n as u32, n as u32) {
            let (i, j) = (2 * i as i32 - n, 2 * j as i32 - n);
            let corners = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)].map(|(i, j)| {
                let place = on_cube(side, i, j, n);
                *index.entry(place).or_insert_with(|| {
                    // Equal angles rather than equal lengths along the cube: quads of more equal size.
                    let bulged =
                        (place.as_vec3() / n as f32).map(|x| (x * core::f32::consts::FRAC_PI_4).tan());
                    mesh.positions.push(radius * bulged.normalize());
                    (mesh.positions.len() - 1) as u32
                })
            });
            mesh.faces.push(Face::quad(corners, MaterialId(0)));
        }
    }
    mesh
}

/// The point (i, j) of a side of the cube `[−n, n]³`, where i × j points outwards.
fn on_cube(side: usize, i: i32, j: i32, n: i32) -> IVec3 {
    let turned = |v: IVec3| match side % 3 {
        0 => v,
        1 => IVec3::new(v.z, v.x, v.y),
        _ => IVec3::new(v.y, v.z, v.x),
    };
    // Exchanging i and j on the far sides turns them inside out, which the sign of n turns back.
    if side < 3 { turned(IVec3::new(i, j, n)) } else { turned(IVec3::new(j, i, -n)) }
}

fn cells(nu: u32, nv: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..nv).flat_map(move |j| (0..nu).map(move |i| (i, j)))
}

fn push(mesh: &mut Mesh, around: [u32; 4], uvs: [Vec2; 4]) {
    mesh.faces.push(Face::quad(around, MaterialId(0)));
    mesh.uvs.get_or_insert_default().push(uvs);
}
