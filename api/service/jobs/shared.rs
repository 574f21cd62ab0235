//! Records and events of jobs that the fronts of a farm share, at its broker.

use super::event_log::{Event, EventPublisher};
use super::job::Job;
use super::record::Record;
use super::records::Records;
use crate::service::clock::RunTime;
use crate::service::error::not_reachable;
use crate::service::farm::Farm;
use crate::service::farm::events::Publisher;
use crate::service::farm::fronts::Fronts;
use crate::service::farm::names;
use crate::service::farm::records::Records as Bucket;
use crate::service::hash::sha256;
use crate::service::storage::revisions::Refused;
use std::io;
use std::sync::Arc;

/// The records, and who may work on them.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) records: Bucket,
    /// Idempotency keys of jobs that are being accepted. Later their records have them.
    keys: Bucket,
    pub(super) fronts: Fronts,
    events: Publisher,
    /// The broker's clock: fronts have their own.
    time: RunTime,
}

impl Shared {
    /// Opens what is at the broker. Not to be called on a thread of a runtime.
    pub(super) fn open(farm: &Farm) -> Result<Self, String> {
        let (broker, runtime) = (&farm.broker, &farm.runtime);
        runtime.block_on(async {
            let fronts = Fronts::join(broker).await?;
            Ok(Self {
                records: Bucket::open(broker, names::JOBS, runtime).await?,
                keys: Bucket::open(broker, names::KEYS, runtime).await?,
                time: RunTime::after(fronts.time().await?),
                events: Publisher::start(broker),
                fronts,
            })
        })
    }

    /// What this front's claims say.
    fn own(&self) -> Vec<u8> {
        self.fronts.id.clone().into_bytes()
    }
}

/// The revision of what was written; none if another front has written it.
fn or_none(written: Result<u64, Refused>) -> io::Result<Option<u64>> {
    match written {
        Ok(revision) => Ok(Some(revision)),
        Err(Refused::Changed) => Ok(None),
        Err(Refused::Failed(error)) => Err(error),
    }
}

fn key(record: &Record) -> String {
    names::job_key(&record.tenant, &record.id)
}

impl Records for Arc<Shared> {
    /// When this returns, this front has heard of it, unless the broker is slow: whatever it had before is in the registry.
    fn create(&self, record: &Record) -> Result<u64, Refused> {
        let json = serde_json::to_vec(record).map_err(io::Error::from)?;
        let revision = self.records.create(&key(record), json)?;
        self.records.wait_for(revision);
        Ok(revision)
    }

    fn replace(&self, record: &Record, revision: u64) -> Result<u64, Refused> {
        let json = serde_json::to_vec(record).map_err(io::Error::from)?;
        self.records.replace(&key(record), json, revision)
    }

    fn current(&self, record: &Record) -> io::Result<Option<(Record, u64)>> {
        let Some((json, revision)) = self.records.get(&key(record))? else { return Ok(None) };
        Ok(Some((serde_json::from_slice(&json)?, revision)))
    }

    fn remove(&self, jobs: &[Arc<Job>]) -> Result<(), Refused> {
        jobs.iter().try_for_each(|job| {
            let (record, revision) = job.stored();
            self.records.remove(&key(&record), revision)
        })
    }

    fn time(&self) -> u64 {
        self.time.ms()
    }

    fn keep_time(&self) -> io::Result<()> {
        Ok(())
    }

    fn front(&self) -> Option<&str> {
        Some(&self.fronts.id)
    }

    fn is_alive(&self, front: &str) -> bool {
        self.fronts.is_alive(front)
    }

    fn has_other(&self, fronts: &[String]) -> bool {
        self.fronts.has_other(fronts)
    }

    fn claim(&self, tenant: &str, key: &str) -> io::Result<Option<u64>> {
        let place = place(tenant, key);
        let mut claimed = self.keys.claim(&place, self.own());
        if matches!(claimed, Err(Refused::Changed))
            && let Some((front, revision)) = self.keys.get(&place)?
            && !str::from_utf8(&front).is_ok_and(|front| front != self.fronts.id && self.fronts.is_alive(front))
        {
            // Who had it is gone. If it is not, its job is not accepted: its claim has another revision now. A claim of this front
            // that it knows nothing of was written after the broker's answer had been given up.
            claimed = self.keys.replace(&place, self.own(), revision);
        }
        let claimed = or_none(claimed)?;
        // Who had it before has written its job before. Who has not heard of that would make a second one.
        if let Some(revision) = claimed
            && !self.records.catch_up_here()
        {
            self.give_up(tenant, key, revision);
            return Err(not_reachable("the broker of the farm does not say which jobs there are"));
        }
        Ok(claimed)
    }

    fn renew(&self, tenant: &str, key: &str, revision: u64) -> io::Result<Option<u64>> {
        or_none(self.keys.replace(&place(tenant, key), self.own(), revision))
    }

    fn give_up(&self, tenant: &str, key: &str, revision: u64) {
        self.keys.drop_later(place(tenant, key), revision);
    }
}

/// Where an idempotency key is kept: clients choose its letters.
fn place(tenant: &str, key: &str) -> String {
    names::idempotency(tenant, &sha256(key.as_bytes()))
}

impl EventPublisher for Shared {
    fn tell(&self, job: &str, event: &Event) {
        self.events.tell(job, event.seq, event.name, &event.data);
    }
}
