//! Posted scenes of a farm: in its store, so that each front knows those that any of them has taken.

use super::ids::is_id_of_text;
use super::store::Released;
use crate::service::error::not_reachable;
use crate::service::storage::objects::{ObjectError, Objects};
use std::io;
use std::sync::Arc;
use tokio::runtime::Handle;

/// Texts as `posted/texts/SCENE`, claims as `posted/claims/SCENE/t-TENANT`. Other fronts change them, too.
#[derive(Debug)]
pub(crate) struct SharedScenes {
    objects: Objects,
    runtime: Handle,
}

impl SharedScenes {
    /// Those in the store of a farm.
    pub(crate) fn new(objects: Objects, runtime: Handle) -> Self {
        Self { objects, runtime }
    }

    /// Waits for the store. The two threads that serve connections must not: without them no answer of the store arrives.
    fn wait<T>(&self, answer: impl Future<Output = Result<T, ObjectError>>) -> io::Result<T> {
        self.runtime.block_on(answer).map_err(not_reachable)
    }

    pub(super) fn get(&self, id: &str) -> io::Result<Option<Arc<[u8]>>> {
        let text = self.wait(self.objects.get(&text_name(id), u64::MAX))?;
        Ok(text.filter(|text| is_id_of_text(id, text)).map(Arc::from))
    }

    pub(super) fn put(&self, id: &str, text: Vec<u8>) -> io::Result<()> {
        self.wait(self.objects.put(&text_name(id), text))
    }

    /// The same as [`Self::is_stored`]; not if the store does not answer.
    pub(super) fn has(&self, id: &str) -> bool {
        let found = self.is_stored(id);
        found.inspect_err(|error| tracing::warn!(id, %error, "a posted scene cannot be looked for")).unwrap_or(false)
    }

    pub(super) fn is_stored(&self, id: &str) -> io::Result<bool> {
        self.wait(self.objects.exists(&text_name(id)))
    }

    /// Writes a claim; whether there was none.
    pub(super) fn claim(&self, id: &str, tenant: &str, source: Option<Vec<u8>>) -> io::Result<bool> {
        let name = claim_name(id, tenant);
        let is_new = !self.wait(self.objects.exists(&name))?;
        if is_new || source.is_some() {
            self.wait(self.objects.put(&name, source.unwrap_or_else(|| tenant.as_bytes().to_vec())))?;
        }
        Ok(is_new)
    }

    pub(super) fn claimed(&self, id: &str, tenant: &str) -> Option<Arc<[u8]>> {
        self.wait(self.objects.get(&claim_name(id, tenant), u64::MAX)).ok()?.map(Arc::from)
    }

    pub(super) fn is_claimed(&self, id: &str, tenant: &str) -> io::Result<bool> {
        self.wait(self.objects.exists(&claim_name(id, tenant)))
    }

    /// Deletes a claim, or all of them, and with the last one the text.
    pub(super) fn release(&self, id: &str, tenant: Option<&str>) -> io::Result<Released> {
        let claims = claims_of(id);
        match tenant {
            Some(tenant) if !self.is_claimed(id, tenant)? => return Ok(Released::Unknown),
            Some(tenant) => self.wait(self.objects.delete(&claim_name(id, tenant)))?,
            None if !self.is_stored(id)? => return Ok(Released::Unknown),
            None => self.wait(self.objects.delete_all(&claims))?,
        }
        if self.wait(self.objects.has_any(&claims))? {
            return Ok(Released::Shared);
        }
        let text = self.get(id)?;
        self.wait(self.objects.delete(&text_name(id)))?;
        match text {
            Some(text) if self.wait(self.objects.has_any(&claims))? => {
                self.put(id, text.to_vec()).map(|()| Released::Shared)
            }
            _ => Ok(Released::Gone),
        }
    }
}

fn text_name(id: &str) -> String {
    format!("posted/texts/{id}")
}

fn claims_of(id: &str) -> String {
    format!("posted/claims/{id}")
}

/// Names of tenants are no digests, so that what is read is not checked against one.
fn claim_name(id: &str, tenant: &str) -> String {
    format!("{}/t-{tenant}", claims_of(id))
}
