//! Where an operation acts.

use std::sync::Arc;

use pelage_geom::glam::Vec3;
use pelage_geom::{Attribute, MaterialId, Texture};
use pelage_skin::groom::{Channel, Mask, Operation, Region, Step, groom};
use pelage_skin::{Skin, SkinOptions, extrude, surface};

use crate::lawn::{close, keeping, lawn};

fn weights(skin: &Skin, masks: &[Mask]) -> Vec<f32> {
    // Moved by 1 m in full, a vertex tells its weight.
    let step = Step { operation: Operation::Move(Vec3::Z), masks: masks.to_vec() };
    let groomed = groom(skin, &[step], &keeping()).unwrap().skin;
    groomed.top.iter().zip(&skin.top).map(|(a, b)| a.z - b.z).collect()
}

#[test]
fn masks_fade_multiply_and_turn_round() {
    let skin = lawn();
    let sphere = Region::Sphere { centre: Vec3::ZERO, radius: 0.25, falloff: 0.5 };
    let inside = Region::Box { min: Vec3::new(0.0, -1.0, -2.0), max: Vec3::splat(2.0), falloff: 0.0 };
    let plain = weights(&skin, &[Mask::new(sphere.clone())]);
    let outside = weights(&skin, &[Mask::outside(sphere.clone())]);
    let product = weights(&skin, &[Mask::new(sphere), Mask::new(inside)]);
    for (i, p) in skin.base.iter().enumerate() {
        let x = ((p.length() - 0.25) / 0.5).clamp(0.0, 1.0);
        let expected = 1.0 - x * x * (3.0 - 2.0 * x);
        assert!(close(plain[i], expected, 1e-5), "{p} {}", plain[i]);
        assert!(close(outside[i], 1.0 - expected, 1e-5));
        assert!(close(product[i], if p.x >= 0.0 { expected } else { 0.0 }, 1e-5));
    }
}

#[test]
fn masks_by_material_attribute_and_image() {
    let mut mesh = surface::plane(2.0, 4, 4);
    mesh.faces[5].material = MaterialId(3);
    let values = mesh.positions.iter().map(|p| 0.5 * (p.x + 1.0)).collect();
    mesh.attributes.push(Attribute { name: "_LENGTH".into(), values });
    let skin = extrude(&mesh, &|_| true, &SkinOptions::new(0.1)).unwrap();
    let worn = weights(&skin, &[Mask::new(Region::Materials(vec![MaterialId(3)]))]);
    assert_eq!(worn.iter().filter(|w| **w == 1.0).count(), 4);
    let attribute = weights(&skin, &[Mask::new(Region::Attribute("_LENGTH".into()))]);
    // Two pixels, black and white in red: halfway between their centres u goes from 0 to 1 over half the width.
    let texture = Texture::new(2, 1, vec![Vec3::ZERO, Vec3::X]).unwrap();
    let image = Region::Image { texture: Arc::new(texture), channel: Channel::Red };
    let image = weights(&skin, &[Mask::new(image)]);
    for (i, p) in skin.base.iter().enumerate() {
        assert!(close(attribute[i], 0.5 * (p.x + 1.0), 1e-6));
        // Centres at u = ¼ and ¾; beyond them the image repeats, so at its ends it is the mean.
        let expected = [0.5, 0.0, 0.5, 1.0, 0.5][((p.x + 1.0) * 2.0).round() as usize];
        assert!(close(image[i], expected, 1e-5), "{p} {}", image[i]);
    }
    // Where triangles became quads, new vertices have the mean of those they stand between.
    let mut cut = mesh.clone();
    cut.uvs = None;
    cut.faces[0].vertices[3] = pelage_geom::Face::NONE;
    let skin = extrude(&cut, &|_| true, &SkinOptions::new(0.1)).unwrap();
    assert!(skin.report.refined && skin.base.len() > mesh.positions.len());
    for (w, p) in weights(&skin, &[Mask::new(Region::Attribute("_LENGTH".into()))]).iter().zip(&skin.base) {
        assert!(close(*w, 0.5 * (p.x + 1.0), 1e-6));
    }
}
