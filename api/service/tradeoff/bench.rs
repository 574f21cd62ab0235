//! Renders the scene of a trade-off with any settings, and keeps the time.

use super::Stopped;
use super::progress::Watch;
use crate::service::clock::milliseconds;
use crate::service::scheduler::pool::Workers;
use std::time::{Duration, Instant};
use strahl::bound::ceiling::Ceiling;
use strahl::film::Region;
use strahl::metrics::Difference;
use strahl::metrics::Image8;
use strahl::render::{Cancelled, Control, Picture, render};
use strahl::scene::compile::{CompileOptions, compile_from};
use strahl::scene::description::{Accuracy, Camera, Fixed, Precision, Proved};
use strahl::scene::{Files, Loaded, Scene};
use strahl::tradeoff::LeftOut;
use strahl::tradeoff::sweep::Settings;

/// Share of the time by which any picture may be late.
const SLACK: f64 = 0.02;
/// Milliseconds that it may be late in any case.
pub(super) const LEAST_SLACK_MS: f64 = 50.0;

/// The scene in both precisions, and the time limit.
pub(super) struct TradeoffBench<'a> {
    pub(super) single: Scene,
    pub(super) double: Scene,
    camera: Camera,
    /// What proofs are held against in each precision, where the scene names a depth.
    held: Option<[Ceiling; 2]>,
    /// What the scene asks for and is not compared.
    pub(super) left_out: LeftOut,
    /// When all of it began.
    began: Instant,
    /// When this part of it began, and the seconds that it may take.
    started: Instant,
    pub(super) seconds: f64,
    pub(super) workers: &'a Workers,
    control: &'a Control,
    /// Which part this is, and who is told what it finds.
    pub(super) part: &'static str,
    pub(super) watch: Watch<'a>,
}

impl<'a> TradeoffBench<'a> {
    /// Builds the scene in the other precision. Also returns the settings that the scene asks for.
    pub(super) fn build(
        loaded: Loaded,
        files: &dyn Files,
        started: Instant,
        seconds: f64,
        workers: &'a Workers,
        control: &'a Control,
        watch: Watch<'a>,
    ) -> Result<(Self, Settings), Stopped> {
        let Loaded { mut description, scene, nff, .. } = loaded;
        let render = description.render;
        let Scene { samples, antialias, adaptive, .. } = scene;
        // The effects of a scene are decided when it is built. With depth 1 it would have none of those of secondary rays.
        let shallow = render.max_depth == Some(1);
        description.render.max_depth = Some(render.fixed_depth().max(2));
        description.render.accuracy = Some(Accuracy::Fixed(Fixed {}));
        // All but proofs are held against recursion without end, as far as it has a bound.
        let is_held = render.max_depth.is_some() && !matches!(render.accuracy(), Accuracy::Fixed(_));
        let mut build = |precision| {
            if control.is_cancelled() {
                return Err(Stopped::Cancelled);
            }
            description.render.precision = precision;
            let options = CompileOptions { spd_counts: nff.spd_counts, ..CompileOptions::default() };
            workers.work(|| compile_from(&description, options, files))?.map_err(Stopped::Refused)
        };
        let other = match render.precision {
            Precision::Single => Precision::Double,
            Precision::Double => Precision::Single,
        };
        let (this, other) = (if shallow || is_held { build(render.precision)? } else { scene }, build(other)?);
        let (single, double) = if render.precision == Precision::Single { (this, other) } else { (other, this) };
        description.render = render;
        description.render.accuracy = Some(Accuracy::Proved(Proved { max_codes: 1 }));
        let held = render.max_depth.map(|_| [&single, &double].map(|scene| scene.ceiling_with(&description.whole())));
        let camera = description.camera;
        let left_out = LeftOut::of(render.accuracy(), adaptive);
        let part = "choices";
        let began = started;
        let bench =
            Self { single, double, camera, held, left_out, began, started, seconds, workers, control, part, watch };
        let is_fixed = matches!(render.accuracy(), Accuracy::Fixed(_));
        let asked = Settings {
            max_depth: if is_fixed { Some(render.fixed_depth()) } else { bench.proved_depth() },
            min_weight: render.fixed_weight(),
            max_codes: match render.accuracy() {
                Accuracy::Fixed(_) => None,
                Accuracy::Proved(Proved { max_codes }) => Some(max_codes),
                Accuracy::Time(_) | Accuracy::Rays(_) | Accuracy::Statistical(_) => Some(1),
            },
            samples,
            antialias,
            precision: render.precision,
        };
        Ok((bench, asked))
    }

