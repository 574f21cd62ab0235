//! Times single parts of the renderer: `cargo bench --bench parts [NAME]` times those whose names contain NAME.
//!
//! It shows where time goes while one works on a part. Figures to publish come from the programs beside this folder, which
//! let versions take turns; whether a kernel has become dearer, `instructions/check.py` says exactly.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a bench may fail loudly, and what it prints is its answer"
)]

mod accel;
mod film;
mod trace;

use std::hint::black_box;
use std::time::{Duration, Instant};

/// How long a part is repeated, and how often at least.
const TIME: Duration = Duration::from_secs(3);
const LEAST: usize = 5;

/// Repeats a part with what `prepare` makes for it each time, which is not timed; nor is dropping what it returns.
/// Prints the median time and those that half of all times lie between.
fn time<I, O>(name: &str, mut prepare: impl FnMut() -> I, mut part: impl FnMut(I) -> O) {
    let mut filter = std::env::args().skip(1).filter(|argument| !argument.starts_with('-'));
    if filter.next().is_some_and(|wanted| !name.contains(&wanted)) {
        return;
    }
    let mut once = || {
        let input = black_box(prepare());
        let start = Instant::now();
        let output = black_box(part(input));
        let took = start.elapsed();
        drop(output);
        took.as_secs_f64() * 1e3
    };
    once();
    let (begun, mut times) = (Instant::now(), Vec::new());
    while begun.elapsed() < TIME || times.len() < LEAST {
        times.push(once());
    }
    times.sort_unstable_by(f64::total_cmp);
    let [low, median, high] = [1, 2, 3].map(|quarter| times[(times.len() - 1) * quarter / 4]);
    println!("{name:<40} {median:>9.3} ms   ({low:.3} to {high:.3}; {} times)", times.len());
}

fn main() {
    accel::scenes();
    accel::hierarchies();
    film::formats();
    trace::pictures();
}
