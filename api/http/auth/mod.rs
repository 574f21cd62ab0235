//! Authorization: keys, capability URLs, tenants, rate limits.

pub(crate) mod capability;
pub(crate) mod client;
pub(crate) mod key_file;
pub(crate) mod keys;
pub(crate) mod rate_limit;
pub(crate) mod tenant;

pub(crate) use keys::{new_key, new_signer, new_webhook_secret};

use crate::http::problem::{Kind, Problem};
use crate::service::clock::unix_time;
use crate::service::deliveries::signature::Secret;
use crate::service::scheduler::pool::Meter;
use axum::extract::Request;
use axum::http::header;
use capability::{Capability, Signers};
use key_file::KeyFile;
use keys::Keys;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use tenant::Tenant;

/// Finds the tenant of a request.
#[derive(Debug)]
pub(crate) struct Access {
    /// The key file. Without one all requests are anonymous.
    keys: Option<KeyFile>,
    anonymous: Arc<Tenant>,
    /// Signs capabilities if the key file has no secrets. They are valid until the process ends, or in a farm as long as the
    /// broker keeps the secret.
    own: Signers,
}

/// Charges tenants for the rays that are traced for them. Tenants that are no longer in the key file owe nothing.
impl Meter for Access {
    fn traced(&self, tenant: &str, rays: u64) {
        let tenant = self.keys().and_then(|keys| keys.reader(tenant));
        if let Some(rate_limit) = tenant.as_ref().and_then(|tenant| tenant.rate_limit.as_ref()) {
            rate_limit.charge(rays, Instant::now());
        }
    }
}

impl Access {
    /// Reads the key file, if there is one. Fronts of a farm have a secret in common. Without a key file messages about jobs are
    /// signed with `webhooks`.
    pub(crate) fn open(path: Option<&Path>, of_farm: Option<Signers>, webhooks: Option<Secret>) -> io::Result<Self> {
        Ok(Self {
            keys: path.map(KeyFile::open).transpose()?,
            anonymous: Arc::new(Tenant::anonymous().with_webhook_secret(webhooks)),
            own: of_farm.map_or_else(Signers::random, Ok)?,
        })
    }

    /// Whether requests need a key.
    pub(crate) fn needs_keys(&self) -> bool {
        self.keys.is_some()
    }

    /// Units that tenants have spent here since the last call.
    pub(crate) fn spent(&self) -> BTreeMap<String, f64> {
        let Some(keys) = self.keys() else { return BTreeMap::new() };
        let spent = keys.limited().map(|(name, rate_limit)| (name.to_owned(), rate_limit.spent_here()));
        spent.filter(|(_, units)| *units > 0.0).collect()
    }

    /// A tenant has spent units at another front.
    pub(crate) fn spent_elsewhere(&self, tenant: &str, units: f64) {
        let tenant = self.keys().and_then(|keys| keys.reader(tenant));
        if let Some(rate_limit) = tenant.as_ref().and_then(|tenant| tenant.rate_limit.as_ref()) {
            rate_limit.spent_elsewhere(units, Instant::now());
        }
    }

    fn keys(&self) -> Option<Arc<Keys>> {
        self.keys.as_ref().map(KeyFile::keys)
    }

    /// The tenant of a request. None if the service needs keys and the request has none.
    pub(crate) fn tenant(&self, request: &Request) -> Result<Option<Arc<Tenant>>, Problem> {
        let keys = self.keys();
        if let Some(capability) = request.extensions().get::<Capability>() {
            let signers = keys.as_ref().and_then(|keys| keys.signers.as_ref()).unwrap_or(&self.own);
            let name = capability.check(signers, request, unix_time().as_secs())?;
            let Some(keys) = &keys else { return Ok(Some(Arc::clone(&self.anonymous))) };
            let gone = || Problem::new(Kind::Forbidden, "the tenant of this capability is no longer in the key file");
            return keys.reader(&name).ok_or_else(gone).map(Some);
        }
        let Some(keys) = keys else { return Ok(Some(Arc::clone(&self.anonymous))) };
        let Some(header) = request.headers().get(header::AUTHORIZATION) else { return Ok(None) };
        let presented = header.to_str().ok().and_then(|text| {
            let (scheme, key) = text.split_once(' ')?;
            scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
        });
        let refused = || {
            Problem::new(
                Kind::Unauthorized,
                "this key is not known here: send Authorization: Bearer and a key of this service",
            )
        };
        presented.and_then(|key| keys.tenant(key)).ok_or_else(refused).map(Some)
    }

    /// Refuses a request whose key or capability no longer opens what it did for a tenant.
    pub(crate) fn recheck(&self, tenant: &Tenant, request: &Request) -> Result<(), Problem> {
        let now = self.tenant(request)?;
        let may_all = |now: &Tenant| tenant.scopes.iter().all(|scope| now.may(*scope));
        if now.is_some_and(|now| now.name == tenant.name && may_all(&now)) {
            return Ok(());
        }
        Err(Problem::new(Kind::Forbidden, "this key has lost some of its scopes, while this was waited for"))
    }

    /// What messages about a tenant's jobs are signed with.
    pub(crate) fn webhook_secret(&self, tenant: &str) -> Option<Secret> {
        let of = |tenant: &Tenant| tenant.webhook.secret.clone();
        match self.keys() {
            Some(keys) => keys.reader(tenant).and_then(|tenant| of(&tenant)),
            None => of(&self.anonymous),
        }
    }

    /// A capability for an id of a tenant.
    pub(crate) fn sign(&self, id: &str, tenant: &str, expires: u64) -> String {
        let keys = self.keys();
        keys.as_ref().and_then(|keys| keys.signers.as_ref()).unwrap_or(&self.own).sign(id, tenant, expires)
    }
}
