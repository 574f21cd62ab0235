//! Where bytes are kept by name: in a folder of this process (`blob_store.rs`), or in the store of a farm (`shared_blobs.rs`).

use super::blob_store::{Blob, BlobStore};
use std::fmt;
use std::io;
use std::time::Duration;

/// Bytes by name, each with a head that can be read alone. They may take their time: not for threads of a runtime.
pub(crate) trait Blobs: fmt::Debug + Send + Sync {
    /// What is kept by a name, if it is there and whole. It fails if that cannot be known now.
    fn get(&self, name: &str) -> io::Result<Option<Blob>>;

    /// The head alone.
    fn head(&self, name: &str) -> io::Result<Option<Vec<u8>>>;

    /// Keeps bytes under a name.
    fn put(&self, name: &str, head: &[u8], body: &[u8]) -> io::Result<()>;

    /// Forgets a name.
    fn remove(&self, name: &str);

    /// Bytes of what is kept by a name, as far as it is known.
    fn size(&self, name: &str) -> Option<u64>;

    /// Bytes of all that is kept.
    fn bytes(&self) -> u64;

    /// Whether the place where they are kept is there.
    fn is_there(&self) -> bool {
        true
    }

    /// Whether anything can be kept there now, as far as that is known without trying.
    fn is_writable(&self) -> bool {
        true
    }

    /// Another process has kept bytes under a name.
    fn learn(&self, _name: &str, _bytes: u64) {}

    /// No process needs what is kept under a name, which may still be there for a while.
    fn forget(&self, _name: &str) {}

    /// The names of all that only this process keeps, in no order; none where others keep bytes, too.
    fn own_names(&self) -> Vec<String> {
        Vec::new()
    }

    /// How long ago a name was written or read, as far as the clock says.
    fn age(&self, _name: &str) -> Duration {
        Duration::ZERO
    }
}

impl Blobs for BlobStore {
    fn get(&self, name: &str) -> io::Result<Option<Blob>> {
        self.get(name)
    }

    fn head(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        self.head(name)
    }

    fn put(&self, name: &str, head: &[u8], body: &[u8]) -> io::Result<()> {
        self.put(name, head, body)
    }

    fn remove(&self, name: &str) {
        self.remove(name);
    }

    fn size(&self, name: &str) -> Option<u64> {
        self.size(name)
    }

    fn bytes(&self) -> u64 {
        self.bytes()
    }

    fn is_there(&self) -> bool {
        self.folder().is_dir()
    }

    fn is_writable(&self) -> bool {
        self.is_writable()
    }

    fn own_names(&self) -> Vec<String> {
        self.names()
    }

    fn age(&self, name: &str) -> Duration {
        self.age(name)
    }
}
