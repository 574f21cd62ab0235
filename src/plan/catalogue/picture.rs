//! How the picture is taken.

use crate::plan::explain::{Effect, State, effect, found};
use crate::plan::use_of::Uses;
use crate::scene::compile::SAMPLES_OF_CHOICES;
use crate::scene::description::{Camera, Description, Precision};

pub(in crate::plan) fn instancing(uses: &Uses) -> Effect {
    found("instancing", &uses.placed, "objects are placed, not copied", "no object is placed by a transform")
}

pub(in crate::plan) fn projection(description: &Description) -> Effect {
    let kind = description.camera.kind();
    let state = if matches!(description.camera, Camera::Pinhole(_)) { State::Off } else { State::On };
    effect("special_projection", state, format!("the camera is {kind}"), vec![format!("/camera/{kind}")])
}

/// `chooses`: whether the scene calls for choices, which decides the number of samples it does not name.
pub(in crate::plan) fn antialiasing(description: &Description, chooses: bool) -> Effect {
    let name = "antialiasing";
    let render = &description.render;
    let samples = render.samples.unwrap_or(if chooses { SAMPLES_OF_CHOICES } else { 1 });
    let (state, reason, key) = match render.antialias {
        true if samples >= 16 => (State::Removed, format!("every pixel has {samples} samples anyway"), "samples"),
        true => (State::On, "pixels that differ from a neighbour get 16 samples".to_owned(), "antialias"),
        false => (State::Off, "render.antialias is false".to_owned(), "antialias"),
    };
    effect(name, state, reason, vec![format!("/render/{key}")])
}

pub(in crate::plan) fn double_precision(description: &Description) -> Effect {
    match description.render.precision {
        Precision::Double => effect("double_precision", State::On, "asked for", vec!["/render/precision".into()]),
        Precision::Single => effect("double_precision", State::Off, "render.precision is \"single\"", Vec::new()),
    }
}
