//! What changes in a folder, written down for a test, and what a crash leaves of it: a kill leaves everything, a power cut what
//! was synced and any part of the rest.

use super::disk::Change;
use parking_lot::Mutex;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

/// Changes by the folder that somebody listens to.
static JOURNALS: Mutex<Vec<(PathBuf, Vec<Change>)>> = Mutex::new(Vec::new());

/// Listens to the changes of a folder and of all in it.
pub(crate) fn listen(folder: &Path) {
    JOURNALS.lock().push((folder.to_owned(), Vec::new()));
}

/// How many changes there have been in a folder.
pub(crate) fn length(folder: &Path) -> usize {
    JOURNALS.lock().iter().find(|(of, _)| of == folder).map_or(0, |(_, changes)| changes.len())
}

/// The changes of a folder, which nobody listens to any more.
pub(crate) fn take(folder: &Path) -> Vec<Change> {
    let mut journals = JOURNALS.lock();
    let at = journals.iter().position(|(of, _)| of == folder).expect("somebody listens");
    journals.swap_remove(at).1
}

/// Something has changed.
pub(super) fn note(change: Change) {
    let mut journals = JOURNALS.lock();
    if let Some((_, changes)) = journals.iter_mut().find(|(of, _)| change.path().starts_with(of)) {
        changes.push(change);
    }
}

/// Folders whose disk takes nothing, and what it says.
static FAULTS: Mutex<Vec<(PathBuf, io::ErrorKind)>> = Mutex::new(Vec::new());

/// Lets the disk of a folder take nothing, or all again.
pub(crate) fn set_fault(folder: &Path, fault: Option<io::ErrorKind>) {
    let mut faults = FAULTS.lock();
    faults.retain(|(of, _)| of != folder);
    faults.extend(fault.map(|fault| (folder.to_owned(), fault)));
}

/// An error if the disk of a file takes nothing.
pub(super) fn room(path: &Path) -> io::Result<()> {
    let faults = FAULTS.lock();
    let fault = faults.iter().find(|(of, _)| path.starts_with(of)).map(|(_, fault)| *fault);
    fault.map_or(Ok(()), |fault| Err(fault.into()))
}

impl Change {
    fn path(&self) -> &Path {
        match self {
            Self::CreateFolder(path)
            | Self::Create(path)
            | Self::Write(path, ..)
            | Self::SetLength(path, _)
            | Self::Sync(path)
            | Self::Rename(path, _)
            | Self::Remove(path)
            | Self::SyncFolder(path) => path,
        }
    }
}

/// What a crash loses of that which was not synced.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Loss {
    /// Nothing: the process was killed.
    Nothing,
    /// All of it.
    Everything,
    /// What was written into files; their names are there.
    Contents,
    /// Names; what was written is there.
    Names,
    /// Half of the last write into each file.
    Torn,
    /// Some of it, by a number.
    Some(u64),
}

impl Loss {
    /// Whether something is still there.
    fn keeps(&mut self, is_name: bool) -> bool {
        match self {
            Self::Nothing | Self::Torn => true,
            Self::Everything => false,
            Self::Contents => is_name,
            Self::Names => !is_name,
            Self::Some(seed) => {
                *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                *seed >> 63 == 0
            }
        }
    }
}

/// Files by path, and folders, which have no contents.
pub(crate) type Tree = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// What is in a folder after a crash.
pub(crate) fn after_crash(folder: &Path, changes: &[Change], mut loss: Loss) -> Tree {
    let mut disk = Disk::default();
    changes.iter().for_each(|change| disk.apply(change));
    let files: Vec<Vec<u8>> = disk.files.iter().map(|file| file.after(&mut loss)).collect();
    let mut tree = Tree::from([(PathBuf::new(), None)]);
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        let Some(names) = disk.folders.get(&at) else { continue };
        for (name, entry) in names.after(&mut loss) {
            let path = at.join(name);
            let inside = path.strip_prefix(folder).unwrap().to_owned();
            match entry {
                Entry::File(number) => drop(tree.insert(inside, Some(files[number].clone()))),
                Entry::Folder => {
                    tree.insert(inside, None);
                    open.push(path);
                }
            }
        }
    }
    tree
}

