//! Highlights of lights with an area on lobes that are narrower than the light looks. Places of the area alone would find such a lobe
//! once in many samples, and then all of it at once: speckles. So a facet of the lobe looks for the light, too, and what both may find
//! is shared by the balance heuristic, as in `sampled_light.rs`. No ray is followed: the light is met by arithmetic.
//!
//! Rays that bring scattered light are lit by places of the area alone: what they would see are caustics. With global illumination, rays
//! of lobes find suns in the sky by themselves (`distant_lights.rs`), and these are left out here.

use super::hits::Hits;
use super::kernel::Tracer;
use super::lighting::{ShadowResult, cast_shadow_rays, is_negligible};
use super::observer::Observer;
use super::pixel_sum::PixelSum;
use super::ray_packet::{RayKind, RayPacket};
use super::sampled_light::balance_heuristic;
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};
use crate::shading::light::{Area, Light, Place};
use crate::shading::lobe_highlights::shares_of_limit;
use crate::shading::lobes::Lobes;
use crate::shading::microfacet::visible_facet;
use crate::shading::optics::reflect;

/// What narrow lobes reflect of a light, as factors on what white would scatter.
#[derive(Debug, Clone, Copy)]
pub(super) struct SoftHighlights<L: Lanes> {
    /// The lanes with such lobes.
    pub(super) lanes: u32,
    /// Of the place that was chosen on the light's area, with what is scattered.
    pub(super) of_place: V3<L>,
    /// Of the places that a facet of the surface and one of its clearcoat mirror.
    of_facets: [(V3<L>, Place<L>); 2],
}

impl<L: Lanes> SoftHighlights<L> {
    /// Those of a light with an area. The point `square` of the unit square has chosen a place, in the direction `to_place`, and chooses
    /// facets. None if no lobe is narrow.
    #[inline(never)]
    pub(super) fn find(
        s: L::Simd,
        light: &Light<L::Real>,
        area: &Area<L::Real>,
        rays: &RayPacket<L>,
        hits: &Hits<L>,
        lobes: &Lobes<L>,
        (place, to_place): (&Place<L>, V3<L>),
        square: [L; 2],
    ) -> Option<Self> {
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let point = hits.surface.point;
                // Of the middle: with one of the place at hand the shares of all places would not be those of one estimate.
                let narrow = lobes.narrower_than(s, light.middle_pdf(s, area, point));
                let lanes = (narrow[0] | narrow[1]) & hits.found;
                if lanes == 0 {
                    return None;
                }
                let (zero, one, to_eye) = (L::lit(s, 0.0), L::lit(s, 1.0), -rays.dir);
                let [surface, clearcoat] = [L::mask(s, narrow[0]), L::mask(s, narrow[1])];
                let (cosine, _) = lobes.faces(s, to_place, hits.ns.dot(to_place).max(zero));
                let pdf = light.chosen_pdf(s, area, point, place);
                let [own, over] = lobes.highlights(s, hits.ns, to_place, to_eye, cosine);
                let own = own.reflected * L::select(surface, balance_heuristic(pdf, own.density), one);
                let over = over.reflected * L::select(clearcoat, balance_heuristic(pdf, over.density), one);
                let of_place = lobes.scattered_of(s, to_place, to_eye, cosine) + own + over;

                let [normal, over_normal] = [hits.ns, lobes.clearcoat_ns];
                let [width, over_width] = lobes.widths();
                let facet = visible_facet(s, normal, to_eye, width, square);
                let dir = reflect(s, rays.dir, facet);
                let (pdf, place) = light.place_pdf(s, area, point, dir);
                let [mirrored, _] = lobes.highlights(s, normal, dir, to_eye, normal.dot(dir).max(zero));
                let mirrored = mirrored.reflected * L::select(surface, balance_heuristic(pdf, mirrored.density), zero);

                let facet = visible_facet(s, over_normal, to_eye, over_width, square);
                let dir = reflect(s, rays.dir, facet);
                let (over_pdf, over_place) = light.place_pdf(s, area, point, dir);
                let [_, coated] = lobes.highlights(s, normal, dir, to_eye, normal.dot(dir).max(zero));
                let coated = coated.reflected * L::select(clearcoat, balance_heuristic(over_pdf, coated.density), zero);

                let limit = match rays.kind {
                    RayKind::Camera => V3 { x: one, y: one, z: one },
                    _ => shares_of_limit(s, of_place + mirrored + coated),
                };
                let of_facets = [(mirrored.times(limit), place), (coated.times(limit), over_place)];
                Some(Self { lanes, of_place: of_place.times(limit), of_facets })
            },
        )
    }

    /// Adds what facets mirror of the light, where nothing hides it from the surface.
    #[inline(never)]
    pub(super) fn add<O: Observer<L>, V: Variant>(
        &self,
        tracer: &mut Tracer<'_, L, O, V>,
        rays: &RayPacket<L>,
        hits: &Hits<L>,
        index: usize,
        number: u32,
        sum: &mut PixelSum<L>,
    ) {
        L::vectorize(
            tracer.s,
            #[inline(always)]
            || {
                let (s, light) = (tracer.s, &tracer.world.lights[index]);
                let zero = L::lit(s, 0.0);
                for (factor, place) in &self.of_facets {
                    let arrival = light.arrive(s, hits.surface.point, place);
                    let facet_cosine = hits.ng.dot(arrival.to_light);
                    let facing = facet_cosine.gt(zero) | L::mask(s, hits.smooth);
                    let added = rays.weight.times(factor.times(V3::splat(s, light.color)) * arrival.strength);
                    // NaN, where nothing is met, is none.
                    let lit = L::mask(s, self.lanes) & facing & added.x.max(added.y).max(added.z).gt(zero);
                    if !lit.any() {
                        continue;
                    }
                    let negligible = is_negligible(tracer, lit, added, light, arrival.strength);
                    if negligible.any() {
                        tracer.counts.shadow_skipped += u64::from(negligible.bits().count_ones());
                        tracer.record_omitted_light(negligible, added);
                    }
                    let lit = lit & !negligible;
                    if !lit.any() {
                        continue;
                    }
                    let ShadowResult { origin, transmittance, .. } =
                        cast_shadow_rays(tracer, index, place, facet_cosine, hits.smooth, lit, rays, hits);
                    let added = tracer.bounded(added.times(transmittance));
                    sum.add(s, lit.bits(), added);
                    if O::WATCHING {
                        let added = V3::select(lit, added, V3 { x: zero, y: zero, z: zero });
                        tracer.observer.shadow(number, index, origin, arrival.to_light, transmittance, added);
                    }
                }
            },
        );
    }
}
