//! What lights, the air and the surroundings do.

use super::rule::{EffectReason, Facts, OfMaterial, Rule, black, is_some};
use super::self_shadowing::casts_no_shadow;
use crate::accel::{Blockers, Shape};
use crate::lanes::Real;
use crate::scene::compile::prune::receives;
use crate::scene::description::Diffuse;
use crate::scene::description::{self as d, Checker, EnvironmentLight, Falloff, Gradient, Light, Noise, Shadows};
use crate::scene::effects::Effect;
use crate::scene::usage::Used;
use crate::scene::world::World;
use crate::scene::world::shows;
use crate::shading::light::{self, Source};
use crate::shading::material::Material;
use crate::shading::texture::checker::BaseColor;

pub(super) fn rules<R: Real>() -> Vec<Rule<R>> {
    vec![
        Rule::new(Effect::AmbientLight, |world| shows(world.ambient), ambient).without(|world| {
            (world.ambient, world.ambient_of_catchers) = (black(), black());
        }),
        Rule::new(
            Effect::DiffuseReflection,
            |world| {
                let arrives = world.is_lit() || world.rules.gathers() || world.rules.has_global_illumination();
                arrives && diffuse_materials().is_on(world)
            },
            diffuse,
        )
        .without(|world| world.materials.iter_mut().for_each(forget_diffuse)),
        Rule::new(Effect::Highlights, |world| world.is_lit() && shiny_materials().is_on(world), highlights)
            .without(|world| world.materials.iter_mut().for_each(|material| material.specular = black())),
        Rule::new(Effect::Shadows, |world| world.rules.shadows.is_some(), shadows)
            .without(|world| world.rules.shadows = None),
        Rule::new(Effect::TransmissiveShadows, lets_light_through, transmissive_shadows).without(|world| {
            world.rules.shadows = world.rules.shadows.map(|_| Blockers::Opaque);
        }),
        Rule::new(
            Effect::ColoredShadows,
            |world| {
                let absorbs = |material: &Material<R>, used: Used| {
                    (absorbing_bodies().shows)(material, used) && material.transmits()
                };
                world.rules.colors_shadows && lets_light_through(world) && world.has_material(absorbs)
            },
            colored_shadows,
        )
        .without(|world| world.rules.colors_shadows = false),
        Rule::of_material(Effect::Absorption, absorbing_bodies())
            .without(|world| world.materials.iter_mut().for_each(|material| material.absorption = black())),
        Rule::of_material(
            Effect::Emission,
            OfMaterial {
                asks: |material| match &material.pbr {
                    Some(pbr) => (pbr.unlit || is_some(pbr.emissive.factor())).then_some("pbr"),
                    None => is_some(material.emission).then_some("emission"),
                },
                shows: |material, _| shows(material.emission),
                follows: false,
                on: "surfaces shine by themselves",
                removed: "what they shine with is too little for single precision",
                off: "emission is 0 everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| material.emission = black())),
        Rule::new(Effect::Fog, |world| world.fog.is_some(), fog).without(|world| world.fog = None),
        Rule::new(Effect::EnvironmentMap, |world| world.environment.is_some(), environment)
            .without(|world| (world.environment, world.bright_directions) = (None, None)),
        Rule::new(
            Effect::EnvironmentLight,
            |world| world.surroundings.is_some() && !world.rules.global_illumination,
            environment_light,
        )
        .without(|world| world.surroundings = None),
        Rule::new(
            Effect::SpotLights,
            |world| world.lights.iter().any(|light| shows(light.color) && matches!(light.source, Source::Spot { .. })),
            spot_lights,
        )
        .without(|world| world.lights.iter_mut().for_each(widen)),
        Rule::new(
            Effect::LightFalloff,
            |world| {
                world.lights.iter().any(|light| shows(light.color) && !matches!(light.falloff, light::Falloff::None))
            },
            falloff,
        )
        .without(|world| world.lights.iter_mut().for_each(|light| light.falloff = light::Falloff::None)),
    ]
}

fn ambient<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    match is_some(facts.description.ambient) {
        true if on => EffectReason::asked_at("the scene has ambient light", "/ambient"),
        true if facts.world.rules.global_illumination => {
            EffectReason::asked_at("what rays bring surfaces takes its place", "/render/fidelity")
        }
        true if facts.description.render.color_bleeding => {
            EffectReason::asked_at("what surfaces gather takes its place", "/render/color_bleeding")
        }
        true => EffectReason::asked_at("no surface has a color for it", "/ambient"),
        false if on => {
            EffectReason::asked_at("the environment has one color: it is ambient light", "/environment/light")
        }
        false => EffectReason::off("ambient is 0"),
    }
}

/// Whether a color of the description is more than black anywhere.
fn is_colored(diffuse: &Diffuse) -> bool {
    match diffuse {
        Diffuse::Uniform(color) => is_some(*color),
        Diffuse::Checker(Checker { a, b, .. })
        | Diffuse::Gradient(Gradient { a, b, .. })
        | Diffuse::Noise(Noise { a, b, .. }) => is_some(*a) || is_some(*b),
        Diffuse::Image(_) => true,
    }
}

fn diffuse_materials<R: Real>() -> OfMaterial<R> {
    OfMaterial {
        asks: |material| match &material.pbr {
            Some(pbr) => (!pbr.unlit).then_some("pbr"),
            None => is_colored(&material.diffuse).then_some("diffuse"),
        },
        shows: |material, _| match material.diffuse {
            BaseColor::Uniform(color) => shows(color),
            BaseColor::Checker { a, b, .. } => shows(a) || shows(b),
        },
        follows: false,
        on: "surfaces scatter the lights",
        removed: "the colors are too dark for single precision, or all of it is metal",
        off: "no material has a diffuse color",
    }
}

/// Ambient light keeps the color that it had.
fn forget_diffuse<R: Real>(material: &mut Material<R>) {
    let diffuse = std::mem::replace(&mut material.diffuse, BaseColor::Uniform(black()));
    material.ambient.get_or_insert(diffuse);
    if let Some(textures) = &mut material.textures {
        let pattern = textures.diffuse.take();
        if !textures.own_ambient {
            (textures.ambient, textures.own_ambient) = (pattern, true);
        }
        if textures.is_plain() {
            material.textures = None;
        }
    }
}

/// Of what needs lights: the same, but for the reason where there are none.
fn of_lights<R: Real>(of: &OfMaterial<R>, facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let reason = of.why(facts, on);
    if reason.asked && !on && !facts.world.is_lit() { no_light(facts) } else { reason }
}

fn no_light<R: Real>(facts: &Facts<'_, R>) -> EffectReason {
    let reason = if !facts.description.lights.iter().any(Light::shines) {
        "no light shines"
    } else if facts.world.has_material(|material, _| receives(material)) {
        "no light gets to a surface that is seen"
    } else {
        "no surface scatters the light"
    };
    EffectReason::asked_at(reason, "/lights")
}

fn diffuse<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let default = facts.world.usage.materials.last().is_some_and(|used| used.anywhere);
    match (on, default) {
        (true, true) => EffectReason::asked("bodies without a material are diffuse", Vec::new()),
        (false, true) => no_light(facts),
        _ => of_lights(&diffuse_materials(), facts, on),
    }
}

