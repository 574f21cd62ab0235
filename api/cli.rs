//! The command line: every command, every flag, and their help.

use crate::server::{Origins, Scope};
use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;
use strahl::film::Region;
use strahl::scene::description::{Accuracy, Fixed, Precision, Proved, Rays, Statistical, Time};
use strahl::scene::limits::{self, Limit};
use strahl::scene::{Format, Overrides};

/// Renders JSON scenes with Whitted's ray tracing, and says what the picture cost.
#[derive(Debug, Parser)]
#[command(name = "strahl", version, max_term_width = 100, arg_required_else_help = true)]
#[command(after_help = "\
Examples:
  strahl render scene.json -o scene.png
  strahl render balls.nff.gz --width 1024 --height 1024 -o - --format png > balls.png
  strahl explain scene.json
  strahl serve --listen 127.0.0.1:8080

SCENE is a .json, .nff or .nff.gz file, or - for standard input.
Exit codes: 0 done, 1 bad input, 2 bad usage, 130 interrupted.")]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Everything `strahl` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene into a picture file.
    Render(RenderArgs),
    /// Follow single rays to their first hit: one JSON ray per line in, one JSON answer per line out.
    Rays(RaysArgs),
    /// Show the tree of rays behind one pixel.
    Tree(TreeArgs),
    /// Show which effects a scene calls for, and why.
    Explain(ExplainArgs),
    /// Measure what accuracy costs in time: many settings, their errors and times, on one page.
    Tradeoff(TradeoffArgs),
    /// Turn a Neutral File Format file into scene JSON.
    Import(ImportArgs),
    /// Check a scene and report all its problems, without rendering it.
    Validate(ValidateArgs),
    /// Print the JSON Schema of scenes.
    Schema,
    /// Print the service's contract as OpenAPI 3.1.
    Openapi,
    /// Make keys for the service.
    #[command(subcommand)]
    Key(KeyCommand),
    /// Check or show the configuration of the service.
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Serve renders over HTTP.
    Serve(Box<ServeArgs>),
    /// Ask a running service whether it is alive; exit code 0 if it is.
    Healthcheck(HealthcheckArgs),
}

/// Where a scene comes from.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Scene file (.json, .nff or .nff.gz), or - for standard input.
    pub(crate) scene: String,
    /// Format of the scene [default: by file name, else by content].
    #[arg(long, value_name = "FORMAT")]
    pub(crate) input: Option<InputFormat>,
}

/// Names of scene formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum InputFormat {
    /// Scene JSON.
    Json,
    /// Neutral File Format, plain or gzip.
    Nff,
}

impl From<InputFormat> for Format {
    fn from(format: InputFormat) -> Self {
        match format {
            InputFormat::Json => Self::Json,
            InputFormat::Nff => Self::Nff,
        }
    }
}

/// Settings put over those in the scene, and the threads to use.
#[derive(Debug, Args)]
pub(crate) struct SettingsArgs {
    /// Threads to render with [default: all the machine, or its container, gives].
    #[arg(long, env = "STRAHL_THREADS", value_parser = threads())]
    pub(crate) threads: Option<u64>,
    /// Pixels across [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::IMAGE_SIDE))]
    width: Option<u32>,
    /// Pixels down [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::IMAGE_SIDE))]
    height: Option<u32>,
    /// Longest chain of rays; the primary ray counts 1 [default: as the scene says].
    #[arg(long, value_name = "RAYS", value_parser = up_to(limits::MAX_DEPTH))]
    max_depth: Option<u32>,
    /// Weight below which a ray is not followed, 0 to 1 [default: as the scene says].
    #[arg(long, value_name = "WEIGHT", value_parser = weight)]
    min_weight: Option<f64>,
    /// What ends the recursion: fixed, proved:CODES, time:MS, rays:COUNT or statistical:CODES [default: as the scene says, else
    /// proved:1].
    #[arg(long, value_name = "MODE", value_parser = accuracy)]
    accuracy: Option<Accuracy>,
    /// Rays for each pixel [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::SAMPLES))]
    samples: Option<u32>,
    /// Floating-point format of the whole trace: single or double [default: as the scene says].
    #[arg(long, value_parser = precision)]
    precision: Option<Precision>,
    /// Whether pixels that differ from a neighbour get more samples: true or false [default: as the scene says].
    #[arg(long, value_name = "BOOL")]
    antialias: Option<bool>,
    /// See opaque surfaces from behind, too (NFF only).
    #[arg(long)]
    two_sided: bool,
    /// Follow the counting rules of the Standard Procedural Databases: 513 x 513 corner rays, depth 5 (NFF only).
    #[arg(long)]
    spd_counts: bool,
}

