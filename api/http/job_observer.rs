<<<<<<< HEAD
//! Counts jobs that end.
=======
//! Charges tenants for the rays of their jobs, and counts jobs that end.
>>>>>>> 3c3dbe3 (The program's comments and help in plain English)

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
