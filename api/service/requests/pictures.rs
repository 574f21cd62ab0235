//! Finding or rendering pictures: in a cache, in a job, by another request for the same picture, or anew.

use super::Service;
use crate::service::error::Error;
use crate::service::memory_budget::Share;
use crate::service::pictures::cache::{MadePicture, Took};
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::pictures::passes::{PassChannel, Passes, Show, passes, show_thinned};
use crate::service::pictures::render::{self, RemoteRender, RenderSpec, Rendered};
use crate::service::pictures::report::Report;
use crate::service::pictures::spec::{Grid, PictureSpec};
use crate::service::scenes::cache::Found;
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::{Form, Key, SentScene};
use crate::service::scheduler::admission::{Done, Work};
use crate::service::scheduler::task::Task;
use data_encoding::HEXLOWER;
use std::fmt::Debug;
use std::sync::Arc;
use strahl::film::{Film, Region};
use strahl::render::{Watcher, sampling_bytes};
use strahl::scene::effects::{Entry, REFINED_SAMPLES, SceneEffects, State};
use strahl::scene::{Description, Format, Overrides, Scene};

/// Texts of at least this many bytes are hashed on a thread of their own, since hashing would delay other requests.
pub(crate) const HASHED_AT_ONCE: usize = 64 << 10;

/// The bytes of a scene in any container.
pub(crate) trait Text: AsRef<[u8]> + Debug + Send + Sync + 'static {}

impl<T: AsRef<[u8]> + Debug + Send + Sync + 'static> Text for T {}

/// A scene as it was sent, for as long as requests need it.
#[derive(Debug, Clone)]
pub(crate) struct Upload {
    text: Arc<dyn Text>,
    form: Form,
    overrides: Overrides,
    digest: Key,
    key: Key,
    hash_ms: f64,
}

impl Upload {
    /// Hashes the scene.
    pub(crate) async fn new(text: impl Text, form: Form, overrides: Overrides) -> Result<Self, Error> {
        let is_long = text.as_ref().len() >= HASHED_AT_ONCE;
        let hash = move || {
            let SentScene { digest, key, hash_ms, .. } = SentScene::new(text.as_ref(), &form, &overrides);
            Self { text: Arc::new(text), form, overrides, digest, key, hash_ms }
        };
        if !is_long {
            return Ok(hash());
        }
        let hashed = tokio::task::spawn_blocking(hash).await;
        hashed.map_err(|_| Error::Internal("the scene cannot be hashed"))
    }

    /// The scene as the scene cache takes it.
    pub(crate) fn sent(&self) -> SentScene<'_> {
        let &Self { ref text, ref form, overrides, digest, key, hash_ms } = self;
        SentScene::hashed((**text).as_ref(), form, overrides, (digest, key, hash_ms))
    }
}

/// The scene of a picture.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "there is one for each request")]
pub(crate) enum Source {
    /// A scene that was sent with the request.
    Sent(Upload),
    /// A scene that is known by the id of its image.
    Known(ImageId),
}

impl Source {
    /// The scene and its zoom. A scene that was sent is not built if the requested picture is too large.
    fn find(&self, service: &Service, work: &Work, spec: Option<&PictureSpec>) -> Result<(Found, u32), Error> {
        match self {
            Self::Sent(upload) => {
                let limits = &service.settings.answers;
                let accept = |scene: &Description| spec.map_or(Ok(()), |spec| limits.check_unbuilt(scene, spec.region));
                Ok((service.scenes.find_if(&work.workers, &upload.sent(), &accept)?, 0))
            }
            Self::Known(image) => Ok((service.known_scene(work, &image.scene)?, image.zoom)),
        }
    }

    /// The text of the scene and what it is, for nodes; none if it is not at hand.
    pub(super) fn text(&self, service: &Service) -> Option<(Vec<u8>, Format, Overrides)> {
        match self {
            Self::Sent(Upload { text, form: Form::Whole(format), overrides, .. }) => {
                Some(((**text).as_ref().to_vec(), *format, *overrides))
            }
            // The text of a variation is that of another scene and a patch.
            Self::Sent(_) => None,
            Self::Known(image) => {
                let text = service.scenes.store.get(&image.scene).ok()??;
                Some((text.to_vec(), Format::Json, Overrides::default()))
            }
        }
    }

    /// The name for single flight: the same for requests for the same picture.
    fn flight(&self, spec: &PictureSpec) -> String {
        match self {
            Self::Sent(upload) => HEXLOWER.encode(&upload.key) + &spec.suffix(),
            Self::Known(image) => spec.name(image),
        }
    }
}

