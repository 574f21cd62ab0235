//! The canonical texts of scenes that were told to be remembered, by scene id: in a folder, or else in memory.

use crate::blobs::Blobs;
use crate::recent::Recent;
use axum::body::Bytes;
use std::io;

/// The texts, the one asked for longest ago first to go.
#[derive(Debug)]
pub(super) enum Texts {
    /// They last as long as the process.
    Memory(Recent<String, Bytes>),
    /// They outlast it.
    Folder(Blobs),
}

impl Texts {
    /// The text of a scene. Call this where waiting for a disk hurts nobody.
    pub(super) fn get(&self, id: &str) -> Option<Bytes> {
        match self {
            Self::Memory(texts) => texts.get(id),
            Self::Folder(blobs) => blobs.get(id).map(Bytes::from),
        }
    }

    /// Remembers a text; false if there is no room for it at all.
    pub(super) fn put(&self, id: &str, text: Vec<u8>) -> io::Result<bool> {
        match self {
            Self::Memory(texts) => {
                let bytes = text.len() as u64;
                texts.put(id.to_owned(), text.into(), bytes);
            }
            Self::Folder(blobs) => blobs.put(id, &text)?,
        }
        Ok(self.has(id))
    }

    /// Whether a text is remembered; looking counts as asking for it.
    pub(super) fn has(&self, id: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.get(id).is_some(),
            Self::Folder(blobs) => blobs.has(id),
        }
    }

    /// Bytes of all texts.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Memory(texts) => texts.bytes(),
            Self::Folder(blobs) => blobs.bytes(),
        }
    }

    /// Forgets a text; whether there was one.
    pub(super) fn remove(&self, id: &str) -> bool {
        match self {
            Self::Memory(texts) => texts.remove(id),
            Self::Folder(blobs) => blobs.remove(id),
        }
    }
}
