//! Bytes by name in a folder: written completely or not at all, checked when read, within a number of bytes.
//!
//! Names are those of what the bytes are made from, so a name never gets other bytes, and nothing has to be invalidated.
//! A file is a head, which can be read alone, and a body. It begins with digests (SHA-256) over its name and all of that: what
//! a failing disk, a power cut or another program has spoilt is as good as not there, and is never given out.

use super::disk;
use super::lru_cache::LruCache;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Bytes of a digest.
const DIGEST: usize = 32;
/// Bytes before the head: digest of name and head, digest of the body, length of the head.
const PREFIX: usize = 2 * DIGEST + 8;

/// Bytes by which a head may be longer than another of the same bytes.
const GROWTH: u64 = 1 << 20;

/// The folder. One process has it at a time.
#[derive(Debug)]
pub(crate) struct BlobStore {
    folder: PathBuf,
    kind: BlobKind,
    budget: u64,
    /// Bytes of each file.
    index: LruCache<String, u64>,
}

/// What a folder keeps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlobKind {
    /// Whether a name is one of those that are kept there. Other files in the folder are left alone.
    pub(crate) is_name: fn(&str) -> bool,
    /// Whether what was put there outlives a power cut.
    pub(crate) durable: bool,
}

/// What is kept by a name.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Blob {
    /// What can be read alone.
    pub(crate) head: Vec<u8>,
    /// The rest.
    pub(crate) body: Vec<u8>,
    /// SHA-256 of the rest.
    pub(crate) digest: [u8; DIGEST],
}

impl BlobStore {
    /// Opens a folder, or makes it. What is there counts as asked for when it was last written or read; if it is more
    /// than the budget, the oldest goes. A budget of `u64::MAX` keeps everything.
    pub(crate) fn open(folder: &Path, budget: u64, kind: BlobKind) -> io::Result<Self> {
        disk::create_folder(folder)?;
        let mut found = Vec::new();
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let about = entry.metadata()?;
            if disk::is_unfinished(&name) {
                // A former process was stopped while it wrote this.
                let _ = disk::remove(&entry.path());
            } else if about.is_file() && (kind.is_name)(&name) {
                found.push((about.modified().unwrap_or(SystemTime::UNIX_EPOCH), name, about.len()));
            }
        }
        found.sort();
        let blobs = Self { folder: folder.to_owned(), kind, budget, index: LruCache::new(budget) };
        for (_, name, bytes) in found {
            if bytes > budget {
                blobs.delete(&name);
            }
            blobs.index.put(name, bytes, bytes).iter().for_each(|gone| blobs.delete(gone));
        }
        Ok(blobs)
    }

    /// What is kept by a name, if it is there and whole. It fails if that cannot be known now.
    pub(crate) fn get(&self, name: &str) -> io::Result<Option<Blob>> {
        self.read_with(name, |file, prefix, head| {
            let mut body = Vec::new();
            file.read_to_end(&mut body)?;
            let digest = prefix.body;
            Ok((Sha256::digest(&body)[..] == digest).then_some(Blob { head, body, digest }))
        })
    }

    /// The head alone.
    pub(crate) fn head(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        self.read_with(name, |_, _, head| Ok(Some(head)))
    }

    fn read_with<T>(
        &self,
        name: &str,
        read: impl FnOnce(&mut File, Prefix, Vec<u8>) -> io::Result<Option<T>>,
    ) -> io::Result<Option<T>> {
        let Some(written) = self.index.get(name) else { return Ok(None) };
        let found = File::open(self.folder.join(name)).and_then(|mut file| {
            if self.budget < u64::MAX {
                // So that the order survives a restart; without it only that is lost.
                let _ = file.set_modified(SystemTime::now());
            }
            let length = file.metadata()?.len();
            // Another program has let it grow. Heads of the same bytes may be longer.
            if length / 2 > written + GROWTH {
                return Ok(None);
            }
            let Some((prefix, head)) = Prefix::read(&mut file, length, name)? else { return Ok(None) };
            read(&mut file, prefix, head)
        });
        match found {
            Ok(Some(found)) => return Ok(Some(found)),
            Err(error) if !self.is_gone(&error) => {
                // It may be whole, and be read another time.
                tracing::warn!(name, %error, "a kept file cannot be read");
                return Err(error);
            }
            _ => {}
        }
        tracing::warn!(name, "a kept file is damaged or gone");
        self.remove(name);
        Ok(None)
    }

    /// Whether a file that cannot be read is not there, or not all of it. If the whole folder is not there, it may come back.
    fn is_gone(&self, error: &io::Error) -> bool {
        match error.kind() {
            io::ErrorKind::NotFound => self.folder.is_dir(),
            kind => kind == io::ErrorKind::UnexpectedEof,
        }
    }

    /// Whether anything can be put there now.
    pub(crate) fn is_writable(&self) -> bool {
        disk::takes_files(&self.folder)
    }

    /// Where they are.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Keeps bytes under a name, unless they are more than all there may be. Whoever reads it sees all of it or nothing, also after the process was killed.
    pub(crate) fn put(&self, name: &str, head: &[u8], body: &[u8]) -> io::Result<()> {
        if !(self.kind.is_name)(name) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no name for a kept file"));
        }
        let bytes = (PREFIX + head.len() + body.len()) as u64;
        if bytes > self.budget {
            return Ok(());
        }
        let prefix = Prefix { body: Sha256::digest(body).into(), head: head.len() as u64 };
        disk::write(&self.folder.join(name), &[&prefix.bytes(name, head), head, body], self.kind.durable)?;
        self.index.put(name.to_owned(), bytes, bytes).iter().for_each(|gone| self.delete(gone));
        Ok(())
    }

    /// Gives files of versions that wrote a digest of the contents and the contents the digests of today, if the contents are
    /// those of their name. Others that are not whole go.
    pub(crate) fn upgrade(&self, is_named: impl Fn(&str, &[u8]) -> bool) -> io::Result<()> {
        for name in self.names() {
            let bytes = fs::read(self.folder.join(&name))?;
            match bytes.split_at_checked(DIGEST) {
                Some((digest, contents)) if Sha256::digest(contents)[..] == *digest && is_named(&name, contents) => {
                    self.put(&name, b"", contents)?;
                }
                _ => drop(self.get(&name)?),
            }
        }
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

    /// Bytes of the file of a name, if it is there; looking counts as asking for it.
    pub(crate) fn size(&self, name: &str) -> Option<u64> {
        self.index.get(name)
    }

    /// How long ago the file of a name was written or read, as far as the clock says.
    pub(crate) fn age(&self, name: &str) -> Duration {
        disk::age(&self.folder.join(name))
    }

    /// Whether a name is there; looking counts as asking for it.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.size(name).is_some()
    }

    /// Whether a name is there; looking does not count.
    pub(crate) fn holds(&self, name: &str) -> bool {
        self.index.holds(name)
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
        if let Err(error) = disk::remove(&self.folder.join(name))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(name, %error, "a file cannot be removed");
        }
    }
}

