//! Rendering one job, from its record to its picture, on a thread of its own.

use super::backend::{Backend, Local, Remote, disk, scene_of, until_possible};
use super::canvas::Canvas;
use super::finish::code;
use super::job::{Job, Stopped};
use super::record::{Failure, JobSpec, Record, State};
use super::registry::pixel_bytes;
use super::rendering::Rendering;
use super::tile_order::TileOrder;
use super::transitions::abandoned;
use super::{CRASHES, Jobs, frames};
use crate::service::clock::milliseconds;
use crate::service::error::{Error, panic_text};
use crate::service::farm::Farm;
use crate::service::pictures::assembly::{empty, paste};
use crate::service::pictures::render::trace;
use crate::service::pictures::tile_bytes::Tile;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::{Form, SentScene};
use crate::service::scheduler::pool::Workers;
use crate::service::scheduler::task::{Class, Task};
use parking_lot::Mutex;
use serde_json::json;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};
use strahl::camera::Window;
use strahl::film::{FileFormat, Film, Region};
use strahl::render::{Cancelled, Control, Watcher, render_window, sampling_bytes};
use strahl::scene::Scene;

/// Passes before the tiles. The pixels of the last one are twice as wide as the picture's, or as wide as the preview's, those
/// of the others twice and 4 times as wide as that.
const PASSES: u32 = 3;
/// Largest edge of tiles that nodes render: the broker takes messages of 1 MiB.
pub(super) const REMOTE_EDGE: u32 = 128;
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
            Some(Stopped::Failed(Failure::internal("the render failed; the service goes on, and its log says more")))
        }
    };
    job.end_picture();
    match end {
        Some(Stopped::Taken) => {}
        Some(Stopped::Suspended) => jobs.suspend(job),
        Some(Stopped::Canceled) => _ = jobs.finish(job, State::Canceled, None),
        Some(Stopped::TooLarge(_)) if jobs.pass_on(job) => {}
        Some(Stopped::Failed(failure) | Stopped::TooLarge(failure)) => {
            _ = jobs.finish(job, State::Failed, Some(failure))
        }
        None => {
            let is_kept = jobs.finish(job, State::Succeeded, None);
            let record = job.record().clone();
            // What no record names yet is needed after a restart.
            if is_kept && !is_sequence {
                jobs.let_go(&record);
            }
        }
    }
}

/// A job that runs here.
pub(super) struct Begun {
    /// Who it is to the scheduler.
    pub(super) task: Task,
    /// Its part of the pool.
    pub(super) workers: Workers,
    /// What it renders.
    pub(super) spec: JobSpec,
    /// The edge of its tiles.
    pub(super) edge: u32,
}

