//! A job in memory: its record, progress and watchers.

use super::event_log::{EventPublisher, Events};
use super::record::{Failure, Record, State, Stats};
use super::rendering::{Rendering, tiles_of};
use super::tile_order::REMEMBERED;
use super::waiters::Waiters;
use crate::service::error::Error;
use parking_lot::{Mutex, MutexGuard};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use strahl::film::{Film, Region};
use strahl::render::Control;

/// A job.
#[derive(Debug)]
pub(crate) struct Job {
    record: Mutex<Record>,
    /// Revision of the record, where records live. It changes under the record's lock.
    stored: AtomicU64,
    /// Held while the record is changed where records live.
    pub(super) changing: Mutex<()>,
    /// Its events.
    pub(crate) events: Events,
    /// Stops its render. Each render has its own.
    control: Mutex<Control>,
    /// Why it was stopped. The first reason counts.
    pub(super) stopped: Mutex<Option<Stopped>>,
    /// Shared with its task in the scheduler.
    pub(super) priority: Arc<AtomicU8>,
    /// Its picture while it is being rendered; of a sequence the frame that was begun last.
    rendering: Mutex<Option<Arc<Rendering>>>,
    /// Regions that clients asked for before it was started.
    pub(super) early_looks: Mutex<Vec<Region>>,
    /// Number of tiles, of all frames.
    pub(super) total: usize,
    pub(super) done: AtomicUsize,
    pub(super) rays: AtomicU64,
    /// Number of changes of the preview.
    pub(super) revision: AtomicU64,
    /// Whether its owner does not want to see it any more.
    pub(super) forgotten: AtomicBool,
    /// Whether it waits until its files or its record can be read and written.
    pub(super) waits: AtomicBool,
    watchers: AtomicUsize,
    /// Requests that wait for it.
    pub(crate) waiters: Waiters,
    /// When this process began to render it.
    pub(super) begun: Mutex<Option<Instant>>,
    /// Estimated milliseconds until it is done, as the front that renders it has said, and when.
    eta: Mutex<Option<(f64, Instant)>>,
    /// When this process has heard last of it after its end.
    pub(super) left: Mutex<Option<Instant>>,
    /// When it began with the tiles, and how many were done then.
    pub(super) tiling: Mutex<Option<(Instant, f64)>>,
    /// When it was accepted. Capped at the time since which the clock counts.
    pub(super) since: Instant,
}

/// Why a job was stopped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stopped {
    /// The owner has canceled it.
    Canceled,
    /// The service shuts down. The next process resumes it.
    Suspended,
    /// It has failed.
    Failed(Failure),
    /// It has failed here for want of memory, of which another front may have enough.
    TooLarge(Failure),
    /// Another front has it, or has ended it. What this one does with it counts no more.
    Taken,
}

impl From<Error> for Stopped {
    fn from(error: Error) -> Self {
        let failure = Failure::from(&error);
        match error {
            Error::Limit { name: "memory_bytes", .. } => Self::TooLarge(failure),
            _ => Self::Failed(failure),
        }
    }
}

/// Progress of a job.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Progress {
    /// Finished tiles.
    pub(crate) done: usize,
    /// All tiles.
    pub(crate) total: usize,
    /// Rays of the finished tiles.
    pub(crate) rays: u64,
    /// Estimated milliseconds until it is done, once this process has begun to render it.
    pub(crate) eta_ms: Option<f64>,
}

impl Job {
    /// A job that this process has not started, at a revision of its record.
    pub(super) fn new(record: Record, revision: u64, publisher: Option<Arc<dyn EventPublisher>>) -> Self {
        let total = tiles_of(&record) * record.frames.map_or(1, |frames| frames.count as usize);
        let age = Duration::from_millis(super::record::now().saturating_sub(record.created));
        let events = Events::new(record.lives, publisher.map(|publisher| (publisher, record.id.clone())));
        Self {
            events,
            stored: AtomicU64::new(revision),
            changing: Mutex::default(),
            control: Mutex::default(),
            stopped: Mutex::default(),
            priority: Arc::new(AtomicU8::new(record.priority)),
            rendering: Mutex::default(),
            early_looks: Mutex::default(),
            total,
            done: AtomicUsize::new(0),
            rays: AtomicU64::new(record.stats.rays),
            revision: AtomicU64::new(0),
            forgotten: AtomicBool::new(false),
            waits: AtomicBool::new(false),
            watchers: AtomicUsize::new(0),
            waiters: Waiters::default(),
            begun: Mutex::default(),
            eta: Mutex::default(),
            left: Mutex::new(record.state.is_final().then(Instant::now)),
            tiling: Mutex::default(),
            since: Instant::now().checked_sub(age).unwrap_or_else(Instant::now),
            record: Mutex::new(record),
        }
    }

