//! Pictures that were made lately, as files: in memory, and in a folder if there is one.
//!
//! A picture's name says what it shows and how ([`spec`](super::spec)), so what is kept never becomes wrong.

use super::file::PictureFile;
use super::single_flight::SingleFlight;
use crate::http::metrics::render_cost::Cost;
use crate::http::problem::Problem;
use crate::service::storage::blob_store::BlobStore;
use crate::service::storage::hit_counter::HitCounter;
use crate::service::storage::lru_cache::LruCache;
use std::sync::Arc;

/// A picture and what it took this time.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    /// The picture.
    pub(crate) made: Arc<PictureFile>,
    /// `Server-Timing`.
    pub(crate) timing: Arc<str>,
    /// What it cost, for whoever had it made.
    pub(crate) cost: Option<Cost>,
}

/// The pictures.
#[derive(Debug)]
pub(crate) struct PictureCache {
    memory: LruCache<String, Arc<PictureFile>>,
    disk: Option<BlobStore>,
    /// How often a picture was in memory, and how often in the folder.
    hit_counters: [HitCounter; 2],
    /// Those that are being made.
    pub(crate) flights: SingleFlight<Shown>,
}

impl PictureCache {
    /// No pictures in memory yet, and those of the folder.
    pub(crate) fn new(budget: u64, disk: Option<BlobStore>) -> Self {
        Self { memory: LruCache::new(budget), disk, hit_counters: Default::default(), flights: SingleFlight::default() }
    }

    /// Whether there is a folder to look into.
    pub(crate) fn has_folder(&self) -> bool {
        self.disk.is_some()
    }

    /// A picture that is in memory.
    pub(crate) fn cached(&self, name: &str) -> Option<Arc<PictureFile>> {
        self.memory.get(name).inspect(|_| self.hit_counters[0].hit())
    }

    /// A picture, from memory or from the folder, on this thread.
    pub(crate) fn get(&self, name: &str) -> Option<Arc<PictureFile>> {
        if let Some(made) = self.cached(name) {
            return Some(made);
        }
        let blob = self.disk.as_ref()?.get(name)?;
        let made = Arc::new(PictureFile::read(&mut &blob[..]).ok()?);
        self.hit_counters[1].hit();
        self.remember(name, &made);
        Some(made)
    }

    /// Keeps a picture. Writing it into the folder takes place on this thread.
    pub(crate) fn put(&self, name: &str, made: &Arc<PictureFile>) {
        self.remember(name, made);
        let Some(disk) = &self.disk else { return };
        self.hit_counters[1].miss();
        if let Err(error) = disk.put(name, &made.to_blob()) {
            tracing::warn!(name, %error, "a picture cannot be kept in the folder");
        }
    }

    /// What is kept where: a name, the bytes there, and how often they were of use.
    pub(crate) fn hit_counters(&self) -> impl Iterator<Item = (&'static str, u64, &HitCounter)> {
        let [memory, disk] = &self.hit_counters;
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
    pub(crate) fn remember(&self, name: &str, made: &Arc<PictureFile>) {
        self.hit_counters[0].miss();
        self.memory.put(name.to_owned(), Arc::clone(made), made.bytes());
    }
}
