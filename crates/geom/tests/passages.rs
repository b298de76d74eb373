//! Passages of rays through boxes: against dense inversion, and through lattices of neighbours without gap or
//! overlap.

mod random;

use pelage_geom::glam::{DVec3, Vec3};
use pelage_geom::{Certificate, Hexahedron, Passage, Ray, Trilinear, certify};
use proptest::prelude::*;
use random::Random;

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn all_passages(hexahedron: &Hexahedron, ray: &Ray) -> Vec<Passage> {
    hexahedron.passages(ray, EVERYWHERE[0], EVERYWHERE[1]).to_vec()
}

fn random_valid(random: &mut Random) -> Hexahedron {
    loop {
        let map = random.any_box();
        let [a, b, c, _, e, f, g, _] = map.corners;
        let hexahedron = if random.below(2) == 0 {
            Hexahedron::cuboid(map)
        } else {
            Hexahedron::prism([a, b, c], [e, f, g])
        };
        if let Certificate::Valid { .. } = certify(&hexahedron, 4) {
            return hexahedron;
        }
    }
}

#[test]
fn passages_are_where_inversion_says() {
    let mut random = Random::new(10);
    let (mut several, mut points) = (0, 0);
    for _ in 0..12_000 {
        let hexahedron = random_valid(&mut random);
        let [lo, hi] = hexahedron.bounds();
        let target = lo + (hi - lo) * random.inside();
        let ray = random.ray_through(target, 3.0);
        let passages = all_passages(&hexahedron, &ray);
        several += usize::from(passages.len() > 1);
        let middle = (0.5 * (lo + hi) - ray.origin).dot(ray.direction);
        for i in 0..24 {
            let t = middle + (hi - lo).length() * ((f64::from(i) + random.unit()) / 24.0 - 0.5);
            // Within a hair of the surface either answer is right.
            if passages.iter().flat_map(|p| p.t).any(|end| (end - t).abs() < 1e-7) {
                continue;
            }
            points += 1;
            let inside = passages.iter().any(|p| p.t[0] < t && t < p.t[1]);
            assert_eq!(
                hexahedron.contains(ray.at(t)),
                inside,
                "t = {t}, {ray:?}, {passages:?}, {hexahedron:?}"
            );
        }
    }
    assert!(points > 250_000 && several > 20, "{points} points, {several} rays with several passages");
}

#[test]
fn ends_are_coordinates_of_the_points_they_name() {
    let mut random = Random::new(11);
    for _ in 0..50_000 {
        let hexahedron = random_valid(&mut random);
        let u = random.inside();
        let ray = random.ray_through(hexahedron.map().point(u), 3.0);
        // Cut somewhere, so that half of the ends lie inside.
        let (t_min, t_max) = (random.between(0.0, 3.0), random.between(2.0, 5.0));
        for passage in hexahedron.passages(&ray, t_min, t_max).iter() {
            assert!(t_min <= passage.t[0] && passage.t[0] < passage.t[1] && passage.t[1] <= t_max);
            for (t, u) in passage.t.into_iter().zip(passage.u) {
                assert!(u.min_element() >= 0.0 && u.max_element() <= 1.0);
                let missed = hexahedron.map().point(u).distance(ray.at(t));
                assert!(missed < 1e-11, "{missed} at {u}");
            }
        }
    }
}

/// A lattice of cells³ boxes that fills the cube [0, cells]³: inner vertices are moved by up to `jitter`, those of
/// the hull within it only.
struct Lattice {
    cells: usize,
    vertices: Vec<Vec3>,
}

impl Lattice {
    fn new(cells: usize, jitter: f64, random: &mut Random) -> Self {
        let side = cells + 1;
        let vertex = |i: usize, random: &mut Random| {
            let place = [i % side, i / side % side, i / side / side];
            let p = place.map(|x| {
                let moved = x as f64 + random.between(-jitter, jitter);
                if x == 0 || x == cells { x as f64 } else { moved }
            });
            DVec3::from_array(p).as_vec3()
        };
        Self { cells, vertices: (0..side * side * side).map(|i| vertex(i, random)).collect() }
    }

    fn vertex(&self, x: usize, y: usize, z: usize) -> Vec3 {
        let side = self.cells + 1;
        self.vertices[x + side * (y + side * z)]
    }

