//! A folder of the service: it began empty and has a marker that says so, one process uses it at a time, and what is not the
//! service's own is left alone.

use super::disk::{self, DiskFile};
use super::left_behind;
use crate::service::error::StartError;
use serde::Deserialize;
use std::fs::{self, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The marker, which is the lock as well.
pub(super) const MARKER: &str = "strahl-folder.toml";
/// More than it has.
const MARKER_BYTES: u64 = 4_096;
/// Version of what is in a folder.
const VERSION: u32 = 1;
/// What file systems put into a new one.
const LOST: &str = "lost+found";

/// A folder that is in use.
#[derive(Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    kind: &'static FolderKind,
    marker: DiskFile,
    pub(crate) is_marked: bool,
    /// Removed at the end.
    temporary: Option<TempDir>,
}

/// What a folder is for.
#[derive(Debug)]
pub(crate) struct FolderKind {
    /// The flag that names it.
    pub(crate) flag: &'static str,
    /// What the marker calls it.
    pub(crate) name: &'static str,
    /// Whether the service keeps a file or folder of this path there.
    pub(crate) is_ours: fn(&[&str]) -> bool,
}

/// What a marker says.
#[derive(Debug, Deserialize)]
pub(super) struct Marker {
    kind: String,
    version: u32,
    /// Whether the folder is to be removed at the end.
    #[serde(default)]
    temporary: bool,
}

impl Marker {
    /// What a file says; none if it is no marker, or not all of one.
    pub(super) fn read(file: impl Read) -> Option<Self> {
        let mut text = String::new();
        file.take(MARKER_BYTES).read_to_string(&mut text).ok()?;
        toml::from_str(&text).ok()
    }

    /// Whether it is that of a temporary folder of a kind, as this version makes them.
    pub(super) fn is_temporary(&self, kind: &FolderKind) -> bool {
        self.temporary && self.kind == kind.name && self.version == VERSION
    }
}

impl Folder {
    /// Opens a folder, which is made if it is not there. It is empty, has a marker, or has only files that the service keeps
    /// there: versions before had no markers.
    pub(crate) fn open(path: &Path, kind: &'static FolderKind) -> Result<Self, StartError> {
        Self::open_any(path, kind, None)
    }

    /// Opens a folder that is removed at the end, and removes those that killed processes have left.
    pub(crate) fn temporary(kind: &'static FolderKind) -> Result<Self, StartError> {
        let folder = tempfile::Builder::new().prefix(left_behind::PREFIX).tempdir().map_err(|error| {
            let flag = kind.flag;
            StartError::Settings(format!("there is no folder for temporary files ({error}): name one with {flag} DIR"))
        })?;
        let path = folder.path().to_path_buf();
        let folder = Self::open_any(&path, kind, Some(folder))?;
        left_behind::remove(&path, kind);
        Ok(folder)
    }

    fn open_any(path: &Path, kind: &'static FolderKind, temporary: Option<TempDir>) -> Result<Self, StartError> {
        let place = format!("{} {}", kind.flag, path.display());
        let wrong = |error: io::Error| {
            let advice = format!("The service has to write into this folder: name another with {} DIR.", kind.flag);
            StartError::Machine(format!("{place}: {error}\n\n{advice}"))
        };
        let refused = |why: String, advice: &str| StartError::Settings(format!("{place}: {why}.\n\n{advice}"));
        disk::create_folders(path).map_err(wrong)?;
        let check_strangers = || match stranger(path, &mut Vec::new(), kind.is_ours).map_err(wrong)? {
            None => Ok(()),
            Some(name) => Err(refused(
                format!("the folder is not empty and does not belong to strahl: there is {name}"),
                "Name a new folder or an empty one. The service would remove files that it does not need.",
            )),
        };
        let marker = path.join(MARKER);
        match fs::metadata(&marker) {
            Ok(about) if !about.is_file() => {
                return Err(refused(format!("{MARKER} is no file"), "Name another folder, or remove it."));
            }
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => check_strangers()?,
            Err(error) => return Err(wrong(error)),
        }
        let marker = DiskFile::open(&marker).map_err(wrong)?;
        match marker.reader().try_lock() {
            Err(TryLockError::WouldBlock) => {
                let advice = "Another process uses the folder: each needs one of its own.";
                return Err(StartError::Machine(format!("{place}: {advice}")));
            }
            Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => return Err(wrong(error)),
            _ => {}
        }
        let said = Marker::read(marker.reader());
        let is_marked = match &said {
            Some(Marker { kind: other, .. }) if *other != kind.name => {
                let why = format!("the folder is one of strahl's, but for another purpose ({other})");
                return Err(refused(why, "Name another folder."));
            }
            Some(Marker { version, .. }) if *version > VERSION => {
                let why = format!("a newer version of strahl has written this folder ({version})");
                return Err(refused(why, "Start that version, or name another folder."));
            }
            Some(_) => true,
            // A crash may have left it incomplete.
            None => false,
        };
        if !is_marked {
            check_strangers()?;
        }
        let mut folder = Self { path: path.to_owned(), kind, marker, is_marked, temporary };
        if folder.temporary.is_none() && said.is_some_and(|marker| marker.temporary) {
            // Who names one that was left wants to keep it.
            folder.write_marker()?;
        }
        Ok(folder)
    }

