//! Frames of a scene that moves: its ground waves, and everything that follows from that is made anew.

use std::path::Path;

use pelage::compile::Loaded;
use pelage::geom::glam::Vec3;
use pelage::scene_file::SceneFile;
use pelage::skin::{Mending, Motion};
use pelage::tracer::{Coat, Description, Scene, reference::Lighting};
use pelage::{Error, Field};

use super::measure::{median, picture, timed};
use super::report::Frame;
use crate::failure::Failure;

/// Where a point of the ground is in a frame: a wave of 8 cm runs along it.
fn moved(p: Vec3, frame: usize) -> Vec3 {
    p + Vec3::Y * (0.08 * (4.0 * p.x + 3.0 * p.z + 0.3 * frame as f32).sin())
}

/// Measures so many frames.
pub fn frames(file: &Path, count: usize) -> Result<Frame, Failure> {
    let loaded = Loaded::new(SceneFile::open(file)?)?;
    let (skins, texels) = (loaded.extrude()?, loaded.bake(&|_| ())?);
    let (imported, at_rest) = (loaded.imported.clone(), skins.clone());
    let mut prepared = loaded.compile(&texels, skins)?;
    let Lighting { lights, environment } = prepared.scene.lighting();
    let (Some(dressed), Some(texel)) = (at_rest.first(), texels.first().and_then(|list| list.first())) else {
        return Err(Failure::Usage("the scene has no skin".into()));
    };
    let mut taken: [Vec<f64>; 5] = Default::default();
    for frame in 0..count {
        let wave = |points: &[Vec3]| points.iter().map(|&p| moved(p, frame)).collect::<Vec<_>>();
        let ((meshes, base), deform) = timed(|| {
            let mut meshes = imported.meshes.clone();
            meshes.iter_mut().for_each(|mesh| mesh.positions = wave(&mesh.positions));
            Ok((meshes, wave(&dressed.skin.base)))
        })?;
        let (skin, certify) = timed(|| {
            let mut skin = dressed.skin.clone();
            skin.update(Motion::Surface(&base), &Mending::default())
                .map_err(|source| Error::Skin { field: Field::whole(file), source: Box::new(source) })?;
            Ok(skin)
        })?;
        let (scene, build) = timed(|| {
            Ok(Scene::new(Description {
                meshes,
                coats: vec![Coat {
                    skin,
                    texels: texel.clone().into(),
                    tint: Vec3::ONE,
                    wears_material: false,
                }],
                materials: imported.materials.clone(),
                textures: Vec::new(),
                lights: lights.clone(),
                environment,
            })?)
        })?;
        prepared.scene = scene;
        let (_, render) = picture(&prepared)?;
        let total = deform + certify + build + render;
        taken.iter_mut().zip([deform, certify, build, render, total]).for_each(|(list, s)| list.push(s));
    }
    let [deform, certify, build, render, total] = taken.map(|list| median(&list));
    Ok(Frame { deform, certify, build, render, total })
}
