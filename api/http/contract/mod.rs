//! The contract as OpenAPI 3.1, generated from the handlers: each says beside its code what it takes and answers
//! (`#[utoipa::path]`), and [`routes`](crate::http::routes) registers code and description in one step.
//!
//! A new handler needs `#[utoipa::path(...)]` above it and `.routes(routes!(handler))` in `routes.rs`; then
//! `strahl openapi > api/openapi.json`. What all operations share is added here: problems, keys, and the schemas that types have
//! themselves ([`generated`]).

pub(crate) mod about;
pub(crate) mod bodies;
pub(crate) mod generated;
pub(crate) mod jobs;
mod links;
pub(crate) mod pictures;
pub(crate) mod queries;

use crate::http::problem::Kind;
use crate::http::routes;
use serde_json::{Map, Value, json};
use std::sync::OnceLock;
use utoipa::OpenApi;

/// The document as the text of `api/openapi.json`.
pub(crate) fn openapi_text() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| format!("{:#}\n", document()))
}

fn document() -> Value {
    // A document of utoipa's own types always becomes JSON.
    let mut document = serde_json::to_value(routes::documented().into_openapi()).unwrap_or_default();
    document["info"] = json!({
        "title": "strahl",
        "version": env!("CARGO_PKG_VERSION"),
        "description": "A render service: a JSON scene in, a ray-traced picture and what it cost out.\n\n\
            Errors are problem documents (RFC 9457), each kind with a page at `/problems/{slug}`. Every answer has \
            `X-Request-Id`. `/v1/render` also takes the method QUERY (RFC 10008), which OpenAPI 3.1 cannot describe: \
            the same body and parameters, safe to repeat, with conditional requests.",
        "license": { "name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0" },
    });
    document["servers"] = json!([{ "url": "/", "description": "This service" }]);
    document["tags"] =
        json!(TAGS.map(|(name, description)| json!({ "name": name, "description": description })).as_slice());
    // Without keys the service asks for none; with keys the operations that say nothing else need one.
    document["security"] = json!([{ "key": [] }, {}]);
    document["components"]["securitySchemes"] = json!({
        "key": { "type": "http", "scheme": "bearer", "description": "A key as `strahl key new` prints it." }
    });
    add_examples(&mut document);
    add_slugs(&mut document);
    add_generated(&mut document);
    add_links(&mut document);
    add_problems(&mut document);
    document
}

/// What no handler mentions by itself.
#[derive(Debug, OpenApi)]
#[openapi(components(schemas(bodies::ProblemDocument), responses(bodies::Picture)))]
pub(crate) struct Shared;

/// What operations are grouped by.
const TAGS: [(&str, &str); 5] = [
    ("render", "A scene in, an answer at once"),
    ("jobs", "Renders that take longer: submitted, watched, fetched"),
    ("pictures", "Known scenes and pictures by their ids"),
    ("tiles", "Deep zoom: IIIF, DZI, XYZ"),
    ("service", "About the service itself"),
];

/// What schemars makes of types becomes components.
fn add_generated(document: &mut Value) {
    let parameters = generated::parameters(document);
    let components = &mut document["components"]["schemas"];
    for (name, definition) in generated::definitions() {
        components[name] = definition;
    }
    for (name, object) in parameters {
        components[name] = object;
    }
    rename_references(components);
}

fn rename_references(value: &mut Value) {
    match value {
        Value::Object(object) => {
            if let Some(Value::String(reference)) = object.get_mut("$ref")
                && let Some(name) = reference.strip_prefix("#/$defs/")
            {
                *reference = format!("#/components/schemas/{name}");
            }
            object.values_mut().for_each(rename_references);
        }
        Value::Array(values) => values.iter_mut().for_each(rename_references),
        _ => {}
    }
}

