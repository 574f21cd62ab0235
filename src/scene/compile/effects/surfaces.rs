//! What surfaces look like.

use super::approximations::metallic_roughness;
use super::rule::{EffectReason, Facts, OfMaterial, Rule};
use crate::lanes::Real;
use crate::scene::description::Diffuse;
use crate::scene::description::Material as Described;
use crate::scene::effects::{Effect, MAX_POINTERS};
use crate::scene::problem::push_token;
use crate::shading::material::Material;
use crate::shading::pbr::Pbr;
use crate::shading::texture::bump::BumpMap;
use crate::shading::texture::checker::BaseColor;
use crate::shading::texture::pattern::{Pattern, Textures};

pub(super) fn rules<R: Real>() -> Vec<Rule<R>> {
    vec![
        Rule::of_material(
            Effect::CheckerTexture,
            OfMaterial {
                asks: |material| color_that(material, |color| matches!(color, Diffuse::Checker(_))),
                shows: |material, _| is_checker(&material.diffuse) || material.ambient.as_ref().is_some_and(is_checker),
                follows: false,
                on: "colors depend on the place",
                removed: "its two colors are the same, or no light shows them",
                off: "no color is a checkerboard",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(forget_checkers)),
        Rule::of_material(
            Effect::GradientTexture,
            OfMaterial {
                asks: |material| color_that(material, |color| matches!(color, Diffuse::Gradient(_))),
                shows: |material, _| has_pattern(material, is_gradient),
                follows: false,
                on: "colors change from point to point",
                removed: "its two colors are the same, or no light shows them",
                off: "no color is a gradient",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| forget_patterns(material, is_gradient))),
        Rule::of_material(
            Effect::NoiseTexture,
            OfMaterial {
                asks: |material| color_that(material, |color| matches!(color, Diffuse::Noise(_))),
                shows: |material, _| has_pattern(material, is_noise),
                follows: false,
                on: "colors are clouds of noise",
                removed: "its two colors are the same, or no light shows them",
                off: "no color is noise",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| forget_patterns(material, is_noise))),
        Rule::of_material(
            Effect::ImageTexture,
            OfMaterial {
                asks: |material| match &material.pbr {
                    Some(pbr) => pbr.has_pictures().then_some("pbr"),
                    None => color_that(material, |color| matches!(color, Diffuse::Image(_))),
                },
                shows: |material, _| has_pattern(material, is_image) || has_pictures(material),
                follows: false,
                on: "pictures lie on surfaces, filtered by the footprint of each ray",
                removed: "the picture has one color, or no light shows it",
                off: "no color is a picture",
            },
        )
        .without(|world| {
            for material in &mut world.materials {
                forget_patterns(material, is_image);
                material.pbr.as_deref_mut().into_iter().for_each(Pbr::forget_pictures);
            }
        }),
        Rule::of_material(
            Effect::BumpMapping,
            OfMaterial {
                asks: |material| material.bump.as_ref().map(|_| "bump"),
                shows: |material, _| has_bumps(material, is_bump),
                follows: false,
                on: "surfaces are lit as if they were rough",
                removed: "the bumps are flat, or no light shows them",
                off: "no material has bumps",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| forget_bumps(material, is_bump))),
        Rule::of_material(
            Effect::NormalMapping,
            OfMaterial {
                asks: |material| match &material.pbr {
                    Some(pbr) => pbr.normals().iter().any(|(_, map)| map.is_some()).then_some("pbr"),
                    None => material.normal_map.as_ref().map(|_| "normal_map"),
                },
                shows: |material, _| has_bumps(material, is_normal_map),
                follows: false,
                on: "pictures tilt the normals of surfaces",
                removed: "the picture tilts no normal, or no light shows it",
                off: "no material has a normal map",
            },
        )
        .without(|world| world.materials.iter_mut().for_each(|material| forget_bumps(material, is_normal_map))),
        Rule::new(
            Effect::MetallicRoughness,
            |world| world.has_material(|material, _| material.pbr.is_some()),
            metallic_roughness,
        ),
        Rule::of_material(
            Effect::Opacity,
            OfMaterial {
                asks: |material| {
                    let pbr = material.pbr.as_ref()?;
                    (pbr.opacity.is_some() || pbr.shadow_catcher).then_some("pbr")
                },
                shows: |material, _| material.has_holes(),
                follows: false,
                on: "light goes straight on through what is only partly there, in any order, and so do shadow rays",
                removed: "all of it is there: the cutoff is 0, or alpha is 1 everywhere",
                off: "all surfaces are there",
            },
        ),
        Rule::new(
            Effect::ShadowCatcher,
            |world| {
                let catches = world.has_material(|material, _| material.catches_shadows());
                catches && world.is_lit() && world.rules.shadows.is_some()
            },
            shadow_catcher,
        ),
        Rule::new(Effect::SmoothNormals, |world| world.usage.smooth, smooth_normals),
    ]
}

fn has_pictures<R>(material: &Material<R>) -> bool {
    material.pbr.as_ref().is_some_and(|pbr| !pbr.pictures.is_empty())
}

/// The key of a color that passes a test.
fn color_that(material: &Described, test: impl Fn(&Diffuse) -> bool) -> Option<&'static str> {
    if test(&material.diffuse) {
        return Some("diffuse");
    }
    material.ambient.as_ref().is_some_and(test).then_some("ambient")
}