    fn cell_corners(&self) -> impl Iterator<Item = [Vec3; 8]> {
        let n = self.cells;
        (0..n * n * n).map(move |i| {
            let [x, y, z] = [i % n, i / n % n, i / n / n];
            core::array::from_fn(|k| self.vertex(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2 & 1)))
        })
    }

    /// Each cell as a cuboid that stands in one of several ways, so that neighbours name their faces differently.
    fn cuboids(&self) -> Vec<Hexahedron> {
        // Right-handed relabellings of the corners: turned about w, and cyclic changes of axes.
        let turned = |c: [Vec3; 8]| [c[1], c[3], c[0], c[2], c[5], c[7], c[4], c[6]];
        let cycled = |c: [Vec3; 8]| core::array::from_fn(|i| c[(i << 1 & 7) | i >> 2]);
        let stand = |(i, mut c): (usize, [Vec3; 8])| {
            for _ in 0..i % 4 {
                c = turned(c);
            }
            for _ in 0..i % 3 {
                c = cycled(c);
            }
            Hexahedron::cuboid(Trilinear { corners: c })
        };
        self.cell_corners().enumerate().map(stand).collect()
    }

    /// Each cell as two prisms over the triangles A, B, C and D, C, B.
    fn prisms(&self) -> Vec<Hexahedron> {
        self.cell_corners().flat_map(split).collect()
    }

    /// Columns of cuboids beside columns of prisms, as a mesh of quads and triangles has them.
    fn mixed(&self) -> Vec<Hexahedron> {
        let column = |i: usize| i % self.cells + i / self.cells % self.cells;
        self.cell_corners()
            .enumerate()
            .flat_map(|(i, corners)| match column(i) % 2 {
                0 => vec![Hexahedron::cuboid(Trilinear { corners })],
                _ => split(corners).to_vec(),
            })
            .collect()
    }

    /// The three ways to fill the lattice.
    fn fillings(&self) -> [Vec<Hexahedron>; 3] {
        [self.cuboids(), self.prisms(), self.mixed()]
    }
}

fn split([a, b, c, d, e, f, g, h]: [Vec3; 8]) -> [Hexahedron; 2] {
    [Hexahedron::prism([a, b, c], [e, f, g]), Hexahedron::prism([d, c, b], [h, g, f])]
}

/// Asserts that the passages of the ray through all boxes follow each other with steps of at most `seam`, and fill
/// the ray's chord of the cube [0, size]³. Returns the number of passages.
fn assert_no_seam(boxes: &[Hexahedron], ray: &Ray, size: f64, seam: f64) -> usize {
    let mut passages: Vec<Passage> = boxes.iter().flat_map(|b| all_passages(b, ray)).collect();
    passages.sort_by(|x, y| x.t[0].total_cmp(&y.t[0]).then(x.t[1].total_cmp(&y.t[1])));
    let mut reached = passages.first().map_or(0.0, |p| p.t[0]);
    for passage in &passages {
        let [enter, exit] = passage.t;
        assert!(enter - reached <= seam, "a gap on {ray:?} at {enter}: {passages:?}");
        assert!(reached.min(exit) - enter <= seam, "an overlap on {ray:?} at {enter}: {passages:?}");
        reached = exit.max(reached);
    }
    let inverse = ray.direction.recip();
    let (a, b) = (-ray.origin * inverse, (DVec3::splat(size) - ray.origin) * inverse);
    let chord = (a.max(b).min_element() - a.min(b).max_element()).max(0.0);
    let length: f64 = passages.iter().map(|p| p.t[1] - p.t[0]).sum();
    assert!((length - chord).abs() < 1e-12 * (1.0 + ray.origin.length()), "{ray:?}: {length} of {chord}");
    passages.len()
}

#[test]
fn rays_never_fall_between_neighbours() {
    let mut random = Random::new(12);
    let mut passages = 0;
    for _ in 0..24 {
        let lattice = Lattice::new(3, 0.25, &mut random);
        for boxes in lattice.fillings() {
            for _ in 0..250 {
                let target = random.inside() * 3.0;
                let ray = random.ray_through(target, 80.0);
                passages += assert_no_seam(&boxes, &ray, 3.0, 0.0);
            }
        }
    }
    assert!(passages > 40_000, "{passages}");
}

