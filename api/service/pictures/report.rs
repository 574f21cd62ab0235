//! The cost report of a picture, which `--stats` and jobs give as JSON and headers of answers in short.

use crate::service::clock::milliseconds;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::time::Instant;
use strahl::bound::ceiling::Reach;
use strahl::bound::{GIVEN_UP, Proof};
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::estimate::Estimate;
use strahl::plan::pilot::Pilot;
use strahl::render::{Cancelled, Control, Picture, Progress, RayCounts, Refined, Sampling};
use strahl::scene::Scene;
use strahl::scene::description::{Accuracy, Rays, RenderSettings, Statistical};
use strahl::scene::nff::NffOptions;
use strahl::scene::world::Pruning;

/// The cost report.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "CostReport")]
pub(crate) struct Report {
    /// The effects, which of them are on and why, and how deep rays go.
    pub(crate) plan: Plan,
    /// Time and rays.
    pub(crate) cost: Cost,
    /// How far the picture may be from the exact one.
    pub(crate) error: ErrorBounds,
    /// What renders the same pixels again.
    pub(crate) replay: Replay,
}

/// Time and rays.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "PictureCost")]
pub(crate) struct Cost {
    /// Milliseconds from the scene's bytes to the picture's.
    pub(crate) wall_ms: f64,
    /// Milliseconds by phase.
    pub(crate) phases_ms: Phases,
    /// Rays by kind.
    pub(crate) rays: RayCounts,
    /// Camera rays that hit something.
    pub(crate) camera_hits: u64,
    /// Rays in the longest chain.
    pub(crate) deepest: u32,
    /// What antialiasing added.
    pub(crate) refined: Refined,
    /// Threads of the pool.
    pub(crate) threads: usize,
    /// How far a picture of the modes `time` and `rays` came.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) progress: Option<Progress>,
    /// Estimate that was made before, from a few of the pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) predicted: Option<Estimate>,
}

impl Cost {
    /// The cost of a picture that was begun at `began`.
    pub(crate) fn of(
        picture: &Picture,
        phases_ms: Phases,
        predicted: Option<Estimate>,
        began: Instant,
        workers: &Workers,
    ) -> Self {
        Self {
            wall_ms: milliseconds(began),
            phases_ms,
            rays: picture.rays,
            camera_hits: picture.rays.camera_hits,
            deepest: picture.rays.deepest,
            refined: picture.refined,
            threads: workers.threads(),
            progress: picture.progress,
            predicted,
        }
    }
}

/// A plan, and what rendering the picture has cost.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Analyzed<'a> {
    /// The plan, with the rays and milliseconds of each effect.
    #[serde(flatten)]
    pub(crate) plan: &'a Plan,
    /// Time and rays.
    pub(crate) actual: &'a Cost,
}

/// Adds to a plan what each effect took of the rendered picture, and what the picture would save without it.
pub(crate) fn measured(
    (mut plan, pilot): (Plan, Pilot),
    cost: &Cost,
    ready: &PreparedScene,
    region: Region,
    workers: &Workers,
    control: &Control,
) -> Result<Plan, Cancelled> {
    let trace_ms = cost.phases_ms.trace;
    plan.measure(&pilot, &cost.rays, &cost.refined, trace_ms);
    for effect in plan.comparable() {
        // One time slice for each effect.
        workers.work(|| plan.compare(effect, &ready.scene, region, control, trace_ms))??;
    }
    Ok(plan)
}

/// Milliseconds by phase, in order.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PhaseTimes")]
pub(crate) struct Phases {
    /// Reading the scene.
    pub(crate) parse: f64,
    /// Checking and compiling it.
    pub(crate) plan: f64,
    /// Building bounding volume hierarchies.
    pub(crate) bvh: f64,
    /// Tracing.
    pub(crate) trace: f64,
    /// The part of `trace` that antialiasing took.
    pub(crate) refine: f64,
    /// Encoding the picture, whatever its format.
    pub(crate) png: f64,
}

impl Phases {
    /// Names and milliseconds, in order, without those that are part of another.
    pub(crate) fn list(&self) -> [(&'static str, f64); 5] {
        [("parse", self.parse), ("plan", self.plan), ("bvh", self.bvh), ("trace", self.trace), ("png", self.png)]
    }
}

/// Error bounds by how they are known. Null means unknown, not exact.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ErrorBounds {
    /// Bounds that certainly hold.
    pub(crate) proved: Proved,
    /// Bounds that likely hold. Null where pixels have one sample and are not compared with their neighbours.
    pub(crate) estimated: Option<Estimated>,
    /// Errors measured against a reference picture.
    pub(crate) measured: Option<f64>,
}

