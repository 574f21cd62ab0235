//! Posting, finding and deleting scenes by id.

use super::Service;
use crate::service::error::Error;
use crate::service::pictures::spec::size_of;
use crate::service::scenes::cache::Found;
use crate::service::scenes::ids::{ImageId, canonical, is_scene_id};
use crate::service::scenes::prepared::{PreparedScene, planned};
use crate::service::scenes::sent_scene::{Form, SentScene};
use crate::service::scenes::store::{Released, Source};
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Task;
use std::io;
use std::sync::Arc;
use strahl::film::Region;
use strahl::plan::estimate::Estimate;

/// A posted scene.
#[derive(Debug)]
pub(crate) struct Remembered {
    /// The scene.
    pub(crate) ready: Arc<PreparedScene>,
    /// Its picture.
    pub(crate) image: ImageId,
    /// Pixels across and down of that picture.
    pub(crate) size: [u32; 2],
    /// Estimate of rendering the scene's own picture.
    pub(crate) estimate: Estimate,
    /// Whether the tenant has not posted it before.
    pub(crate) is_new: bool,
}

/// A known image whose scene is built.
#[derive(Debug)]
pub(crate) struct OpenedImage {
    /// The image.
    pub(crate) image: ImageId,
    /// Its scene.
    pub(crate) ready: Arc<PreparedScene>,
    /// Pixels across and down.
    pub(crate) size: [u32; 2],
}

impl Service {
    /// Stores a scene for a tenant, opened as 2^zoom times its size.
    pub(crate) fn remember(
        &self,
        work: &Work,
        tenant: &str,
        sent: &SentScene<'_>,
        zoom: u32,
    ) -> Result<Remembered, Error> {
        let store = &self.scenes.store;
        let unwritten = |error: io::Error| Error::io("the scene cannot be remembered", &error);
        let ready = match self.scenes.cached(Some(tenant), &sent.key).filter(|ready| store.has(&ready.scene_id)) {
            Some(ready) => ready,
            None => {
                let mut built = self.scenes.build(&work.workers, sent, &|_| Ok(()))?;
                let (text, ready) =
                    work.workers.work(|| (canonical(&mut built.loaded.description), built.prepared()))?;
                if !ready.reproducible {
                    return Err(Error::NoIds(
                        "pictures of this scene have no id, since files or a clock decide on them: put its textures into \
                         the scene, and ask for another accuracy than time",
                    ));
                }
                if !store.has(&ready.scene_id) && !store.put(&ready.scene_id, text).map_err(unwritten)? {
                    return Err(Error::TooLarge("the scene is larger than the store of scenes (known_scene_bytes)"));
                }
                self.scenes.keep(sent.key, ready)
            }
        };
        self.scenes.note(tenant, &ready);
        let size = size_of(&ready.scene, zoom).ok_or_else(|| {
            Error::OutOfRange(
                "opened this large, neighboring pixels have the same rays: ask for a smaller zoom, or for \
                 render.precision double"
                    .into(),
            )
        })?;
        let whole = Region::whole(ready.scene.width, ready.scene.height);
        let (plan, _) = planned(&ready, whole, &work.workers, &work.control)?;
        let source = match sent.form {
            Form::Whole(format) => Some(Source { format: *format, text: sent.text }),
            Form::Variation(_) => None,
        };
        self.assets.note_scene(&ready.scene_id, &ready.scene.assets, |id| store.holds(id));
        let is_new = store.claim(&ready.scene_id, tenant, source).map_err(unwritten)?;
        // It may have been deleted with the last claim before this one.
        if !store.has(&ready.scene_id) {
            store.put(&ready.scene_id, self.canonical_text(work, sent)?).map_err(unwritten)?;
        }
        let image = ImageId { scene: ready.scene_id.clone(), zoom };
        let estimate = plan.estimate.ok_or(Error::Internal("the scene has no estimate"))?;
        Ok(Remembered { ready, image, size, estimate, is_new })
    }

    /// The scene of an id, if it was posted or if a job renders it.
    pub(crate) fn known_scene(&self, work: &Work, id: &str) -> Result<Found, Error> {
        if let Some(spec) = self.jobs.spec_of(id, None).filter(|_| !self.scenes.store.has(id))
            && let Some(text) = self.jobs.scene(&spec.scene)?
        {
            let form = Form::Whole(spec.format);
            return self.scenes.find(&work.workers, &SentScene::known(text.as_ref(), &form, &spec.settings));
        }
        self.scenes.find_known(&work.workers, id)
    }

