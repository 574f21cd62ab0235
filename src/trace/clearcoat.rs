//! The rays that clearcoat reflects by itself: with global illumination, since it has facets of its own, and where its normal is not that
//! of the surface below, which has another mirror ray.

use super::distant_lights::CERTAIN;
use super::facets::{CHOICES, again, threshold};
use super::footprint::curvatures;
use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::{Choice, child};
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};
use crate::scene::effects::Effect;
use crate::shading::lobes::Lobes;
use crate::shading::microfacet::{smith_g1, visible_facet};
use crate::shading::optics::reflect;

/// Stacks the rays of clearcoat.
#[inline(never)]
pub(super) fn scatter_clearcoat<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    lobes: &Lobes<L>,
    number: u32,
) {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || {
            let s = tracer.s;
            let zero = L::lit(s, 0.0);
            let coated = lobes.clearcoat_by_rays.gt(zero).bits() & lobes.lanes & hits.found;
            if coated == 0 {
                return;
            }
            let weight = rays.weight * lobes.clearcoat_by_rays;
            if rays.depth >= tracer.world.rules.max_depth {
                tracer.omit_children(coated, weight, rays.depth + 1, false);
                if O::WATCHING {
                    tracer.observer.not_followed(number, RayKind::Reflected, weight, NotFollowed::Depth);
                }
                return;
            }
            let (n, width, to_eye) = (lobes.clearcoat_ns, lobes.clearcoat_facets, -rays.dir);
            let rough = width.gt(zero);
            let facet = if rough.any() { facets(tracer, rays, hits, lobes, rough.bits() & coated) } else { n };
            let mut dir = reflect(s, rays.dir, facet);
            let of_surface = tracer.cones.next;
            let apart = lobes.apart & coated;
            let even = L::mask(s, apart) & !rough;
            if apart != 0 {
                // A normal that leans may send the mirrored ray below the surface; the geometric one does not.
                let above = dir.dot(hits.ng).gt(zero) | !even;
                dir = V3::select(above, dir, reflect(s, rays.dir, hits.ng));
                if tracer.world.has_footprints() {
                    let curvature = curvatures(s, tracer.world, hits, apart);
                    tracer.cones.next = tracer.cones.mirrored(s, curvature);
                }
            }
            let dir = dir.normalized(s);
            let above = dir.dot(hits.ng).gt(zero) & (dir.dot(n).gt(zero) | even);
            let mut density = zero;
            if tracer.world.effects.has(Effect::GlobalIllumination) {
                density = L::select(rough, lobes.clearcoat_pdf(s, dir, to_eye), L::lit(s, CERTAIN));
            }
            tracer.cones.chosen(density);
            tracer.send(RayPacket {
                origin: hits.surface.leave(hits.ng),
                dir,
                t_min: zero,
                weight,
                active: coated & above.bits(),
                media: rays.media,
                depth: rays.depth + 1,
                kind: RayKind::Reflected,
                straight: false,
                gathered: rays.gathered,
                // Beside the ray that the surface below reflects.
                path: child(!rays.path, RayKind::Reflected),
                dispersed: rays.dispersed,
                parent: number,
            });
            tracer.cones.next = of_surface;
        },
    );
}

/// Facets of the clearcoat in some lanes, of which none is hidden (`facets.rs`).
#[inline(always)]
fn facets<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    lobes: &Lobes<L>,
    lanes: u32,
) -> V3<L> {
    let s = tracer.s;
    let (n, width, zero) = (lobes.clearcoat_ns, lobes.clearcoat_facets, L::lit(s, 0.0));
    let (mut all, mut left) = (n, lanes);
    for choice in 0..CHOICES {
        let square = tracer.sampler.square(s, again(rays.path, choice), Choice::Clearcoat);
        let facet = visible_facet(s, n, -rays.dir, width, square);
        let out = reflect(s, rays.dir, facet);
        let above = out.dot(hits.ng).gt(zero) & out.dot(n).gt(zero);
        let open = L::select(above, smith_g1(s, n, out, width), zero);
        // Beside the one of the surface below.
        let chosen = threshold::<L>(s, &tracer.sampler, rays.path ^ 0x5555_5555, choice).lt(open) & L::mask(s, left);
        all = V3::select(chosen, facet, all);
        left &= !chosen.bits();
        if left == 0 {
            break;
        }
    }
    all
}
