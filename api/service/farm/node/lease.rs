//! Keeping a piece of work from going to another node, for as long as its render gets on.

use async_nats::jetstream::{AckKind, Message};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use strahl::render::Control;
use tokio::task::JoinHandle;

/// A render that has not got on for so long is given up. Progress shows after 1,024 pixels, which may take a while.
const PATIENCE: Duration = Duration::from_secs(60);

/// The lease of a piece, until this is dropped.
#[derive(Debug)]
pub(super) struct Lease {
    /// Stops the render of the piece.
    pub(super) control: Control,
    state: Arc<State>,
    keeper: JoinHandle<()>,
}

#[derive(Debug, Default)]
struct State {
    /// Whether the scene is being fetched or built, which nobody counts.
    is_loading: AtomicBool,
    is_stuck: AtomicBool,
    is_late: AtomicBool,
}

impl Lease {
    /// Keeps a message. `lease` is how long the broker waits, `limit` how long the piece may take.
    pub(super) fn keep(message: &Arc<Message>, lease: Duration, limit: Duration) -> Self {
        let (control, state) = (Control::default(), Arc::<State>::default());
        let keeper = tokio::spawn(keep(Arc::clone(message), control.clone(), Arc::clone(&state), lease, limit));
        Self { control, state, keeper }
    }

    /// The scene is being fetched and built, or no longer.
    pub(super) fn loading(&self, is_loading: bool) {
        self.state.is_loading.store(is_loading, Ordering::Relaxed);
    }

    /// Why it was given up, if it was.
    pub(super) fn complaint(&self) -> Option<&'static str> {
        let is = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
        match () {
            () if is(&self.state.is_stuck) => Some("the render did not get on"),
            () if is(&self.state.is_late) => Some("the render took longer than a piece may"),
            () => None,
        }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.keeper.abort();
    }
}

async fn keep(message: Arc<Message>, control: Control, state: Arc<State>, lease: Duration, limit: Duration) {
    let began = Instant::now();
    let mut got_on = (0, Instant::now());
    loop {
        tokio::time::sleep(lease / 3).await;
        let progress = control.rays() + control.done();
        if progress != got_on.0 || state.is_loading.load(Ordering::Relaxed) {
            got_on = (progress, Instant::now());
        }
        if got_on.1.elapsed() > PATIENCE {
            state.is_stuck.store(true, Ordering::Relaxed);
        } else if began.elapsed() > limit {
            state.is_late.store(true, Ordering::Relaxed);
        } else {
            // If it is lost, the next one comes in time.
            let _ = message.ack_with(AckKind::Progress).await;
            continue;
        }
        control.cancel();
        return;
    }
}
