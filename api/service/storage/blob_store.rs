//! Bytes by name in a folder: written completely or not at all, checked when read, within a number of bytes.
//!
//! Names are those of what the bytes are made from, so a name never gets other bytes, and nothing has to be invalidated.
//! Each file begins with the SHA-256 of the rest: what a failing disk or a power cut has spoilt is as good as not there.

use super::lru_cache::LruCache;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

/// Bytes of the digest before the contents.
const DIGEST: usize = 32;
/// Files that are not complete yet have this ending, which no name has.
const UNFINISHED: &str = "tmp~";

/// The folder. One process has it at a time.
#[derive(Debug)]
pub(crate) struct BlobStore {
    folder: PathBuf,
    index: LruCache<String, ()>,
    unfinished: AtomicU64,
}

impl BlobStore {
    /// Opens a folder, or makes it. What is there counts as asked for when it was last written or read; if it is more
    /// than the budget, the oldest goes. A budget of `u64::MAX` keeps everything.
    pub(crate) fn open(folder: &Path, budget: u64) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let mut found = Vec::new();
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let about = entry.metadata()?;
            if name.ends_with(UNFINISHED) {
                // A former process was stopped while it wrote this.
                let _ = fs::remove_file(entry.path());
            } else if about.is_file() && is_name(&name) {
                found.push((about.modified().unwrap_or(SystemTime::UNIX_EPOCH), name, about.len()));
            }
        }
        found.sort();
        let blobs = Self { folder: folder.to_owned(), index: LruCache::new(budget), unfinished: AtomicU64::new(0) };
        for (_, name, bytes) in found {
            if bytes > budget {
                blobs.delete(&name);
            }
            blobs.index.put(name, (), bytes).iter().for_each(|gone| blobs.delete(gone));
        }
        Ok(blobs)
    }

    /// The bytes of a name, if they are there and whole.
    pub(crate) fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.index.get(name)?;
        let contents = self.read(name);
        if contents.is_none() {
            tracing::warn!(name, "a kept file is damaged or gone");
            self.remove(name);
        }
        contents
    }

    fn read(&self, name: &str) -> Option<Vec<u8>> {
        let mut file = File::open(self.folder.join(name)).ok()?;
        let mut digest = [0; DIGEST];
        file.read_exact(&mut digest).ok()?;
        let mut contents = Vec::new();
        file.read_to_end(&mut contents).ok()?;
        // So that the order survives a restart; without it only that is lost.
        let _ = file.set_modified(SystemTime::now());
        (Sha256::digest(&contents)[..] == digest).then_some(contents)
    }

    /// Keeps bytes under a name of letters, digits and `_.,-` that begins with a letter or digit. Whoever reads it sees
    /// all of it or nothing, also after the process was killed.
    pub(crate) fn put(&self, name: &str, contents: &[u8]) -> io::Result<()> {
        if !is_name(name) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no name for a kept file"));
        }
        let number = self.unfinished.fetch_add(1, Ordering::Relaxed);
        let unfinished = self.folder.join(format!("{number}.{UNFINISHED}"));
        let written = File::create(&unfinished).and_then(|mut file| {
            file.write_all(&Sha256::digest(contents))?;
            file.write_all(contents)
        });
        written.and_then(|()| fs::rename(&unfinished, self.folder.join(name))).inspect_err(|_| {
            let _ = fs::remove_file(&unfinished);
        })?;
        let bytes = (DIGEST + contents.len()) as u64;
        self.index.put(name.to_owned(), (), bytes).iter().for_each(|gone| self.delete(gone));
        Ok(())
    }

    /// Forgets a name; whether it was there.
    pub(crate) fn remove(&self, name: &str) -> bool {
        let known = self.index.remove(name);
        if known {
            self.delete(name);
        }
        known
    }

    /// Whether a name is there; looking counts as asking for it.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.index.get(name).is_some()
    }

    /// All names, in no order.
    pub(crate) fn names(&self) -> Vec<String> {
        self.index.keys()
    }

    /// Bytes of all files.
    pub(crate) fn bytes(&self) -> u64 {
        self.index.bytes()
    }

    fn delete(&self, name: &str) {
        if let Err(error) = fs::remove_file(self.folder.join(name))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(name, %error, "a file cannot be removed");
        }
    }
}

/// Nothing that could lead out of the folder.
fn is_name(name: &str) -> bool {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"_.,-".contains(&byte);
    name.len() <= 200 && name.as_bytes().first().is_some_and(u8::is_ascii_alphanumeric) && name.bytes().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("strahl-blobs-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn what_was_put_is_there_after_a_restart_and_what_is_spoilt_is_not() {
        let folder = folder("restart");
        let blobs = BlobStore::open(&folder, 1_000).unwrap();
        blobs.put("i_a.png", b"picture").unwrap();
        blobs.put("i_b.png", b"other").unwrap();
        fs::write(folder.join(format!("7.{UNFINISHED}")), b"half").unwrap();
        drop(blobs);
        let spoilt = fs::read(folder.join("i_b.png")).unwrap();
        fs::write(folder.join("i_b.png"), &spoilt[..spoilt.len() - 1]).unwrap();

        let blobs = BlobStore::open(&folder, 1_000).unwrap();
        assert_eq!(blobs.get("i_a.png").as_deref(), Some(&b"picture"[..]));
        assert_eq!(blobs.get("i_b.png"), None);
        assert_eq!((blobs.names(), blobs.bytes()), (vec!["i_a.png".to_owned()], 39));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing else is left");
        assert!(blobs.remove("i_a.png") && blobs.get("i_a.png").is_none());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn the_oldest_goes_when_there_is_no_room() {
        let folder = folder("room");
        let blobs = BlobStore::open(&folder, 2 * 40).unwrap();
        for name in ["a", "b"] {
            blobs.put(name, &[0; 8]).unwrap();
        }
        assert!(blobs.get("a").is_some());
        blobs.put("c", &[0; 8]).unwrap();
        assert_eq!(["a", "b", "c"].map(|name| blobs.get(name).is_some()), [true, false, true]);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let folder = folder("names");
        let blobs = BlobStore::open(&folder, 1_000).unwrap();
        for name in ["", "..", "../a", "a/b", ".a", "a\0", "ä", &"a".repeat(300)] {
            assert!(blobs.put(name, b"").is_err(), "{name}");
        }
        fs::remove_dir_all(folder).unwrap();
    }
}
