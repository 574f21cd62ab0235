//! What jobs ask of the service: scenes that are built once for all, and somebody who charges for rays and counts
//! jobs.

use super::auth::Access;
use super::metrics::Metrics;
use super::problem::Problem;
use crate::service::jobs::JobObserver;
use crate::service::jobs::record::{Failure, Record, State};
use crate::service::scenes::cache::SceneCache;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use std::sync::Arc;
use strahl::scene::{Format, Overrides};

/// The service as jobs see it.
#[derive(Debug)]
pub(crate) struct JobHost {
    pub(crate) scenes: Arc<SceneCache>,
    pub(crate) access: Arc<Access>,
    pub(crate) metrics: Arc<Metrics>,
}

impl JobObserver for JobHost {
    fn build(
        &self,
        workers: &Workers,
        text: &[u8],
        format: Format,
        settings: &Overrides,
    ) -> Result<Arc<PreparedScene>, Failure> {
        let found = self.scenes.find(workers, text, format, settings);
        found.map(|found| found.ready).map_err(|problems| Problem::scene(&problems).into_failure())
    }

    fn spent(&self, tenant: &str, rays: u64) {
        self.access.charge(tenant, rays);
    }

    fn ended(&self, record: &Record, state: State) {
        self.metrics.job_ended(record, state);
    }
}
