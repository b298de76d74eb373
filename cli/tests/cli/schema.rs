//! `pelage schema` from outside.

use serde_json::Value;

use super::folder::Folder;

#[test]
fn the_schema_is_told_or_written() {
    let folder = Folder::new();
    let told = folder.told("schema");
    let schema: Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(folder.told("schema -o pelage.schema.json"), "");
    assert_eq!(folder.read("pelage.schema.json"), told.as_bytes());
    folder.fails("schema -o none/a.json", 3, "none/a.json: cannot be written");
}