/// A whole number from 1 to a limit.
fn up_to(limit: Limit) -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(1..=limit.max)
}

/// A number from 0 to 1.
pub(crate) fn weight(text: &str) -> Result<f64, String> {
    let weight: f64 = text.parse().map_err(|_| "expected a number from 0 to 1".to_owned())?;
    if (0.0..=1.0).contains(&weight) { Ok(weight) } else { Err("expected a number from 0 to 1".into()) }
}

/// An accuracy mode with its parameters: `proved:1`.
pub(crate) fn accuracy(text: &str) -> Result<Accuracy, String> {
    let (mode, parameters) = text.split_once(':').unwrap_or((text, ""));
    let number = |text: &str| text.parse::<f64>().ok();
    let accuracy = match mode {
        "fixed" if parameters.is_empty() => Some(Accuracy::Fixed(Fixed {})),
        "proved" => match parameters {
            "" => Some(1),
            codes => codes.parse().ok().filter(|codes| *codes <= 2),
        }
        .map(|max_codes| Accuracy::Proved(Proved { max_codes })),
        "time" => number(parameters).filter(|ms| (1.0..=3.6e6).contains(ms)).map(|ms| Accuracy::Time(Time { ms })),
        "rays" => {
            let count = parameters.parse().ok().filter(|count| (1..=1 << 53).contains(count));
            count.map(|count| Accuracy::Rays(Rays { count }))
        }
        "statistical" => statistical(parameters),
        _ => None,
    };
    accuracy.ok_or_else(|| ACCURACY.to_owned())
}

/// Half width and confidence: `1` or `1,0.99`.
fn statistical(parameters: &str) -> Option<Accuracy> {
    let (half_width, confidence) = parameters.split_once(',').unwrap_or((parameters, "0.95"));
    let half_width = half_width.parse().ok().filter(|width| (0.25..=64.0).contains(width))?;
    let confidence = confidence.parse().ok().filter(|confidence| (0.5..=0.999).contains(confidence))?;
    Some(Accuracy::Statistical(Statistical { half_width, confidence }))
}

/// What an accuracy may be.
pub(crate) const ACCURACY: &str = "expected fixed, proved:0 to proved:2, time:MILLISECONDS, rays:COUNT, \
     statistical:CODES (0.25 to 64) or statistical:CODES,CONFIDENCE (0.5 to 0.999)";

impl SettingsArgs {
    /// The settings as the renderer takes them.
    pub(crate) fn overrides(&self) -> Overrides {
        Overrides {
            width: self.width,
            height: self.height,
            max_depth: self.max_depth,
            min_weight: self.min_weight,
            accuracy: self.accuracy,
            samples: self.samples,
            antialias: self.antialias,
            precision: self.precision,
            two_sided: self.two_sided,
            spd_counts: self.spd_counts,
        }
    }
}

/// What only commands that render pictures take.
#[derive(Debug, Args)]
pub(crate) struct PictureArgs {
    /// Render only these pixels of the picture: left edge, upper edge, width, height.
    #[arg(long, value_name = "X,Y,W,H", value_parser = region)]
    pub(crate) region: Option<Region>,
    /// Write the cost report as JSON: plan, times, rays. - is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) stats: Option<PathBuf>,
}

