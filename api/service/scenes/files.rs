//! The files that scenes find: assets of their tenant, and pictures in a folder of the service.

use super::ids::BodiesDigest;
use super::prepared::PreparedScene;
use super::texture_folder::TextureFolder;
use crate::service::assets::{Assets, in_store, is_in_store};
use crate::service::error::{Error, not_reachable};
use crate::service::storage::lru_cache::LruCache;
use crate::service::storage::objects::Objects;
use std::sync::Arc;
use strahl::scene::assets::hash_of;
use strahl::scene::problem::Code;
use strahl::scene::{Description, Files, NoFiles, Problems};
use tokio::runtime::Handle;

/// Where scenes find the assets that they name.
#[derive(Debug, Default)]
pub(crate) enum AssetSource {
    /// Nowhere.
    #[default]
    None,
    /// Each tenant has its own.
    Tenants(Arc<Assets>),
    /// In the store of a farm. A front has looked whether the tenant has them.
    Store(Objects, Handle),
}

impl AssetSource {
    /// Whether a tenant is known to have all of some assets; without a tenant it may see what there is. It never waits: who is not
    /// known here is looked for when the scene is built again.
    pub(crate) fn has_all(&self, tenant: Option<&str>, hashes: &[String]) -> bool {
        match self {
            Self::None => hashes.is_empty(),
            Self::Tenants(assets) => tenant.is_none_or(|tenant| hashes.iter().all(|hash| assets.knows(tenant, hash))),
            Self::Store(..) => true,
        }
    }

    /// Why a scene is not built: if it lacks assets, that may be the store that holds them.
    pub(crate) fn reason(&self, error: Error) -> Error {
        let lacks = |problems: &Problems| problems.0.iter().any(|problem| problem.code == Code::MissingAsset);
        if !matches!(&error, Error::Scene(problems) if lacks(problems)) {
            return error;
        }
        let checked = match self {
            Self::None => Ok(()),
            Self::Tenants(assets) => assets.check_store(),
            Self::Store(objects, runtime) => {
                let checked = runtime.block_on(objects.check()).map_err(not_reachable);
                checked.map_err(|error| Error::io("assets cannot be looked for", &error))
            }
        };
        checked.err().unwrap_or(error)
    }

    fn has(&self, tenant: Option<&str>, hash: &str) -> bool {
        match (self, tenant) {
            (Self::None, _) => false,
            (Self::Tenants(assets), Some(tenant)) => assets.owns(tenant, hash),
            (Self::Tenants(assets), None) => assets.exists(hash),
            (Self::Store(objects, runtime), _) => runtime.block_on(is_in_store(objects, hash)),
        }
    }

    fn get(&self, tenant: Option<&str>, hash: &str) -> Option<Vec<u8>> {
        match self {
            Self::None => None,
            Self::Tenants(assets) => assets.read(tenant, hash),
            Self::Store(objects, runtime) => runtime.block_on(in_store(objects, hash, u64::MAX)),
        }
    }
}

/// The files of the scenes of a tenant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SceneFiles<'a> {
    /// Pictures that have no hash.
    pub(crate) folder: Option<&'a TextureFolder>,
    /// What has one.
    pub(crate) assets: &'a AssetSource,
    /// Scenes with models that are kept.
    pub(crate) kept: &'a LruCache<BodiesDigest, Arc<PreparedScene>>,
    /// The tenant, if only what is its own may be read.
    pub(crate) tenant: Option<&'a str>,
}

impl SceneFiles<'_> {
    /// A scene that is kept with the objects of another one, among which are models. Whether they are the same is yet to be
    /// looked at, and so is whether the tenant has the assets.
    pub(crate) fn with_models_of(&self, description: &Description) -> Option<Arc<PreparedScene>> {
        self.kept.get(&BodiesDigest::of(description))
    }
}

impl Files for SceneFiles<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        match (hash_of(name), self.folder) {
            (Some(hash), _) => self.assets.get(self.tenant, hash).ok_or_else(|| "is not here any more".to_owned()),
            (None, Some(folder)) => folder.read(name),
            (None, None) => NoFiles.read(name),
        }
    }

    fn has_asset(&self, hash: &str) -> bool {
        self.assets.has(self.tenant, hash)
    }
}
