//! What is known of a job, and outlives the process.

use crate::service::clock::unix_time;
use crate::service::error::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl::film::FileFormat;
use strahl::scene::problem::Code;
use strahl::scene::{Format, Overrides, Problems};

/// A job.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Record {
    /// A UUID of version 7: later jobs have greater ones.
    pub(crate) id: String,
    /// Whose it is.
    pub(crate) tenant: String,
    /// That tenant's share beside others.
    pub(crate) weight: u32,
    /// Where it stands.
    pub(crate) state: State,
    /// 0 to 100.
    pub(crate) priority: u8,
    /// What its owner calls it.
    pub(crate) labels: Vec<String>,
    /// What it renders.
    #[serde(rename = "order")]
    pub(crate) spec: JobSpec,
    /// Name of the scene with the settings in it, if its picture has a name.
    pub(crate) scene_id: Option<String>,
    /// Name of the picture, if it has one.
    pub(crate) image_id: Option<String>,
    /// Pixels across.
    pub(crate) width: u32,
    /// Pixels down.
    pub(crate) height: u32,
    /// Edge of a tile in pixels; the picture is one tile if it is 0.
    pub(crate) edge: u32,
    /// Milliseconds it should take on the whole pool.
    pub(crate) estimate_ms: f64,
    /// Bytes of its built scene.
    pub(crate) scene_bytes: u64,
    /// What makes a second submission the same as this one.
    pub(crate) idempotency: Option<Idempotency>,
    /// Milliseconds since 1970 when it was accepted.
    pub(crate) created: u64,
    /// When it was first begun.
    pub(crate) started: Option<u64>,
    /// When it reached its final state.
    pub(crate) finished: Option<u64>,
    /// What it took.
    pub(crate) stats: Stats,
    /// Why it failed.
    pub(crate) failure: Option<Failure>,
    /// How many processes have worked on it.
    pub(crate) lives: u64,
    /// How many processes ended while they rendered it, without a new tile.
    #[serde(default)]
    pub(crate) crashes: u32,
    /// Bytes of its tiles when a process last ended like that.
    #[serde(default)]
    pub(crate) tile_bytes: u64,
    /// Number of its last event, once it is final.
    pub(crate) last_event: Option<u64>,
    /// Grows with each change that its owner makes.
    pub(crate) version: u64,
}

impl Record {
    /// The process has ended while it rendered this job, which had tiles of so many bytes.
    pub(super) fn count_crash(&mut self, tile_bytes: u64) {
        self.crashes = if tile_bytes > self.tile_bytes { 0 } else { self.crashes + 1 };
        self.tile_bytes = tile_bytes;
    }
}

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "JobState")]
pub(crate) enum State {
    /// It waits.
    Queued,
    /// It is being rendered.
    Running,
    /// There is a picture.
    Succeeded,
    /// There is none, for a reason.
    Failed,
    /// Its owner wants it no more.
    Canceled,
    /// There was a picture.
    Expired,
}

impl State {
    /// All of them by name.
    pub(crate) const ALL: [(&str, Self); 6] = [
        ("queued", Self::Queued),
        ("running", Self::Running),
        ("succeeded", Self::Succeeded),
        ("failed", Self::Failed),
        ("canceled", Self::Canceled),
        ("expired", Self::Expired),
    ];

    /// Whether nothing more happens.
    pub(crate) fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }

    /// Whether it may still be rendered, or a part of it again.
    pub(crate) fn needs_scene(self) -> bool {
        matches!(self, Self::Queued | Self::Running | Self::Succeeded)
    }

    /// Its name in JSON and events.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, state)| *state == self).map_or("", |(name, _)| name)
    }
}

/// A scene, settings over it, and how the picture is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct JobSpec {
    /// Name of the file with the scene's text: its SHA-256.
    pub(crate) scene: String,
    /// The format of that text.
    pub(crate) format: Format,
    /// Settings over the scene's.
    pub(crate) settings: Overrides,
    /// How the picture is written.
    pub(crate) output: FileFormat,
}

/// A client's name for a submission, and a hash of what was submitted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Idempotency {
    /// The `Idempotency-Key`.
    pub(crate) key: String,
    /// SHA-256 of the request, in hexadecimal digits.
    pub(crate) request: String,
}

/// What a job took, in all processes that worked on it.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "JobStats")]
pub(crate) struct Stats {
    /// Milliseconds until it was first begun.
    pub(crate) queue_ms: f64,
    /// Milliseconds spent reading and building the scene, the last time.
    pub(crate) bvh_ms: f64,
    /// Milliseconds of tracing, as far as it is known which process did it: the last one's.
    pub(crate) render_ms: f64,
    /// Milliseconds of encoding the picture.
    pub(crate) encode_ms: f64,
    /// Rays of all tiles, those of a former process included.
    pub(crate) rays: u64,
    /// Tiles that a former process had finished, and that were not rendered again.
    pub(crate) tiles_recovered: u64,
    /// Bytes of the picture file.
    pub(crate) picture_bytes: u64,
    /// Whether the picture was there already, so that nothing was rendered.
    pub(crate) reused: bool,
}

/// Why a job failed, in the words of a problem document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Failure {
    /// The kind of problem: its page is `/problems/{slug}`.
    pub(crate) slug: String,
    /// What happened and what to do.
    pub(crate) detail: String,
}

impl From<&Problems> for Failure {
    /// Text that cannot even be read as its format is another kind of problem than a scene that is not valid.
    fn from(problems: &Problems) -> Self {
        let slug = match problems.0.first().map(|first| first.code) {
            Some(Code::InvalidJson) => "invalid-json",
            Some(Code::InvalidNff) => "invalid-nff",
            _ => "invalid-scene",
        };
        let first = problems.0.first().map_or_else(String::new, ToString::to_string);
        let detail = match problems.0.len() {
            0 | 1 => first,
            _ => format!("{} problems; the first: {first}", problems.count()),
        };
        Self { slug: slug.into(), detail }
    }
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        match error {
            Error::Scene(problems) => problems.into(),
            _ => Self { slug: "internal".into(), detail: "the scene cannot be built".into() },
        }
    }
}

/// Milliseconds since 1970.
pub(crate) fn now() -> u64 {
    u64::try_from(unix_time().as_millis()).unwrap_or(u64::MAX)
}