/// Makes a job one that runs here.
pub(super) fn begin(jobs: &Jobs, job: &Arc<Job>) -> Result<Begun, Stopped> {
    if !jobs.begin(job).map_err(|error| job.why_stopped_or(disk(&error)))? {
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
    let workers = Arc::clone(&jobs.pool).join(task.clone(), job.control());
    Ok(Begun { task, workers, spec, edge })
}

fn work(jobs: &Jobs, job: &Arc<Job>) -> Result<(), Stopped> {
    let began = Instant::now();
    let Begun { task, workers, spec, edge } = begin(jobs, job)?;
    let text = when_there_is_room(job, || jobs.scene(&spec.scene));
    let text = text.map_err(|error| job.why_stopped_or(error.into()))?;
    let text = text.ok_or_else(scene_is_gone)?;
    let building = Instant::now();
    let form = Form::Whole(spec.format);
    let sent = SentScene::new(text.as_ref(), &form, &spec.settings);
    let found = when_there_is_room(job, || jobs.cache.find(&workers, &sent));
    let ready = found.map_err(|error| job.why_stopped_or(error.into()))?.ready;
    let farm = farm_for(jobs, job, edge, &ready, text.as_ref())?;
    drop(text);
    let rendering = job.begin_picture(None);
    let bvh_ms = milliseconds(building);
    job.record().stats.bvh_ms = bvh_ms;
    job.events.publish("started", json!({ "threads": workers.threads(), "bvh_ms": bvh_ms }));

    jobs.make_room();
    let mut share = jobs.cache.memory.share(ready.bytes());
    let sampling = sampling_bytes(&ready.scene, u64::from(ready.scene.width) * u64::from(ready.scene.height));
    let bytes = pixel_bytes(&job.record()) + ready.scene.stack_bytes() * workers.threads() as u64 + sampling;
    let taken = when_there_is_room(job, || share.grow(bytes));
    taken.map_err(|error| job.why_stopped_or(error.into()))?;
    let rendering_since = Instant::now();
    job.done.store(0, Ordering::Relaxed);
    job.rays.store(0, Ordering::Relaxed);
    job.record().stats.tiles_recovered = 0;
    if edge == 0 {
        whole(job, &rendering, &ready, spec.output, &workers, began).map_err(|Cancelled| job.why_stopped())?;
    } else {
        let tenant = job.record().tenant.clone();
        let slots = || jobs.registry.lock().share(&tenant);
        let mut backend = backend(jobs, farm, &slots);
        *job.begun.lock() = Some(rendering_since);
        recover(job, &rendering, &mut *backend)?;
        if job.done.load(Ordering::Relaxed) > 0 {
            tiles(job, &rendering, &ready, &workers, &mut *backend)?;
        } else if backend.is_remote() {
            // The coarse pictures are made here meanwhile, and given up when they are late.
            let control = Control::default();
            let beside = Arc::clone(&jobs.pool).join(task, control.clone());
            thread::scope(|scope| {
                scope.spawn(|| _ = passes(job, &rendering, &ready, &beside, &control, edge));
                let done = tiles(job, &rendering, &ready, &workers, &mut *backend);
                control.cancel();
                done
            })?;
        } else {
            let passed = passes(job, &rendering, &ready, &workers, &job.control(), edge);
            passed.map_err(|Cancelled| job.why_stopped())?;
            tiles(job, &rendering, &ready, &workers, &mut *backend)?;
        }
    }
    job.record().stats.render_ms = milliseconds(rendering_since);

    let encoding = Instant::now();
    let canvas = rendering.take().ok_or_else(|| job.why_stopped())?;
    let image = job.record().image_id.clone();
    let entered = job.control().enter();
    let preview = |canvas: &Canvas| canvas.preview.clone();
    let coded = code(canvas, preview, &ready, &spec, &workers, began).map_err(|Cancelled| job.why_stopped())?;
    let rays = coded.rays();
    let finished = coded.files(&spec, image, &ready);
    drop(entered);
    if job.control().is_cancelled() {
        // The file may be cut short.
        return Err(job.why_stopped());
    }
    let record = job.record().clone();
    let kept = until_possible(job, || jobs.keep_picture(&record, &finished.made, &finished.preview));
    kept.map_err(|error| job.why_stopped_or(disk(&error)))?;
    let mut record = job.record();
    record.stats.encode_ms = milliseconds(encoding);
    record.stats.rays = rays;
    record.stats.picture_bytes = finished.made.bytes.len() as u64;
    Ok(())
}

/// The farm, if nodes can render the tiles of a scene, whose text is in its store from now on.
pub(super) fn farm_for<'a>(
    jobs: &'a Jobs,
    job: &Job,
    edge: u32,
    ready: &PreparedScene,
    text: &[u8],
) -> Result<Option<&'a Arc<Farm>>, Stopped> {
    // Nodes have no folder of textures, and what a clock or a number of rays ends has no tiles.
    let is_remote = (1..=REMOTE_EDGE).contains(&edge) && !ready.scene.from_files;
    let farm = jobs.farm.as_ref().filter(|_| is_remote);
    if let Some(farm) = farm {
        let shared = until_possible(job, || farm.share_scene(&scene_of(job, None), text));
        shared.map_err(|error| job.why_stopped_or(disk(&error)))?;
    }
    Ok(farm)
}

