//! Where tasks of a farm's manager read and write: files, and blobs of the store, which are written `store:NAME`. Both are there
//! completely or not at all, so that a task may be stopped at any time, and done twice.

use super::failure::{Failure, NO_INPUT, NO_OUTPUT, TRY_AGAIN};
use super::output;
use crate::service::error::StartError;
use crate::service::storage::disk;
use crate::service::storage::objects::{ObjectError, Objects};
use clap::Args;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use tokio::runtime::{Builder, Runtime};

/// What begins the name of a blob.
const STORE: &str = "store:";

/// Where the store is.
#[derive(Debug, Args)]
pub(super) struct StoreArgs {
    /// The store of names that begin with store: - a folder that all machines see, or s3://BUCKET/PREFIX, with
    /// AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY of the environment.
    #[arg(long, env = "STRAHL_STORE", value_name = "DIR|s3://BUCKET/PREFIX")]
    store: Option<String>,
}

/// Files, and the store if there is one.
#[derive(Debug)]
pub(super) struct Places {
    store: Option<(Objects, Runtime)>,
}

impl Places {
    /// Opens the store, if any of these places is there.
    pub(super) fn open<'a>(args: &StoreArgs, places: impl IntoIterator<Item = &'a str>) -> Result<Self, Failure> {
        if !places.into_iter().any(|place| place.starts_with(STORE)) {
            return Ok(Self { store: None });
        }
        let place = args.store.as_deref();
        let place = place.ok_or_else(|| Failure::Usage(format!("names that begin with {STORE} need --store")))?;
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime =
            runtime.map_err(|error| Failure::task(TRY_AGAIN, format!("no thread can be started: {error}")))?;
        let opened = runtime.block_on(Objects::open(place)).map_err(|error| match error {
            StartError::Settings(why) => Failure::Usage(why),
            StartError::Machine(why) => Failure::task(TRY_AGAIN, why),
        });
        Ok(Self { store: Some((opened?, runtime)) })
    }

    /// All of a file or a blob, up to a number of bytes and one more.
    pub(super) fn read(&self, place: &str, max: u64) -> Result<Vec<u8>, Failure> {
        if let (Some(name), Some((store, runtime))) = (place.strip_prefix(STORE), &self.store) {
            let found = runtime.block_on(store.get(name, max.saturating_add(1))).map_err(|error| match error {
                ObjectError::Store(_) => Failure::task(TRY_AGAIN, format!("{place} cannot be read: {error}")),
                ObjectError::Name(_) => Failure::Usage(error.to_string()),
                _ => Failure::task(NO_INPUT, format!("{place} cannot be read: {error}")),
            })?;
            return found.ok_or_else(|| Failure::task(NO_INPUT, format!("{place} is not in the store")));
        }
        let mut bytes = Vec::new();
        let read = File::open(place).and_then(|file| file.take(max.saturating_add(1)).read_to_end(&mut bytes));
        read.map_err(|error| {
            let code = match error.kind() {
                io::ErrorKind::NotFound | io::ErrorKind::IsADirectory => NO_INPUT,
                _ => TRY_AGAIN,
            };
            Failure::task(code, format!("{place} cannot be read: {error}"))
        })?;
        Ok(bytes)
    }

    /// Writes all of a file or a blob, instead of what was there.
    pub(super) fn write(&self, place: &str, bytes: Vec<u8>) -> Result<(), Failure> {
        if let (Some(name), Some((store, runtime))) = (place.strip_prefix(STORE), &self.store) {
            return runtime.block_on(store.put(name, bytes)).map_err(|error| match error {
                ObjectError::Name(_) => Failure::Usage(error.to_string()),
                _ => Failure::task(TRY_AGAIN, format!("{place} cannot be written: {error}")),
            });
        }
        let path = Path::new(place);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let written = folder.map_or(Ok(()), disk::create_folders).and_then(|()| output::replace(path, &bytes, true));
        written.map_err(|error| {
            let code = if error.kind() == io::ErrorKind::StorageFull { TRY_AGAIN } else { NO_OUTPUT };
            Failure::task(code, format!("{place} cannot be written: {error}"))
        })
    }
}

/// A place with numbers in it, such as `tiles/shot.{index}.tile`.
pub(super) fn numbered(template: &str, word: &str, number: u32, digits: usize) -> String {
    template.replace(&format!("{{{word}}}"), &format!("{number:0digits$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_where_their_word_is() {
        assert_eq!(numbered("a/{index}.{frame}", "index", 7, 1), "a/7.{frame}");
        assert_eq!(numbered("a/{frame}/{frame}.png", "frame", 7, 4), "a/0007/0007.png");
    }

    #[test]
    fn a_file_is_replaced_as_a_whole_and_what_is_not_there_is_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/out.tile");
        let place = file.to_str().unwrap();
        let places = Places::open(&StoreArgs { store: None }, [place]).unwrap();
        places.write(place, b"one".to_vec()).unwrap();
        places.write(place, b"two".to_vec()).unwrap();
        assert_eq!(places.read(place, 10).unwrap(), b"two");
        assert_eq!(places.read(place, 1).unwrap(), b"tw", "one more than asked for, to know that there is more");
        assert_eq!(std::fs::read_dir(file.parent().unwrap()).unwrap().count(), 1);
        let gone = folder.path().join("gone");
        assert!(matches!(places.read(gone.to_str().unwrap(), 1), Err(Failure::Task { code: NO_INPUT, .. })));
        let same = places.read(file.parent().unwrap().to_str().unwrap(), 1);
        assert!(matches!(same, Err(Failure::Task { code: NO_INPUT, .. })), "a folder is no input");
        assert!(matches!(places.write(&format!("{place}/x"), vec![]), Err(Failure::Task { code: NO_OUTPUT, .. })));
        assert!(matches!(Places::open(&StoreArgs { store: None }, ["store:a"]), Err(Failure::Usage(_))));
    }

    #[test]
    fn names_of_the_store_are_read_and_written_there() {
        let folder = tempfile::tempdir().unwrap();
        let args = StoreArgs { store: Some(folder.path().to_str().unwrap().to_owned()) };
        let places = Places::open(&args, ["store:a/b.tile"]).unwrap();
        places.write("store:a/b.tile", b"one".to_vec()).unwrap();
        assert_eq!(places.read("store:a/b.tile", 10).unwrap(), b"one");
        assert!(matches!(places.read("store:a/c.tile", 1), Err(Failure::Task { code: NO_INPUT, .. })));
        assert!(matches!(places.write("store:../c", vec![]), Err(Failure::Usage(_))));
    }
}
