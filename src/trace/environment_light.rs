//! Light from the surroundings at the surfaces that a packet hits, without a sample ([`Surroundings`]).

use super::hits::Hits;
use super::ray_packet::RayPacket;
use crate::lanes::{Column, Columns, Lanes, Mask, V3, parts};
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;
use crate::shading::optics::reflect;
use crate::shading::surroundings::Surroundings;

/// What surfaces send to the rays of the light from all around. `gathers`: whether what is scattered is gathered by rays instead.
#[inline(never)]
pub(super) fn light_from_around<L: Lanes>(
    s: L::Simd,
    surroundings: &Surroundings,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    gathers: bool,
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let zero = L::lit(s, 0.0);
            let mut light = V3 { x: zero, y: zero, z: zero };
            if !gathers {
                light = coefficients.diffuse.times(surroundings.scattered(s, hits.ns));
            }
            let Some(lobes) = lobes else { return light };
            let [blurred, clearcoat] = [
                lobes.blurred,
                V3 { x: lobes.clearcoat_blurred, y: lobes.clearcoat_blurred, z: lobes.clearcoat_blurred },
            ];
            let here = lobes.lanes & hits.found;
            let own = seen(s, surroundings, reflect(s, rays.dir, hits.ns), lobes.roughness, blurred, here);
            let mirrored = reflect(s, rays.dir, lobes.clearcoat_ns);
            let all = light + own + seen(s, surroundings, mirrored, lobes.clearcoat_roughness, clearcoat, here);
            V3::select(L::mask(s, lobes.lanes), all * lobes.occlusion, light)
        },
    )
}

/// A share of what lobes of a roughness see around directions, in the lanes of some where it is not 0.
#[inline(always)]
fn seen<L: Lanes>(
    s: L::Simd,
    surroundings: &Surroundings,
    dir: V3<L>,
    roughness: L,
    share: V3<L>,
    lanes: u32,
) -> V3<L> {
    let lanes = share.x.max(share.y).max(share.z).gt(L::lit(s, 0.0)).bits() & lanes;
    share.times(around(s, surroundings, dir, roughness, lanes))
}

/// What lobes of a roughness see around directions, in some lanes.
#[inline(always)]
fn around<L: Lanes>(s: L::Simd, surroundings: &Surroundings, dir: V3<L>, roughness: L, lanes: u32) -> V3<L> {
    let mut seen = Columns::of(V3::<L>::splat(s, [L::Real::default(); 3]));
    if lanes == 0 {
        return seen.lanes(s);
    }
    let (dirs, roughness) = (Columns::of(dir), Column::of(roughness));
    for (first, lanes) in parts::<L>(lanes) {
        let light = surroundings.reflected(s, dirs.part::<L::Double>(s, first), roughness.part(s, first), lanes);
        seen.put(s, first, L::Double::mask(s, lanes), light);
    }
    seen.lanes(s)
}
