//! `strahl serve`: its flags.

use super::values::{long_seconds, public_url, seconds, threads, word};
use crate::http::middleware::cors::Origins;
use clap::Args;
use schemars::JsonSchema;
use serde::Deserialize;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// `strahl serve`.
#[derive(Debug, Clone, Args)]
#[command(args_override_self = true)]
pub(crate) struct ServeArgs {
    /// Address and port to listen on; port 0 takes a free one. Beyond loopback it needs --keys or --insecure-no-auth.
    #[arg(long, env = "STRAHL_LISTEN", value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8080")]
    pub(crate) listen: SocketAddr,
    /// Configuration file: TOML with the names of these flags (max_pixels = 1000000); flags and environment go before it.
    #[arg(long, env = "STRAHL_CONFIG", value_name = "FILE.toml")]
    pub(crate) config: Option<PathBuf>,
    /// Address and port for operators, without keys: /livez, /readyz, /metrics. 127.0.0.1:9090 is usual; without it there is
    /// none, and /livez and /readyz are answered beside everything else.
    #[arg(long, env = "STRAHL_ADMIN_LISTEN", value_name = "ADDRESS:PORT")]
    pub(crate) admin_listen: Option<SocketAddr>,
    /// How the log is written.
    #[arg(long, env = "STRAHL_LOG_FORMAT", value_name = "FORMAT", default_value = "text", value_parser = word::<LogFormat>())]
    pub(crate) log_format: LogFormat,
    /// File of API keys, as `strahl key new` makes them; it is read again when it changes. Without it nobody needs a key.
    #[arg(long, env = "STRAHL_KEYS", value_name = "FILE")]
    pub(crate) keys: Option<PathBuf>,
    /// Let everybody who can reach the service use it, also from other machines.
    #[arg(long, env = "STRAHL_INSECURE_NO_AUTH", conflicts_with = "keys")]
    pub(crate) insecure_no_auth: bool,
    /// Web pages that may use the service from a browser: * for all, none, or origins between commas.
    #[arg(long, env = "STRAHL_CORS_ORIGIN", value_name = "ORIGINS", default_value = "*", value_parser = Origins::read)]
    pub(crate) cors_origin: Origins,
    /// Threads to render with [default: all the machine, or its container, gives].
    #[arg(long, env = "STRAHL_THREADS", value_parser = threads())]
    pub(crate) threads: Option<u64>,
    /// Requests that may wait for the renderer; further ones are answered with 503.
    #[arg(long, env = "STRAHL_QUEUE", default_value_t = 32, value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub(crate) queue: u32,
    /// Connections open at one time; further ones wait to be accepted.
    #[arg(long, env = "STRAHL_MAX_CONNECTIONS", default_value_t = 2_048, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) max_connections: u32,
    /// Bytes of a request body.
    #[arg(long, env = "STRAHL_MAX_BODY_BYTES", value_name = "BYTES", default_value_t = 64 << 20, value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    pub(crate) max_body_bytes: u64,
    /// Pixels of one answer.
    #[arg(long, env = "STRAHL_MAX_PIXELS", value_name = "PIXELS", default_value_t = 8_300_000)]
    pub(crate) max_pixels: u64,
    /// Samples of one answer: its pixels times the samples for each.
    #[arg(long, env = "STRAHL_MAX_SAMPLES_TOTAL", value_name = "SAMPLES", default_value_t = 64_000_000)]
    pub(crate) max_samples_total: u64,
    /// Bytes of built scenes that are kept, so that asking again about the same scene skips reading and building it; 0
    /// keeps none.
    #[arg(long, env = "STRAHL_SCENE_CACHE_BYTES", value_name = "BYTES", default_value_t = 512 << 20)]
    pub(crate) scene_cache_bytes: u64,
    /// Bytes of finished pictures that are kept in memory; 0 keeps none.
    #[arg(long, env = "STRAHL_PICTURE_CACHE_BYTES", value_name = "BYTES", default_value_t = 256 << 20)]
    pub(crate) picture_cache_bytes: u64,
    /// Bytes of scenes that are remembered by POST /v1/scenes.
    #[arg(long, env = "STRAHL_KNOWN_SCENE_BYTES", value_name = "BYTES", default_value_t = 256 << 20)]
    pub(crate) known_scene_bytes: u64,
    /// Folder in which finished pictures and known scenes outlast the process; without it they are kept in memory only.
    #[arg(long, env = "STRAHL_CACHE", value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// Bytes of finished pictures in that folder.
    #[arg(long, env = "STRAHL_DISK_CACHE_BYTES", value_name = "BYTES", default_value_t = 10 << 30)]
    pub(crate) disk_cache_bytes: u64,
    /// Tiles that may wait for the renderer, up to 25 seconds each; further ones are answered with 503.
    #[arg(long, env = "STRAHL_TILE_QUEUE", default_value_t = 512, value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub(crate) tile_queue: u32,
    /// Tiles that one client may ask for at one time, a client being a tenant's address; further ones are answered with 429.
    /// Behind a proxy that many share it should be larger.
    #[arg(long, env = "STRAHL_CLIENT_TILES", value_name = "TILES", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) client_tiles: u32,
    /// Address under which clients see the service, such as https://render.example.org; for the addresses in IIIF answers
    /// [default: http:// and what the request's Host says].
    #[arg(long, env = "STRAHL_PUBLIC_URL", value_name = "URL", value_parser = public_url)]
    pub(crate) public_url: Option<String>,
    /// Folder of pictures that scenes may name as textures; without it they have to contain them.
    #[arg(long, env = "STRAHL_TEXTURES", value_name = "DIR")]
    pub(crate) textures: Option<PathBuf>,
    /// Folder in which jobs outlive the service; without it they are in a temporary one, and end with it.
    #[arg(long, env = "STRAHL_DATA", value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Bytes that scenes and pictures of jobs may take in that folder: where there is no room, the oldest pictures go first.
    /// The scene of a job, and what it writes, may take half of it.
    #[arg(long, env = "STRAHL_DATA_BYTES", value_name = "BYTES", default_value_t = 10 << 30)]
    pub(crate) data_bytes: u64,
    /// Jobs that wait or run; further ones are answered with 503.
    #[arg(long, env = "STRAHL_JOBS", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) jobs: u32,
    /// Pixels of a job's picture.
    #[arg(long, env = "STRAHL_JOB_MAX_PIXELS", value_name = "PIXELS", default_value_t = 100_000_000)]
    pub(crate) job_max_pixels: u64,
    /// Samples of a job's picture: its pixels times the samples for each.
    #[arg(long, env = "STRAHL_JOB_MAX_SAMPLES_TOTAL", value_name = "SAMPLES", default_value_t = 20_000_000_000)]
    pub(crate) job_max_samples_total: u64,
    /// Bytes that jobs under way may take together [default: half of what the machine, or its container, has].
    #[arg(long, env = "STRAHL_JOB_MEMORY_BYTES", value_name = "BYTES")]
    pub(crate) job_memory_bytes: Option<u64>,
    /// Seconds that a job may run.
    #[arg(long, env = "STRAHL_JOB_TIMEOUT", value_name = "SECONDS", default_value = "3600", value_parser = seconds)]
    pub(crate) job_timeout: Duration,
    /// Seconds that a job's picture is kept.
    #[arg(long, env = "STRAHL_KEEP_PICTURES", value_name = "SECONDS", default_value = "604800", value_parser = long_seconds)]
    pub(crate) keep_pictures: Duration,
    /// Seconds that a job is remembered after its end, or after its picture is gone.
    #[arg(long, env = "STRAHL_KEEP_RECORDS", value_name = "SECONDS", default_value = "86400", value_parser = long_seconds)]
    pub(crate) keep_records: Duration,
    /// Seconds until a request that is not answered is given up.
    #[arg(long, env = "STRAHL_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    pub(crate) timeout: Duration,
    /// Seconds a client may take to send a request's headers.
    #[arg(long, env = "STRAHL_HEADER_TIMEOUT", value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    pub(crate) header_timeout: Duration,
    /// Seconds a client may take to send a request's body.
    #[arg(long, env = "STRAHL_BODY_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    pub(crate) body_timeout: Duration,
    /// Seconds a client may stop reading its answer.
    #[arg(long, env = "STRAHL_WRITE_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    pub(crate) write_timeout: Duration,
    /// Seconds that running requests have to finish after SIGTERM or Ctrl-C.
    #[arg(long, env = "STRAHL_DRAIN_TIMEOUT", value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub(crate) drain_timeout: Duration,
}

/// Names of log formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LogFormat {
    /// For people.
    Text,
    /// For programs: one object in each line.
    Json,
}
