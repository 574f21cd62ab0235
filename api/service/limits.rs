//! What one request may ask of the service. What a scene may say is in `strahl::scene::limits`.

use super::jobs::JobLimits;
use super::memory;
use crate::cli::ServeArgs;
use crate::http::auth::tenant::Tenant;
use crate::http::problem::{Kind, Problem};
use crate::service::scenes::ids::MAX_ZOOM;
use serde_json::{Value, json};
use std::time::Duration;
use strahl::film::Region;
use strahl::scene::{Scene, limits as scene};

/// Rays of one `POST /v1/rays`.
pub(crate) const MAX_RAYS: usize = 100_000;
/// Seconds of one `POST /v1/tradeoff`, however long a request may take.
const MAX_TRADEOFF_SECONDS: f64 = 300.0;
/// Bodies of the largest size that memory is set aside for.
const BODIES: u64 = 8;

/// Limits by the names that errors quote.
#[derive(Debug)]
pub(crate) struct Limits {
    pub(crate) max_body_bytes: u64,
    /// Bytes of all bodies and answers together.
    pub(crate) memory_bytes: u64,
    pub(crate) body_timeout: Duration,
    timeout: Duration,
    header_timeout: Duration,
    write_timeout: Duration,
    queue: u32,
    max_pixels: u64,
    max_samples_total: u64,
    scene_cache_bytes: u64,
    picture_cache_bytes: u64,
    known_scene_bytes: u64,
    disk_cache_bytes: Option<u64>,
    tile_queue: u32,
    /// Tiles of one client at one time.
    pub(crate) client_tiles: u32,
    job_max_pixels: u64,
    job_max_samples_total: u64,
    /// Bytes that open jobs may take together.
    pub(crate) job_memory_bytes: u64,
    /// Bytes of all files of jobs.
    pub(crate) data_bytes: u64,
    jobs: u32,
    job_timeout: Duration,
    keep_pictures: Duration,
    keep_records: Duration,
    is_durable: bool,
}

impl Limits {
    /// As the command line says.
    pub(crate) fn new(args: &ServeArgs) -> Self {
        Self {
            max_body_bytes: args.max_body_bytes,
            memory_bytes: args.max_body_bytes.saturating_mul(BODIES).max(512 << 20),
            body_timeout: args.body_timeout,
            timeout: args.timeout,
            header_timeout: args.header_timeout,
            write_timeout: args.write_timeout,
            queue: args.queue,
            max_pixels: args.max_pixels,
            max_samples_total: args.max_samples_total,
            scene_cache_bytes: args.scene_cache_bytes,
            picture_cache_bytes: args.picture_cache_bytes,
            known_scene_bytes: args.known_scene_bytes,
            disk_cache_bytes: args.cache.as_ref().map(|_| args.disk_cache_bytes),
            tile_queue: args.tile_queue,
            client_tiles: args.client_tiles,
            job_max_pixels: args.job_max_pixels,
            job_max_samples_total: args.job_max_samples_total,
            job_memory_bytes: args.job_memory_bytes.unwrap_or_else(|| memory::available() / 2),
            data_bytes: args.data_bytes,
            jobs: args.jobs,
            job_timeout: args.job_timeout,
            keep_pictures: args.keep_pictures,
            keep_records: args.keep_records,
            is_durable: args.data.is_some(),
        }
    }

    /// Refuses a region that is too much work for one answer.
    pub(crate) fn check(&self, scene: &Scene, region: Region) -> Result<(), Problem> {
        let pixels = u64::from(region.width) * u64::from(region.height);
        if pixels > self.max_pixels {
            let detail = format!(
                "{} x {} is {pixels} pixels; one answer has at most {} (max_pixels): ask for tiles",
                region.width, region.height, self.max_pixels
            );
            return Err(Problem::limit(Kind::CostLimit, "max_pixels", self.max_pixels, detail));
        }
        let samples = pixels * u64::from(scene.samples);
        if samples > self.max_samples_total {
            let detail = format!(
                "{pixels} pixels with {} samples each are {samples} samples; one answer has at most {} \
                 (max_samples_total): ask for tiles or fewer samples",
                scene.samples, self.max_samples_total
            );
            return Err(Problem::limit(Kind::CostLimit, "max_samples_total", self.max_samples_total, detail));
        }
        Ok(())
    }