/// `strahl render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Picture file: .png, .jpg, .webp, or .exr or .pfm for linear floats; - for standard output, which needs --format.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Format of the picture [default: by file name].
    #[arg(long)]
    pub(crate) format: Option<PictureFormat>,
    /// Bits per channel of a PNG: 8 or 16.
    #[arg(long, default_value = "8", value_parser = ["8", "16"], hide_possible_values = true)]
    pub(crate) bits: String,
    /// Quality of a JPEG, 1 to 100.
    #[arg(long, value_name = "QUALITY", value_parser = quality)]
    pub(crate) quality: Option<u8>,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

/// Names of picture formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PictureFormat {
    /// sRGB.
    Png,
    /// sRGB, lossy.
    Jpg,
    /// sRGB, lossless.
    Webp,
    /// OpenEXR, linear 32-bit floats.
    Exr,
    /// Portable float map, linear 32-bit floats.
    Pfm,
}

/// `strahl rays`.
#[derive(Debug, Args)]
#[command(after_help = "\
A ray:  {\"origin\":[0,0,5],\"direction\":[0,0,-1],\"t_min\":0,\"t_max\":null}
The direction is taken as given: t counts in its units. If SCENE is -, the rays cannot come from standard input as well: \
use --rays FILE.")]
pub(crate) struct RaysArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// File with the rays.
    #[arg(long, value_name = "FILE", default_value = "-")]
    pub(crate) rays: String,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

/// `strahl tree`.
#[derive(Debug, Args)]
pub(crate) struct TreeArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the upper left.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub(crate) pixel: [u32; 2],
    /// How to show the tree.
    #[arg(long, default_value = "json")]
    pub(crate) format: TreeFormat,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

/// Names of tree formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TreeFormat {
    /// Every ray with all its numbers.
    Json,
    /// Graphviz.
    Dot,
    /// A drawing.
    Svg,
}

/// `strahl explain`.
#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// How to show the plan.
    #[arg(long, default_value = "table")]
    pub(crate) format: ExplainFormat,
    /// Render the scene, too, and put the rays actually traced beside the plan.
    #[arg(long)]
    pub(crate) analyze: bool,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

/// Names of plan formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExplainFormat {
    /// For people.
    Table,
    /// For programs.
    Json,
}

/// `strahl tradeoff`.
#[derive(Debug, Args)]
#[command(after_help = "\
The picture is scaled down so that all settings can be compared in the time there is; the report says to what size.")]
pub(crate) struct TradeoffArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Page with plots, table and pictures: .html, or .svg for the plot of error against time alone; - for the page on
    /// standard output.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Write all points as JSON, too. - is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    /// Seconds that loading and measuring may take.
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub(crate) seconds: Duration,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

/// `strahl import`.
#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// Neutral File Format file (.nff or .nff.gz), or - for standard input.
    pub(crate) file: String,
    /// Where the scene JSON goes.
    #[arg(short, long, value_name = "FILE.json", default_value = "-")]
    pub(crate) output: PathBuf,
    /// See opaque surfaces from behind, too.
    #[arg(long)]
    pub(crate) two_sided: bool,
    /// Follow the counting rules of the Standard Procedural Databases: 513 x 513 corner rays, depth 5.
    #[arg(long)]
    pub(crate) spd_counts: bool,
}

/// `strahl validate`.
#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// How to report.
    #[arg(long, default_value = "text")]
    pub(crate) format: ReportFormat,
}

/// Names of report formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    /// For people.
    Text,
    /// For programs.
    Json,
}

/// `strahl key`.
#[derive(Debug, Subcommand)]
pub(crate) enum KeyCommand {
    /// Make an API key, which is shown once, and the lines about it for the key file.
    New(NewKeyArgs),
    /// Make a secret that signs capability URLs, for the key file. The first one signs, all of them are accepted.
    Signer {
        /// Add it to this key file instead of printing it.
        #[arg(long, value_name = "FILE")]
        file: Option<PathBuf>,
    },
}

