//! How each metallic-roughness material is done, and how far that is off: what plans say of them.
//!
//! The figures are means over 120 directions in a studio with white walls and panels of light, in 8-bit codes, against integrals of 1,024
//! samples.

use super::rule::{EffectReason, Facts};
use crate::enum_names::list;
use crate::lanes::Real;
use crate::scene::description::Pbr;
use crate::scene::effects::MAX_POINTERS;
use crate::scene::problem::push_token;
use crate::shading::lobes::{CLEARCOAT, MIRROR, NARROWEST};

/// Codes that one mirror ray is off by roughness, of metals and of what is none.
const MIRROR_RAY: [&[[f64; 2]]; 2] = [&[[0.0, 0.0], [0.05, 0.3], [0.1, 2.4]], &[[0.0, 0.0], [0.05, 0.05], [0.1, 0.3]]];

/// Codes that surroundings blurred by the roughness are off, of metals and of what is none.
const BLURRED: [&[[f64; 2]]; 2] = [
    &[[0.0, 0.2], [0.1, 0.8], [0.2, 3.0], [0.3, 5.7], [0.5, 6.0], [0.6, 5.2], [1.0, 4.4]],
    &[[0.0, 0.1], [0.1, 0.2], [0.2, 0.6], [0.3, 1.0], [0.5, 0.9], [0.6, 0.6], [1.0, 0.2]],
];

pub(super) fn metallic_roughness<R: Real>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let used = &facts.world.usage.materials;
    let all =
        facts.description.materials.iter().enumerate().filter_map(|(i, (name, m))| Some((i, name, m.pbr.as_deref()?)));
    let (seen, unseen): (Vec<_>, Vec<_>) = all.partition(|(i, ..)| used[*i].anywhere);
    let pointers = |of: &[(usize, &String, &Pbr)]| -> Vec<String> {
        let pointer = |name| push_token(&push_token("/materials", name), "pbr");
        of.iter().take(MAX_POINTERS).map(|(_, name, _)| pointer(name)).collect()
    };
    if !on {
        return match unseen.is_empty() {
            true => EffectReason::off("no material is written as in glTF"),
            false => EffectReason::asked("only materials of which no object can be seen ask for it", pointers(&unseen)),
        };
    }
    let global_illumination = facts.world.rules.has_global_illumination();
    let lit_by_surroundings = facts.world.surroundings.is_some();
    let described = seen.iter().take(MAX_POINTERS).map(|(_, name, pbr)| {
        let how = if global_illumination { by_rays(pbr) } else { how(pbr, lit_by_surroundings) };
        format!("{name}: {how}")
    });
    EffectReason::asked(described.collect::<Vec<_>>().join("; "), pointers(&seen))
}

/// How a material is simulated with global illumination.
fn by_rays(pbr: &Pbr) -> String {
    if pbr.shadow_catcher || pbr.unlit {
        return how(pbr, false);
    }
    let mut parts = vec!["highlights of lights in closed form".to_owned(), "rays for what is scattered".to_owned()];
    let roughness = pbr.roughness.factor();
    parts.push(match pbr.roughness.textured() {
        None if roughness * roughness <= NARROWEST => format!("mirror rays for roughness {roughness}"),
        None => format!("rays by GGX facets for roughness {roughness}"),
        Some(_) => "rays by GGX facets of the roughness in the picture".to_owned(),
    });
    if pbr.clearcoat.factor() > 0.0 {
        parts.push("rays of its own for the clearcoat".to_owned());
    }
    list(parts.into_iter(), "and")
}

/// How a material is done.
fn how(pbr: &Pbr, lit_by_surroundings: bool) -> String {
    if pbr.shadow_catcher {
        return "shadows alone".to_owned();
    }
    if pbr.unlit {
        return "unlit".to_owned();
    }
    let mut parts = vec!["highlights of lights in closed form".to_owned()];
    let roughness = pbr.roughness.factor();
    let metal = pbr.metallic.factor() >= 0.5;
    let limit = if metal { 0.5 * MIRROR } else { MIRROR };
    let blurred = if lit_by_surroundings { "blurred surroundings" } else { "ambient light" };
    parts.push(match pbr.roughness.textured() {
        Some(_) => format!("mirror rays where roughness is at most {limit}, elsewhere {blurred}"),
        None if roughness <= limit => {
            let codes = interpolated(MIRROR_RAY[usize::from(!metal)], roughness);
            format!("mirror rays for roughness {roughness}, about {codes:.1} codes off")
        }
        None if lit_by_surroundings => {
            let codes = interpolated(BLURRED[usize::from(!metal)], roughness);
            format!("{blurred} for roughness {roughness}, about {codes:.1} codes off")
        }
        None => format!("{blurred} in place of reflections, since roughness is {roughness}"),
    });
    if pbr.transmission.factor() > 0.0 && !(pbr.roughness.textured().is_none() && roughness <= MIRROR) {
        parts.push("light that passes is not spread".to_owned());
    }
    let leans = pbr.normal != pbr.clearcoat_normal;
    let mirrors = pbr.clearcoat_roughness.textured().is_some() || pbr.clearcoat_roughness.factor() < CLEARCOAT[1];
    if leans && mirrors && pbr.clearcoat.factor() > 0.0 {
        parts.push("mirror rays of its own for the clearcoat".to_owned());
    }
    list(parts.into_iter(), "and")
}

/// Between the figures of a table.
fn interpolated(table: &[[f64; 2]], x: f64) -> f64 {
    let pair = table.windows(2).find(|pair| x <= pair[1][0]);
    let Some([[a, f], [b, g]]) = pair.map(|pair| [pair[0], pair[1]]) else { return table[table.len() - 1][1] };
    f + (g - f) * ((x - a) / (b - a)).clamp(0.0, 1.0)
}
