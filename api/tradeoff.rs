//! Measuring a trade-off within a time: first all settings once on a small picture, which is the warm-up and says how large
//! a picture the time suffices for, then references, then all settings round by round on that picture.

use crate::picture::milliseconds;
use crate::workers::Workers;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use strahl::accuracy::page::Thumbnails;
use strahl::accuracy::sweep::{Difference, Point, REFERENCE_SAMPLES, Settings, Times, points};
use strahl::accuracy::tradeoff::{Circumstances, Finer, Front, HOW_TIMES_ARE_MEASURED, Reference, Tradeoff};
use strahl::accuracy::{Codes8, Errors, Proof, advice};
use strahl::film::Region;
use strahl::lanes::instructions;
use strahl::render::{Cancelled, Control, Cut, Picture, render};
use strahl::scene::compile::{CompileOptions, compile_from};
use strahl::scene::description::{Accuracy, Camera, Fixed, Precision, Proved};
use strahl::scene::{Files, Loaded, Problems, Scene};

/// Pixels of the small picture.
const TRIAL_PIXELS: f64 = 2304.0;
/// Pixels that are compared at most.
const MOST_PIXELS: f64 = 1_048_576.0;
/// Rounds that the size of the picture is chosen for, and that there are at most.
const ROUNDS: [usize; 2] = [3, 9];
/// Shares of the time by when the small picture, the references and all rendering end.
const ENDS: [f64; 3] = [0.3, 0.65, 0.95];
/// Share of the time that should suffice for what is planned.
const PLANNED: f64 = 0.8;
/// Depth of references, unless the scene asks for more.
const DEPTH: u32 = 1000;
/// Weights below which references do not follow rays, each further than the one before; the last that the time suffices for
/// is taken, and one more is looked at.
const WEIGHTS: [f64; 6] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0];
/// The finest weight of the points: references go further wherever they can.
const FINEST: f64 = 1e-5;
/// Pause between two looks at the time and at the client.
const BETWEEN_LOOKS: Duration = Duration::from_millis(4);

/// What was found out.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// The numbers.
    pub(crate) tradeoff: Tradeoff,
    /// The pictures of the points, where they were measured.
    pub(crate) thumbnails: Vec<Option<Thumbnails>>,
}

/// Why nothing was found out.
#[derive(Debug)]
pub(crate) enum Stopped {
    /// Nobody wants to know any more.
    Cancelled,
    /// The scene cannot be built in the other precision.
    Refused(Problems),
}

impl From<Cancelled> for Stopped {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Measures what accuracy costs for a scene, in about so many seconds from `started`.
pub(crate) fn measure(
    loaded: Loaded,
    files: &dyn Files,
    started: Instant,
    seconds: f64,
    workers: &Workers,
    control: &Control,
) -> Result<Outcome, Stopped> {
    control.total.store((seconds * 1e3) as u64, Ordering::Relaxed);
    let name = loaded.description.name.clone();
    let (mut stage, asked) = Stage::set(loaded, files, started, seconds, workers, control)?;
    let asked_size = [stage.single.width, stage.single.height];
    let mut points = points(asked);

    let trial = Trial::run(&mut stage, &points, asked)?;
    let size = trial.size_for(&stage, asked_size, points.len());
    stage.resize(size);

    let (references, dropped) = References::trace(&mut stage, &points, trial.recursion)?;
    let mut thumbnails = vec![None; points.len()];
    let mut times = vec![Vec::new(); points.len()];
    for round in 0..ROUNDS[1] {
        for (i, point) in points.iter_mut().enumerate() {
            // Once a point's time is known, it is only begun if it can end.
            let longest = times[i].iter().copied().fold(0.0, f64::max);
            if round > 0 && (times[i].is_empty() || stage.left(ENDS[2]) < 1.2 * longest / 1e3) {
                continue;
            }
            let Some(picture) = stage.shoot(point.settings, ENDS[2])? else { continue };
            times[i].push(picture.trace_ms);
            if round == 0 {
                point.rays = Some(picture.rays);
                // The same bounds for all points: recursion without end, which the references come near to.
                let endless = stage.single.ceiling().reach.max_depth.is_none();
                let proof = endless.then(|| stage.workers.work(|| Proof::of(&picture))).transpose()?;
                point.proved_codes = proof.filter(|p| p.max_linear.is_some()).map(|p| p.max_codes);
                let codes = Codes8::from(&picture.film);
                point.measured = references.errors(&stage, point.settings, &codes);
                thumbnails[i] = Some(references.thumbnails(point.settings, &codes));
            }
        }
    }
    for (point, times) in points.iter_mut().zip(&times) {
        point.time = Times::of(times);
    }

    let fronts = Front::all(&points);
    let circumstances = Circumstances {
        version: env!("CARGO_PKG_VERSION"),
        date: today(),
        threads: workers.threads(),
        instructions: instructions(Cut::default().level),
        asked_size,
        size,
        seconds,
        took_seconds: milliseconds(started) / 1e3,
        times: HOW_TIMES_ARE_MEASURED,
    };
    let (max_depth, min_weight) = trial.recursion;
    let reference = Reference { max_depth, min_weight, dropped, finer: trial.finer };
    let advice = advice(&points, &fronts);
    Ok(Outcome { tradeoff: Tradeoff { scene: name, circumstances, reference, points, fronts, advice }, thumbnails })
}

/// The scene in both precisions, and the clock.
struct Stage<'a> {
    single: Scene,
    double: Scene,
    camera: Camera,
    started: Instant,
    seconds: f64,
    workers: &'a Workers,
    control: &'a Control,
}