fn shiny_materials<R: Real>() -> OfMaterial<R> {
    OfMaterial {
        asks: |material| match &material.pbr {
            Some(pbr) => (!pbr.unlit).then_some("pbr"),
            None => is_some(material.specular).then_some("specular"),
        },
        shows: |material, _| shows(material.specular),
        follows: false,
        on: "lights mirror in shiny surfaces (Phong)",
        removed: "they are too dark for single precision",
        off: "specular is 0 everywhere",
    }
}

fn highlights<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    of_lights(&shiny_materials(), facts, on)
}

fn shadows<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if facts.description.render.shadows == Shadows::None {
        return EffectReason::off("render.shadows is \"none\"").because("/render/shadows");
    }
    if on {
        return EffectReason::asked_at("bodies hide the lights from each other", "/lights");
    }
    match casts_no_shadow(facts.description, facts.world).filter(|_| facts.world.is_lit()) {
        None => no_light(facts),
        Some((item, why)) => {
            let kind = match item.shape {
                Shape::Plane(_) => "plane",
                Shape::Disc(_) => "disc",
                Shape::Sphere(_) => "sphere",
                _ => "box",
            };
            EffectReason::asked(why, vec![format!("{}/{kind}", (facts.source)(item.source))])
        }
    }
}

/// Whether shadow rays pass some bodies.
fn lets_light_through<R>(world: &World<R>) -> bool {
    world.rules.shadows == Some(Blockers::Transmissive)
}

fn transmissive_shadows<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let because = "/render/shadows";
    match facts.description.render.shadows {
        Shadows::Opaque | Shadows::None => EffectReason::off("render.shadows is not \"transmissive\""),
        Shadows::Transmissive if on => {
            EffectReason::asked_at("transmitting bodies let some of the light through", because)
        }
        Shadows::Transmissive if !facts.world.transmits => EffectReason::asked_at("no body transmits light", because),
        Shadows::Transmissive => EffectReason::asked_at("there are no shadows", because),
    }
}

fn absorbing_bodies<R: Real>() -> OfMaterial<R> {
    OfMaterial {
        asks: |material| match &material.pbr {
            Some(pbr) => pbr.attenuation.is_some().then_some("pbr"),
            None => is_some(material.absorption).then_some("absorption"),
        },
        shows: |material, used| {
            // Opaque bodies absorb light only around an eye that is inside of them.
            used.filled && shows(material.absorption) && (material.transmits() || used.around_eye)
        },
        follows: false,
        on: "bodies absorb light along its way through them",
        removed: "no light that is seen gets into a body that absorbs: those that ask for it are opaque, hollow or sheets",
        off: "absorption is 0 everywhere",
    }
}

