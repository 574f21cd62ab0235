//! The rays of a pixel drawn into a rendered picture.

use crate::service::scheduler::pool::Workers;
use strahl::film::{FileFormat, Region, encode};
use strahl::inspect::overlay::Overlay;
use strahl::inspect::tree::Tree;
use strahl::render::{Cancelled, Control, render};
use strahl::scene::Scene;

/// Bytes of memory for each pixel beside those of the picture: its file once more, as text.
pub(crate) const PIXEL_BYTES: u64 = 8;

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OverlaySpec {
    /// Eye and target of another camera that sees the rays.
    pub(crate) seen_from: Option<[[f64; 3]; 2]>,
    /// Whether the picture is rendered.
    pub(crate) picture: bool,
    /// All samples of the pixel instead of the first.
    pub(crate) all_samples: bool,
}

/// Renders the picture, if it is wanted, and draws the rays. `seen_from` is the scene with the other camera, if there is one.
pub(crate) fn draw(
    tree: Tree,
    scene: &Scene,
    seen_from: Option<&Scene>,
    spec: OverlaySpec,
    workers: &Workers,
    control: &Control,
) -> Result<String, Cancelled> {
    workers.work(|| {
        let seen_by = seen_from.unwrap_or(scene);
        let region = Region::whole(seen_by.width, seen_by.height);
        let picture =
            if spec.picture { Some(encode(&render(seen_by, region, control)?.film, FileFormat::Png8)) } else { None };
        let OverlaySpec { all_samples, .. } = spec;
        let tree = &tree.drawn(all_samples);
        Overlay { tree, scene, seen_from, picture: picture.as_deref(), all_samples }.draw(control)
    })?
}
