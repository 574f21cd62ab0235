//! Who renders the tiles of a job, and where finished ones are kept: this process and a file, or the nodes of the farm and the
//! broker. The pictures are the same bytes.

use super::checkpoint::Tiles;
use super::files::Files;
use super::job::{Job, Stopped};
use super::record::{Failure, Record};
use super::rendering::Rendering;
use crate::service::error::{is_full, is_temporary, not_reachable};
use crate::service::farm::Farm;
use crate::service::farm::coordinator::{self, Order};
use crate::service::farm::names::Class;
use crate::service::farm::work::{Death, SceneSource};
use crate::service::pictures::tile_bytes::{Owner, Tile};
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::Duration;
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Cancelled, render};

/// Time until what the disk had no room for is written again.
const BETWEEN_WRITES: Duration = Duration::from_millis(500);
/// Finished tiles that wait for the disk.
const WAITING: usize = 4;

/// Who renders the tiles of a job.
pub(super) trait Backend {
    /// Calls `found` with tiles that were finished before.
    fn recover(&mut self, job: &Job, rendering: &Rendering, found: &mut dyn FnMut(Tile)) -> Result<(), Stopped>;
    /// Renders all tiles that are to come, and calls `finished` with each once it is kept.
    fn render(
        &mut self,
        job: &Job,
        rendering: &Rendering,
        ready: &PreparedScene,
        workers: &Workers,
        finished: &(dyn Fn(&Tile) + Sync),
    ) -> Result<(), Stopped>;
    /// Whether coarse pictures take nothing from the tiles, since others render those.
    fn is_remote(&self) -> bool;
}

/// This process and a file.
#[derive(Debug)]
pub(super) struct Local<'a> {
    files: &'a Files,
    tiles: Option<Tiles>,
}

impl<'a> Local<'a> {
    pub(super) fn new(files: &'a Files) -> Self {
        Self { files, tiles: None }
    }
}

impl Backend for Local<'_> {
    fn recover(&mut self, job: &Job, rendering: &Rendering, found: &mut dyn FnMut(Tile)) -> Result<(), Stopped> {
        let Record { width, height, .. } = job.record().clone();
        let Rendering { name, tiles, .. } = rendering;
        let region = |number: u32| tiles.get(number as usize).map(|(region, _)| *region);
        // Tiles that are found twice count once.
        let file =
            until_possible(job, || Tiles::open(&self.files.tiles(name), name, [width, height], region, &mut *found));
        self.tiles = Some(file.map_err(|error| job.why_stopped_or(disk(&error)))?);
        Ok(())
    }

    fn render(
        &mut self,
        job: &Job,
        rendering: &Rendering,
        ready: &PreparedScene,
        workers: &Workers,
        finished: &(dyn Fn(&Tile) + Sync),
    ) -> Result<(), Stopped> {
        let Some(file) = self.tiles.take() else { return Ok(()) };
        let (done, to_keep) = sync_channel(WAITING);
        // Another thread writes, so that the pool does not wait for the disk.
        let rendered = thread::scope(|scope| {
            let writer = scope.spawn(move || persist(job, file, &to_keep, finished));
            let rendered = workers.work(|| {
                while let Some((number, region)) = rendering.next() {
                    let picture = render(&ready.scene, region, &job.control())?;
                    // It fails only if the writer has panicked.
                    done.send(Tile { number, picture }).map_err(|_| Cancelled)?;
                }
                Ok(())
            });
            drop(done);
            writer.join().map_err(|_| Cancelled).and(rendered?)
        });
        rendered.map_err(|Cancelled| job.why_stopped())
    }

    fn is_remote(&self) -> bool {
        false
    }
}

fn persist(job: &Job, mut file: Tiles, done: &Receiver<Tile>, finished: &(dyn Fn(&Tile) + Sync)) {
    let mut keeps = true;
    while let Ok(tile) = done.recv() {
        let kept = if keeps { file.add(&tile) } else { Ok(()) };
        if let Err(error) = kept {
            // The tiles are in the picture all the same. After a crash they are rendered again.
            tracing::warn!(job = job.record().id, %error, "a finished tile is not kept");
            if is_full(&error) {
                // The picture needs the room more.
                keeps = false;
                let _ = file.clear();
            }
        }
        finished(&tile);
    }
}

/// The nodes of the farm and the broker.
pub(super) struct Remote<'a> {
    pub(super) farm: &'a Arc<Farm>,
    /// The part of the farm that the job may have.
    pub(super) share: &'a dyn Fn() -> f64,
    /// How long a piece may take.
    pub(super) limit: Duration,
}

