//! What requests and answers of all kinds share, for the contract. Nothing here is ever made: handlers write these shapes by other means.
#![allow(dead_code, reason = "only their descriptions are used")]

use super::generated::{RayAnswer, SceneProblem};
use utoipa::{ToResponse, ToSchema};

/// Anything that is not JSON.
#[derive(Debug, ToSchema)]
#[schema(value_type = String, format = Binary)]
pub(crate) struct Bytes(Vec<u8>);

/// The picture, in the format that `Accept` or `format` asks for.
#[derive(Debug, ToResponse)]
#[response(
    description = "The picture, in the format that `Accept` or `format` asks for.",
    headers(
        ("Server-Timing" = String, description = "Milliseconds of queue, parse, plan, bvh, trace and encoding, and of antialiasing (refine), which is a part of trace."),
        ("Render-Rays" = String, description = "Rays traced, by kind; `gathered` only where there are any."),
        ("Render-Error" = String, description = "How far it may be from the truth: `proved` codes (or `?0`) and the share that is proved to be `identical`, `depth` where the proof has one, `estimated` codes."),
        ("ETag" = Option<String>, description = "The picture's name, known before it is rendered; pictures that a clock or files decide on have none."),
        ("Content-Location" = Option<String>, description = "Where this picture stays, as long as its scene is known."),
        ("Repr-Digest" = String, description = "SHA-256 of the picture's file (RFC 9530)."),
        ("Render-Plan" = String, description = "Effects that were simulated."),
        ("Render-Warnings" = Option<String>, description = "Up to five warnings about the scene; `POST /v1/scenes/validate` has all."),
    )
)]
pub(crate) enum Picture {
    /// sRGB, 8 or 16 bits.
    Png(#[content("image/png")] Bytes),
    /// sRGB, lossy.
    Jpeg(#[content("image/jpeg")] Bytes),
    /// sRGB, lossless.
    WebP(#[content("image/webp")] Bytes),
    /// Linear 32-bit floats.
    Exr(#[content("image/x-exr")] Bytes),
    /// Linear 32-bit floats.
    Pfm(#[content("image/x-portable-floatmap")] Bytes),
}

/// One of the Server-Sent Events of a stream (WHATWG HTML, 9.2).
#[derive(Debug, ToSchema)]
pub(crate) struct StreamedEvent {
    /// What `Last-Event-ID` and `since` name.
    id: Option<String>,
    /// Its name.
    event: Option<String>,
    /// A JSON object.
    data: Option<String>,
    /// Milliseconds to wait before connecting again.
    retry: Option<i64>,
}

/// XML.
#[derive(Debug, ToSchema)]
#[schema(value_type = String)]
pub(crate) struct Xml(String);

/// A problem (RFC 9457).
#[derive(Debug, ToSchema)]
pub(crate) struct ProblemDocument {
    /// Path of the page about this kind of problem, `/problems/{slug}`.
    #[schema(value_type = String, format = "uri-reference", example = "/problems/invalid-scene")]
    r#type: String,
    /// What kind of problem it is.
    title: String,
    /// The answer's status.
    #[schema(minimum = 400, maximum = 599)]
    status: u16,
    /// What is wrong with this request, and what to do.
    detail: String,
    /// The request's id, as in `X-Request-Id`.
    instance: String,
    /// Everything that is wrong, one by one, as far as the limit `problems` goes.
    errors: Option<Vec<ErrorEntry>>,
    /// The limit that was met; `/v1/limits` has all of them. With the limit `problems` there may be more errors.
    limit: Option<LimitEntry>,
    /// Formats there are, with 406.
    available: Option<Vec<String>>,
    /// The scope that the key lacks, with 403.
    scope: Option<String>,
    /// What to do instead, in one word.
    suggest: Option<String>,
}

/// One thing that is wrong.
#[derive(Debug, ToSchema)]
pub(crate) struct ErrorEntry {
    /// Its place in the body, a JSON pointer as a URI fragment.
    #[schema(example = "#/objects/3/sphere/radius")]
    pointer: Option<String>,
    /// The query parameter that is wrong.
    parameter: Option<String>,
    /// What kind of mistake it is.
    code: String,
    /// What is wrong, and what to do.
    detail: String,
    /// Line in the body, from 1.
    line: Option<u64>,
    /// Column in the line, from 1.
    column: Option<u64>,
}

/// A limit by name.
#[derive(Debug, ToSchema)]
pub(crate) struct LimitEntry {
    /// Its name in `/v1/limits`.
    name: String,
    /// The largest value allowed.
    max: u64,
}

/// A ray.
#[derive(Debug, ToSchema)]
pub(crate) struct RayQuestion {
    /// Where it begins.
    origin: [f64; 3],
    /// Where it goes; taken as given, t counts in its units.
    direction: [f64; 3],
    /// Hits nearer than this do not count.
    t_min: Option<f64>,
    /// Hits farther than this do not count; null is infinity.
    t_max: Option<f64>,
}

/// What the rays hit, in their order.
#[derive(Debug, ToSchema)]
pub(crate) struct Answers {
    /// One for each ray.
    answers: Vec<RayAnswer>,
}

/// What `POST /v1/scenes/validate` says of a valid scene.
#[derive(Debug, ToSchema)]
pub(crate) struct Valid {
    /// True; a scene that is not valid is a problem.
    valid: bool,
    /// What the author should know.
    warnings: Vec<SceneProblem>,
}