/// The id of a scene's own picture, if it has one.
pub(crate) fn image_of(ready: &PreparedScene) -> Option<ImageId> {
    ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom: 0 })
}

impl Service {
    /// A picture that exists already, in a cache or in a job.
    pub(crate) async fn stored_picture(
        self: &Arc<Self>,
        image: &ImageId,
        spec: &PictureSpec,
    ) -> Option<Arc<PictureFile>> {
        if let Some(file) = self.pictures.cached(&spec.name(image)) {
            return Some(file);
        }
        // A thread is needed only if the disk has to be read.
        let by_a_job = || spec.is_whole() && self.jobs.has_picture(&image.to_string(), spec.format);
        if !self.pictures.has_folder() && !by_a_job() {
            return None;
        }
        let (service, image, spec) = (Arc::clone(self), image.clone(), *spec);
        tokio::task::spawn_blocking(move || service.read_picture(&image, &spec)).await.ok().flatten()
    }

    /// The same on this thread, which may wait for the disk.
    fn read_picture(&self, image: &ImageId, spec: &PictureSpec) -> Option<Arc<PictureFile>> {
        let name = spec.name(image);
        if let Some(file) = self.pictures.get(&name) {
            return Some(file);
        }
        let of_a_job = spec.is_whole().then(|| self.jobs.picture_of(&image.to_string(), spec.format));
        let file = Arc::new(of_a_job.flatten()?);
        self.pictures.remember(&name, &file);
        Some(file)
    }

    /// The name for single flight of a tenant's request.
    fn flight(&self, task: &Task, source: &Source, spec: &PictureSpec) -> String {
        let mut name = source.flight(spec);
        // Another tenant may not have the assets that the scene names.
        if !self.assets.is_empty() {
            name.push_str(&task.tenant);
        }
        name
    }

    /// Renders a picture, or waits for another request that renders the same one.
    pub(crate) async fn make_picture(
        self: &Arc<Self>,
        task: Task,
        source: Source,
        spec: PictureSpec,
    ) -> Result<MadePicture, Error> {
        let name = self.flight(&task, &source, &spec);
        self.make(name, task, source, spec, None).await
    }

    async fn make(
        self: &Arc<Self>,
        name: String,
        task: Task,
        source: Source,
        spec: PictureSpec,
        passes: Option<Arc<PassChannel>>,
    ) -> Result<MadePicture, Error> {
        let mut is_mine = false;
        let work = || {
            is_mine = true;
            let service = Arc::clone(self);
            async move {
                let renderer = Arc::clone(&service);
                let work = move |work: &Work| match passes {
                    None => renderer.render(work, &source, &spec, None),
                    Some(passes) => renderer.render(work, &source, &spec, Some(&|pass| passes.show(pass))),
                };
                let Done { value: (file, report, cached), queue_ms } = service.run(task, work).await?;
                Ok(MadePicture { file, took: Took::new(report.as_ref(), queue_ms, cached) })
            }
        };
        let mut made = self.pictures.flights.share(name, work).await?;
        made.took.is_shared = !is_mine;
        Ok(made)
    }

    /// Builds a scene without a picture.
    pub(crate) async fn build_scene(self: &Arc<Self>, task: Task, source: Source) -> Result<Arc<PreparedScene>, Error> {
        let service = Arc::clone(self);
        let work = move |work: &Work| source.find(&service, work, None).map(|(found, _)| found.ready);
        Ok(self.run(task, work).await?.value)
    }

    /// Pixels across and down of a picture that may be rendered. Its scene is built, and nothing is rendered.
    pub(crate) async fn size_of_picture(
        self: &Arc<Self>,
        task: Task,
        source: Source,
        spec: PictureSpec,
    ) -> Result<[u32; 2], Error> {
        let service = Arc::clone(self);
        let work = move |work: &Work| {
            let (Found { ready, .. }, zoom) = source.find(&service, work, Some(&spec))?;
            let RenderSpec { region, .. } = spec.render_spec(&ready.scene, zoom)?;
            service.settings.answers.check(region, ready.scene.samples)?;
            Ok::<_, Error>([region.width, region.height])
        };
        Ok(self.run(task, work).await?.value)
    }

    /// Memory for a picture that is made of a scene.
    pub(crate) fn room_for_picture(&self, ready: &PreparedScene, pixels: u64, each: u64) -> Result<Share, Error> {
        let mut share = self.memory.share(ready.bytes());
        let stacks = ready.scene.stack_bytes() * self.pool.threads as u64;
        let sampling = sampling_bytes(&ready.scene, pixels);
        share.grow(pixels * each + stacks + sampling + render::PICTURE_BYTES)?;
        Ok(share)
    }

