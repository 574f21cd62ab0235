//! Takes out of a world what no picture of it can show, so that its kernels need not know of it.
//!
//! By the counting rules of the SPD rays are traced that add nothing, so there all of it stays.

use super::ceiling::{can_measure_reach, of_light};
use crate::lanes::Real;
use crate::scene::world::{World, shows};
use crate::shading::light::{Falloff, Light};
use crate::shading::material::Material;
use crate::shading::texture::checker::BaseColor;

/// Light that surfaces gather, if none of them scatters any, and ambient light that no surface has a color for. Gathered light
/// takes the place of ambient light wherever it is asked for, but for what wide lobes of `pbr` materials reflect.
pub(super) fn remove_ambient_light<R: Real>(world: &mut World<R>) {
    let bleeds_in_vain = world.rules.gathers() && !world.has_material(|material, _| scatters(material));
    if bleeds_in_vain {
        world.rules.color_bleeding = false;
        world.materials.iter_mut().filter(|material| material.pbr.is_none()).for_each(forget_ambient);
    }
    let reflects = |material: &Material<R>| {
        is_colored(material.ambient.as_ref().unwrap_or(&material.diffuse)) || material.catches_shadows()
    };
    if !world.has_material(|material, _| reflects(material)) {
        world.ambient = [R::from_f64(0.0); 3];
    }
}

/// Lights that are black, shine on nothing that scatters them or end before any surface (where that is soon measured), then patterns
/// and bumps that nothing makes visible. Bounds do not depend on any of it, and name lights by their number.
pub(super) fn remove_unlit<R: Real>(world: &mut World<R>) {
    if !world.is_lit() {
        // What would mirror lights is as clear as if it did not.
        world.materials.iter_mut().for_each(|material| material.specular = [R::from_f64(0.0); 3]);
    }
    if world.rules.spd_counts {
        return;
    }
    let scattered = world.has_material(|material, _| receives(material));
    let measured = can_measure_reach(world);
    let arrives = |light: &Light<R>| match light.falloff {
        Falloff::Linear { .. } | Falloff::Windowed { .. } if measured => {
            let used = of_light(world, light, measured).into_iter().zip(&world.usage.materials);
            used.filter(|(_, used)| used.anywhere).any(|(strength, _)| strength > 0.0)
        }
        _ => true,
    };
    let kept = world.lights.iter().filter(|light| scattered && shows(light.color) && arrives(light)).copied().collect();
    world.lights = kept;
    let lit = world.is_lit();
    let scattering =
        lit || world.rules.gathers() || world.rules.has_global_illumination() || world.surroundings.is_some();
    let ambient = shows(world.ambient);
    for material in &mut world.materials {
        let own_ambient = material.ambient.is_some();
        let diffuse = scattering || (ambient && !own_ambient);
        let tilts = scattering && scatters(material) || shows(material.specular);
        let bumps = tilts || material.mirrors() || material.transmits() || material.pbr.is_some();
        if let Some(textures) = &mut material.textures {
            textures.diffuse.take_if(|_| !diffuse);
            textures.ambient.take_if(|_| !ambient);
            textures.bump.take_if(|_| !bumps);
            if textures.is_plain() {
                material.textures = None;
            }
        }
        forget_checker(&mut material.diffuse, diffuse);
        if let Some(color) = &mut material.ambient {
            forget_checker(color, ambient);
        }
    }
}

/// A material without a color for ambient light.
fn forget_ambient<R: Real>(material: &mut Material<R>) {
    material.ambient = Some(BaseColor::Uniform([R::from_f64(0.0); 3]));
    if let Some(textures) = &mut material.textures {
        (textures.ambient, textures.own_ambient) = (None, true);
    }
}

/// Whether it shows the light of lights.
pub(super) fn receives<R: Real>(material: &Material<R>) -> bool {
    scatters(material) || shows(material.specular) || material.catches_shadows()
}

pub(super) fn scatters<R: Real>(material: &Material<R>) -> bool {
    is_colored(&material.diffuse)
}

fn is_colored<R: Real>(color: &BaseColor<R>) -> bool {
    match *color {
        BaseColor::Uniform(color) => shows(color),
        BaseColor::Checker { a, b, .. } => shows(a) || shows(b),
    }
}

/// A checker that nobody sees has one of its colors.
fn forget_checker<R: Real>(color: &mut BaseColor<R>, seen: bool) {
    if let (BaseColor::Checker { a, .. }, false) = (&*color, seen) {
        *color = BaseColor::Uniform(*a);
    }
}
