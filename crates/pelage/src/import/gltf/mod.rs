//! glTF 2.0, text or binary. [glTF]
//!
//! The JSON comes through the `gltf` crate's own structures; indices, offsets and numbers are checked here, where
//! the crate's accessors would panic on bad ones or leave geometry out.

mod attributes;
mod buffers;
mod geometry;
mod material;

use std::path::Path;

use glam::{Mat4, Quat, Vec3};
use gltf::json;
use json::extensions::scene::khr_lights_punctual;
use json::validation::Checked;
use pelage_tracer::{Camera, Light};

use super::{Fault, Files, ImportError, ImportOptions, Imported, Place, Warning};
use crate::scene_file::EXTENSION;
use buffers::Document;
pub(crate) use buffers::text;
use geometry::Pose;
use material::Materials;

/// Extensions that a file may require: understood, or harmless to the geometry.
const SUPPORTED: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    EXTENSION,
];

/// The sun's angle as seen from the earth, in radians: glTF's directional lights have none of their own.
const SUN_ANGLE: f32 = 0.53 * std::f32::consts::PI / 180.0;

pub(super) fn read(path: &Path, files: &Files, options: &ImportOptions) -> Result<Imported, ImportError> {
    let document = Document::open(path, files)?;
    let supported = |name: &&String| SUPPORTED.contains(&name.as_str());
    if let Some(name) = document.root.extensions_required.iter().find(|name| !supported(name)) {
        return Err(
            Fault::RequiredExtension(name.clone()).at(path, Place::Field("extensionsRequired".into()))
        );
    }
    let mut warnings = Vec::new();
    for name in document.root.extensions_used.iter().filter(|name| !supported(name)) {
        warnings.push(Warning {
            file: path.to_owned(),
            place: Place::Field("extensionsUsed".into()),
            message: format!("`{name}` is not supported: what it adds is left out"),
        });
    }
    if let Some(field) = unlisted_skin(&document.root) {
        let message = format!("has `{EXTENSION}`, which `extensionsUsed` should list");
        warnings.push(Warning { file: path.to_owned(), place: Place::Field(field), message });
    }
    let materials = Materials::read(&document, options.content, &mut warnings)?;
    let imported = Imported { warnings, ..Imported::default() };
    let mut importer =
        Importer { document, materials, unit: options.unit, content: options.content, faces: 0, imported };
    let globals = importer.walk()?;
    for (node, &global) in globals.iter().enumerate() {
        if let Some(global) = global {
            importer.node(node, global, &globals)?;
        }
    }
    let Importer { mut imported, materials, .. } = importer;
    imported.materials = materials.list;
    imported.textures = materials.textures.list;
    Ok(imported)
}

/// What carries a skin in a file that does not say that it has any. [glTF §3.12]
fn unlisted_skin(root: &json::Root) -> Option<String> {
    if root.extensions_used.iter().any(|name| name == EXTENSION) {
        return None;
    }
    let of_mesh =
        |mesh: &json::Mesh| mesh.extensions.as_ref().is_some_and(|e| e.others.contains_key(EXTENSION));
    let of_material = |material: &json::Material| {
        material.extensions.as_ref().is_some_and(|e| e.others.contains_key(EXTENSION))
    };
    let mesh = root.meshes.iter().position(of_mesh).map(|i| format!("meshes[{i}]"));
    mesh.or_else(|| root.materials.iter().position(of_material).map(|i| format!("materials[{i}]")))
}

struct Importer<'a> {
    document: Document<'a>,
    materials: Materials,
    unit: f32,
    /// Whether lines and colours of vertices are wanted.
    content: bool,
    faces: u64,
    imported: Imported,
}

