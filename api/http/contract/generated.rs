//! Answers whose schemas come from the types that write them, as the scene's comes from those that read it: where handlers
//! name one of these, the document gets what schemars makes of the type.

use crate::service::pictures::report::Report;
use crate::service::scenes::prepared::Analyzed;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use strahl::inspect::query::RayAnswer as AnsweredRay;
use strahl::inspect::tree::Tree;
use strahl::plan::Plan;
use strahl::plan::estimate::Estimate as PlanEstimate;
use strahl::scene::problem::Problem;
use strahl::scene::schema::schema;
use strahl::tradeoff::Tradeoff as MeasuredTradeoff;
use utoipa::openapi::{ObjectBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// Query parameters that are about how a picture is written.
const OUTPUT: [&str; 3] = ["format", "bits", "quality"];

/// Names for handlers; what they stand for is put in by [`definitions`].
macro_rules! stand_ins {
    ($($(#[$about:meta])* $name:ident),+ $(,)?) => {$(
        $(#[$about])*
        #[derive(Debug)]
        pub(crate) struct $name;

        impl ToSchema for $name {}

        impl PartialSchema for $name {
            fn schema() -> RefOr<Schema> {
                ObjectBuilder::new().into()
            }
        }
    )+};
}

stand_ins! {
    /// A scene.
    Scene,
    /// The plan of a scene, with `actual` if it was carried out.
    Explained,
    /// The tree of rays behind a pixel.
    RayTree,
    /// What accuracy costs.
    Tradeoff,
    /// What a ray hits.
    RayAnswer,
    /// What the author of a scene should know.
    SceneProblem,
    /// Rays and milliseconds that a picture should take.
    Estimate,
    /// What a picture cost, and how far it may be from the exact one.
    CostReport,
    /// Settings over the scene's.
    Overrides,
    /// How a picture is written.
    PictureOutput,
}

/// Query parameters as objects: the settings and the output of a job are those of a render.
pub(crate) fn parameters(document: &Value) -> [(&'static str, Value); 2] {
    let object = |is_output: bool, about: &str| {
        let all = document["paths"]["/v1/render"]["post"]["parameters"].as_array().into_iter().flatten();
        let chosen =
            all.filter(|parameter| OUTPUT.contains(&parameter["name"].as_str().unwrap_or_default()) == is_output);
        let property = |parameter: &Value| {
            let mut schema = parameter["schema"].clone();
            schema["description"] = parameter["description"].clone();
            Some((parameter["name"].as_str()?.to_owned(), schema))
        };
        let properties: Map<String, Value> = chosen.filter_map(property).collect();
        json!({ "type": "object", "description": about, "properties": properties, "additionalProperties": false })
    };
    [
        ("Overrides", object(false, "Settings over the scene's.")),
        ("PictureOutput", object(true, "How a picture is written.")),
    ]
}

/// The definitions by name. They refer to each other as `#/$defs/NAME`.
pub(crate) fn definitions() -> Map<String, Value> {
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    generator.subschema_for::<Plan>();
    generator.subschema_for::<Analyzed<'_>>();
    generator.subschema_for::<PlanEstimate>();
    generator.subschema_for::<Tree>();
    generator.subschema_for::<MeasuredTradeoff>();
    generator.subschema_for::<AnsweredRay>();
    generator.subschema_for::<Problem>();
    generator.subschema_for::<Report>();
    let mut definitions = generator.take_definitions(true);
    let either = json!({
        "description": "The plan of a scene, with `actual` if it was carried out.",
        "anyOf": [{ "$ref": "#/$defs/Analyzed" }, { "$ref": "#/$defs/Plan" }],
    });
    definitions.insert("Explained".into(), either);
    // Settings in an answer are those that a scene may have.
    let mut scene = schema().clone();
    if let Some(Value::Object(parts)) = scene.as_object_mut().and_then(|scene| scene.remove("$defs")) {
        definitions.extend(parts);
    }
    for key in ["$schema", "$id"] {
        scene.as_object_mut().and_then(|scene| scene.remove(key));
    }
    definitions.insert("Scene".into(), scene);
    definitions
}
