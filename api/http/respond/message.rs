//! The message about a job that has ended, as its webhook gets it: the type of what happened, when, and the job as
//! `GET /v1/jobs/{id}` shows it, without the cost report.

use super::job::{JobView, rfc3339};
use crate::http::state::App;
use crate::service::deliveries::MessageWriter;
use crate::service::deliveries::signature::Secret;
use crate::service::jobs::Job;
use crate::service::jobs::record::State;
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

/// The message about a job that has ended.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct JobMessage {
    /// `job.succeeded`, `job.failed` or `job.canceled`.
    #[serde(rename = "type")]
    kind: String,
    /// When the job ended (RFC 3339).
    timestamp: String,
    /// The job.
    data: JobView,
}

/// Writes the messages of the service.
pub(crate) struct HttpMessageWriter(pub(crate) App);

impl MessageWriter for HttpMessageWriter {
    fn message(&self, job: &Arc<Job>) -> String {
        let (state, ended) = {
            let record = job.record();
            (record.state, record.finished.unwrap_or(record.created))
        };
        // A picture may go before its message does.
        let state = if state == State::Expired { State::Succeeded } else { state };
        let message = JobMessage {
            kind: format!("job.{}", state.name()),
            timestamp: rfc3339(ended),
            data: JobView::of(&self.0, job),
        };
        // All values of a job can be written as JSON.
        serde_json::to_string(&message).unwrap_or_default()
    }

    fn secret(&self, tenant: &str) -> Option<Secret> {
        self.0.access.webhook_secret(tenant)
    }
}
