//! A large farm on a small machine: nodes and coordinators as they are, a real broker, and tiles whose rendering is a sleep.
//! `benches/farm/simulate.py` starts it.
//!
//! It prints JSON: pieces and tiles a second, the share of the time that slots slept (which is what rendering would be), and how
//! evenly jobs got slots (Jain's index).

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "this is a program for a terminal")]

#[path = "../../api/service/mod.rs"]
#[allow(dead_code, unused_imports, reason = "a simulation uses a part of the service")]
mod service;

use clap::Parser;
use parking_lot::Mutex;
use service::clock::unix_time;
use service::farm::Farm;
use service::farm::coordinator::{Order, Tiles};
use service::farm::names::Class;
use service::farm::node::settings::NodeSettings;
use service::farm::node::work;
use service::farm::settings::FarmSettings;
use service::farm::work::SceneSource;
use service::pictures::tile_bytes::Tile;
use service::storage::objects::Objects;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Cancelled, Control, Picture, render_window};
use strahl::scene::{Format, Overrides, Scene};

/// Pixels of a tile, in each direction.
const TILE: u32 = 8;
/// Tiles of a row of the pictures.
const ROW: u32 = 1_000;
/// Nothing to see.
const SCENE: &str = r#"{"version":1,"image":{"width":8000,"height":8000},"camera":{"pinhole":{"eye":[0,0,5],"look_at":[0,0,0]}},"objects":[{"sphere":{"center":[0,0,100],"radius":1}}]}"#;

/// Milliseconds that a tile takes on average.
static TILE_MS: AtomicU64 = AtomicU64::new(0);
/// Microseconds that slots have slept.
static SLEPT: AtomicU64 = AtomicU64::new(0);

#[derive(Debug, Parser)]
struct Simulation {
    #[command(flatten)]
    farm: FarmSettings,
    #[command(flatten)]
    node: NodeSettings,
    /// Nodes, each with a connection of its own.
    #[arg(long, default_value_t = 500)]
    nodes: u32,
    /// Jobs at one time.
    #[arg(long, default_value_t = 100)]
    jobs: u32,
    /// Milliseconds of a tile; each takes between half and one and a half of it.
    #[arg(long, default_value_t = 1_000)]
    tile_ms: u64,
    /// Seconds before figures are taken, and seconds of the figures.
    #[arg(long, default_value_t = 20)]
    warm_up: u64,
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Instead of jobs without end: pictures that somebody waits for, one after the other, each of so many tiles.
    #[arg(long)]
    picture_tiles: Option<u32>,
}

/// Sleeps instead of rendering. What a tile takes follows from where it is.
fn sleep(scene: &Scene, window: &Window, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    let started = Instant::now();
    let mut picture = render_window(scene, window, region, control)?;
    let chance = (u64::from(region.x) * 2_654_435_761 + u64::from(region.y) * 40_503) % 1_000;
    let end = started + Duration::from_micros(TILE_MS.load(Ordering::Relaxed) * (500 + chance));
    while Instant::now() < end {
        // A real render shows that it gets on, and can be stopped.
        thread::sleep((end - Instant::now()).min(Duration::from_millis(500)));
        control.add_rays(1);
        if control.is_cancelled() {
            return Err(Cancelled);
        }
    }
    SLEPT.fetch_add(started.elapsed().as_micros() as u64, Ordering::Relaxed);
    picture.trace_ms = started.elapsed().as_secs_f64() * 1e3;
    picture.refine_ms = 0.0;
    Ok(picture)
}

/// Tiles of a job, by default without end.
struct Endless<'a> {
    next: u32,
    end: u32,
    share: f64,
    finished: &'a AtomicU64,
    over: &'a AtomicBool,
}

impl Tiles for Endless<'_> {
    fn next(&mut self) -> Option<(u32, Region)> {
        if self.next == self.end {
            return None;
        }
        let number = self.next % (ROW * ROW);
        self.next += 1;
        Some((number, Region { x: number % ROW * TILE, y: number / ROW * TILE, width: TILE, height: TILE }))
    }

    fn pixels_left(&self) -> u64 {
        u64::from(self.end.min(ROW * ROW).saturating_sub(self.next) * TILE * TILE)
    }

    fn share(&self) -> f64 {
        self.share
    }

    fn finished(&mut self, _: Tile) -> bool {
        self.finished.fetch_add(1, Ordering::Relaxed);
        !self.over.load(Ordering::Relaxed)
    }
}

