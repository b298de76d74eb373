//! Instruction counts of the walk and of the wall, by gungraun under valgrind: the same to a thousandth on a busy machine,
//! where times are not. Needs `cargo install gungraun-runner` of the same version, and the feature `instructions`.
#![allow(missing_docs, unused_qualifications, reason = "of what the macros of gungraun write")]

mod boxes;

use std::hint::black_box;
use std::path::Path;

use boxes::Random;
use glam::Vec3;
use gungraun::{library_benchmark, library_benchmark_group, main};
use pelage::geom::{DTrilinear, Hexahedron, Ray, RaySpace, Trilinear, wall_hits};
use pelage::texel::file::FileOptions;
use pelage::texel::{BuildOptions, Grass, Texel, build};
use pelage::texel_file::{read_texel, write_texel};

/// So many rays are counted together.
const RAYS: usize = 256;

/// Where the texel is kept.
const TEXEL: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/instructions.texel");

/// Builds a texel of blades. This happens once, and not under valgrind, where it would take minutes.
fn bake() {
    let options = BuildOptions { depth: 6, ..BuildOptions::preview() };
    let texel = build("blades", Grass::meadow(), &options, &|_| ()).expect("grass is sound");
    write_texel(&texel, Path::new(TEXEL), &FileOptions::default()).expect("a file");
}

/// The texel, and rays from its top to its bottom in voxels of the level.
fn walks(level: u32) -> (Texel, u32, Vec<[Vec3; 2]>) {
    let (mut random, scale) = (Random(5), (1 << level) as f32);
    let rays = (0..RAYS).map(|_| {
        let from = random.inside().as_vec3().with_z(1.0);
        [scale * from, scale * (from + Vec3::new(0.9, 0.4, -1.0))]
    });
    let file = read_texel(Path::new(TEXEL)).expect("the file of the setup");
    (file.texel, level, rays.collect())
}

#[library_benchmark]
#[bench::level_4(args = (4), setup = walks)]
#[bench::level_6(args = (6), setup = walks)]
fn walk((texel, level, rays): (Texel, u32, Vec<[Vec3; 2]>)) -> f32 {
    let level = texel.level(level);
    let one = |&[from, to]: &[Vec3; 2]| level.walk(from, to).map(|step| step.leave).sum::<f32>();
    black_box(rays.iter().map(one).sum())
}

type Make = fn(&mut Random) -> Trilinear;

fn rays(make: Make) -> Vec<(DTrilinear, Hexahedron, Ray)> {
    let mut random = Random(6);
    let one = |_| {
        let map = make(&mut random);
        let exact = DTrilinear::from(map);
        let target = exact.point(random.inside());
        (exact, Hexahedron::cuboid(map), random.ray_through(target))
    };
    (0..RAYS).map(one).collect()
}

#[library_benchmark]
#[bench::mild(args = (Random::mild), setup = rays)]
#[bench::strong(args = (Random::strong), setup = rays)]
fn wall(rays: Vec<(DTrilinear, Hexahedron, Ray)>) -> usize {
    let hits = |(map, _, ray): &(DTrilinear, Hexahedron, Ray)| {
        let [p00, p10, p01, p11, ..] = map.corners;
        wall_hits(ray, [p00, p10, p01, p11]).len()
    };
    black_box(rays.iter().map(hits).sum())
}

#[library_benchmark]
#[bench::mild(args = (Random::mild), setup = rays)]
#[bench::strong(args = (Random::strong), setup = rays)]
fn ray_space(rays: Vec<(DTrilinear, Hexahedron, Ray)>) {
    for (map, _, ray) in &rays {
        black_box(RaySpace::new(map, ray));
    }
}

#[library_benchmark]
#[bench::mild(args = (Random::mild), setup = rays)]
#[bench::strong(args = (Random::strong), setup = rays)]
fn passages(rays: Vec<(DTrilinear, Hexahedron, Ray)>) {
    for (_, hexahedron, ray) in &rays {
        black_box(hexahedron.passages(ray, 0.0, f64::INFINITY));
    }
}

library_benchmark_group!(name = texels, benchmarks = [walk]);
library_benchmark_group!(name = boxes_and_rays, benchmarks = [wall, ray_space, passages]);

main!(setup = bake(), library_benchmark_groups = [texels, boxes_and_rays]);