/// Who renders the tiles: the farm, or this process.
pub(super) fn backend<'a>(
    jobs: &'a Jobs,
    farm: Option<&'a Arc<Farm>>,
    share: &'a dyn Fn() -> f64,
) -> Box<dyn Backend + 'a> {
    match farm {
        Some(farm) => Box::new(Remote { farm, share, limit: jobs.limits.job_timeout }),
        None => Box::new(Local::new(&jobs.files)),
    }
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
    rendering: &Rendering,
    ready: &PreparedScene,
    output: FileFormat,
    workers: &Workers,
    began: Instant,
) -> Result<(), Cancelled> {
    *job.begun.lock() = Some(Instant::now());
    let Scene { width, height, .. } = ready.scene;
    let (window, region) = (Window::whole(width, height), Region::whole(width, height));
    *rendering.canvas.lock() = Some(Canvas::of_preview(width, height));
    let mut pass = 0;
    let mut show = |film: Film, distance: u32| {
        if let Some(canvas) = &mut *rendering.canvas.lock() {
            canvas.fill(&film, 0);
        }
        pass += 1;
        job.publish_preview(pass, distance);
    };
    let watcher = Some(&mut show as Watcher<'_>);
    let (picture, ()) = trace(ready, &window, region, output, began, workers, &job.control(), watcher, |_| ())?;
    let rays = picture.rays.total();
    job.rays.fetch_add(rays, Ordering::Relaxed);
    *rendering.canvas.lock() = Some(Canvas::of(picture));
    rendering.tiles[0].1.store(true, Ordering::Release);
    job.done.fetch_add(1, Ordering::Relaxed);
    Ok(())
}

/// Puts the tiles that were finished before onto a new canvas.
pub(super) fn recover(job: &Job, rendering: &Rendering, backend: &mut dyn Backend) -> Result<(), Stopped> {
    let Record { width, height, .. } = job.record().clone();
    let mut canvas = Canvas::new(width, height);
    let (mut recovered, mut rays) = (0, 0);
    let tiles = &rendering.tiles;
    backend.recover(job, rendering, &mut |Tile { number, picture }| {
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
    let mut current = rendering.order.lock();
    job.early_looks.lock().drain(..).for_each(|look| order.look(look));
    *current = Some(order);
    drop(current);
    *rendering.canvas.lock() = Some(canvas);
    Ok(())
}

/// Coarse pictures of it all, each finer than the one before. The last one is for watchers.
fn passes(
    job: &Job,
    rendering: &Rendering,
    ready: &PreparedScene,
    workers: &Workers,
    control: &Control,
    edge: u32,
) -> Result<(), Cancelled> {
    let scene = &ready.scene;
    let last = rendering.canvas.lock().as_ref().map_or(1, |canvas| canvas.level().max(1));
    for (level, pass) in (last..last + PASSES).rev().zip(1..) {
        let is_looked_at = || rendering.order.lock().as_ref().is_some_and(TileOrder::is_looked_at);
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
                paste(&mut coarse, &render_window(scene, &window, part, control)?.film);
            }
            Ok(false)
        })??;
        if !is_done {
            break;
        }
        if let Some(canvas) = &mut *rendering.canvas.lock() {
            canvas.fill(&coarse, level);
        }
        job.publish_preview(pass, 1 << level);
    }
    Ok(())
}

/// All tiles that are not finished.
pub(super) fn tiles(
    job: &Job,
    rendering: &Rendering,
    ready: &PreparedScene,
    workers: &Workers,
    backend: &mut dyn Backend,
) -> Result<(), Stopped> {
    let beginning = (Instant::now(), job.work_done());
    job.tiling.lock().get_or_insert(beginning);
    let reported = Mutex::default();
    backend.render(job, rendering, ready, workers, &|tile| show(job, rendering, tile, &reported))
}

/// Puts a finished tile onto the canvas, and publishes events.
fn show(job: &Job, rendering: &Rendering, tile: &Tile, reported: &Mutex<Option<Instant>>) {
    if let Some(canvas) = &mut *rendering.canvas.lock() {
        canvas.finish(&tile.picture);
    }
    rendering.tiles[tile.number as usize].1.store(true, Ordering::Release);
    job.rays.fetch_add(tile.picture.rays.total(), Ordering::Relaxed);
    let done = job.done.fetch_add(1, Ordering::Relaxed) + 1;
    let revision = job.revision.fetch_add(1, Ordering::Relaxed) + 1;
    let Region { x, y, width, height } = tile.picture.film.region;
    let mut data = json!({ "x": x, "y": y, "w": width, "h": height, "tiles_done": done });
    if let Some(frame) = rendering.frame {
        data["frame"] = frame.into();
    }
    job.events.publish("tile", data);
    let mut reported = reported.lock();
    if reported.is_none_or(|reported| reported.elapsed() >= BETWEEN_REPORTS) || done == job.total {
        let progress = job.progress();
        job.events.publish(
            "progress",
            json!({
                "fraction": done as f64 / job.total as f64, "tiles_done": done, "rays": progress.rays,
                "eta_ms": progress.eta_ms.map(f64::round), "revision": revision,
            }),
        );
        *reported = Some(Instant::now());
    }
}

/// The text of the scene, which only the client can send again.
pub(super) fn scene_is_gone() -> Stopped {
    let detail = "the file with the scene of this job is damaged or gone; submit the job again, with its scene";
    Stopped::Failed(Failure { slug: "gone".into(), detail: detail.into() })
}