/// `strahl key new`.
#[derive(Debug, Args)]
pub(crate) struct NewKeyArgs {
    /// Whose key it is: letters, digits and -.
    #[arg(long, value_name = "NAME")]
    pub(crate) tenant: String,
    /// What it allows.
    #[arg(long, value_name = "SCOPES", value_delimiter = ',', default_value = "render,jobs,read")]
    pub(crate) scopes: Vec<Scope>,
    /// Add the lines to this key file instead of printing them.
    #[arg(long, value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}

/// Names of log formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// For people.
    Text,
    /// For programs: one object in each line.
    Json,
}

/// `strahl config`.
#[derive(Debug, Subcommand)]
pub(crate) enum ConfigCommand {
    /// Check a configuration file.
    Check {
        /// The file.
        file: PathBuf,
    },
    /// Print what a service with these flags would use, and where each value comes from.
    Print(Box<ServeArgs>),
}

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
    #[arg(long, env = "STRAHL_LOG_FORMAT", value_name = "FORMAT", default_value = "text")]
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

/// `strahl healthcheck`. It goes by what the service itself goes by, so that both say the same in one environment.
#[derive(Debug, Args)]
#[command(after_help = "\
Ask on the listener for operators if there is one: on that for clients, a crowd of them may take all connections.")]
pub(crate) struct HealthcheckArgs {
    /// What to ask [default: /livez on the listener for operators, or else on that for clients].
    #[arg(long, env = "STRAHL_HEALTHCHECK_URL")]
    pub(crate) url: Option<String>,
    /// Where the service listens for operators.
    #[arg(long, env = "STRAHL_ADMIN_LISTEN", value_name = "ADDRESS:PORT")]
    pub(crate) admin_listen: Option<SocketAddr>,
    /// Where the service listens for clients.
    #[arg(long, env = "STRAHL_LISTEN", value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8080")]
    pub(crate) listen: SocketAddr,
}

fn threads() -> RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=1_024)
}

/// Reads `single` or `double`.
pub(crate) fn precision(text: &str) -> Result<Precision, &'static str> {
    match text {
        "single" => Ok(Precision::Single),
        "double" => Ok(Precision::Double),
        _ => Err("expected single or double"),
    }
}

fn public_url(text: &str) -> Result<String, &'static str> {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    match host.is_some_and(|host| !host.is_empty() && text.bytes().all(|byte| byte.is_ascii_graphic())) {
        true => Ok(text.trim_end_matches('/').to_owned()),
        false => Err("expected an address that begins with http:// or https://"),
    }
}

/// Reads the quality of a JPEG.
pub(crate) fn quality(text: &str) -> Result<u8, &'static str> {
    text.parse().ok().filter(|quality| (1..=100).contains(quality)).ok_or("expected a whole number from 1 to 100")
}

fn numbers<const N: usize>(text: &str) -> Option<[u32; N]> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

fn region(text: &str) -> Result<Region, &'static str> {
    let [x, y, width, height] =
        numbers(text).ok_or("expected four whole numbers: left edge, upper edge, width, height")?;
    Ok(Region { x, y, width, height })
}

fn pixel(text: &str) -> Result<[u32; 2], &'static str> {
    numbers(text).ok_or("expected two whole numbers: column and row")
}

fn seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds")?;
    if seconds > 0.0 && seconds <= 86_400.0 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("expected a number of seconds above 0, at most 86400")
    }
}

fn long_seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds = text.parse().ok().filter(|seconds| (1..=31_536_000).contains(seconds));
    seconds.map(Duration::from_secs).ok_or("expected a whole number of seconds from 1 to 31536000, a year")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn regions_have_four_numbers() {
        assert_eq!(region("1, 2,3,4"), Ok(Region { x: 1, y: 2, width: 3, height: 4 }));
        assert!(region("1,2,3").is_err());
        assert!(region("1,2,3,-4").is_err());
    }

    #[test]
    fn a_timeout_is_finite_and_above_0() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        for wrong in ["0", "-1", "inf", "NaN", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
