//! The LRU cache of built scenes: a second request about a scene skips reading and building it, which takes longer than a
//! picture of a large scene.
//!
//! The key of a scene is a hash of its bytes, format and settings. Invalid scenes are not cached, nor are scenes with textures
//! from files, which may change between requests.

use super::files::{AssetSource, SceneFiles};
use super::ids::BodiesDigest;
use super::load_memory::LoadMemory;
use super::prepared::{Loading, PreparedScene};
use super::sent_scene::{Form, Key, SentScene};
use super::store::SceneStore;
use super::texture_folder::TextureFolder;
use super::views::ModelKey;
use crate::service::error::Error;
use crate::service::memory_budget::{MemoryBudget, Share};
use crate::service::scheduler::pool::Workers;
use crate::service::storage::hit_counter::HitCounter;
use crate::service::storage::lru_cache::LruCache;
use crate::service::storage::seen_by::SeenBy;
use std::sync::Arc;
use strahl::scene::compile::Original;
use strahl::scene::size::{building_bytes, reading_bytes};
use strahl::scene::variation::vary_if;
use strahl::scene::{Description, Format, Loaded, NotLoaded, Overrides, load_if};
use strahl::sequence::Frame;

/// Most scene ids that are kept.
const IDS: u64 = 10_000;

/// The scenes.
#[derive(Debug)]
pub(crate) struct SceneCache {
    /// Folder of the textures that scenes may name, if there is one.
    textures: Option<TextureFolder>,
    /// The assets that they may name.
    assets: AssetSource,
    built: Arc<LruCache<Key, Arc<PreparedScene>>>,
    /// Variations of them. Each keeps what it is a variation of in memory and is counted with it, so they have bytes of their
    /// own: looking at a large scene from all sides must not push out all others.
    varied: Arc<LruCache<Key, Arc<PreparedScene>>>,
    /// Views of models, of which other views are made.
    pub(super) models: Arc<LruCache<ModelKey, Arc<PreparedScene>>>,
    /// Scenes with models, of which those with the same models are made.
    pub(super) placed: Arc<LruCache<BodiesDigest, Arc<PreparedScene>>>,
    /// What scenes take their memory from.
    pub(crate) memory: MemoryBudget,
    /// Key with which the scene of an id was last sent.
    ids: LruCache<String, Key>,
    /// Texts of scenes, from which they can be built again.
    pub(crate) store: SceneStore,
    /// Hits and misses of built scenes.
    pub(crate) hits: HitCounter,
    /// Who has had which scene, by its id.
    seen: SeenBy,
}

/// The scene of a request.
#[derive(Debug)]
pub(crate) struct Found {
    /// The scene.
    pub(crate) ready: Arc<PreparedScene>,
    /// What this request spent on it, or what the request of another tenant has spent.
    pub(crate) loading: Loading,
    /// Whether it was in the cache, and the tenant may know.
    pub(crate) cached: bool,
}

/// A scene that was built.
#[derive(Debug)]
pub(crate) struct Built {
    /// The scene.
    pub(crate) loaded: Loaded,
    /// The one that it is a variation of.
    pub(crate) original: Option<Arc<PreparedScene>>,
    /// The memory that it takes.
    pub(crate) share: Share,
}

impl Built {
    /// The scene without its description.
    pub(crate) fn prepared(self) -> PreparedScene {
        PreparedScene::new(self.loaded, self.original.as_ref()).with(self.share)
    }

    /// The scene with it, to make variations of.
    pub(super) fn into_original(self) -> PreparedScene {
        PreparedScene::to_vary(self.loaded, self.original.as_ref()).with(self.share)
    }
}

/// Refuses a scene that was read and is not built yet.
pub(crate) type Accept<'a> = &'a (dyn Fn(&Description) -> Result<(), Error> + Sync);

