//! The memory of a scene while it is read and built: taken before each step, as large as the step may need at most.

use super::files::SceneFiles;
use super::prepared::PreparedScene;
use crate::service::error::Error;
use crate::service::memory_budget::Share;
use flate2::bufread::MultiGzDecoder;
use parking_lot::Mutex;
use std::io::Read;
use std::sync::Arc;
use strahl::scene::limits::SCENE_BYTES;
use strahl::scene::recognise::is_gzip;
use strahl::scene::{Description, Files, Format, KnownScene};

/// Bytes that are unpacked at a time.
const PIECE: usize = 1 << 20;

/// The memory, and the files that the scene may name.
pub(super) struct LoadMemory<'a> {
    files: &'a SceneFiles<'a>,
    /// The scene that this one is built as a variation of.
    base: Mutex<Option<Arc<PreparedScene>>>,
    share: Mutex<Share>,
    refused: Mutex<Option<Error>>,
}

impl<'a> LoadMemory<'a> {
    /// Nothing taken yet.
    pub(super) fn new(files: &'a SceneFiles<'a>, share: Share) -> Self {
        Self { files, base: Mutex::default(), share: Mutex::new(share), refused: Mutex::default() }
    }

    /// Takes more.
    pub(super) fn take(&self, bytes: u64) -> Result<(), Error> {
        let mut share = self.share.lock();
        let whole = share.bytes().saturating_add(bytes);
        share.grow(whole)
    }

    /// The text of a compressed file. Of one that is broken or too long the reader says so: there is none.
    pub(super) fn unpacked(&self, text: &[u8], format: Format) -> Result<Option<Vec<u8>>, Error> {
        if format != Format::Nff || !is_gzip(text) {
            return Ok(None);
        }
        let (mut from, mut unpacked) = (MultiGzDecoder::new(text), Vec::new());
        loop {
            self.take(PIECE as u64)?;
            match from.by_ref().take(PIECE as u64).read_to_end(&mut unpacked) {
                Ok(0) => return Ok(Some(unpacked)),
                Ok(_) if unpacked.len() as u64 <= SCENE_BYTES.max => {}
                _ => return Ok(None),
            }
        }
    }

    /// The refusal of memory for a picture, which the scene's problems hide.
    pub(super) fn refusal(&self) -> Result<(), Error> {
        self.refused.lock().take().map_or(Ok(()), Err)
    }

    /// The scene that this one was built as a variation of, if there was one.
    pub(super) fn base(&self) -> Option<Arc<PreparedScene>> {
        self.base.lock().take()
    }

    /// What was taken.
    pub(super) fn into_share(self) -> Share {
        self.share.into_inner()
    }
}

impl Files for LoadMemory<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let bytes = self.files.read(name)?;
        // An asset may be a large model.
        if self.has_room(bytes.len() as u64) { Ok(bytes) } else { Err("has no room in memory".into()) }
    }

    fn has_asset(&self, hash: &str) -> bool {
        self.files.has_asset(hash)
    }

    fn known(&self, description: &Description) -> Option<Arc<dyn KnownScene>> {
        let base = self.files.with_models_of(description)?;
        *self.base.lock() = Some(Arc::clone(&base));
        Some(base)
    }

    fn has_room(&self, bytes: u64) -> bool {
        self.take(bytes).map_err(|error| *self.refused.lock() = Some(error)).is_ok()
    }
}
