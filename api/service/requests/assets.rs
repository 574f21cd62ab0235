//! Keeping and finding assets.

use super::Service;
use crate::service::assets::Sent;
use crate::service::error::Error;
use crate::service::hash::sha256;
use crate::service::memory_budget::MeteredBytes;
use std::sync::Arc;

impl Service {
    /// Keeps bytes for a tenant; if `expected` is given they have to have that SHA-256.
    pub(crate) async fn keep_asset(
        self: &Arc<Self>,
        tenant: String,
        expected: Option<String>,
        bytes: MeteredBytes,
    ) -> Result<Sent, Error> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let keep = move || {
            let hash = sha256(bytes.as_ref());
            if let Some(expected) = expected.filter(|expected| *expected != hash) {
                return Err(Error::OtherBytes { expected, hash });
            }
            let named = || service.jobs.assets();
            let has_scene = |id: &str| service.scenes.store.holds(id);
            let is_new = service.assets.keep(&tenant, &hash, bytes.as_ref(), named, has_scene)?;
            Ok(Sent { hash, is_new })
        };
        self.asset_threads.run(&owner, keep).await?
    }

    /// An asset of a tenant.
    pub(crate) async fn asset(self: &Arc<Self>, tenant: String, hash: String) -> Result<Option<MeteredBytes>, Error> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let read = move || {
            let Some(bytes) = service.assets.size(&tenant, &hash) else {
                return service.assets.check_store().map(|()| None);
            };
            service.memory.read(bytes, || Ok(service.assets.get(&tenant, &hash)))
        };
        self.asset_threads.run(&owner, read).await?
    }

    /// Bytes of an asset of a tenant.
    pub(crate) async fn asset_size(self: &Arc<Self>, tenant: String, hash: String) -> Result<Option<u64>, Error> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let look = move || match service.assets.size(&tenant, &hash) {
            None => service.assets.check_store().map(|()| None),
            found => Ok(found),
        };
        self.asset_threads.run(&owner, look).await?
    }

    /// Those of some hashes that a tenant has not sent.
    pub(crate) async fn missing_assets(
        self: &Arc<Self>,
        tenant: String,
        mut hashes: Vec<String>,
    ) -> Result<Vec<String>, Error> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let look = move || {
            hashes.retain(|hash| !service.assets.owns(&tenant, hash));
            if hashes.is_empty() { Ok(hashes) } else { service.assets.check_store().map(|()| hashes) }
        };
        self.asset_threads.run(&owner, look).await?
    }

    /// Takes back a tenant's claim on an asset; false if it has none. What a job of its own needs stays.
    pub(crate) async fn remove_asset(self: &Arc<Self>, tenant: String, hash: String) -> Result<bool, Error> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let remove = move || service.assets.remove(&tenant, &hash, || service.jobs.that_needs(&tenant, &hash));
        self.asset_threads.run(&owner, remove).await?
    }
}
