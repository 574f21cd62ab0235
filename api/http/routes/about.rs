//! The service's limits and version, the formats of pictures, the schema of scenes, the contract.

use crate::http::prelude::*;
use crate::http::settings::ConnectionLimits;
use crate::service::assets::ASSETS;
use crate::service::limits::{
    ANSWER_GROWTH, AnswerLimits, CacheLimits, DeliverySettings, JobLimits, MAX_RAYS, PART_PIXELS,
};
use crate::service::requests::compare::SEEN_PIXELS;
use crate::service::scenes::cache::PATCH_BYTES;
use crate::service::scenes::ids::MAX_ZOOM;
use axum::http::Extensions;
use serde_json::{Number, Value, json};
use std::collections::BTreeMap;
use strahl::film::{DEFAULT_QUALITY, PictureFormat};
use strahl::render::RENDER_EPOCH;
use strahl::scene::limits as scene;
use strahl::scene::schema::schema_text;
use strahl::sequence::FRAMES;

pub(super) fn routes() -> Vec<Route> {
    let object = |media_type| Content::of(media_type, |_| json!({ "type": "object" }));
    vec![
        Route::get(
            "/v1/limits",
            limits,
            ["limits", "service", "The limits of requests, of jobs, of scenes, and of the caller's tenant."],
        )
        .answer(200, "All limits by name", &[Content::json::<AllLimits<'_>>()]),
        Route::get(
            "/v1/version",
            version,
            ["version", "service", "The version of the service, and of what its pictures depend on."],
        )
        .answer(200, "Name and numbers", &[Content::json::<Version>()]),
        Route::get("/v1/formats", formats, ["formats", "service", "The formats of pictures."]).answer(
            200,
            "Names, media types and parameters",
            &[Content::json::<Formats>()],
        ),
        Route::get("/schema/scene.json", schema, ["sceneSchema", "service", "The JSON Schema of scenes."]).answer(
            200,
            "Draft 2020-12",
            &[object("application/schema+json")],
        ),
        Route::get("/openapi.json", openapi, ["openapi", "service", "This document."]).answer(
            200,
            "OpenAPI 3.1",
            &[object("application/json")],
        ),
    ]
}

/// All limits by the names that problems quote.
#[derive(Debug, Serialize, JsonSchema)]
struct AllLimits<'a> {
    /// Limits of one request: bytes, seconds (`_s`) and counts. Null: not available here.
    request: RequestLimits<'a>,
    /// Limits of jobs.
    jobs: &'a JobLimits,
    /// Limits of what is delivered after jobs.
    deliveries: DeliveryLimits<'a>,
    /// Concurrency limits of the caller's tenant, and units in a minute. Null: unlimited.
    tenant: TenantLimits,
    /// Limits of scenes.
    #[schemars(with = "BTreeMap<String, f64>")]
    scene: BTreeMap<&'static str, Number>,
}

/// What is delivered after jobs.
#[derive(Debug, Serialize, JsonSchema)]
struct DeliveryLimits<'a> {
    /// Whether pictures can be put into a store.
    store: bool,
    #[serde(flatten)]
    webhooks: &'a DeliverySettings,
}

/// What one request may ask for.
#[derive(Debug, Serialize, JsonSchema)]
struct RequestLimits<'a> {
    #[serde(flatten)]
    connection: &'a ConnectionLimits,
    #[serde(flatten)]
    answer: &'a AnswerLimits,
    #[serde(flatten)]
    caches: &'a CacheLimits,
    /// Number of the assets of one tenant.
    assets: usize,
    /// Bytes of finished pictures on disk.
    disk_cache_bytes: Option<u64>,
    /// Bytes of memory that requests, jobs and caches take together.
    memory_bytes: u64,
    /// Rays of one `POST /v1/rays`.
    max_rays: usize,
    /// Bytes of the answer to `POST /v1/rays`, as a multiple of those of the request.
    answer_growth: usize,
    /// Pixels of a part of a job's picture.
    part_pixels: u64,
    /// Bytes of the patch of a variation.
    patch_bytes: u64,
    /// Pixels of pictures that `POST /v1/compare` compares by FLIP and CIEDE2000.
    flip_pixels: u64,
    /// Seconds of one `POST /v1/tradeoff`.
    max_tradeoff_seconds: f64,
    /// Largest zoom: a scene may be opened as 2^zoom times its size.
    max_zoom: u32,
}

