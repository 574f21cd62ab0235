//! The contract as OpenAPI 3.1. It is made from the routes, which declare their requests and answers beside their handlers
//! ([`Route`]). Schemas are those of the types that are read and written.
//!
//! After a change: `strahl openapi > api/openapi.json`.

mod links;
mod route;
mod schemas;

pub(crate) use route::{Body, Content, Route, example_scene};
pub(crate) use schemas::scene_reference;

use super::problem::{Kind, ProblemDocument};
use schemas::Schemas;
use serde_json::{Map, Value, json};

/// Tags that group operations.
const TAGS: [(&str, &str); 6] = [
    ("render", "A scene in, an answer at once"),
    ("jobs", "Renders that take longer: submit, watch, fetch"),
    ("assets", "Files that scenes name by their SHA-256"),
    ("pictures", "Known scenes and pictures by their ids"),
    ("tiles", "Deep zoom: IIIF, DZI, XYZ"),
    ("service", "About the service itself"),
];

/// What the header `Render-Warnings` holds.
const WARNINGS: &str =
    "Up to twelve warnings about the scene, and whether there are more; `POST /v1/scenes/validate` has all.";

/// The document as the text of `api/openapi.json`.
pub(crate) fn openapi_text(routes: &[Route]) -> String {
    format!("{:#}\n", document(routes))
}

fn document(routes: &[Route]) -> Value {
    let mut schemas = Schemas::default();
    let mut paths = Map::new();
    for route in routes {
        let path = paths.entry(route.path.replace("{*", "{")).or_insert_with(|| json!({}));
        path[route.method] = route.operation(&mut schemas);
    }
    add_slugs(&mut paths);
    schemas.answer::<ProblemDocument>();
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "strahl",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "A render service: POST a JSON scene, get a ray-traced picture and what it cost.\n\n\
                Errors are problem documents (RFC 9457). Each kind has a page at `/problems/{slug}`. Every answer has \
                `X-Request-Id`. `/v1/render` also takes the method QUERY (RFC 10008), which OpenAPI 3.1 cannot describe: \
                the same body and parameters, safe to repeat, with conditional requests.",
            "license": { "name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0" },
        },
        "servers": [{ "url": "/", "description": "This service" }],
        "tags": TAGS.map(|(name, description)| json!({ "name": name, "description": description })).as_slice(),
        // Without a key file no key is needed. With one every operation needs a key, unless it declares otherwise.
        "security": [{ "key": [] }, {}],
        "paths": paths,
        "components": {
            "securitySchemes": {
                "key": { "type": "http", "scheme": "bearer", "description": "A key, as `strahl key new` prints it." }
            },
            "responses": { "Picture": picture(), "PictureOrParts": picture_or(&["multipart/mixed", "image/apng", "image/gif"]), "PictureOrAnimation": picture_or(&["image/apng"]), "Problem": problem() },
            "schemas": schemas.components(),
        },
    })
}

/// Lists the kinds of problems.
fn add_slugs(paths: &mut Map<String, Value>) {
    if let Some(slug) = paths.get_mut("/problems/{slug}").and_then(|path| path.pointer_mut("/get/parameters/0/schema"))
    {
        slug["enum"] = Kind::ALL.iter().map(|kind| kind.page().0).collect();
    }
}

/// The answer with a picture.
fn picture() -> Value {
    let header = |about: &str| json!({ "description": about, "schema": { "type": "string" } });
    let optional = |about: &str| json!({ "description": about, "schema": { "type": ["string", "null"] } });
    let file = json!({ "schema": { "$ref": "#/components/schemas/Bytes" } });
    let formats = strahl::film::PictureFormat::ALL.map(|format| (format.names().1.to_owned(), file.clone()));
    json!({
        "description": "The picture, in the format that `Accept` or `format` asks for.",
        "headers": {
            "Server-Timing": header("Milliseconds of queue, parse, plan, bvh, trace and encoding (png), and of antialiasing (refine), which is a part of trace."),
            "Render-Rays": header("Rays traced, by kind. `gathered` is there only if there are any."),
            "Render-Error": header("How far the picture may be from the exact one: `proved` 8-bit codes (or `?0`), the share of pixels proved `identical`, the `depth` of the proof if it has one, `estimated` codes."),
            "ETag": optional("The picture's name, known before it is rendered. Pictures that depend on a clock or on files have none."),
            "Content-Location": optional("Where this picture stays, as long as its scene is known."),
            "Repr-Digest": header("SHA-256 of the picture's file (RFC 9530)."),
            "Render-Plan": header("Effects that were simulated."),
            "Render-Warnings": optional(WARNINGS),
        },
        "content": Map::from_iter(formats),
    })
}

/// The answer with a picture, or with several in one of these forms.
fn picture_or(forms: &[&str]) -> Value {
    let mut response = picture();
    response["description"] =
        "The picture, in the format that `Accept` or `format` asks for, or several, without the headers \
                               of one."
            .into();
    for form in forms {
        response["content"][form] = json!({ "schema": { "$ref": "#/components/schemas/Bytes" } });
    }
    response
}

/// The answer of any operation that fails.
fn problem() -> Value {
    json!({
        "description": "A problem (RFC 9457): what is wrong, where, and what to do.",
        "headers": {
            "Accept-Encoding": {
                "description": "With 415 for a `Content-Encoding`: those that there are (RFC 9110 section 15.5.16).",
                "schema": { "type": "string" },
            },
            "Retry-After": {
                "description": "With 429 and 503: seconds to wait before the next try.",
                "schema": { "type": "integer", "minimum": 1 },
            },
        },
        "content": { "application/problem+json": { "schema": { "$ref": "#/components/schemas/ProblemDocument" } } },
    })
}
