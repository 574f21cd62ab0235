//! Temporary folders that killed processes have left. The next process that makes one removes them.
//!
//! Only a folder that is surely one: its marker says so, it belongs to the same user, all that is in it is the service's own,
//! and no process holds its lock.

use super::folder::{FolderKind, MARKER, Marker, stranger};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::Path;

/// What the names of temporary folders begin with.
pub(super) const PREFIX: &str = "strahl-";
/// Most names that are looked at: the folder is everybody's.
const LOOKED_AT: usize = 10_000;

/// Removes what was left beside a temporary folder. What cannot be removed stays.
pub(super) fn remove(own: &Path, kind: &FolderKind) {
    let Some(Ok(all)) = own.parent().map(fs::read_dir) else { return };
    let names = all.take(LOOKED_AT).flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX));
    for path in names.map(|entry| entry.path()).filter(|path| path != own) {
        match remove_one(&path, own, kind) {
            Ok(true) => tracing::info!(folder = %path.display(), "removed what a killed process has left"),
            Ok(false) => {}
            Err(error) => tracing::debug!(folder = %path.display(), %error, "a folder is left alone"),
        }
    }
}

/// Removes a folder if it was left; whether it was.
fn remove_one(path: &Path, own: &Path, kind: &FolderKind) -> io::Result<bool> {
    let (about, own) = (fs::symlink_metadata(path)?, fs::symlink_metadata(own)?);
    let marker = path.join(MARKER);
    if !about.is_dir() || owner(&about) != owner(&own) || !fs::symlink_metadata(&marker)?.is_file() {
        return Ok(false);
    }
    let is_temporary = || {
        let said = File::open(&marker).ok().and_then(Marker::read);
        said.is_some_and(|marker| marker.is_temporary(kind))
    };
    // It is read before it is locked: a process that has just made its folder has no complete marker yet, and needs the lock.
    // It is read once more: somebody may have named the folder, and keeps it.
    let lock = File::open(&marker)?;
    if !is_temporary() || lock.try_lock().is_err() || !is_temporary() {
        return Ok(false);
    }
    if stranger(path, &mut Vec::new(), kind.is_ours)?.is_some() {
        return Ok(false);
    }
    fs::remove_dir_all(path).map(|()| true)
}

/// The user whose it is.
#[cfg(unix)]
fn owner(about: &Metadata) -> u32 {
    std::os::unix::fs::MetadataExt::uid(about)
}

/// Elsewhere each user has a folder for temporary files.
#[cfg(not(unix))]
fn owner(_: &Metadata) -> u32 {
    0
}
