//! The closed form of a wall against Newton's iterations, against itself in other orders, and at its worst.

mod random;

use pelage_geom::glam::DVec3;
use pelage_geom::{DTrilinear, Ray, RaySpace, paper, wall_hits};
use random::Random;

/// S(a,b) of the wall with corners P00, P10, P01, P11.
fn surface([p00, p10, p01, p11]: [DVec3; 4], a: f64, b: f64) -> DVec3 {
    p00.lerp(p10, a).lerp(p01.lerp(p11, a), b)
}

/// The corners of the wall u_axis = c, with (a, b) the next two coordinates in cyclic order.
fn slice(map: &DTrilinear, axis: usize, c: f64) -> [DVec3; 4] {
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(a, b)| map.point(coordinates(axis, c, a, b)))
}

fn coordinates(axis: usize, c: f64, a: f64, b: f64) -> DVec3 {
    let mut u = [0.0; 3];
    (u[axis], u[(axis + 1) % 3], u[(axis + 2) % 3]) = (c, a, b);
    DVec3::from_array(u)
}

#[test]
fn every_root_that_newton_finds_is_found() {
    let mut random = Random::new(1);
    let mut compared = 0;
    for _ in 0..60_000 {
        let map = DTrilinear::from(random.any_box());
        let (axis, c) = (random.below(3), random.unit());
        let target = map.point(random.inside());
        let ray = random.ray_through(target, 3.0);
        let start = (target - ray.origin).dot(ray.direction);
        let Some((t, u)) = paper::reach_wall(&map, axis, c, &ray, start, 1e-12, 40) else { continue };
        let u = u.to_array();
        let (a, b) = (u[(axis + 1) % 3], u[(axis + 2) % 3]);
        if !(1e-6..=1.0 - 1e-6).contains(&a) || !(1e-6..=1.0 - 1e-6).contains(&b) {
            continue;
        }
        compared += 1;
        let hits = RaySpace::new(&map, &ray).wall(axis, c);
        // Where the ray touches the wall, two roots meet and t is known to the root of the tolerance only.
        let missed = hits.iter().map(|hit| (hit.t - t).abs()).fold(f64::INFINITY, f64::min);
        assert!(missed < 1e-5, "wall {axis} at {c}: Newton says {t} at {u:?}, closed form {hits:?}");
    }
    assert!(compared > 20_000, "only {compared} roots to compare with");
}

#[test]
fn every_root_is_on_the_ray_and_on_the_wall() {
    let mut random = Random::new(2);
    let (mut count, mut twice, mut worst) = (0, 0, 0.0_f64);
    for _ in 0..800_000 {
        let map = DTrilinear::from(random.any_box());
        let (axis, c) = (random.below(3), random.unit());
        let distance = [3.0, 100.0][random.below(2)];
        let target = map.point(random.inside());
        let ray = random.ray_through(target, distance);
        let hits = RaySpace::new(&map, &ray).wall(axis, c);
        let wall = slice(&map, axis, c);
        let far = wall.iter().map(|p| p.distance(ray.origin)).fold(0.0, f64::max);
        for hit in hits.iter() {
            assert!((0.0..=1.0).contains(&hit.a) && (0.0..=1.0).contains(&hit.b));
            // 2⁻⁵³ of the distance is what a coordinate can hold.
            worst =
                worst.max(surface(wall, hit.a, hit.b).distance(ray.at(hit.t)) / (far * 0.5 * f64::EPSILON));
            count += 1;
        }
        twice += usize::from(hits.len() == 2);
        assert!(hits.windows(2).all(|pair| pair[0].t <= pair[1].t && pair[0].side == -pair[1].side));
    }
    assert!(count > 300_000 && twice > 500, "{count} roots, {twice} walls hit twice");
    assert!(worst < 32.0, "{worst}");
}

/// The eight orders of the same wall, each with how it maps (a, b).
fn orders(p: [DVec3; 4]) -> Vec<([DVec3; 4], [usize; 3])> {
    let mut all = Vec::new();
    for first in 0..4 {
        for (da, db) in [(1, 2), (2, 1)] {
            all.push(([p[first], p[first ^ da], p[first ^ db], p[first ^ 3]], [first, da, db]));
        }
    }
    all
}

