//! Bytes by name in the store of a farm, which other fronts and nodes read, too. They lie there as they are, so that everybody
//! can read them; a head has a blob of its own beside them, with the digests of both.

use super::blob_store::{Blob, Prefix};
use super::blobs::Blobs;
use super::objects::{ObjectError, Objects};
use crate::service::error::not_reachable;
use parking_lot::Mutex;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::io;
use tokio::runtime::Handle;

/// What the name of a head ends with, after that of the bytes.
const ABOUT: &str = ".about";
/// Most bytes of a head.
const HEAD_BYTES: u64 = 16 << 20;

/// A folder of the store.
#[derive(Debug)]
pub(crate) struct SharedBlobs {
    objects: Objects,
    runtime: Handle,
    folder: &'static str,
    /// Whether names are the SHA-256 of their bytes, so that nothing has to be kept beside them.
    named_by_digest: bool,
    /// Bytes of what is known to be there.
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    sizes: HashMap<String, u64>,
    bytes: u64,
}

impl SharedBlobs {
    /// A folder of a store.
    pub(crate) fn new(objects: Objects, runtime: Handle, folder: &'static str, named_by_digest: bool) -> Self {
        Self { objects, runtime, folder, named_by_digest, known: Mutex::default() }
    }

    fn path(&self, name: &str) -> String {
        format!("{}/{name}", self.folder)
    }

    fn read(&self, path: &str, most: u64) -> io::Result<Option<Vec<u8>>> {
        self.runtime.block_on(self.objects.get(path, most)).or_else(|error| {
            tracing::warn!(path, %error, "a blob cannot be read");
            if matches!(error, ObjectError::Store(_)) { Err(not_reachable(error)) } else { Ok(None) }
        })
    }

    fn about(&self, name: &str) -> io::Result<Option<(Prefix, Vec<u8>)>> {
        let Some(bytes) = self.read(&self.path(&format!("{name}{ABOUT}")), HEAD_BYTES)? else { return Ok(None) };
        let about = Prefix::read(&mut bytes.as_slice(), bytes.len() as u64, name).ok().flatten();
        if about.is_none() {
            tracing::warn!(name, "a blob is damaged");
        }
        Ok(about)
    }
}

impl Blobs for SharedBlobs {
    fn get(&self, name: &str) -> io::Result<Option<Blob>> {
        let about = if self.named_by_digest { None } else { self.about(name)? };
        if about.is_none() && !self.named_by_digest {
            return Ok(None);
        }
        let Some(body) = self.read(&self.path(name), u64::MAX)? else { return Ok(None) };
        let Some((prefix, head)) = about else {
            let digest = Sha256::digest(&body).into();
            return Ok(Some(Blob { head: Vec::new(), body, digest }));
        };
        let digest = prefix.body;
        let is_whole = Sha256::digest(&body)[..] == digest;
        if !is_whole {
            tracing::warn!(name, "a blob is damaged");
        }
        Ok(is_whole.then_some(Blob { head, body, digest }))
    }

    fn head(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        Ok(self.about(name)?.map(|(_, head)| head))
    }

    /// Who finds the head finds the bytes.
    fn put(&self, name: &str, head: &[u8], body: &[u8]) -> io::Result<()> {
        let put = |path: String, bytes: Vec<u8>| self.runtime.block_on(self.objects.put(&path, bytes));
        let put_both = || -> Result<(), ObjectError> {
            put(self.path(name), body.to_vec())?;
            if !self.named_by_digest {
                let prefix = Prefix { body: Sha256::digest(body).into(), head: head.len() as u64 };
                put(self.path(&format!("{name}{ABOUT}")), [&prefix.bytes(name, head), head].concat())?;
            }
            Ok(())
        };
        put_both().map_err(not_reachable)?;
        self.learn(name, body.len() as u64);
        Ok(())
    }

    fn remove(&self, name: &str) {
        {
            let mut known = self.known.lock();
            let bytes = known.sizes.remove(name).unwrap_or(0);
            known.bytes -= bytes;
        }
        let about = (!self.named_by_digest).then(|| format!("{name}{ABOUT}"));
        for name in about.into_iter().chain([name.to_owned()]) {
            if let Err(error) = self.runtime.block_on(self.objects.delete(&self.path(&name))) {
                tracing::warn!(name, %error, "a blob cannot be removed");
            }
        }
    }

    fn size(&self, name: &str) -> Option<u64> {
        self.known.lock().sizes.get(name).copied()
    }

    fn bytes(&self) -> u64 {
        self.known.lock().bytes
    }

    fn learn(&self, name: &str, bytes: u64) {
        let mut known = self.known.lock();
        let before = known.sizes.insert(name.to_owned(), bytes).unwrap_or(0);
        known.bytes = known.bytes - before + bytes;
    }

    fn forget(&self, name: &str) {
        let mut known = self.known.lock();
        let bytes = known.sizes.remove(name).unwrap_or(0);
        known.bytes -= bytes;
    }
}
