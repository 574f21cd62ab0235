//! Where the records of jobs live: in a database that this process alone has (`store.rs`), or at the broker of a farm, whose
//! fronts all write them (`shared.rs`). So each write names the revision that it replaces, and is refused if there is another.

use super::job::Job;
use super::record::Record;
use crate::service::storage::revisions::Refused;
use std::fmt;
use std::io;
use std::sync::Arc;

/// Records by their jobs.
pub(super) trait Records: fmt::Debug + Send + Sync {
    /// Keeps the record of a new job; its revision.
    fn create(&self, record: &Record) -> Result<u64, Refused>;

    /// Keeps a record instead of the one of a revision; its own revision.
    fn replace(&self, record: &Record, revision: u64) -> Result<u64, Refused>;

    /// A record as it is now, with its revision; none if it was removed.
    fn current(&self, record: &Record) -> io::Result<Option<(Record, u64)>>;

    /// Removes records.
    fn remove(&self, jobs: &[Arc<Job>]) -> Result<(), Refused>;

    /// Milliseconds that services have run on the records.
    fn time(&self) -> u64;

    /// Notes that time, as every write does.
    fn keep_time(&self) -> io::Result<()>;

    /// Whether what was last to be written could not be.
    fn is_failing(&self) -> bool {
        false
    }

    /// The name of this process among those that write records; none if it is alone.
    fn front(&self) -> Option<&str> {
        None
    }

    /// Whether another process that has written its name into records is still there.
    fn is_alive(&self, _front: &str) -> bool {
        false
    }

    /// Whether there is another process that writes records, and is none of these.
    fn has_other(&self, _fronts: &[String]) -> bool {
        false
    }

    /// Makes an idempotency key this process's own, until it is given up; none if another process has it. If another one has had
    /// it before, this process knows the job that was made with it when this returns.
    fn claim(&self, _tenant: &str, _key: &str) -> io::Result<Option<u64>> {
        Ok(Some(0))
    }

    /// Whether it is still this process's own; it is for a while from now on.
    fn renew(&self, _tenant: &str, _key: &str, revision: u64) -> io::Result<Option<u64>> {
        Ok(Some(revision))
    }

    /// Gives an idempotency key up.
    fn give_up(&self, _tenant: &str, _key: &str, _revision: u64) {}
}
