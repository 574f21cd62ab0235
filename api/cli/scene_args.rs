//! Arguments of commands about scenes: the scene, and settings that replace its own.

use super::values::{region, up_to, weight, word};
use crate::service::values::threads;
use clap::Args;
use std::path::PathBuf;
use strahl::film::{Region, ToneMapping};
use strahl::models::NameOrIndex;
use strahl::scene::description::{Accuracy, Fidelity, FilmBackground, Precision};
use strahl::scene::model::{LightChoice, ModelOptions, UpAxis, View};
use strahl::scene::nff::NffOptions;
use strahl::scene::{Format, Overrides, limits};

/// Where a scene comes from.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// Scene file (.json, .nff or .nff.gz), model (.glb, .gltf, .obj, .stl or .ply), or - for standard input.
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
    #[command(flatten)]
    overrides: OverrideArgs,
}

/// Settings that replace the scene's.
#[derive(Debug, Args)]
pub(super) struct OverrideArgs {
    /// Pixels across [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::IMAGE_SIDE), group = "across")]
    width: Option<u32>,
    /// Pixels down [default: as the scene says].
    #[arg(long, value_parser = up_to(limits::IMAGE_SIDE), group = "down")]
    height: Option<u32>,
    /// Size of the picture by its name, in place of --width and --height: og is that of a preview of a page, 1200 x 630.
    #[arg(long, value_name = "NAME", value_parser = ["og"], hide_possible_values = true, groups = ["across", "down"])]
    size: Option<String>,
    /// Pixels of the device for each pixel across and down, as the scene says or as given [default: 1].
    #[arg(long, value_name = "RATIO", value_parser = ratio)]
    dpr: Option<f64>,
    /// What the camera sees where nothing is: scene, transparent, or a color as #rrggbb [default: as the scene says].
    #[arg(long, value_name = "BACKGROUND")]
    background: Option<FilmBackground>,
    /// Exposure in stops, each of which doubles the light [default: as the scene says].
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = stops)]
    exposure: Option<f64>,
    /// How light brighter than white is compressed: none, khronos_pbr_neutral or agx [default: as the scene says].
    #[arg(long, value_parser = word::<ToneMapping>(), hide_possible_values = true)]
    tone: Option<ToneMapping>,
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
    /// How light gets from everywhere to surfaces: fast, or faithful, by rays [default: as the scene says].
    #[arg(long, value_name = "FIDELITY", value_parser = word::<Fidelity>(), hide_possible_values = true)]
    fidelity: Option<Fidelity>,
    /// See opaque surfaces from behind, too (NFF only).
    #[arg(long)]
    two_sided: bool,
    /// Follow the counting rules of the Standard Procedural Databases: 513 x 513 corner rays, depth 5 (NFF only).
    #[arg(long)]
    spd_counts: bool,
    #[command(flatten)]
    model: ModelArgs,
}

/// What is asked of a model.
#[derive(Debug, Args)]
#[command(next_help_heading = "Models")]
pub(super) struct ModelArgs {
    /// From where it is seen: three_quarter, front, back, left, right, top, bottom, iso, or angles in degrees around it and from
    /// above, as 30,70 [default: three_quarter].
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true)]
    view: Option<View>,
    /// Which axis is up: y or z [default: as its format has it].
    #[arg(long, value_name = "AXIS", value_parser = word::<UpAxis>(), hide_possible_values = true)]
    up: Option<UpAxis>,
    /// Which camera of the file sees it, from 0, in place of --view.
    #[arg(long, value_name = "INDEX")]
    camera: Option<u32>,
    /// Which scene of the file, from 0 [default: as the file says].
    #[arg(long = "scene", value_name = "INDEX")]
    model_scene: Option<u32>,
    /// Which animation of the file is played, by its place from 0 or its name [default: none].
    #[arg(long, value_name = "WHICH")]
    animation: Option<NameOrIndex>,
    /// Seconds since the start of the animation.
    #[arg(short, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    t: Option<f64>,
    /// Which variant of its materials, by its place from 0 or its name.
    #[arg(long, value_name = "WHICH")]
    variant: Option<NameOrIndex>,
    /// Which lights shine on it: auto, studio or file [default: auto].
    #[arg(long, value_name = "LIGHTS", value_parser = word::<LightChoice>(), hide_possible_values = true)]
    light: Option<LightChoice>,
    /// Refuse a model that requires what is not simulated.
    #[arg(long)]
    strict: bool,
}

impl ModelArgs {
    /// The options as the renderer takes them.
    pub(super) fn options(&self) -> ModelOptions {
        ModelOptions {
            view: self.view,
            up: self.up,
            camera: self.camera,
            scene: self.model_scene,
            animation: self.animation,
            t: self.t,
            variant: self.variant,
            light: self.light,
            strict: self.strict.then_some(true),
            around: None,
        }
    }
}

/// A ratio of pixels.
fn ratio(text: &str) -> Result<f64, String> {
    let wrong = || "expected a number from 0.25 to 8".to_owned();
    text.parse().ok().filter(|ratio: &f64| (0.25..=8.0).contains(ratio)).ok_or_else(wrong)
}

/// A time of an animation.
fn seconds(text: &str) -> Result<f64, String> {
    let wrong = || "expected a number of at least 0".to_owned();
    text.parse().ok().filter(|t| ModelOptions::is_time(*t)).ok_or_else(wrong)
}

/// An exposure.
fn stops(text: &str) -> Result<f64, String> {
    let wrong = || "expected a number from -32 to 32".to_owned();
    text.parse().ok().filter(|stops: &f64| stops.abs() <= 32.0).ok_or_else(wrong)
}

impl SettingsArgs {
    /// Those that replace the scene's.
    pub(super) fn overrides(&self) -> Overrides {
        self.overrides.overrides()
    }
}

impl OverrideArgs {
    /// The settings as the renderer takes them.
    pub(super) fn overrides(&self) -> Overrides {
        let [width, height] = if self.size.is_some() { [Some(1200), Some(630)] } else { [self.width, self.height] };
        Overrides {
            width,
            height,
            dpr: self.dpr,
            max_depth: self.max_depth,
            min_weight: self.min_weight,
            accuracy: self.accuracy,
            samples: self.samples,
            antialias: self.antialias,
            fidelity: self.fidelity,
            precision: self.precision,
            background: self.background,
            exposure: self.exposure,
            tone: self.tone,
            seen_from: None,
            nff: NffOptions { two_sided: self.two_sided, spd_counts: self.spd_counts },
            model: self.model.options(),
        }
    }
}

/// Arguments of commands that render pictures.
#[derive(Debug, Args)]
pub(super) struct PictureArgs {
    /// Render only these pixels of the picture: left edge, upper edge, width, height.
    #[arg(long, value_name = "X,Y,W,H", value_parser = region, help_heading = None::<&str>)]
    pub(super) region: Option<Region>,
    /// Write the cost report as JSON: plan, times, rays. - is standard output.
    #[arg(long, value_name = "FILE.json", help_heading = None::<&str>)]
    pub(super) stats: Option<PathBuf>,
}
