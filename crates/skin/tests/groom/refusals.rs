//! What makes no sense is named.

use std::sync::Arc;

use pelage_geom::Texture;
use pelage_geom::glam::{Vec2, Vec3};
use pelage_skin::groom::{Channel, Comb, Field, GroomOptions, Mask, Operation, Region, Step, Tilt, groom};
use pelage_skin::{SkinError, SkinOptions, extrude, surface};

#[test]
fn what_makes_no_sense_is_named() {
    let mut bare = surface::plane(1.0, 2, 2);
    bare.uvs = None;
    let skin = extrude(&bare, &|_| true, &SkinOptions::new(0.1)).unwrap();
    let fails = |operation: Operation, masks: Vec<Mask>, message: &str| {
        let steps = [Step::everywhere(Operation::Scale(1.0)), Step { operation, masks }];
        let error = groom(&skin, &steps, &GroomOptions::default()).unwrap_err().to_string();
        assert_eq!(error, format!("groom[1]: {message}"));
    };
    fails(Operation::Scale(f32::NAN), vec![], "scale: must be positive and at most 1000");
    fails(
        Operation::Tilt(Tilt { towards: Vec3::ZERO, angle: 3.0 }),
        vec![],
        "tilt.towards: must be finite and not zero",
    );
    let uv = Operation::Comb(Comb { along: Field::Uv(Vec2::X), angle: 3.0 });
    fails(uv, vec![], "comb.along.uv: needs texture coordinates, and the mesh has none");
    let curve = Operation::Comb(Comb { along: Field::Curve(vec![Vec3::ONE]), angle: 3.0 });
    fails(curve, vec![], "comb.along.curve: must hold two different finite points or more");
    let scale = || Operation::Scale(2.0);
    let mask = |region: Region| vec![Mask::new(region)];
    fails(scale(), mask(Region::Patches(vec![4])), "mask: patch 4 does not exist: there are 4");
    fails(scale(), mask(Region::Attribute("_X".into())), "mask: the mesh has no vertex attribute `_X`");
    let texture = Arc::new(Texture::new(1, 1, vec![Vec3::ONE]).unwrap());
    fails(
        scale(),
        mask(Region::Image { texture, channel: Channel::Mean }),
        "mask: an image needs texture coordinates, and the mesh has none",
    );
    let options = GroomOptions { steepest: 100.0, ..GroomOptions::default() };
    assert!(matches!(groom(&skin, &[], &options), Err(SkinError::Option { option: "steepest", .. })));
}
