//! Jobs, for the contract.
#![allow(dead_code, reason = "only their descriptions are used")]

use super::generated::{CostReport, Overrides, PictureOutput, Scene};
use crate::service::jobs::record::{State, Stats};
use utoipa::ToSchema;

/// A job to be done.
#[derive(Debug, ToSchema)]
pub(crate) struct JobRequest {
    /// What to render.
    scene: Scene,
    /// Settings over the scene's, by the names of the query parameters of `POST /v1/render`.
    settings: Option<Overrides>,
    /// How the picture is written, by the names of the query parameters of `POST /v1/render`.
    output: Option<PictureOutput>,
    /// Among the tenant's jobs, 50 if it is not given.
    #[schema(minimum = 0, maximum = 100)]
    priority: Option<u8>,
    /// What its owner calls it.
    #[schema(max_items = 16)]
    labels: Option<Vec<String>>,
}

/// A job.
#[derive(Debug, ToSchema)]
pub(crate) struct JobView {
    /// A UUID of version 7.
    id: String,
    /// Where it stands.
    state: State,
    /// How far it is.
    progress: JobProgress,
    /// Its place among the tenant's waiting jobs, from 1.
    position: Option<u64>,
    /// Milliseconds until it should be done.
    eta_ms: Option<f64>,
    /// Milliseconds it should take on a machine that does nothing else.
    estimate_ms: f64,
    /// 0 to 100.
    priority: u8,
    /// What its owner calls it.
    labels: Vec<String>,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Edge of a tile in pixels; 0 if the picture is one tile.
    tile: u32,
    /// Name of the scene with the settings in it, if its picture has a name: those that a clock or files decide on have none.
    scene_id: Option<String>,
    /// Name of the picture, if it has one.
    image_id: Option<String>,
    /// Whose it is.
    tenant: String,
    /// When it was accepted (RFC 3339).
    created_at: String,
    /// When it was first begun.
    started_at: Option<String>,
    /// When it ended.
    finished_at: Option<String>,
    /// Until when it is kept.
    expires_at: Option<String>,
    /// Paths of what there is to see.
    links: JobLinks,
    /// What it took.
    stats: Stats,
    /// Why it failed.
    problem: Option<JobFailure>,
    /// Once it has succeeded, and only where one job is asked for: what the picture cost, and how far it may be from the exact one.
    report: Option<CostReport>,
}

/// Jobs, the newest first.
#[derive(Debug, ToSchema)]
pub(crate) struct JobList {
    /// The jobs.
    jobs: Vec<JobView>,
    /// `cursor` of the next page; null on the last one.
    next: Option<String>,
}

/// How far a job is.
#[derive(Debug, ToSchema)]
pub(crate) struct JobProgress {
    /// From 0 to 1.
    fraction: f64,
    /// Finished tiles.
    tiles_done: u64,
    /// All tiles.
    tiles_total: u64,
    /// Rays of the finished ones.
    rays: u64,
}

/// Paths of what there is to see of a job, and where its picture and tiles are if they have names.
#[derive(Debug, ToSchema)]
pub(crate) struct JobLinks {
    /// The job.
    #[schema(rename = "self")]
    this: String,
    /// What happens to it.
    events: String,
    /// The picture so far.
    preview: String,
    /// The picture.
    image: String,
    /// Stops it.
    cancel: String,
    /// The canonical text of its scene, with the settings in it.
    scene: Option<String>,
    /// The picture by its name.
    picture: Option<String>,
    /// The description of the image for IIIF.
    iiif: Option<String>,
    /// The description of the image for DZI.
    dzi: Option<String>,
    /// The description of the image's tiles for XYZ.
    xyz: Option<String>,
}

/// Why a job failed: a problem (RFC 9457).
#[derive(Debug, ToSchema)]
pub(crate) struct JobFailure {
    /// Path of the page about this kind of problem, `/problems/{slug}`.
    #[schema(value_type = String, format = "uri-reference", example = "/problems/render-deadline")]
    r#type: String,
    /// What kind of problem it is.
    title: String,
    /// The status that such a problem has as an answer.
    #[schema(minimum = 400, maximum = 599)]
    status: u16,
    /// What happened, and what to do.
    detail: String,
}