/// Bound on the error of ending the recursion.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "ProvedError")]
pub(crate) struct Proved {
    /// The bound. Null where there is none.
    #[serde(flatten)]
    pub(crate) proof: Option<Proof>,
    /// The picture that it compares with.
    pub(crate) reference: &'static str,
    /// How bright an omitted ray can be, why, and how long the chains of rays of the reference are.
    #[serde(flatten)]
    pub(crate) reach: Reach,
    /// Why the bound is larger than what was asked for, or than 1 code, and what to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) shortfall: Option<String>,
    /// Errors that it does not cover.
    pub(crate) not_covered: &'static [&'static str],
    /// Pixels that have not had all of their samples.
    #[serde(skip)]
    waiting_pixels: u64,
}

impl Proved {
    fn line(&self) -> String {
        let mut field = match &self.proof {
            // Rounded down, so that 1 means all.
            Some(Proof { max_codes, identical_fraction, .. }) => {
                format!("proved={max_codes}, identical={:.3}", (identical_fraction * 1e3).floor() / 1e3)
            }
            None => format!("proved=?0, why=\"{}\"", quotable(&self.reach.why)),
        };
        if let Some(depth) = self.reach.max_depth {
            let _ = write!(field, ", depth={depth}");
        }
        field
    }

    /// The same in words.
    pub(crate) fn in_words(&self) -> String {
        let against = match self.reach.max_depth {
            Some(depth) if self.reach.because.iter().any(|pointer| pointer == "/render/max_depth") => {
                format!("recursion to depth {depth}")
            }
            Some(depth) => format!("recursion to depth {depth} ({})", self.reach.why),
            None => "endless recursion".to_owned(),
        };
        let against = match self.waiting_pixels {
            0 => against,
            pixels => format!("{against} for the samples that were traced ({pixels} pixels wait for more)"),
        };
        match &self.proof {
            Some(Proof { max_codes: 0, .. }) => format!("proved: the same codes as {against}"),
            Some(Proof { max_codes, identical_fraction, .. }) => format!(
                "proved: at most {max_codes} of 255 codes from {against}, {:.1} % of the pixels not at all",
                (identical_fraction * 1e3).floor() / 10.0
            ),
            None => format!("nothing is proved of its error: {}", self.reach.why),
        }
    }

    /// What is proved about a picture.
    fn about(picture: &Picture, scene: &Scene) -> Self {
        let mut reach = scene.ceiling().reach.clone();
        let pixels = picture.film.region.pixels();
        if let Some(Progress { traced_pixels, .. }) = picture.progress
            && traced_pixels < pixels
        {
            let borrowed = pixels - traced_pixels;
            reach.why =
                format!("{borrowed} pixels were not traced but interpolated, of which nothing follows for them");
            reach.because = Vec::new();
        }
        let waiting_pixels = picture.progress.map_or(0, |progress| progress.waiting_pixels);
        let proof = Some(picture.proof()).filter(|proof| proof.max_linear.is_some() && reach.ceiling.is_some());
        Self {
            shortfall: proof.as_ref().filter(|_| picture.progress.is_none()).and_then(|proof| shortfall(proof, scene)),
            proof,
            reference: match (reach.max_depth, waiting_pixels > 0) {
                (None, false) => "the same samples, recursion without end",
                (Some(_), false) => "the same samples, recursion to max_depth",
                (None, true) => "the samples that were traced, recursion without end",
                (Some(_), true) => "the samples that were traced, recursion to max_depth",
            },
            reach,
            waiting_pixels,
            not_covered: match scene.plays_roulette() {
                true => &[ALIASING, LEFT_OUT, ROULETTE],
                false => &[ALIASING, LEFT_OUT],
            },
        }
    }
}

const ALIASING: &str = "aliasing between samples";
const LEFT_OUT: &str = "light that the model leaves out, such as caustics";
const ROULETTE: &str =
    "chance in which rays stand for others (Russian roulette): of what was not followed, the bound holds in the mean";

/// Why a proof shows less than a user expects.
fn shortfall(proof: &Proof, scene: &Scene) -> Option<String> {
    let codes = proof.max_codes;
    match scene.pruning() {
        Pruning::Weight(_) if codes > 1 => Some(format!(
            "max_depth or min_weight cut off up to {codes} codes; with \"accuracy\": {{\"proved\": {{\"max_codes\": \
             1}}}} rays are followed until it is at most 1, as long as that is within reach"
        )),
        Pruning::Proved { max_codes } if codes > max_codes => {
            let pixels = match proof.beyond[usize::from(max_codes.min(2))] {
                1 => "1 pixel".to_owned(),
                pixels => format!("{pixels} pixels"),
            };
            Some(format!("the proof of {pixels} was given up: {GIVEN_UP}"))
        }
        _ => None,
    }
}

