//! Rendering one job, from its record to its picture, on a thread of its own.
//!
//! Another thread writes finished tiles to disk and publishes events, so that the pool does not wait for that.

use super::{CRASHES, Jobs, abandoned, frames};
use super::canvas::{Canvas, empty, paste};
use super::checkpoint::{Tile, Tiles};
use super::finish::code;
use super::job::{Job, Stopped, locked};
use super::record::{Failure, JobSpec, Record, State};
use super::registry::pixel_bytes;
use super::tile_order::TileOrder;
use crate::service::clock::milliseconds;
use crate::service::error::{Error, panic_text};
use crate::service::pictures::render::trace;
use crate::service::scenes::cache::{Form, SentScene};
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use crate::service::scheduler::task::{Class, Task};
use serde_json::json;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::{Duration, Instant};
use strahl::camera::Window;
use strahl::film::{FileFormat, Film, Region};
use strahl::render::{Cancelled, Watcher, render, render_window, sampling_bytes};
use strahl::scene::Scene;

/// Passes before the tiles. The pixels of the last one are twice as wide as the picture's, or as wide as the preview's, those
/// of the others twice and 4 times as wide as that.
const PASSES: u32 = 3;
/// Finished tiles that wait for the disk.
const WAITING: usize = 4;
/// Time until memory that was not there is asked for again.
const BETWEEN_TRIES: Duration = Duration::from_millis(200);
/// Time between two events about progress.
const BETWEEN_REPORTS: Duration = Duration::from_millis(200);

/// Works on a job until it is final or suspended.
pub(super) fn run(jobs: &Jobs, job: &Arc<Job>) {
    let is_sequence = job.record().frames.is_some();
    let work = if is_sequence { frames::work } else { work };
    let done = catch_unwind(AssertUnwindSafe(|| work(jobs, job)));
    let end = match done {
        Ok(Ok(())) => None,
        Ok(Err(stopped)) => Some(stopped),
        Err(panic) => {
            tracing::error!(job = job.record().id, panic = panic_text(&*panic), "a job panicked");
            Some(Stopped::Failed(internal("the render failed; the service goes on, and its log says more")))
        }
    };
    *locked(&job.canvas) = None;
    *locked(&job.order) = None;
    match end {
        Some(Stopped::Taken) => {}
        Some(Stopped::Suspended) => jobs.suspend(job),
        Some(Stopped::Canceled) => jobs.finish(job, State::Canceled, None),
        Some(Stopped::Failed(failure)) => jobs.finish(job, State::Failed, Some(failure)),
        None => {
            jobs.finish(job, State::Succeeded, None);
            let record = job.record().clone();
            if !is_sequence {
                jobs.let_go(&record);
            }
        }
    }
}

/// Makes a job one that runs here. Its part of the pool, what it renders, and the edge of its tiles.
pub(super) fn begin(jobs: &Jobs, job: &Arc<Job>) -> Result<(Workers, JobSpec, u32), Stopped> {
    if !jobs.begin(job).map_err(|error| disk(&error))? {
        return Err(Stopped::Taken);
    }
    let (task, spec, edge) = {
        let record = job.record();
        if record.crashes > CRASHES {
            return Err(Stopped::Failed(abandoned()));
        }
        let (tenant, weight) = (record.tenant.as_str().into(), record.weight);
        let task =
            Task { class: Class::Jobs, tenant, weight, priority: Arc::clone(&job.priority), waiting_since: job.since };
        (task, record.spec.clone(), record.edge)
    };
    Ok((Arc::clone(&jobs.pool).join(task, job.control()), spec, edge))
}