impl Importer<'_> {
    fn warn(&mut self, field: String, message: String) {
        let file = self.document.path.to_owned();
        self.imported.warnings.push(Warning { file, place: Place::Field(field), message });
    }

    fn count_faces(&mut self, faces: usize, field: &str) -> Result<(), ImportError> {
        self.faces += faces as u64;
        let limit = self.document.files.limits.faces;
        if self.faces > limit {
            return Err(self.document.fault(field, Fault::Limit { what: "faces", found: self.faces, limit }));
        }
        Ok(())
    }

    /// Node to scene, for every node of the scene. Iterative, because a file decides how deep it goes.
    fn walk(&self) -> Result<Vec<Option<Mat4>>, ImportError> {
        let document = &self.document;
        let nodes = &document.root.nodes;
        let limits = document.files.limits;
        if nodes.len() as u64 > limits.nodes {
            let fault = Fault::Limit { what: "nodes", found: nodes.len() as u64, limit: limits.nodes };
            return Err(document.fault("nodes", fault));
        }
        let mut globals = vec![None; nodes.len()];
        let unit = Mat4::from_scale(Vec3::splat(self.unit));
        let mut pending: Vec<_> = self.roots()?.into_iter().rev().map(|node| (node, unit, 1_u64)).collect();
        while let Some((index, parent, depth)) = pending.pop() {
            let field = format!("nodes[{index}]");
            let Some(node) = nodes.get(index) else {
                let fault = Fault::Index { what: "node", index: index as i64, count: nodes.len() };
                return Err(document.fault("nodes", fault));
            };
            if depth > limits.depth {
                let fault = Fault::Limit { what: "depth of the nodes", found: depth, limit: limits.depth };
                return Err(document.fault(field, fault));
            }
            let global = parent * local(node);
            if !global.is_finite() {
                return Err(document.fault(field, Fault::NotANumber("the node's transform".into())));
            }
            if globals[index].replace(global).is_some() {
                return Err(
                    document.fault(field, Fault::Syntax("has two parents, or is its own ancestor".into()))
                );
            }
            for child in node.children.iter().flatten().rev() {
                pending.push((child.value(), global, depth + 1));
            }
        }
        Ok(globals)
    }

    /// The roots of the scene that the file shows; without any scene, all nodes that are no other's child.
    fn roots(&self) -> Result<Vec<usize>, ImportError> {
        let root = &self.document.root;
        let scene = match root.scene {
            Some(index) => Some(self.document.get(&root.scenes, index, "scene", "scene")?),
            None => root.scenes.first(),
        };
        if let Some(scene) = scene {
            return Ok(scene.nodes.iter().map(|n| n.value()).collect());
        }
        let mut is_child = vec![false; root.nodes.len()];
        for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
            if let Some(flag) = is_child.get_mut(child.value()) {
                *flag = true;
            }
        }
        Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).collect())
    }

    /// What hangs on a node: a mesh, a camera, a light.
    fn node(&mut self, index: usize, global: Mat4, globals: &[Option<Mat4>]) -> Result<(), ImportError> {
        let node = self.document.root.nodes[index].clone();
        let field = format!("nodes[{index}]");
        if let Some(mesh_index) = node.mesh {
            let mesh = self.document.get(&self.document.root.meshes, mesh_index, "mesh", &field)?;
            let name = node.name.clone().or_else(|| mesh.name.clone()).unwrap_or_default();
            let weights = node.weights.clone().or_else(|| mesh.weights.clone()).unwrap_or_default();
            let joints = node.skin.map(|skin| self.joints(skin, globals, &field)).transpose()?;
            let skinned = joints.is_some();
            let pose = Pose { weights: &weights, joints };
            let strands = self.imported.strands.len();
            if let Some(mut mesh) = self.mesh(mesh_index.value(), &name, &pose)? {
                // A skinned mesh hangs on its joints; its node's own transform does not count.
                if !skinned {
                    mesh.transform(global);
                }
                self.imported.meshes.push(mesh);
            }
            if !skinned {
                self.imported.strands[strands..].iter_mut().for_each(|strand| strand.transform(global));
            }
        }
        if let Some(camera) = node.camera {
            let camera = self.document.get(&self.document.root.cameras, camera, "camera", &field)?;
            let name = node.name.clone().or_else(|| camera.name.clone()).unwrap_or_default();
            match camera.perspective.as_ref().map(|p| p.yfov) {
                Some(fov) if fov > 0.0 && fov < std::f32::consts::PI => {
                    let eye = global.w_axis.truncate();
                    let back = global.z_axis.truncate().normalize_or(Vec3::Z);
                    let camera = Camera::look_at(eye, eye - back, global.y_axis.truncate(), fov);
                    self.imported.cameras.push((name, camera));
                }
                _ => self.warn(field.clone(), format!("the camera `{name}` is no perspective one: left out")),
            }
        }
        if let Some(punctual) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) {
            let root = &self.document.root;
            let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
            let lights = lights.map_or(&[][..], |l| &l.lights);
            let light = self.document.get(lights, punctual.light, "light", &field)?;
            let light = light_of(light, global).map_err(|fault| self.document.fault(field, fault))?;
            self.imported.lights.push(light);
        }
        Ok(())
    }

    /// Joint to scene × inverse bind matrix, for each joint of a skin.
    fn joints(
        &self,
        skin: json::Index<json::Skin>,
        globals: &[Option<Mat4>],
        field: &str,
    ) -> Result<Vec<Mat4>, ImportError> {
        let skin = self.document.get(&self.document.root.skins, skin, "skin", field)?;
        let inverse_bind = match skin.inverse_bind_matrices {
            Some(accessor) => self.document.floats::<16>(accessor)?,
            None => Vec::new(),
        };
        let joint = |(i, node): (usize, &json::Index<json::Node>)| {
            let global = globals.get(node.value()).copied().flatten().ok_or_else(|| {
                let reason = format!("the joint nodes[{}] of its skin is not in the scene", node.value());
                self.document.fault(field, Fault::Syntax(reason))
            })?;
            Ok(global * inverse_bind.get(i).map_or(Mat4::IDENTITY, Mat4::from_cols_array))
        };
        skin.joints.iter().enumerate().map(joint).collect()
    }
}

