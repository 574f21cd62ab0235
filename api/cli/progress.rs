//! The progress bar, fed from the render's own counters. It shows on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;
use strahl::render::Control;

const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// Runs work while a bar shows its progress.
pub(super) fn while_showing<T>(control: &Control, work: impl FnOnce() -> T) -> T {
    if !io::stderr().is_terminal() {
        return work();
    }
    thread::scope(|scope| {
        // Dropping the sender, even by a panic in `work`, ends the bar.
        let (working, done) = mpsc::channel::<()>();
        scope.spawn(move || {
            let bar = ProgressBar::new(0).with_style(style());
            while done.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
                bar.set_length(control.total());
                bar.set_position(control.done());
            }
            bar.finish_and_clear();
        });
        let result = work();
        drop(working);
        result
    })
}

fn style() -> ProgressStyle {
    ProgressStyle::with_template("{wide_bar} {percent:>3} %  {elapsed} gone, {eta} to go")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}