#[test]
fn small_boxes_far_from_the_origin_have_no_seams_either() {
    // Millimetres at a hundred metres: powers of two keep the hull flat.
    let mut random = Random::new(15);
    let (scale, place) = (1.0 / 256.0, Vec3::new(64.0, -128.0, 32.0));
    for _ in 0..12 {
        let lattice = Lattice::new(2, 0.25, &mut random);
        let moved = lattice.vertices.iter().map(|&p| p * scale + place).collect();
        let lattice = Lattice { vertices: moved, ..lattice };
        for boxes in lattice.fillings() {
            for _ in 0..200 {
                let target = random.inside() * 2.0 * f64::from(scale) + place.as_dvec3();
                let ray = random.ray_through(target, 100.0);
                let mut passages: Vec<Passage> = boxes.iter().flat_map(|b| all_passages(b, &ray)).collect();
                passages.sort_by(|x, y| x.t[0].total_cmp(&y.t[0]));
                // The target is inside, so something is met, without any step.
                assert!(!passages.is_empty(), "{ray:?}");
                for pair in passages.windows(2) {
                    assert_eq!(pair[0].t[1].to_bits(), pair[1].t[0].to_bits(), "{ray:?}: {pair:?}");
                }
            }
        }
    }
}

/// Where a ray meets several faces in one point, their order is that of rounding: 1e-15 of coordinates, by the sine of
/// the angle to the faces, here 1e-3 and more.
const AT_AN_EDGE: f64 = 1e-12;

#[test]
fn rays_through_vertices_and_edges_find_no_seam() {
    let mut random = Random::new(13);
    for jitter in [0.0, 0.25] {
        let lattice = Lattice::new(2, jitter, &mut random);
        // Only the middle vertex and the edges at it lie inside the hull.
        let middle = lattice.vertex(1, 1, 1).as_dvec3();
        let neighbours = [(0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2)];
        for boxes in lattice.fillings() {
            for _ in 0..4_000 {
                let (x, y, z) = neighbours[random.below(6)];
                let on_edge = middle.lerp(lattice.vertex(x, y, z).as_dvec3(), random.unit().max(0.25));
                for target in [middle, on_edge] {
                    let ray = random.ray_through(target, 8.0);
                    assert_no_seam(&boxes, &ray, 2.0, AT_AN_EDGE);
                }
            }
        }
    }
}

#[test]
fn rays_along_faces_and_edges_take_one_side() {
    // An unjittered lattice and rays along its axes and diagonals through its vertices: every decision is a tie.
    let lattice = Lattice::new(2, 0.0, &mut Random::new(0));
    for boxes in lattice.fillings() {
        for direction in [
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            -DVec3::Z,
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(-1.0, 1.0, 1.0),
        ] {
            let ray = Ray::new(DVec3::ONE - 4.0 * direction, direction).expect("a direction");
            assert_no_seam(&boxes, &ray, 2.0, AT_AN_EDGE);
            // Off the axis, in a face or along an edge of the hull's own lines.
            let ray = Ray { origin: ray.origin + DVec3::new(0.5, 0.0, 0.0), ..ray };
            let count: usize = boxes.iter().map(|b| all_passages(b, &ray).len()).sum();
            assert!(count > 0, "{direction}");
        }
    }
}

#[test]
fn a_camera_inside_starts_at_once() {
    let hexahedron = Hexahedron::cuboid(Trilinear::identity());
    let ray = Ray { origin: DVec3::new(0.25, 0.5, 0.5), direction: DVec3::X };
    let passages = hexahedron.passages(&ray, 0.0, f64::INFINITY);
    assert_eq!(passages.len(), 1);
    assert_eq!(passages[0].t, [0.0, 0.75]);
    assert!(passages[0].u[0].distance(DVec3::new(0.25, 0.5, 0.5)) < 1e-12);
    assert!(passages[0].u[1].distance(DVec3::new(1.0, 0.5, 0.5)) < 1e-12);
    // Cut at both ends; beyond the box; and behind the camera.
    assert_eq!(hexahedron.passages(&ray, 0.25, 0.5)[0].t, [0.25, 0.5]);
    assert!(hexahedron.passages(&ray, 1.0, 2.0).is_empty());
    assert!(hexahedron.passages(&ray, 0.5, 0.25).is_empty());
}

