//! The media on both sides of the surfaces that rays cross.

use super::hits::{Hits, Touch};
use crate::lanes::{Ids, Lanes};
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::shading::media::{Media, MediumList};

/// The media on both sides of a surface, in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interface<L: Lanes> {
    /// Index of refraction on the side the ray comes from.
    pub n1: L,
    /// Index of refraction on the other side.
    pub n2: L,
    /// Mean dispersion on both sides; 0 where nothing in the world disperses.
    pub dispersion: [L; 2],
    /// The media of a ray on the other side.
    pub behind: L::Ids,
}

/// The media at the surfaces of closed bodies that the rays of some lanes have hit; these rays are in the media `lists`. In
/// other lanes both sides are empty space, and the list stays.
#[inline(always)]
pub(crate) fn interface<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &mut Media<L::Real>,
    hits: &Hits<L>,
    lists: L::Ids,
    lanes: u32,
) -> Interface<L> {
    let one = L::lit(s, 1.0);
    let mut all = Interface { n1: one, n2: one, dispersion: [L::lit(s, 0.0); 2], behind: lists };
    let mut left = lanes;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        let same = alike(s, hits, lists, lane, left);
        left &= !same;
        let (before, behind) = of_lane(world, media, hits, lists.lane(lane) as MediumList, lane);
        let mask = L::mask(s, same);
        let ior = |list: MediumList| L::splat(s, media.ior(list));
        all.n1 = L::select(mask, ior(before), all.n1);
        all.n2 = L::select(mask, ior(behind), all.n2);
        if world.effects.has(Effect::Dispersion) {
            let dispersion = |list: MediumList| L::splat(s, media.dispersion(list));
            let [first, second] = all.dispersion;
            all.dispersion = [L::select(mask, dispersion(before), first), L::select(mask, dispersion(behind), second)];
        }
        all.behind = L::Ids::select(mask, L::Ids::splat(s, u64::from(behind)), all.behind);
    }
    all
}

/// The lanes of `among` that cross the same surface as `lane`, the lowest of them, out of the same media.
#[inline(always)]
fn alike<L: Lanes>(s: L::Simd, hits: &Hits<L>, lists: L::Ids, lane: usize, among: u32) -> u32 {
    if !hits.touching.is_empty() {
        return 1 << lane;
    }
    let way = if hits.entering & (1 << lane) != 0 { hits.entering } else { !hits.entering };
    lists.same_as_first(s, among).1 & hits.body.same_as_first(s, among).1 & way
}

/// The lists of a ray in front of the surface and behind it.
#[inline(always)]
fn of_lane<L: Lanes>(
    world: &World<L::Real>,
    media: &mut Media<L::Real>,
    hits: &Hits<L>,
    list: MediumList,
    lane: usize,
) -> (MediumList, MediumList) {
    let medium = hits.medium(world, lane);
    let goes_in = hits.goes_in(lane);
    let before = if goes_in || media.contains(list, medium.body) { list } else { media.enter(list, medium) };
    let own = Touch { lane, goes_in, medium };
    let mut behind = before;
    for touch in hits.touching.iter().filter(|touch| touch.lane == lane).chain([&own]) {
        behind = if touch.goes_in { media.enter(behind, touch.medium) } else { media.leave(behind, touch.medium.body) };
    }
    (before, behind)
}