fn colored_shadows<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let absorption = absorbing_bodies();
    if on {
        let reason = "bodies absorb some of the light on its way to surfaces";
        return EffectReason { reason: reason.into(), ..absorption.why(facts, true) };
    }
    if !absorption.is_on(facts.world) {
        return EffectReason::off("no body absorbs the light that passes through it");
    }
    if facts.description.render.shadows != Shadows::Transmissive {
        return EffectReason::off("render.shadows is not \"transmissive\"").because("/render/shadows");
    }
    no_light(facts)
}

fn fog<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    match &facts.description.fog {
        Some(fog) if on => {
            let how = if fog.height.is_some() { "fog that thins out with height" } else { "fog" };
            EffectReason::asked_at(format!("{how} fades what is far away"), "/fog")
        }
        Some(fog) if fog.density > 0.0 => EffectReason::asked_at("it is too thin for single precision", "/fog/density"),
        Some(_) => EffectReason::asked_at("fog.density is 0", "/fog/density"),
        None => EffectReason::off("the scene has no fog"),
    }
}

fn environment<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    match &facts.description.environment {
        None => EffectReason::off("rays that hit nothing see the background"),
        Some(environment) if on && environment.sky.is_some() => {
            EffectReason::asked_at("rays that hit nothing see a sky", "/environment/sky")
        }
        Some(environment) if on && environment.studio.is_some() => {
            EffectReason::asked_at("rays that hit nothing see a studio", "/environment/studio")
        }
        Some(_) if on => EffectReason::asked_at("rays that hit nothing see a picture", "/environment"),
        Some(environment) if environment.intensity == 0.0 => {
            EffectReason::asked_at("its intensity is 0: it is black", "/environment/intensity")
        }
        Some(_) if facts.world.usage.enclosed => EffectReason::asked_at("the eye is in a closed room", "/environment"),
        Some(_) if facts.world.fog.is_some() => {
            EffectReason::asked_at("fog hides it: it is infinitely far away", "/environment")
        }
        Some(_) => EffectReason::asked_at("it has one color: it is a background", "/environment"),
    }
}

fn environment_light<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let at = "/environment/light";
    match &facts.description.environment {
        Some(environment) if environment.light == EnvironmentLight::None && facts.world.rules.global_illumination => {
            EffectReason::off("rays bring the light of all that they see")
        }
        Some(environment) if environment.light == EnvironmentLight::None => {
            EffectReason::off("the environment is seen, and lights nothing: environment.light is \"none\"")
        }
        None => EffectReason::off("the scene has no environment"),
        Some(_) if facts.world.rules.global_illumination => {
            EffectReason::asked_at("rays bring the light of the environment", "/render/fidelity")
        }
        Some(_) if on => EffectReason::asked_at(
            "surfaces scatter the light of the environment, by 9 coefficients, about 0.5 codes off, and rough ones reflect it \
             blurred; nothing hides it from them. What is proved about rays holds for that light, not for its error",
            at,
        ),
        Some(environment) if environment.intensity == 0.0 => {
            EffectReason::asked_at("its intensity is 0: it is black", at)
        }
        Some(_) if facts.world.usage.enclosed => EffectReason::asked_at("the eye is in a closed room", at),
        Some(_) => EffectReason::asked_at("it has one color: it is ambient light", at),
    }
}

/// An effect of lights: `asks` says which ask for it.
pub(super) fn by_light<R>(
    facts: &Facts<'_, R>,
    asks: impl Fn(&Light) -> bool,
    says: [&'static str; 3],
    on: bool,
) -> EffectReason {
    let [why_on, black, off] = says;
    let asking = facts.description.lights.iter().enumerate().filter(|(_, light)| asks(light));
    let pointers: Vec<String> =
        asking.filter(|(_, light)| light.shines() || !on).map(|(i, _)| format!("/lights/{i}")).collect();
    match (on, pointers.is_empty()) {
        (true, _) => EffectReason::asked(why_on, pointers),
        (false, false) if facts.description.lights.iter().any(|light| asks(light) && light.shines()) => {
            EffectReason::asked("no surface scatters the light, or it gets to none that is seen", pointers)
        }
        (false, false) => EffectReason::asked(black, pointers),
        (false, true) => EffectReason::off(off),
    }
}

fn spot_lights<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let says = ["lights shine into cones", "all spots are black", "no light is a spot"];
    by_light(facts, |light| matches!(light, Light::Spot(_)), says, on)
}

fn falloff<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let fades = |light: &Light| match light {
        Light::Point(d::PointLight { falloff, .. }) | Light::Spot(d::SpotLight { falloff, .. }) => {
            *falloff != Falloff::None
        }
        Light::Directional(_) => false,
    };
    let says = ["lights fade with distance", "all lights that fade are black", "no light fades with distance"];
    by_light(facts, fades, says, on)
}

/// Makes a point light of a spot.
fn widen<R: Real>(light: &mut light::Light<R>) {
    if let Source::Spot { position, .. } = light.source {
        light.source = Source::Point { position };
    }
}
