//! Who may do what: keys, capability URLs, quotas, and which pages may ask.

mod allowance;
mod capability;
mod cors;
mod gate;
mod keys;
mod mint;
mod reload;

pub(super) use allowance::{Allowance, Cost};
pub(super) use capability::{Capability, strip};
pub(crate) use cors::Origins;
pub(super) use cors::cors;
pub(super) use gate::{identify, require};
pub(crate) use keys::{new_key, new_signer};
pub(super) use mint::*;
pub(super) use reload::watch;

use super::tenant::Tenant;
use capability::Signers;
use keys::Keys;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

/// What decides about a request's tenant.
#[derive(Debug)]
pub(super) struct Access {
    /// The key file and what it said last; without one everybody is anonymous.
    keys: Option<(PathBuf, RwLock<Arc<Keys>>)>,
    anonymous: Arc<Tenant>,
    /// Signs capabilities where the key file names no secrets; they end with the process.
    own: Signers,
    pub(super) origins: Origins,
}

impl Access {
    /// Reads the key file, if there is one.
    pub(super) fn open(path: Option<&Path>, origins: Origins) -> io::Result<Self> {
        let read = |path: &Path| {
            let keys = Keys::read(&std::fs::read_to_string(path)?, None).map_err(io::Error::other)?;
            Ok::<_, io::Error>((path.to_owned(), RwLock::new(Arc::new(keys))))
        };
        Ok(Self {
            keys: path.map(read).transpose()?,
            anonymous: Arc::new(Tenant::anonymous()),
            own: Signers::random()?,
            origins,
        })
    }

    fn keys(&self) -> Option<Arc<Keys>> {
        // A panic while swapping one pointer for another leaves one of the two.
        self.keys.as_ref().map(|(_, keys)| Arc::clone(&keys.read().unwrap_or_else(PoisonError::into_inner)))
    }
}