#[test]
fn boxes_without_volume_have_no_length() {
    let flat = |map: Trilinear| Trilinear { corners: map.corners.map(|c| c * Vec3::new(1.0, 1.0, 0.0)) };
    let point = Trilinear { corners: [Vec3::ONE; 8] };
    let mut random = Random::new(14);
    for _ in 0..20_000 {
        let map = random.jittered(0.2);
        for degenerate in [flat(map), point] {
            let [a, b, c, _, e, f, g, _] = degenerate.corners;
            for hexahedron in [Hexahedron::cuboid(degenerate), Hexahedron::prism([a, b, c], [e, f, g])] {
                let target = degenerate.corners[random.below(8)].as_dvec3();
                let ray = random.ray_through(target, 2.0);
                for passage in all_passages(&hexahedron, &ray) {
                    // Ends are apart by the rounding of the collapsed sides, which rays graze at any angle.
                    let height = (passage.t[1] - passage.t[0]) * ray.direction.z.abs();
                    assert!(height < 1e-12, "{passage:?}");
                    assert!(passage.u[0].is_finite() && passage.u[1].is_finite());
                }
            }
        }
    }
}

#[test]
fn a_collapsed_edge_is_no_obstacle() {
    // The wedge 0 ≤ z ≤ x over the unit square: its edge x = 0 is collapsed, and a ray along x at z = ¼ is inside
    // from x = ¼ to 1.
    let mut map = Trilinear::identity();
    map.corners[4] = map.corners[0];
    map.corners[6] = map.corners[2];
    let hexahedron = Hexahedron::cuboid(map);
    let ray = Ray { origin: DVec3::new(-1.0, 0.5, 0.25), direction: DVec3::X };
    let passages = all_passages(&hexahedron, &ray);
    assert_eq!(passages.len(), 1);
    assert!((passages[0].t[0] - 1.25).abs() < 1e-15 && (passages[0].t[1] - 2.0).abs() < 1e-15);
    // Down through the collapsed edge's far end: the height there is x.
    let down = Ray { origin: DVec3::new(0.125, 0.5, 2.0), direction: -DVec3::Z };
    assert!((all_passages(&hexahedron, &down)[0].t[0] - 1.875).abs() < 1e-15);
}

#[test]
fn a_mirrored_box_is_still_a_box() {
    let mut map = Trilinear::identity();
    for c in &mut map.corners {
        c.x = -c.x;
    }
    let ray = Ray { origin: DVec3::new(-2.0, 0.3, 0.4), direction: DVec3::X };
    let passages = all_passages(&Hexahedron::cuboid(map), &ray);
    assert_eq!(passages.len(), 1);
    assert_eq!(passages[0].t, [1.0, 2.0]);
    assert!((passages[0].u[0].x - 1.0).abs() < 1e-15 && passages[0].u[1].x.abs() < 1e-15);
}

#[test]
fn numbers_that_are_not_finite_are_missed() {
    let mut map = Trilinear::identity();
    let ray = Ray { origin: DVec3::new(-2.0, 0.3, 0.4), direction: DVec3::X };
    for bad in [Vec3::NAN, Vec3::INFINITY] {
        map.corners[3] = bad;
        assert!(all_passages(&Hexahedron::cuboid(map), &ray).is_empty());
    }
    let ray = Ray { origin: DVec3::NAN, direction: DVec3::X };
    assert!(all_passages(&Hexahedron::cuboid(Trilinear::identity()), &ray).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Corners from a coarse lattice: most boxes are folded, many collapsed, and ties are everywhere.
    #[test]
    fn any_eight_corners_give_ordered_passages(
        corners in proptest::array::uniform8(proptest::array::uniform3(-2_i8..=2)),
        origin in proptest::array::uniform3(-3_i8..=3),
        direction in proptest::array::uniform3(-2_i8..=2),
    ) {
        let corners = corners.map(|c| Vec3::from_array(c.map(f32::from)));
        let [a, b, c, _, e, f, g, _] = corners;
        let ray = Ray::new(DVec3::from_array(origin.map(f64::from)), DVec3::from_array(direction.map(f64::from)));
        prop_assume!(ray.is_some());
        for hexahedron in [Hexahedron::cuboid(Trilinear { corners }), Hexahedron::prism([a, b, c], [e, f, g])] {
            let passages = ray.map(|ray| hexahedron.passages(&ray, 0.5, 4.0).to_vec()).unwrap_or_default();
            let mut reached = 0.5;
            for Passage { t, u } in passages {
                prop_assert!(reached <= t[0] && t[0] < t[1] && t[1] <= 4.0);
                prop_assert!(u.iter().all(|u| u.min_element() >= 0.0 && u.max_element() <= 1.0));
                reached = t[1];
            }
        }
    }
}
