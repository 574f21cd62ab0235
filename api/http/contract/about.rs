//! What the service says about itself, for the contract.
#![allow(dead_code, reason = "only their descriptions are used")]

use serde::Serialize;
use std::collections::HashMap;
use utoipa::ToSchema;

/// What `/readyz` says.
#[derive(Debug, ToSchema)]
pub(crate) struct Readiness {
    /// `ready` or `draining`.
    status: String,
    /// Requests that are worked on.
    running: u64,
    /// Requests that wait.
    waiting: u64,
    /// Jobs: `waiting` and `running`.
    jobs: JobCounts,
}

/// How many jobs there are.
#[derive(Debug, ToSchema)]
pub(crate) struct JobCounts {
    /// Those that wait.
    waiting: u64,
    /// Those that are rendered.
    running: u64,
}

/// All limits by the names that problems quote.
#[derive(Debug, ToSchema)]
pub(crate) struct AllLimits {
    /// What one request may ask for; bytes, seconds (`_s`) and counts. Null: there is no such thing here.
    request: HashMap<String, Option<f64>>,
    /// What jobs may ask for.
    jobs: HashMap<String, LimitValue>,
    /// What whoever asks may have at one time. Null: as much as it likes.
    tenant: HashMap<String, Option<f64>>,
    /// What a scene may say.
    scene: HashMap<String, f64>,
}

/// A number, or whether something is so.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub(crate) enum LimitValue {
    /// Bytes, seconds or a count.
    Number(f64),
    /// `durable`: whether jobs outlive the process.
    Flag(bool),
}

/// The program and its renderer.
#[derive(Debug, ToSchema)]
pub(crate) struct Version {
    /// `strahl`.
    name: String,
    /// The program's version.
    version: String,
    /// Changes whenever pixels do.
    render_epoch: u32,
}

/// The formats that pictures may have.
#[derive(Debug, ToSchema)]
pub(crate) struct Formats {
    /// One by one.
    formats: Vec<FormatEntry>,
}

/// A format of pictures.
#[derive(Debug, ToSchema)]
pub(crate) struct FormatEntry {
    /// Its name in queries, and its file ending.
    name: String,
    /// Its media type.
    media_type: String,
    /// Whether it holds exactly the codes that were computed.
    lossless: bool,
    /// Whether it holds linear floats.
    linear: bool,
    /// Query parameters that are only for it, each as a JSON Schema.
    #[schema(value_type = HashMap<String, Object>)]
    parameters: HashMap<String, ()>,
}
