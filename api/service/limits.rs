//! The service's limits and folders: one list for flags, checks and `GET /v1/limits`. Limits of scenes are in
//! `strahl::scene::limits`.

use super::addresses::Network;
use super::error::Error;
use super::values::{as_seconds, long_seconds, seconds};
use super::{memory, memory_budget};
use clap::{Args, value_parser};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Duration;
use strahl::film::Region;
use strahl::scene::description::ImageSize;
use strahl::scene::{Description, Scene};

/// Edge of a tile in pixels.
pub(crate) const TILE: u32 = 512;
/// Rays of one `POST /v1/rays`.
pub(crate) const MAX_RAYS: usize = 100_000;
/// Bytes of the answer to `POST /v1/rays` for each byte of the request.
pub(crate) const ANSWER_GROWTH: usize = 100;
/// Pixels of a part of a job's picture.
pub(crate) const PART_PIXELS: u64 = 4 << 20;
/// Most seconds of a trade-off, whatever the time limit of a request.
const MAX_TRADEOFF_SECONDS: f64 = 300.0;

/// Settings of the service.
#[derive(Debug, Clone, Args)]
#[group(skip)]
pub(crate) struct Settings {
    /// Limits of one answer.
    #[command(flatten)]
    pub(crate) answers: AnswerLimits,
    /// The caches.
    #[command(flatten)]
    pub(crate) caches: CacheLimits,
    /// Jobs.
    #[command(flatten)]
    pub(crate) jobs: JobLimits,
    /// What is delivered after jobs.
    #[command(flatten)]
    pub(crate) deliveries: DeliverySettings,
    /// Bytes of memory that requests, jobs, caches and the program take together. Caches give way; what has no room then is
    /// refused [default: three quarters of what the machine, or its container, has].
    #[arg(long, env = "STRAHL_MEMORY_BYTES", value_name = "BYTES", default_value_t = (memory::available() / 4 * 3).max(memory_budget::LEAST), hide_default_value = true, value_parser = value_parser!(u64).range(memory_budget::LEAST..), help_heading = "Memory")]
    pub(crate) memory_bytes: u64,
    /// Folder of pictures that scenes may name as textures. Without it scenes have to contain their textures.
    #[arg(long, env = "STRAHL_TEXTURES", value_name = "DIR", help_heading = "Folders")]
    pub(crate) textures: Option<PathBuf>,
}

/// Limits of one answer.
#[derive(Debug, Clone, Args, Serialize, JsonSchema)]
#[group(skip)]
#[command(next_help_heading = "Limits of one request")]
pub(crate) struct AnswerLimits {
    /// Pixels of one answer.
    #[arg(long, env = "STRAHL_MAX_PIXELS", value_name = "PIXELS", default_value_t = 8_300_000, value_parser = value_parser!(u64).range(1..))]
    pub(crate) max_pixels: u64,
    /// Samples of one answer: its pixels times the samples of each.
    #[arg(long, env = "STRAHL_MAX_SAMPLES_TOTAL", value_name = "SAMPLES", default_value_t = 64_000_000, value_parser = value_parser!(u64).range(1..))]
    pub(crate) max_samples_total: u64,
    /// Seconds after which a request is given up.
    #[arg(long, env = "STRAHL_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    #[serde(rename = "timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) timeout: Duration,
    /// Requests that may wait for the renderer; one more is answered with 503.
    #[arg(long, env = "STRAHL_QUEUE", default_value_t = 32, value_parser = value_parser!(u32).range(..=100_000))]
    pub(crate) queue: u32,
    /// Tiles that may wait for the renderer, at most 25 seconds each; one more is answered with 503.
    #[arg(long, env = "STRAHL_TILE_QUEUE", default_value_t = 512, value_parser = value_parser!(u32).range(..=100_000))]
    pub(crate) tile_queue: u32,
}

/// Sizes of the caches.
#[derive(Debug, Clone, Args, Serialize, JsonSchema)]
#[group(skip)]
#[command(next_help_heading = "Caches")]
pub(crate) struct CacheLimits {
    /// Bytes of built scenes in memory: another request about the same scene skips reading and building it. 0 keeps none.
    #[arg(long, env = "STRAHL_SCENE_CACHE_BYTES", value_name = "BYTES", default_value_t = 512 << 20)]
    pub(crate) scene_cache_bytes: u64,
    /// Bytes of finished pictures in memory. 0 keeps none.
    #[arg(long, env = "STRAHL_PICTURE_CACHE_BYTES", value_name = "BYTES", default_value_t = 256 << 20)]
    pub(crate) picture_cache_bytes: u64,
    /// Bytes of the scenes posted to /v1/scenes.
    #[arg(long, env = "STRAHL_KNOWN_SCENE_BYTES", value_name = "BYTES", default_value_t = 256 << 20)]
    pub(crate) known_scene_bytes: u64,
    /// Bytes of the assets of one tenant, which scenes name by their SHA-256. If there is no room, those that it needed longest
    /// ago go, but for what scenes of /v1/scenes and jobs name.
    #[arg(long, env = "STRAHL_ASSET_BYTES", value_name = "BYTES", default_value_t = 1 << 30)]
    pub(crate) asset_bytes: u64,
    /// Bytes of finished pictures in the folder of --cache.
    #[arg(long, env = "STRAHL_DISK_CACHE_BYTES", value_name = "BYTES", default_value_t = 10 << 30)]
    #[serde(skip)]
    pub(crate) disk_cache_bytes: u64,
    /// Folder where finished pictures and remembered scenes outlive the service: a new or empty one at first. Without it they
    /// are kept in memory only.
    #[arg(long, env = "STRAHL_CACHE", value_name = "DIR", help_heading = "Folders")]
    #[serde(skip)]
    pub(crate) cache: Option<PathBuf>,
}

