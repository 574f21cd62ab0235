//! Scenes that were asked for lately, so that asking again skips reading and building: a picture of a large scene takes
//! less time than its hierarchies.
//!
//! A scene is known by a hash of its bytes and of all that is put over them. Problems are not kept: they are found again.
//! Nor are scenes with pictures from files, which may have changed by the next time; pictures in the scene are part of it.

use crate::folder::Folder;
use crate::picture::milliseconds;
use crate::ready::{Loading, Ready};
use crate::workers::Workers;
use lru::LruCache;
use sha2::{Digest, Sha256};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use strahl::render::Cancelled;
use strahl::scene::{Files, Format, NoFiles, Overrides, Problems, load_with};

/// The scenes, the one that was asked for longest ago first to go.
#[derive(Debug)]
pub(super) struct Scenes {
    /// Bytes they may take together; 0 keeps none.
    budget: u64,
    /// Where the pictures are that they name, if they may.
    textures: Option<Folder>,
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    scenes: LruCache<Key, Arc<Ready>>,
    bytes: u64,
}

type Key = [u8; 32];

/// A scene that a request is about.
#[derive(Debug)]
pub(super) struct Found {
    /// The scene.
    pub(super) ready: Arc<Ready>,
    /// What this request spent on it.
    pub(super) loading: Loading,
    /// Whether it was there already.
    pub(super) kept: bool,
}

impl Scenes {
    /// No scenes yet, and later as many as fit.
    pub(super) fn new(budget: u64, textures: Option<Folder>) -> Self {
        Self { budget, textures, kept: Mutex::new(Kept { scenes: LruCache::unbounded(), bytes: 0 }) }
    }

    /// Bytes of the scenes that are kept.
    pub(super) fn bytes(&self) -> u64 {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).bytes
    }

    /// The scene, from before or else read, checked and compiled on the pool.
    pub(super) fn find(
        &self,
        workers: &Workers,
        bytes: &[u8],
        format: Format,
        overrides: &Overrides,
    ) -> Result<Found, Problems> {
        let files = self.files();
        let build = || {
            let built = workers.work(|| load_with(bytes, format, overrides, files).map(Ready::from));
            // The caller looks whether it was cancelled.
            built.unwrap_or_else(|Cancelled| Err(Problems(Vec::new())))
        };
        if self.budget == 0 {
            let ready = build()?;
            return Ok(Found { loading: ready.loading, ready: Arc::new(ready), kept: false });
        }
        let hashing = Instant::now();
        let key = key(bytes, format, overrides);
        let hashed = Loading { parse: milliseconds(hashing), ..Loading::default() };
        if let Some(ready) = self.look_up(&key) {
            return Ok(Found { ready, loading: hashed, kept: true });
        }
        let ready = Arc::new(build()?);
        if !ready.scene.from_files {
            self.keep(key, &ready);
        }
        let loading = Loading { parse: hashed.parse + ready.loading.parse, ..ready.loading };
        Ok(Found { ready, loading, kept: false })
    }

    /// The pictures that scenes may name.
    pub(super) fn files(&self) -> &dyn Files {
        self.textures.as_ref().map_or(&NoFiles, |folder| folder)
    }

    fn look_up(&self, key: &Key) -> Option<Arc<Ready>> {
        // A panic between two lines of this file leaves at worst a count that is too high.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.scenes.get(key).map(Arc::clone)
    }

    fn keep(&self, key: Key, ready: &Arc<Ready>) {
        let bytes = size(ready);
        if bytes > self.budget {
            return;
        }
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.bytes += bytes;
        // Two requests may have built the same scene at the same time.
        let same = kept.scenes.put(key, Arc::clone(ready));
        kept.bytes -= same.as_ref().map_or(0, |same| size(same));
        let mut gone = Vec::new();
        while kept.bytes > self.budget
            && let Some((_, oldest)) = kept.scenes.pop_lru()
        {
            kept.bytes -= size(&oldest);
            gone.push(oldest);
        }
        // Giving back the memory of a large scene takes its time, and others wait for the lock.
        drop(kept);
        drop((same, gone));
    }
}

fn size(ready: &Ready) -> u64 {
    ready.scene.bytes() as u64
}

/// The overrides go in as they print for debugging, which no field can be missing from.
fn key(bytes: &[u8], format: Format, overrides: &Overrides) -> Key {
    Sha256::new().chain_update(format!("{format:?} {overrides:?}\n")).chain_update(bytes).finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::load;

    fn ready(objects: usize) -> Arc<Ready> {
        let sphere = r#"{ "sphere": { "center": [0, 0, 0], "radius": 1 } }"#;
        let scene = format!(
            r#"{{ "version": 1, "camera": {{ "pinhole": {{ "eye": [0, 0, 5], "look_at": [0, 0, 0] }} }}, "objects": [{}] }}"#,
            vec![sphere; objects].join(",")
        );
        Arc::new(load(scene.as_bytes(), Format::Json, &Overrides::default()).unwrap().into())
    }

    #[test]
    fn the_scene_asked_for_longest_ago_goes_first() {
        let scene = ready(100);
        let scenes = Scenes::new(2 * size(&scene), None);
        let [a, b, c] = [[1; 32], [2; 32], [3; 32]];
        scenes.keep(a, &scene);
        scenes.keep(b, &scene);
        assert!(scenes.look_up(&a).is_some());
        scenes.keep(c, &scene);
        assert_eq!([a, b, c].map(|key| scenes.look_up(&key).is_some()), [true, false, true]);
        scenes.keep(c, &scene);
        assert_eq!(scenes.kept.lock().unwrap().bytes, 2 * size(&scene), "a scene built twice counts once");
    }

    #[test]
    fn a_scene_larger_than_the_budget_throws_nothing_out() {
        let small = ready(1);
        let scenes = Scenes::new(2 * size(&small), None);
        scenes.keep([1; 32], &small);
        scenes.keep([2; 32], &ready(1_000));
        assert!(scenes.look_up(&[1; 32]).is_some() && scenes.look_up(&[2; 32]).is_none());
    }

    #[test]
    fn everything_that_changes_a_scene_changes_its_key() {
        let plain = Overrides::default();
        let of = |bytes: &[u8], format, overrides: &Overrides| key(bytes, format, overrides);
        let first = of(b"{}", Format::Json, &plain);
        assert_eq!(first, of(b"{}", Format::Json, &plain));
        assert_ne!(first, of(b"{ }", Format::Json, &plain));
        assert_ne!(first, of(b"{}", Format::Nff, &plain));
        assert_ne!(first, of(b"{}", Format::Json, &Overrides { min_weight: Some(0.5), ..plain }));
        assert_ne!(first, of(b"{}", Format::Json, &Overrides { two_sided: true, ..plain }));
    }
}
