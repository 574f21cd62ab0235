//! The record of a job, which is kept on disk.

use super::files::frame_name;
use super::outbox::Outbox;
use crate::service::clock::unix_time;
use crate::service::error::Error;
use crate::service::pictures::spec::PictureSpec;
use crate::service::sequences::Frames;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Not;
use strahl::film::FileFormat;
use strahl::scene::problem::Code;
use strahl::scene::{Format, Overrides, Problems};
use uuid::Uuid;

/// A job.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Record {
    /// A UUID of version 7, so that later jobs have greater ids.
    pub(crate) id: String,
    /// The tenant that owns it.
    pub(crate) tenant: String,
    /// The tenant's weight in the scheduler.
    pub(crate) weight: u32,
    /// Its state.
    pub(crate) state: State,
    /// 0 to 100.
    pub(crate) priority: u8,
    /// The owner's labels.
    pub(crate) labels: Vec<String>,
    /// What it renders.
    #[serde(rename = "order")]
    pub(crate) spec: JobSpec,
    /// Id of the scene with its settings, if the picture has an id.
    pub(crate) scene_id: Option<String>,
    /// Id of the picture, if it has one.
    pub(crate) image_id: Option<String>,
    /// Pixels across.
    pub(crate) width: u32,
    /// Pixels down.
    pub(crate) height: u32,
    /// Edge of a tile in pixels. 0: the picture is one tile.
    pub(crate) edge: u32,
    /// Estimated milliseconds on the whole pool.
    pub(crate) estimate_ms: f64,
    /// Estimated rays; 0 if unknown, as in records of versions before.
    #[serde(default)]
    pub(crate) estimate_rays: u64,
    /// Bytes of its built scene.
    pub(crate) scene_bytes: u64,
    /// Tells a repeated submission from a new one.
    pub(crate) idempotency: Option<Idempotency>,
    /// When it was accepted, in milliseconds since 1970.
    pub(crate) created: u64,
    /// When it was first started.
    pub(crate) started: Option<u64>,
    /// When it reached its final state.
    pub(crate) finished: Option<u64>,
    /// Milliseconds that services had run on the folder when it did. Versions before did not count them.
    #[serde(default)]
    pub(crate) ended: Option<u64>,
    /// The SHA-256 of each asset that its scene names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) assets: Vec<String>,
    /// The frames of a sequence, whose text is beside that of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) frames: Option<Frames>,
    /// Its cost.
    pub(crate) stats: Stats,
    /// Why it failed.
    pub(crate) failure: Option<Failure>,
    /// Number of restarts since it was accepted.
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
    /// What is delivered after its end.
    #[serde(default)]
    pub(crate) outbox: Outbox,
    /// In a farm: the front that works on it, or that has yet to remove what it leaves behind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) front: Option<String>,
    /// In a farm: fronts that have too little memory for it, and when the first one found out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) refused: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) refused_at: Option<u64>,
    /// In a farm: bytes of the text of its scene.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(crate) text_bytes: u64,
    /// In a farm: whether its owner does not want to see it any more. It goes when what it leaves behind is gone.
    #[serde(default, skip_serializing_if = "Not::not")]
    pub(crate) forgotten: bool,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

impl Record {
    /// Whether it needs the text of its scene.
    pub(super) fn needs_scene(&self) -> bool {
        self.state.needs_scene() && !self.forgotten
    }

    /// Whether it has a picture.
    pub(super) fn has_picture(&self) -> bool {
        self.state == State::Succeeded && !self.forgotten
    }

    /// Notes that the process has ended while it rendered this job, whose tiles took `tile_bytes`.
    pub(super) fn count_crash(&mut self, tile_bytes: u64) {
        self.crashes = if tile_bytes > self.tile_bytes { 0 } else { self.crashes + 1 };
        self.tile_bytes = tile_bytes;
    }

    /// Name of the picture's file: that of the picture, which several jobs may have, or else of the job.
    pub(crate) fn picture_name(&self) -> String {
        match &self.image_id {
            Some(image) => PictureSpec::plain(None, self.spec.output).name(image),
            None => self.id.clone(),
        }
    }

    /// Names of the files of its pictures: one, or one for each frame.
    pub(super) fn picture_names(&self) -> Vec<String> {
        match self.frames {
            Some(frames) => (0..frames.count).map(|number| frame_name(&self.id, number)).collect(),
            None => vec![self.picture_name()],
        }
    }

    /// Whether they are its own. A sequence has its frames from the beginning: some are finished while others are rendered.
    pub(crate) fn has_pictures(&self) -> bool {
        self.has_picture() || (self.frames.is_some() && !self.state.is_final() && !self.forgotten)
    }

