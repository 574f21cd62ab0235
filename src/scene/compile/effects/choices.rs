//! Effects that are means over choices.

use super::light::by_light;
use super::rule::{EffectReason, Facts, OfMaterial, Rule, is_some};
use crate::camera::Camera;
use crate::lanes::Real;
use crate::scene::compile::prune::scatters;
use crate::scene::description::{self as d, Area, Light};
use crate::scene::effects::{Effect, MAX_POINTERS};
use crate::scene::problem::push_token;
use crate::scene::usage::Used;
use crate::scene::world::World;
use crate::shading::material::{Fresnel, Material};

pub(super) fn rules<R: Real>() -> Vec<Rule<R>> {
    vec![
        Rule::new(Effect::SoftShadows, |world| world.lights.iter().any(|light| light.area.is_some()), soft_shadows)
            .without(|world| world.lights.iter_mut().for_each(|light| light.area = None)),
        Rule::of_material(
            Effect::Gloss,
            OfMaterial {
                asks: |material| match &material.pbr {
                    Some(_) => None,
                    None => (material.roughness > 0.0).then_some("roughness"),
                },
                shows: |material, _| material.alpha > R::from_f64(0.0) && (material.mirrors() || material.transmits()),
                follows: true,
                on: "rough surfaces scatter what they reflect and transmit: each sample chooses a facet",
                removed: "no rough surface reflects or transmits",
                off: "roughness is 0 everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| material.alpha = R::from_f64(0.0))),
        Rule::of_material(
            Effect::Dispersion,
            OfMaterial {
                asks: |material| match &material.pbr {
                    Some(pbr) => (pbr.dispersion > 0.0).then_some("pbr"),
                    None => (material.dispersion > 0.0).then_some("dispersion"),
                },
                shows: disperses,
                follows: true,
                on: "bodies bend and reflect wavelengths differently: each sample chooses one",
                removed: "no body that disperses light transmits any, sheets do not bend it, and none is varnished",
                off: "dispersion is 0 everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| material.dispersion = R::from_f64(0.0))),
        Rule::new(Effect::DepthOfField, |world| world.camera.lens().is_some(), depth_of_field).without(|world| {
            if let Camera::Lens(flat, _) = world.camera {
                world.camera = Camera::Flat(flat);
            }
        }),
        Rule::new(Effect::MotionBlur, |world| world.usage.moves, motion_blur)
            .without(|world| world.usage.moves = false),
        Rule::new(Effect::ColorBleeding, |world| world.rules.gathers(), color_bleeding)
            .without(|world| world.rules.color_bleeding = false),
        Rule::new(Effect::GlobalIllumination, global_illumination_shows, global_illumination),
        Rule::new(
            Effect::EnvironmentSampling,
            |world| world.bright_directions.is_some() && global_illumination_shows(world),
            environment_sampling,
        )
        .without(|world| world.bright_directions = None),
        Rule::new(
            Effect::EmitterSampling,
            |world| world.emitters.is_some() && global_illumination_shows(world),
            emitter_sampling,
        )
        .without(|world| world.emitters = None),
    ]
}

/// Whether a surface scatters or reflects what global illumination brings.
fn global_illumination_shows<R: Real>(world: &World<R>) -> bool {
    let takes_part = |material: &Material<R>| scatters(material) || material.pbr.as_ref().is_some_and(|pbr| !pbr.unlit);
    world.rules.has_global_illumination() && world.has_material(|material, _| takes_part(material))
}

/// Whether bodies of a material split light: by bending it, which sheets do not, and in hollow bodies there is nothing; or by a
/// varnish, whose reflection depends on the index. Layers do so in volumes alone (glTF, KHR_materials_dispersion).
pub(in crate::scene::compile) fn disperses<R: Real>(material: &Material<R>, used: Used) -> bool {
    let bends = used.filled && material.transmits();
    let varnished = material.fresnel == Fresnel::Dielectric && (material.mirrors() || material.transmits());
    material.dispersion > R::from_f64(0.0) && (bends || varnished)
}

fn soft_shadows<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let area = |area: Option<Area>| match area {
        None => None,
        Some(Area::Disc(disc)) => Some(disc.radius > 0.0),
        Some(Area::Parallelogram(area)) => Some([area.u, area.v].as_flattened().iter().any(|x| *x != 0.0)),
    };
    let size = |light: &Light| match light {
        Light::Point(l) => area(l.area),
        Light::Spot(l) => area(l.area),
        Light::Directional(l) => l.area.map(|area| area.angle_deg > 0.0),
    };
    let on_and_off = "lights shine from areas: each sample chooses a point of them";
    if on || facts.description.lights.iter().any(|light| size(light) == Some(true)) {
        let says = [on_and_off, "all lights with an area are black", "all lights are points"];
        return by_light(facts, |light| size(light) == Some(true), says, on);
    }
    by_light(
        facts,
        |light| size(light).is_some(),
        [on_and_off, "areas of size 0 are points", "all lights are points"],
        on,
    )
}

fn depth_of_field<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    match &facts.description.camera {
        _ if on => EffectReason::asked_at(
            "the camera has a lens: each sample chooses a point of it",
            "/camera/pinhole/aperture",
        ),
        d::Camera::Pinhole(camera) if camera.focus_distance.is_some() => EffectReason::asked_at(
            "aperture is 0: everything is sharp at any distance",
            "/camera/pinhole/focus_distance",
        ),
        _ => EffectReason::off("the camera has no lens"),
    }
}

fn motion_blur<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        EffectReason::asked("objects move: each sample chooses a time", facts.pointers.moving.clone())
    } else {
        EffectReason::off("nothing moves")
    }
}