fn work(jobs: &Jobs, job: &Arc<Job>) -> Result<(), Stopped> {
    let began = Instant::now();
    let (workers, spec, edge) = begin(jobs, job)?;
    let text = when_there_is_room(job, || jobs.scene(&spec.scene));
    let text = text.map_err(|error| stopped_or(job, Stopped::Failed(Failure::from(&error))))?;
    let text = text.ok_or_else(scene_is_gone)?;
    let building = Instant::now();
    let form = Form::Whole(spec.format);
    let sent = SentScene::new(text.as_ref(), &form, &spec.settings);
    let found = when_there_is_room(job, || jobs.cache.find(&workers, &sent));
    drop(text);
    let ready = found.map_err(|error| stopped_or(job, Stopped::Failed(Failure::from(&error))))?.ready;
    let bvh_ms = milliseconds(building);
    job.record().stats.bvh_ms = bvh_ms;
    job.events.publish("started", json!({ "threads": workers.threads(), "bvh_ms": bvh_ms }));

    jobs.make_room();
    let mut share = jobs.cache.memory.share(ready.bytes());
    let sampling = sampling_bytes(&ready.scene, u64::from(ready.scene.width) * u64::from(ready.scene.height));
    let bytes = pixel_bytes(&job.record()) + ready.scene.stack_bytes() * workers.threads() as u64 + sampling;
    let taken = when_there_is_room(job, || share.grow(bytes));
    taken.map_err(|error| stopped_or(job, Stopped::Failed(Failure::from(&error))))?;
    let rendering = Instant::now();
    job.done.store(0, Ordering::Relaxed);
    job.rays.store(0, Ordering::Relaxed);
    job.record().stats.tiles_recovered = 0;
    if edge == 0 {
        whole(job, &ready, spec.output, &workers, began).map_err(|Cancelled| stopped(job))?;
    } else {
        let owner = job.record().id.clone();
        let file = recover(jobs, job, &owner).map_err(|error| disk(&error))?;
        *locked(&job.begun) = Some(rendering);
        if job.done.load(Ordering::Relaxed) == 0 {
            passes(job, &ready, &workers, edge).map_err(|Cancelled| stopped(job))?;
        }
        *locked(&job.tiling) = Some((Instant::now(), job.work_done()));
        tiles(job, &ready, &workers, file).map_err(|Cancelled| stopped(job))?;
    }
    job.record().stats.render_ms = milliseconds(rendering);

    let encoding = Instant::now();
    let canvas = locked(&job.canvas).take().ok_or_else(|| stopped(job))?;
    let image = job.record().image_id.clone();
    let entered = job.control().enter();
    let preview = |canvas: &Canvas| canvas.preview.clone();
    let coded = code(canvas, preview, &ready, &spec, &workers, began).map_err(|Cancelled| stopped(job))?;
    let rays = coded.rays();
    let finished = coded.files(&spec, image, &ready);
    drop(entered);
    if job.control().is_cancelled() {
        // The file may be cut short.
        return Err(stopped(job));
    }
    let record = job.record().clone();
    jobs.keep_picture(&record, &finished.made, &finished.preview).map_err(|error| disk(&error))?;
    let mut record = job.record();
    record.stats.encode_ms = milliseconds(encoding);
    record.stats.rays = rays;
    record.stats.picture_bytes = finished.made.bytes.len() as u64;
    Ok(())
}

/// Does something that needs memory, again and again until there is some.
pub(super) fn when_there_is_room<T>(job: &Job, mut work: impl FnMut() -> Result<T, Error>) -> Result<T, Error> {
    loop {
        match work() {
            Err(Error::Busy { .. }) if !job.control().is_cancelled() => thread::sleep(BETWEEN_TRIES),
            done => return done,
        }
    }
}