/// Node to parent.
fn local(node: &json::Node) -> Mat4 {
    if let Some(matrix) = &node.matrix {
        return Mat4::from_cols_array(matrix);
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |q| Quat::from_array(q.0));
    // Quaternions in files are unit ones only nearly; a zero one turns nothing.
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { Quat::IDENTITY };
    Mat4::from_scale_rotation_translation(
        node.scale.map_or(Vec3::ONE, Vec3::from),
        rotation,
        node.translation.map_or(Vec3::ZERO, Vec3::from),
    )
}

/// A light of KHR_lights_punctual, which shines along its node's −Z. [KHRLights]
fn light_of(light: &khr_lights_punctual::Light, global: Mat4) -> Result<Light, Fault> {
    let power = Vec3::from(light.color).max(Vec3::ZERO) * light.intensity.max(0.0);
    if !power.is_finite() {
        return Err(Fault::NotANumber("the light's intensity".into()));
    }
    let position = global.w_axis.truncate();
    let direction = -global.z_axis.truncate().normalize_or(Vec3::Z);
    let Checked::Valid(kind) = light.type_ else {
        return Err(Fault::Syntax("the light has an unknown type".into()));
    };
    Ok(match kind {
        khr_lights_punctual::Type::Directional => {
            Light::Directional { direction, illuminance: power, angle: SUN_ANGLE }
        }
        khr_lights_punctual::Type::Point => Light::Point { position, intensity: power, radius: 0.0 },
        khr_lights_punctual::Type::Spot => {
            let spot = light.spot.clone().unwrap_or_default();
            let outer = spot.outer_cone_angle.clamp(1e-3, std::f32::consts::FRAC_PI_2);
            let inner = spot.inner_cone_angle.clamp(0.0, outer - 0.5e-3);
            if !(outer.is_finite() && inner.is_finite()) {
                return Err(Fault::NotANumber("the light's cone".into()));
            }
            Light::Spot { position, direction, intensity: power, inner, outer, radius: 0.0 }
        }
    })
}