fn color_bleeding<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let because = "/render/color_bleeding";
    match facts.description.render.color_bleeding {
        false => EffectReason::off("not asked for: interreflection is the ambient light"),
        true if facts.world.rules.global_illumination => EffectReason::asked_at(
            "fidelity \"faithful\" brings light from surface to surface, and not once only",
            "/render/fidelity",
        ),
        true if on => EffectReason::asked_at(
            "surfaces gather what others scatter, once: each sample chooses a direction",
            because,
        ),
        true if facts.world.rules.max_depth == 1 => {
            EffectReason::asked_at("max_depth is 1: only camera rays are followed", because)
        }
        true => EffectReason::asked_at("all diffuse colors are black: there is nothing to gather", because),
    }
}

fn global_illumination<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let because = "/render/fidelity";
    let faithful = facts.description.render.fidelity == d::Fidelity::Faithful;
    match (faithful, on) {
        (false, _) => EffectReason::off("fidelity is \"fast\": light from everywhere needs no rays"),
        (true, true) => EffectReason::asked_at(
            "rays bring surfaces the light of others, of what glows and of the surroundings: each sample chooses a direction for \
             each lobe",
            because,
        ),
        (true, false) if facts.world.rules.max_depth == 1 => {
            EffectReason::asked_at("max_depth is 1: only camera rays are followed", because)
        }
        (true, false) => EffectReason::asked_at("no surface scatters or reflects what rays would bring", because),
    }
}

fn environment_sampling<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        let reason = "each sample looks for one bright direction of the environment, and shares what it finds with the rays of lobes";
        return EffectReason::asked_at(reason, "/environment");
    }
    EffectReason::off(match facts.description.environment {
        None => "the scene has no environment",
        Some(_) if facts.description.render.fidelity == d::Fidelity::Fast => "fidelity is \"fast\"",
        Some(_) => "the environment has one color, is hidden or is behind fog: no direction is brighter",
    })
}

fn emitter_sampling<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        let glowing = facts.description.materials.iter().filter(|(_, material)| match &material.pbr {
            Some(pbr) => is_some(pbr.emissive.factor()),
            None => is_some(material.emission),
        });
        let because = glowing.map(|(name, _)| push_token("/materials", name)).take(MAX_POINTERS).collect();
        let reason = "each sample looks for one point of what glows, and shares what it finds with the rays of lobes";
        return EffectReason::asked(reason, because);
    }
    EffectReason::off(match facts.description.render.fidelity {
        d::Fidelity::Fast => "fidelity is \"fast\": what glows is seen, and lights nothing",
        d::Fidelity::Faithful => "no triangle, box or ball glows alike everywhere: rays find what glows by chance",
    })
}
