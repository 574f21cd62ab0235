//! What surfaces look like.

use crate::plan::explain::{Effect, State, by_material, effect, found};
use crate::plan::use_of::Uses;
use crate::scene::description::{Description, Diffuse, Material};
use crate::scene::problem::push_token;

/// A pattern of diffuse or ambient colours; removed if none that a body has `shows` anything but one colour.
fn pattern(
    name: &'static str,
    description: &Description,
    uses: &Uses,
    asks: impl Fn(&Diffuse) -> bool,
    shows: impl Fn(&Diffuse) -> bool,
    on: &str,
    off: &str,
) -> Effect {
    let of = |test: &dyn Fn(&Diffuse) -> bool, m: &Material| test(&m.diffuse) || m.ambient.as_ref().is_some_and(test);
    let asked = by_material(name, description, uses, "diffuse", |m| of(&asks, m), on, off);
    let shown = by_material(name, description, uses, "diffuse", |m| of(&shows, m), on, off);
    if asked.state == State::On && shown.state != State::On {
        return effect(name, State::Removed, "its two colours are the same", asked.because);
    }
    if shown.state == State::On { shown } else { asked }
}

pub(in crate::plan) fn checker(description: &Description, uses: &Uses) -> Effect {
    let asks = |d: &Diffuse| matches!(d, Diffuse::Checker(_));
    let shows = |d: &Diffuse| matches!(d, Diffuse::Checker(c) if c.a != c.b);
    pattern(
        "checker_texture",
        description,
        uses,
        asks,
        shows,
        "colours depend on the place",
        "no colour is a checkerboard",
    )
}

pub(in crate::plan) fn gradient(description: &Description, uses: &Uses) -> Effect {
    let asks = |d: &Diffuse| matches!(d, Diffuse::Gradient(_));
    let shows = |d: &Diffuse| matches!(d, Diffuse::Gradient(g) if g.a != g.b);
    let (on, off) = ("colours change from point to point", "no colour is a gradient");
    pattern("gradient_texture", description, uses, asks, shows, on, off)
}

pub(in crate::plan) fn noise(description: &Description, uses: &Uses) -> Effect {
    let asks = |d: &Diffuse| matches!(d, Diffuse::Noise(_));
    let shows = |d: &Diffuse| matches!(d, Diffuse::Noise(n) if n.a != n.b);
    pattern("noise_texture", description, uses, asks, shows, "colours are clouds of noise", "no colour is noise")
}

pub(in crate::plan) fn images(description: &Description, uses: &Uses) -> Effect {
    let calls = |d: &Diffuse| matches!(d, Diffuse::Image(_));
    let (on, off) = ("pictures lie on surfaces, filtered by the footprint of each ray", "no colour is a picture");
    pattern("image_texture", description, uses, calls, calls, on, off)
}

pub(in crate::plan) fn bumps(description: &Description, uses: &Uses) -> Effect {
    let calls = |m: &Material| m.bump.as_ref().is_some_and(|bump| bump.height > 0.0);
    let flat = |m: &Material| m.bump.as_ref().is_some_and(|bump| bump.height == 0.0);
    let effect_of = by_material(
        "bump_mapping",
        description,
        uses,
        "bump",
        calls,
        "surfaces are lit as if they were rough",
        "no material has bumps",
    );
    if effect_of.state != State::Off {
        return effect_of;
    }
    let flat = description.materials.iter().filter(|(_, m)| flat(m));
    let flat: Vec<String> = flat.map(|(name, _)| push_token(&push_token("/materials", name), "bump")).collect();
    if flat.is_empty() { effect_of } else { effect("bump_mapping", State::Removed, "all bumps have height 0", flat) }
}

pub(in crate::plan) fn normal_maps(description: &Description, uses: &Uses) -> Effect {
    let calls = |m: &Material| m.normal_map.is_some();
    let (on, off) = ("pictures tilt the normals of surfaces", "no material has a normal map");
    by_material("normal_mapping", description, uses, "normal_map", calls, on, off)
}

pub(in crate::plan) fn smooth_normals(uses: &Uses) -> Effect {
    found("smooth_normals", &uses.smooth, "meshes interpolate their normals", "no mesh has normals")
}
