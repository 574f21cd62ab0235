//! Work that nobody wants any more: pieces here are stopped, and those to come are dropped. It is named by the coordinator that
//! has sent it: another one may go on with the job.

use crate::service::farm::connection::{Broker, RETRY_AFTER};
use crate::service::farm::names::CANCELS;
use futures_util::StreamExt;
use lru::LruCache;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::sync::Arc;
use strahl::render::Control;

/// Coordinators that are remembered: those whose pieces may still be on their way.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(4_096).expect("it is not 0");

/// The coordinators, and what runs here.
#[derive(Debug, Clone)]
pub(super) struct Cancels(Arc<Mutex<Known>>);

#[derive(Debug)]
struct Known {
    cancelled: LruCache<String, ()>,
    /// Controls of the pieces that are being rendered, and their coordinators.
    running: HashMap<u64, (String, Control)>,
    count: u64,
}

/// A piece that is being rendered, until this is dropped.
#[derive(Debug)]
pub(super) struct Running(Cancels, u64);

impl Cancels {
    pub(super) fn new() -> Self {
        let known = Known { cancelled: LruCache::new(REMEMBERED), running: HashMap::new(), count: 0 };
        Self(Arc::new(Mutex::new(known)))
    }

    /// Whether what a coordinator has sent was cancelled.
    pub(super) fn has(&self, session: &str) -> bool {
        self.0.lock().cancelled.contains(session)
    }

    /// A piece of a coordinator begins.
    pub(super) fn enter(&self, session: &str, control: &Control) -> Running {
        let mut known = self.0.lock();
        if known.cancelled.contains(session) {
            control.cancel();
        }
        known.count += 1;
        let id = known.count;
        known.running.insert(id, (session.to_owned(), control.clone()));
        drop(known);
        Running(self.clone(), id)
    }

    fn cancel(&self, session: &str) {
        let mut known = self.0.lock();
        known.cancelled.put(session.to_owned(), ());
        known.running.values().filter(|(running, _)| running == session).for_each(|(_, control)| control.cancel());
    }

    /// Stops everything that runs.
    pub(super) fn stop_all(&self) {
        self.0.lock().running.values().for_each(|(_, control)| control.cancel());
    }

    /// Hears of what was cancelled from now on.
    pub(super) async fn listen(self, broker: Broker) {
        loop {
            if let Ok(mut heard) = broker.client.subscribe(CANCELS).await {
                while let Some(message) = heard.next().await {
                    if let Ok(session) = std::str::from_utf8(&message.payload) {
                        self.cancel(session);
                    }
                }
            }
            tokio::time::sleep(RETRY_AFTER).await;
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.0.0.lock().running.remove(&self.1);
    }
}
