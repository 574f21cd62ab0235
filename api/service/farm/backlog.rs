//! Work that fronts have for nodes, in seconds of a slot: what the number of nodes should follow.

use super::names::Class;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::atomic::AtomicU64;

/// The work that is left of each picture this front coordinates.
#[derive(Debug, Default)]
pub(crate) struct Backlog(Mutex<HashMap<String, (Class, f64)>>);

impl Backlog {
    /// A picture takes so many milliseconds more.
    pub(super) fn note(&self, name: &str, class: Class, ms: f64) {
        let mut pictures = self.0.lock();
        match pictures.get_mut(name) {
            Some(known) => *known = (class, ms),
            None => drop(pictures.insert(name.to_owned(), (class, ms))),
        }
    }

    /// A picture is done.
    pub(super) fn forget(&self, name: &str) {
        self.0.lock().remove(name);
    }

    /// Seconds of a slot that work of a class takes.
    pub(crate) fn seconds(&self, class: Class) -> f64 {
        // A sum of nothing is -0.0.
        self.0.lock().values().filter(|(of, _)| *of == class).fold(0.0, |sum, (_, ms)| sum + ms / 1e3)
    }
}

/// What has happened since the start.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// Pieces that were sent.
    pub(crate) pieces: AtomicU64,
    /// Tiles that came back.
    pub(crate) tiles: AtomicU64,
    /// Pieces that were lost and sent again.
    pub(crate) again: AtomicU64,
    /// Slow pieces that were rendered twice.
    pub(crate) doubled: AtomicU64,
    /// Pieces that were given up.
    pub(crate) dead: AtomicU64,
    /// Tiles of which two nodes made different pixels.
    pub(crate) differing: AtomicU64,
    /// How often the broker had no room for more work.
    pub(crate) full: AtomicU64,
}
