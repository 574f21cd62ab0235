//! The job that a path names, for handlers: there is one, and who asks may see it.

use crate::http::App;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::problem::{Kind, Problem};
use crate::service::jobs::Job;
use crate::service::jobs::record::Record;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use uuid::Uuid;

/// A job, and who asks about it.
#[derive(Debug)]
pub(crate) struct Named {
    pub(crate) job: Arc<Job>,
    pub(crate) tenant: Arc<Tenant>,
}

impl FromRequestParts<App> for Named {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, service: &App) -> Result<Self, Problem> {
        let tenant = Tenant::of(&parts.extensions);
        let Path(id) = Path::<String>::from_request_parts(parts, service)
            .await
            .map_err(|_| Problem::new(Kind::NotFound, "a job's id is text"))?;
        find(service, &tenant, &id).map(|job| Self { job, tenant })
    }
}

/// The job of an id, if the tenant may see it.
pub(crate) fn find(service: &App, tenant: &Tenant, id: &str) -> Result<Arc<Job>, Problem> {
    let found = service.jobs.find(id).filter(|job| may_see(tenant, &job.record()));
    found.ok_or_else(|| missing(service, id))
}

/// Whether a tenant may see a job: its own, and operators all.
pub(crate) fn may_see(tenant: &Tenant, record: &Record) -> bool {
    record.tenant == tenant.name || tenant.may(Scope::Admin)
}

fn missing(service: &App, id: &str) -> Problem {
    let limits = service.jobs.limits;
    let kept = limits.keep_records.min(limits.keep_pictures + limits.keep_records);
    if is_older(id, kept) {
        Problem::new(Kind::Gone, format!("there is no job {id} any more, if there ever was"))
    } else {
        Problem::new(Kind::NotFound, format!("you have no job {id}"))
    }
}

/// Whether an id is that of a job from so long ago that it may have been forgotten.
fn is_older(id: &str, age: Duration) -> bool {
    let made = Uuid::try_parse(id).ok().and_then(|id| id.get_timestamp()).map(|made| made.to_unix());
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    made.is_some_and(|(seconds, _)| now.as_secs().saturating_sub(seconds) >= age.as_secs().max(1))
}
