//! A scene ready to be rendered, and what every answer about it says.

use strahl::plan::explain::{Explanation, explain};
use strahl::scene::description::RenderSettings;
use strahl::scene::{Loaded, Scene};

/// A scene without its description, which would take as much memory again.
#[derive(Debug)]
pub(crate) struct Ready {
    /// The scene.
    pub(crate) scene: Scene,
    /// Which effects it calls for.
    pub(crate) plan: Explanation,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// Whether an NFF file was read as two-sided.
    pub(crate) two_sided: bool,
    /// Whether an NFF file was read by the SPD's counting rules.
    pub(crate) spd_counts: bool,
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

impl From<Loaded> for Ready {
    fn from(Loaded { description, scene, two_sided, spd_counts, parse_ms, plan_ms }: Loaded) -> Self {
        let loading = Loading { parse: parse_ms, plan: plan_ms, bvh: scene.bvh_ms };
        // What the scene calls for decides the number it does not name.
        let render = RenderSettings { samples: Some(scene.samples), ..description.render };
        Self { plan: explain(&description), render, scene, two_sided, spd_counts, loading }
    }
}
