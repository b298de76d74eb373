//! Boxes that cross: what is in front is shown in front, pixel by pixel.

use pelage::geom::glam::{DVec3, Vec3};
use pelage::tracer::{Camera, Rays, Settings};
use pelage_tests::{one_box, picture, scene, sheet, texel};

/// A flat box around the plane through the z axis that is turned by `angle` about it, one solid sheet in its middle.
fn slab(angle: f32) -> pelage::skin::Skin {
    let (sin, cos) = angle.sin_cos();
    let (along, across) = (Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0));
    let corner = |x: f32, z: f32, h: f32| x * along + z * Vec3::Z + h * across;
    let face =
        |h: f32| [corner(-1.0, 1.0, h), corner(1.0, 1.0, h), corner(-1.0, -1.0, h), corner(1.0, -1.0, h)];
    one_box(face(-0.2), face(0.2))
}

#[test]
fn crossing_sheets_show_the_nearer_one_from_both_sides() {
    let red = texel(&sheet(0.5, 0.0, Vec3::X), 5, false);
    let green = texel(&sheet(0.5, 0.0, Vec3::Y), 5, false);
    let angles = [0.5_f32, -0.5];
    let scene = scene(vec![(slab(angles[0]), red), (slab(angles[1]), green)], vec![]);
    let size = [96, 96];
    // Without shadows: only what is in front matters here.
    let settings = Settings { size, rays: Rays::One, shadows: false, ..Settings::default() };
    for eye in [Vec3::new(0.3, 3.0, 0.4), Vec3::new(-0.2, -3.0, 0.3), Vec3::new(3.0, 0.2, 0.5)] {
        let camera = Camera::look_at(eye, Vec3::ZERO, Vec3::Z, 0.5);
        let film = picture(&scene, &camera, &settings);
        let mut seen = 0;
        for y in 0..size[1] {
            for x in 0..size[0] {
                let centre = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0).truncate();
                let (ray, _) = camera.cone(centre, size);
                // Where the ray meets each plane, and whether well inside the sheet's borders and well apart.
                let hit = |angle: f32| {
                    let normal = DVec3::new(-f64::from(angle.sin()), f64::from(angle.cos()), 0.0);
                    let t = -ray.origin.dot(normal) / ray.direction.dot(normal);
                    let p = ray.at(t);
                    let along = (p.x * p.x + p.y * p.y).sqrt();
                    (t > 0.0 && along < 0.95 && p.z.abs() < 0.95).then_some(t)
                };
                let near = match angles.map(hit) {
                    [Some(a), Some(b)] if (a - b).abs() > 0.05 => usize::from(b < a),
                    _ => continue,
                };
                let color = film.get(x, y).expect("inside").color;
                let (front, back) = if near == 0 { (color.x, color.y) } else { (color.y, color.x) };
                assert!(front > 0.9 && back < 0.02, "pixel {x}, {y} from {eye}: {color}, nearer is {near}");
                seen += 1;
            }
        }
        println!("from {eye}: {seen} pixels with both sheets, the nearer one shown in all");
        assert!(seen > 300);
    }
}
