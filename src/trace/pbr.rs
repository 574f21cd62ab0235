//! The lobes of metallic-roughness materials that a packet hits, body by body: channels are looked up in double precision as
//! textures are, and what follows from them is worked out for all lanes at once.

use super::hits::Hits;
use super::ray_packet::RayPacket;
use super::texturing::Seen;
use crate::lanes::{Column, Columns, Ids, Lanes, Mask, V3, parts};
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;
use crate::shading::pbr::{NUMBERS, Parameters};

/// The lobes under the rays, none if no ray has hit such a material; the coefficients take over what they say. `widths` are
/// those of the cones at the hits, and `clearcoat` are the normals of clearcoat.
#[inline(never)]
pub(super) fn lobes_of<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &RayPacket<L>,
    widths: L,
    clearcoat: V3<L>,
    hits: &Hits<L>,
    coefficients: &mut Coefficients<L>,
) -> Option<Lobes<L>> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let (parameters, lanes) = parameters(s, world, rays.dir, widths, hits);
            if lanes == 0 {
                return None;
            }
            // Not by `map`, whose closure is compiled for SSE2 in arrays as long as this.
            let mut numbers = [L::lit(s, 0.0); NUMBERS];
            for (number, column) in numbers.iter_mut().zip(&parameters) {
                *number = column.lanes::<L>(s);
            }
            let parameters = Parameters::of_numbers(numbers);
            let global_illumination = world.effects.has(Effect::GlobalIllumination);
            let (mut apart, mut clearcoat_ns) = (0, hits.ns);
            if world.effects.has(Effect::NormalMapping) {
                // Within a body its surface alone says what stays inside: total reflection loses nothing to clearcoat that leans.
                let inside = hits.closed & hits.transmissive & !hits.entering;
                apart = !clearcoat.eq(hits.ns).bits() & lanes & !inside;
                clearcoat_ns = V3::select(L::mask(s, apart), clearcoat, hits.ns);
            }
            let lobes = Lobes::of(s, &parameters, lanes, -rays.dir, hits.ns, clearcoat_ns, apart, global_illumination);
            let mask = L::mask(s, lanes);
            let c = coefficients;
            c.ambient = V3::select(mask, lobes.ambient, c.ambient);
            c.diffuse = V3::select(mask, lobes.scattered, c.diffuse);
            c.specular = V3::select(mask, V3::splat(s, [L::Real::default(); 3]), c.specular);
            c.reflection = V3::select(mask, lobes.reflection, c.reflection);
            c.transmission = V3::select(mask, lobes.transmission, c.transmission);
            c.alpha = L::select(mask, lobes.facets, c.alpha);
            Some(lobes)
        },
    )
}

/// The channels where rays have hit, and the lanes that have any.
#[inline(always)]
fn parameters<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    dir: V3<L>,
    widths: L,
    hits: &Hits<L>,
) -> ([Column; NUMBERS], u32) {
    let seen = Seen::new(dir, hits, widths);
    let mut numbers = [Column::of(L::lit(s, 0.0)); NUMBERS];
    let (mut left, mut known) = (hits.found, 0);
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        let (material, alike) = hits.material.same_as_first(s, left);
        let Some(pbr) = &world.materials[material as usize].pbr else {
            left &= !alike;
            continue;
        };
        let owner = world.owner(hits.expanded.lane(lane));
        let same = owner.lanes::<L>(s, hits.expanded, alike);
        left &= !same;
        known |= same;
        for (first, lanes) in parts::<L>(same) {
            let mask = L::Double::mask(s, lanes);
            let lookup = seen.part::<L::Double>(s, first).lookup::<L>(s, &owner, hits, first, lanes);
            for (column, number) in numbers.iter_mut().zip(pbr.at(s, &lookup).to_numbers()) {
                column.put(s, first, mask, number);
            }
        }
    }
    (numbers, known)
}

/// The lanes in which rays in directions `dir` have hit what may be only partly there, how much of it is there, and the share of
/// light that passes what is.
#[inline(always)]
pub(super) fn passage<L: Lanes>(s: L::Simd, world: &World<L::Real>, dir: V3<L>, hits: &Hits<L>) -> (u32, L, V3<L>) {
    let mut known = 0;
    let seen = Seen::new(dir, hits, L::lit(s, 0.0));
    let mut opacity = Column::of(L::lit(s, 1.0));
    let mut passed = Columns::of(V3::<L>::splat(s, [L::Real::default(); 3]));
    let mut left = hits.found;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        let (material, alike) = hits.material.same_as_first(s, left);
        let Some(pbr) = world.materials[material as usize].pbr.as_ref().filter(|pbr| pbr.has_holes()) else {
            left &= !alike;
            continue;
        };
        let owner = world.owner(hits.expanded.lane(lane));
        let same = owner.lanes::<L>(s, hits.expanded, alike);
        left &= !same;
        known |= same;
        for (first, lanes) in parts::<L>(same) {
            let mask = L::Double::mask(s, lanes);
            let lookup = seen.part::<L::Double>(s, first).lookup::<L>(s, &owner, hits, first, lanes);
            let (there, passes) = pbr.passage(s, &lookup);
            opacity.put(s, first, mask, there);
            passed.put(s, first, mask, passes);
        }
    }
    (known, opacity.lanes(s), passed.lanes(s))
}
