//! Pictures that were made lately, as files: in memory, and in a folder if there is one.
//!
//! A picture's name says what it shows and how ([`spec`](super::spec)), so what is kept never becomes wrong.

use super::file::{PictureFile, PictureMeta};
use super::passes::PassChannels;
use super::report::{Phases, Report};
use super::single_flight::SingleFlight;
use crate::service::memory_budget::MemoryBudget;
use crate::service::scenes::ids::is_image_name;
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::hit_counter::HitCounter;
use crate::service::storage::lru_cache::LruCache;
use crate::service::storage::seen_by::SeenBy;
use std::sync::Arc;

/// Pictures in a folder. One that a power cut has spoilt is made again, so nobody waits for the disk.
pub(crate) const KIND: BlobKind = BlobKind { is_name: is_image_name, durable: false };

/// A picture and what this request took.
#[derive(Debug, Clone)]
pub(crate) struct MadePicture {
    /// The picture.
    pub(crate) file: Arc<PictureFile>,
    /// What it took.
    pub(crate) took: Took,
}

/// What a request for a picture took.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Took {
    /// Whether its scene was in the cache.
    pub(crate) scene_cached: bool,
    /// Milliseconds of waiting for the renderer.
    pub(crate) queue_ms: f64,
    /// Milliseconds and rays of the render. None if the picture was in a cache.
    pub(crate) render: Option<(Phases, u64)>,
    /// Whether another request rendered it, and is charged for it.
    pub(crate) is_shared: bool,
}

impl Took {
    /// What a picture has taken that another tenant has had made: nothing says that it was there.
    pub(crate) fn by_others(meta: &PictureMeta) -> Self {
        Self { scene_cached: false, queue_ms: 0.0, render: Some((meta.phases, 0)), is_shared: true }
    }

    /// What a cached picture takes.
    pub(crate) const CACHED: Self = Self { scene_cached: true, queue_ms: 0.0, render: None, is_shared: false };

    /// What rendering took: the report, and the milliseconds in the queue.
    pub(crate) fn new(report: Option<&Report>, queue_ms: f64, scene_cached: bool) -> Self {
        let waited = report.map_or(0.0, |report| {
            let worked: f64 = report.cost.phases_ms.list().iter().map(|(_, ms)| ms).sum();
            // Time that no phase accounts for was spent waiting for time slices.
            (report.cost.wall_ms - worked).max(0.0)
        });
        let render = report.map(|report| (report.cost.phases_ms, report.cost.rays.total()));
        Self { scene_cached, queue_ms: queue_ms + waited, render, is_shared: false }
    }
}

/// The cache.
#[derive(Debug)]
pub(crate) struct PictureCache {
    memory: Arc<LruCache<String, Arc<PictureFile>>>,
    budget: MemoryBudget,
    disk: Option<BlobStore>,
    /// Hits and misses in memory, and on disk.
    hit_counters: [HitCounter; 2],
    /// Who has had which picture, by its name.
    pub(crate) seen: SeenBy,
    /// Those that are being made.
    pub(crate) flights: SingleFlight<MadePicture>,
    /// The coarse pictures before them.
    pub(crate) passes: PassChannels,
}

impl PictureCache {
    /// A cache that is empty in memory, and has the pictures on disk.
    pub(crate) fn new(bytes: u64, budget: &MemoryBudget, disk: Option<BlobStore>) -> Self {
        let memory = Arc::new(LruCache::new(bytes));
        budget.evict_from(Arc::<LruCache<_, _>>::downgrade(&memory));
        Self {
            memory,
            budget: budget.clone(),
            disk,
            hit_counters: Default::default(),
            flights: SingleFlight::default(),
            passes: PassChannels::default(),
            seen: SeenBy::default(),
        }
    }

    /// Whether pictures are cached on disk.
    pub(crate) fn has_folder(&self) -> bool {
        self.disk.is_some()
    }

    /// A picture, if it is in memory.
    pub(crate) fn cached(&self, name: &str) -> Option<Arc<PictureFile>> {
        self.memory.get(name).inspect(|_| self.hit_counters[0].hit())
    }

    /// A picture, from memory or from disk, read on this thread if there is memory for it.
    pub(crate) fn get(&self, name: &str) -> Option<Arc<PictureFile>> {
        if let Some(file) = self.cached(name) {
            return Some(file);
        }
        let file = Arc::new(PictureFile::read(self.disk.as_ref()?, name, &self.budget).ok()??);
        self.hit_counters[1].hit();
        self.remember(name, &file);
        Some(file)
    }

    /// Caches a picture. It is written to disk on this thread.
    pub(crate) fn put(&self, name: &str, file: &Arc<PictureFile>) {
        self.remember(name, file);
        let Some(disk) = &self.disk else { return };
        self.hit_counters[1].miss();
        if let Err(error) = disk.put(name, &file.head(), &file.bytes) {
            tracing::warn!(name, %error, "a picture cannot be kept in the folder");
        }
    }

    /// Name, bytes and hits of each part of the cache.
    pub(crate) fn hit_counters(&self) -> impl Iterator<Item = (&'static str, u64, &HitCounter)> {
        let [memory, disk] = &self.hit_counters;
        let folder = self.disk.as_ref().map(|blobs| ("picture_folder", blobs.bytes(), disk));
        [("pictures", self.memory.bytes(), memory)].into_iter().chain(folder)
    }

    /// Deletes every picture whose name begins with `prefix`.
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

    /// Caches a picture in memory.
    pub(crate) fn remember(&self, name: &str, file: &Arc<PictureFile>) {
        self.hit_counters[0].miss();
        self.memory.put(name.to_owned(), Arc::clone(file), file.size());
    }
}