    /// Locks its record.
    pub(crate) fn record(&self) -> MutexGuard<'_, Record> {
        self.record.lock()
    }

    /// Its record and the revision of that.
    pub(super) fn stored(&self) -> (Record, u64) {
        let record = self.record();
        (record.clone(), self.stored.load(Ordering::Relaxed))
    }

    /// Takes over a record, unless it is older than the one that is here, which is returned.
    pub(super) fn adopt(&self, record: Record, revision: u64) -> Option<Record> {
        let mut here = self.record();
        if revision <= self.stored.load(Ordering::Relaxed) {
            return None;
        }
        self.stored.store(revision, Ordering::Relaxed);
        self.priority.store(record.priority, Ordering::Relaxed);
        // What a render measures is here first; how long it waited is in what was written.
        let (stats, frames) = match record.lives == here.lives && !record.state.is_final() {
            true => (Stats { queue_ms: record.stats.queue_ms, ..here.stats }, here.frames),
            false => (record.stats, record.frames),
        };
        Some(std::mem::replace(&mut *here, Record { stats, frames, ..record }))
    }

    /// What stops its render.
    pub(super) fn control(&self) -> Control {
        self.control.lock().clone()
    }

    /// As if no process had begun to render it.
    pub(super) fn reset(&self) {
        *self.control.lock() = Control::default();
        *self.stopped.lock() = None;
        *self.begun.lock() = None;
        *self.tiling.lock() = None;
    }

    /// From now on it shows this picture, or frame, of which nothing is done.
    pub(super) fn begin_picture(&self, frame: Option<u32>) -> Arc<Rendering> {
        let rendering = Arc::new(Rendering::of(&self.record(), frame));
        *rendering.last_preview.lock() = self.rendering().and_then(|before| before.preview());
        *self.rendering.lock() = Some(Arc::clone(&rendering));
        rendering
    }

    /// The picture that is being rendered.
    pub(super) fn rendering(&self) -> Option<Arc<Rendering>> {
        self.rendering.lock().clone()
    }

    /// It is not rendered any more.
    pub(super) fn end_picture(&self) {
        *self.rendering.lock() = None;
    }

    /// Notes how far the front that renders it has come.
    pub(super) fn hear_progress(&self, done: usize, rays: Option<u64>, eta_ms: Option<f64>, revision: Option<u64>) {
        self.done.store(done, Ordering::Relaxed);
        if let Some(rays) = rays {
            self.rays.store(rays, Ordering::Relaxed);
        }
        if let Some(eta) = eta_ms {
            *self.eta.lock() = Some((eta, Instant::now()));
        }
        self.hear_preview(revision);
    }

    /// Notes how many frames the front that renders it has finished.
    pub(super) fn hear_frame(&self, done: u32) {
        self.record().frames.iter_mut().for_each(|frames| frames.done = done);
    }

    /// Notes the revision of the preview at the front that renders it.
    pub(super) fn hear_preview(&self, revision: Option<u64>) {
        if let Some(revision) = revision {
            self.revision.store(revision, Ordering::Relaxed);
        }
    }

    /// Forgets what a job that has ended needs no more: its events.
    pub(super) fn rest(&self) {
        *self.early_looks.lock() = Vec::new();
        self.events.forget();
    }

    /// The work that is done, in tiles of as many rays as all have on average: expensive tiles often come first. Counts finished tiles
    /// where the number of rays was not estimated.
    pub(super) fn work_done(&self) -> f64 {
        let estimate = self.record().estimate_rays;
        if estimate == 0 {
            return self.done.load(Ordering::Relaxed) as f64;
        }
        self.total as f64 * (self.rays.load(Ordering::Relaxed) as f64 / estimate as f64).min(1.0)
    }

    /// Its progress.
    pub(crate) fn progress(&self) -> Progress {
        let total = self.total;
        let done = if self.record().state == State::Succeeded { total } else { self.done.load(Ordering::Relaxed) };
        let begun = (*self.begun.lock()).map(|begun| begun.elapsed().as_secs_f64() * 1e3);
        let worked = self.work_done();
        let tiling = (*self.tiling.lock())
            .map(|(since, before)| Tiling { done: worked - before, ms: since.elapsed().as_secs_f64() * 1e3 });
        let estimate_ms = self.record().estimate_ms;
        // More rays than estimated leave little, but something, to do.
        let left = (total as f64 - worked).max(0.1 * total.saturating_sub(done) as f64);
        let told = *self.eta.lock();
        let eta_ms = begun
            .map(|begun| eta_ms(estimate_ms, begun, tiling, total as f64, left))
            .or_else(|| told.map(|(eta, then)| (eta - then.elapsed().as_secs_f64() * 1e3).max(0.0)));
        Progress { done, total, rays: self.rays.load(Ordering::Relaxed), eta_ms }
    }

    /// Renders the tiles of a region next, since a client has asked for it.
    pub(crate) fn look(&self, region: Region) {
        if let Some(rendering) = self.rendering()
            && let Some(order) = &mut *rendering.order.lock()
        {
            order.look(region);
            return;
        }
        let mut early = self.early_looks.lock();
        if early.len() < REMEMBERED {
            early.push(region);
        }
    }

    /// A region of the picture, if all of it is finished.
    pub(crate) fn finished_part(&self, region: Region) -> Option<Film> {
        self.rendering()?.finished_part(region)
    }

    /// The preview and its revision, once anything has been rendered.
    pub(crate) fn preview(&self) -> Option<(Film, u64)> {
        let revision = self.revision();
        let preview = self.rendering().filter(|_| revision > 0)?.preview()?;
        Some((preview, revision))
    }

    /// Whether there is a preview.
    pub(crate) fn has_preview(&self) -> bool {
        self.revision() > 0 && self.rendering().is_some_and(|rendering| rendering.has_preview())
    }

    /// Revision of the preview.
    pub(crate) fn revision(&self) -> u64 {
        self.revision.load(Ordering::Relaxed)
    }

    /// Counts a watcher until the guard is dropped. Finer previews are made for watched jobs only.
    pub(crate) fn watch(self: &Arc<Self>) -> Watcher {
        self.watchers.fetch_add(1, Ordering::Relaxed);
        Watcher(Arc::clone(self))
    }

    /// Tells watchers of a preview whose pixels are so far apart in the picture, across and down.
    pub(super) fn publish_preview(&self, pass: u32, scale: u32) {
        let revision = self.revision.fetch_add(1, Ordering::Relaxed) + 1;
        self.events.publish("preview", json!({ "pass": pass, "scale": scale, "revision": revision }));
    }

    /// Whether any client watches it.
    pub(super) fn is_watched(&self) -> bool {
        self.watchers.load(Ordering::Relaxed) > 0
    }

    /// Why it was stopped.
    pub(super) fn why_stopped(&self) -> Stopped {
        self.why_stopped_or(Stopped::Failed(Failure::internal("the render ended early")))
    }

    /// Why it was stopped, or else why it has failed.
    pub(super) fn why_stopped_or(&self, otherwise: Stopped) -> Stopped {
        self.stopped.lock().clone().unwrap_or(otherwise)
    }

    /// Stops the render, for the first reason given.
    pub(super) fn stop(&self, why: Stopped) {
        self.stopped.lock().get_or_insert(why);
        self.control().cancel();
    }
}

