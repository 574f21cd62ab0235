//! The JSON Schema of scenes, made from the types of [`description`](super::description). Editors complete and check scenes
//! with it, and [`read`](super::read) explains broken scenes with it.

use super::Description;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
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

/// The schema of a type that is read.
pub(in crate::scene) fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12()
        .with_transform(RecursiveTransform(bound_integers))
        .with_transform(RecursiveTransform(join_lines));
    settings.into_generator().into_root_schema_for::<T>()
}

fn build() -> Value {
    let mut schema = schema_of::<Description>();
    schema.insert("$id".into(), "/schema/scene.json".into());
    schema.insert("title".into(), "strahl scene, version 1".into());
    schema.to_value()
}

/// `format` is only a hint in JSON Schema; a keyword has to refuse what does not fit into 32 bits.
fn bound_integers(schema: &mut Schema) {
    if schema.get("format").is_some_and(|format| format == "uint32") && schema.get("maximum").is_none() {
        schema.insert("maximum".into(), u32::MAX.into());
    }
}

/// Removes the line breaks of doc comments from descriptions.
fn join_lines(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    }
}

/// A schema, and the name of the nearest definition around it.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) struct Node<'s> {
    pub(in crate::scene) schema: &'s Value,
    pub(in crate::scene) name: &'s str,
}

impl<'s> Node<'s> {
    /// Follows references.
    pub(in crate::scene) fn resolve(self, root: &'s Value) -> Self {
        let mut node = self;
        while let Some(name) = node.schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            node = Node { schema: &root["$defs"][name], name };
        }
        node
    }

    /// The alternatives of a schema, those of alternatives included; the schema itself if it has none.
    pub(in crate::scene) fn alternatives(self, root: &'s Value) -> Vec<Self> {
        let node = self.resolve(root);
        match node.schema["oneOf"].as_array().or_else(|| node.schema["anyOf"].as_array()) {
            None => vec![node],
            Some(choices) => {
                choices.iter().flat_map(|schema| Node { schema, name: node.name }.alternatives(root)).collect()
            }
        }
    }

    /// The key of an alternative that is an object with just this key.
    pub(in crate::scene) fn tag(self) -> Option<&'s str> {
        match self.schema["required"].as_array().map(Vec::as_slice) {
            Some([tag]) if self.schema["properties"].as_object().is_some_and(|keys| keys.len() == 1) => tag.as_str(),
            _ => None,
        }
    }

    /// The strings it allows, if it lists them.
    pub(in crate::scene) fn words(self) -> Vec<&'s str> {
        let listed = self.schema["enum"].as_array().map_or(&[][..], Vec::as_slice);
        listed.iter().chain(self.schema.get("const")).filter_map(Value::as_str).collect()
    }

    /// Its JSON types.
    pub(in crate::scene) fn types(self) -> Vec<&'s str> {
        match &self.schema["type"] {
            Value::Array(types) => types.iter().filter_map(Value::as_str).collect(),
            name => name.as_str().into_iter().collect(),
        }
    }

    /// Whether it takes all numbers.
    pub(in crate::scene) fn is_any_number(self) -> bool {
        let bounds = ["minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"];
        self.schema["type"] == "number" && bounds.iter().all(|bound| self.schema.get(bound).is_none())
    }

    /// Whether it takes any value.
    pub(in crate::scene) fn is_anything(self) -> bool {
        self.types().is_empty()
    }

    /// Whether a value is of one of its types.
    pub(in crate::scene) fn takes(self, value: &Value) -> bool {
        self.types().iter().any(|name| match *name {
            "null" => value.is_null(),
            "boolean" => value.is_boolean(),
            "number" => value.is_number(),
            // As in serde, 5.0 is not an integer.
            "integer" => value.is_i64() || value.is_u64(),
            "string" => value.is_string(),
            "array" => value.is_array(),
            _ => value.is_object(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_a_schema_with_all_an_editor_shows() {
        assert!(jsonschema::meta::is_valid(schema()));
        assert_eq!(schema()["$schema"], "https://json-schema.org/draft/2020-12/schema");
        let described = |keys: &Value| {
            for (name, key) in keys.as_object().into_iter().flatten() {
                assert!(key["description"].as_str().is_some_and(|text| !text.contains('\n')), "{name}");
            }
        };
        described(&schema()["properties"]);
        described(&schema()["$defs"]);
        for definition in schema()["$defs"].as_object().unwrap().values() {
            described(&definition["properties"]);
        }
    }

    /// Ranges that the documentation of a key states have to be keywords, too.
    #[test]
    fn ranges_are_keywords() {
        for (name, definition) in schema()["$defs"].as_object().unwrap() {
            for (key, property) in definition["properties"].as_object().into_iter().flatten() {
                let text = property["description"].as_str().unwrap();
                let has = |keyword: &str| property.get(keyword).is_some();
                let ranged = property["type"] == "number" || property["type"] == "integer";
                let says = |phrase: &str| ranged && text.contains(phrase);
                assert!(!says("above 0") || has("exclusiveMinimum"), "{name} {key}");
                assert!(!says("at least 0") || has("minimum"), "{name} {key}");
                assert!(!says("at most") || has("maximum"), "{name} {key}");
                assert!(!says("below 180") || has("exclusiveMaximum"), "{name} {key}");
                assert!(!says(", 0 to") || (has("minimum") && has("maximum")), "{name} {key}");
            }
        }
    }

    #[test]
    fn text_is_the_schema() {
        assert_eq!(&serde_json::from_str::<Value>(&schema_text()).unwrap(), schema());
        assert!(schema_text().ends_with("}\n"));
    }
}
