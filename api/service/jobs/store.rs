//! Records on disk, in an embedded database that is intact after any crash. One process can open it at a time.
//!
//! redb rather than SQLite: keys and values are enough, it is plain Rust, so that the static binary needs no C, and it builds
//! in seconds.

use super::job::Job;
use super::record::Record;
use super::records::Records;
use crate::service::clock::RunTime;
use crate::service::error::{StartError, panic_text};
use crate::service::storage::disk::{self, DatabaseFile};
use crate::service::storage::revisions::Refused;
use parking_lot::Mutex;
use redb::{Database, ReadableDatabase, ReadableTable, StorageError, TableDefinition};
use std::cell::Cell;
use std::fs;
use std::io;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once};

/// Milliseconds that services have run on the folder.
const TIME: TableDefinition<'_, (), u64> = TableDefinition::new("time");
/// Records as JSON by id.
const JOBS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("jobs");
/// The file.
const NAME: &str = "jobs.redb";
/// A new one, until it can be opened.
const UNFINISHED: &str = "jobs.redb.new";

/// The database.
#[derive(Debug)]
pub(super) struct Store {
    path: PathBuf,
    /// None after an error of the disk: redb takes nothing more until it is opened again.
    database: Mutex<Option<Database>>,
    /// Whether the last write failed.
    is_failing: AtomicBool,
    /// How long services have run on the folder.
    run_time: RunTime,
}

/// What is in a database.
#[derive(Debug)]
pub(super) struct Contents {
    /// All records that can be read, the oldest first.
    pub(super) records: Vec<Record>,
    /// Whether there are others.
    pub(super) others: bool,
}

impl Store {
    /// Opens the database in a folder, every page of it checked. It is made if there is none, unless jobs have files there.
    pub(super) fn open(folder: &Path, has_files: bool) -> Result<(Self, Contents), StartError> {
        let path = folder.join(NAME);
        let is_there = fs::metadata(&path).is_ok_and(|about| about.len() > 0);
        if !is_there && has_files {
            return Err(StartError::Machine(format!(
                "{} is missing or empty, but jobs have files beside it.\n\n\
                 Restore {NAME} from a backup. Or name another folder with --data DIR, or move everything out of this \
                 one, to begin without these jobs.",
                path.display()
            )));
        }
        let opened = caught(|| {
            if !is_there {
                Self::create(folder)?;
            }
            let mut database = Database::builder().create_with_backend(DatabaseFile::open(&path)?)?;
            if !database.check_integrity()? {
                tracing::warn!(file = NAME, "the database was damaged; its last whole state is used");
            }
            let transaction = database.begin_read()?;
            // Versions before had no such table.
            let before = transaction.open_table(TIME).ok().map(|table| table.get(())).transpose()?.flatten();
            let run_time = RunTime::after(before.map_or(0, |before| before.value()));
            let contents = contents(&database)?;
            let (database, is_failing) = (Mutex::new(Some(database)), AtomicBool::new(false));
            Ok((Self { path: path.clone(), database, is_failing, run_time }, contents))
        });
        opened.map_err(|error| StartError::Machine(format!("{}: {}", path.display(), advice(&error))))
    }

    /// It has its name when it is whole: a crash leaves none, or one that can be opened.
    fn create(folder: &Path) -> Result<(), redb::Error> {
        let (unfinished, path) = (folder.join(UNFINISHED), folder.join(NAME));
        match disk::remove(&unfinished) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
        let database = Database::builder().create_with_backend(DatabaseFile::open(&unfinished)?)?;
        write(&database, 0, |_| Ok(()))?;
        drop(database);
        disk::rename(&unfinished, &path)?;
        Ok(disk::sync_parent(&path)?)
    }

