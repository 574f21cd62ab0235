//! The progress bar, fed from the render's own counters. It shows on a terminal only; commands that take long write lines
//! elsewhere.

use super::output;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;
use strahl::render::Control;

const BETWEEN_LOOKS: Duration = Duration::from_millis(100);
/// Percent between two lines.
const TOLD_EVERY: u64 = 20;

/// Runs work while a bar shows its progress.
pub(super) fn while_showing<T>(control: &Control, work: impl FnOnce() -> T) -> T {
    if io::stderr().is_terminal() { beside(work, |done| show(control, &done)) } else { work() }
}

/// Runs work while a bar shows its progress, or lines where there is no terminal.
pub(super) fn while_telling<T>(control: &Control, what: &str, work: impl FnOnce() -> T) -> T {
    if io::stderr().is_terminal() {
        return beside(work, |done| show(control, &done));
    }
    beside(work, |done| {
        let mut told = 0;
        while done.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
            let percent = 100 * control.done() / control.total().max(1);
            if percent / TOLD_EVERY > told {
                told = percent / TOLD_EVERY;
                output::say(&format!("{what}: {} %", told * TOLD_EVERY));
            }
        }
    })
}

/// Runs work, and something beside it that ends when its channel closes.
fn beside<T>(work: impl FnOnce() -> T, other: impl FnOnce(Receiver<()>) + Send) -> T {
    thread::scope(|scope| {
        // Dropping the sender, even by a panic in `work`, ends the other.
        let (working, done) = mpsc::channel::<()>();
        scope.spawn(move || other(done));
        let result = work();
        drop(working);
        result
    })
}

fn show(control: &Control, done: &Receiver<()>) {
    let bar = ProgressBar::new(0).with_style(style());
    while done.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
        bar.set_length(control.total());
        bar.set_position(control.done());
    }
    bar.finish_and_clear();
}

fn style() -> ProgressStyle {
    ProgressStyle::with_template("{wide_bar} {percent:>3} %  {elapsed} gone, {eta} to go")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}