fn is_checker<R>(color: &BaseColor<R>) -> bool {
    matches!(color, BaseColor::Checker { .. })
}

fn is_gradient(pattern: &Pattern) -> bool {
    matches!(pattern, Pattern::Gradient { .. })
}

fn is_noise(pattern: &Pattern) -> bool {
    matches!(pattern, Pattern::Noise { .. })
}

fn is_image(pattern: &Pattern) -> bool {
    matches!(pattern, Pattern::Image(_))
}

fn is_normal_map(bump: &BumpMap) -> bool {
    matches!(bump, BumpMap::Normals { .. })
}

fn is_bump(bump: &BumpMap) -> bool {
    !is_normal_map(bump)
}

fn has_pattern<R>(material: &Material<R>, test: fn(&Pattern) -> bool) -> bool {
    let Some(textures) = &material.textures else { return false };
    [&textures.diffuse, &textures.ambient].into_iter().flatten().any(test)
}

fn has_bumps<R>(material: &Material<R>, test: fn(&BumpMap) -> bool) -> bool {
    let Some(textures) = &material.textures else { return false };
    [&textures.bump, &textures.clearcoat].into_iter().flatten().any(test)
}

/// Checkers become the mean of their two colors.
fn forget_checkers<R: Real>(material: &mut Material<R>) {
    for color in [Some(&mut material.diffuse), material.ambient.as_mut()].into_iter().flatten() {
        if let BaseColor::Checker { a, b, .. } = *color {
            let half = R::from_f64(0.5);
            *color = BaseColor::Uniform(std::array::from_fn(|c| (a[c] + b[c]) * half));
        }
    }
}

/// Patterns become their mean, which stands beside them.
fn forget_patterns<R>(material: &mut Material<R>, test: fn(&Pattern) -> bool) {
    change(material, |textures| {
        for pattern in [&mut textures.diffuse, &mut textures.ambient] {
            pattern.take_if(|pattern| test(pattern));
        }
    });
}

fn forget_bumps<R>(material: &mut Material<R>, test: fn(&BumpMap) -> bool) {
    change(material, |textures| {
        for bump in [&mut textures.bump, &mut textures.clearcoat] {
            bump.take_if(|bump| test(bump));
        }
    });
}

/// Changes the textures of a material, and forgets them if nothing is left.
fn change<R>(material: &mut Material<R>, change: impl Fn(&mut Textures)) {
    let Some(textures) = &mut material.textures else { return };
    change(textures);
    if textures.is_plain() {
        material.textures = None;
    }
}

fn shadow_catcher<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let asking =
        facts.description.materials.iter().filter(|(_, m)| m.pbr.as_ref().is_some_and(|pbr| pbr.shadow_catcher));
    let because: Vec<String> =
        asking.map(|(name, _)| push_token(&push_token("/materials", name), "pbr")).take(MAX_POINTERS).collect();
    match (on, because.is_empty()) {
        (true, _) => EffectReason::asked("surfaces show the shadows of lights alone", because),
        (false, false) => EffectReason::asked("no light casts shadows on them, or no object uses them", because),
        (false, true) => EffectReason::off("no surface shows shadows alone"),
    }
}

fn smooth_normals<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        EffectReason::asked("meshes interpolate their normals", facts.pointers.smooth.clone())
    } else {
        EffectReason::off("no mesh has normals")
    }
}