    fn change(
        &self,
        change: impl FnOnce(&mut redb::Table<'_, &'static str, &'static [u8]>) -> Result<(), StorageError>,
    ) -> io::Result<()> {
        let mut open = self.database.lock();
        let changed = caught(|| {
            let database = match open.take() {
                Some(database) => database,
                None => Database::builder().create_with_backend(DatabaseFile::reopen(&self.path)?)?,
            };
            write(&database, self.run_time.ms(), change)?;
            *open = Some(database);
            Ok(())
        });
        self.is_failing.store(changed.is_err(), Ordering::Relaxed);
        changed.map_err(|error| match error {
            redb::Error::Io(error) => error,
            error @ redb::Error::PreviousIo => io::Error::other(error),
            error => io::Error::new(io::ErrorKind::InvalidData, error),
        })
    }
}

fn write(
    database: &Database,
    run_time: u64,
    change: impl FnOnce(&mut redb::Table<'_, &'static str, &'static [u8]>) -> Result<(), StorageError>,
) -> Result<(), redb::Error> {
    let transaction = database.begin_write()?;
    {
        change(&mut transaction.open_table(JOBS)?)?;
        transaction.open_table(TIME)?.insert((), run_time)?;
    }
    Ok(transaction.commit()?)
}

fn contents(database: &Database) -> Result<Contents, redb::Error> {
    let transaction = database.begin_read()?;
    let table = transaction.open_table(JOBS)?;
    let (mut records, mut others) = (Vec::new(), false);
    for entry in table.iter()? {
        let (id, json) = entry?;
        match serde_json::from_slice(json.value()) {
            Ok(record) => records.push(record),
            Err(error) => {
                tracing::warn!(job = id.value(), %error, "a job's record cannot be read");
                others = true;
            }
        }
    }
    Ok(Contents { records, others })
}

/// Each write is on disk when it returns. No other process writes, so none is refused.
impl Records for Store {
    fn create(&self, record: &Record) -> Result<u64, Refused> {
        self.replace(record, 0)
    }

    fn replace(&self, record: &Record, revision: u64) -> Result<u64, Refused> {
        let json = serde_json::to_vec(record).map_err(io::Error::from)?;
        self.change(|table| table.insert(record.id.as_str(), json.as_slice()).map(drop))?;
        Ok(revision + 1)
    }

    fn current(&self, _: &Record) -> io::Result<Option<(Record, u64)>> {
        Ok(None)
    }

    fn remove(&self, jobs: &[Arc<Job>]) -> Result<(), Refused> {
        Ok(self.change(|table| jobs.iter().try_for_each(|job| table.remove(job.record().id.as_str()).map(drop)))?)
    }

    fn time(&self) -> u64 {
        self.run_time.ms()
    }

    fn keep_time(&self) -> io::Result<()> {
        self.change(|_| Ok(()))
    }

    fn is_failing(&self) -> bool {
        self.is_failing.load(Ordering::Relaxed)
    }
}

/// Runs what opens a database. redb panics where a damaged one does not fit; then that is an error, and nothing is printed.
fn caught<T>(open: impl FnOnce() -> Result<T, redb::Error>) -> Result<T, redb::Error> {
    thread_local!(static IS_QUIET: Cell<bool> = const { Cell::new(false) });
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !IS_QUIET.get() {
                print(panic)
            }
        }));
    });
    IS_QUIET.set(true);
    let opened = catch_unwind(AssertUnwindSafe(open));
    IS_QUIET.set(false);
    opened.unwrap_or_else(|panic| Err(redb::Error::Corrupted(panic_text(&*panic))))
}

/// What happened and what to do.
fn advice(error: &redb::Error) -> String {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    match error {
        redb::Error::DatabaseAlreadyOpen => "Another process uses the folder: each needs one of its own.".into(),
        redb::Error::Io(error) if !matches!(error.kind(), InvalidData | InvalidInput | UnexpectedEof) => {
            format!(
                "{error}\n\nThe service has to write into this folder: make room on its disk or give it the rights, or name another with --data DIR, which begins without these jobs."
            )
        }
        damaged => format!(
            "the database of jobs is damaged ({damaged}).\n\nRestore {NAME} from a backup. Or remove it and everything \
             beside it, or name another folder with --data DIR, to begin without these jobs."
        ),
    }
}
