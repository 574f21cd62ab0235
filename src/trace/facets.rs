//! The facets of rough surfaces that reflect and pass light by rays, where no light may be lost among them.
//!
//! Of the facets that the eye sees, others hide some from where their light goes, and send on what they hide. So a facet whose
//! light is hidden is chosen again: then each stands for as much light as there is, whatever the roughness and the index of
//! refraction, as in Turquin's compensation (Practical multiple scattering compensation for microfacet models, 2019), which
//! divides by the mean share that is not hidden. Weights of one sample are at most 1 by that, as ceilings need them.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::ray_packet::RayPacket;
use super::sampling::{Choice, Sampler};
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};
use crate::shading::lobes::Lobes;
use crate::shading::microfacet::{smith_g1, visible_facet};
use crate::shading::optics::{fresnel_dielectric, reflect, refract};

/// How often a facet is chosen at most. Of the roughest surfaces some 0.7 of the facets are hidden.
pub(super) const CHOICES: u32 = 16;

/// Facets, and the factors on what they reflect and on what passes them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facets<L: Lanes> {
    pub(super) normal: V3<L>,
    pub(super) reflected: L,
    pub(super) passed: L,
}

/// The place of a choice among those of a sample at a place in the tree, the first of which takes the sample's own coordinates.
pub(super) fn again(path: u32, choice: u32) -> u32 {
    path ^ choice.wrapping_mul(0x9e37_79b9)
}

/// A number in [0, 1) for each lane, independent of the facet of that choice.
#[inline(always)]
pub(super) fn threshold<L: Lanes>(s: L::Simd, sampler: &Sampler, path: u32, choice: u32) -> L {
    let [number, _] = sampler.square(s, !again(path, choice), Choice::Hidden);
    number
}

/// Facets in some lanes, all of which have lobes. Light passes in those of `clear`, from n1 into n2 with `eta` = n1/n2.
#[inline(never)]
pub(super) fn facets<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    lobes: &Lobes<L>,
    lanes: u32,
    clear: u32,
    eta: L,
) -> Facets<L> {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || {
            let s = tracer.s;
            let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
            let (width, to_eye) = (lobes.facets, -rays.dir);
            let (passes, closed) = (L::mask(s, clear & lanes), L::mask(s, hits.closed));
            let mut all = Facets { normal: hits.ns, reflected: one, passed: one };
            let mut left = lanes;
            for choice in 0..CHOICES {
                let square = tracer.sampler.square(s, again(rays.path, choice), Choice::Facet);
                let facet = visible_facet(s, hits.ns, to_eye, width, square);
                let out = reflect(s, rays.dir, facet);
                let above = out.dot(hits.ng).gt(zero) & out.dot(hits.ns).gt(zero);
                let reflected = L::select(above, smith_g1(s, hits.ns, out, width), zero);
                let (mut passed, mut open) = (zero, reflected);
                if passes.any() {
                    let refraction = refract(s, rays.dir, facet, eta);
                    let reflectance = fresnel_dielectric(s, eta, &refraction);
                    let reflectance = L::select(eta.eq(one), zero, reflectance);
                    // As in `secondary.rs`: sheets spread what passes as they spread what they reflect.
                    let mirrored = out - hits.ns * (L::lit(s, 2.0) * out.dot(hits.ns));
                    let through = V3::select(closed, refraction.dir.normalized(s), mirrored);
                    let below = through.dot(hits.ng).lt(zero) & !(refraction.total & closed);
                    passed = L::select(below & passes, smith_g1(s, hits.ns, through, width), zero);
                    let [mirrors, lets_in] = lobes.leaving(s, reflectance, to_eye.dot(facet));
                    let shares = (mirrors * reflected + lets_in * passed) / (mirrors + lets_in);
                    // Total reflection mirrors all that would pass.
                    let parts = passes & !(refraction.total & closed) & (mirrors + lets_in).gt(zero);
                    open = L::select(parts, shares, open);
                }
                let chosen = threshold::<L>(s, &tracer.sampler, rays.path, choice).lt(open) & L::mask(s, left);
                all.normal = V3::select(chosen, facet, all.normal);
                all.reflected = L::select(chosen, reflected / open, all.reflected);
                all.passed = L::select(chosen, passed / open, all.passed);
                left &= !chosen.bits();
                if left == 0 {
                    break;
                }
            }
            all
        },
    )
}
