//! How rays cross surfaces: the media on both sides, and the way that light is bent.

use super::hits::Hits;
use super::interface::{Interface, interface};
use super::kernel::{Tracer, first};
use super::observer::{Observer, Snell};
use super::ray_packet::RayPacket;
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};
use crate::math;
use crate::scene::effects::Effect;
use crate::shading::optics::{Refraction, fresnel_dielectric, refract};

/// How far the indices of refraction are from their means for the light of the samples, if anything disperses.
#[inline(always)]
pub(super) fn bend<L: Lanes, O: Observer<L>, V: Variant>(tracer: &Tracer<'_, L, O, V>) -> Option<L> {
    let disperses = V::DETAILS && tracer.world.effects.has(Effect::Dispersion);
    disperses.then_some(tracer.wavelengths.bend)
}

/// The crossing of a surface.
pub(super) struct Crossing<L: Lanes> {
    pub(super) n1: L,
    pub(super) n2: L,
    pub(super) refraction: Refraction<L>,
    /// Mean dispersion in front of the surface and behind it.
    pub(super) dispersion: [L; 2],
    pub(super) dir: V3<L>,
    /// The media behind the surface.
    pub(super) media: L::Ids,
    /// Lanes whose surface lies between equal media and is invisible.
    pub(super) unseen: u32,
}

impl<L: Lanes> Crossing<L> {
    /// For a tree: of the first lane.
    pub(super) fn snell(&self, s: L::Simd) -> Snell {
        let sine = first(self.refraction.sin_incident);
        // The arc tangent of sine and cosine is exact for small angles, where the arc cosine is not.
        let angle = |sine: f64, cosine: L| math::atan2(sine, first(cosine));
        Snell {
            n1: first(self.n1),
            n2: first(self.n2),
            theta1: angle(sine, self.refraction.cos_incident),
            theta2: angle(sine * first(self.n1) / first(self.n2), self.refraction.cos_transmitted),
            total: self.refraction.total.bits() & 1 != 0,
            reflectance: first(fresnel_dielectric(s, self.n1 / self.n2, &self.refraction)),
        }
    }
}

/// Cosine and sine of the largest angle between a facet and the normal by which it bends light, 15 degrees: that of a round body
/// of 12 facets. Normals that are interpolated from a sharp rim down a long facet lean further, and would make prisms of flat
/// walls.
const LEANING: [f64; 2] = [0.965_925_826_289_068_3, 0.258_819_045_102_520_76];

/// Interpolated normals that lean no further from those of their facets.
#[inline(always)]
fn upright<L: Lanes>(s: L::Simd, ns: V3<L>, ng: V3<L>) -> V3<L> {
    let [cos, sin] = LEANING.map(
        #[inline(always)]
        |x| L::lit(s, x),
    );
    let along = ns.dot(ng);
    let across = ns - ng * along;
    let turned = ng * cos + across * (sin / across.length());
    V3::select(along.lt(cos), turned, ns)
}

/// The media on both sides of a surface, for the light of the samples.
#[inline(always)]
pub(super) fn between<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    clear: u32,
) -> Interface<L> {
    let mut between = interface(tracer.s, tracer.world, &mut tracer.media, hits, rays.media, clear & hits.closed);
    if V::DETAILS && tracer.world.effects.has(Effect::Dispersion) {
        between.n1 = between.n1 + between.dispersion[0] * tracer.wavelengths.bend;
        between.n2 = between.n2 + between.dispersion[1] * tracer.wavelengths.bend;
    }
    between
}

/// The way through surfaces with normals `ns`, in lanes that are `clear`. Of these some are `rough`, and the facets of `lossless` ones
/// have been chosen with what they do.
#[inline(always)]
pub(super) fn cross<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    mut ns: V3<L>,
    clear: u32,
    [rough, lossless]: [u32; 2],
    Interface { n1, n2, dispersion, behind }: Interface<L>,
) -> Crossing<L> {
    let s = tracer.s;
    let eta = n1 / n2;
    let tilted = if V::DETAILS { tracer.cones.tilted } else { 0 };
    let curved = hits.smooth & !tilted & !rough & clear;
    if curved != 0 {
        ns = V3::select(L::mask(s, curved), upright(s, ns, hits.ng), ns);
    }
    let mut refraction = refract(s, rays.dir, ns, eta);
    // Those of lobes have been chosen with what they do.
    let bent = (hits.smooth | tilted) & !lossless;
    if bent != 0 {
        // As with mirrors: where the interpolated normal would keep the ray on its side, the geometric one decides. Facets of
        // rough surfaces beside may do so, too, and stay. Total reflection is as well for the geometric normal to say: else light
        // that passes a wall would be shut in by it. Bumps are meant to lean.
        let tilted = L::mask(s, tilted);
        let below = refraction.dir.dot(hits.ng).lt(L::lit(s, 0.0)) & !refraction.total;
        let below = below | (refraction.total & tilted) | !L::mask(s, bent);
        let flat = refract(s, rays.dir, hits.ng, eta);
        refraction = Refraction {
            dir: V3::select(below, refraction.dir, flat.dir),
            sin_incident: L::select(below, refraction.sin_incident, flat.sin_incident),
            cos_incident: L::select(below, refraction.cos_incident, flat.cos_incident),
            cos_transmitted: L::select(below, refraction.cos_transmitted, flat.cos_transmitted),
            total: (below & refraction.total) | (!below & flat.total),
        };
    }
    // Through equal media the direction is the same to the last bit.
    let equal = eta.eq(L::lit(s, 1.0));
    let dir = V3::select(equal, rays.dir, refraction.dir.normalized(s));
    let equal = equal.bits() & clear;
    let unseen = if equal == 0 { 0 } else { hits.perfectly_clear(tracer.world, equal) };
    Crossing { n1, n2, refraction, dispersion, dir, media: behind, unseen }
}
