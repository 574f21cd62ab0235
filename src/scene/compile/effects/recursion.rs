//! Whether any ray that leaves a surface is followed.

use super::rule::EffectReason;
use crate::lanes::Real;
use crate::scene::description::Description;
use crate::scene::world::{Pruning, World};
use crate::shading::material::{Fresnel, Material};

/// Why none is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// Only camera rays are asked for.
    Depth,
    /// None is heavy enough.
    Weight,
}

/// Share by which a weight must lie below `min_weight`, since both are rounded.
const MARGIN: f64 = 1e-5;

impl Cut {
    /// What cuts off all of them, if anything does.
    pub(super) fn of<R: Real>(world: &World<R>) -> Option<Self> {
        match world.rules.pruning {
            _ if world.rules.max_depth == 1 => Some(Self::Depth),
            Pruning::Weight(least) if !world.rules.spd_counts && heaviest(world) * (1.0 + MARGIN) < least => {
                Some(Self::Weight)
            }
            _ => None,
        }
    }

    /// The reason for effects of such rays.
    pub(super) fn reason(self, description: &Description) -> EffectReason {
        match self {
            Self::Depth => EffectReason::asked_at("max_depth is 1: only camera rays are followed", "/render/max_depth"),
            Self::Weight => {
                let least = description.render.fixed_weight();
                let reason = format!("min_weight is {least}: no ray is heavy enough to be followed");
                EffectReason::asked_at(reason, "/render/min_weight")
            }
        }
    }
}

/// The largest weight that a ray may have which leaves what the camera sees.
fn heaviest<R: Real>(world: &World<R>) -> f64 {
    let used = world.materials.iter().zip(&world.usage.materials).filter(|(_, used)| used.anywhere);
    let heaviest = used.map(|(material, _)| sends(material)).fold(0.0, f64::max);
    // A single wavelength weighs more than white.
    let split = world.spectrum.as_ref().map_or(1.0, |spectrum| spectrum.strongest().max_element());
    heaviest * split.max(1.0)
}

/// The most of its light that a surface sends on with one ray: under total internal reflection r_t joins r_s. Where nothing is
/// followed angles are not asked for, so dielectrics count as if both did not depend on them.
fn sends<R: Real>(material: &Material<R>) -> f64 {
    let channel = |c: usize| {
        let (r_s, r_t) = (material.reflection[c].to_f64(), material.transmission[c].to_f64());
        let all_along = matches!(material.fresnel, Fresnel::Conductor | Fresnel::Layered);
        if all_along { (r_s + r_t).max(1.0) } else { r_s + r_t }
    };
    (0..3).map(channel).fold(0.0, f64::max)
}
