//! Everything the farm has at the broker: streams, subjects and buckets, and how each is configured. Nobody else names them.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::settings::FarmSettings;
use crate::service::error::StartError;
use crate::service::scenes::ids::renderer;
use async_nats::jetstream::consumer::{AckPolicy, pull};
use async_nats::jetstream::kv;
use async_nats::jetstream::stream::{Config, DiscardPolicy, RetentionPolicy, StorageType};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// The stream of work that waits for nodes.
pub(crate) const WORK: &str = "FARM_T";
/// The stream of finished tiles.
pub(crate) const RESULTS: &str = "FARM_R";
/// The stream of what nobody could render, and why.
pub(crate) const DEAD: &str = "FARM_DLQ";
/// The stream of the broker's notes on work that was delivered too often.
pub(crate) const NOTES: &str = "FARM_ADV";
/// The stream of the events of jobs.
pub(crate) const EVENTS: &str = "FARM_EV";
/// The bucket of jobs: their records by `<tenant>.<job>`.
pub(crate) const JOBS: &str = "farm_jobs";
/// The bucket of nodes, by their ids.
pub(crate) const NODES: &str = "farm_nodes";
/// The bucket of fronts, by their ids.
pub(crate) const FRONTS: &str = "farm_fronts";
/// The bucket of the idempotency keys of jobs that are being accepted.
pub(crate) const KEYS: &str = "farm_keys";
/// The bucket of what all fronts know and nobody else may: the secret that signs capabilities.
pub(crate) const SECRETS: &str = "farm_secrets";
/// The key of that secret.
pub(crate) const CAPABILITIES: &str = "capabilities";

/// How long servers of a cluster may take to agree on a leader.
const PATIENCE: Duration = Duration::from_secs(20);
/// Work that may wait: windows keep each job to a few hundred pieces.
const MOST_WORK: i64 = 200_000;
/// How long results are kept. Those of finished jobs go at once.
const RESULT_AGE: Duration = Duration::from_secs(6 * 3_600);
/// How long it is kept why work was given up.
const DEAD_AGE: Duration = Duration::from_secs(14 * 86_400);
/// Within which a message with the same id counts as the same.
const SAME_WITHIN: Duration = Duration::from_secs(120);
/// How often a piece of work is delivered at most.
pub(crate) const DELIVERIES: i64 = 5;
/// Pieces that all nodes may have at one time: beyond it the broker says nothing and delivers nothing.
const MOST_HELD: i64 = 100_000;
/// A queue that no node has asked for so long goes: that of an old version.
const QUEUE_AGE: Duration = Duration::from_secs(7 * 86_400);
/// Requests for work that may wait: one for each free slot of the farm.
const MOST_WAITING: i64 = 50_000;
/// A node or front that has not been heard of for so long is gone.
pub(crate) const NODE_AGE: Duration = Duration::from_secs(30);
/// The same of fronts.
pub(crate) const FRONT_AGE: Duration = Duration::from_secs(10);
/// How long a front has for accepting a job under an idempotency key.
pub(crate) const KEY_AGE: Duration = Duration::from_secs(120);
/// How long it is known that a record was removed: a front that has not heard of it meanwhile looks at all of them.
pub(crate) const REMOVED_AGE: Duration = Duration::from_secs(3_600);
/// Events of one job that are kept, and how long.
const JOB_EVENTS: i64 = 1_024;
const EVENT_AGE: Duration = Duration::from_secs(3_600);

/// How urgent work is. Each has a queue of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Class {
    /// Somebody waits for the answer.
    Hi,
    /// Jobs.
    Norm,
    /// Jobs of low priority.
    Bulk,
}

impl Class {
    /// All, the most urgent first.
    pub(crate) const ALL: [Self; 3] = [Self::Hi, Self::Norm, Self::Bulk];
    /// Jobs below this priority give way to all others.
    const LOW: u8 = 25;

    /// That of a job.
    pub(crate) fn of_job(priority: u8) -> Self {
        if priority < Self::LOW { Self::Bulk } else { Self::Norm }
    }

    /// Its part of a subject.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Hi => "hi",
            Self::Norm => "norm",
            Self::Bulk => "bulk",
        }
    }

    /// The queue of this version of the renderer.
    pub(crate) fn queue(self) -> String {
        format!("{}-{}", self.name(), renderer())
    }
}

