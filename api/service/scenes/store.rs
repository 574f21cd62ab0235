//! The canonical texts of posted scenes by scene id, on disk or in memory.
//!
//! A scene belongs to the tenants that have posted it: each has a claim, an entry `SCENE.TENANT` beside the text, which holds
//! the text as the tenant has written it. The scene is deleted with the last claim, or when there is no room for it. In a farm they
//! are in its store (`shared_scenes.rs`), where none is deleted by itself.

use super::ids::{is_id_of_text, is_scene_id};
use super::shared_scenes::SharedScenes;
use crate::service::is_tenant_name;
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::lru_cache::LruCache;
use std::io;
use std::sync::Arc;
use strahl::scene::Format;

/// Texts and claims in a folder. A scene that was accepted outlives a power cut.
pub(crate) const KIND: BlobKind = BlobKind {
    is_name: |name| {
        let (id, tenant) = name.split_once('.').map_or((name, None), |(id, tenant)| (id, Some(tenant)));
        is_scene_id(id) && tenant.is_none_or(is_tenant_name)
    },
    durable: true,
};

/// Whether a file of this name has these contents: the text of a scene, or a claim to one.
pub(crate) fn is_text_of(name: &str, contents: &[u8]) -> bool {
    match name.split_once('.') {
        Some((_, tenant)) => contents == tenant.as_bytes() || Source::read(contents).is_some(),
        None => is_id_of_text(name, contents),
    }
}

/// Bytes that a text in memory takes beside its own.
const ENTRY_BYTES: u64 = 512;

/// Bytes of the longest text that is kept as it was sent.
const SOURCE_BYTES: usize = 1 << 20;

/// A scene as its author has written it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Source<'a> {
    /// The format.
    pub(crate) format: Format,
    /// The text.
    pub(crate) text: &'a [u8],
}

impl<'a> Source<'a> {
    /// The one that a claim holds.
    pub(crate) fn read(claim: &'a [u8]) -> Option<Self> {
        let of = |format: Format| Some(Self { format, text: claim.strip_prefix(Self::head(format))? });
        let models = [Format::Gltf, Format::Obj, Format::Stl, Format::Ply, Format::Parts];
        [Format::Json, Format::Nff].into_iter().chain(models).find_map(of)
    }

    fn written(self) -> Vec<u8> {
        [Self::head(self.format), self.text].concat()
    }

    /// Names of tenants contain no line breaks.
    fn head(format: Format) -> &'static [u8] {
        match format {
            Format::Json => b"json\n",
            Format::Nff => b"nff\n",
            Format::Gltf => b"gltf\n",
            Format::Obj => b"obj\n",
            Format::Stl => b"stl\n",
            Format::Ply => b"ply\n",
            Format::Parts => b"parts\n",
        }
    }
}

/// The texts. The least recently used are deleted first.
#[derive(Debug)]
pub(crate) enum SceneStore {
    /// In memory, until the process ends.
    Memory(LruCache<String, Arc<[u8]>>),
    /// On disk.
    Folder(BlobStore),
    /// Where all fronts of a farm find them.
    Shared(SharedScenes),
}

impl SceneStore {
    /// The text of a scene. This may wait for the disk, and fails if that cannot be read now.
    pub(crate) fn get(&self, id: &str) -> io::Result<Option<Arc<[u8]>>> {
        match self {
            Self::Memory(texts) => Ok(texts.get(id)),
            Self::Folder(blobs) => Ok(blobs.get(id)?.map(|blob| blob.body.into())),
            Self::Shared(scenes) => scenes.get(id),
        }
    }

    /// Stores a text. False if it is larger than the store.
    pub(crate) fn put(&self, id: &str, text: Vec<u8>) -> io::Result<bool> {
        match self {
            Self::Memory(texts) => {
                let bytes = text.len() as u64 + ENTRY_BYTES;
                texts.put(id.to_owned(), text.into(), bytes);
            }
            Self::Folder(blobs) => blobs.put(id, b"", &text)?,
            Self::Shared(scenes) => {
                scenes.put(id, text)?;
                return Ok(true);
            }
        }
        Ok(self.has(id))
    }