/// Limits of the caller's tenant.
#[derive(Debug, Serialize, JsonSchema)]
struct TenantLimits {
    /// Waiting and running jobs.
    jobs: u32,
    /// Open event streams.
    streams: u32,
    /// Units of cost in a minute: one for each request, and one for each million rays.
    units_per_minute: Option<u32>,
}

async fn limits(State(app): State<App>, extensions: Extensions) -> Response {
    let tenant = Tenant::of(&extensions);
    let counts = scene::ALL.into_iter().chain([FRAMES]).map(|limit| (limit.name, Number::from(limit.max)));
    let lengths = [("magnitude", scene::MAGNITUDE), ("smallest_length", scene::SMALLEST_LENGTH)];
    let lengths = lengths.into_iter().filter_map(|(name, length)| Some((name, Number::from_f64(length)?)));
    let settings = &app.service.settings;
    let request = RequestLimits {
        connection: &app.limits,
        answer: &settings.answers,
        caches: &settings.caches,
        assets: ASSETS,
        disk_cache_bytes: settings.caches.on_disk(),
        memory_bytes: settings.memory_bytes,
        max_rays: MAX_RAYS,
        answer_growth: ANSWER_GROWTH,
        part_pixels: PART_PIXELS,
        patch_bytes: PATCH_BYTES,
        flip_pixels: SEEN_PIXELS,
        max_tradeoff_seconds: settings.answers.tradeoff_seconds(),
        max_zoom: MAX_ZOOM,
    };
    let units_per_minute = tenant.rate_limit.as_ref().map(|limit| limit.per_minute);
    let tenant = TenantLimits { jobs: tenant.quotas.jobs, streams: tenant.quotas.streams, units_per_minute };
    let deliveries = DeliveryLimits { store: app.service.store.is_some(), webhooks: &settings.deliveries };
    let scene = counts.chain(lengths).collect();
    Json(AllLimits { request, jobs: &settings.jobs, deliveries, tenant, scene }).into_response()
}

/// The program and its renderer.
#[derive(Debug, Serialize, JsonSchema)]
struct Version {
    /// `strahl`.
    name: &'static str,
    /// The program's version.
    version: &'static str,
    /// Changes whenever a version renders other pixels.
    render_epoch: u32,
}

async fn version() -> Json<Version> {
    Json(Version { name: "strahl", version: env!("CARGO_PKG_VERSION"), render_epoch: RENDER_EPOCH })
}

/// The formats of pictures.
#[derive(Debug, Serialize, JsonSchema)]
struct Formats {
    /// All formats.
    formats: Vec<FormatEntry>,
}

/// A format of pictures.
#[derive(Debug, Serialize, JsonSchema)]
struct FormatEntry {
    /// Its name in queries, and its file ending.
    name: &'static str,
    /// Its media type.
    media_type: &'static str,
    /// Whether it holds exactly the codes that were computed.
    lossless: bool,
    /// Whether it holds linear floats.
    linear: bool,
    /// Query parameters for this format only, each as a JSON Schema.
    #[schemars(with = "BTreeMap<String, serde_json::Map<String, Value>>")]
    parameters: Value,
}

async fn formats() -> Json<Formats> {
    let entry = |format: PictureFormat| {
        let parameters = match format {
            PictureFormat::Png => json!({ "bits": { "enum": [8, 16], "default": 8 } }),
            PictureFormat::Jpg => json!({ "quality": { "minimum": 1, "maximum": 100, "default": DEFAULT_QUALITY } }),
            PictureFormat::Webp | PictureFormat::Exr | PictureFormat::Pfm => json!({}),
        };
        let (name, media_type) = format.names();
        FormatEntry { name, media_type, lossless: format != PictureFormat::Jpg, linear: format.is_linear(), parameters }
    };
    Json(Formats { formats: PictureFormat::ALL.map(entry).into() })
}

async fn schema() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/schema+json")], schema_text())
}

async fn openapi(State(app): State<App>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], app.contract.clone())
}
