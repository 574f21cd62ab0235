//! Arguments of commands about scenes: the scene, and settings that replace its own.

use super::values::{region, up_to, weight, word};
use crate::service::values::threads;
use clap::Args;
use std::path::PathBuf;
use strahl::film::Region;
use strahl::scene::description::{Accuracy, Precision};
use strahl::scene::nff::NffOptions;
use strahl::scene::{Format, Overrides, limits};

/// Where a scene comes from.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// Scene file (.json, .nff or .nff.gz), or - for standard input.
    pub(super) scene: String,
    /// Format of the scene [default: by file name, else by content].
    #[arg(long, value_name = "FORMAT", value_parser = word::<Format>())]
    pub(super) input: Option<Format>,
}

/// Settings that replace the scene's, and the threads to use.
#[derive(Debug, Args)]
pub(super) struct SettingsArgs {
    /// Threads to render with [default: all of the machine, or of its container].
    #[arg(long, env = "STRAHL_THREADS", value_parser = threads())]
    pub(super) threads: Option<u64>,
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
    #[arg(long, value_name = "MODE")]
    accuracy: Option<Accuracy>,
    /// Rays for each pixel [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::SAMPLES))]
    samples: Option<u32>,
    /// Floating-point format of the whole trace: single or double [default: as the scene says].
    #[arg(long, value_parser = word::<Precision>(), hide_possible_values = true)]
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

impl SettingsArgs {
    /// The settings as the renderer takes them.
    pub(super) fn overrides(&self) -> Overrides {
        Overrides {
            width: self.width,
            height: self.height,
            max_depth: self.max_depth,
            min_weight: self.min_weight,
            accuracy: self.accuracy,
            samples: self.samples,
            antialias: self.antialias,
            precision: self.precision,
            seen_from: None,
            nff: NffOptions { two_sided: self.two_sided, spd_counts: self.spd_counts },
        }
    }
}

/// Arguments of commands that render pictures.
#[derive(Debug, Args)]
pub(super) struct PictureArgs {
    /// Render only these pixels of the picture: left edge, upper edge, width, height.
    #[arg(long, value_name = "X,Y,W,H", value_parser = region)]
    pub(super) region: Option<Region>,
    /// Write the cost report as JSON: plan, times, rays. - is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(super) stats: Option<PathBuf>,
}
