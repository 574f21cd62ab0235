//! Attenuation of light between two surfaces: bodies absorb it, e^(-sigma d) after Beer and Lambert, and outside of them fog
//! replaces it by its own light.

use super::ray_packet::RayPacket;
use crate::lanes::{Ids, Lanes, Real, V3, exp_minus, opacity};
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::shading::media::{Media, MediumList, OUTSIDE};

/// Attenuation along rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attenuation<L: Lanes> {
    /// The share of light that passes.
    pub(super) transmittance: V3<L>,
    /// Radiance that fog adds.
    pub(super) added: V3<L>,
}

/// The attenuation of rays over a length, which is infinite where they hit nothing.
pub(super) fn attenuate<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    rays: &RayPacket<L>,
    length: L,
) -> Attenuation<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || attenuate_in(s, world, media, rays, length),
    )
}

#[inline(always)]
fn attenuate_in<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    rays: &RayPacket<L>,
    length: L,
) -> Attenuation<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let black = V3 { x: zero, y: zero, z: zero };
    let mut attenuation = Attenuation { transmittance: V3 { x: one, y: one, z: one }, added: black };
    if world.effects.has(Effect::Absorption) {
        let sigma = absorption(s, world, media, rays.media, rays.active);
        attenuation.transmittance = beer_lambert(s, depth(s, sigma, length));
    }
    if let Some(fog) = &world.fog {
        let outside = rays.media.eq(L::Ids::splat(s, u64::from(OUTSIDE)));
        let depth = fog.optical_depth(s, rays.start().y, rays.dir.y, length);
        let depth = L::select(outside, depth, zero);
        attenuation.transmittance = attenuation.transmittance * exp_minus(s, depth);
        attenuation.added = V3::splat(s, fog.color) * opacity(s, depth);
    }
    attenuation
}

/// sigma in the media `lists` of rays: that of the body that decides.
#[inline(always)]
pub(super) fn absorption<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    lists: L::Ids,
    lanes: u32,
) -> V3<L> {
    let mut all = V3::splat(s, [L::Real::from_f64(0.0); 3]);
    let mut left = lanes;
    while left != 0 {
        let (list, same) = lists.same_as_first(s, left);
        left &= !same;
        if let Some(medium) = media.deciding(list as MediumList) {
            let item = world.owner(medium.body).item;
            // A cavity is empty.
            if !item.hollow {
                let sigma = V3::splat(s, world.materials[item.material as usize].absorption);
                all = V3::select(L::mask(s, same), sigma, all);
            }
        }
    }
    all
}

/// sigma times length; 0 where sigma is 0, even over an infinite length.
#[inline(always)]
pub(super) fn depth<L: Lanes>(s: L::Simd, sigma: V3<L>, length: L) -> V3<L> {
    let zero = L::lit(s, 0.0);
    V3 {
        x: L::select(sigma.x.gt(zero), sigma.x * length, zero),
        y: L::select(sigma.y.gt(zero), sigma.y * length, zero),
        z: L::select(sigma.z.gt(zero), sigma.z * length, zero),
    }
}

/// e^-depth.
#[inline(always)]
pub(super) fn beer_lambert<L: Lanes>(s: L::Simd, depth: V3<L>) -> V3<L> {
    V3 { x: exp_minus(s, depth.x), y: exp_minus(s, depth.y), z: exp_minus(s, depth.z) }
}
