//! What specialised kernels buy: every scene by the kernel for what it calls for, and by the general one, which asks at run
//! time. `cargo bench --bench kernels` prints a table; both take turns, round by round, on one thread.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a bench may fail loudly, and its table is its answer")]

use std::time::Instant;
use strahl::film::Region;
use strahl::render::{Control, RenderOptions, render_with};
use strahl::scene::compile::Precise;
use strahl::scene::{Format, Overrides, Scene, load};
use strahl::trace::variants::KernelVariant;

const ROUNDS: usize = 9;

fn milliseconds(scene: &Scene, specialised: bool) -> f64 {
    let cut = RenderOptions { specialised, ..RenderOptions::default() };
    let start = Instant::now();
    render_with(scene, Region::whole(scene.width, scene.height), &Control::default(), cut).unwrap();
    start.elapsed().as_secs_f64() * 1e3
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn measure(path: &std::path::Path) {
    let overrides = Overrides {
        width: Some(192),
        height: Some(108),
        samples: Some(4),
        antialias: Some(false),
        ..Overrides::default()
    };
    let scene = load(&std::fs::read(path).unwrap(), Format::Json, &overrides).unwrap().scene;
    let kernel = match &scene.world {
        Precise::Single(world) => KernelVariant::of(world),
        Precise::Double(world) => KernelVariant::of(world),
    };
    if kernel == KernelVariant::General {
        return;
    }
    let (mut special, mut general) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        special.push(milliseconds(&scene, true));
        general.push(milliseconds(&scene, false));
    }
    let name = path.file_stem().unwrap().display().to_string();
    let (special, general) = (median(special), median(general));
    println!("| {name} | {kernel:?} | {special:.2} | {general:.2} | {:.2} |", general / special);
}

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    println!("| scene | kernel | its own, ms | general, ms | general / own |\n|---|---|---|---|---|");
    let mut paths = Vec::new();
    for folder in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes")).unwrap().flatten() {
        if let Ok(files) = std::fs::read_dir(folder.path()) {
            paths
                .extend(files.flatten().map(|file| file.path()).filter(|p| p.extension().is_some_and(|e| e == "json")));
        }
    }
    paths.sort();
    pool.install(|| paths.iter().for_each(|path| measure(path)));
}
