//! The catalogue of effects: each against exact answers or statistics, in both precisions, and gone without a trace where a
//! scene does not call for it.
#![allow(clippy::disallowed_methods, reason = "expected values come from another library than strahl's")]

mod absorption;
mod agreement;
mod bumps;
mod channels;
mod checkers;
mod clearcoat;
mod combined;
mod convergence;
mod distant_lights;
mod emission;
mod environment;
mod environment_light;
mod faithful;
mod film;
mod fog;
mod fresnel;
mod furnaces;
mod metallic_roughness;
mod motion;
mod panes;
mod rooms;
mod roulette;
mod shadow_catcher;
mod soft_highlights;
mod textures;

use serde_json::{Value, json};
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Control, Picture, render};
use strahl::scene::compile::Precise;
use strahl::scene::effects::{Effect, SceneEffects};
use strahl::scene::{Format, Overrides, Scene, load};

/// Loads a scene in a precision.
fn scene(mut description: Value, precision: &str) -> Scene {
    description["render"]["precision"] = json!(precision);
    match load(description.to_string().as_bytes(), Format::Json, &Overrides::default()) {
        Ok(loaded) => loaded.scene,
        Err(problems) => panic!("{problems}\n{description:#}"),
    }
}

/// Renders the whole picture.
fn picture(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

/// Linear pixels of a description, row by row.
fn pixels(description: Value, precision: &str) -> Vec<[f32; 3]> {
    picture(&scene(description, precision)).film.pixels
}

/// The effects that are on.
fn effects(description: &Value) -> SceneEffects {
    match scene(description.clone(), "double").world {
        Precise::Double(world) => world.effects,
        Precise::Single(world) => world.effects,
    }
}

/// What is wrong with a description, as pointers.
fn problems(description: &Value) -> Vec<String> {
    match load(description.to_string().as_bytes(), Format::Json, &Overrides::default()) {
        Ok(_) => Vec::new(),
        Err(problems) => problems.0.into_iter().map(|problem| problem.pointer).collect(),
    }
}