impl Backend for Remote<'_> {
    fn recover(&mut self, job: &Job, rendering: &Rendering, found: &mut dyn FnMut(Tile)) -> Result<(), Stopped> {
        let Record { width, height, lives, .. } = job.record().clone();
        let Rendering { name, tiles, .. } = rendering;
        // The first front that takes a job begins its first life.
        if lives <= 1 {
            return Ok(());
        }
        let region = |number: u32| tiles.get(number as usize).map(|(region, _)| *region);
        let (owner, results) = (Owner::of(name), &self.farm.results);
        let mut after = 0;
        let next = |after| self.farm.runtime.block_on(results.next(name, after)).map_err(not_reachable);
        let stopped = |error| job.why_stopped_or(disk(&error));
        while let Some((sequence, bytes)) = until_possible(job, || next(after)).map_err(stopped)? {
            after = sequence;
            // What is damaged is rendered again.
            if let Ok(Some((tile, _))) = owner.read(&mut bytes.as_slice(), [width, height], region) {
                found(tile);
            }
            if job.control().is_cancelled() {
                return Err(job.why_stopped());
            }
        }
        Ok(())
    }

    fn render(
        &mut self,
        job: &Job,
        rendering: &Rendering,
        ready: &PreparedScene,
        workers: &Workers,
        finished: &(dyn Fn(&Tile) + Sync),
    ) -> Result<(), Stopped> {
        let record = job.record().clone();
        let (pixels, control) = (f64::from(record.width) * f64::from(record.height), job.control());
        let frames = record.frames.map_or(1.0, |frames| f64::from(frames.count));
        let order = Order {
            name: &rendering.name,
            tenant: &record.tenant,
            class: Class::of_job(record.priority),
            scene: scene_of(job, rendering.frame),
            window: Window::whole(ready.scene.width, ready.scene.height),
            // The estimate is for all threads of this process.
            pixel_ms: record.estimate_ms * workers.threads() as f64 / (pixels * frames),
            limit: self.limit,
            control: &control,
        };
        let mut tiles = OfPicture { rendering, share: self.share, finished };
        self.farm.render(&order, &mut tiles).map_err(|stopped| match stopped {
            coordinator::Stopped::Cancelled => job.why_stopped(),
            coordinator::Stopped::Dead(Death::Killed, detail) => {
                Stopped::Failed(Failure { slug: "abandoned".into(), detail })
            }
            coordinator::Stopped::TooLarge(detail) => Stopped::Failed(Failure::too_large(&detail)),
            coordinator::Stopped::Dead(_, detail) => Stopped::Failed(Failure::internal(&detail)),
            coordinator::Stopped::Broker(error) => {
                Stopped::Failed(Failure::internal(&format!("the farm's broker: {error}")))
            }
        })
    }

    fn is_remote(&self) -> bool {
        true
    }
}

/// The scene of a job, as nodes find it.
pub(super) fn scene_of(job: &Job, frame: Option<u32>) -> SceneSource {
    let spec = &job.record().spec;
    SceneSource { text: spec.scene.clone(), format: spec.format, settings: spec.settings, frame }
}

/// The tiles of a picture, as a coordinator takes them.
struct OfPicture<'a> {
    rendering: &'a Rendering,
    share: &'a dyn Fn() -> f64,
    finished: &'a (dyn Fn(&Tile) + Sync),
}

impl coordinator::Tiles for OfPicture<'_> {
    fn next(&mut self) -> Option<(u32, Region)> {
        self.rendering.next()
    }

    fn pixels_left(&self) -> u64 {
        self.rendering.pixels_left()
    }

    fn share(&self) -> f64 {
        (self.share)()
    }

    fn finished(&mut self, tile: Tile) -> bool {
        (self.finished)(&tile);
        true
    }
}

/// Reads or writes what belongs to a job. While the disk is full, or the farm's broker or its store does not answer, it waits until
/// the job is stopped.
pub(super) fn until_possible<T>(job: &Job, mut work: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let mut is_told = false;
    loop {
        match work() {
            Err(error) if is_temporary(&error) && !job.control().is_cancelled() => {
                if !is_told {
                    tracing::error!(job = job.record().id, %error, "a job waits until its files can be read and written");
                }
                is_told = true;
                job.waits.store(true, Ordering::Relaxed);
                thread::sleep(BETWEEN_WRITES);
            }
            done => {
                job.waits.store(false, Ordering::Relaxed);
                return done;
            }
        }
    }
}

/// A file of the job cannot be read or written.
pub(super) fn disk(error: &io::Error) -> Stopped {
    Stopped::Failed(Failure::internal(&format!("a file of the job cannot be read or written: {}", error.kind())))
}
