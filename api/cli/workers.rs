//! The threads that render, and the part of the picture that they render, as the flags say.

use super::failure::Failure;
use crate::service::scheduler::pool::{Pool, Workers};
use std::sync::Arc;
use strahl::film::Region;
use strahl::render::Control;
use strahl::scene::Scene;

/// Starts the threads that render.
pub(crate) fn start_pool(threads: Option<u64>) -> Result<Arc<Pool>, Failure> {
    Pool::start(threads).map_err(|error| Failure::Input(format!("the rendering threads cannot be started: {error}")))
}

/// Starts them for one piece of work after the other, which ends when `control` is cancelled.
pub(super) fn start_workers(threads: Option<u64>, control: &Arc<Control>) -> Result<Workers, Failure> {
    Ok(Workers::alone(start_pool(threads)?, Arc::clone(control)))
}

/// The region asked for, or the whole picture.
pub(super) fn region_of(scene: &Scene, region: Option<Region>) -> Result<Region, Failure> {
    let Scene { width, height, .. } = *scene;
    let region = region.unwrap_or_else(|| Region::whole(width, height));
    if region.fits(width, height) {
        Ok(region)
    } else {
        Err(Failure::Usage(format!(
            "--region {},{},{},{} does not lie inside the picture of {width} x {height} pixels",
            region.x, region.y, region.width, region.height
        )))
    }
}