/// Limits of jobs, and how long they are kept.
#[derive(Debug, Clone, Args, Serialize, JsonSchema)]
#[group(skip)]
#[command(next_help_heading = "Jobs")]
pub(crate) struct JobLimits {
    /// Jobs that wait or run; one more is answered with 503.
    #[arg(long, env = "STRAHL_JOBS", default_value_t = 10_000, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub(crate) jobs: u32,
    /// Pixels of a job's picture.
    #[arg(long, env = "STRAHL_JOB_MAX_PIXELS", value_name = "PIXELS", default_value_t = 100_000_000)]
    pub(crate) job_max_pixels: u64,
    /// Samples of a job's picture: its pixels times the samples of each.
    #[arg(long, env = "STRAHL_JOB_MAX_SAMPLES_TOTAL", value_name = "SAMPLES", default_value_t = 20_000_000_000)]
    pub(crate) job_max_samples_total: u64,
    /// Bytes of memory that running jobs may take together [default: half of what the machine, or its container, has].
    #[arg(long, env = "STRAHL_JOB_MEMORY_BYTES", value_name = "BYTES", default_value_t = memory::available() / 2, hide_default_value = true)]
    pub(crate) job_memory_bytes: u64,
    /// Bytes that the scenes and pictures of jobs may take on disk. If there is no room, the oldest pictures of the tenant that
    /// has most are deleted. The scene of one job may take half of it, and so may its tiles and its picture.
    #[arg(long, env = "STRAHL_DATA_BYTES", value_name = "BYTES", default_value_t = 10 << 30)]
    pub(crate) data_bytes: u64,
    /// Seconds that a job may run.
    #[arg(long, env = "STRAHL_JOB_TIMEOUT", value_name = "SECONDS", default_value = "3600", value_parser = seconds)]
    #[serde(rename = "job_timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) job_timeout: Duration,
    /// Seconds that a job's picture is kept.
    #[arg(long, env = "STRAHL_KEEP_PICTURES", value_name = "SECONDS", default_value = "604800", value_parser = long_seconds)]
    #[serde(rename = "keep_pictures_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) keep_pictures: Duration,
    /// Seconds that a job is remembered after its end, or after its picture was deleted.
    #[arg(long, env = "STRAHL_KEEP_RECORDS", value_name = "SECONDS", default_value = "86400", value_parser = long_seconds)]
    #[serde(rename = "keep_records_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) keep_records: Duration,
    /// Ended jobs of one tenant that are kept; of more, the oldest are forgotten.
    #[arg(long, env = "STRAHL_KEEP_JOBS", value_name = "JOBS", default_value_t = 10_000, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub(crate) keep_jobs: u32,
    /// Folder where jobs outlive the service: a new or empty one at first. Without it they are kept in a temporary folder and
    /// end with the service.
    #[arg(long, env = "STRAHL_DATA", value_name = "DIR", help_heading = "Folders")]
    #[serde(skip)]
    pub(crate) data: Option<PathBuf>,
    /// Whether jobs outlive the service.
    #[arg(skip)]
    pub(crate) durable: bool,
}

