//! What loading a scene takes from outside.

use super::Scene;
use super::description::Description;
use std::sync::Arc;

/// What loading a scene takes from outside: the files that it names, and memory.
pub trait Files: Sync {
    /// The bytes of a file; at most one more than [`PICTURE_BYTES`](super::limits::PICTURE_BYTES) are needed. An error is the end of a sentence that begins
    /// with the file's name.
    fn read(&self, name: &str) -> Result<Vec<u8>, String>;

    /// Whether there is an asset of this SHA-256, which is then read under the name `sha256:` and its digits.
    fn has_asset(&self, _hash: &str) -> bool {
        false
    }

    /// A scene that is kept and may have the same objects, among them models. This one is then built as a variation of it.
    fn known(&self, _description: &Description) -> Option<Arc<dyn KnownScene>> {
        None
    }

    /// Whether there is memory for so many bytes more, asked before a picture is decoded or a model placed. Without it the scene is not built.
    fn has_room(&self, _bytes: u64) -> bool {
        true
    }
}

/// A scene that somebody keeps, of which others may be variations.
pub trait KnownScene: Send + Sync {
    /// What it was built from, and the scene.
    fn kept(&self) -> Option<(&Description, &Scene)>;
}

/// No files: pictures have to be in the scene.
#[derive(Debug, Clone, Copy)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<Vec<u8>, String> {
        Err("cannot be read: files are not read here. Send it as an asset, and name it \"sha256:...\". A file of a posted model \
             may also be another part of a multipart/form-data body, and a picture may stand in the scene as \
             \"data:image/png;base64,...\""
            .into())
    }
}
