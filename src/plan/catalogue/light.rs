//! What lights and the air do.

use super::passing::absorption;
use crate::plan::explain::{Effect, State, by_material, effect, found, light_pointers};
use crate::plan::use_of::Uses;
use crate::scene::description::{Checker, Description, Diffuse, Falloff, Gradient, Light, Material, Noise, Shadows};

pub(in crate::plan) fn ambient(description: &Description) -> Effect {
    if description.ambient.0.max_element() > 0.0 {
        effect("ambient_light", State::On, "the scene has ambient light", vec!["/ambient".into()])
    } else {
        effect("ambient_light", State::Off, "ambient is 0", Vec::new())
    }
}

pub(in crate::plan) fn lit(description: &Description) -> bool {
    description.lights.iter().any(|light| {
        let (color, intensity) = match light {
            Light::Point(l) => (l.color, l.intensity),
            Light::Directional(l) => (l.color, l.intensity),
            Light::Spot(l) => (l.color, l.intensity),
        };
        color.0.max_element() * intensity > 0.0
    })
}

pub(in crate::plan) fn shines(diffuse: &Diffuse) -> bool {
    match diffuse {
        Diffuse::Uniform(color) => color.0.max_element() > 0.0,
        Diffuse::Checker(Checker { a, b, .. })
        | Diffuse::Gradient(Gradient { a, b, .. })
        | Diffuse::Noise(Noise { a, b, .. }) => a.0.max_element().max(b.0.max_element()) > 0.0,
        Diffuse::Image(_) => true,
    }
}

pub(in crate::plan) fn diffuse(description: &Description, uses: &Uses) -> Effect {
    let name = "diffuse_reflection";
    if !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    if uses.default_material {
        return effect(name, State::On, "bodies without a material are diffuse", Vec::new());
    }
    let (on, off) = ("surfaces scatter the lights", "no material has a diffuse colour");
    by_material(name, description, uses, "diffuse", |m| shines(&m.diffuse), on, off)
}

pub(in crate::plan) fn highlights(description: &Description, uses: &Uses) -> Effect {
    let name = "highlights";
    let effect_of = by_material(
        name,
        description,
        uses,
        "specular",
        |m| m.specular.0.max_element() > 0.0,
        "lights mirror in shiny surfaces (Phong)",
        "specular is 0 everywhere",
    );
    if effect_of.state == State::On && !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    effect_of
}

pub(in crate::plan) fn shadows(description: &Description) -> Effect {
    let name = "shadows";
    match (description.render.shadows, lit(description)) {
        (Shadows::None, _) => effect(name, State::Off, "render.shadows is \"none\"", vec!["/render/shadows".into()]),
        (_, false) => effect(name, State::Removed, "no light shines", vec!["/lights".into()]),
        _ => effect(name, State::On, "bodies hide the lights from each other", vec!["/lights".into()]),
    }
}

pub(in crate::plan) fn transmissive_shadows(description: &Description, uses: &Uses) -> Effect {
    let name = "transmissive_shadows";
    if description.render.shadows != Shadows::Transmissive {
        return effect(name, State::Off, "render.shadows is not \"transmissive\"", Vec::new());
    }
    let clear = |m: &str| description.materials.get(m).is_some_and(|m| m.transmission.0.max_element() > 0.0);
    let because = vec!["/render/shadows".into()];
    if !uses.materials.iter().any(|m| clear(m)) {
        return effect(name, State::Removed, "no body transmits light", because);
    }
    effect(name, State::On, "transmitting bodies let some of the light through", because)
}

pub(in crate::plan) fn colored_shadows(description: &Description, uses: &Uses) -> Effect {
    let name = "colored_shadows";
    let absorption = absorption(description, uses);
    if absorption.state != State::On {
        return effect(name, State::Off, "no body absorbs the light that passes through it", Vec::new());
    }
    if description.render.shadows != Shadows::Transmissive {
        return effect(name, State::Off, "render.shadows is not \"transmissive\"", vec!["/render/shadows".into()]);
    }
    if !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    effect(name, State::On, "bodies absorb some of the light on its way to surfaces", absorption.because)
}

pub(in crate::plan) fn spot_lights(description: &Description) -> Effect {
    let spots = light_pointers(description, |light| matches!(light, Light::Spot(_)));
    found("spot_lights", &spots, "lights shine into cones", "no light is a spot")
}

pub(in crate::plan) fn falloff(description: &Description) -> Effect {
    let fades = light_pointers(description, |light| match light {
        Light::Point(l) => l.falloff != Falloff::None,
        Light::Spot(l) => l.falloff != Falloff::None,
        Light::Directional(_) => false,
    });
    found("light_falloff", &fades, "lights fade with distance", "no light fades with distance")
}

pub(in crate::plan) fn emission(description: &Description, uses: &Uses) -> Effect {
    let (on, off) = ("surfaces shine by themselves", "emission is 0 everywhere");
    let shines = |m: &Material| m.emission.0.max_element() > 0.0;
    by_material("emission", description, uses, "emission", shines, on, off)
}

pub(in crate::plan) fn fog(description: &Description) -> Effect {
    match &description.fog {
        Some(fog) if fog.density > 0.0 => {
            let how = if fog.height.is_some() { "fog that thins out with height" } else { "fog" };
            effect("fog", State::On, format!("{how} fades what is far away"), vec!["/fog".into()])
        }
        Some(_) => effect("fog", State::Removed, "fog.density is 0", vec!["/fog/density".into()]),
        None => effect("fog", State::Off, "the scene has no fog", Vec::new()),
    }
}

pub(in crate::plan) fn environment(description: &Description) -> Effect {
    let name = "environment_map";
    match &description.environment {
        None => effect(name, State::Off, "rays that hit nothing see the background", Vec::new()),
        Some(environment) if environment.intensity == 0.0 => {
            effect(name, State::Removed, "its intensity is 0: it is black", vec!["/environment/intensity".into()])
        }
        Some(_) => effect(name, State::On, "rays that hit nothing see a picture", vec!["/environment".into()]),
    }
}
