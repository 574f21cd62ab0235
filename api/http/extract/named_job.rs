//! The job in a path, if the tenant may see it.

use super::path::Path;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::problem::{Kind, Problem};
use crate::http::state::{App, AppState};
use crate::service::clock::unix_time;
use crate::service::jobs::Job;
use crate::service::jobs::record::Record;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use std::sync::Arc;
use std::time::Duration;
use uuid::Uuid;

/// A job, and the tenant of the request.
#[derive(Debug)]
pub(crate) struct NamedJob {
    pub(crate) job: Arc<Job>,
    pub(crate) tenant: Arc<Tenant>,
}

impl FromRequestParts<App> for NamedJob {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let tenant = Tenant::of(&parts.extensions);
        let Path(id) = Path::<String>::from_request_parts(parts, app).await?;
        find(app, &tenant, &id).await.map(|job| Self { job, tenant })
    }
}

/// The job of an id, if the tenant may see it.
pub(crate) async fn find(app: &AppState, tenant: &Tenant, id: &str) -> Result<Arc<Job>, Problem> {
    let found = app.service.jobs.find_lately(id).await?.filter(|job| may_see(tenant, &job.record()));
    found.ok_or_else(|| missing(app, id))
}

/// Whether a tenant may see a job. Keys with the scope admin may see all.
pub(crate) fn may_see(tenant: &Tenant, record: &Record) -> bool {
    record.tenant == tenant.name || tenant.may(Scope::Admin)
}

fn missing(app: &AppState, id: &str) -> Problem {
    if is_older(id, app.service.jobs.limits.keep_records) {
        Problem::new(Kind::Gone, format!("there is no job {id} any more, if there ever was"))
    } else {
        Problem::new(Kind::NotFound, format!("you have no job {id}"))
    }
}

/// Whether the job of an id is so old that it may have been deleted.
fn is_older(id: &str, age: Duration) -> bool {
    let made = Uuid::try_parse(id).ok().and_then(|id| id.get_timestamp()).map(|made| made.to_unix());
    made.is_some_and(|(seconds, _)| unix_time().as_secs().saturating_sub(seconds) >= age.as_secs().max(1))
}