/// Something to begin with, wherever a scene is asked for.
fn add_examples(document: &mut Value) {
    let scene = json!({
        "version": 1,
        "image": { "width": 48, "height": 32 },
        "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
        "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1 } }],
    });
    let job = json!({ "scene": scene, "settings": { "width": 64 }, "output": { "format": "webp" }, "priority": 60 });
    let rays = json!({ "scene": scene, "rays": [{ "origin": [0, 1, 5], "direction": [0, 0, -1] }] });
    let nff = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nl 3 3 3\n\
               f 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";
    for operation in operations(document) {
        let Some(content) = operation.get_mut("requestBody").and_then(|body| body.get_mut("content")) else { continue };
        for (name, example) in [("Scene", &scene), ("JobRequest", &job), ("Questions", &rays)] {
            if content["application/json"]["schema"]["$ref"] == format!("#/components/schemas/{name}") {
                content["application/json"]["examples"] = json!({ "a ball": { "value": example } });
            }
        }
        if content["text/x-nff"].is_object() {
            content["text/x-nff"]["examples"] = json!({ "a ball": { "value": nff } });
        }
    }
}

/// The names that problems have.
fn add_slugs(document: &mut Value) {
    let slugs: Vec<_> = Kind::ALL.iter().map(|kind| kind.page().0).collect();
    document["paths"]["/problems/{slug}"]["get"]["parameters"][0]["schema"]["enum"] = json!(slugs);
}

fn operations(document: &mut Value) -> impl Iterator<Item = &mut Map<String, Value>> {
    let paths = document["paths"].as_object_mut().into_iter().flat_map(Map::values_mut);
    let items = paths.filter_map(Value::as_object_mut).flat_map(Map::values_mut);
    items.filter_map(Value::as_object_mut)
}

/// Where ids in an answer lead.
fn add_links(document: &mut Value) {
    for operation in operations(document) {
        let name = operation["operationId"].as_str().unwrap_or_default().to_owned();
        for (status, response) in operation["responses"].as_object_mut().into_iter().flatten() {
            let links = links::of(&name, status);
            if !links.is_empty() {
                response["links"] = links.into();
            }
        }
    }
}

/// Any operation may be answered by a problem.
fn add_problems(document: &mut Value) {
    document["components"]["responses"]["Problem"] = json!({
        "description": "A problem (RFC 9457): what is wrong, where, and what to do.",
        "headers": {
            "Retry-After": {
                "description": "Seconds until it makes sense to try again; with 429 and 503.",
                "schema": { "type": "integer", "minimum": 1, "maximum": 120 },
            },
        },
        "content": { "application/problem+json": { "schema": { "$ref": "#/components/schemas/ProblemDocument" } } },
    });
    let problem = json!({ "$ref": "#/components/responses/Problem" });
    for operation in operations(document) {
        for status in ["4XX", "5XX"] {
            operation["responses"][status] = problem.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that is referred to is there.
    #[test]
    fn references_lead_somewhere() {
        fn check(value: &Value, document: &Value) {
            match value {
                Value::Object(object) => {
                    if let Some(Value::String(reference)) = object.get("$ref") {
                        let pointer = reference.strip_prefix('#').unwrap_or_default();
                        assert!(document.pointer(pointer).is_some(), "{reference} leads nowhere");
                    }
                    object.values().for_each(|value| check(value, document));
                }
                Value::Array(values) => values.iter().for_each(|value| check(value, document)),
                _ => {}
            }
        }
        let document = document();
        check(&document, &document);
        assert!(document["components"]["schemas"]["Scene"]["properties"]["camera"].is_object());
    }

    #[test]
    fn operations_have_unique_ids_a_summary_and_a_known_tag() {
        let document = document();
        let mut ids = Vec::new();
        for (path, item) in document["paths"].as_object().unwrap() {
            for (method, operation) in item.as_object().unwrap() {
                ids.push(operation["operationId"].as_str().unwrap().to_owned());
                assert!(operation["summary"].is_string(), "{method} {path}");
                let tag = operation["tags"][0].as_str();
                assert!(TAGS.iter().any(|(known, _)| Some(*known) == tag), "{method} {path} has the tag {tag:?}");
            }
        }
        let all = ids.len();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), all, "{ids:?}");
    }
}
