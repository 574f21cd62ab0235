//! A scene that is ready to be rendered, with its plan and id.

use super::ids::{is_reproducible, scene_id};
use crate::service::memory_budget::Share;
use crate::service::scheduler::pool::Workers;
use strahl::film::Region;
use strahl::plan::pilot::{Effort, Pilot};
use strahl::plan::{Outline, Plan};
use strahl::render::{Cancelled, Control};
use strahl::scene::description::RenderSettings;
use strahl::scene::nff::NffOptions;
use strahl::scene::{Loaded, Scene};

/// A compiled scene. Its description is dropped, since it takes as much memory again.
#[derive(Debug)]
pub(crate) struct PreparedScene {
    /// The scene.
    pub(crate) scene: Scene,
    /// What plans of it say of its description.
    pub(crate) outline: Outline,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// Its [id](super::ids).
    pub(crate) scene_id: String,
    /// Whether the same id always means the same picture.
    pub(crate) reproducible: bool,
    /// The options that an NFF file was read with.
    pub(crate) nff: NffOptions,
    /// How long loading took.
    pub(crate) loading: Loading,
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
    /// The same with its part of the memory, of which it needs the least part now.
    pub(crate) fn with(mut self, mut share: Share) -> Self {
        share.shrink(self.bytes());
        self.share = Some(share);
        self
    }

    /// Bytes of memory it takes, kept in a cache.
    pub(crate) fn bytes(&self) -> u64 {
        let own = size_of::<Self>() - size_of::<Scene>();
        (self.scene.bytes() + self.outline.bytes() + own) as u64 + ENTRY_BYTES
    }
}

impl From<Loaded> for PreparedScene {
    fn from(Loaded { mut description, scene, nff, parse_ms, plan_ms }: Loaded) -> Self {
        let loading = Loading { parse: parse_ms, plan: plan_ms, bvh: scene.bvh_ms };
        // The plan takes the description apart.
        let scene_id = scene_id(&mut description);
        let outline = Outline::new(&mut description, &scene);
        let reproducible = is_reproducible(&description.render) && !scene.from_files && !nff.spd_counts;
        // Effects decide the number of samples if the scene does not give one, or pixels do.
        let samples = (!scene.adaptive).then_some(scene.samples);
        let render = RenderSettings { samples, ..description.render.resolved() };
        Self { outline, render, scene, scene_id, reproducible, nff, loading, share: None }
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
