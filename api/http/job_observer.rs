//! Who charges tenants for the rays of their jobs, and counts jobs that end.

use super::auth::Access;
use super::metrics::Metrics;
use crate::service::jobs::JobObserver;
use crate::service::jobs::record::{Record, State};
use std::sync::Arc;

/// Accounts of jobs.
#[derive(Debug)]
pub(crate) struct JobAccounts {
    pub(crate) access: Arc<Access>,
    pub(crate) metrics: Arc<Metrics>,
}

impl JobObserver for JobAccounts {
    fn spent(&self, tenant: &str, rays: u64) {
        self.access.charge(tenant, rays);
    }

    fn ended(&self, record: &Record, state: State) {
        self.metrics.job_ended(record, state);
    }
}
