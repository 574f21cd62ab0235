//! The JSON Schema of scenes, made from the types of [`description`](super::description): what editors complete and
//! check with, and what [`diagnose`](super::diagnose) explains broken scenes with.

use super::Description;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::sync::OnceLock;

/// The schema, draft 2020-12.
pub fn schema() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(build)
}

/// The schema as the text of `api/scene.schema.json`.
pub fn schema_text() -> String {
    format!("{:#}\n", schema())
}

fn build() -> Value {
    let settings =
        SchemaSettings::draft2020_12().with_transform(schemars::transform::RecursiveTransform(bound_integers));
    let mut schema = settings.into_generator().into_root_schema_for::<Description>();
    schema.insert("$id".into(), "/schema/scene.json".into());
    schema.insert("title".into(), "strahl scene, version 1".into());
    schema.to_value()
}

/// `format` is only a hint in JSON Schema; what does not fit into 32 bits has to be refused by a keyword.
fn bound_integers(schema: &mut schemars::Schema) {
    if schema.get("format").is_some_and(|format| format == "uint32") && schema.get("maximum").is_none() {
        schema.insert("maximum".into(), u32::MAX.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn show() {
        println!("{}", schema_text());
    }
}
