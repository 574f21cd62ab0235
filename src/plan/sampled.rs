//! Effects that are means over choices.

use super::explain::{Effect, State, by_material, effect, found, light_pointers};
use super::use_of::Uses;
use crate::scene::description::{Area, Camera, Description, Light};

pub(super) fn soft_shadows(description: &Description) -> Effect {
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

pub(super) fn gloss(description: &Description, uses: &Uses) -> Effect {
    let effect_of = by_material(
        "gloss",
        description,
        uses,
        "roughness",
        |m| m.roughness > 0.0,
        "rough surfaces scatter what they reflect and transmit: each sample chooses a facet",
        "roughness is 0 everywhere",
    );
    let shows = description.materials.iter().any(|(name, m)| {
        let passes = m.reflection.0.max_element() > 0.0 || m.transmission.0.max_element() > 0.0;
        m.roughness > 0.0 && passes && uses.materials.contains(name)
    });
    if effect_of.state == State::On && !shows {
        return effect("gloss", State::Removed, "no rough surface reflects or transmits", effect_of.because);
    }
    effect_of
}

pub(super) fn dispersion(description: &Description, uses: &Uses) -> Effect {
    let effect_of = by_material(
        "dispersion",
        description,
        uses,
        "dispersion",
        |m| m.dispersion > 0.0,
        "bodies bend wavelengths differently: each sample chooses one",
        "dispersion is 0 everywhere",
    );
    let shows = description
        .materials
        .iter()
        .any(|(name, m)| m.dispersion > 0.0 && m.transmission.0.max_element() > 0.0 && uses.materials.contains(name));
    if effect_of.state == State::On && !shows {
        return effect("dispersion", State::Removed, "no body that disperses light transmits any", effect_of.because);
    }
    effect_of
}

pub(super) fn depth_of_field(description: &Description) -> Effect {
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

pub(super) fn motion_blur(uses: &Uses) -> Effect {
    found("motion_blur", &uses.moving, "objects move: each sample chooses a time", "nothing moves")
}

pub(super) fn color_bleeding(description: &Description) -> Effect {
    let name = "color_bleeding";
    let because = vec!["/render/color_bleeding".into()];
    match (description.render.color_bleeding, description.render.max_depth) {
        (false, _) => effect(name, State::Off, "not asked for: interreflection is the ambient light", Vec::new()),
        (true, 1) => effect(name, State::Removed, "max_depth is 1: only camera rays are followed", because),
        _ => effect(
            name,
            State::On,
            "surfaces gather what others scatter, once: each sample chooses a direction",
            because,
        ),
    }
}