    /// Coarse pictures, and then the picture. Requests for the same picture share both; one that comes while the picture is made
    /// for somebody who wanted no coarse ones gets the picture alone.
    pub(crate) fn stream_picture(
        self: &Arc<Self>,
        task: Task,
        source: Source,
        spec: PictureSpec,
    ) -> (Passes, impl Future<Output = Result<MadePicture, Error>> + Send + 'static) {
        let name = self.flight(&task, &source, &spec);
        let passes = self.pictures.passes.join(&name);
        let (seen, service) = (passes.subscribe(), Arc::clone(self));
        (seen, async move { service.make(name, task, source, spec, Some(passes)).await })
    }

    /// A picture, its report unless it existed already, and whether its scene was in the cache. Coarse pictures before it are
    /// shown to those who look on.
    fn render(
        &self,
        work: &Work,
        source: &Source,
        spec: &PictureSpec,
        show: Option<Show<'_>>,
    ) -> Result<(Arc<PictureFile>, Option<Report>, bool), Error> {
        let (Found { ready, loading, cached }, zoom) =
            source.find(self, work, Some(spec).filter(|spec| spec.grid == Grid::Level(0)))?;
        let image = ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom });
        // The same scene may have been sent in another form, or to another process.
        if let Some(file) = image.as_ref().and_then(|image| self.read_picture(image, spec)) {
            return Ok((file, None, cached));
        }
        // Tiles are many and small, so they contain no note. Their headers say the same.
        let render_spec =
            RenderSpec { note: spec.is_whole(), asked: Some(work.queued), ..spec.render_spec(&ready.scene, zoom)? };
        self.settings.answers.check(render_spec.region, ready.scene.samples)?;
        // Nobody sets it twice.
        let _ = work.expensive.set(what_is_expensive(&ready.scene, render_spec.region));
        // The passes have a third of its pixels together.
        let each = (render::PIXEL_BYTES + render_spec.layers.pixel_bytes()) * if show.is_some() { 2 } else { 1 };
        let mut share = self.room_for_picture(&ready, render_spec.region.pixels(), each)?;
        if render_spec.layers.share().is_some() {
            // A copy of the scene, in which the object shines.
            share.grow(share.bytes() + ready.bytes())?;
        }
        let ends_by_itself = ready.render.accuracy().is_budget();
        if let Some(show) = show.filter(|_| !ends_by_itself) {
            passes(&ready, &render_spec, &self.memory, &work.workers, &work.control, show)?;
        }
        let mut last = u32::MAX;
        let mut watch = show.map(|show| {
            move |film: Film, distance| {
                // Further films of a distance have the same pixels there.
                if distance < last {
                    last = distance;
                    show_thinned(&film, distance, &self.memory, show);
                }
            }
        });
        let watcher = watch.as_mut().map(|watch| watch as Watcher<'_>);
        let remote = |render_spec: &RenderSpec| self.spread(work, source, &ready, render_spec);
        let Rendered { file, report, .. } = render::make(
            work.started,
            &ready,
            loading,
            &render_spec,
            &work.workers,
            &work.control,
            watcher,
            Some(&remote).filter(|_| !ends_by_itself).map(|remote| remote as RemoteRender<'_>),
        )?;
        let name = image.as_ref().map(|image| spec.name(image));
        let meta = PictureMeta::new(image.map(|image| image.to_string()), &report, &ready.scene, spec.is_whole());
        let file = Arc::new(PictureFile::new(file, meta).with(share));
        if let Some(name) = name {
            self.pictures.put(&name, &file);
        }
        Ok((file, Some(report), cached))
    }
}

/// What makes a picture expensive, for a client whose time is over.
fn what_is_expensive(scene: &Scene, region: Region) -> String {
    let Region { width, height, .. } = region;
    let samples = match scene.samples {
        1 if scene.antialias => format!("1 sample for each, up to {REFINED_SAMPLES} at edges"),
        1 => "1 sample for each".to_owned(),
        _ if scene.adaptive => "8 to 256 samples for each".to_owned(),
        samples => format!("{samples} samples for each"),
    };
    let at_random = |entry: &&Entry| {
        entry.state == State::On && [entry.effect].into_iter().collect::<SceneEffects>().needs_sampling()
    };
    let effects: Vec<&str> = scene.effects.iter().filter(at_random).map(|entry| entry.effect.name()).collect();
    let effects = if effects.is_empty() { String::new() } else { format!(" ({})", effects.join(", ")) };
    format!("it has {width} x {height} pixels, {samples}{effects}")
}