/// What a file begins with.
pub(super) struct Prefix {
    /// Digest of the body.
    pub(super) body: [u8; DIGEST],
    /// Bytes of the head.
    pub(super) head: u64,
}

impl Prefix {
    /// As it stands in the file, after a digest of all but the body.
    pub(super) fn bytes(&self, name: &str, head: &[u8]) -> Vec<u8> {
        let rest = [&self.body[..], &self.head.to_le_bytes()].concat();
        // No name has a byte of 0.
        let digest =
            Sha256::new().chain_update(name).chain_update([0]).chain_update(&rest).chain_update(head).finalize();
        [&digest[..], &rest].concat()
    }

    /// Reads it and the head from a file of some length, if they are whole and were written under this name.
    pub(super) fn read(file: &mut impl Read, length: u64, name: &str) -> io::Result<Option<(Self, Vec<u8>)>> {
        let mut bytes = [0; PREFIX];
        file.read_exact(&mut bytes)?;
        let (mut prefix, mut head_length) = (Self { body: [0; DIGEST], head: 0 }, [0; 8]);
        prefix.body.copy_from_slice(&bytes[DIGEST..2 * DIGEST]);
        head_length.copy_from_slice(&bytes[2 * DIGEST..]);
        prefix.head = u64::from_le_bytes(head_length);
        // A spoilt length asks for no memory.
        if prefix.head > length.saturating_sub(PREFIX as u64) {
            return Ok(None);
        }
        let mut head = vec![0; prefix.head as usize];
        file.read_exact(&mut head)?;
        Ok((prefix.bytes(name, &head) == bytes).then_some((prefix, head)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: BlobKind =
        BlobKind { is_name: |name| name.bytes().all(|b| b.is_ascii_lowercase() || b == b'.'), durable: true };

    fn open(folder: &Path, budget: u64) -> BlobStore {
        BlobStore::open(folder, budget, KIND).unwrap()
    }

    /// What is there under a name.
    fn body(blobs: &BlobStore, name: &str) -> Option<Vec<u8>> {
        blobs.get(name).unwrap().map(|blob| blob.body)
    }

    #[test]
    fn what_was_put_is_there_after_a_restart_and_what_was_half_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = open(folder.path(), 1_000);
        blobs.put("a.png", b"about", b"picture").unwrap();
        fs::write(folder.path().join("0f7.tmp~"), b"half").unwrap();
        fs::write(folder.path().join("STRANGER"), b"not ours").unwrap();
        drop(blobs);

        let blobs = open(folder.path(), 1_000);
        let blob = blobs.get("a.png").unwrap().unwrap();
        assert_eq!((&blob.head[..], &blob.body[..]), (&b"about"[..], &b"picture"[..]));
        assert_eq!(
            (&blob.digest[..], blobs.head("a.png").unwrap()),
            (&Sha256::digest(b"picture")[..], Some(b"about".to_vec()))
        );
        assert_eq!((blobs.names(), blobs.bytes()), (vec!["a.png".to_owned()], PREFIX as u64 + 12));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "only what was half-written is gone");
        assert!(blobs.remove("a.png") && blobs.get("a.png").unwrap().is_none());
    }

    #[test]
    fn every_flipped_bit_every_end_that_is_missing_and_every_other_name_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = open(folder.path(), 1_000);
        let path = folder.path().join("a");
        blobs.put("a", b"head", b"body").unwrap();
        let whole = fs::read(&path).unwrap();
        let flipped = (0..whole.len() * 8).map(|bit| {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        });
        let cut = (0..whole.len()).map(|length| whole[..length].to_vec());
        for spoilt in flipped.chain(cut).chain([[&whole[..], b"more"].concat()]) {
            fs::write(&path, spoilt).unwrap();
            assert_eq!(blobs.get("a").unwrap(), None);
            assert!(!path.exists() && !blobs.has("a"), "it is as good as not there");
            blobs.put("a", b"head", b"body").unwrap();
        }
        blobs.put("b", b"head", b"other").unwrap();
        fs::rename(folder.path().join("b"), &path).unwrap();
        assert_eq!(blobs.head("a").unwrap(), None, "whole, but of another name");
    }

