//! The files that a scene is read from. No result may replace one of them.

use super::failure::Failure;
use crate::service::scenes::texture_folder::TextureFolder;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use strahl::scene::Files;

/// The folder of a scene, and what has been read from it.
#[derive(Debug)]
pub(super) struct SceneInputs {
    folder: TextureFolder,
    path: PathBuf,
    /// Canonical paths, that of the scene among them.
    read: Mutex<BTreeSet<PathBuf>>,
}

impl SceneInputs {
    /// Those of the scene in a file; none if its folder cannot be read.
    pub(super) fn of(scene: &Path) -> Option<Self> {
        // A path without a folder is in the working directory.
        let path = scene.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let read = Mutex::new(scene.canonicalize().into_iter().collect());
        Some(Self { folder: TextureFolder::open(path).ok()?, path: path.to_owned(), read })
    }

    /// Fails if a result would replace what was read.
    pub(super) fn check_output(&self, output: &Path) -> Result<(), Failure> {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if output.canonicalize().is_ok_and(|output| read.contains(&output)) {
            let name = output.display();
            return Err(Failure::Usage(format!("{name} belongs to the scene: name another file for the result")));
        }
        Ok(())
    }
}

impl Files for SceneInputs {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let bytes = self.folder.read(name)?;
        if let Ok(path) = self.path.join(name).canonicalize() {
            self.read.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
        }
        Ok(bytes)
    }

    fn has_asset(&self, hash: &str) -> bool {
        self.folder.has_asset(hash)
    }
}