/// Loads a scene that depends on another one.
type Load<'a> = &'a (dyn Fn(Original<'_>, &LoadMemory<'_>, Accept<'_>) -> Result<Loaded, NotLoaded<Error>> + Sync);

/// What reading a scene took, of which the scene of a request is a variation.
pub(super) struct Spent {
    parse_ms: f64,
    plan_ms: f64,
    bvh_ms: f64,
}

impl Spent {
    pub(super) fn of(loaded: &Loaded) -> Self {
        Self { parse_ms: loaded.parse_ms, plan_ms: loaded.plan_ms, bvh_ms: loaded.scene.bvh_ms }
    }

    /// The variation as this request has paid for it.
    pub(super) fn on(self, mut loaded: Loaded) -> Loaded {
        (loaded.parse_ms, loaded.plan_ms) = (self.parse_ms, self.plan_ms + loaded.plan_ms);
        loaded.scene.bvh_ms += self.bvh_ms;
        loaded
    }
}

/// Bytes of the longest patch: as a tree of values it takes 16 times as much.
pub(crate) const PATCH_BYTES: u64 = 4 << 20;

/// Bytes that reading a patch takes.
fn patching_bytes(patch: &[u8]) -> Result<u64, Error> {
    if patch.len() as u64 > PATCH_BYTES {
        let detail = format!("a patch has at most {PATCH_BYTES} bytes (patch_bytes): send the whole scene");
        return Err(Error::Limit { name: "patch_bytes", max: PATCH_BYTES, detail });
    }
    Ok(16 * patch.len() as u64)
}

impl SceneCache {
    /// No scenes yet, and later as many as fit.
    pub(crate) fn new(budget: u64, memory: MemoryBudget, textures: Option<TextureFolder>, store: SceneStore) -> Self {
        let [built, varied] = [(); 2].map(|()| Arc::new(LruCache::new(budget)));
        memory.evict_from(Arc::<LruCache<_, _>>::downgrade(&built));
        memory.evict_from(Arc::<LruCache<_, _>>::downgrade(&varied));
        let models = Arc::new(LruCache::new(budget));
        memory.evict_from(Arc::<LruCache<_, _>>::downgrade(&models));
        let placed = Arc::new(LruCache::new(budget));
        memory.evict_from(Arc::<LruCache<_, _>>::downgrade(&placed));
        Self {
            textures,
            assets: AssetSource::None,
            built,
            varied,
            models,
            placed,
            memory,
            ids: LruCache::new(IDS),
            store,
            hits: HitCounter::default(),
            seen: SeenBy::default(),
        }
    }

    /// The same with assets.
    pub(crate) fn with_assets(self, assets: AssetSource) -> Self {
        Self { assets, ..self }
    }

    /// A scene that was built already, as a tenant may see it.
    fn found(&self, tenant: &str, ready: Arc<PreparedScene>, hash_ms: f64) -> Found {
        let cached = self.note(tenant, &ready);
        let loading = if cached { Loading::default() } else { ready.loading };
        Found { loading: Loading { parse: loading.parse + hash_ms, ..loading }, ready, cached }
    }

    /// Notes that a tenant has a scene; whether it had it before.
    pub(crate) fn note(&self, tenant: &str, ready: &PreparedScene) -> bool {
        self.seen.note(tenant, &ready.scene_id)
    }

    /// Bytes of the built scenes.
    pub(crate) fn bytes(&self) -> u64 {
        self.built.bytes() + self.varied.bytes() + self.models.bytes() + self.placed.bytes()
    }

    /// The scene, from the cache or else read, checked and compiled on the pool.
    pub(crate) fn find(&self, workers: &Workers, sent: &SentScene<'_>) -> Result<Found, Error> {
        self.find_if(workers, sent, &|_| Ok(()))
    }

    /// The same, but a scene that `accept` refuses is not built.
    pub(crate) fn find_if(&self, workers: &Workers, sent: &SentScene<'_>, accept: Accept<'_>) -> Result<Found, Error> {
        if let Some(ready) = self.cached(sent.owner(workers), &sent.key) {
            return Ok(self.found(workers.tenant(), ready, sent.hash_ms));
        }
        self.hits.miss();
        let built = self.build(workers, sent, accept)?;
        let ready = workers.work(|| built.prepared())?;
        self.note(workers.tenant(), &ready);
        let loading = Loading { parse: sent.hash_ms + ready.loading.parse, ..ready.loading };
        Ok(Found { ready: self.keep(sent.key, ready), loading, cached: false })
    }

    /// The scene of an id, from the cache or else built from its text in the store.
    pub(crate) fn find_known(&self, workers: &Workers, id: &str) -> Result<Found, Error> {
        if let Some(ready) = self.cached_known(id) {
            return Ok(self.found(workers.tenant(), ready, 0.0));
        }
        let (text, _share) = self.stored(id)?;
        // Stored texts were valid scenes. They are invalid now only if the renderer's limits have changed.
        self.find(workers, &SentScene::known(&text, &Form::JSON, &Overrides::default()))
    }

    /// A scene with several settings in turn, which shares its geometry.
    pub(crate) fn find_several(
        &self,
        workers: &Workers,
        sent: &SentScene<'_>,
        settings: &[Overrides],
    ) -> Result<Vec<Arc<PreparedScene>>, Error> {
        let mut base: Option<Arc<PreparedScene>> = None;
        // Each of the settings multiplies its pixels once.
        let unscaled = SentScene { overrides: Overrides { dpr: None, ..sent.overrides }, ..*sent };
        let mut one = |overrides: &Overrides| {
            let own = SentScene::new(sent.text, sent.form, overrides);
            if matches!(sent.form, Form::Variation(_)) || self.cached(own.owner(workers), &own.key).is_some() {
                return Ok(self.find(workers, &own)?.ready);
            }
            let original = match &base {
                Some(base) => Arc::clone(base),
                None => {
                    let built = self.build(workers, &unscaled, &|_| Ok(()))?;
                    Arc::clone(base.insert(Arc::new(workers.work(|| built.into_original())?)))
                }
            };
            let built = self.vary(workers, original, (b"{}", overrides), &|_| Ok(()))?;
            Ok(self.keep(own.key, workers.work(|| built.prepared())?))
        };
        settings.iter().map(&mut one).collect()
    }

    /// A scene of which the frames of a sequence are made, from the cache or else built.
    pub(crate) fn to_vary(&self, workers: &Workers, sent: &SentScene<'_>) -> Result<Arc<PreparedScene>, Error> {
        if let Some(ready) = self.cached(sent.owner(workers), &sent.key).filter(|ready| ready.original().is_some()) {
            return Ok(ready);
        }
        let built = self.build(workers, sent, &|_| Ok(()))?;
        Ok(self.keep(sent.key, workers.work(|| built.into_original())?))
    }

    /// The scene of a frame, unless `accept` refuses it.
    pub(crate) fn frame(
        &self,
        workers: &Workers,
        original: &Arc<PreparedScene>,
        frame: Frame<'_>,
        overrides: &Overrides,
        accept: Accept<'_>,
    ) -> Result<PreparedScene, Error> {
        let load: Load<'_> = &|known, memory, accept| frame.load_if(known, overrides, memory, accept);
        let built = self.vary_by(workers, Arc::clone(original), frame.patch(), load, accept)?;
        Ok(workers.work(|| built.prepared())?)
    }

    /// The scene of an id with its description, of which variations are made.
    fn original(&self, workers: &Workers, id: &str) -> Result<Arc<PreparedScene>, Error> {
        if let Some(ready) = self.cached_known(id).filter(|ready| ready.original().is_some()) {
            return Ok(ready);
        }
        let (text, _share) = self.stored(id)?;
        let sent = SentScene::known(&text, &Form::JSON, &Overrides::default());
        self.to_vary(workers, &sent)
    }

    /// The text of a stored scene, and the memory that it takes.
    fn stored(&self, id: &str) -> Result<(Arc<[u8]>, Share), Error> {
        let text = self.store.get(id).map_err(|error| Error::io("the stored scene cannot be read", &error))?;
        let text = text.ok_or_else(|| Error::UnknownScene(id.to_owned()))?;
        let mut share = self.memory.share(0);
        share.grow(text.len() as u64)?;
        Ok((text, share))
    }

    /// Reads a scene, checks and compiles it unless `accept` refuses it.
    pub(crate) fn build(&self, workers: &Workers, sent: &SentScene<'_>, accept: Accept<'_>) -> Result<Built, Error> {
        let &SentScene { text, form, ref overrides, .. } = sent;
        let format = match form {
            Form::Whole(format) => *format,
            Form::Variation(id) => {
                return self.vary(workers, self.original(workers, id)?, (text, overrides), accept);
            }
        };
        if let Some(key) = sent.model_key() {
            return self.view(workers, sent, format, key, accept);
        }
        let built = self.load(workers, sent, format, accept)?;
        let Loaded { scene, description, .. } = &built.loaded;
        let has_models = !scene.assets.is_empty() && !scene.from_files && description.has_models();
        if built.original.is_some() || !has_models {
            return Ok(built);
        }
        let spent = Spent::of(&built.loaded);
        let base = Arc::new(workers.work(|| built.into_original())?);
        let bytes = base.bytes();
        drop(self.placed.put(base.bodies, Arc::clone(&base), bytes));
        let again = self.vary(workers, base, (b"{}", &Overrides::default()), &|_| Ok(()))?;
        Ok(Built { loaded: spent.on(again.loaded), ..again })
    }

    /// Reads, checks and compiles a scene unless `accept` refuses it.
    pub(super) fn load(
        &self,
        workers: &Workers,
        sent: &SentScene<'_>,
        format: Format,
        accept: Accept<'_>,
    ) -> Result<Built, Error> {
        let &SentScene { text, ref overrides, .. } = sent;
        let files = self.files(sent.owner(workers));
        let memory = LoadMemory::new(&files, self.memory.share(text.len() as u64));
        let build = || {
            let unpacked = memory.unpacked(text, format)?;
            let text = unpacked.as_deref().unwrap_or(text);
            memory.take(reading_bytes(text, format))?;
            let accept = |description: &Description| {
                accept(description)?;
                memory.take(building_bytes(description))
            };
            let loaded = load_if(text, format, overrides, &memory, &accept);
            memory.refusal()?;
            loaded.map_err(|error| self.assets.reason(error.into()))
        };
        let loaded = workers.work(build)??;
        let original = memory.base();
        Ok(Built { loaded, original, share: memory.into_share() })
    }

    /// The same for what a patch and settings make of another scene.
    fn vary(
        &self,
        workers: &Workers,
        original: Arc<PreparedScene>,
        (patch, overrides): (&[u8], &Overrides),
        accept: Accept<'_>,
    ) -> Result<Built, Error> {
        let load: Load<'_> = &|known, memory, accept| vary_if(known, patch, overrides, memory, accept);
        self.vary_by(workers, original, patch, load, accept)
    }

    /// The same for what `load` makes of another scene, with a patch.
    fn vary_by(
        &self,
        workers: &Workers,
        original: Arc<PreparedScene>,
        patch: &[u8],
        load: Load<'_>,
        accept: Accept<'_>,
    ) -> Result<Built, Error> {
        let files = self.files(Some(workers.tenant()));
        let memory = LoadMemory::new(&files, self.memory.share(patch.len() as u64));
        let vary = || {
            let known = original.original().ok_or(Error::Internal("the scene has no description"))?;
            memory.take(patching_bytes(patch)?)?;
            let accept = |description: &Description| {
                accept(description)?;
                memory.take(known.building_bytes(description))
            };
            let loaded = load(known, &memory, &accept);
            memory.refusal()?;
            loaded.map_err(|error| self.assets.reason(error.into()))
        };
        let loaded = workers.work(vary)??;
        Ok(Built { loaded, original: Some(original), share: memory.into_share() })
    }

    /// The built scene of a key, if it is in the cache and a tenant has the assets that it names.
    pub(crate) fn cached(&self, tenant: Option<&str>, key: &Key) -> Option<Arc<PreparedScene>> {
        let found = self.built.get(key).or_else(|| self.varied.get(key));
        let may_see = |ready: &Arc<PreparedScene>| self.assets.has_all(tenant, &ready.scene.assets);
        found.filter(may_see).inspect(|_| self.hits.hit())
    }

    /// The built scene of an id, if it is in the cache.
    pub(crate) fn cached_known(&self, id: &str) -> Option<Arc<PreparedScene>> {
        self.cached(None, &self.ids.get(id)?)
    }

    /// Caches a built scene, unless it has textures from files.
    pub(crate) fn keep(&self, key: Key, ready: PreparedScene) -> Arc<PreparedScene> {
        let ready = Arc::new(ready);
        if !ready.scene.from_files {
            match ready.bytes_with_original() {
                Some(bytes) => drop(self.varied.put(key, Arc::clone(&ready), bytes)),
                None => drop(self.built.put(key, Arc::clone(&ready), ready.bytes())),
            }
            if ready.reproducible {
                self.ids.put(ready.scene_id.clone(), key, 1);
            }
        }
        ready
    }

    /// Deletes the built scene of an id.
    pub(crate) fn forget(&self, id: &str) {
        if let Some(key) = self.ids.get(id) {
            self.built.remove(&key);
            self.varied.remove(&key);
        }
        self.ids.remove(id);
    }

    /// The files that scenes of a tenant may name; without one, any that are there.
    pub(crate) fn files<'a>(&'a self, tenant: Option<&'a str>) -> SceneFiles<'a> {
        SceneFiles { folder: self.textures.as_ref(), assets: &self.assets, kept: &self.placed, tenant }
    }
}
