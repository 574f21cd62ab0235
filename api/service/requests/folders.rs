//! The folders that the service writes into: each its own, with a marker, and apart from the other.

use crate::service::error::StartError;
use crate::service::jobs::DATA;
use crate::service::limits::Settings;
use crate::service::pictures::cache;
use crate::service::scenes::store;
use crate::service::storage::disk::is_unfinished;
use crate::service::storage::folder::{Folder, FolderKind, overlap};

/// The folder of `--cache`.
const CACHE: FolderKind = FolderKind {
    flag: "--cache",
    name: "cache",
    is_ours: |path| match path {
        ["pictures" | "scenes"] => true,
        ["pictures", name] => (cache::KIND.is_name)(name) || is_unfinished(name),
        ["scenes", name] => (store::KIND.is_name)(name) || is_unfinished(name),
        _ => false,
    },
};

/// The folders, for as long as the service runs.
#[derive(Debug)]
pub(crate) struct Folders {
    /// Of jobs.
    pub(super) data: Folder,
    /// Of pictures and scenes, if there is one.
    pub(super) cache: Option<Folder>,
}

impl Folders {
    /// Refuses folders of which one is in the other.
    pub(crate) fn check(settings: &Settings) -> Result<(), StartError> {
        match (settings.jobs.data.as_deref(), settings.caches.cache.as_deref()) {
            (Some(data), Some(cache)) if overlap(data, cache) => Err(StartError::Settings(format!(
                "--data {} and --cache {} are the same folder, or one is in the other.\n\nName two folders side by side: \
                 what is in a cache may be removed at any time.",
                data.display(),
                cache.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Opens those that the settings name, and a temporary one for jobs if they name none.
    pub(crate) fn open(settings: &Settings) -> Result<Self, StartError> {
        // Links may have changed since the settings were checked.
        Self::check(settings)?;
        let (data, cache) = (settings.jobs.data.as_deref(), settings.caches.cache.as_deref());
        Ok(Self {
            data: data.map_or_else(|| Folder::temporary(&DATA), |path| Folder::open(path, &DATA))?,
            cache: cache.map(|path| Folder::open(path, &CACHE)).transpose()?,
        })
    }
}
