//! The tenant of a request, what it may do, and its limits.
//!
//! Middleware puts an `Arc<Tenant>` into each request's extensions, and [`Tenant::of`] takes it out. Without keys every request
//! belongs to the tenant "anonymous", which may do everything.

use super::rate_limit::RateLimit;
use crate::http::problem::{Kind, Problem};
use crate::service::ANONYMOUS;
use crate::service::deliveries::signature::Secret;
use crate::service::scheduler::task::{Class, Task};
use axum::http::Extensions;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A scope of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Scope {
    /// Send scenes: pictures, tiles, rays, trees, plans, trade-offs.
    Render,
    /// Submit, change and cancel jobs.
    Jobs,
    /// Read jobs, events, previews, pictures, and tiles of known scenes.
    Read,
    /// Do with the jobs and scenes of all tenants what the other scopes allow.
    Admin,
}

impl Scope {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Render, Self::Jobs, Self::Read, Self::Admin];

    /// Its name, as key files and errors have it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Render => "render",
            Self::Jobs => "jobs",
            Self::Read => "read",
            Self::Admin => "admin",
        }
    }
}

/// Concurrency limits of a tenant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Quotas {
    /// Waiting and running jobs.
    pub(crate) jobs: u32,
    /// Open event streams.
    pub(crate) streams: u32,
}

impl Default for Quotas {
    fn default() -> Self {
        Self { jobs: 1_000, streams: 64 }
    }
}

/// Where a tenant hears about its jobs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct TenantWebhook {
    /// The receiver of jobs that name none.
    pub(crate) url: Option<String>,
    /// What messages are signed with. Without it there are none.
    pub(crate) secret: Option<Secret>,
}

/// A tenant.
#[derive(Debug, Clone)]
pub(crate) struct Tenant {
    /// Its name: letters, digits and `-`.
    pub(crate) name: String,
    /// Its weight in the scheduler, at least 1.
    pub(crate) weight: u32,
    /// The scopes of this request's key.
    pub(crate) scopes: Vec<Scope>,
    /// Its concurrency limits.
    pub(crate) quotas: Quotas,
    /// Its rate limit. None: unlimited.
    pub(crate) rate_limit: Option<Arc<RateLimit>>,
    /// Where it hears about its jobs.
    pub(crate) webhook: TenantWebhook,
}

impl Tenant {
    /// The tenant of all requests if there are no keys.
    pub(crate) fn anonymous() -> Self {
        Self::named(ANONYMOUS, &Scope::ALL)
    }

    /// The same with a secret for messages about its jobs.
    pub(crate) fn with_webhook_secret(self, secret: Option<Secret>) -> Self {
        Self { webhook: TenantWebhook { url: None, secret }, ..self }
    }

    fn named(name: &str, scopes: &[Scope]) -> Self {
        let (name, scopes) = (name.to_owned(), scopes.to_vec());
        let (quotas, webhook) = (Quotas::default(), TenantWebhook::default());
        Self { name, weight: 1, scopes, quotas, rate_limit: None, webhook }
    }

    /// The tenant of a request that another front has let in.
    pub(crate) fn from_front(name: &str, weight: u32, scopes: &[Scope]) -> Self {
        Self { weight: weight.max(1), ..Self::named(name, scopes) }
    }

    /// The tenant of a request. If no middleware has set it, a tenant that may do nothing.
    pub(crate) fn of(extensions: &Extensions) -> Arc<Self> {
        extensions.get::<Arc<Self>>().map_or_else(|| Arc::new(Self::named("nobody", &[])), Arc::clone)
    }

    /// The tenant of a request, which any key has.
    pub(crate) fn required(extensions: &Extensions) -> Result<Arc<Self>, Problem> {
        let detail = "this service requires a key: send Authorization: Bearer rk_...";
        extensions.get::<Arc<Self>>().map(Arc::clone).ok_or_else(|| Problem::new(Kind::Unauthorized, detail))
    }

    /// Whether the service has no keys, so that all requests see the same.
    pub(crate) fn is_anonymous(&self) -> bool {
        self.name == ANONYMOUS
    }

    /// A task of this tenant for the scheduler.
    pub(crate) fn task(&self, class: Class) -> Task {
        Task::new(class, &self.name, self.weight)
    }

    /// Refuses what requires a scope that its key lacks.
    pub(crate) fn require(&self, scope: Scope, what: &str) -> Result<(), Problem> {
        if self.may(scope) {
            return Ok(());
        }
        let detail = format!("this key lacks the scope {}, which {what} requires", scope.name());
        Err(Problem::new(Kind::Forbidden, detail).with_scope(scope.name()))
    }

    /// Whether its key has a scope.
    pub(crate) fn may(&self, scope: Scope) -> bool {
        self.scopes.contains(&scope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_anonymous_may_do_everything_and_nobody_nothing() {
        let mut extensions = Extensions::new();
        assert!(Scope::ALL.iter().all(|scope| !Tenant::of(&extensions).may(*scope)));
        extensions.insert(Arc::new(Tenant::anonymous()));
        assert!(Scope::ALL.iter().all(|scope| Tenant::of(&extensions).may(*scope)));
    }
}
