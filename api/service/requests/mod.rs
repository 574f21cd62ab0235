//! The service itself: scenes, pictures and jobs for requests, from the caches or made on the pool.

pub(crate) mod assets;
pub(crate) mod compare;
pub(crate) mod folders;
pub(crate) mod jobs;
pub(crate) mod pictures;
pub(crate) mod scenes;
pub(crate) mod sequences;
mod spread;

use self::folders::Folders;
use super::assets::Assets;
use super::error::{Error, StartError};
use super::farm::Farm;
use super::jobs::{JobObserver, Jobs};
use super::limits::{CacheLimits, Settings};
use super::memory_budget::MemoryBudget;
use super::pictures::cache::{self, PictureCache};
use super::scenes::cache::SceneCache;
use super::scenes::files::AssetSource;
use super::scenes::shared_scenes::SharedScenes;
use super::scenes::store::{self, SceneStore};
use super::scenes::texture_folder::TextureFolder;
use super::scheduler::admission::{Done, Queue, Work};
use super::scheduler::pool::Pool;
use super::scheduler::task::{Class, Task};
use super::storage::blob_store::BlobStore;
use super::storage::folder::Folder;
use super::storage::lru_cache::LruCache;
use super::storage::objects::Objects;
use super::storage_threads::StorageThreads;
use std::io;
use std::sync::Arc;
use std::time::Duration;

/// Time limit of a tile, waiting included. OpenSeadragon gives up after 30 seconds, and never asks again.
const TILE_PATIENCE: Duration = Duration::from_secs(25);

/// Opens the parts of a cache: scenes and pictures.
fn open_cache(folder: &mut Folder, limits: &CacheLimits) -> Result<(BlobStore, BlobStore), StartError> {
    let parts = |folder: &Folder| {
        let scenes = BlobStore::open(&folder.path.join("scenes"), limits.known_scene_bytes, store::KIND)?;
        let pictures = BlobStore::open(&folder.path.join("pictures"), limits.disk_cache_bytes, cache::KIND)?;
        if !folder.is_marked {
            scenes.upgrade(store::is_text_of)?;
            // Their digests did not say which pictures they were.
            pictures.names().iter().for_each(|name| _ = pictures.remove(name));
        }
        Ok((scenes, pictures))
    };
    let wrong = |error: io::Error| StartError::Settings(format!("--cache {}: {error}", folder.path.display()));
    let opened = parts(folder).map_err(wrong)?;
    folder.mark()?;
    Ok(opened)
}

/// The service: pool, queues, caches and jobs, shared by all requests.
#[derive(Debug)]
pub(crate) struct Service {
    /// The threads that render.
    pub(crate) pool: Arc<Pool>,
    /// Requests that wait for the pool.
    pub(crate) queue: Queue,
    /// Tiles that wait for the pool. A viewer asks for many at once.
    pub(crate) tiles: Queue,
    /// Built scenes and posted scenes.
    pub(crate) scenes: Arc<SceneCache>,
    /// What scenes name by its SHA-256.
    pub(crate) assets: Arc<Assets>,
    /// Threads for requests about assets, which also wait for one another.
    asset_threads: StorageThreads,
    /// Threads for other requests that wait for the disk or the store.
    pub(crate) storage_threads: StorageThreads,
    /// Finished pictures.
    pub(crate) pictures: PictureCache,
    /// Renders in the background.
    pub(crate) jobs: Arc<Jobs>,
    /// Who renders what takes long, if it is not this process.
    pub(crate) farm: Option<Arc<Farm>>,
    /// Where pictures of jobs are put that ask for it.
    pub(crate) store: Option<Objects>,
    /// What all of them take their memory from.
    pub(crate) memory: MemoryBudget,
    /// Its settings.
    pub(crate) settings: Settings,
}

impl Service {
    /// Opens the caches and goes on with the jobs in their folders.
    pub(crate) fn open(
        settings: &Settings,
        folders: &mut Folders,
        pool: Arc<Pool>,
        farm: Option<Arc<Farm>>,
        store: Option<Objects>,
        observer: Arc<dyn JobObserver>,
    ) -> Result<Arc<Self>, StartError> {
        let mut settings = settings.clone();
        settings.jobs.durable = settings.jobs.data.is_some() || farm.is_some();
        let Settings { answers, caches, jobs, memory_bytes, textures, .. } = &settings;
        let memory = MemoryBudget::new(*memory_bytes);
        let textures = textures.as_deref().map(|path| {
            let wrong = |error| StartError::Settings(format!("--textures {}: {error}", path.display()));
            TextureFolder::open(path).map_err(wrong)
        });
        let (mut known, on_disk) = match &mut folders.cache {
            None => (SceneStore::Memory(LruCache::new(caches.known_scene_bytes)), None),
            Some(folder) => {
                let (scenes, pictures) = open_cache(folder, caches)?;
                (SceneStore::Folder(scenes), Some(pictures))
            }
        };
        if let Some(farm) = &farm {
            known = SceneStore::Shared(SharedScenes::new(farm.objects.clone(), farm.runtime.clone()));
        }
        let assets = Arc::new(match &farm {
            Some(farm) => Assets::shared(farm.objects.clone(), farm.runtime.clone(), caches.asset_bytes),
            None => Assets::open(&folders.data.path.join("assets"), caches.asset_bytes, jobs.durable)?,
        });
        let scenes = SceneCache::new(caches.scene_cache_bytes, memory.clone(), textures.transpose()?, known)
            .with_assets(AssetSource::Tenants(Arc::clone(&assets)));
        let scenes = Arc::new(scenes);
        let pictures = PictureCache::new(caches.picture_cache_bytes, &memory, on_disk);
        let jobs = Jobs::open(
            &mut folders.data,
            jobs.clone(),
            Arc::clone(&pool),
            Arc::clone(&scenes),
            farm.clone(),
            observer,
        )?;
        Ok(Arc::new(Self {
            queue: Queue::new(Arc::clone(&pool), answers.queue, answers.timeout),
            tiles: Queue::new(Arc::clone(&pool), answers.tile_queue, TILE_PATIENCE.min(answers.timeout)),
            pool,
            scenes,
            assets,
            asset_threads: StorageThreads::default(),
            storage_threads: StorageThreads::default(),
            pictures,
            jobs,
            farm,
            store,
            memory,
            settings,
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
