//! The folder in which the service keeps what is to outlive it, or one that ends with it.

use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The folder.
#[derive(Debug)]
pub(crate) enum DataFolder {
    /// One that was named.
    Kept(PathBuf),
    /// One that is removed at the end.
    Temporary(TempDir),
}

impl DataFolder {
    /// The folder of that name, which is made if it is not there, or a temporary one.
    pub(crate) fn open(path: Option<&Path>) -> io::Result<Self> {
        let Some(path) = path else {
            return tempfile::Builder::new().prefix("strahl-").tempdir().map(Self::Temporary).map_err(|error| {
                let why = format!("there is no folder for temporary files ({error}): name one with --data DIR");
                io::Error::new(error.kind(), why)
            });
        };
        std::fs::create_dir_all(path)
            .map_err(|error| io::Error::new(error.kind(), format!("--data {}: {error}", path.display())))?;
        Ok(Self::Kept(path.to_owned()))
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        match self {
            Self::Kept(path) => path,
            Self::Temporary(folder) => folder.path(),
        }
    }
}
