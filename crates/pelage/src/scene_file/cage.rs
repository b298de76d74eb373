//! `cage = "top.obj"`, or a table with the mesh's name.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::{Deserialize, Deserializer, de};

/// A mesh of the same faces as the one that wears the skin; it stands where that one's geometry entry puts it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CageEntry {
    /// A path relative to the scene file.
    pub file: String,
    /// Which mesh of the file; by default the only one, or that of the same name as the mesh that wears the skin.
    #[serde(default)]
    pub mesh: Option<String>,
}

/// Reads a path, or a table.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<CageEntry>, D::Error> {
    struct Cage;
    impl<'de> de::Visitor<'de> for Cage {
        type Value = CageEntry;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a path, or a table with `file` and `mesh`")
        }

        fn visit_str<E: de::Error>(self, file: &str) -> Result<CageEntry, E> {
            Ok(CageEntry { file: file.to_owned(), mesh: None })
        }

        fn visit_map<A: de::MapAccess<'de>>(self, table: A) -> Result<CageEntry, A::Error> {
            CageEntry::deserialize(MapAccessDeserializer::new(table))
        }
    }
    deserializer.deserialize_any(Cage).map(Some)
}