    /// Marks the folder, once all that is in it is as this version writes it.
    pub(crate) fn mark(&mut self) -> Result<(), StartError> {
        if self.is_marked { Ok(()) } else { self.write_marker() }
    }

    fn write_marker(&mut self) -> Result<(), StartError> {
        let temporary = if self.temporary.is_some() { "temporary = true\n" } else { "" };
        let text = format!(
            "# This folder belongs to strahl, which removes files from it.\nkind = \"{}\"\nversion = {VERSION}\n{temporary}",
            self.kind.name
        );
        let marked = self.marker.truncate(0).and_then(|_| self.marker.append(text.as_bytes()));
        marked
            .and_then(|()| self.marker.sync())
            .and_then(|()| disk::sync_parent(&self.path.join(MARKER)))
            .map_err(|error| StartError::Settings(format!("{} {}: {error}", self.kind.flag, self.path.display())))?;
        self.is_marked = true;
        Ok(())
    }
}

/// The path of a file or folder in `at` that the service does not keep there, if there is any.
pub(super) fn stranger(root: &Path, at: &mut Vec<String>, is_ours: fn(&[&str]) -> bool) -> io::Result<Option<String>> {
    let folder = at.iter().fold(root.to_owned(), |path, name| path.join(name));
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        at.push(entry.file_name().to_string_lossy().into_owned());
        let path: Vec<&str> = at.iter().map(String::as_str).collect();
        if !matches!(path[..], [MARKER | LOST]) {
            if !is_ours(&path) {
                return Ok(Some(path.join("/")));
            }
            if fs::metadata(entry.path())?.is_dir()
                && let Some(found) = stranger(root, at, is_ours)?
            {
                return Ok(Some(found));
            }
        }
        at.pop();
    }
    Ok(None)
}

/// Whether two folders are the same, or one is in the other, whatever they are called. They need not be there.
pub(crate) fn overlap(one: &Path, other: &Path) -> bool {
    let (one, other) = (resolved(one), resolved(other));
    one.starts_with(&other) || other.starts_with(&one)
}

/// A path without links, as far as it is there.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(found) = fs::canonicalize(path) {
        return found;
    }
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) if parent != Path::new("") => resolved(parent).join(name),
        _ => std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: FolderKind =
        FolderKind { flag: "--data", name: "data", is_ours: |path| matches!(path, ["kept"] | ["kept", "ours"]) };

    fn refusal(path: &Path) -> String {
        match Folder::open(path, &KIND) {
            Err(StartError::Settings(why) | StartError::Machine(why)) => why,
            Ok(_) => String::new(),
        }
    }

    #[test]
    fn a_folder_is_ours_if_it_began_empty_or_has_only_what_is_ours() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        for (name, files, expected) in [
            ("empty", &[][..], ""),
            ("new disk", &["lost+found/"], ""),
            ("older", &["kept/ours"], ""),
            ("crashed", &["strahl-folder.toml", "kept/ours"], ""),
            ("strange file", &["kept/ours", "cv.txt"], "there is cv.txt"),
            ("strange inside", &["kept/film.blend"], "there is kept/film.blend"),
            ("strange marker", &["strahl-folder.toml", "cv.txt"], "there is cv.txt"),
        ] {
            for file in files {
                let path = at(name).join(file);
                fs::create_dir_all(if file.ends_with('/') { &path } else { path.parent().unwrap() }).unwrap();
                if !file.ends_with('/') {
                    fs::write(path, "").unwrap();
                }
            }
            let said = refusal(&at(name));
            assert_eq!((said.contains(expected), said.is_empty()), (true, expected.is_empty()), "{name}: {said}");
            assert!(files.iter().all(|file| at(name).join(file).exists()), "{name}");
        }
        let marked = || Folder::open(&at("empty"), &KIND).unwrap();
        let mut folder = marked();
        assert!(!folder.is_marked);
        folder.mark().unwrap();
        assert!(refusal(&at("empty")).contains("Another process"), "while it is in use");
        drop(folder);
        fs::write(at("empty/cv.txt"), "").unwrap();
        assert!(marked().is_marked, "what is added later is left alone");
        for (was, is, expected) in [("data", "cache", "another purpose (cache)"), ("= 1", "= 2", "newer version")] {
            let text = fs::read_to_string(at("empty").join(MARKER)).unwrap();
            fs::write(at("empty").join(MARKER), text.replace(was, is)).unwrap();
            assert!(refusal(&at("empty")).contains(expected));
            fs::write(at("empty").join(MARKER), text).unwrap();
        }
    }

    #[test]
    fn a_marker_is_a_file() {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join(MARKER)).unwrap();
        assert!(refusal(root.path()).contains("is no file"));
        #[cfg(unix)]
        {
            // One that can be read without end.
            fs::remove_dir(root.path().join(MARKER)).unwrap();
            std::os::unix::fs::symlink("/dev/zero", root.path().join(MARKER)).unwrap();
            assert!(refusal(root.path()).contains("is no file"));
        }
    }

    #[test]
    fn folders_overlap_whatever_they_are_called() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir(at("a")).unwrap();
        for (other, expected) in
            [("a", true), ("a/b/c", true), (".", true), ("a/../a", true), ("b", false), ("ab", false), ("b/a", false)]
        {
            assert_eq!(overlap(&at("a"), &at(other)), expected, "{other}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
            assert!(overlap(&at("a"), &at("link")) && overlap(&at("link/b"), &at("a")));
        }
    }
}
