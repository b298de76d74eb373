//! What a file tells about its texel, and the kind that grew it: JSON objects.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::FileError;
use crate::{Kind, Texel};

/// What is told about a texel, for people.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// Under which terms it may be used: best an SPDX expression, as in `CC0-1.0`.
    pub licence: String,
    /// What it was made from, in words: a file's name, a kind.
    pub origin: String,
    /// How it was made: names of options, and what they were set to.
    pub parameters: BTreeMap<String, String>,
}

/// What is not for people only.
#[derive(Serialize, Deserialize)]
pub(super) struct Properties {
    pub name: String,
    pub periodic: bool,
    pub specular: f32,
    pub roughness: f32,
}

#[derive(Serialize, Deserialize)]
struct Object<M> {
    texel: Properties,
    about: M,
}

/// The bytes of what is told about a texel.
pub(super) fn encode(texel: &Texel, metadata: &Metadata) -> serde_json::Result<Vec<u8>> {
    let Texel { periodic, specular, roughness, .. } = *texel;
    let texel = Properties { name: texel.name.clone(), periodic, specular, roughness };
    serde_json::to_vec(&Object { texel, about: metadata })
}

/// What `bytes` tell, or what is wrong with them.
pub(super) fn decode(bytes: &[u8]) -> Result<(Properties, Metadata), &'static str> {
    let object: serde_json::Result<Object<Metadata>> = serde_json::from_slice(bytes);
    object
        .map(|object| (object.texel, object.about))
        .map_err(|_| "are not the JSON object that they should be")
}

/// The bytes of a kind.
pub(super) fn encode_kind(kind: &Kind) -> serde_json::Result<Vec<u8>> {
    serde_json::to_vec(kind)
}

/// The kind that `bytes` describe, or what is wrong with them.
pub(super) fn decode_kind(bytes: &[u8]) -> Result<Kind, FileError> {
    serde_json::from_slice(bytes).map_err(|error| FileError::Kind { reason: error.to_string() })
}
