//! One file for each command.

mod config;
mod explain;
mod healthcheck;
mod import;
mod interrupt;
mod key;
mod map;
mod openapi;
mod output;
mod progress;
mod rays;
mod render;
mod schema;
mod tradeoff;
mod tree;
mod validate;

use crate::cli::Command;
use crate::failure::Failure;
use crate::service::scheduler::pool::{Pool, Workers};
use std::sync::Arc;
use strahl::film::Region;
use strahl::render::Control;
use strahl::scene::Scene;

/// Runs a command.
pub(crate) fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Rays(args) => rays::run(&args),
        Command::Tree(args) => tree::run(&args),
        Command::Map(args) => map::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Import(args) => import::run(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Schema => schema::run(),
        Command::Openapi => openapi::run(),
        Command::Config(command) => config::run(&command),
        Command::Key(command) => key::run(&command),
        Command::Serve(args) => crate::http::run(&args),
        Command::Healthcheck(args) => healthcheck::run(&args),
    }
}

/// Starts the threads that render.
pub(crate) fn start_pool(threads: Option<u64>) -> Result<Arc<Pool>, Failure> {
    Pool::start(threads).map_err(|error| Failure::Input(format!("the rendering threads cannot be started: {error}")))
}

/// Starts them for one piece of work after the other, which ends when `control` is cancelled.
fn start_workers(threads: Option<u64>, control: &Arc<Control>) -> Result<Workers, Failure> {
    Ok(Workers::alone(start_pool(threads)?, Arc::clone(control)))
}

/// The region asked for, or the whole picture.
fn region_of(scene: &Scene, region: Option<Region>) -> Result<Region, Failure> {
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
