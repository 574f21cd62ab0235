//! Pictures that were made lately, as files: in memory, and in a folder if there is one.
//!
//! A picture's name says what it shows and how ([`excerpt`](super::spec)), so what is kept never becomes wrong.

use super::file::Made;
use super::single_flight::Flights;
use crate::http::metrics::render_cost::Cost;
use crate::http::problem::Problem;
use crate::service::storage::blob_store::Blobs;
use crate::service::storage::hit_counter::Tally;
use crate::service::storage::lru_cache::Recent;
use std::sync::Arc;

/// A picture and what it took this time.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    /// The picture.
    pub(crate) made: Arc<Made>,
    /// `Server-Timing`.
    pub(crate) timing: Arc<str>,
    /// What it cost, for whoever had it made.
    pub(crate) cost: Option<Cost>,
}

/// The pictures.
#[derive(Debug)]
pub(crate) struct Pictures {
    memory: Recent<String, Arc<Made>>,
    disk: Option<Blobs>,
    /// How often a picture was in memory, and how often in the folder.
    tallies: [Tally; 2],
    /// Those that are being made.
    pub(crate) flights: Flights<Shown>,
}

impl Pictures {
    /// No pictures in memory yet, and those of the folder.
    pub(crate) fn new(budget: u64, disk: Option<Blobs>) -> Self {
        Self { memory: Recent::new(budget), disk, tallies: Default::default(), flights: Flights::default() }
    }

    /// Whether there is a folder to look into.
    pub(crate) fn has_folder(&self) -> bool {
        self.disk.is_some()
    }

    /// A picture that is in memory.
    pub(crate) fn at_hand(&self, name: &str) -> Option<Arc<Made>> {
        self.memory.get(name).inspect(|_| self.tallies[0].hit())
    }

    /// A picture, from memory or from the folder, on this thread.
    pub(crate) fn get(&self, name: &str) -> Option<Arc<Made>> {
        if let Some(made) = self.at_hand(name) {
            return Some(made);
        }
        let blob = self.disk.as_ref()?.get(name)?;
        let made = Arc::new(Made::read(&mut &blob[..]).ok()?);
        self.tallies[1].hit();
        self.remember(name, &made);
        Some(made)
    }

    /// Keeps a picture. Writing it into the folder takes place on this thread.
    pub(crate) fn put(&self, name: &str, made: &Arc<Made>) {
        self.remember(name, made);
        let Some(disk) = &self.disk else { return };
        self.tallies[1].miss();
        if let Err(error) = disk.put(name, &made.to_blob()) {
            tracing::warn!(name, %error, "a picture cannot be kept in the folder");
        }
    }

    /// What is kept where: a name, the bytes there, and how often they were of use.
    pub(crate) fn tallies(&self) -> impl Iterator<Item = (&'static str, u64, &Tally)> {
        let [memory, disk] = &self.tallies;
        let folder = self.disk.as_ref().map(|blobs| ("picture_folder", blobs.bytes(), disk));
        [("pictures", self.memory.bytes(), memory)].into_iter().chain(folder)
    }

    /// The picture of a name, made by `work` unless it is there or on its way.
    pub(crate) async fn share<F>(&self, name: String, work: impl FnOnce() -> F) -> Result<Shown, Problem>
    where
        F: Future<Output = Result<Shown, Problem>> + Send + 'static,
    {
        self.flights.share(name, work).await
    }

    /// Forgets every picture whose name begins so.
    pub(crate) fn forget(&self, prefix: &str) {
        for name in self.memory.keys().into_iter().filter(|name| name.starts_with(prefix)) {
            self.memory.remove(&name);
        }
        if let Some(disk) = &self.disk {
            for name in disk.names().into_iter().filter(|name| name.starts_with(prefix)) {
                disk.remove(&name);
            }
        }
    }

    /// Keeps a picture in memory.
    pub(crate) fn remember(&self, name: &str, made: &Arc<Made>) {
        self.tallies[0].miss();
        self.memory.put(name.to_owned(), Arc::clone(made), made.bytes());
    }
}
