//! Who may do what: keys, capability URLs, quotas, and which pages may ask.

mod allowance;
mod capability;
mod cors;
mod gate;
mod keys;
mod mint;
mod peer;
mod reload;

pub(crate) use allowance::Allowance;
pub(crate) use capability::{Capability, strip};
pub(crate) use cors::Origins;
pub(crate) use cors::cors;
pub(crate) use gate::{identify, require};
pub(crate) use keys::{new_key, new_signer};
pub(crate) use mint::*;
pub(crate) use peer::{Client, arrived};
pub(crate) use reload::watch;

use crate::server::tenant::Tenant;
use capability::Signers;
use keys::Keys;
use reload::KeyFile;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// What decides about a request's tenant.
#[derive(Debug)]
pub(crate) struct Access {
    /// The key file; without one everybody is anonymous.
    keys: Option<KeyFile>,
    anonymous: Arc<Tenant>,
    /// Signs capabilities where the key file names no secrets; they end with the process.
    own: Signers,
    pub(crate) origins: Origins,
}

impl Access {
    /// Reads the key file, if there is one.
    pub(crate) fn open(path: Option<&Path>, origins: Origins) -> io::Result<Self> {
        Ok(Self {
            keys: path.map(KeyFile::open).transpose()?,
            anonymous: Arc::new(Tenant::anonymous()),
            own: Signers::random()?,
            origins,
        })
    }

    /// Charges a tenant for rays that were traced for it by other means than a request. Tenants that are no longer in the
    /// key file owe nothing.
    pub(crate) fn charge(&self, tenant: &str, rays: u64) {
        let tenant = self.keys().and_then(|keys| keys.reader(tenant));
        if let Some(allowance) = tenant.as_ref().and_then(|tenant| tenant.allowance.as_ref()) {
            allowance.charge(rays, Instant::now());
        }
    }

    fn keys(&self) -> Option<Arc<Keys>> {
        self.keys.as_ref().map(KeyFile::keys)
    }
}