    /// Pixels that one answer about a scene may have.
    pub(crate) fn max_area(&self, scene: &Scene) -> u64 {
        self.max_pixels.min(self.max_samples_total / u64::from(scene.samples))
    }

    /// Refuses a picture that is too much work for a job.
    pub(crate) fn check_job(&self, scene: &Scene) -> Result<(), Problem> {
        let pixels = u64::from(scene.width) * u64::from(scene.height);
        for (what, count, name, max) in [
            ("pixels", pixels, "job_max_pixels", self.job_max_pixels),
            ("samples", pixels * u64::from(scene.samples), "job_max_samples_total", self.job_max_samples_total),
        ] {
            if count > max {
                let detail = format!("the picture has {count} {what}; that of a job has at most {max} ({name})");
                return Err(Problem::limit(Kind::CostLimit, name, max, detail));
            }
        }
        Ok(())
    }

    /// Limits that jobs know themselves.
    pub(crate) fn of_jobs(&self) -> JobLimits {
        JobLimits {
            jobs: self.jobs as usize,
            memory_bytes: self.job_memory_bytes,
            data_bytes: self.data_bytes,
            timeout: self.job_timeout,
            keep_pictures: self.keep_pictures,
            keep_records: self.keep_records,
        }
    }

    /// Seconds that one trade-off may ask for: some of the time of any request is left for waiting and for writing it down.
    pub(crate) fn tradeoff_seconds(&self) -> f64 {
        (self.timeout.as_secs_f64() * 2.0 / 3.0).min(MAX_TRADEOFF_SECONDS)
    }

    /// `GET /v1/limits`, for whoever asks.
    pub(crate) fn to_json(&self, tenant: &Tenant) -> Value {
        let scene_limits = [
            scene::SCENE_BYTES,
            scene::JSON_DEPTH,
            scene::NESTING,
            scene::OBJECTS,
            scene::TRIANGLES,
            scene::LIGHTS,
            scene::POLYGON_VERTICES,
            scene::EXPANDED_PRIMITIVES,
            scene::IMAGE_SIDE,
            scene::PIXELS,
            scene::SAMPLES,
            scene::MAX_DEPTH,
            scene::RAYS_PER_SAMPLE,
            scene::TREE_RAYS,
            scene::PROBLEMS,
        ];
        let mut by_name: serde_json::Map<_, _> =
            scene_limits.iter().map(|limit| (limit.name.to_owned(), json!(limit.max))).collect();
        by_name.insert("magnitude".into(), json!(scene::MAGNITUDE));
        by_name.insert("smallest_length".into(), json!(scene::SMALLEST_LENGTH));
        json!({
            "request": {
                "max_body_bytes": self.max_body_bytes,
                "memory_bytes": self.memory_bytes,
                "max_pixels": self.max_pixels,
                "max_samples_total": self.max_samples_total,
                "max_rays": MAX_RAYS,
                "max_tradeoff_seconds": self.tradeoff_seconds(),
                "scene_cache_bytes": self.scene_cache_bytes,
                "picture_cache_bytes": self.picture_cache_bytes,
                "known_scene_bytes": self.known_scene_bytes,
                "disk_cache_bytes": self.disk_cache_bytes,
                "max_zoom": MAX_ZOOM,
                "queue": self.queue,
                "tile_queue": self.tile_queue,
                "client_tiles": self.client_tiles,
                "header_timeout_s": self.header_timeout.as_secs_f64(),
                "body_timeout_s": self.body_timeout.as_secs_f64(),
                "write_timeout_s": self.write_timeout.as_secs_f64(),
                "timeout_s": self.timeout.as_secs_f64(),
            },
            "jobs": {
                "durable": self.is_durable,
                "jobs": self.jobs,
                "job_max_pixels": self.job_max_pixels,
                "job_max_samples_total": self.job_max_samples_total,
                "job_memory_bytes": self.job_memory_bytes,
                "data_bytes": self.data_bytes,
                "job_timeout_s": self.job_timeout.as_secs_f64(),
                "keep_pictures_s": self.keep_pictures.as_secs_f64(),
                "keep_records_s": self.keep_records.as_secs_f64(),
            },
            "tenant": {
                "jobs": tenant.quotas.jobs,
                "streams": tenant.quotas.streams,
                "units_per_minute": tenant.rate_limit.as_ref().map(|rate_limit| rate_limit.per_minute()),
            },
            "scene": by_name,
        })
    }
}
