//! What mirrors, and what passes through bodies.

use super::rule::{EffectReason, Facts, OfMaterial, Rule, black, is_some};
use crate::lanes::Real;
use crate::scene::description as d;
use crate::scene::effects::Effect;
use crate::scene::usage::Used;
use crate::scene::world::shows;
use crate::shading::lobes::MIRROR;
use crate::shading::material::{Fresnel, Material};

pub(super) fn rules<R: Real>() -> Vec<Rule<R>> {
    vec![
        Rule::of_material(
            Effect::Reflection,
            OfMaterial {
                asks: |material| match material.fresnel {
                    _ if material.pbr.is_some() => asked(material, |pbr| !pbr.unlit),
                    _ if is_some(material.reflection) => Some("reflection"),
                    d::Fresnel::Conductor => Some("fresnel"),
                    _ => None,
                },
                shows: |material, _| material.mirrors(),
                follows: true,
                on: "surfaces mirror their surroundings",
                removed: "it is too little for single precision, or no part of the surface is smooth enough",
                off: "reflection is 0 everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(forget_reflection)),
        Rule::of_material(
            Effect::Transmission,
            OfMaterial {
                asks: |material| match material.pbr {
                    Some(_) => asked(material, transmits),
                    None => is_some(material.transmission).then_some("transmission"),
                },
                shows: |material, _| material.transmits(),
                follows: true,
                on: "light passes through bodies",
                removed: "it is too little for single precision",
                off: "transmission is 0 everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| material.transmission = black())),
        Rule::of_material(
            Effect::Fresnel,
            OfMaterial {
                asks: |material| match material.pbr {
                    Some(_) => asked(material, |pbr| mirrors(pbr) || transmits(pbr)),
                    None => (material.fresnel != d::Fresnel::None).then_some("fresnel"),
                },
                shows: |material, _| match material.fresnel {
                    Fresnel::None => false,
                    Fresnel::Dielectric | Fresnel::Layered => shows(material.reflection) || material.transmits(),
                    Fresnel::Conductor => true,
                },
                follows: true,
                on: "reflection and transmission depend on the angle of incidence",
                removed: "dielectrics with reflection 0 and transmission 0 do not mirror",
                off: "fresnel is \"none\" everywhere",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| material.fresnel = Fresnel::None)),
        Rule::new(Effect::TotalReflection, |world| bending_bodies().is_on(world), total_reflection),
        Rule::of_material(Effect::Refraction, bending_bodies())
            .without(|world| world.materials.iter_mut().for_each(straighten)),
        Rule::new(Effect::HollowBodies, |world| world.usage.hollow, hollow),
    ]
}

/// The key of a material as in glTF, if that asks for something.
fn asked(material: &d::Material, asks: impl Fn(&d::Pbr) -> bool) -> Option<&'static str> {
    material.pbr.as_deref().filter(|pbr| asks(pbr)).map(|_| "pbr")
}

/// Whether the surface or its clearcoat may be smooth enough for a mirror ray.
fn mirrors(pbr: &d::Pbr) -> bool {
    let smooth = |roughness: &d::Channel<f64>| roughness.textured().is_some() || roughness.factor() <= MIRROR;
    let clearcoated = pbr.clearcoat.factor() > 0.0 && smooth(&pbr.clearcoat_roughness);
    !pbr.unlit && (smooth(&pbr.roughness) || clearcoated)
}

fn transmits(pbr: &d::Pbr) -> bool {
    !pbr.unlit && pbr.transmission.factor() > 0.0
}

/// Bodies into which light is refracted. Sheets and hollow bodies do not bend it: behind their surface is what was in front.
fn bending_bodies<R: Real>() -> OfMaterial<R> {
    OfMaterial {
        asks: |material| match material.pbr {
            Some(_) => asked(material, transmits),
            None => is_some(material.transmission).then_some("ior"),
        },
        shows: bends,
        follows: true,
        on: "light bends by Snell's law",
        removed: "all indices of refraction are 1, or those of sheets and hollow bodies: nothing bends",
        off: "nothing transmits light",
    }
}

fn bends<R: Real>(material: &Material<R>, used: Used) -> bool {
    // The index of bodies that disperse light is their own at one wavelength alone.
    let is_empty = material.ior == R::from_f64(1.0) && material.dispersion == R::from_f64(0.0);
    used.filled && material.transmits() && !is_empty
}

fn total_reflection<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        return EffectReason::asked("light can meet a less dense medium at a grazing angle", Vec::new());
    }
    bending_bodies().why(facts, on).or_off("no refraction")
}

fn hollow<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        EffectReason::asked("bodies enclose empty space", facts.pointers.hollow.clone())
    } else {
        EffectReason::off("no body is hollow")
    }
}

/// What conductors transmit depends on what they mirror, so they become plain.
fn forget_reflection<R: Real>(material: &mut Material<R>) {
    material.reflection = black();
    if material.fresnel == Fresnel::Conductor {
        material.fresnel = Fresnel::None;
    }
}

/// Varnished bodies keep their index: it decides how much they mirror.
fn straighten<R: Real>(material: &mut Material<R>) {
    if material.transmits() {
        material.ior = R::from_f64(1.0);
    }
}