/// A picture that a clock or a number of rays ends, or one that no tiles are made of.
pub(super) fn whole(
    job: &Job,
    ready: &PreparedScene,
    output: FileFormat,
    workers: &Workers,
    began: Instant,
) -> Result<(), Cancelled> {
    *locked(&job.begun) = Some(Instant::now());
    let Scene { width, height, .. } = ready.scene;
    let (window, region) = (Window::whole(width, height), Region::whole(width, height));
    *locked(&job.canvas) = Some(Canvas::of_preview(width, height));
    let mut pass = 0;
    let mut show = |film: Film, distance: u32| {
        if let Some(canvas) = &mut *locked(&job.canvas) {
            canvas.fill(&film, 0);
        }
        pass += 1;
        job.publish_preview(pass, distance);
    };
    let watcher = Some(&mut show as Watcher<'_>);
    let (picture, ()) = trace(ready, &window, region, output, began, workers, &job.control(), watcher, |_| ())?;
    let rays = picture.rays.total();
    job.rays.fetch_add(rays, Ordering::Relaxed);
    *locked(&job.canvas) = Some(Canvas::of(picture));
    job.tiles()[0].1.store(true, Ordering::Release);
    job.done.fetch_add(1, Ordering::Relaxed);
    Ok(())
}

/// Opens the file of tiles and puts those of `owner` that are there onto a new canvas.
pub(super) fn recover(jobs: &Jobs, job: &Job, owner: &str) -> io::Result<Tiles> {
    let Record { ref id, width, height, .. } = job.record().clone();
    let mut canvas = Canvas::new(width, height);
    let (mut recovered, mut rays) = (0, 0);
    let tiles = job.tiles();
    let region = |number: u32| tiles.get(number as usize).map(|(region, _)| *region);
    let file = Tiles::open(&jobs.files.tiles(id), owner, [width, height], region, |Tile { number, picture }| {
        let (_, done) = &tiles[number as usize];
        if !done.swap(true, Ordering::Release) {
            canvas.finish(&picture);
            recovered += 1;
            rays += picture.rays.total();
        }
    })?;
    job.done.fetch_add(recovered, Ordering::Relaxed);
    job.rays.fetch_add(rays, Ordering::Relaxed);
    job.revision.fetch_add(u64::from(recovered > 0), Ordering::Relaxed);
    job.record().stats.tiles_recovered += recovered as u64;
    let regions = tiles.iter().map(|(region, _)| *region).collect();
    let is_done = |number: usize| tiles[number].1.load(Ordering::Relaxed);
    let mut order = TileOrder::new(regions, Region::whole(width, height), is_done);
    let mut current = locked(&job.order);
    locked(&job.early_looks).drain(..).for_each(|look| order.look(look));
    *current = Some(order);
    drop(current);
    *locked(&job.canvas) = Some(canvas);
    Ok(file)
}

/// Coarse pictures of it all, each finer than the one before. The last one is for watchers.
fn passes(job: &Job, ready: &PreparedScene, workers: &Workers, edge: u32) -> Result<(), Cancelled> {
    let scene = &ready.scene;
    let last = locked(&job.canvas).as_ref().map_or(1, |canvas| canvas.level().max(1));
    for (level, pass) in (last..last + PASSES).rev().zip(1..) {
        let is_looked_at = || locked(&job.order).as_ref().is_some_and(TileOrder::is_looked_at);
        if is_looked_at() || (level == last && !job.is_watched()) {
            break;
        }
        let Some(window) = Window::level(scene.width, scene.height, level as i32) else { continue };
        let whole = Region::whole(window.width, window.height);
        let mut coarse = empty([window.width, window.height], whole).film;
        let mut parts = whole.tiles(edge);
        let is_done = workers.work(|| {
            // Who looks at a tile wants it more than another pass.
            while !is_looked_at() {
                let Some(part) = parts.next() else { return Ok(true) };
                paste(&mut coarse, &render_window(scene, &window, part, &job.control())?.film);
            }
            Ok(false)
        })??;
        if !is_done {
            break;
        }
        if let Some(canvas) = &mut *locked(&job.canvas) {
            canvas.fill(&coarse, level);
        }
        job.publish_preview(pass, 1 << level);
    }
    Ok(())
}

/// All tiles that are not finished.
pub(super) fn tiles(job: &Job, ready: &PreparedScene, workers: &Workers, file: Tiles) -> Result<(), Cancelled> {
    let (finished, to_keep) = sync_channel(WAITING);
    thread::scope(|scope| {
        let writer = scope.spawn(move || persist_tiles(job, file, to_keep));
        let next = || locked(&job.order).as_mut().and_then(TileOrder::next);
        let rendered = workers.work(|| {
            while let Some((number, region)) = next() {
                let picture = render(&ready.scene, region, &job.control())?;
                // It fails if the writer has stopped, which has cancelled the job.
                finished.send(Tile { number: number as u32, picture }).map_err(|_| Cancelled)?;
            }
            Ok(())
        });
        drop(finished);
        let kept = writer.join().unwrap_or(Err(Cancelled));
        rendered?.and(kept)
    })
}

/// Writes tiles to disk and to the canvas, and publishes events.
fn persist_tiles(job: &Job, mut file: Tiles, finished: Receiver<Tile>) -> Result<(), Cancelled> {
    let mut reported: Option<Instant> = None;
    let tiles = job.tiles();
    while let Ok(tile) = finished.recv() {
        if let Err(error) = file.add(&tile) {
            tracing::error!(%error, "a finished tile cannot be kept");
            job.stop(disk(&error));
            return Err(Cancelled);
        }
        if let Some(canvas) = &mut *locked(&job.canvas) {
            canvas.finish(&tile.picture);
        }
        tiles[tile.number as usize].1.store(true, Ordering::Release);
        job.rays.fetch_add(tile.picture.rays.total(), Ordering::Relaxed);
        let done = job.done.fetch_add(1, Ordering::Relaxed) + 1;
        let revision = job.revision.fetch_add(1, Ordering::Relaxed) + 1;
        let Region { x, y, width, height } = tile.picture.film.region;
        let mut data = json!({ "x": x, "y": y, "w": width, "h": height, "tiles_done": done });
        if let Some(frame) = job.frame() {
            data["frame"] = frame.into();
        }
        job.events.publish("tile", data);
        if reported.is_none_or(|reported| reported.elapsed() >= BETWEEN_REPORTS) || done == job.total {
            let progress = job.progress();
            job.events.publish(
                "progress",
                json!({
                    "fraction": done as f64 / job.total as f64, "tiles_done": done, "rays": progress.rays,
                    "eta_ms": progress.eta_ms.map(f64::round), "revision": revision,
                }),
            );
            reported = Some(Instant::now());
        }
    }
    Ok(())
}

/// Why it was stopped.
pub(super) fn stopped(job: &Job) -> Stopped {
    stopped_or(job, Stopped::Failed(internal("the render ended early")))
}

pub(super) fn stopped_or(job: &Job, otherwise: Stopped) -> Stopped {
    locked(&job.stopped).clone().unwrap_or(otherwise)
}

fn internal(detail: &str) -> Failure {
    Failure { slug: "internal".into(), detail: detail.into() }
}

/// The text of the scene, which only the client can send again.
pub(super) fn scene_is_gone() -> Stopped {
    let detail = "the file with the scene of this job is damaged or gone; submit the job again, with its scene";
    Stopped::Failed(Failure { slug: "gone".into(), detail: detail.into() })
}

/// A file of the job cannot be read or written.
pub(super) fn disk(error: &io::Error) -> Stopped {
    Stopped::Failed(internal(&format!("a file of the job cannot be read or written: {}", error.kind())))
}