/// What is asked of the farm.
fn order<'a>(name: &'a str, class: Class, scene: &SceneSource, tile_ms: u64, control: &'a Control) -> Order<'a> {
    Order {
        name,
        tenant: "simulation",
        class,
        scene: scene.clone(),
        window: Window { origin: [0.0; 2], step: [1.0; 2], width: ROW * TILE, height: ROW * TILE },
        pixel_ms: tile_ms as f64 / f64::from(TILE * TILE),
        limit: Duration::from_secs(600),
        control,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Simulation { farm: settings, node, nodes, jobs, tile_ms, warm_up, seconds, picture_tiles } =
        Simulation::parse();
    TILE_MS.store(tile_ms, Ordering::Relaxed);
    let slots = u64::from(nodes) * u64::from(node.slots.unwrap_or(4));
    let runtime = |threads, blocking| {
        let mut builder = tokio::runtime::Builder::new_multi_thread();
        builder.worker_threads(threads).max_blocking_threads(blocking).enable_all().build()
    };
    // Fronts and nodes are processes of their own, so each side has its threads.
    let (of_front, of_nodes) = (runtime(2, 512)?, runtime(2, slots as usize + 600)?);
    let refused = |error| format!("{error:?}");
    let place = settings.store.as_deref().ok_or("--store")?;
    let store = of_front.block_on(Objects::open(place)).map_err(refused)?;
    let farm = Farm::open(&settings, Some(&store), None, of_front.handle()).map_err(refused)?.ok_or("--farm")?;
    let farm = Arc::new(farm);
    let scene = SceneSource {
        text: SceneSource::name_of(SCENE.as_bytes()),
        format: Format::Json,
        settings: Overrides::default(),
        frame: None,
    };
    farm.share_scene(&scene, SCENE.as_bytes())?;
    let (stop, stopped) = tokio::sync::watch::channel(false);
    let (of_node, of_farm) = (node.clone(), settings.clone());
    let each = (0..nodes).map(move |number| {
        let (mut node, settings, mut stopped) = (of_node.clone(), of_farm.clone(), stopped.clone());
        node.name = Some(format!("node{number}"));
        node.slots = node.slots.or(Some(4));
        async move {
            let until = async move {
                let _ = stopped.wait_for(|is| *is).await;
                "the end"
            };
            if let Err(error) = work(&node, &settings, sleep, until).await {
                eprintln!("a node: {error:?}");
            }
        }
    });
    // Made on the thread that runs them, since they cannot go to another.
    let running = thread::spawn(move || of_nodes.block_on(futures_util::future::join_all(each)));
    let started = Instant::now();
    while u64::from(farm.nodes.slots()) < slots && started.elapsed() < Duration::from_secs(240) {
        thread::sleep(Duration::from_millis(200));
    }
    let joined = started.elapsed();
    if let Some(end) = picture_tiles {
        let (mut took, started) = (Vec::new(), Instant::now());
        while started.elapsed() < Duration::from_secs(seconds) {
            let (began, control, over) = (Instant::now(), Control::default(), AtomicBool::new(false));
            let slept = SLEPT.load(Ordering::Relaxed);
            let name = format!("simulated-{}", unix_time().as_millis());
            let mut tiles = Endless { next: 0, end, share: 1.0, finished: &AtomicU64::new(0), over: &over };
            farm.render(&order(&name, Class::Hi, &scene, tile_ms, &control), &mut tiles)
                .map_err(|error| format!("{error:?}"))?;
            let all = (SLEPT.load(Ordering::Relaxed) - slept) as f64 / 1e3;
            took.push((began.elapsed().as_secs_f64() * 1e3, all));
        }
        took.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median, worst) = (took[took.len() / 2], took[took.len() - 1]);
        let figures = serde_json::json!({
            "nodes": nodes, "slots": slots, "tiles": end, "tile_ms": tile_ms, "pictures": took.len(),
            "tiles_took_ms": median.1, "picture_took_ms": median.0, "worst_ms": worst.0,
        });
        println!("{figures}");
        stop.send_replace(true);
        let _ = running.join();
        return Ok(());
    }
    let over = AtomicBool::new(false);
    let finished: Vec<AtomicU64> = (0..jobs).map(|_| AtomicU64::new(0)).collect();
    let controls: Mutex<Vec<Control>> = Mutex::default();
    thread::scope(|scope| {
        for (job, finished) in finished.iter().enumerate() {
            let (farm, scene, over, controls) = (&farm, scene.clone(), &over, &controls);
            scope.spawn(move || {
                let control = Control::default();
                controls.lock().push(control.clone());
                let mut tiles = Endless { next: 0, end: u32::MAX, share: 1.0 / f64::from(jobs), finished, over };
                let name = format!("simulated-{job}-{}", unix_time().as_millis());
                if let Err(error) = farm.render(&order(&name, Class::Norm, &scene, tile_ms, &control), &mut tiles)
                    && !over.load(Ordering::Relaxed)
                {
                    eprintln!("job {job}: {error:?}");
                }
            });
        }
        thread::sleep(Duration::from_secs(warm_up));
        let count = || finished.iter().map(|count| count.load(Ordering::Relaxed)).collect::<Vec<_>>();
        let (from, before, slept) = (Instant::now(), count(), SLEPT.load(Ordering::Relaxed));
        let pieces = farm.counts.pieces.load(Ordering::Relaxed);
        thread::sleep(Duration::from_secs(seconds));
        let took = from.elapsed().as_secs_f64();
        let tiles: Vec<f64> = count().iter().zip(before).map(|(after, before)| (after - before) as f64).collect();
        let (sum, squares) = (tiles.iter().sum::<f64>(), tiles.iter().map(|tiles| tiles * tiles).sum::<f64>());
        let slept = (SLEPT.load(Ordering::Relaxed) - slept) as f64 / 1e6;
        let figures = serde_json::json!({
            "nodes": nodes, "slots": slots, "slots_seen": farm.nodes.slots(), "jobs": jobs, "tile_ms": tile_ms, "seconds": took,
            "joined_s": joined.as_secs_f64(),
            "pieces_per_s": (farm.counts.pieces.load(Ordering::Relaxed) - pieces) as f64 / took,
            "tiles_per_s": sum / took,
            "busy": slept / (took * slots as f64),
            "jain": sum * sum / (f64::from(jobs) * squares),
            "sent_again": farm.counts.again.load(Ordering::Relaxed),
            "rendered_twice": farm.counts.doubled.load(Ordering::Relaxed),
        });
        println!("{figures}");
        over.store(true, Ordering::Relaxed);
        controls.lock().iter().for_each(Control::cancel);
    });
    stop.send_replace(true);
    let _ = running.join();
    Ok(())
}
