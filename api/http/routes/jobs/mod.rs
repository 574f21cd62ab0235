//! `/v1/jobs`: pictures to be fetched later, and everything there is to see of them meanwhile.

mod change;
mod deferred;
mod events;
mod pictures;
mod submit;
mod view;

pub(crate) use change::*;
pub(crate) use deferred::render_later;
pub(crate) use events::*;
pub(crate) use pictures::*;
pub(crate) use submit::*;
pub(crate) use view::*;

use crate::http::Service;
use crate::http::problem::{Kind, Problem};
use crate::service::jobs::Job;
use crate::service::jobs::record::State;
use std::sync::Arc;
use std::time::Duration;

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
