//! Counts jobs that end.

use super::metrics::Metrics;
use crate::service::jobs::JobObserver;
use crate::service::jobs::record::{Record, State};
use std::sync::Arc;

/// The counters of jobs.
#[derive(Debug)]
pub(crate) struct JobCounters(pub(crate) Arc<Metrics>);

impl JobObserver for JobCounters {
    fn ended(&self, record: &Record, state: State) {
        self.0.job_ended(record, state);
    }
}
