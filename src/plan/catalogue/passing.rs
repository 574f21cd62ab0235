//! What mirrors, and what passes through bodies.

use crate::plan::explain::{Effect, State, by_material, effect, found};
use crate::plan::use_of::Uses;
use crate::scene::description::{Accuracy, Description, Fresnel, Material};

/// Why nothing beyond the camera rays is followed, if so.
pub(in crate::plan) fn cut_off(description: &Description) -> Option<&'static str> {
    if description.render.max_depth == Some(1) {
        Some("max_depth is 1: only camera rays are followed")
    } else if matches!(description.render.accuracy(), Accuracy::Fixed(_)) && description.render.fixed_weight() >= 1.0 {
        Some("min_weight is 1: no ray is heavy enough to be followed")
    } else {
        None
    }
}

pub(in crate::plan) fn reflection(description: &Description, uses: &Uses) -> Effect {
    let name = "reflection";
    let effect_of = by_material(
        name,
        description,
        uses,
        "reflection",
        |m| m.reflection.0.max_element() > 0.0 || m.fresnel == Fresnel::Conductor,
        "surfaces mirror their surroundings",
        "reflection is 0 everywhere",
    );
    match cut_off(description) {
        Some(why) if effect_of.state == State::On => {
            effect(name, State::Removed, why, vec!["/render/max_depth".into()])
        }
        _ => effect_of,
    }
}

pub(in crate::plan) fn transmission(description: &Description, uses: &Uses) -> Effect {
    let name = "transmission";
    let effect_of = by_material(
        name,
        description,
        uses,
        "transmission",
        |m| m.transmission.0.max_element() > 0.0,
        "light passes through bodies",
        "transmission is 0 everywhere",
    );
    match cut_off(description) {
        Some(why) if effect_of.state == State::On => {
            effect(name, State::Removed, why, vec!["/render/max_depth".into()])
        }
        _ => effect_of,
    }
}

pub(in crate::plan) fn refraction(description: &Description, uses: &Uses) -> Effect {
    let name = "refraction";
    let clear = |m: &Material| m.transmission.0.max_element() > 0.0;
    let (on, off) = ("light bends by Snell's law", "nothing transmits light");
    let effect_of = by_material(name, description, uses, "ior", clear, on, off);
    if effect_of.state != State::On || cut_off(description).is_some() {
        return effect(name, State::Off, off, Vec::new());
    }
    let bends = |m: &Material| clear(m) && m.ior != 1.0;
    let bending = by_material(name, description, uses, "ior", bends, on, off);
    if bending.state == State::On {
        return bending;
    }
    effect(name, State::Removed, "all indices of refraction are 1: nothing bends", effect_of.because)
}

pub(in crate::plan) fn fresnel(description: &Description, uses: &Uses) -> Effect {
    let name = "fresnel";
    let asks = |m: &Material| m.fresnel != Fresnel::None;
    let on = "reflection and transmission depend on the angle of incidence";
    let effect_of = by_material(name, description, uses, "fresnel", asks, on, "fresnel is \"none\" everywhere");
    if effect_of.state != State::On {
        return effect_of;
    }
    if let Some(why) = cut_off(description) {
        return effect(name, State::Removed, why, vec!["/render/max_depth".into()]);
    }
    let shows =
        |m: &Material| m.fresnel == Fresnel::Conductor || m.reflection.0.max(m.transmission.0).max_element() > 0.0;
    let used = |name: &str| uses.materials.contains(name);
    if !description.materials.iter().any(|(name, m)| asks(m) && used(name) && shows(m)) {
        let why = "dielectrics with reflection 0 and transmission 0 do not mirror";
        return effect(name, State::Removed, why, effect_of.because);
    }
    effect_of
}

pub(in crate::plan) fn absorption(description: &Description, uses: &Uses) -> Effect {
    let name = "absorption";
    let absorbs = |m: &Material| m.absorption.0.max_element() > 0.0;
    let on = "bodies absorb light along its way through them";
    let effect_of = by_material(name, description, uses, "absorption", absorbs, on, "absorption is 0 everywhere");
    if effect_of.state != State::On {
        return effect_of;
    }
    let filled = |name: &str| uses.filled.contains(name);
    let inside = |(name, m): (&str, &Material)| absorbs(m) && m.transmission.0.max_element() > 0.0 && filled(name);
    if !description.materials.iter().any(inside) {
        let why = "light gets into no body that absorbs: those that ask for it are opaque, hollow or sheets";
        return effect(name, State::Removed, why, effect_of.because);
    }
    effect_of
}

pub(in crate::plan) fn total_reflection(description: &Description, uses: &Uses) -> Effect {
    let name = "total_reflection";
    let clear = |m: &&Material| m.transmission.0.max_element() > 0.0;
    let used = |(n, m)| uses.materials.contains(n).then_some(m);
    let indices: Vec<f64> = description.materials.iter().filter_map(used).filter(clear).map(|m| m.ior).collect();
    if cut_off(description).is_some() {
        return effect(name, State::Off, "no refraction", Vec::new());
    }
    match indices.as_slice() {
        [] => effect(name, State::Off, "no refraction", Vec::new()),
        all if all.iter().all(|ior| *ior == 1.0) => {
            effect(name, State::Removed, "all indices of refraction are 1: nothing bends", Vec::new())
        }
        _ => effect(name, State::On, "light can meet a less dense medium at a grazing angle", Vec::new()),
    }
}

pub(in crate::plan) fn hollow(uses: &Uses) -> Effect {
    found("hollow_bodies", &uses.hollow, "bodies enclose empty space", "no body is hollow")
}
