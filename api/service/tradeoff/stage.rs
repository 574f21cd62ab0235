//! Renders the scene of a trade-off with any settings, and keeps the time.

use super::Stopped;
use crate::service::clock::milliseconds;
use crate::service::scheduler::pool::Workers;
use std::time::{Duration, Instant};
use strahl::film::Region;
use strahl::metrics::Difference;
use strahl::metrics::Image8;
use strahl::render::{Cancelled, Control, Picture, render};
use strahl::scene::compile::{CompileOptions, compile_from};
use strahl::scene::description::{Accuracy, Camera, Fixed, Precision, Proved};
use strahl::scene::{Files, Loaded, Scene};
use strahl::tradeoff::sweep::Settings;

/// The scene in both precisions, and the time limit.
pub(super) struct Stage<'a> {
    pub(super) single: Scene,
    pub(super) double: Scene,
    camera: Camera,
    started: Instant,
    pub(super) seconds: f64,
    pub(super) workers: &'a Workers,
    control: &'a Control,
}

impl<'a> Stage<'a> {
    /// Builds the scene in the other precision. Also returns the settings that the scene asks for.
    pub(super) fn set(
        loaded: Loaded,
        files: &dyn Files,
        started: Instant,
        seconds: f64,
        workers: &'a Workers,
        control: &'a Control,
    ) -> Result<(Self, Settings), Stopped> {
        let Loaded { mut description, scene, nff, .. } = loaded;
        let render = description.render;
        let Scene { samples, antialias, .. } = scene;
        let asked = Settings {
            max_depth: render.fixed_depth(),
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
        // The effects of a scene are decided when it is built. With depth 1 it would have none of those of secondary rays.
        let shallow = render.max_depth == Some(1);
        description.render.max_depth = Some(render.fixed_depth().max(2));
        description.render.accuracy = Some(Accuracy::Fixed(Fixed {}));
        let mut build = |precision| {
            if control.is_cancelled() {
                return Err(Stopped::Cancelled);
            }
            description.render.precision = precision;
            let options = CompileOptions { spd_counts: nff.spd_counts, ..CompileOptions::default() };
            workers.work(|| compile_from(&description, options, files))?.map_err(Stopped::Refused)
        };
        let other = match asked.precision {
            Precision::Single => Precision::Double,
            Precision::Double => Precision::Single,
        };
        let (this, other) = (if shallow { build(asked.precision)? } else { scene }, build(other)?);
        let (single, double) = if asked.precision == Precision::Single { (this, other) } else { (other, this) };
        let camera = description.camera;
        Ok((Self { single, double, camera, started, seconds, workers, control }, asked))
    }

    /// Seconds since the start.
    pub(super) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Seconds until a share of the time has passed, below 0 after it.
    pub(super) fn left(&self, share: f64) -> f64 {
        share * self.seconds - self.elapsed()
    }

    pub(super) fn resize(&mut self, [width, height]: [u32; 2]) {
        self.single.set_size(&self.camera, width, height);
        self.double.set_size(&self.camera, width, height);
    }

    /// A picture with some settings. None if it is not finished before a share of the time has passed.
    pub(super) fn shoot(&mut self, settings: Settings, end: f64) -> Result<Option<Picture>, Cancelled> {
        self.control.set_progress(milliseconds(self.started) as u64, (self.seconds * 1e3) as u64);
        let left = self.left(end);
        let Settings { max_depth, min_weight, max_codes, samples, antialias, precision } = settings;
        let scene = match precision {
            Precision::Single => &mut self.single,
            Precision::Double => &mut self.double,
        };
        match max_codes {
            Some(codes) => scene.set_proved(codes),
            None => scene.set_recursion(max_depth, min_weight),
        }
        (scene.samples, scene.antialias) = (samples, antialias);
        let (scene, whole) = (&*scene, Region::whole(scene.width, scene.height));
        let deadline = Instant::now() + Duration::from_secs_f64(left.max(0.0));
        let in_time = Control::until(deadline);
        let rendered = self.workers.work(|| render(scene, whole, &in_time));
        self.control.add_rays(in_time.rays());
        match rendered? {
            Ok(picture) => Ok(Some(picture)),
            Err(Cancelled) if self.control.is_cancelled() => Err(Cancelled),
            Err(Cancelled) => Ok(None),
        }
    }

    /// Compares two pictures on the pool. None if the request was cancelled.
    pub(super) fn compare(&self, reference: &Image8, test: &Image8) -> Option<Difference> {
        self.workers.work(|| Difference::of(reference, test)).ok()
    }
}
