//! The schemas of the contract, which schemars makes from the types of requests and answers.

use crate::http::extract::parameter::Parameter;
use crate::http::extract::query::Query;
use schemars::generate::{Contract, SchemaSettings};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use strahl::scene::Format;
use strahl::scene::schema::schema;

/// Path of the components.
const COMPONENTS: &str = "#/components/schemas/";

/// Collects schemas.
#[derive(Debug)]
pub(crate) struct Schemas {
    answers: SchemaGenerator,
    bodies: SchemaGenerator,
}

impl Default for Schemas {
    fn default() -> Self {
        let generator = |contract: Contract| {
            let settings = SchemaSettings::draft2020_12().with(|settings| {
                settings.definitions_path = COMPONENTS.trim_start_matches('#').into();
                settings.contract = contract;
            });
            settings.into_generator()
        };
        Self { answers: generator(Contract::Serialize), bodies: generator(Contract::Deserialize) }
    }
}

impl Schemas {
    /// The schema of a type that is written.
    pub(crate) fn answer<T: JsonSchema>(&mut self) -> Value {
        self.answers.subschema_for::<T>().to_value()
    }

    /// The schema of a type that is read.
    pub(crate) fn body<T: JsonSchema>(&mut self) -> Value {
        self.bodies.subschema_for::<T>().to_value()
    }

    /// All components by name.
    pub(super) fn components(mut self) -> Map<String, Value> {
        let mut components = self.bodies.take_definitions(true);
        components.extend(self.answers.take_definitions(true));
        // Settings in an answer are those of scenes.
        let mut scene = schema().clone();
        rename_references(&mut scene);
        if let Some(Value::Object(parts)) = scene.as_object_mut().and_then(|scene| scene.remove("$defs")) {
            components.extend(parts);
        }
        for key in ["$schema", "$id"] {
            scene.as_object_mut().and_then(|scene| scene.remove(key));
        }
        components.insert("Scene".into(), scene);
        components.insert(
            "Bytes".into(),
            json!({ "type": "string", "format": "binary", "description": "Anything that is not JSON." }),
        );
        let overrides = Query::describe(|query| query.settings(Format::Json));
        components.insert("Overrides".into(), object("Settings over the scene's.", overrides));
        components.insert("PictureOutput".into(), object("How a picture is written.", Query::describe(Query::output)));
        components
    }
}

/// Query parameters as an object, since jobs take the settings and output of renders as JSON.
fn object(about: &str, parameters: Vec<Parameter>) -> Value {
    let property = |parameter: Parameter| {
        let mut schema = parameter.schema();
        schema["description"] = parameter.about.into();
        (parameter.name.to_owned(), schema)
    };
    let properties: Map<_, _> = parameters.into_iter().map(property).collect();
    json!({ "type": "object", "description": about, "properties": properties, "additionalProperties": false })
}

/// The schema of a scene inside of a body, whose type is raw JSON.
pub(crate) fn scene_reference(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "$ref": format!("{COMPONENTS}Scene") })
}

/// Any bytes.
pub(crate) fn bytes() -> Value {
    json!({ "$ref": format!("{COMPONENTS}Bytes") })
}

fn rename_references(value: &mut Value) {
    match value {
        Value::Object(object) => {
            if let Some(Value::String(reference)) = object.get_mut("$ref")
                && let Some(name) = reference.strip_prefix("#/$defs/")
            {
                *reference = format!("{COMPONENTS}{name}");
            }
            object.values_mut().for_each(rename_references);
        }
        Value::Array(values) => values.iter_mut().for_each(rename_references),
        _ => {}
    }
}
