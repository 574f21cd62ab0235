//! Views of models: the first one is kept with its description, and each other view of the same file is a variation of it. Then
//! nothing is read, decoded and built again.

use super::cache::{Accept, Built, SceneCache, Spent};
use super::load_memory::LoadMemory;
use super::prepared::PreparedScene;
use super::sent_scene::{Form, Key, SentScene};
use crate::service::error::Error;
use crate::service::memory_budget::Share;
use crate::service::scheduler::pool::Workers;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use strahl::scene::model::ModelOptions;
use strahl::scene::{Description, Format, Loaded};

/// Bytes of the longest model that is kept with its description, which takes as much memory again as the built scene.
const KEPT: usize = 32 << 20;

/// What views of a model have in common, and whether they have a floor.
pub(super) type ModelKey = (Key, bool);

impl SentScene<'_> {
    /// A hash of all that views of a model have in common; none for what is no model.
    pub(super) fn model_key(&self) -> Option<Key> {
        let Form::Whole(format) = self.form else { return None };
        let common = ModelOptions { view: None, camera: None, light: None, around: None, ..self.overrides.model };
        let said = format!("{format:?} {common:?}\n");
        let hash = || Sha256::new().chain_update(said).chain_update(self.digest).finalize().into();
        (format.is_model() && self.text.len() <= KEPT).then(hash)
    }
}

impl SceneCache {
    /// A view of a model: of one that is kept, or of one that is read.
    pub(super) fn view(
        &self,
        workers: &Workers,
        sent: &SentScene<'_>,
        format: Format,
        key: Key,
        accept: Accept<'_>,
    ) -> Result<Built, Error> {
        let known = [true, false].map(|has_floor| self.models.get(&(key, has_floor)));
        for base in known.into_iter().flatten() {
            if let Some((loaded, share)) = self.seen_again(workers, sent, &base, accept)? {
                return Ok(Built { loaded, original: Some(base), share });
            }
        }
        let first = self.load(workers, sent, format, accept)?;
        let Some(views) = first.loaded.views.as_ref().filter(|_| !first.loaded.scene.from_files) else {
            return Ok(first);
        };
        let has_floor = views.has_floor(&first.loaded.description);
        let spent = Spent::of(&first.loaded);
        let base = Arc::new(workers.work(|| first.into_original())?);
        let again = self.seen_again(workers, sent, &base, accept)?;
        let (loaded, share) = again.ok_or(Error::Internal("a view of a model is not seen again"))?;
        let bytes = base.bytes();
        drop(self.models.put((key, has_floor), Arc::clone(&base), bytes));
        Ok(Built { loaded: spent.on(loaded), original: Some(base), share })
    }

    /// A view as a variation of another one; none if only one of the two has a floor.
    fn seen_again(
        &self,
        workers: &Workers,
        sent: &SentScene<'_>,
        base: &PreparedScene,
        accept: Accept<'_>,
    ) -> Result<Option<(Loaded, Share)>, Error> {
        let files = self.files(sent.owner(workers));
        let memory = LoadMemory::new(&files, self.memory.share(sent.text.len() as u64));
        let again = || {
            let lost = Error::Internal("a view of a model has no description");
            let (original, views) = (base.original().ok_or(lost.clone())?, base.views.as_ref().ok_or(lost)?);
            let accept = |description: &Description| {
                accept(description)?;
                memory.take(original.building_bytes(description))
            };
            let loaded = views.again(original, &sent.overrides, &memory, &accept);
            memory.refusal()?;
            loaded.map_err(Error::from)
        };
        let loaded = workers.work(again)??;
        Ok(loaded.map(|loaded| (loaded, memory.into_share())))
    }
}
