//! Alpha: the share of each pixel that is not background.
//!
//! It is one less the light of a white background that reaches the camera directly or through bodies (Porter and Duff 1984,
//! Smith and Blinn 1996: the difference of the picture before white and before black). That light is a picture of its own, by
//! the same samples, of rays that light and mirror nothing. So all ways to finish a picture have the same alpha, but
//! for antialiasing of one that may be stopped: there colours decide which pixels get more samples.

use super::{Picture, RenderOptions, render_seen};
use crate::camera::Window;
use crate::control::{Cancelled, Control};
use crate::film::Region;
use crate::scene::Scene;
use crate::trace::counts::RayCounts;

/// The alpha of a region, row by row, and its rays; empty where the background is opaque.
pub(super) fn alpha(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    options: RenderOptions,
) -> Result<(Vec<f32>, RayCounts), Cancelled> {
    let Some(matte) = scene.matte() else { return Ok(Default::default()) };
    let Picture { film, rays, .. } = render_seen(&matte, window, region, control, options)?;
    Ok((of_clear(&film.pixels), rays))
}

/// The alpha of pixels that see so much of a white background.
pub(super) fn of_clear(pixels: &[[f32; 3]]) -> Vec<f32> {
    pixels.iter().map(|clear| (1.0 - clear.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0)).collect()
}