/// Where work of a job is published.
pub(crate) fn work(class: Class, tenant: &str, job: &str) -> String {
    format!("farm.t.{}.{}.{}.{job}", class.name(), renderer(), token(tenant))
}

/// All work of a job, of whatever class and version.
pub(crate) fn all_work(tenant: &str, job: &str) -> String {
    format!("farm.t.*.*.{}.{job}", token(tenant))
}

/// Where a finished tile is kept. Another version of the renderer has other tiles.
pub(crate) fn result(job: &str, tile: u32) -> String {
    format!("farm.r.{job}.{}.{tile}", renderer())
}

/// All tiles of a job that this version of the renderer has made.
pub(crate) fn results(job: &str) -> String {
    format!("farm.r.{job}.{}.*", renderer())
}

/// All tiles of a job.
pub(crate) fn all_results(job: &str) -> String {
    format!("farm.r.{job}.>")
}

/// Where nodes say that they have begun with a piece of a job. It is not kept.
pub(crate) fn begun(job: &str) -> String {
    format!("farm.b.{job}")
}

/// Where it is said why work of a job was given up.
pub(crate) fn dead(tenant: &str, job: &str) -> String {
    format!("farm.dlq.{}.{job}", token(tenant))
}

/// Events of a job.
pub(crate) fn events(job: &str) -> String {
    format!("farm.ev.{job}")
}

/// The job of whose events this is the subject.
pub(crate) fn job_of_events(subject: &str) -> Option<&str> {
    subject.strip_prefix("farm.ev.")
}

/// Where other fronts ask a front. It is not kept.
pub(crate) fn front(id: &str) -> String {
    format!("farm.front.{id}")
}

/// Key of an idempotency key of a tenant.
pub(crate) fn idempotency(tenant: &str, digest: &str) -> String {
    format!("{}.{digest}", token(tenant))
}

/// Tells nodes to drop work of a job. It is not kept.
pub(crate) fn cancel(job: &str) -> String {
    format!("farm.ctl.cancel.{job}")
}

/// What tenants have spent at one front. It is not kept.
pub(crate) const SPENT: &str = "farm.spent";
/// All that nodes publish: results, that they have begun, and what they give up.
pub(crate) const BY_NODES: [&str; 3] = ["farm.r.>", "farm.b.*", "farm.dlq.>"];
/// All that is said to nodes.
pub(crate) const TO_NODES: &str = "farm.ctl.>";
/// All that fronts publish.
pub(crate) const BY_FRONTS: &str = "farm.>";
/// All jobs that are to be dropped.
pub(crate) const CANCELS: &str = "farm.ctl.cancel.*";
/// The broker's notes on work that was delivered too often.
pub(crate) const TOO_OFTEN: &str = "$JS.EVENT.ADVISORY.CONSUMER.MAX_DELIVERIES.FARM_T.*";

/// Key of a job's record.
pub(crate) fn job_key(tenant: &str, job: &str) -> String {
    format!("{}.{job}", token(tenant))
}

/// A text as one part of a subject or key. Letters, digits, `_` and `-` stay, all else becomes `=` and two digits, so that two
/// texts never have the same.
pub(crate) fn token(text: &str) -> String {
    let mut token = String::with_capacity(text.len());
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'-' => token.push(char::from(byte)),
            // Writing to a String cannot fail.
            _ => _ = write!(token, "={byte:02x}"),
        }
    }
    token
}

/// Makes what is missing at the broker, and brings the rest to these configurations. Fronts do it at their start. Servers of a
/// cluster that were started a moment ago have no leader yet, so it is tried for a while.
pub(crate) async fn set_up(broker: &Broker, settings: &FarmSettings) -> Result<(), StartError> {
    let began = Instant::now();
    loop {
        match set_up_once(broker, settings).await {
            Err(StartError::Machine(why)) if began.elapsed() < PATIENCE => {
                tracing::warn!(why, "the broker is not ready yet");
                tokio::time::sleep(RETRY_AFTER).await;
            }
            done => return done,
        }
    }
}

