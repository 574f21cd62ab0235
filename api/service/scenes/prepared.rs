//! A scene that is ready to be rendered, with its plan and id.

use super::ids::{BodiesDigest, is_reproducible, scene_id};
use crate::service::memory_budget::Share;
use crate::service::scheduler::pool::Workers;
use std::sync::Arc;
use strahl::camera::Window;
use strahl::film::Region;
use strahl::plan::pilot::{Effort, Pilot};
use strahl::plan::{Outline, Plan};
use strahl::render::{Cancelled, Control};
use strahl::scene::compile::Original;
use strahl::scene::description::RenderSettings;
use strahl::scene::model::Views;
use strahl::scene::nff::NffOptions;
use strahl::scene::size::description_bytes;
use strahl::scene::{Description, KnownScene, Loaded, Scene};

/// A compiled scene. Its description is dropped, since it takes as much memory again, unless variations are made of it.
#[derive(Debug)]
pub(crate) struct PreparedScene {
    /// The scene.
    pub(crate) scene: Scene,
    /// What plans of it say of its description.
    pub(crate) outline: Outline,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// Its [id](super::ids); empty if nobody asks for it.
    pub(crate) scene_id: String,
    /// Whether the same id always means the same picture.
    pub(crate) reproducible: bool,
    /// The options that an NFF file was read with.
    pub(crate) nff: NffOptions,
    /// How long loading took.
    pub(crate) loading: Loading,
    /// The hash of its objects and definitions.
    pub(super) bodies: BodiesDigest,
    /// What it was built from, and the bytes of that, if variations are made of it.
    description: Option<(Description, u64)>,
    /// The scene that it is a variation of, whose geometry it may share.
    original: Option<Arc<Self>>,
    /// How a model is seen again.
    pub(super) views: Option<Arc<Views>>,
    /// Its part of the memory, if that is limited.
    share: Option<Share>,
}

/// Milliseconds until a scene is ready. `plan` and `bvh` are 0 for a cached scene.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Loading {
    /// Reading the scene, or finding it in the cache.
    pub(crate) parse: f64,
    /// Checking and compiling it.
    pub(crate) plan: f64,
    /// Building bounding volume hierarchies.
    pub(crate) bvh: f64,
}

/// Bytes that a kept scene takes beside its own: its keys, its places in the caches, and what the allocator cannot give to
/// others. Of 8,000 small scenes each takes 11.4 kB, of which 6.5 kB are its own.
const ENTRY_BYTES: u64 = 4 << 10;

impl PreparedScene {
    /// A loaded scene; `original` is the one that it is a variation of.
    pub(crate) fn new(loaded: Loaded, original: Option<&Arc<Self>>) -> Self {
        Self::with_description(loaded, original).0
    }

    /// A loaded scene of a command that has no use for its id: to hash a large one takes a tenth of the time of its picture.
    pub(crate) fn without_id(loaded: Loaded) -> Self {
        Self::identified(loaded, None, String::new(), BodiesDigest::default()).0
    }

    /// The same, and its description.
    fn with_description(mut loaded: Loaded, original: Option<&Arc<Self>>) -> (Self, Description) {
        let description = &mut loaded.description;
        let known = original.filter(|known| known.original().is_some_and(|known| known.has_objects_of(description)));
        let bodies = known.map_or_else(|| BodiesDigest::of(description), |known| known.bodies);
        let scene_id = scene_id(description, bodies);
        Self::identified(loaded, original, scene_id, bodies)
    }

    fn identified(
        loaded: Loaded,
        original: Option<&Arc<Self>>,
        scene_id: String,
        bodies: BodiesDigest,
    ) -> (Self, Description) {
        let Loaded { mut description, scene, nff, views, parse_ms, plan_ms } = loaded;
        description.render = description.render.resolved();
        let loading = Loading { parse: parse_ms, plan: plan_ms, bvh: scene.bvh_ms };
        // The plan takes the description apart.
        let outline = Outline::new(&mut description, &scene);
        let reproducible = is_reproducible(&description.render) && !scene.from_files && !nff.spd_counts;
        // Effects decide the number of samples if the scene does not give one, or pixels do.
        let samples = (!scene.adaptive).then_some(scene.samples);
        let render = RenderSettings { samples, ..description.render };
        let original = original.cloned();
        let ready = Self {
            outline,
            render,
            scene,
            scene_id,
            reproducible,
            nff,
            loading,
            bodies,
            description: None,
            original,
            views,
            share: None,
        };
        (ready, description)
    }

    /// A scene that variations are made of, and which may be one itself.
    pub(crate) fn to_vary(loaded: Loaded, original: Option<&Arc<Self>>) -> Self {
        let (ready, description) = Self::with_description(loaded, original);
        let bytes = description_bytes(&description.whole());
        Self { description: Some((description, bytes)), ..ready }
    }

    /// The scene as variations are made of it, if they are.
    pub(crate) fn original(&self) -> Option<Original<'_>> {
        self.description.as_ref().map(|(description, _)| Original { description, scene: &self.scene })
    }

    /// The same with its part of the memory, of which it needs the least part now.
    pub(crate) fn with(mut self, mut share: Share) -> Self {
        share.shrink(self.bytes());
        self.share = Some(share);
        self
    }

    /// The scene opened as 2^zoom times its size, for questions about the pixels of that picture. It is as large as its own,
    /// which it shares.
    pub(crate) fn opened(self: &Arc<Self>, zoom: u32) -> Option<Arc<Self>> {
        if zoom == 0 {
            return Some(Arc::clone(self));
        }
        let window = Window::level(self.scene.width, self.scene.height, -(zoom as i32))?;
        Some(Arc::new(Self {
            scene: self.scene.through(&window),
            outline: self.outline.clone(),
            render: self.render,
            scene_id: self.scene_id.clone(),
            description: None,
            views: None,
            original: Some(Arc::clone(self)),
            share: None,
            ..**self
        }))
    }

    /// Bytes that a variation keeps in memory, with those of the scene that it is a variation of; none for other scenes.
    pub(crate) fn bytes_with_original(&self) -> Option<u64> {
        self.original.as_ref().map(|original| self.bytes() + original.bytes())
    }

    /// Bytes of memory it takes, kept in a cache.
    pub(crate) fn bytes(&self) -> u64 {
        let own = size_of::<Self>() - size_of::<Scene>();
        let scene = match &self.original {
            Some(original) => self.scene.bytes_beside(&original.scene),
            None => self.scene.bytes(),
        };
        let description = self.description.as_ref().map_or(0, |(_, bytes)| *bytes);
        (scene + self.outline.bytes() + own) as u64 + description + ENTRY_BYTES
    }
}

impl KnownScene for PreparedScene {
    fn kept(&self) -> Option<(&Description, &Scene)> {
        self.description.as_ref().map(|(description, _)| (description, &self.scene))
    }
}

/// The plan of a region with its estimate, and the pilot that the estimate comes from.
pub(crate) fn planned(
    ready: &PreparedScene,
    region: Region,
    workers: &Workers,
    control: &Control,
) -> Result<(Plan, Pilot), Cancelled> {
    let mut plan = ready.outline.plan(&ready.scene);
    let pilot = workers.work(|| plan.estimate(&ready.scene, region, control, Effort::QUICK))??;
    Ok((plan, pilot))
}