impl<'a> Stage<'a> {
    /// Builds what is missing; also the settings that the scene asks for.
    fn set(
        loaded: Loaded,
        files: &dyn Files,
        started: Instant,
        seconds: f64,
        workers: &'a Workers,
        control: &'a Control,
    ) -> Result<(Self, Settings), Stopped> {
        let Loaded { mut description, scene, spd_counts, .. } = loaded;
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
        // What a scene calls for is decided when it is built: one ray deep it would be nothing.
        let shallow = render.max_depth == Some(1);
        description.render.max_depth = Some(render.fixed_depth().max(2));
        description.render.accuracy = Some(Accuracy::Fixed(Fixed {}));
        let mut build = |precision| {
            if control.cancelled.load(Ordering::Relaxed) {
                return Err(Stopped::Cancelled);
            }
            description.render.precision = precision;
            let options = CompileOptions { spd_counts, ..CompileOptions::default() };
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
    fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Seconds until a share of the time is over; below 0 after it.
    fn left(&self, share: f64) -> f64 {
        share * self.seconds - self.elapsed()
    }

    fn resize(&mut self, [width, height]: [u32; 2]) {
        self.single.set_size(&self.camera, width, height);
        self.double.set_size(&self.camera, width, height);
    }

    /// A picture with some settings; none if it is not done before a share of the time is over.
    fn shoot(&mut self, settings: Settings, end: f64) -> Result<Option<Picture>, Cancelled> {
        self.control.done.store(milliseconds(self.started) as u64, Ordering::Relaxed);
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
        while_wanted(self.control, deadline, |control| self.workers.work(|| render(scene, whole, control))?)
    }

    /// Compares two pictures on the pool; none if nobody wants to know any more.
    fn compare(&self, reference: &Codes8, test: &Codes8) -> Option<Difference> {
        self.workers.work(|| Difference::of(reference, test)).ok()
    }
}

/// Does some work that is cancelled at a deadline, which gives none, or with `outer`.
fn while_wanted<T>(
    outer: &Control,
    deadline: Instant,
    work: impl FnOnce(&Control) -> Result<T, Cancelled>,
) -> Result<Option<T>, Cancelled> {
    let inner = Control::default();
    let given_up = || outer.cancelled.load(Ordering::Relaxed);
    let result = thread::scope(|scope| {
        // Dropping the sender, even by a panic in `work`, ends the looks.
        let (working, done) = mpsc::channel::<()>();
        let inner = &inner;
        scope.spawn(move || {
            while done.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
                if given_up() || Instant::now() >= deadline {
                    inner.cancelled.store(true, Ordering::Relaxed);
                }
            }
        });
        let result = work(inner);
        drop(working);
        result
    });
    match result {
        Ok(done) => Ok(Some(done)),
        Err(Cancelled) if given_up() => Err(Cancelled),
        Err(Cancelled) => Ok(None),
    }
}

/// What the small picture says.
struct Trial {
    pixels: f64,
    /// Seconds of one round, of comparing two pictures, and of all references.
    round: f64,
    comparison: f64,
    references: f64,
    /// Depth and weight of the references.
    recursion: (u32, f64),
    /// What following lighter rays than those of the references changes.
    finer: Option<Finer>,
}

impl Trial {
    fn run(stage: &mut Stage<'_>, points: &[Point], asked: Settings) -> Result<Self, Cancelled> {
        let size = scaled([stage.single.width, stage.single.height], TRIAL_PIXELS);
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        stage.resize(size);
        let mut trial = Self {
            pixels,
            round: 0.0,
            comparison: 0.0,
            references: 0.0,
            recursion: (DEPTH.max(asked.max_depth), WEIGHTS[0].min(asked.min_weight)),
            finer: None,
        };
        for point in points {
            // Half of this part is for the references, without which there would be no errors.
            if let Some(picture) = stage.shoot(point.settings, 0.5 * ENDS[0])? {
                trial.round += picture.trace_ms / 1e3;
                if trial.comparison == 0.0 {
                    let codes = Codes8::from(&picture.film);
                    let begun = Instant::now();
                    stage.compare(&codes, &codes);
                    trial.comparison = milliseconds(begun) / 1e3;
                }
            }
        }
        let samples: f64 =
            positions(points).iter().map(|&(n, smooth)| f64::from(n) + if smooth { 5.0 } else { 0.0 }).sum();
        // One after the other: weight, picture, seconds of all references.
        let mut steps: Vec<(f64, Codes8, f64)> = Vec::new();
        let mut patience = f64::INFINITY;
        for min_weight in WEIGHTS.map(|weight| weight.min(asked.min_weight)) {
            if steps.last().is_some_and(|(before, ..)| *before == min_weight) {
                continue;
            }
            let end = ENDS[0].min((stage.elapsed() + patience) / stage.seconds);
            let settings = reference((trial.recursion.0, min_weight), (1, false));
            let Some(picture) = stage.shoot(settings, end)? else { break };
            let one = picture.trace_ms / 1e3;
            patience = 20.0 * one + 0.05;
            steps.push((min_weight, Codes8::from(&picture.film), samples * one));
            // Better references leave smaller pictures: beyond the weights of the points they take as long as two rounds at
            // most. One more is only looked at.
            if min_weight < FINEST && samples * one > 2.0 * trial.round {
                break;
            }
        }
        // The last step says what following still lighter rays would change, unless there is nothing lighter.
        let beyond = steps.last().filter(|(weight, ..)| *weight > 0.0 && steps.len() > 1).cloned();
        if beyond.is_some() {
            steps.pop();
        }
        if let Some((weight, codes, all)) = steps.last() {
            (trial.recursion.1, trial.references) = (*weight, *all);
            trial.finer =
                beyond.map(|(min_weight, finer, _)| Finer { min_weight, max_codes: largest_difference(codes, &finer) });
        }
        Ok(trial)
    }

