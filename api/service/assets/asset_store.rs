//! Where assets lie: in a folder of this process, or in the store of a farm.

use crate::service::error::not_reachable;
use crate::service::is_tenant_name;
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::objects::{ObjectError, Objects};
use std::io;
use std::path::Path;
use strahl::scene::assets::is_hash;
use tokio::runtime::Handle;

/// The bytes by their SHA-256, and claims of tenants to them.
#[derive(Debug)]
pub(super) enum AssetStore {
    /// Bytes as `HASH`, claims as `HASH.TENANT`, and as `s_…` what a kept scene names.
    Folder(BlobStore),
    /// Bytes as `assets/HASH`, claims as `assets/claims/HASH/t-TENANT`. These may take their time, and other fronts change them,
    /// too.
    Store(Objects, Handle),
}

/// Whether a file of the folder may have this name.
pub(crate) fn is_name(name: &str) -> bool {
    let (hash, tenant) = name.split_once('.').map_or((name, None), |(hash, tenant)| (hash, Some(tenant)));
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
    let of_scene = name.strip_prefix("s_").is_some_and(|id| id.len() <= 64 && id.bytes().all(plain));
    of_scene || (is_hash(hash) && tenant.is_none_or(is_tenant_name))
}

impl AssetStore {
    /// A folder, and whether what is put there outlives a power cut.
    pub(super) fn folder(path: &Path, durable: bool) -> io::Result<Self> {
        Ok(Self::Folder(BlobStore::open(path, u64::MAX, BlobKind { is_name, durable })?))
    }

    /// The bytes of a hash.
    pub(super) fn get(&self, hash: &str) -> Option<Vec<u8>> {
        match self {
            Self::Folder(blobs) => Some(blobs.get(hash).ok()??.body),
            Self::Store(objects, runtime) => runtime.block_on(in_store(objects, hash, u64::MAX)),
        }
    }

    /// Fails if it cannot be known what is there.
    pub(super) fn check(&self) -> io::Result<()> {
        match self {
            Self::Folder(_) => Ok(()),
            Self::Store(objects, runtime) => runtime.block_on(objects.check()).map_err(not_reachable),
        }
    }

    /// Whether the bytes of a hash are there.
    pub(super) fn has(&self, hash: &str) -> bool {
        match self {
            Self::Folder(blobs) => blobs.has(hash),
            Self::Store(objects, runtime) => runtime.block_on(is_in_store(objects, hash)),
        }
    }

    /// Keeps bytes under their hash.
    pub(super) fn put(&self, hash: &str, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Folder(blobs) => blobs.put(hash, b"", bytes),
            Self::Store(objects, runtime) => {
                runtime.block_on(objects.put(&blob(hash), bytes.to_vec())).map_err(not_reachable)
            }
        }
    }

    /// Bytes of the asset that a tenant has a claim to.
    pub(super) fn claimed(&self, hash: &str, tenant: &str) -> Option<u64> {
        let written = match self {
            Self::Folder(blobs) => blobs.head(&format!("{hash}.{tenant}")).ok()??,
            Self::Store(objects, runtime) => {
                let found = runtime.block_on(objects.get(&claim(hash, tenant), 64));
                found.inspect_err(|error| tracing::warn!(hash, %error, "a claim to an asset cannot be read")).ok()??
            }
        };
        std::str::from_utf8(&written).ok()?.parse().ok()
    }

    /// Writes a claim to an asset of some bytes.
    pub(super) fn claim(&self, hash: &str, tenant: &str, bytes: u64) -> io::Result<()> {
        let written = bytes.to_string().into_bytes();
        match self {
            Self::Folder(blobs) => blobs.put(&format!("{hash}.{tenant}"), &written, b""),
            Self::Store(objects, runtime) => {
                runtime.block_on(objects.put(&claim(hash, tenant), written)).map_err(not_reachable)
            }
        }
    }

    /// Removes a claim.
    pub(super) fn unclaim(&self, hash: &str, tenant: &str) -> io::Result<()> {
        match self {
            Self::Folder(blobs) => {
                blobs.remove(&format!("{hash}.{tenant}"));
                Ok(())
            }
            Self::Store(objects, runtime) => {
                runtime.block_on(objects.delete(&claim(hash, tenant))).map_err(not_reachable)
            }
        }
    }

    /// Removes the bytes of a hash unless there is a claim to them.
    pub(super) fn remove_unclaimed(&self, hash: &str) -> io::Result<()> {
        match self {
            Self::Folder(blobs) => {
                let before = format!("{hash}.");
                if !blobs.names().iter().any(|name| name.starts_with(&before)) {
                    blobs.remove(hash);
                }
                Ok(())
            }
            Self::Store(objects, runtime) => runtime.block_on(remove_unclaimed(objects, hash)).map_err(not_reachable),
        }
    }

    /// The folder, in which everything can be listed.
    pub(super) fn listed(&self) -> Option<&BlobStore> {
        match self {
            Self::Folder(blobs) => Some(blobs),
            Self::Store(..) => None,
        }
    }
}

const CLAIMS: &str = "assets/claims";

fn blob(hash: &str) -> String {
    format!("assets/{hash}")
}

/// Another front may find the bytes and write a claim at the same time. It looks for the bytes once more when it has written the
/// claim, and this looks for claims once more when it has put the bytes aside, so one of the two puts them back.
async fn remove_unclaimed(objects: &Objects, hash: &str) -> Result<(), ObjectError> {
    let (claims, aside) = (format!("{CLAIMS}/{hash}"), format!("assets/leaving/{hash}"));
    if objects.has_any(&claims).await? {
        return Ok(());
    }
    objects.rename(&blob(hash), &aside).await?;
    if objects.has_any(&claims).await? {
        return objects.rename(&aside, &blob(hash)).await;
    }
    objects.delete(&aside).await
}

/// Names of tenants are no digests, so that what is read is not checked against one.
fn claim(hash: &str, tenant: &str) -> String {
    format!("{CLAIMS}/{hash}/t-{tenant}")
}

/// Whether the bytes of a hash are in the store of a farm.
pub(crate) async fn is_in_store(objects: &Objects, hash: &str) -> bool {
    let found = objects.exists(&blob(hash)).await;
    found.inspect_err(|error| tracing::warn!(hash, %error, "an asset cannot be looked for")).unwrap_or(false)
}

/// The bytes of a hash in the store of a farm.
pub(crate) async fn in_store(objects: &Objects, hash: &str, max: u64) -> Option<Vec<u8>> {
    let found = objects.get(&blob(hash), max).await;
    found.unwrap_or_else(|error| {
        tracing::warn!(hash, %error, "an asset cannot be read");
        None
    })
}
