//! How long a texel takes to bake, and how much memory, from a mesh of many triangles.
//!
//! ```text
//! cargo run --release --example bake_speed -- [MODEL] [TRIANGLES] [RESOLUTION]
//! ```
//!
//! The triangles of MODEL (.glb, .gltf or .obj; `-` for a bumpy ball of our own) are cut in four until there are
//! TRIANGLES of them (1 000 000), and built at RESOLUTION (512).

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use pelage::bake::{ContentOptions, content, read};
use pelage::geom::glam::Vec3;
use pelage::skin::surface;
use pelage::texel::{BuildOptions, Geometry, build};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let model = arguments.next().unwrap_or_else(|| "-".into());
    let wanted: usize = arguments.next().map_or(Ok(1_000_000), |n| n.parse())?;
    let resolution: u32 = arguments.next().map_or(Ok(512), |n| n.parse())?;
    let begun = Instant::now();
    let mut geometry = if model == "-" {
        ball((wanted as f64 / 12.0).sqrt().ceil() as u32)
    } else {
        let file = Path::new(&model);
        let options = ContentOptions { resolution, ..ContentOptions::default() };
        content(file, &read(file)?, &options, &|_| ())?.geometry
    };
    while geometry.triangles.len() < wanted {
        geometry = in_four(&geometry);
    }
    println!("{} triangles: {:.2} s", geometry.triangles.len(), begun.elapsed().as_secs_f64());
    let options = BuildOptions { depth: resolution.ilog2(), periodic: false, ..BuildOptions::standard() };
    let begun = Instant::now();
    let texel = build("speed", geometry, &options, &|_| ())?;
    println!("built at {resolution}³: {:.2} s", begun.elapsed().as_secs_f64());
    for level in texel.levels() {
        println!("{:4}³ {:9} voxels {:10} bytes", level.resolution(), level.len(), level.memory());
    }
    // Where the system tells: kilobytes, and hundredths of a second.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(line) = status.lines().find(|line| line.starts_with("VmHWM")) {
        println!("{line}");
    }
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    if let Some(ticks) = stat.split_whitespace().nth(13) {
        println!("user CPU: {ticks} ticks");
    }
    Ok(())
}

/// A bumpy ball in the texel's cube, of `12 n²` triangles.
fn ball(n: u32) -> Geometry {
    let mesh = surface::cube_sphere(0.4, n);
    let bumpy = |p: Vec3| {
        let wave = (p * 60.0).map(f32::sin).element_product();
        Vec3::splat(0.5) + p * (1.0 + 0.1 * wave)
    };
    let mut geometry = Geometry { specular: 0.04, roughness: 0.5, ..Geometry::default() };
    for face in &mesh.faces {
        let corner = |i: usize| bumpy(mesh.positions[face.vertices[i] as usize]);
        geometry.push_quad([0, 1, 2, 3].map(corner), Vec3::splat(0.7));
    }
    geometry
}

/// Every triangle cut in four at the middles of its edges.
fn in_four(geometry: &Geometry) -> Geometry {
    let mut finer = Geometry { triangles: Vec::new(), colors: Vec::new(), ..*geometry };
    for (&[a, b, c], &color) in geometry.triangles.iter().zip(&geometry.colors) {
        let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
        for triangle in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            finer.push(triangle, color);
        }
    }
    finer
}
