//! Effects that are means over choices.

use super::passing::cut_off;
use crate::plan::explain::{Effect, State, by_material, effect, found, light_pointers};
use crate::plan::use_of::Uses;
use crate::scene::description::{Area, Camera, Description, Fresnel, Light, Material};

pub(in crate::plan) fn soft_shadows(description: &Description) -> Effect {
    let area = |area: Option<Area>| match area {
        None => None,
        Some(Area::Disc(disc)) => Some(disc.radius > 0.0),
        Some(Area::Parallelogram(area)) => Some([area.u, area.v].as_flattened().iter().any(|x| *x != 0.0)),
    };
    let asked = |light: &Light| match light {
        Light::Point(l) => area(l.area),
        Light::Spot(l) => area(l.area),
        Light::Directional(l) => l.area.map(|area| area.angle_deg > 0.0),
    };
    let name = "soft_shadows";
    let large = light_pointers(description, |light| asked(light) == Some(true));
    let small = light_pointers(description, |light| asked(light) == Some(false));
    if large.is_empty() && !small.is_empty() {
        return effect(name, State::Removed, "areas of size 0 are points", small);
    }
    found(name, &large, "lights shine from areas: each sample chooses a point of them", "all lights are points")
}

/// An effect of rays that leave a surface: removed where none leave, or none that `shows` it.
fn of_rays(
    asked: Effect,
    description: &Description,
    uses: &Uses,
    shows: impl Fn(&Material) -> bool,
    why: &str,
) -> Effect {
    if asked.state != State::On {
        return asked;
    }
    if let Some(why) = cut_off(description) {
        return effect(asked.effect, State::Removed, why, asked.because);
    }
    if description.materials.iter().any(|(name, m)| shows(m) && uses.materials.contains(name)) {
        return asked;
    }
    effect(asked.effect, State::Removed, why, asked.because)
}

pub(in crate::plan) fn gloss(description: &Description, uses: &Uses) -> Effect {
    let on = "rough surfaces scatter what they reflect and transmit: each sample chooses a facet";
    let rough = |m: &Material| m.roughness > 0.0;
    let asked = by_material("gloss", description, uses, "roughness", rough, on, "roughness is 0 everywhere");
    let leaves =
        |m: &Material| m.reflection.0.max(m.transmission.0).max_element() > 0.0 || m.fresnel == Fresnel::Conductor;
    let why = "no rough surface reflects or transmits";
    of_rays(asked, description, uses, |m| rough(m) && leaves(m), why)
}

pub(in crate::plan) fn dispersion(description: &Description, uses: &Uses) -> Effect {
    let on = "bodies bend wavelengths differently: each sample chooses one";
    let disperses = |m: &Material| m.dispersion > 0.0;
    let asked = by_material("dispersion", description, uses, "dispersion", disperses, on, "dispersion is 0 everywhere");
    let clear = |m: &Material| m.transmission.0.max_element() > 0.0;
    let why = "no body that disperses light transmits any";
    of_rays(asked, description, uses, |m| disperses(m) && clear(m), why)
}

pub(in crate::plan) fn depth_of_field(description: &Description) -> Effect {
    let name = "depth_of_field";
    match &description.camera {
        Camera::Pinhole(c) if c.aperture > 0.0 => {
            let because = vec!["/camera/pinhole/aperture".into()];
            effect(name, State::On, "the camera has a lens: each sample chooses a point of it", because)
        }
        Camera::Pinhole(c) if c.focus_distance.is_some() => {
            let because = vec!["/camera/pinhole/focus_distance".into()];
            effect(name, State::Removed, "aperture is 0: everything is sharp at any distance", because)
        }
        _ => effect(name, State::Off, "the camera has no lens", Vec::new()),
    }
}

pub(in crate::plan) fn motion_blur(uses: &Uses) -> Effect {
    found("motion_blur", &uses.moving, "objects move: each sample chooses a time", "nothing moves")
}

pub(in crate::plan) fn color_bleeding(description: &Description) -> Effect {
    let name = "color_bleeding";
    let because = vec!["/render/color_bleeding".into()];
    match (description.render.color_bleeding, description.render.max_depth) {
        (false, _) => effect(name, State::Off, "not asked for: interreflection is the ambient light", Vec::new()),
        (true, Some(1)) => effect(name, State::Removed, "max_depth is 1: only camera rays are followed", because),
        _ => effect(
            name,
            State::On,
            "surfaces gather what others scatter, once: each sample chooses a direction",
            because,
        ),
    }
}