/// What is delivered after jobs: pictures to the store, messages to webhooks.
#[derive(Debug, Clone, Args, Serialize, JsonSchema)]
#[group(skip)]
#[command(next_help_heading = "Webhooks")]
pub(crate) struct DeliverySettings {
    /// Attempts to send a message to a webhook, or a picture to the store, before it is given up.
    #[arg(long, env = "STRAHL_WEBHOOK_ATTEMPTS", default_value_t = 10, value_parser = value_parser!(u32).range(1..=100))]
    pub(crate) webhook_attempts: u32,
    /// Seconds from the first attempt to the second. Each later one waits four times as long, up to an hour.
    #[arg(long, env = "STRAHL_WEBHOOK_RETRY", value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    #[serde(rename = "webhook_retry_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) webhook_retry: Duration,
    /// Seconds that a receiver may take to answer.
    #[arg(long, env = "STRAHL_WEBHOOK_TIMEOUT", value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    #[serde(rename = "webhook_timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) webhook_timeout: Duration,
    /// Messages of one tenant that are sent at one time.
    #[arg(long, env = "STRAHL_WEBHOOK_PARALLEL", value_name = "MESSAGES", default_value_t = 4, value_parser = value_parser!(u32).range(1..=1_000))]
    pub(crate) webhook_parallel: u32,
    /// Accept webhooks of http://, whose messages anybody on the way can read.
    #[arg(long, env = "STRAHL_WEBHOOK_HTTP")]
    pub(crate) webhook_http: bool,
    /// Networks of yours that webhooks may be in, with commas between: 10.1.0.0/16. All others that are not public are
    /// refused, with this machine.
    #[arg(long, env = "STRAHL_WEBHOOK_ALLOW", value_name = "CIDR,...", value_delimiter = ',')]
    #[serde(skip)]
    pub(crate) webhook_allow: Vec<Network>,
    /// File with the secret that signs messages where there are no --keys, as `strahl key webhook` makes one. With --keys each
    /// tenant has its own.
    #[arg(long, env = "STRAHL_WEBHOOK_SECRET_FILE", value_name = "FILE", conflicts_with = "keys")]
    #[serde(skip)]
    pub(crate) webhook_secret_file: Option<PathBuf>,
}

impl CacheLimits {
    /// Bytes of finished pictures on disk, if there is a folder for them.
    pub(crate) fn on_disk(&self) -> Option<u64> {
        self.cache.as_ref().map(|_| self.disk_cache_bytes)
    }
}

impl AnswerLimits {
    /// Refuses a region that is too much work for one answer.
    pub(crate) fn check(&self, region: Region, samples: u32) -> Result<(), Error> {
        let Region { width, height, .. } = region;
        let (pixels, max) = (region.pixels(), self.max_pixels);
        if pixels > max {
            let detail = format!(
                "{width} x {height} is {pixels} pixels; one answer has at most {max} (max_pixels): ask for a smaller size; \
                 a picture may also be a job (POST /v1/jobs), or come in tiles"
            );
            return Err(Error::Limit { name: "max_pixels", max, detail });
        }
        let (total, max) = (pixels.saturating_mul(u64::from(samples)), self.max_samples_total);
        if total > max {
            let detail = format!(
                "{pixels} pixels with {samples} samples each are {total} samples; one answer has at most {max} \
                 (max_samples_total): ask for fewer samples or a smaller size; a picture may also be a job (POST /v1/jobs), or come in \
                 tiles"
            );
            return Err(Error::Limit { name: "max_samples_total", max, detail });
        }
        Ok(())
    }

    /// Refuses a picture of a scene, or a region of it, before the scene is built. The default number of samples is known only
    /// afterwards.
    pub(crate) fn check_unbuilt(&self, scene: &Description, region: Option<Region>) -> Result<(), Error> {
        let ImageSize { width, height } = scene.image;
        let region = region.unwrap_or_else(|| Region::whole(width, height));
        // A region outside of the picture is reported as another problem.
        if !region.fits(width, height) {
            return Ok(());
        }
        self.check(region, scene.render.samples.unwrap_or(1))
    }

    /// Most pixels of one answer about a scene.
    pub(crate) fn max_area(&self, scene: &Scene) -> u64 {
        self.max_pixels.min(self.max_samples_total / u64::from(scene.samples))
    }

    /// Edge of the tiles of a scene's levels in pixels, a power of two: less than [`TILE`] where so many samples are more than
    /// one answer may have.
    pub(crate) fn tile_edge(&self, scene: &Scene) -> u32 {
        let most = self.max_area(scene).max(1);
        TILE.min(1 << (most.ilog2() / 2))
    }

    /// Most seconds of a trade-off. The rest of a request's time is for waiting and for writing the answer.
    pub(crate) fn tradeoff_seconds(&self) -> f64 {
        (self.timeout.as_secs_f64() * 2.0 / 3.0).min(MAX_TRADEOFF_SECONDS)
    }
}

impl JobLimits {
    /// Refuses a picture that is too much work for a job.
    pub(crate) fn check(&self, [width, height]: [u32; 2], samples: u32) -> Result<(), Error> {
        let pixels = u64::from(width) * u64::from(height);
        for (what, count, name, max) in [
            ("pixels", pixels, "job_max_pixels", self.job_max_pixels),
            ("samples", pixels.saturating_mul(u64::from(samples)), "job_max_samples_total", self.job_max_samples_total),
        ] {
            if count > max {
                let detail = format!("the picture has {count} {what}; that of a job has at most {max} ({name})");
                return Err(Error::Limit { name, max, detail });
            }
        }
        Ok(())
    }
}