    /// The size of the pictures that the time suffices for, at most as asked.
    fn size_for(&self, stage: &Stage<'_>, asked: [u32; 2], points: usize) -> [u32; 2] {
        let planned = ROUNDS[0] as f64 * self.round + self.references + 2.0 * points as f64 * self.comparison;
        let pixels = self.pixels * stage.left(PLANNED) / planned.max(1e-9);
        scaled(asked, pixels.clamp(self.pixels, MOST_PIXELS))
    }
}

/// A size of the same shape with at most about so many pixels, and no larger.
fn scaled([width, height]: [u32; 2], pixels: f64) -> [u32; 2] {
    let factor = (pixels / (f64::from(width) * f64::from(height))).sqrt().min(1.0);
    [width, height].map(|side| ((f64::from(side) * factor).round() as u32).max(1))
}

fn largest_difference(a: &Codes8, b: &Codes8) -> u8 {
    a.pixels.as_flattened().iter().zip(b.pixels.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Where samples may lie, each once, the fewest samples first.
fn positions(points: &[Point]) -> Vec<(u32, bool)> {
    let mut all: Vec<_> = points.iter().map(|point| point.settings.positions()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn reference((max_depth, min_weight): (u32, f64), (samples, antialias): (u32, bool)) -> Settings {
    Settings { max_depth, min_weight, max_codes: None, samples, antialias, precision: Precision::Double }
}

/// Pictures in double precision, their recursion followed as far as possible, for each way that samples lie.
struct References {
    /// Their depth and weight.
    recursion: (u32, f64),
    by_positions: Vec<((u32, bool), Codes8)>,
    /// What each of them misses for having too few samples.
    sampling: Vec<Option<Difference>>,
}

impl References {
    /// Traces as many as the time suffices for; also how many rays were dropped.
    fn trace(stage: &mut Stage<'_>, points: &[Point], recursion: (u32, f64)) -> Result<(Self, u64), Cancelled> {
        let (mut by_positions, mut dropped) = (Vec::new(), 0);
        for positions in positions(points) {
            if let Some(picture) = stage.shoot(reference(recursion, positions), ENDS[1])? {
                dropped += picture.rays.dropped;
                by_positions.push((positions, Codes8::from(&picture.film)));
            }
        }
        let mut references = Self { recursion, by_positions, sampling: Vec::new() };
        let sampling = |(_, codes): &(_, Codes8)| references.best().and_then(|best| stage.compare(best, codes));
        references.sampling = references.by_positions.iter().map(sampling).collect();
        Ok((references, dropped))
    }

    fn place(&self, positions: (u32, bool)) -> Option<usize> {
        self.by_positions.iter().position(|(known, _)| *known == positions)
    }

    fn same(&self, settings: Settings) -> Option<&Codes8> {
        self.place(settings.positions()).map(|i| &self.by_positions[i].1)
    }

    fn best(&self) -> Option<&Codes8> {
        self.place((REFERENCE_SAMPLES, false)).map(|i| &self.by_positions[i].1)
    }

    /// Errors of a picture; no truncation of one that follows rays further than its reference.
    fn errors(&self, stage: &Stage<'_>, settings: Settings, picture: &Codes8) -> Errors {
        let (depth, weight) = self.recursion;
        let comparable = settings.max_codes.is_some() || settings.max_depth <= depth && settings.min_weight >= weight;
        Errors {
            truncation: self.same(settings).filter(|_| comparable).and_then(|same| stage.compare(same, picture)),
            sampling: self.place(settings.positions()).and_then(|i| self.sampling[i]),
            total: self.best().and_then(|best| stage.compare(best, picture)),
        }
    }

    fn thumbnails(&self, settings: Settings, picture: &Codes8) -> Thumbnails {
        Thumbnails {
            picture: picture.thumbnail(),
            truncation: self.same(settings).map(|same| picture.difference(same)),
            total: self.best().map(|best| picture.difference(best)),
        }
    }
}

/// The date by Coordinated Universal Time, as YYYY-MM-DD.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    date(seconds / 86_400)
}

/// The date so many days after 1 January 1970. Years are counted from March, so that leap days end them: 146,097 days are
/// 400 years, and 153 five months from March, August or January.
fn date(days: u64) -> String {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", era * 400 + year + next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (days, text) in [
            (0, "1970-01-01"),
            (59, "1970-03-01"),
            (11_016, "2000-02-29"),
            (20_779, "2026-11-22"),
            (20_818, "2026-12-31"),
        ] {
            assert_eq!(date(days), text);
        }
    }

    #[test]
    fn sizes_keep_their_shape_and_never_grow() {
        assert_eq!(scaled([640, 400], 64_000.0), [320, 200]);
        assert_eq!(scaled([40, 30], 1e6), [40, 30]);
        assert_eq!(scaled([16_384, 1], 100.0), [1280, 1]);
    }
}
