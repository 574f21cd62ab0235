//! The files that a command reads for a scene. No result may replace one of them, nor another result.

use super::failure::Failure;
use super::output::is_standard;
use crate::service::hash::sha256;
use crate::service::scenes::texture_folder::TextureFolder;
use parking_lot::Mutex;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use strahl::scene::hashes::hash_of;
use strahl::scene::{Files, NoFiles};

/// The folder of a scene, and what has been read for it.
#[derive(Debug)]
pub(super) struct SceneInputs {
    /// None for standard input, and if it cannot be read.
    folder: Option<TextureFolder>,
    path: PathBuf,
    read: Mutex<BTreeSet<Identity>>,
    /// The hashes of the files beside the scene, by their names in it, if they are wanted.
    contents: Option<Mutex<BTreeMap<String, String>>>,
}

/// What tells files apart, whatever they are called.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Identity {
    /// A file that is there: its device and its number.
    #[cfg(unix)]
    There(u64, u64),
    /// Its path without links, or the name of a blob.
    Named(PathBuf),
}

impl Identity {
    fn of(file: &Path) -> Self {
        #[cfg(unix)]
        if let Ok(about) = file.metadata() {
            use std::os::unix::fs::MetadataExt;
            return Self::There(about.dev(), about.ino());
        }
        let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let in_folder = || Some(parent.canonicalize().ok()?.join(file.file_name()?));
        Self::Named(file.canonicalize().ok().or_else(in_folder).unwrap_or_else(|| file.to_owned()))
    }
}

impl SceneInputs {
    /// Those of the scene in a file; - is standard input.
    pub(super) fn of(scene: &Path) -> Self {
        let inputs = Self {
            folder: None,
            // A path without a folder is in the working directory.
            path: scene.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned(),
            read: Mutex::default(),
            contents: None,
        };
        if is_standard(scene) {
            return inputs;
        }
        inputs.note(scene);
        Self { folder: TextureFolder::open(&inputs.path).ok(), ..inputs }
    }

    /// Notes another file that the command has read.
    pub(super) fn note(&self, file: &Path) {
        self.read.lock().insert(Identity::of(file));
    }

    /// From now on hashes what is read.
    pub(super) fn hash_contents(&mut self) {
        self.contents = Some(Mutex::default());
    }

    /// A hash of the files beside the scene that were read, with their names; empty if there were none, or nothing was hashed.
    pub(super) fn hash(&self) -> String {
        let Some(contents) = &self.contents else { return String::new() };
        let line = |(name, hash): (&String, &String)| format!("{hash} {name}\n");
        let all: String = contents.lock().iter().map(line).collect();
        if all.is_empty() { all } else { sha256(all.as_bytes()) }
    }

    /// Fails if a result would replace what was read, or another one of these results.
    pub(super) fn check_outputs<'a>(&self, outputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
        let read = self.read.lock();
        let mut others = BTreeSet::new();
        // What is no file keeps nothing, such as /dev/null.
        for output in
            outputs.into_iter().filter(|output| !is_standard(output) && (output.is_file() || !output.exists()))
        {
            let (name, identity) = (output.display(), Identity::of(output));
            if read.contains(&identity) {
                return Err(Failure::Usage(format!("{name} belongs to the scene: name another file for the result")));
            }
            if !others.insert(identity) {
                return Err(Failure::Usage(format!("{name} cannot be two results: name another file for one of them")));
            }
        }
        Ok(())
    }
}

impl Files for SceneInputs {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let Some(folder) = &self.folder else { return NoFiles.read(name) };
        let bytes = folder.read(name)?;
        if let Some(contents) = &self.contents {
            contents.lock().insert(name.to_owned(), sha256(&bytes));
        }
        self.note(&self.path.join(hash_of(name).unwrap_or(name)));
        Ok(bytes)
    }

    fn has_asset(&self, hash: &str) -> bool {
        self.folder.as_ref().is_some_and(|folder| folder.has_asset(hash))
    }
}