    /// The depth of the pictures that proofs are held against. None: recursion without end.
    pub(super) fn proved_depth(&self) -> Option<u32> {
        self.held.as_ref().map_or_else(|| self.single.ceiling(), |[single, _]| single).reach.max_depth
    }

    /// Why that is so, and what is proved, in a sentence.
    pub(super) fn why(&self) -> &str {
        &self.held.as_ref().map_or_else(|| self.single.ceiling(), |[single, _]| single).reach.why
    }

    /// Begins the next part, which may take some seconds.
    pub(super) fn begin_part(&mut self, part: &'static str, seconds: f64) {
        (self.part, self.started, self.seconds) = (part, Instant::now(), seconds.max(0.0));
    }

    /// Seconds since the start of this part.
    pub(super) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Seconds until a share of the time has passed, below 0 after it.
    pub(super) fn seconds_left(&self, share: f64) -> f64 {
        share * self.seconds - self.elapsed()
    }

    /// Milliseconds by which any picture may be late: a machine that does something else stops small ones for longer than they take.
    pub(super) fn slack_ms(&self) -> f64 {
        (SLACK * self.seconds * 1e3).max(LEAST_SLACK_MS)
    }

    pub(super) fn resize(&mut self, [width, height]: [u32; 2]) {
        self.single.set_size(&self.camera, width, height);
        self.double.set_size(&self.camera, width, height);
    }

    /// A picture with some settings. None if it is not finished before a share of the time has passed.
    pub(super) fn render_picture(&mut self, settings: Settings, end: f64) -> Result<Option<Picture>, Cancelled> {
        self.render_within(settings, f64::INFINITY, end)
    }

    /// The same. None also if it takes longer than some milliseconds.
    pub(super) fn render_within(
        &mut self,
        settings: Settings,
        most_ms: f64,
        end: f64,
    ) -> Result<Option<Picture>, Cancelled> {
        self.control.set_progress(milliseconds(self.began) as u64, self.control.total());
        let left = self.seconds_left(end).min(most_ms / 1e3);
        let Settings { max_depth, min_weight, max_codes, samples, antialias, precision } = settings;
        let scene = match precision {
            Precision::Single => &mut self.single,
            Precision::Double => &mut self.double,
        };
        // Where proofs are held against another depth, only their ceiling is exchanged.
        let held =
            max_codes.and(self.held.as_ref()).map(|held| held[usize::from(precision == Precision::Double)].clone());
        let endless = held.map(|held| {
            let endless = scene.ceiling().clone();
            scene.set_ceiling(held);
            endless
        });
        match max_codes {
            Some(codes) => scene.set_proved(codes),
            None => scene.set_recursion(max_depth.unwrap_or(u32::MAX), min_weight),
        }
        // Each setting has the samples that it names, whatever the scene would choose.
        (scene.samples, scene.antialias, scene.adaptive, scene.statistical) = (samples, antialias, false, None);
        let whole = Region::whole(scene.width, scene.height);
        let deadline = Instant::now() + Duration::from_secs_f64(left.max(0.0));
        let in_time = Control::until(deadline);
        let (rendered, workers) = (&*scene, self.workers);
        let rendered = workers.work(|| render(rendered, whole, &in_time));
        if let Some(endless) = endless {
            scene.set_ceiling(endless);
        }
        self.control.add_rays(in_time.rays());
        match rendered? {
            Ok(picture) => Ok(Some(picture)),
            Err(Cancelled) if self.control.is_cancelled() => Err(Cancelled),
            Err(Cancelled) => Ok(None),
        }
    }

    /// The bound proved for a picture. Where settings name a proof, it is held against recursion to their depth; the bounds of all
    /// others are against recursion without end, which the references come near to.
    pub(super) fn proved_codes(&self, picture: &Picture, settings: Settings) -> Result<Option<u8>, Cancelled> {
        let endless = self.single.ceiling().reach.max_depth.is_none();
        let holds = endless || settings.max_codes.is_some();
        let proof = holds.then(|| self.workers.work(|| picture.proof())).transpose()?;
        Ok(proof.filter(|proof| proof.max_linear.is_some()).map(|proof| proof.max_codes))
    }

    /// Compares two pictures on the pool. None if the request was cancelled.
    pub(super) fn compare(&self, reference: &Image8, test: &Image8) -> Option<Difference> {
        self.workers.work(|| Difference::of(reference, test)).ok()
    }
}
