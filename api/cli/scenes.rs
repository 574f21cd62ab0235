//! Flags of the commands that do something with a scene.

use super::scene_args::{PictureArgs, SceneArgs, SettingsArgs};
use super::values::{pixel, quality, seconds};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;
use strahl::accuracy::MapKind;

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

/// `strahl map`.
#[derive(Debug, Args)]
pub(crate) struct MapArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// What the map shows.
    #[arg(long)]
    pub(crate) of: MapOf,
    /// File to write: .png has colors and a scale, .pfm and .exr the numbers.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

/// Names of maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MapOf {
    /// 8-bit codes that each pixel is off at most, by what is proved.
    Proved,
    /// Rays of each pixel.
    Rays,
    /// Nanoseconds of each pixel, traced alone.
    Time,
    /// Rays in the longest chain of each pixel.
    Depth,
}

impl From<MapOf> for MapKind {
    fn from(of: MapOf) -> Self {
        match of {
            MapOf::Proved => Self::Proved,
            MapOf::Rays => Self::Rays,
            MapOf::Time => Self::Time,
            MapOf::Depth => Self::Depth,
        }
    }
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