#[derive(Debug, Default)]
struct Disk {
    files: Vec<Layers<Vec<u8>, FileOp>>,
    folders: BTreeMap<PathBuf, Layers<BTreeMap<OsString, Entry>, NameOp>>,
    /// Which file each path is at this moment.
    now: BTreeMap<PathBuf, usize>,
}

/// What is synced, and what was done since.
#[derive(Debug)]
struct Layers<T, Op> {
    synced: T,
    pending: Vec<Op>,
}

impl<T: Default, Op> Default for Layers<T, Op> {
    fn default() -> Self {
        Self { synced: T::default(), pending: Vec::new() }
    }
}

#[derive(Debug, Clone)]
enum FileOp {
    Write(u64, Vec<u8>),
    SetLength(u64),
}

#[derive(Debug, Clone, Copy)]
enum Entry {
    File(usize),
    Folder,
}

#[derive(Debug, Clone)]
enum NameOp {
    Link(OsString, Entry),
    Unlink(OsString),
    Move(OsString, OsString, usize),
}

impl Disk {
    fn apply(&mut self, change: &Change) {
        let name = |path: &Path| path.file_name().unwrap().to_owned();
        match change {
            Change::CreateFolder(path) => self.names(path).push(NameOp::Link(name(path), Entry::Folder)),
            Change::Create(path) if self.now.contains_key(path) => {}
            Change::Create(path) => {
                let number = self.files.len();
                self.files.push(Layers::default());
                self.now.insert(path.clone(), number);
                self.names(path).push(NameOp::Link(name(path), Entry::File(number)));
            }
            Change::Write(path, at, bytes) => self.contents(path).push(FileOp::Write(*at, bytes.clone())),
            Change::SetLength(path, length) => self.contents(path).push(FileOp::SetLength(*length)),
            Change::Sync(path) => {
                let number = self.now[path];
                let Layers { synced, pending } = &mut self.files[number];
                pending.drain(..).for_each(|op| op.apply(synced));
            }
            Change::Rename(from, to) => {
                let number = self.now.remove(from).unwrap();
                self.now.insert(to.clone(), number);
                self.names(to).push(NameOp::Move(name(from), name(to), number));
            }
            Change::Remove(path) => {
                self.now.remove(path);
                self.names(path).push(NameOp::Unlink(name(path)));
            }
            Change::SyncFolder(path) => {
                let Layers { synced, pending } = self.folders.entry(path.clone()).or_default();
                pending.drain(..).for_each(|op| op.apply(synced));
            }
        }
    }

    fn names(&mut self, path: &Path) -> &mut Vec<NameOp> {
        &mut self.folders.entry(path.parent().unwrap().to_owned()).or_default().pending
    }

    fn contents(&mut self, path: &Path) -> &mut Vec<FileOp> {
        &mut self.files[self.now[path]].pending
    }
}

impl Layers<Vec<u8>, FileOp> {
    fn after(&self, loss: &mut Loss) -> Vec<u8> {
        let mut contents = self.synced.clone();
        let mut kept: Vec<FileOp> = self.pending.iter().filter(|_| loss.keeps(false)).cloned().collect();
        if let (Loss::Torn, Some(FileOp::Write(_, bytes))) = (loss, kept.last_mut()) {
            bytes.truncate(bytes.len() / 2);
        }
        kept.into_iter().for_each(|op| op.apply(&mut contents));
        contents
    }
}

impl Layers<BTreeMap<OsString, Entry>, NameOp> {
    fn after(&self, loss: &mut Loss) -> BTreeMap<OsString, Entry> {
        let mut names = self.synced.clone();
        self.pending.iter().filter(|_| loss.keeps(true)).cloned().for_each(|op| op.apply(&mut names));
        names
    }
}

impl FileOp {
    fn apply(self, to: &mut Vec<u8>) {
        match self {
            Self::Write(at, bytes) => {
                let end = at as usize + bytes.len();
                to.resize(to.len().max(end), 0);
                to[at as usize..end].copy_from_slice(&bytes);
            }
            Self::SetLength(length) => to.resize(length as usize, 0),
        }
    }
}

impl NameOp {
    fn apply(self, to: &mut BTreeMap<OsString, Entry>) {
        match self {
            Self::Link(name, entry) => drop(to.insert(name, entry)),
            Self::Unlink(name) => drop(to.remove(&name)),
            Self::Move(from, name, number) => {
                to.remove(&from);
                to.insert(name, Entry::File(number));
            }
        }
    }
}
