//! Scenes that were asked for lately, so that asking again skips reading and building: a picture of a large scene takes
//! less time than its hierarchies.
//!
//! A scene is known by a hash of its bytes and of all that is put over them. Problems are not kept: they are found again.
//! Nor are scenes with pictures from files, which may have changed by the next time; pictures in the scene are part of it.

use super::prepared::{Loading, PreparedScene};
use super::store::SceneStore;
use super::texture_folder::TextureFolder;
use crate::http::problem::{Kind, Problem};
use crate::service::pictures::render::milliseconds;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::pool::Workers;
use crate::service::storage::hit_counter::HitCounter;
use crate::service::storage::lru_cache::LruCache;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use std::time::Instant;
use strahl::render::Cancelled;
use strahl::scene::{Files, Format, Loaded, NoFiles, Overrides, Problems, load_with};

/// Scenes that are remembered by id only to find them by what they were sent as.
const NAMES: u64 = 10_000;

/// The scenes, the one that was asked for longest ago first to go.
#[derive(Debug)]
pub(crate) struct SceneCache {
    /// Where the pictures are that they name, if they may.
    textures: Option<TextureFolder>,
    kept: LruCache<Key, Arc<PreparedScene>>,
    /// What a scene of a name was last sent as.
    names: LruCache<String, Key>,
    /// Scenes that can be built again.
    pub(crate) texts: SceneStore,
    /// How often a scene was built already.
    pub(crate) hits: HitCounter,
}

/// A hash of a scene as it was sent, and of all that is put over it.
pub(crate) type Key = [u8; 32];

/// A scene that a request is about.
#[derive(Debug)]
pub(crate) struct Found {
    /// The scene.
    pub(crate) ready: Arc<PreparedScene>,
    /// What this request spent on it.
    pub(crate) loading: Loading,
    /// Whether it was there already.
    pub(crate) kept: bool,
}

impl SceneCache {
    /// No scenes yet, and later as many as fit.
    pub(crate) fn new(budget: u64, textures: Option<TextureFolder>, texts: SceneStore) -> Self {
        Self { textures, kept: LruCache::new(budget), names: LruCache::new(NAMES), texts, hits: HitCounter::default() }
    }

    /// Bytes of the scenes that are kept.
    pub(crate) fn bytes(&self) -> u64 {
        self.kept.bytes()
    }

    /// The scene, from before or else read, checked and compiled on the pool.
    pub(crate) fn find(
        &self,
        workers: &Workers,
        bytes: &[u8],
        format: Format,
        overrides: &Overrides,
    ) -> Result<Found, Problems> {
        let hashing = Instant::now();
        let key = key(bytes, format, overrides);
        let parse = milliseconds(hashing);
        if let Some(ready) = self.recall(&key) {
            return Ok(Found { ready, loading: Loading { parse, ..Loading::default() }, kept: true });
        }
        self.hits.miss();
        let ready = self.build(workers, bytes, format, overrides, PreparedScene::from)?;
        let loading = Loading { parse: parse + ready.loading.parse, ..ready.loading };
        Ok(Found { ready: self.keep(key, ready), loading, kept: false })
    }

    /// The scene of a name, built or to be built from its text.
    pub(crate) fn find_known(&self, job: &Work, id: &str) -> Result<Found, Problem> {
        if let Some(ready) = self.recall_known(id) {
            return Ok(Found { ready, loading: Loading::default(), kept: true });
        }
        let text = self.texts.get(id).ok_or_else(|| unknown(id))?;
        let found = self.find(&job.workers, &text, Format::Json, &Overrides::default());
        found.map_err(|problems| {
            // Canonical texts have been scenes; only the renderer's limits may have changed since.
            Problem::scene(&problems)
        })
    }

    /// Reads, checks and compiles a scene; `read` makes of it what is wanted. A job that was cancelled gets no problems.
    pub(crate) fn build<T: Send>(
        &self,
        workers: &Workers,
        bytes: &[u8],
        format: Format,
        overrides: &Overrides,
        read: impl FnOnce(Loaded) -> T + Send,
    ) -> Result<T, Problems> {
        let files = self.files();
        let built = workers.work(|| load_with(bytes, format, overrides, files).map(read));
        // The caller looks whether it was cancelled.
        built.unwrap_or_else(|Cancelled| Err(Problems(Vec::new())))
    }

    /// The scene that was sent like this, if it is still built.
    pub(crate) fn recall(&self, key: &Key) -> Option<Arc<PreparedScene>> {
        self.kept.get(key).inspect(|_| self.hits.hit())
    }

    /// The scene of a name, if it is still built.
    pub(crate) fn recall_known(&self, id: &str) -> Option<Arc<PreparedScene>> {
        self.recall(&self.names.get(id)?)
    }

    /// Keeps a built scene, unless its pictures are files.
    pub(crate) fn keep(&self, key: Key, ready: PreparedScene) -> Arc<PreparedScene> {
        let ready = Arc::new(ready);
        if !ready.scene.from_files {
            self.kept.put(key, Arc::clone(&ready), ready.scene.bytes() as u64);
            if ready.reproducible {
                self.names.put(ready.scene_id.clone(), key, 1);
            }
        }
        ready
    }

    /// Forgets the built scene of a name.
    pub(crate) fn forget(&self, id: &str) {
        if let Some(key) = self.names.get(id) {
            self.kept.remove(&key);
        }
        self.names.remove(id);
    }

    /// The pictures that scenes may name.
    pub(crate) fn files(&self) -> &dyn Files {
        self.textures.as_ref().map_or(&NoFiles, |folder| folder)
    }
}

/// No scene has this name, any more or ever.
pub(crate) fn unknown(id: &str) -> Problem {
    let detail = format!("the scene {id} is not known here, or no longer: send it to POST /v1/scenes");
    Problem::new(Kind::NotFound, detail)
}

/// The overrides go in as they print for debugging, which no field can be missing from.
pub(crate) fn key(bytes: &[u8], format: Format, overrides: &Overrides) -> Key {
    Sha256::new().chain_update(format!("{format:?} {overrides:?}\n")).chain_update(bytes).finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::nff::NffOptions;

    #[test]
    fn everything_that_changes_a_scene_changes_its_key() {
        let plain = Overrides::default();
        let of = |bytes: &[u8], format, overrides: &Overrides| key(bytes, format, overrides);
        let first = of(b"{}", Format::Json, &plain);
        assert_eq!(first, of(b"{}", Format::Json, &plain));
        assert_ne!(first, of(b"{ }", Format::Json, &plain));
        assert_ne!(first, of(b"{}", Format::Nff, &plain));
        assert_ne!(first, of(b"{}", Format::Json, &Overrides { min_weight: Some(0.5), ..plain }));
        assert_ne!(
            first,
            of(b"{}", Format::Json, &Overrides { nff: NffOptions { two_sided: true, ..plain.nff }, ..plain })
        );
    }
}
