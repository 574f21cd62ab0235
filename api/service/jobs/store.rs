//! Records on disk, in an embedded database that is intact after any crash. One process can open it at a time.
//!
//! redb rather than SQLite: keys and values are enough, it is plain Rust, so that the static binary needs no C, and it builds
//! in seconds.

use super::record::Record;
use redb::{Database, DatabaseError, ReadableDatabase, ReadableTable, TableDefinition};
use std::io;
use std::path::Path;

/// Records as JSON by id.
const JOBS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("jobs");

/// The database.
#[derive(Debug)]
pub(super) struct Store(Database);

impl Store {
    /// Opens or makes it.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let database = Database::create(path).map_err(|error| match error {
            DatabaseError::DatabaseAlreadyOpen => io::ErrorKind::ResourceBusy.into(),
            error => io::Error::other(error),
        })?;
        let store = Self(database);
        store.change(|_| Ok(()))?;
        Ok(store)
    }

    /// Writes a record, which is on disk when this returns.
    pub(super) fn put(&self, record: &Record) -> io::Result<()> {
        let json = serde_json::to_vec(record)?;
        self.change(|table| table.insert(record.id.as_str(), json.as_slice()).map(drop))
    }

    /// Deletes records.
    pub(super) fn remove(&self, ids: &[String]) -> io::Result<()> {
        self.change(|table| ids.iter().try_for_each(|id| table.remove(id.as_str()).map(drop)))
    }

    fn change(
        &self,
        change: impl FnOnce(&mut redb::Table<'_, &'static str, &'static [u8]>) -> Result<(), redb::StorageError>,
    ) -> io::Result<()> {
        let transaction = self.0.begin_write().map_err(io::Error::other)?;
        {
            let mut table = transaction.open_table(JOBS).map_err(io::Error::other)?;
            change(&mut table).map_err(io::Error::other)?;
        }
        transaction.commit().map_err(io::Error::other)
    }

    /// All records that can be read, the oldest first, and whether there are any that cannot.
    pub(super) fn all(&self) -> io::Result<(Vec<Record>, bool)> {
        let transaction = self.0.begin_read().map_err(io::Error::other)?;
        let table = transaction.open_table(JOBS).map_err(io::Error::other)?;
        let (mut records, mut others) = (Vec::new(), false);
        for entry in table.iter().map_err(io::Error::other)? {
            let (id, json) = entry.map_err(io::Error::other)?;
            match serde_json::from_slice(json.value()) {
                Ok(record) => records.push(record),
                Err(error) => {
                    tracing::warn!(job = id.value(), %error, "a job's record cannot be read");
                    others = true;
                }
            }
        }
        Ok((records, others))
    }
}
