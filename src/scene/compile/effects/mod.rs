//! The rules of the table of effects.
//!
//! An effect is on exactly if the world that the kernels read holds it. So rules look at the world, as it was built in its
//! precision, and at the description only to say which keys ask for an effect and why it cannot show.

mod approximations;
mod choices;
mod light;
mod picture;
mod rays;
mod recursion;
mod rule;
mod self_shadowing;
mod surfaces;

pub(super) use choices::disperses;
pub(super) use picture::refines;
pub(super) use rule::{Facts, black};
pub(super) use self_shadowing::casts_no_shadow;

use super::prune;
use crate::accel::Blockers;
use crate::lanes::Real;
use crate::scene::effects::{Effect, Entry};
use crate::scene::world::World;
use crate::shading::material::{Fresnel, Material};
use rule::Rule;

/// Sets all of a world that follows from the rest: its effects above all.
pub(super) fn derive_flags<R: Real>(world: &mut World<R>) {
    let any = |kind: fn(&Material<R>) -> bool| world.has_material(|material, _| kind(material));
    let (transmits, reflects) = (any(Material::transmits), any(Material::mirrors));
    let conducts = world.has_material(|material, _| matches!(material.fresnel, Fresnel::Conductor | Fresnel::Layered));
    (world.transmits, world.reflects) = (transmits, reflects);
    let has_holes = world.has_material(|material, _| material.has_holes());
    if world.rules.shadows.is_some_and(|blockers| blockers != Blockers::Transmissive || !transmits) {
        // Where no body transmits light, the first one on the way decides, unless it may be only partly there.
        world.rules.shadows = Some(if has_holes { Blockers::Holed } else { Blockers::Opaque });
    }
    world.effects = rules().iter().filter(|rule| rule.is_on(world)).map(|rule| rule.effect).collect();
    // Light that grazes a conductor is mirrored completely: where no ray is followed, this much is lacking.
    world.angular = world.effects.has(Effect::Fresnel) || conducts;
    let layered = world.effects.has(Effect::MetallicRoughness);
    world.branches = world.effects.has(Effect::GlobalIllumination)
        && (layered || world.has_material(|material, _| branches(material)));
}

/// Whether a surface scatters light and sends it on in other ways as well.
fn branches<R: Real>(material: &Material<R>) -> bool {
    let scatters = prune::scatters(material) || material.textures.as_ref().is_some_and(|own| own.diffuse.is_some());
    scatters && (material.mirrors() || material.transmits())
}

/// The table of a scene.
pub(super) fn table<R: Real>(facts: &Facts<'_, R>) -> Vec<Entry> {
    let mut table: Vec<Entry> = rules().iter().map(|rule| rule.explain(facts)).collect();
    table.push(picture::antialiasing(facts));
    table.sort_by_key(|entry| entry.effect as u32);
    table
}

/// Takes an effect out of a world; false where that would make another scene of it, as with hollow bodies, and with shadows that hide lights which are
/// not there any more.
pub(super) fn remove<R: Real>(effect: Effect, world: &mut World<R>) -> bool {
    if effect == Effect::Shadows && world.hides_lights {
        return false;
    }
    let rules = rules();
    let Some(remove) = rules.iter().find(|rule| rule.effect == effect).and_then(|rule| rule.remove) else {
        return false;
    };
    remove(world);
    prune::remove_ambient_light(world);
    prune::remove_unlit(world);
    derive_flags(world);
    true
}

/// All but antialiasing, which is no matter of the world.
fn rules<R: Real>() -> Vec<Rule<R>> {
    [light::rules(), rays::rules(), surfaces::rules(), choices::rules(), picture::rules()]
        .into_iter()
        .flatten()
        .collect()
}