    /// A waiting job that is accepted now.
    pub(crate) fn new(spec: JobSpec) -> Self {
        Self {
            id: Uuid::now_v7().to_string(),
            tenant: String::new(),
            weight: 1,
            state: State::Queued,
            priority: 0,
            labels: Vec::new(),
            spec,
            scene_id: None,
            image_id: None,
            width: 0,
            height: 0,
            edge: 0,
            estimate_ms: 0.0,
            estimate_rays: 0,
            scene_bytes: 0,
            idempotency: None,
            created: now(),
            started: None,
            finished: None,
            ended: None,
            assets: Vec::new(),
            frames: None,
            stats: Stats::default(),
            failure: None,
            lives: 0,
            crashes: 0,
            tile_bytes: 0,
            last_event: None,
            version: 1,
            outbox: Outbox::default(),
            front: None,
            refused: Vec::new(),
            refused_at: None,
            text_bytes: 0,
            forgotten: false,
        }
    }
}

/// State of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "JobState")]
pub(crate) enum State {
    /// Waits for its turn.
    Queued,
    /// Is being rendered.
    Running,
    /// The picture is finished.
    Succeeded,
    /// There is no picture; `failure` says why.
    Failed,
    /// The owner has canceled it.
    Canceled,
    /// The picture has been deleted to make room, or because it was old.
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

    /// Whether the state will not change any more, except by expiring.
    pub(crate) fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }

    /// Whether the scene may still have to be rendered, or a part of it again.
    pub(crate) fn needs_scene(self) -> bool {
        matches!(self, Self::Queued | Self::Running | Self::Succeeded)
    }

    /// Its name in JSON and events.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, state)| *state == self).map_or("", |(name, _)| name)
    }
}

/// What a job renders: a scene with settings, and the format of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct JobSpec {
    /// Name of the scene's file: the SHA-256 of its text.
    pub(crate) scene: String,
    /// The format of that text.
    pub(crate) format: Format,
    /// Settings that replace the scene's.
    pub(crate) settings: Overrides,
    /// Format of the picture.
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

impl Idempotency {
    /// A key, and the SHA-256 of what was submitted with it.
    pub(crate) fn of(key: &str, request: &str) -> Self {
        Self { key: key.to_owned(), request: request.to_owned() }
    }
}

/// Whether it can be the id of a job.
pub(crate) fn is_job_id(name: &str) -> bool {
    Uuid::try_parse(name).is_ok_and(|id| id.to_string() == name)
}

/// Cost of a job, over all restarts.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "JobStats")]
pub(crate) struct Stats {
    /// Milliseconds from acceptance until it was first started.
    pub(crate) queue_ms: f64,
    /// Milliseconds spent reading and building the scene, since the last restart.
    pub(crate) bvh_ms: f64,
    /// Milliseconds of tracing, since the last restart.
    pub(crate) render_ms: f64,
    /// Milliseconds of encoding the picture.
    pub(crate) encode_ms: f64,
    /// Rays of all tiles.
    pub(crate) rays: u64,
    /// Tiles that were finished before the last restart and not rendered again.
    pub(crate) tiles_recovered: u64,
    /// Bytes of the picture file.
    pub(crate) picture_bytes: u64,
    /// Whether the picture existed already and nothing was rendered.
    pub(crate) reused: bool,
}

/// Why a job failed, as in a problem document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Failure {
    /// Kind of problem. Its page is `/problems/{slug}`.
    pub(crate) slug: String,
    /// What is wrong and what to do.
    pub(crate) detail: String,
}

impl Failure {
    /// It is the service's fault.
    pub(super) fn internal(detail: &str) -> Self {
        Self { slug: "internal".into(), detail: detail.into() }
    }

    /// It takes more memory than there is.
    pub(super) fn too_large(detail: &str) -> Self {
        Self { slug: "cost-limit".into(), detail: detail.into() }
    }
}

impl From<&Problems> for Failure {
    /// Text that is no JSON or NFF is another kind of problem than an invalid scene.
    fn from(problems: &Problems) -> Self {
        let slug = match problems.0.first().map(|first| first.code) {
            Some(Code::InvalidJson) => "invalid-json",
            Some(Code::InvalidNff) => "invalid-nff",
            Some(Code::OtherFormat) => "unsupported-media-type",
            Some(Code::MissingAsset) => "assets-missing",
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
            Error::Limit { detail, .. } => Self::too_large(detail),
            _ => Self { slug: "internal".into(), detail: "the scene cannot be built".into() },
        }
    }
}

/// Milliseconds since 1970.
pub(crate) fn now() -> u64 {
    u64::try_from(unix_time().as_millis()).unwrap_or(u64::MAX)
}
