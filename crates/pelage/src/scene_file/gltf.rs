//! The skins that a glTF file says its meshes and materials wear: the extension `PELAGE_skin`, or custom properties whose
//! names begin with `pelage_`. See `docs/gltf.md`.

use serde::Deserialize;

use super::source::{Node, Source, parse};
use super::{SceneFile, SkinEntry};
use crate::error::Error;
use crate::import::{Files, ImportOptions, gltf_text};

/// The extension's name.
pub(crate) const EXTENSION: &str = "PELAGE_skin";
/// How the names of custom properties begin.
const PREFIX: &str = "pelage_";

/// Everything in the file that says what grows.
#[derive(Deserialize)]
struct Skins {
    skin: Vec<SkinEntry>,
}

/// Gives the scene of a glTF file the skins that the file has.
///
/// # Errors
/// The file cannot be read; what it says of a skin does not make sense.
pub(super) fn dress(scene: SceneFile) -> Result<SceneFile, Error> {
    let files = Files::around(&scene.path, &[], ImportOptions::default().limits)?;
    let text = gltf_text(&scene.path, &files)?;
    // Most files have none, and what is no JSON is told of where the meshes are read.
    let Some(text) = std::str::from_utf8(&text).ok().filter(|t| t.contains(EXTENSION) || t.contains(PREFIX))
    else {
        return Ok(scene);
    };
    let Ok(root) = parse::json(text) else { return Ok(scene) };
    let found = found(&root);
    let labelled = found.iter().map(|Found { label, skin, .. }| (label.clone(), skin.clone())).collect();
    let own_text = scene.path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    let source = Source::of_skins(&scene.path, own_text.then_some(text), labelled);
    let Skins { mut skin } = source.read()?;
    let scene = SceneFile { source, ..scene };
    for (i, (skin, Found { wearers, .. })) in skin.iter_mut().zip(found).enumerate() {
        if !skin.on.is_empty() {
            let reason = "must be left out: what carries the skin wears it";
            return Err(scene.fault(format!("skin[{i}].on"), reason).into());
        }
        skin.on = wearers.map_err(|reason| scene.fault(format!("skin[{i}]"), reason))?;
    }
    let scene = SceneFile { skin, ..scene };
    scene.validate()?;
    Ok(scene)
}

/// A skin in a glTF file.
struct Found {
    /// What carries it, and what joins that to the names of fields.
    label: String,
    /// As in a scene file.
    skin: Node,
    /// The names of what wears it, or why there are none.
    wearers: Result<Vec<String>, String>,
}

fn found(root: &Node) -> Vec<Found> {
    let (nodes, meshes) = (root.list("nodes"), root.list("meshes"));
    let name_of = |node: &Node| {
        let mesh = node.index("mesh").and_then(|index| meshes.get(index));
        let name = node.text("name").or_else(|| mesh.and_then(|mesh| mesh.text("name")));
        name.map(str::to_owned).ok_or_else(|| "needs a name, and its node has none".to_owned())
    };
    let mut found = Vec::new();
    for (i, mesh) in meshes.iter().enumerate() {
        let wearers = || {
            let names: Result<Vec<String>, String> =
                nodes.iter().filter(|node| node.index("mesh") == Some(i)).map(name_of).collect();
            names.and_then(
                |names| if names.is_empty() { Err("no node has this mesh".into()) } else { Ok(names) },
            )
        };
        found.extend(carried("mesh", i, mesh, &wearers));
    }
    for (i, material) in root.list("materials").iter().enumerate() {
        let name = || material.text("name").map(|name| vec![name.to_owned()]);
        let wearers = || name().ok_or_else(|| "needs a name, and its material has none".to_owned());
        found.extend(carried("material", i, material, &wearers));
    }
    // What Blender calls an object.
    for (i, node) in nodes.iter().enumerate() {
        let wearers = || match node.index("mesh") {
            Some(_) => Ok(vec![name_of(node)?]),
            None => Err("the node has no mesh that could wear it".into()),
        };
        found.extend(carried("node", i, node, &wearers));
    }
    found
}

/// The skin that a mesh, material or node carries.
fn carried(
    kind: &str,
    index: usize,
    carrier: &Node,
    wearers: &dyn Fn() -> Result<Vec<String>, String>,
) -> Option<Found> {
    let name = carrier.text("name").map_or_else(|| index.to_string(), |name| format!("`{name}`"));
    if let Some(skin) = carrier.get("extensions").and_then(|extensions| extensions.get(EXTENSION)) {
        let label = format!("{kind} {name}: {EXTENSION}.");
        return Some(Found { label, skin: skin.clone(), wearers: wearers() });
    }
    let properties = carrier.get("extras")?;
    let mut skin = Node::table([]);
    let mut texel = None;
    for (name, value) in properties.entries() {
        match name.strip_prefix(PREFIX) {
            Some("texel") => texel = Some(texel_of(properties, value)),
            Some("resolution") | None => {}
            Some(field) => skin.put(field, value.clone()),
        }
    }
    if let Some(resolution) = properties.get("pelage_resolution") {
        let grown = || Node::table([("fur", Node::table([]).at(resolution))]).at(resolution);
        let texel = texel.get_or_insert_with(grown);
        let kind = texel.entries().next().map(|(kind, fields)| (kind.to_owned(), fields.clone()));
        match kind {
            Some((kind, mut fields)) if kind != "file" => {
                fields.put("resolution", resolution.clone());
                texel.put(&kind, fields);
            }
            // A file has its own: the skin has no such field, and that is what is told.
            _ => skin.put("resolution", resolution.clone()),
        }
    }
    if let Some(texel) = texel {
        skin.put("texel", texel);
    }
    skin.entries().next()?;
    Some(Found { label: format!("{kind} {name}: extras.{PREFIX}"), skin, wearers: wearers() })
}

/// What a word like `fur:plush` or `lawn.texel` says, as a table; any other value as it is, for the message.
fn texel_of(properties: &Node, value: &Node) -> Node {
    match properties.text("pelage_texel") {
        None => value.clone(),
        Some(file) if file.ends_with(".texel") => Node::table([("file", Node::text_at(file, value))]),
        Some(word) => match word.split_once(':') {
            Some((kind, preset)) => {
                Node::table([(kind, Node::table([("preset", Node::text_at(preset, value))]).at(value))])
                    .at(value)
            }
            None => Node::table([(word, Node::table([]).at(value))]).at(value),
        },
    }
}
