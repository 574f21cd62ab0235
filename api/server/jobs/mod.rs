//! `/v1/jobs`: pictures to be fetched later, and everything there is to see of them meanwhile.

mod change;
mod deferred;
mod events;
mod look;
mod prefer;
mod submit;
mod view;

pub(super) use change::*;
pub(super) use deferred::render_later;
pub(super) use events::*;
pub(super) use look::*;
pub(super) use prefer::Prefer;
pub(super) use submit::*;
pub(super) use view::*;

use super::Service;
use super::problem::{Kind, Problem};
use super::tenant::{Scope, Tenant};
use crate::jobs::Job;
use crate::jobs::record::{Record, State};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use uuid::Uuid;

/// Whether a tenant may see a job: its own, and operators all.
fn may_see(tenant: &Tenant, record: &Record) -> bool {
    record.tenant == tenant.name || tenant.may(Scope::Admin)
}

/// The job of a path, if the tenant may see it.
fn find(service: &Service, tenant: &Tenant, id: &str) -> Result<Arc<Job>, Problem> {
    service.jobs.find(id).filter(|job| may_see(tenant, &job.record())).ok_or_else(|| {
        let limits = service.jobs.limits;
        let kept = limits.keep_records.min(limits.keep_pictures + limits.keep_records);
        if is_older(id, kept) {
            Problem::new(Kind::Gone, format!("there is no job {id} any more, if there ever was"))
        } else {
            Problem::new(Kind::NotFound, format!("you have no job {id}"))
        }
    })
}

/// Whether an id is that of a job from so long ago that it may have been forgotten.
fn is_older(id: &str, age: Duration) -> bool {
    let made = Uuid::try_parse(id).ok().and_then(|id| id.get_timestamp()).map(|made| made.to_unix());
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    made.is_some_and(|(seconds, _)| now.as_secs().saturating_sub(seconds) >= age.as_secs().max(1))
}

/// Waits for something, until the time is over or the service is about to end; none then.
async fn patiently<T>(service: &Service, patience: Duration, wait: impl Future<Output = T>) -> Option<T> {
    let mut draining = service.drain.watch();
    tokio::select! {
        done = wait => Some(done),
        () = tokio::time::sleep(patience) => None,
        _ = draining.wait_for(|draining| *draining) => None,
    }
}

/// Waits until a job is final or the time is over.
async fn until_final(service: &Service, job: &Arc<Job>, patience: Duration) {
    let mut bell = job.events.bell();
    let ended = async {
        while !job.record().state.is_final() {
            if bell.changed().await.is_err() {
                return;
            }
        }
    };
    // Either way the caller looks at the state.
    patiently(service, patience, ended).await;
}

/// A job without a picture, when one is asked for.
fn no_picture(job: &Job) -> Problem {
    let record = job.record();
    let (id, state) = (record.id.clone(), record.state);
    match state {
        State::Expired => Problem::new(Kind::Gone, format!("the picture of job {id} has expired; submit it again")),
        State::Failed | State::Canceled => {
            let detail = record.failure.as_ref().map_or("it was canceled", |failure| failure.detail.as_str());
            Problem::new(Kind::JobFailed, format!("job {id} has no picture: {detail}"))
        }
        State::Queued | State::Running | State::Succeeded => {
            drop(record);
            let eta = job.progress().eta_ms.unwrap_or(1_000.0);
            let seconds = ((eta / 1e3).ceil() as u32).clamp(1, 10);
            Problem::new(Kind::JobNotFinished, format!("job {id} is {}", state.name())).retry_after(seconds)
        }
    }
}