#[test]
fn a_wall_is_the_same_to_the_last_bit_in_all_eight_orders() {
    let mut random = Random::new(3);
    for round in 0..50_000 {
        let map = DTrilinear::from(random.any_box());
        let wall = slice(&map, random.below(3), [0.0, 1.0][random.below(2)]);
        // A third of the rays aim at the outline, where the decision is closest.
        let (mut a, b) = (random.unit(), random.unit());
        if round % 3 == 0 {
            a = a.round();
        }
        let ray = random.ray_through(surface(wall, a, b), 3.0);
        let expected = wall_hits(&ray, wall);
        for (order, [first, da, _]) in orders(wall) {
            let hits = wall_hits(&ray, order);
            assert_eq!(hits.len(), expected.len());
            for (hit, reference) in hits.iter().zip(expected.iter()) {
                assert_eq!(hit.t.to_bits(), reference.t.to_bits());
                let mut ab = if da == 1 { [hit.a, hit.b] } else { [hit.b, hit.a] };
                for (bit, x) in ab.iter_mut().enumerate() {
                    *x = if first >> bit & 1 == 1 { 1.0 - *x } else { *x };
                }
                let difference = (ab[0] - reference.a).abs().max((ab[1] - reference.b).abs());
                assert!(difference < 1e-15, "{hit:?} {reference:?}");
                let mirrored = (first.count_ones() + u32::from(da == 2)) % 2 == 1;
                assert_eq!(hit.side, if mirrored { -reference.side } else { reference.side });
            }
        }
    }
}

#[test]
fn a_saddle_is_hit_twice() {
    // The saddle S = (a, b, a + b − 2ab), with two opposite corners up.
    let wall = [DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 1.0, 0.0)];
    // Along the diagonal a = b = s, z = 2s − 2s², which is 0.32 at s = 0.2 and s = 0.8.
    let ray = Ray::new(DVec3::new(-1.0, -1.0, 0.32), DVec3::new(1.0, 1.0, 0.0)).expect("a direction");
    let hits = wall_hits(&ray, wall);
    assert_eq!(hits.len(), 2);
    for (hit, s) in hits.iter().zip([0.2, 0.8]) {
        assert!((hit.a - s).abs() < 1e-15 && (hit.b - s).abs() < 1e-15);
        assert!((hit.t - (1.0 + s) * 2.0_f64.sqrt()).abs() < 1e-15);
    }
    // Above the saddle's ridge (z = ½ at s = ½) nothing.
    let above = Ray { origin: ray.origin + DVec3::Z * 0.2, ..ray };
    assert!(wall_hits(&above, wall).is_empty());
}

#[test]
fn degenerate_walls_never_yield_nan() {
    let mut random = Random::new(4);
    for round in 0..300_000 {
        // Corners from a 3³ lattice coincide, line up and lie in the rays' planes all the time.
        let mut lattice = || DVec3::from_array(core::array::from_fn(|_| random.below(3) as f64));
        let wall = [lattice(), lattice(), lattice(), lattice()];
        let (origin, mut towards) = (lattice(), lattice() - lattice());
        if round % 2 == 0 {
            towards += random.cube(1e-15);
        }
        let Some(ray) = Ray::new(origin, towards) else { continue };
        let hits = wall_hits(&ray, wall);
        let size = wall.iter().map(|p| p.distance(wall[0])).fold(0.0, f64::max);
        for hit in hits.iter() {
            assert!(
                hit.t.is_finite() && (0.0..=1.0).contains(&hit.a) && (0.0..=1.0).contains(&hit.b),
                "{hit:?}"
            );
            // Rays along edges are common here: the bound is √ε.
            let missed = surface(wall, hit.a, hit.b).distance(ray.at(hit.t));
            assert!(missed < 1e-7 * (1.0 + size), "{missed}: {wall:?} {ray:?}");
        }
        let again = orders(wall).into_iter().map(|(order, _)| wall_hits(&ray, order));
        for other in again {
            assert!(other.iter().map(|h| h.t.to_bits()).eq(hits.iter().map(|h| h.t.to_bits())));
        }
    }
}