    /// Whether a text is stored. This counts as a use.
    pub(crate) fn has(&self, id: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.get(id).is_some(),
            Self::Folder(blobs) => blobs.has(id),
            Self::Shared(scenes) => scenes.has(id),
        }
    }

    /// The same, which does not count as a use.
    pub(crate) fn holds(&self, id: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.holds(id),
            Self::Folder(blobs) => blobs.holds(id),
            Self::Shared(scenes) => scenes.has(id),
        }
    }

    /// Bytes of all texts that this process keeps.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Memory(texts) => texts.bytes(),
            Self::Folder(blobs) => blobs.bytes(),
            Self::Shared(_) => 0,
        }
    }

    /// Adds a tenant's claim, with the text that it has sent if that is not too long. False if there was one.
    pub(crate) fn claim(&self, id: &str, tenant: &str, source: Option<Source<'_>>) -> io::Result<bool> {
        let source = source.filter(|source| source.text.len() <= SOURCE_BYTES);
        if let Self::Shared(scenes) = self {
            return scenes.claim(id, tenant, source.map(Source::written));
        }
        let name = claim_name(id, tenant);
        let is_new = !self.has(&name);
        if is_new || source.is_some() {
            self.put(&name, source.map_or_else(|| tenant.as_bytes().to_vec(), Source::written))?;
        }
        Ok(is_new)
    }

    /// What a tenant's claim holds: its own text, or one that is not known.
    pub(crate) fn claimed(&self, id: &str, tenant: &str) -> Option<Arc<[u8]>> {
        match self {
            Self::Shared(scenes) => scenes.claimed(id, tenant),
            _ => self.get(&claim_name(id, tenant)).ok()?,
        }
    }

    /// Whether a text is stored to which a tenant has a claim, or anybody. Fails if the store of a farm does not answer.
    pub(crate) fn is_known(&self, id: &str, tenant: Option<&str>) -> io::Result<bool> {
        match (self, tenant) {
            (Self::Shared(scenes), Some(tenant)) => scenes.is_claimed(id, tenant),
            (Self::Shared(scenes), None) => scenes.is_stored(id),
            (_, Some(tenant)) => Ok(self.has(&claim_name(id, tenant))),
            (_, None) => Ok(self.has(id)),
        }
    }

    /// Deletes a tenant's claim, and with the last one the text. Without a tenant all claims are deleted. Who claims it at the same time
    /// looks for the text afterwards, and this looks for claims once more, so one of the two puts it back.
    pub(crate) fn release(&self, id: &str, tenant: Option<&str>) -> io::Result<Released> {
        if let Self::Shared(scenes) = self {
            return scenes.release(id, tenant);
        }
        let claimed = tenant.map_or_else(|| self.has(id), |tenant| self.remove(&claim_name(id, tenant)));
        if !claimed {
            return Ok(Released::Unknown);
        }
        let others = self.claims(id);
        if tenant.is_some() && !others.is_empty() {
            return Ok(Released::Shared);
        }
        for name in &others {
            self.remove(name);
        }
        let text = self.get(id)?;
        self.remove(id);
        match text {
            Some(text) if !self.claims(id).is_empty() => self.put(id, text.to_vec()).map(|_| Released::Shared),
            _ => Ok(Released::Gone),
        }
    }

    /// The claims on a scene.
    fn claims(&self, id: &str) -> Vec<String> {
        let all = match self {
            Self::Memory(texts) => texts.keys(),
            Self::Folder(blobs) => blobs.names(),
            Self::Shared(_) => Vec::new(),
        };
        let before = claim_name(id, "");
        all.into_iter().filter(|name| name.starts_with(&before)).collect()
    }

    fn remove(&self, name: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.remove(name),
            Self::Folder(blobs) => blobs.remove(name),
            Self::Shared(_) => false,
        }
    }
}

/// What has become of a scene after a claim was released.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Released {
    /// The tenant had no claim.
    Unknown,
    /// Other tenants have claims.
    Shared,
    /// There was no other claim: the scene is deleted.
    Gone,
}

/// Neither ids nor names of tenants contain dots.
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
            SceneStore::Memory(LruCache::new(10_000)),
            SceneStore::Folder(BlobStore::open(folder.path(), 1_000, KIND).unwrap()),
        ] {
            texts.put(&id, b"{}".to_vec()).unwrap();
            let source = Source { format: Format::Nff, text: b"v" };
            let claims = [None, Some(source), None].map(|source| texts.claim(&id, "one", source).unwrap());
            assert_eq!(claims, [true, false, false]);
            assert_eq!(texts.claimed(&id, "one").as_deref().and_then(Source::read), Some(source));
            assert!(texts.claim(&id, "two", None).unwrap());
            assert_eq!(texts.claimed(&id, "two").as_deref().and_then(Source::read), None);
            assert_eq!(texts.release(&id, Some("three")).unwrap(), Released::Unknown);
            assert_eq!(texts.release(&id, Some("one")).unwrap(), Released::Shared);
            assert_eq!(texts.release(&id, Some("one")).unwrap(), Released::Unknown);
            assert!(texts.has(&id));
            assert_eq!(texts.release(&id, Some("two")).unwrap(), Released::Gone);
            assert!(!texts.has(&id));
            texts.put(&id, b"{}".to_vec()).unwrap();
            texts.claim(&id, "one", None).unwrap();
            assert_eq!(texts.release(&id, None).unwrap(), Released::Gone);
            assert!(!texts.has(&id) && texts.claim(&id, "one", None).unwrap(), "claims go with the scene");
        }
    }
}
