//! Who asks: the tenant a request belongs to, what it may do, and how much of it.
//!
//! A middleware puts an `Arc<Tenant>` into each request's extensions; [`Tenant::of`] takes it out. Without keys everybody
//! is the tenant "anonymous" and may do everything.

use super::rate_limit::RateLimit;
use crate::service::scheduler::task::{Class, Task};
use axum::http::Extensions;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A kind of thing that a key may allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Scope {
    /// Send scenes and get an answer at once: pictures, tiles, rays, trees, plans, trade-offs.
    Render,
    /// Submit, change and cancel jobs.
    Jobs,
    /// Look at what is there: jobs, events, previews, pictures, tiles of known scenes.
    Read,
    /// What concerns the service as a whole.
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

/// How much a tenant may have at one time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Quotas {
    /// Jobs that wait or run.
    pub(crate) jobs: u32,
    /// Open event streams.
    pub(crate) streams: u32,
}

impl Default for Quotas {
    fn default() -> Self {
        Self { jobs: 1_000, streams: 64 }
    }
}

/// Who asks.
#[derive(Debug, Clone)]
pub(crate) struct Tenant {
    /// What it is called: letters, digits, `-` and `_`.
    pub(crate) name: String,
    /// Its share of the machine beside other tenants' weights, at least 1.
    pub(crate) weight: u32,
    /// What this request's key allows.
    pub(crate) scopes: Vec<Scope>,
    /// How much it may have at one time.
    pub(crate) quotas: Quotas,
    /// How much it may ask for in a minute; without one, as much as it likes.
    pub(crate) rate_limit: Option<Arc<RateLimit>>,
}

impl Tenant {
    /// Everybody, where there are no keys.
    pub(crate) fn anonymous() -> Self {
        Self::named("anonymous", &Scope::ALL)
    }

    fn named(name: &str, scopes: &[Scope]) -> Self {
        let (name, scopes) = (name.to_owned(), scopes.to_vec());
        Self { name, weight: 1, scopes, quotas: Quotas::default(), rate_limit: None }
    }

    /// Whose request this is. Where no middleware has said so, nobody's: a tenant that may do nothing.
    pub(crate) fn of(extensions: &Extensions) -> Arc<Self> {
        extensions.get::<Arc<Self>>().map_or_else(|| Arc::new(Self::named("nobody", &[])), Arc::clone)
    }

    /// Whether there are no keys, so that everybody sees the same.
    pub(crate) fn is_anonymous(&self) -> bool {
        self.name == "anonymous"
    }

    /// A task of its own for the scheduler.
    pub(crate) fn task(&self, class: Class) -> Task {
        Task::new(class, &self.name, self.weight)
    }

    /// Whether its key allows this.
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