/// Error of sampling, estimated from the samples themselves.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "EstimatedError")]
pub(crate) struct Estimated {
    /// 8-bit codes that a share of the pixels is likely not further off, in the channel that is least sure.
    pub(crate) half_width_codes: f64,
    /// That share.
    pub(crate) share_of_pixels: f64,
    /// How it was estimated.
    pub(crate) method: &'static str,
    /// In the mode `statistical`: whether the target was reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) target: Option<Target>,
    /// Where each pixel gets as many samples as its error asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) samples: Option<AdaptiveSamples>,
}

/// How many samples the pixels asked for.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct AdaptiveSamples {
    /// Of a pixel, on average.
    mean: f64,
    /// Most of a pixel.
    most: u32,
    /// Share of the pixels that asked for no more; the others got the most that are allowed.
    settled_fraction: f64,
}

/// Result of the mode `statistical`.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "SamplingTarget")]
pub(crate) struct Target {
    #[serde(flatten)]
    asked: Statistical,
    /// Share of the pixels that reached the target. The others got the most samples allowed.
    sure_fraction: f64,
    /// Samples of a pixel, on average.
    mean_samples: f64,
    /// Most samples of a pixel.
    most_samples: u32,
}

/// The share of the pixels that an estimate is about.
const SHARE: f64 = 0.95;

impl Estimated {
    /// What the samples of a picture tell.
    pub(crate) fn about(picture: &Picture, scene: &Scene) -> Option<Self> {
        let Sampling { widths, reached } = &picture.sampling;
        let half_width_codes = f64::from(widths.at_share(SHARE)?) / 2.0;
        let target = scene.statistical.map(|asked| Target {
            asked,
            sure_fraction: reached.sure as f64 / reached.pixels.max(1) as f64,
            mean_samples: reached.samples as f64 / reached.pixels.max(1) as f64,
            most_samples: reached.most_samples,
        });
        let pixels = reached.pixels.max(1) as f64;
        let samples = (scene.adaptive && reached.pixels > 0).then(|| AdaptiveSamples {
            mean: reached.samples as f64 / pixels,
            most: reached.most_samples,
            settled_fraction: reached.sure as f64 / pixels,
        });
        let method = match target {
            _ if samples.is_some() => "what the last doubling of the samples changed, in each pixel and beside it",
            Some(_) => "independent batches of each pixel's samples, Student's t",
            None if picture.progress.is_some() => {
                "two halves of each pixel's samples; where it had to stop, how far pixels changed that were traced further"
            }
            None => "two halves of each pixel's samples; where antialiasing saw no contrast, the neighbours",
        };
        Some(Self { half_width_codes, share_of_pixels: SHARE, method, target, samples })
    }
}

impl ErrorBounds {
    /// What is known about a picture. Nothing is measured unless there is a reference, as in a trade-off.
    pub(crate) fn about(picture: &Picture, scene: &Scene) -> Self {
        Self { proved: Proved::about(picture, scene), estimated: Estimated::about(picture, scene), measured: None }
    }

    /// As a structured field (RFC 9651): `proved=1, identical=0.982, depth=10, estimated=2.5`, with `depth` where the
    /// reference of the proof has one; `proved=?0, why="..."` where there is no bound.
    pub(crate) fn line(&self) -> String {
        let mut field = self.proved.line();
        if let Some(Estimated { half_width_codes, .. }) = &self.estimated {
            let _ = write!(field, ", estimated={half_width_codes:.1}");
        }
        field
    }

    /// The same in words, for the command line.
    pub(crate) fn in_words(&self) -> String {
        let mut words = self.proved.in_words();
        if let Some(Estimated { half_width_codes, .. }) = &self.estimated {
            let _ = write!(words, "; likely within {half_width_codes:.1} codes of more samples");
        }
        words
    }
}

/// A text as the string of a structured field may be: printable ASCII without quotes and backslashes.
fn quotable(text: &str) -> String {
    text.chars().map(|c| if matches!(c, ' '..='~') && !matches!(c, '"' | '\\') { c } else { '\'' }).collect()
}

/// Settings that render the same pixels again, on any machine and any number of threads.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Replay {
    /// Version of the renderer.
    pub(crate) version: &'static str,
    /// Width and height of the whole picture.
    pub(crate) image: [u32; 2],
    /// The part that was rendered.
    pub(crate) region: Region,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// How an NFF file was read.
    #[serde(flatten)]
    pub(crate) nff: NffOptions,
}

impl Replay {
    /// What renders a picture again. One that a time limit has ended is repeated by its number of rays.
    pub(crate) fn of(picture: &Picture, ready: &PreparedScene) -> Self {
        let render = match picture.progress {
            Some(Progress { count, .. }) => {
                RenderSettings { accuracy: Some(Accuracy::Rays(Rays { count })), ..ready.render }
            }
            None => ready.render,
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            image: [picture.film.full_width, picture.film.full_height],
            region: picture.film.region,
            render,
            nff: ready.nff,
        }
    }
}
