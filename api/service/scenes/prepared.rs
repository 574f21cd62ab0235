//! A scene ready to be rendered, and what every answer about it says.

use super::ids::{is_reproducible, scene_id};
use crate::service::scheduler::pool::Workers;
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::pilot::{Effort, Pilot};
use strahl::render::{Cancelled, Control};
use strahl::scene::description::RenderSettings;
use strahl::scene::nff::NffOptions;
use strahl::scene::{Loaded, Scene};

/// A scene without its description, which would take as much memory again.
#[derive(Debug)]
pub(crate) struct PreparedScene {
    /// The scene.
    pub(crate) scene: Scene,
    /// What rendering it means.
    pub(crate) plan: Plan,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// The scene's name ([`identity`](super::ids)).
    pub(crate) scene_id: String,
    /// Whether the same name always means the same picture.
    pub(crate) reproducible: bool,
    /// The options that an NFF file was read with.
    pub(crate) nff: NffOptions,
    /// How long it took.
    pub(crate) loading: Loading,
}

/// Milliseconds until a scene is ready; plan and bvh take 0 for one that was ready before.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Loading {
    /// Reading the scene, or recognising it.
    pub(crate) parse: f64,
    /// Checking and compiling it.
    pub(crate) plan: f64,
    /// Building bounding volume hierarchies.
    pub(crate) bvh: f64,
}

impl From<Loaded> for PreparedScene {
    fn from(Loaded { mut description, scene, nff, parse_ms, plan_ms }: Loaded) -> Self {
        let loading = Loading { parse: parse_ms, plan: plan_ms, bvh: scene.bvh_ms };
        // The plan takes the description apart.
        let scene_id = scene_id(&mut description);
        let plan = Plan::new(&mut description, &scene);
        let reproducible = is_reproducible(&description.render) && !scene.from_files && !nff.spd_counts;
        // What the scene calls for decides the number it does not name.
        let render = RenderSettings { samples: Some(scene.samples), ..description.render.resolved() };
        Self { plan, render, scene, scene_id, reproducible, nff, loading }
    }
}

/// The plan of a region, with what it is expected to take, and the pilot that says so.
pub(crate) fn planned(
    ready: &PreparedScene,
    region: Region,
    workers: &Workers,
    control: &Control,
) -> Result<(Plan, Pilot), Cancelled> {
    let mut plan = ready.plan.clone();
    let pilot = workers.work(|| plan.estimate(&ready.scene, region, control, Effort::QUICK))??;
    Ok((plan, pilot))
}
