//! Every change of the files that the service keeps. A file is put into its folder completely or not at all, and what is
//! durable outlives a power cut: its bytes are synced before its name, and its name before anybody hears of it.
//!
//! A test listens to these changes and plays them again, each time as far as a crash would have let them come.

use redb::StorageBackend;
use redb::backends::FileBackend;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use uuid::Uuid;

/// Files that are not complete yet have this ending, which no name has.
const UNFINISHED: &str = ".tmp~";

/// Whether a file of this name was not complete yet when a former process ended.
pub(crate) fn is_unfinished(name: &str) -> bool {
    name.strip_suffix(UNFINISHED).is_some_and(|stem| !stem.is_empty() && stem.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Makes a folder, and those that it is to be in, as far as they are not there.
pub(crate) fn create_folders(path: &Path) -> io::Result<()> {
    if let Some(parent) = path.parent()
        && !path.is_dir()
        && !parent.as_os_str().is_empty()
    {
        create_folders(parent)?;
    }
    create_folder(path)
}

/// Makes a folder in one that is there, unless it is there itself.
pub(crate) fn create_folder(path: &Path) -> io::Result<()> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => return Ok(()),
        made => made?,
    }
    note(|| Change::CreateFolder(path.into()));
    sync_parent(path)
}

/// Puts a file into its folder, instead of the one of that name if there is one.
pub(crate) fn write(path: &Path, parts: &[&[u8]], durable: bool) -> io::Result<()> {
    // Another process must not write into the same one: the name is random.
    let unfinished = path.with_file_name(format!("{}{UNFINISHED}", Uuid::now_v7().simple()));
    let written = DiskFile::create(&unfinished).and_then(|mut file| {
        parts.iter().try_for_each(|part| file.append(part))?;
        if durable { file.sync() } else { Ok(()) }
    });
    written.and_then(|()| rename(&unfinished, path)).inspect_err(|_| drop(remove(&unfinished)))?;
    if durable { sync_parent(path) } else { Ok(()) }
}

/// Whether a folder takes files now: one is put there, and removed.
pub(crate) fn takes_files(folder: &Path) -> bool {
    let probe = folder.join(format!("{}{UNFINISHED}", Uuid::now_v7().simple()));
    let written = DiskFile::create(&probe).and_then(|mut file| {
        file.append(&[0; 1 << 16])?;
        file.sync()
    });
    written.and(remove(&probe)).is_ok()
}

/// Gives a file another name in the same folder.
pub(crate) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    note(|| Change::Rename(from.into(), to.into()));
    Ok(())
}

/// Removes a file; it may be there again after a power cut.
pub(crate) fn remove(path: &Path) -> io::Result<()> {
    fs::remove_file(path)?;
    note(|| Change::Remove(path.into()));
    Ok(())
}

/// How long ago a file was written, as far as the clock says; nothing for one that is not there.
pub(crate) fn age(path: &Path) -> Duration {
    let modified = fs::metadata(path).and_then(|about| about.modified()).ok();
    modified.and_then(|modified| modified.elapsed().ok()).unwrap_or_default()
}

/// The names in the folder of a file outlive a power cut from now on.
pub(crate) fn sync_parent(path: &Path) -> io::Result<()> {
    let Some(folder) = path.parent() else { return Ok(()) };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Elsewhere folders cannot be opened; there, and where they cannot be synced, names are as durable as the system says.
    let synced = if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) };
    synced.or_else(|error| match error.kind() {
        io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
        _ => Err(error),
    })?;
    note(|| Change::SyncFolder(folder.into()));
    Ok(())
}

/// A file that grows at its end.
#[derive(Debug)]
pub(crate) struct DiskFile {
    file: File,
    path: PathBuf,
    length: u64,
}

impl DiskFile {
    fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).create_new(true).open(path)?;
        note(|| Change::Create(path.into()));
        Ok(Self { file, path: path.into(), length: 0 })
    }

    /// Opens a file, or makes it; what is in it stays.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
        note(|| Change::Create(path.into()));
        let length = file.metadata()?.len();
        Ok(Self { file, path: path.into(), length })
    }

    /// Writes at the end, all or nothing.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        room(&self.path)?;
        if let Err(error) = self.file.write_all(bytes) {
            // The disk may be full in the middle of them.
            self.truncate(self.length)?;
            return Err(error);
        }
        note(|| Change::Write(self.path.clone(), self.length, bytes.into()));
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Cuts off what comes after so many bytes; how many those were.
    pub(crate) fn truncate(&mut self, length: u64) -> io::Result<u64> {
        self.file.set_len(length)?;
        note(|| Change::SetLength(self.path.clone(), length));
        Ok(std::mem::replace(&mut self.length, length) - length)
    }

    /// What was written outlives a power cut from now on.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.file.sync_all()?;
        note(|| Change::Sync(self.path.clone()));
        Ok(())
    }

    /// To read what is there.
    pub(crate) fn reader(&self) -> &File {
        &self.file
    }
}

/// The file of a database.
#[derive(Debug)]
pub(crate) struct DatabaseFile {
    file: FileBackend,
    path: PathBuf,
}

impl DatabaseFile {
    /// Opens it, or makes it. One process has it at a time.
    pub(crate) fn open(path: &Path) -> Result<Self, redb::DatabaseError> {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        note(|| Change::Create(path.into()));
        Ok(Self { file: FileBackend::new(file)?, path: path.into() })
    }
}

impl DatabaseFile {
    /// Opens it again, after it could not be written. One that is not there any more is not made: its volume is away, and what
    /// would be written meanwhile would be lost.
    pub(crate) fn reopen(path: &Path) -> Result<Self, redb::DatabaseError> {
        if fs::metadata(path)?.len() == 0 {
            return Err(io::Error::from(io::ErrorKind::NotFound).into());
        }
        Self::open(path)
    }
}

impl StorageBackend for DatabaseFile {
    fn len(&self) -> io::Result<u64> {
        self.file.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.file.read(offset, out)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        room(&self.path)?;
        self.file.set_len(length)?;
        note(|| Change::SetLength(self.path.clone(), length));
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        self.file.sync_data()?;
        note(|| Change::Sync(self.path.clone()));
        Ok(())
    }

    fn write(&self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        room(&self.path)?;
        self.file.write(offset, bytes)?;
        note(|| Change::Write(self.path.clone(), offset, bytes.into()));
        Ok(())
    }

    fn close(&self) -> io::Result<()> {
        self.file.close()
    }
}

/// What has changed.
#[derive(Debug, Clone)]
#[cfg_attr(not(test), expect(dead_code, reason = "only a test listens"))]
pub(crate) enum Change {
    CreateFolder(PathBuf),
    /// It may have been there.
    Create(PathBuf),
    Write(PathBuf, u64, Vec<u8>),
    SetLength(PathBuf, u64),
    Sync(PathBuf),
    Rename(PathBuf, PathBuf),
    Remove(PathBuf),
    SyncFolder(PathBuf),
}

#[cfg(test)]
fn note(change: impl FnOnce() -> Change) {
    super::test_journal::note(change());
}

#[cfg(not(test))]
fn note(_: impl FnOnce() -> Change) {}

/// Whether a test lets the disk take nothing.
#[cfg(test)]
fn room(path: &Path) -> io::Result<()> {
    super::test_journal::room(path)
}

#[cfg(not(test))]
fn room(_: &Path) -> io::Result<()> {
    Ok(())
}
