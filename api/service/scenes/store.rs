//! The canonical texts of scenes that were told to be remembered, by scene id, and for whom: in a folder, or else in memory.
//!
//! A scene belongs to the tenants that have posted it: each has a claim, an entry `SCENE.TENANT` beside the text. It goes
//! when nobody claims it any more, or when there is no room.

use super::ids::{id_of_text, is_scene_id};
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::lru_cache::LruCache;
use std::io;
use std::sync::Arc;

/// Texts and claims in a folder. A scene that was accepted outlives a power cut.
pub(crate) const KIND: BlobKind = BlobKind {
    is_name: |name| {
        let (id, tenant) = name.split_once('.').unwrap_or((name, ""));
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
        is_scene_id(id) && tenant.len() <= 64 && tenant.bytes().all(plain)
    },
    durable: true,
};

/// Whether a file of this name has these contents: the text of a scene, or a claim to one.
pub(crate) fn is_text_of(name: &str, contents: &[u8]) -> bool {
    match name.split_once('.') {
        Some((_, tenant)) => contents == tenant.as_bytes(),
        None => name == id_of_text(contents),
    }
}

/// The texts, the one asked for longest ago first to go.
#[derive(Debug)]
pub(crate) enum SceneStore {
    /// They last as long as the process.
    Memory(LruCache<String, Arc<[u8]>>),
    /// They outlast it.
    Folder(BlobStore),
}

impl SceneStore {
    /// The text of a scene. Call this where waiting for a disk hurts nobody.
    pub(crate) fn get(&self, id: &str) -> Option<Arc<[u8]>> {
        match self {
            Self::Memory(texts) => texts.get(id),
            Self::Folder(blobs) => blobs.get(id).map(|blob| blob.body.into()),
        }
    }

    /// Remembers a text; false if there is no room for it at all.
    pub(crate) fn put(&self, id: &str, text: Vec<u8>) -> io::Result<bool> {
        match self {
            Self::Memory(texts) => {
                let bytes = text.len() as u64;
                texts.put(id.to_owned(), text.into(), bytes);
            }
            Self::Folder(blobs) => blobs.put(id, b"", &text)?,
        }
        Ok(self.has(id))
    }

    /// Whether a text is remembered; looking counts as asking for it.
    pub(crate) fn has(&self, id: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.get(id).is_some(),
            Self::Folder(blobs) => blobs.has(id),
        }
    }

    /// Bytes of all texts.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Memory(texts) => texts.bytes(),
            Self::Folder(blobs) => blobs.bytes(),
        }
    }

    /// Remembers that a tenant wants a scene to be there; whether that is new.
    pub(crate) fn claim(&self, id: &str, tenant: &str) -> io::Result<bool> {
        let name = claim_name(id, tenant);
        let is_new = !self.has(&name);
        if is_new {
            self.put(&name, tenant.as_bytes().to_vec())?;
        }
        Ok(is_new)
    }

    /// Forgets a tenant's claim, and with the last one the text; or at once everything about the scene, if the tenant is
    /// none in particular.
    pub(crate) fn release(&self, id: &str, tenant: Option<&str>) -> Released {
        let claimed = tenant.map_or_else(|| self.has(id), |tenant| self.remove(&claim_name(id, tenant)));
        if !claimed {
            return Released::Unknown;
        }
        let others = self.claims(id);
        if tenant.is_some() && !others.is_empty() {
            return Released::Shared;
        }
        for name in &others {
            self.remove(name);
        }
        self.remove(id);
        Released::Gone
    }

    /// The claims on a scene.
    fn claims(&self, id: &str) -> Vec<String> {
        let all = match self {
            Self::Memory(texts) => texts.keys(),
            Self::Folder(blobs) => blobs.names(),
        };
        let before = claim_name(id, "");
        all.into_iter().filter(|name| name.starts_with(&before)).collect()
    }

    fn remove(&self, name: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.remove(name),
            Self::Folder(blobs) => blobs.remove(name),
        }
    }
}

/// What has become of a scene that a tenant wants no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Released {
    /// It was none of the tenant's.
    Unknown,
    /// Others want it.
    Shared,
    /// Nobody wants it: it is gone.
    Gone,
}

/// Neither ids nor names of tenants have points.
fn claim_name(id: &str, tenant: &str) -> String {
    format!("{id}.{tenant}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_stays_as_long_as_somebody_claims_it() {
        let folder = tempfile::tempdir().unwrap();
        let id = format!("s_{}", "a".repeat(32));
        for texts in [
            SceneStore::Memory(LruCache::new(1_000)),
            SceneStore::Folder(BlobStore::open(folder.path(), 1_000, KIND).unwrap()),
        ] {
            texts.put(&id, b"{}".to_vec()).unwrap();
            assert_eq!([texts.claim(&id, "one"), texts.claim(&id, "one")].map(Result::unwrap), [true, false]);
            assert!(texts.claim(&id, "two").unwrap());
            assert_eq!(texts.release(&id, Some("three")), Released::Unknown);
            assert_eq!(texts.release(&id, Some("one")), Released::Shared);
            assert_eq!(texts.release(&id, Some("one")), Released::Unknown);
            assert!(texts.has(&id));
            assert_eq!(texts.release(&id, Some("two")), Released::Gone);
            assert!(!texts.has(&id));
            texts.put(&id, b"{}".to_vec()).unwrap();
            texts.claim(&id, "one").unwrap();
            assert_eq!(texts.release(&id, None), Released::Gone);
            assert!(!texts.has(&id) && texts.claim(&id, "one").unwrap(), "claims go with the scene");
        }
    }
}