async fn set_up_once(broker: &Broker, settings: &FarmSettings) -> Result<(), StartError> {
    let replicas = settings.farm_replicas as usize;
    for config in streams(replicas) {
        let name = config.name.clone();
        let made = broker.stream.create_or_update_stream(config).await;
        made.map_err(|error| refused(&name, &error))?;
    }
    for config in buckets(replicas) {
        let name = config.bucket.clone();
        let made = broker.stream.create_or_update_key_value(config).await;
        made.map_err(|error| refused(&name, &error))?;
    }
    for class in Class::ALL {
        let config = queue(class, settings.farm_lease);
        let name = class.queue();
        let made = broker.stream.create_consumer_on_stream(config, WORK).await;
        made.map_err(|error| refused(&name, &error))?;
    }
    Ok(())
}

fn refused(name: &str, error: &(dyn std::error::Error + 'static)) -> StartError {
    StartError::Machine(format!(
        "the broker does not make {name}: {}\n\nMay this account make streams, and has it room for them? `strahl farm \
         accounts` writes accounts that may.",
        reasons(error)
    ))
}

fn streams(num_replicas: usize) -> [Config; 5] {
    let common = Config {
        storage: StorageType::File,
        num_replicas,
        allow_direct: true,
        duplicate_window: SAME_WITHIN,
        max_consumers: -1,
        max_bytes: -1,
        max_messages: -1,
        max_messages_per_subject: -1,
        ..Config::default()
    };
    let of = |name: &str, subject: &str| Config { name: name.into(), subjects: vec![subject.into()], ..common.clone() };
    [
        Config {
            retention: RetentionPolicy::WorkQueue,
            discard: DiscardPolicy::New,
            max_messages: MOST_WORK,
            max_age: Duration::from_secs(86_400),
            ..of(WORK, "farm.t.>")
        },
        // The first result of a tile is the one: a second one is refused.
        Config {
            discard: DiscardPolicy::New,
            discard_new_per_subject: true,
            max_messages_per_subject: 1,
            max_age: RESULT_AGE,
            ..of(RESULTS, "farm.r.>")
        },
        Config { max_age: DEAD_AGE, max_messages: 100_000, ..of(DEAD, "farm.dlq.>") },
        Config { max_age: DEAD_AGE, max_messages: 100_000, ..of(NOTES, TOO_OFTEN) },
        Config { max_messages_per_subject: JOB_EVENTS, max_age: EVENT_AGE, ..of(EVENTS, "farm.ev.>") },
    ]
}

fn buckets(num_replicas: usize) -> [kv::Config; 5] {
    let of = |bucket: &str, max_age| kv::Config {
        bucket: bucket.into(),
        history: 1,
        storage: StorageType::File,
        num_replicas,
        max_age,
        ..kv::Config::default()
    };
    [
        kv::Config { limit_markers: Some(REMOVED_AGE), ..of(JOBS, Duration::ZERO) },
        of(NODES, NODE_AGE),
        of(FRONTS, FRONT_AGE),
        of(KEYS, KEY_AGE),
        of(SECRETS, Duration::ZERO),
    ]
}

/// The queue of a class. Work that is not acknowledged goes to another node after the lease.
fn queue(class: Class, lease: Duration) -> pull::Config {
    pull::Config {
        durable_name: Some(class.queue()),
        ack_policy: AckPolicy::Explicit,
        ack_wait: lease,
        max_deliver: DELIVERIES,
        filter_subject: format!("farm.t.{}.{}.>", class.name(), renderer()),
        max_ack_pending: MOST_HELD,
        max_waiting: MOST_WAITING,
        inactive_threshold: QUEUE_AGE,
        ..pull::Config::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tenants_with_any_names_have_subjects_of_their_own() {
        let tenants = ["a", "A", "a.b", "a*", ">", "a b", "a=2eb", "ä", "=", ""];
        let tokens: std::collections::BTreeSet<String> = tenants.iter().map(|tenant| token(tenant)).collect();
        assert_eq!(tokens.len(), tenants.len());
        assert!(tokens.iter().all(|token| token.bytes().all(|b| b.is_ascii_alphanumeric() || b"=_-".contains(&b))));
        assert_eq!(token("a.b"), "a=2eb");
        assert!(work(Class::Hi, "a.b", "7").ends_with(".a=2eb.7"));
    }

    #[test]
    fn jobs_of_low_priority_are_bulk() {
        let classes = [0, 24, 25, 100].map(Class::of_job);
        assert_eq!(classes, [Class::Bulk, Class::Bulk, Class::Norm, Class::Norm]);
    }
}
