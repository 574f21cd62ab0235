//! Scenes of a node: each is fetched and built once, whichever slots need it.

use crate::service::error::Error;
use crate::service::farm::work::{SCENE_BYTES, SceneSource};
use crate::service::memory_budget::MemoryBudget;
use crate::service::scenes::cache::SceneCache;
use crate::service::scenes::files::AssetSource;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::{Form, Key, SentScene};
use crate::service::scenes::store::SceneStore;
use crate::service::scheduler::pool::Pool;
use crate::service::scheduler::task::{Class, Task};
use crate::service::sequences::text::split;
use crate::service::storage::lru_cache::LruCache;
use crate::service::storage::objects::{ObjectError, Objects};
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use strahl::render::Control;
use tokio::runtime::Handle;

/// Scenes whose keys are remembered.
const KEYS: u64 = 10_000;

/// The scenes.
#[derive(Debug)]
pub(super) struct NodeScenes {
    store: Objects,
    cache: SceneCache,
    /// Its key in the cache, by what was asked for.
    keys: LruCache<String, Key>,
    /// Those that are being fetched or rendered: the cache may have no room for one of them.
    current: Mutex<HashMap<String, Flight>>,
    /// The threads that build.
    pool: Arc<Pool>,
}

/// A scene that some slots need.
type Flight = Weak<tokio::sync::Mutex<Weak<PreparedScene>>>;

/// Why there is no scene.
#[derive(Debug)]
pub(super) enum NoScene {
    /// There is no room, or the store does not answer: later there may be.
    NotNow(String),
    /// This node has too little memory for it.
    TooLarge(String),
    /// Not on this node, and likely on no other.
    Never(String),
    /// It is not wanted any more.
    Cancelled,
}

impl NodeScenes {
    pub(super) fn new(store: Objects, memory: &MemoryBudget, cache_bytes: u64, pool: Arc<Pool>) -> Self {
        let no_store = SceneStore::Memory(LruCache::new(0));
        let assets = AssetSource::Store(store.clone(), Handle::current());
        let cache = SceneCache::new(cache_bytes, memory.clone(), None, no_store).with_assets(assets);
        Self { store, cache, keys: LruCache::new(KEYS), current: Mutex::default(), pool }
    }

    /// The scene of a piece, in the cache or from the store.
    pub(super) async fn find(self: &Arc<Self>, source: &SceneSource, control: &Control) -> Result<Held, NoScene> {
        let name = serde_json::to_string(source).unwrap_or_default();
        let flight = self.flight(&name);
        // Who comes second waits for the first, and finds the scene.
        let mut current = flight.lock().await;
        let cached = current.upgrade().or_else(|| self.cache.cached(None, &self.keys.get(&name)?));
        let ready = match cached {
            Some(ready) => ready,
            None => self.build(&name, source, control).await?,
        };
        *current = Arc::downgrade(&ready);
        drop(current);
        Ok(Held { ready, _flight: flight })
    }

    fn flight(&self, name: &str) -> Arc<tokio::sync::Mutex<Weak<PreparedScene>>> {
        let mut current = self.current.lock();
        current.retain(|_, flight| flight.strong_count() > 0);
        if let Some(flight) = current.get(name).and_then(Weak::upgrade) {
            return flight;
        }
        let flight = Arc::new(tokio::sync::Mutex::new(Weak::new()));
        current.insert(name.to_owned(), Arc::downgrade(&flight));
        flight
    }

    async fn build(
        self: &Arc<Self>,
        name: &str,
        source: &SceneSource,
        control: &Control,
    ) -> Result<Arc<PreparedScene>, NoScene> {
        let text = match self.store.get(&source.blob(), SCENE_BYTES).await {
            Ok(Some(text)) => text,
            Ok(None) => return Err(NoScene::Never("the scene is not in the store".into())),
            Err(error @ ObjectError::Store(_)) => return Err(NoScene::NotNow(error.to_string())),
            Err(error) => return Err(NoScene::Never(error.to_string())),
        };
        let &SceneSource { format, settings, frame, .. } = source;
        let (scenes, control) = (Arc::clone(self), control.clone());
        let build = move || {
            let text = scenes.cache.memory.metered(text)?;
            let form = Form::Whole(format);
            let workers = Arc::clone(&scenes.pool).join(Task::new(Class::Jobs, "", 1), control);
            if let Some(number) = frame {
                let (sequence, scene) = split(text.as_ref()).ok_or(Error::Internal("the text is no sequence"))?;
                let base = scenes.cache.to_vary(&workers, &SentScene::new(scene, &form, &settings))?;
                let ready = scenes.cache.frame(&workers, &base, sequence.frame(number), &settings, &|_| Ok(()))?;
                return Ok((None, Arc::new(ready)));
            }
            let sent = SentScene::new(text.as_ref(), &form, &settings);
            Ok((Some(sent.key), scenes.cache.find(&workers, &sent)?.ready))
        };
        let built = tokio::task::spawn_blocking(build).await;
        match built.unwrap_or(Err(Error::Internal("building the scene panics"))) {
            Ok((key, ready)) => {
                // Few ask for a frame twice; its geometry is that of the base, which is kept.
                if let Some(key) = key {
                    self.keys.put(name.to_owned(), key, 1);
                }
                Ok(ready)
            }
            Err(Error::Busy { detail, .. }) => Err(NoScene::NotNow(detail)),
            Err(Error::Cancelled) => Err(NoScene::Cancelled),
            Err(Error::Scene(problems)) => Err(NoScene::Never(format!("the scene has problems: {problems}"))),
            Err(Error::Limit { name: "memory_bytes", detail, .. }) => Err(NoScene::TooLarge(detail)),
            Err(Error::Limit { detail, .. }) => Err(NoScene::Never(detail)),
            Err(error) => Err(NoScene::Never(format!("the scene cannot be built: {error:?}"))),
        }
    }
}

/// A scene, for as long as a slot needs it.
#[derive(Debug)]
pub(super) struct Held {
    /// The scene.
    pub(super) ready: Arc<PreparedScene>,
    /// Keeps it where other slots find it.
    _flight: Arc<tokio::sync::Mutex<Weak<PreparedScene>>>,
}
