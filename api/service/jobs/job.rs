//! A job as the process that works on it sees it: its record, how far it is, and who watches.

use super::canvas::Canvas;
use super::event_log::Events;
use super::record::{Failure, Record, State};
use super::tile_order::{REMEMBERED, TileOrder, meet};
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use strahl::film::{Film, Region};
use strahl::render::Control;

/// A job.
#[derive(Debug)]
pub(crate) struct Job {
    record: Mutex<Record>,
    /// What happens to it.
    pub(crate) events: Events,
    /// Stops its render.
    pub(super) control: Control,
    /// Why it was stopped: the first reason counts.
    pub(super) stopped: Mutex<Option<Stopped>>,
    /// Shared with its seat on the pool.
    pub(super) priority: Arc<AtomicU8>,
    /// The picture so far, while it is being rendered.
    pub(super) canvas: Mutex<Option<Canvas>>,
    /// Which tile is next, while it is being rendered.
    pub(super) order: Mutex<Option<TileOrder>>,
    /// Looks at it before it was begun.
    pub(super) early_looks: Mutex<Vec<Region>>,
    /// Tiles by number, and whether they are finished.
    pub(super) tiles: Vec<(Region, AtomicBool)>,
    pub(super) done: AtomicUsize,
    pub(super) rays: AtomicU64,
    /// Rays that this process has traced for it, those of previews included.
    pub(super) spent: AtomicU64,
    /// Changes of the preview.
    pub(super) revision: AtomicU64,
    /// Bytes of its files, once it has succeeded.
    pub(super) kept: AtomicU64,
    /// Whether its owner does not want to see it any more.
    pub(super) forgotten: AtomicBool,
    watchers: AtomicUsize,
    /// When this process began it, and how many tiles were done then.
    pub(super) begun: Mutex<Option<(Instant, usize)>>,
    /// When it was accepted, as far as this process can say.
    pub(super) since: Instant,
}

/// Why a job does not go on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stopped {
    /// Its owner said so.
    Canceled,
    /// The service ends; another process goes on.
    Suspended,
    /// It cannot.
    Failed(Failure),
}

/// How far a job is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Progress {
    /// Finished tiles.
    pub(crate) done: usize,
    /// All tiles.
    pub(crate) total: usize,
    /// Rays of the finished ones.
    pub(crate) rays: u64,
    /// Milliseconds until it is done, once a tile has said how long they take.
    pub(crate) eta_ms: Option<f64>,
}

impl Job {
    /// A job that nobody has begun in this process.
    pub(super) fn new(record: Record) -> Self {
        let picture = Region::whole(record.width, record.height);
        let regions = if record.edge == 0 { vec![picture] } else { picture.tiles(record.edge).collect() };
        let age = Duration::from_millis(super::record::now().saturating_sub(record.created));
        let events = Events::new(record.lives);
        Self {
            events,
            control: Control::default(),
            stopped: Mutex::default(),
            priority: Arc::new(AtomicU8::new(record.priority)),
            canvas: Mutex::default(),
            order: Mutex::default(),
            early_looks: Mutex::default(),
            tiles: regions.into_iter().map(|region| (region, AtomicBool::new(false))).collect(),
            done: AtomicUsize::new(0),
            rays: AtomicU64::new(record.stats.rays),
            spent: AtomicU64::new(0),
            revision: AtomicU64::new(0),
            kept: AtomicU64::new(0),
            forgotten: AtomicBool::new(false),
            watchers: AtomicUsize::new(0),
            begun: Mutex::default(),
            since: Instant::now().checked_sub(age).unwrap_or_else(Instant::now),
            record: Mutex::new(record),
        }
    }

    /// Its record, for a moment.
    pub(crate) fn record(&self) -> MutexGuard<'_, Record> {
        locked(&self.record)
    }

    /// How far it is.
    pub(crate) fn progress(&self) -> Progress {
        let total = self.tiles.len();
        let done = if self.record().state == State::Succeeded { total } else { self.done.load(Ordering::Relaxed) };
        let eta_ms = (*locked(&self.begun)).and_then(|(begun, before)| {
            let here = done.saturating_sub(before);
            (here > 0).then(|| begun.elapsed().as_secs_f64() * 1e3 * (total - done) as f64 / here as f64)
        });
        Progress { done, total, rays: self.rays.load(Ordering::Relaxed), eta_ms }
    }

    /// Somebody looks at a region: its tiles are next.
    pub(crate) fn look(&self, region: Region) {
        match &mut *locked(&self.order) {
            Some(order) => order.look(region),
            None => {
                let mut early = locked(&self.early_looks);
                if early.len() < REMEMBERED {
                    early.push(region);
                }
            }
        }
    }

    /// A region of the picture, if all of it is finished.
    pub(crate) fn finished_part(&self, region: Region) -> Option<Film> {
        let is_done = |(tile, done): &(Region, AtomicBool)| !meet(*tile, region) || done.load(Ordering::Acquire);
        let canvas = locked(&self.canvas);
        canvas.as_ref().filter(|_| self.tiles.iter().all(is_done)).map(|canvas| canvas.crop(region))
    }

    /// The small picture so far and its revision; none before there is anything to see.
    pub(crate) fn preview(&self) -> Option<(Film, u64)> {
        let canvas = locked(&self.canvas);
        let revision = self.revision();
        canvas.as_ref().filter(|_| revision > 0).map(|canvas| (canvas.preview().clone(), revision))
    }

    /// Number of the preview.
    pub(crate) fn revision(&self) -> u64 {
        self.revision.load(Ordering::Relaxed)
    }

    /// Somebody watches until the guard is dropped: finer previews are worth their rays.
    pub(crate) fn watch(self: &Arc<Self>) -> Watcher {
        self.watchers.fetch_add(1, Ordering::Relaxed);
        Watcher(Arc::clone(self))
    }

    /// Whether somebody watches.
    pub(super) fn is_watched(&self) -> bool {
        self.watchers.load(Ordering::Relaxed) > 0
    }

    /// Stops the render, for the first reason given.
    pub(super) fn stop(&self, why: Stopped) {
        locked(&self.stopped).get_or_insert(why);
        self.control.cancel();
    }
}

/// Somebody who watches a job.
#[derive(Debug)]
pub(crate) struct Watcher(Arc<Job>);

impl Drop for Watcher {
    fn drop(&mut self) {
        self.0.watchers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A panic elsewhere leaves single values behind these locks, each of them whole.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