/// A client that watches a job.
#[derive(Debug)]
pub(crate) struct Watcher(Arc<Job>);

impl Drop for Watcher {
    fn drop(&mut self) {
        self.0.watchers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The tiles' worth of work that a process has done, and the milliseconds it took.
#[derive(Debug, Clone, Copy)]
struct Tiling {
    done: f64,
    ms: f64,
}

/// Estimated milliseconds until a job is done that was begun so many ago: by its estimate, and more and more by its tiles.
fn eta_ms(estimate_ms: f64, begun: f64, tiling: Option<Tiling>, total: f64, left: f64) -> f64 {
    let share = estimate_ms / total;
    match tiling {
        Some(Tiling { done, ms }) if done > 0.0 => {
            let trusted = total / 8.0;
            left * (trusted * share + ms) / (trusted + done)
        }
        // Passes before the tiles are not part of the estimate; it cannot be over before the first tile.
        _ => (left * share - tiling.map_or(begun, |tiling| tiling.ms)).max(0.5 * left * share),
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::JobSpec;
    use super::*;
    use strahl::film::FileFormat;
    use strahl::scene::{Format, Overrides};

    #[test]
    fn the_first_tiles_hardly_change_what_was_estimated() {
        let tiles = |done: f64, ms: f64| Some(Tiling { done, ms });
        assert_eq!(eta_ms(12_000.0, 0.0, None, 100.0, 100.0), 12_000.0);
        // The passes took a third, and the first tile ten times as long as others.
        assert!((10_000.0..22_000.0).contains(&eta_ms(12_000.0, 5_200.0, tiles(1.0, 1_200.0), 100.0, 99.0)));
        assert!((5_900.0..6_100.0).contains(&eta_ms(12_000.0, 9_000.0, tiles(50.0, 6_000.0), 100.0, 50.0)));
        // An estimate that was wrong by far is forgotten.
        assert!((55_000.0..60_000.0).contains(&eta_ms(12_000.0, 60_000.0, tiles(50.0, 69_000.0), 100.0, 50.0)));
        assert_eq!(eta_ms(12_000.0, 12_500.0, None, 1.0, 1.0), 6_000.0);
        assert_eq!(eta_ms(12_000.0, 12_500.0, tiles(1.0, 12_000.0), 1.0, 0.0), 0.0);
    }

    /// A fifth of the tiles with most of the rays is most of the work.
    #[test]
    fn dear_tiles_that_come_first_do_not_raise_the_eta() {
        let spec = JobSpec {
            scene: String::new(),
            format: Format::Json,
            settings: Overrides::default(),
            output: FileFormat::Png8,
        };
        let size = Record { width: 100, height: 100, edge: 10, ..Record::new(spec) };
        let job = Job::new(Record { estimate_ms: 20_000.0, estimate_rays: 1_000_000, ..size }, 1, None);
        let ago = |ms: u64| Instant::now().checked_sub(Duration::from_millis(ms)).unwrap();
        *job.begun.lock() = Some(ago(14_000));
        *job.tiling.lock() = Some((ago(14_000), 0.0));
        job.done.store(18, Ordering::Relaxed);
        job.rays.store(600_000, Ordering::Relaxed);
        let eta = job.progress().eta_ms.unwrap();
        assert!((7_000.0..11_000.0).contains(&eta), "{eta}");
    }

    #[test]
    fn a_job_at_rest_still_says_how_it_ended() {
        let (settings, output) = (Overrides::default(), FileFormat::Png8);
        let spec = JobSpec { scene: String::new(), format: Format::Json, settings, output };
        let record = Record { width: 100, height: 50, edge: 16, lives: 2, ..Record::new(spec) };
        let job = Job::new(record.clone(), 1, None);
        assert_eq!((job.begin_picture(None).tiles.len(), job.progress().total), (28, 28));
        job.end_picture();
        let first = job.events.publish("tile", json!({}));
        let last = job.events.publish("succeeded", json!({}));
        job.record().state = State::Succeeded;
        job.rest();
        assert_eq!((job.progress().done, job.progress().total), (28, 28));
        assert_eq!((job.events.since(first), job.events.since(last)), (None, Some(Vec::new())));
        assert_eq!(job.events.last(), last);
        let whole = Job::new(Record { edge: 0, ..record }, 1, None);
        let tiles: Vec<Region> = whole.begin_picture(None).tiles.iter().map(|(region, _)| *region).collect();
        assert_eq!(tiles, [Region::whole(100, 50)]);
    }
}