    /// The canonical text of the scene of an id, if the owner has sent it, or for anybody.
    pub(crate) async fn scene_text(
        self: &Arc<Self>,
        task: Task,
        id: String,
        owner: Option<String>,
    ) -> Result<Arc<[u8]>, Error> {
        let stored = {
            let (service, id, owner) = (Arc::clone(self), id.clone(), owner.clone());
            let read = move || {
                let store = &service.scenes.store;
                let may_read = is_scene_id(&id) && (owner.is_none() || store.is_known(&id, owner.as_deref())?);
                if may_read { store.get(&id) } else { Ok(None) }
            };
            self.storage_threads.run(&task.tenant, read).await?
        };
        if let Some(text) = stored.map_err(|error| Error::io("the stored scene cannot be read", &error))? {
            return Ok(text);
        }
        let service = Arc::clone(self);
        let of_a_job = move |work: &Work| {
            let unknown = || Error::UnknownScene(id.clone());
            let spec = service.jobs.spec_of(&id, owner.as_deref()).ok_or_else(unknown)?;
            let text = service.jobs.scene(&spec.scene)?.ok_or_else(unknown)?;
            let form = Form::Whole(spec.format);
            service.canonical_text(work, &SentScene::known(text.as_ref(), &form, &spec.settings))
        };
        Ok(self.run(task, of_a_job).await?.value.into())
    }

    /// What a tenant's claim to a scene holds, which may be the text that it has sent.
    pub(crate) async fn scene_claim(self: &Arc<Self>, id: String, tenant: String) -> Option<Arc<[u8]>> {
        let (service, owner) = (Arc::clone(self), tenant.clone());
        let read = move || is_scene_id(&id).then(|| service.scenes.store.claimed(&id, &tenant)).flatten();
        self.storage_threads.run(&owner, read).await.ok().flatten()
    }

    /// The canonical text of a scene that was sent.
    pub(super) fn canonical_text(&self, work: &Work, sent: &SentScene<'_>) -> Result<Vec<u8>, Error> {
        let mut built = self.scenes.build(&work.workers, sent, &|_| Ok(()))?;
        Ok(work.workers.work(|| canonical(&mut built.loaded.description))?)
    }

    /// Whether an owner has sent a scene, or anybody. This may wait for the store.
    fn knows(&self, id: &str, owner: Option<&str>) -> Result<bool, Error> {
        let unread = |error: io::Error| Error::io("the stored scene cannot be read", &error);
        Ok(is_scene_id(id) && self.scenes.store.is_known(id, owner).map_err(unread)?)
    }

    /// Whether an owner has sent a scene, or anybody.
    pub(crate) async fn is_known_scene(self: &Arc<Self>, id: String, owner: Option<String>) -> Result<bool, Error> {
        let (service, tenant) = (Arc::clone(self), owner.clone().unwrap_or_default());
        self.storage_threads.run(&tenant, move || service.knows(&id, owner.as_deref())).await?
    }

    /// How a variation of a scene is sent, for an owner who may read the scene. This may wait for the store.
    pub(crate) fn variation_of(&self, id: &str, owner: Option<&str>) -> Result<Form, Error> {
        if self.knows(id, owner)? {
            Ok(Form::Variation(id.to_owned()))
        } else {
            Err(Error::UnknownScene(id.to_owned()))
        }
    }

    /// Releases a tenant's claim on a scene, or all claims. Without claims the scene and its pictures are deleted.
    pub(crate) async fn forget_scene(self: &Arc<Self>, id: String, owner: Option<String>) -> Result<Released, Error> {
        // Operators may forget those of all.
        let (service, tenant) = (Arc::clone(self), owner.clone().unwrap_or_default());
        let release = move || {
            if !is_scene_id(&id) {
                return Ok(Released::Unknown);
            }
            let released = service.scenes.store.release(&id, owner.as_deref());
            let released = released.map_err(|error| Error::io("the scene cannot be deleted", &error))?;
            if released == Released::Gone {
                service.scenes.forget(&id);
                service.pictures.forget(&format!("i_{}_", &id[2..]));
            }
            Ok(released)
        };
        self.storage_threads.run(&tenant, release).await?
    }

    /// Opens an image, and builds its scene if it is not in the cache.
    pub(crate) async fn open_image(self: &Arc<Self>, task: Task, image: ImageId) -> Result<OpenedImage, Error> {
        let ready = match self.scenes.cached_known(&image.scene) {
            Some(ready) => ready,
            None => {
                let (service, id) = (Arc::clone(self), image.scene.clone());
                self.run(task, move |work| Ok::<_, Error>(service.known_scene(work, &id)?.ready)).await?.value
            }
        };
        let size = size_of(&ready.scene, image.zoom).ok_or_else(|| Error::UnknownScene(image.scene.clone()))?;
        Ok(OpenedImage { image, ready, size })
    }
}
