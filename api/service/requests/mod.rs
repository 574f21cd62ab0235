//! What requests ask for: scenes, pictures and jobs, from the caches or made on the pool.

pub(crate) mod jobs;
pub(crate) mod pictures;
pub(crate) mod scenes;

use super::error::{Error, StartError};
use super::jobs::{JobObserver, Jobs};
use super::limits::Settings;
use super::pictures::cache::PictureCache;
use super::scenes::cache::SceneCache;
use super::scenes::store::SceneStore;
use super::scenes::texture_folder::TextureFolder;
use super::scheduler::admission::{Done, Queue, Work};
use super::scheduler::pool::Pool;
use super::scheduler::task::{Class, Task};
use super::storage::blob_store::BlobStore;
use super::storage::lru_cache::LruCache;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Time limit of a tile, waiting included. OpenSeadragon gives up after 30 seconds, and never asks again.
const TILE_PATIENCE: Duration = Duration::from_secs(25);

/// Everything that requests share.
#[derive(Debug)]
pub(crate) struct Service {
    /// The threads that render.
    pub(crate) pool: Arc<Pool>,
    /// The one way to them.
    pub(crate) queue: Queue,
    /// The way for tiles, of which a viewer asks for many at once.
    pub(crate) tiles: Queue,
    /// Scenes that need not be built again.
    pub(crate) scenes: Arc<SceneCache>,
    /// Pictures that need not be made again.
    pub(crate) pictures: PictureCache,
    /// Renders that nobody has to wait for.
    pub(crate) jobs: Arc<Jobs>,
    /// What it was told.
    pub(crate) settings: Settings,
}

impl Service {
    /// Opens the caches and goes on with the jobs in a folder.
    pub(crate) fn open(
        settings: &Settings,
        folder: &Path,
        pool: Arc<Pool>,
        observer: Box<dyn JobObserver>,
    ) -> Result<Arc<Self>, StartError> {
        let Settings { answers, caches, jobs, textures } = settings;
        let textures = textures.as_deref().map(|path| {
            let wrong = |error| StartError::Settings(format!("--textures {}: {error}", path.display()));
            TextureFolder::open(path).map_err(wrong)
        });
        let blobs = |part: &str, budget: u64| {
            let folder = caches.cache.as_ref().map(|folder| folder.join(part));
            let open = |folder: &Path| {
                let wrong = |error| StartError::Settings(format!("--cache {}: {error}", folder.display()));
                BlobStore::open(folder, budget).map_err(wrong)
            };
            folder.as_deref().map(open).transpose()
        };
        let store = blobs("scenes", caches.known_scene_bytes)?
            .map_or_else(|| SceneStore::Memory(LruCache::new(caches.known_scene_bytes)), SceneStore::Folder);
        let scenes = Arc::new(SceneCache::new(caches.scene_cache_bytes, textures.transpose()?, store));
        let pictures = PictureCache::new(caches.picture_cache_bytes, blobs("pictures", caches.disk_cache_bytes)?);
        let jobs = Jobs::open(folder, jobs.clone(), Arc::clone(&pool), Arc::clone(&scenes), observer);
        let jobs = jobs.map_err(|error| {
            let advice = match error.kind() {
                io::ErrorKind::ResourceBusy => "Another process uses the folder: each needs one of its own.",
                _ => "The service has to write into this folder: name another with --data DIR.",
            };
            StartError::Machine(format!("jobs cannot be kept in {}: {error}\n\n{advice}", folder.display()))
        })?;
        Ok(Arc::new(Self {
            queue: Queue::new(Arc::clone(&pool), answers.queue, answers.timeout),
            tiles: Queue::new(Arc::clone(&pool), answers.tile_queue, TILE_PATIENCE.min(answers.timeout)),
            pool,
            scenes,
            pictures,
            jobs,
            settings: settings.clone(),
        }))
    }

    /// Queues work and waits for it. Tiles wait in a queue of their own: a viewer asks for many at once, and not twice.
    pub(crate) async fn run<T: Send + 'static, E: From<Error> + Send + 'static>(
        &self,
        task: Task,
        work: impl FnOnce(&Work) -> Result<T, E> + Send + 'static,
    ) -> Result<Done<T>, E> {
        let queue = if task.class == Class::Tiles { &self.tiles } else { &self.queue };
        queue.run(task, work).await
    }
}