    #[test]
    fn a_file_that_another_program_let_grow_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = open(folder.path(), u64::MAX);
        blobs.put("a", b"head", b"body").unwrap();
        let path = folder.path().join("a");
        // 8 GiB that take no room.
        File::options().write(true).open(&path).unwrap().set_len(8 << 30).unwrap();
        assert!(blobs.get("a").unwrap().is_none() && !path.exists());
    }

    #[test]
    fn the_oldest_goes_when_there_is_no_room() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = open(folder.path(), 2 * (PREFIX as u64 + 8));
        for name in ["a", "b"] {
            blobs.put(name, b"", &[0; 8]).unwrap();
        }
        assert!(blobs.get("a").unwrap().is_some());
        blobs.put("c", b"", &[0; 8]).unwrap();
        blobs.put("large", b"", &[0; 300]).unwrap();
        assert_eq!(["a", "b", "c"].map(|name| body(&blobs, name).is_some()), [true, false, true]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn nothing_is_kept_under_a_name_of_another_pattern() {
        let folder = tempfile::tempdir().unwrap();
        assert!(open(folder.path(), 1_000).put("A", b"", b"").is_err());
    }

    /// As an unmounted volume does.
    #[test]
    fn a_folder_that_comes_back_has_what_was_in_it() {
        let root = tempfile::tempdir().unwrap();
        let [path, away] = ["here", "away"].map(|name| root.path().join(name));
        let blobs = open(&path, u64::MAX);
        blobs.put("a", b"", b"kept").unwrap();
        assert!(blobs.is_writable());
        fs::rename(&path, &away).unwrap();
        assert!(blobs.get("a").is_err() && blobs.head("a").is_err() && !blobs.is_writable());
        assert!(blobs.put("b", b"", b"new").is_err());
        fs::rename(&away, &path).unwrap();
        assert_eq!(body(&blobs, "a").as_deref(), Some(&b"kept"[..]));
        assert!(blobs.is_writable() && fs::read_dir(&path).unwrap().count() == 1);
        fs::remove_file(path.join("a")).unwrap();
        assert_eq!(blobs.get("a").unwrap(), None);
    }
}
