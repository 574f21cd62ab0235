//! r_s L_s + r_t L_t: the reflected and the transmitted ray.

use super::distant_lights::CERTAIN;
use super::facets::{Facets, facets};
use super::footprint::curvatures;
use super::fresnel::{AtAngles, Bent, at_angles, conductors, into_varnish};
use super::hits::Hits;
use super::interface::{Interface, interface};
use super::kernel::{Tracer, first, stage};
use super::observer::{NotFollowed, Observer, Snell};
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::{Choice, child};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::math;
use crate::scene::effects::Effect;
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;
use crate::shading::microfacet::{smith_g1, visible_facet};
use crate::shading::optics::{Refraction, fresnel_dielectric, reflect, refract};
use crate::trace::variants::Variant;

/// Stacks the rays that leave from what the rays hit, the transmitted one on top of the reflected one. The share that the
/// dielectric of lobes has reflected comes back: 0 where that is not known.
#[inline(always)]
pub(super) fn scatter<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    number: u32,
) -> L {
    stage::<L, V, _>(
        tracer.s,
        #[inline(always)]
        || scatter_in(tracer, rays, hits, coefficients, lobes, number),
    )
}

#[inline(always)]
fn scatter_in<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    number: u32,
) -> L {
    let s = tracer.s;
    let zero = L::lit(s, 0.0);
    if !V::SECONDARY {
        return zero;
    }
    let tilted = if V::DETAILS { tracer.cones.tilted } else { 0 };
    let (mut r_s, mut r_t) = (coefficients.reflection, coefficients.transmission);
    let mut mirror = r_s.x.max(r_s.y).max(r_s.z).gt(zero).bits() & hits.found;
    let by_angle = V::DETAILS && tracer.world.angular;
    if by_angle {
        mirror |= conductors(s, tracer.world, hits);
        if let Some(lobes) = lobes {
            mirror |= lobes.mirrored & hits.found;
        }
    }
    let mut clear = hits.transmissive & hits.found;
    if mirror | clear == 0 {
        return zero;
    }
    if !tracer.world.transmits {
        // What bodies transmit was taken out of the scene.
        clear = 0;
    }
    if rays.depth >= tracer.world.rules.max_depth {
        end_at_max_depth(tracer, rays, hits, coefficients, lobes, [mirror, clear], number);
        return zero;
    }

    let rough = if V::DETAILS && tracer.world.effects.has(Effect::Gloss) {
        coefficients.alpha.gt(zero).bits() & (mirror | clear)
    } else {
        0
    };
    let between = if clear != 0 { Some(between(tracer, rays, hits, clear)) } else { None };
    let Chosen { ns, lossless, kept } =
        choose_facets(tracer, rays, hits, coefficients, lobes, between.as_ref(), [rough, clear]);
    let curvature = if V::FOOTPRINTS && tracer.world.has_footprints() {
        curvatures(s, tracer.world, hits, mirror | clear)
    } else {
        zero
    };
    let mut crossing = match between {
        Some(between) => Some(cross(tracer, rays, hits, ns, clear, [rough, lossless], between)),
        None => None,
    };
    let sheets = lobes.map_or(0, |lobes| rough & clear & lobes.lanes & !hits.closed);
    if sheets != 0
        && let Some(crossing) = &mut crossing
    {
        // Facets of a thin sheet spread what passes as they spread what they reflect (glTF, KHR_materials_transmission).
        let out = reflect(s, rays.dir, ns);
        let through = out - hits.ns * (L::lit(s, 2.0) * out.dot(hits.ns));
        crossing.dir = V3::select(L::mask(s, sheets), through, crossing.dir);
    }
    let (mut tinted, mut layer) = (0, zero);
    if by_angle {
        AtAngles { r_s, r_t, tinted, layer } =
            angular(tracer, rays, hits, ns, coefficients, lobes, crossing.as_ref(), clear);
        tinted &= !rays.dispersed;
        if tinted != 0 {
            let mask = L::mask(s, tinted);
            r_s = V3::select(mask, r_s.times(tracer.wavelengths.color), r_s);
            r_t = V3::select(mask, r_t.times(tracer.wavelengths.color), r_t);
        }
    }
    let mut reflected_weight = rays.weight.times(r_s);
    let mut transmitted = None;
    let mut through = [zero; 3];
    let (mut total, mut split, mut split_mirrored) = (0, 0, 0);
    if let Some(crossing) = crossing {
        total = crossing.refraction.total.bits() & clear & hits.closed;
        tracer.counts.total_internal_reflections += u64::from(total.count_ones());
        if O::WATCHING {
            tracer.observer.refracts(number, crossing.snell(s));
        }
        // Under total internal reflection r_t joins r_s; dielectrics have none left.
        let joined = reflected_weight + rays.weight.times(r_t);
        reflected_weight = V3::select(L::mask(s, total), joined, reflected_weight);
        let mut transmitted_weight = rays.weight.times(r_t);
        if V::DETAILS && tracer.world.effects.has(Effect::Dispersion) {
            // Light is split where it is bent, and where its reflection depends on the index.
            let [before, behind] = crossing.dispersion;
            split = before.max(behind).gt(zero).bits() & clear & !rays.dispersed;
            let mask = L::mask(s, split);
            transmitted_weight =
                V3::select(mask, transmitted_weight.times(tracer.wavelengths.color), transmitted_weight);
            split_mirrored = if by_angle { split } else { split & total };
            let mask = L::mask(s, split_mirrored);
            reflected_weight = V3::select(mask, reflected_weight.times(tracer.wavelengths.color), reflected_weight);
        }
        let mut active = clear & !total;
        if rough != 0 {
            // Facets of an invisible surface hide nothing.
            let facets = rough & !crossing.unseen;
            active &= crossing.dir.dot(hits.ng).lt(zero).bits() | !facets;
            let open = smith_g1(s, hits.ns, crossing.dir, coefficients.alpha);
            let weight = transmitted_weight * L::select(L::mask(s, lossless), kept[1], open);
            transmitted_weight = V3::select(L::mask(s, facets), weight, transmitted_weight);
        }
        // Invisible surfaces leave a ray's origin as it is, so that what lies behind is hit at the same bits.
        let unseen = L::mask(s, crossing.unseen);
        if V::FOOTPRINTS {
            let Refraction { cos_incident, cos_transmitted, .. } = crossing.refraction;
            let eta = crossing.n1 / crossing.n2;
            through = tracer.cones.transmitted(s, curvature, eta, eta * cos_incident - cos_transmitted, unseen);
        }
        let behind = hits.surface.leave(-hits.ng);
        transmitted = Some(RayPacket {
            origin: V3::select(unseen, rays.origin, behind),
            dir: crossing.dir,
            t_min: L::select(unseen, hits.t, zero),
            weight: transmitted_weight,
            active,
            media: crossing.media,
            depth: rays.depth + 1,
            kind: RayKind::Transmitted,
            straight: rays.straight,
            gathered: rays.gathered,
            path: child(rays.path, RayKind::Transmitted),
            dispersed: rays.dispersed | split | tinted,
            parent: number,
        });
    }

    let everywhere = if tracer.world.rules.spd_counts { clear } else { total };
    let reflecting = mirror | everywhere;
    if reflecting != 0 {
        let mut dir = reflect(s, rays.dir, ns);
        let mut active = reflecting;
        if rough != 0 {
            // Light that facets reflect below the surface is lost, but for those of lobes.
            let above = dir.dot(hits.ng).gt(zero).bits() & dir.dot(hits.ns).gt(zero).bits();
            active &= above | !rough;
            let open = smith_g1(s, hits.ns, dir, coefficients.alpha);
            let weight = reflected_weight * L::select(L::mask(s, lossless), kept[0], open);
            reflected_weight = V3::select(L::mask(s, rough), weight, reflected_weight);
        }
        if (hits.smooth | tilted) & !rough != 0 {
            // An interpolated normal may send the mirrored ray below the surface; the geometric one does not.
            let above = dir.dot(hits.ng).gt(zero);
            dir = V3::select(above, dir, reflect(s, rays.dir, hits.ng));
        }
        if V::FOOTPRINTS {
            tracer.cones.next = tracer.cones.mirrored(s, curvature);
            if let Some(lobes) = lobes
                && tracer.world.effects.has(Effect::GlobalIllumination)
            {
                let density = lobes.pdf(s, hits.ns, dir, -rays.dir);
                let density = L::select(L::mask(s, rough), density, L::lit(s, CERTAIN));
                tracer.cones.chosen(L::select(L::mask(s, lobes.lanes), density, zero));
            }
        }
        tracer.send(RayPacket {
            origin: hits.surface.leave(hits.ng),
            dir: dir.normalized(s),
            t_min: zero,
            weight: reflected_weight,
            active,
            media: rays.media,
            depth: rays.depth + 1,
            kind: RayKind::Reflected,
            straight: false,
            gathered: rays.gathered,
            path: child(rays.path, RayKind::Reflected),
            dispersed: rays.dispersed | split_mirrored | tinted,
            parent: number,
        });
    }
    if let Some(transmitted) = transmitted
        && transmitted.active != 0
    {
        if V::FOOTPRINTS {
            tracer.cones.next = through;
        }
        tracer.send(transmitted);
    }
    layer
}

/// Leaves out the rays of `mirror` and `clear` lanes, which would be deeper than any may be.
#[inline(always)]
fn end_at_max_depth<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    [mirror, clear]: [u32; 2],
    number: u32,
) {
    let s = tracer.s;
    let by_angle = V::DETAILS && tracer.world.angular;
    let (mut r_s, mut r_t) = (coefficients.reflection, coefficients.transmission);
    // An upper bound at any angle: conductors reflect grazing light completely.
    let mut most = r_s + r_t;
    if by_angle {
        let one = V3::splat(s, [L::Real::from_f64(1.0); 3]);
        most = V3 { x: most.x.max(one.x), y: most.y.max(one.y), z: most.z.max(one.z) };
    }
    tracer.omit_children(mirror | clear, rays.weight.times(most), rays.depth + 1, false);
    if rays.straight && tracer.is_transparent() {
        let most = if by_angle { V3::splat(s, [L::Real::from_f64(1.0); 3]) } else { r_t };
        tracer.record_unseen(L::mask(s, clear), rays.weight.times(most), rays.depth + 1);
    }
    if O::WATCHING {
        if by_angle {
            let crossing = if clear != 0 {
                let between = between(tracer, rays, hits, clear);
                Some(cross(tracer, rays, hits, hits.ns, clear, [0, 0], between))
            } else {
                None
            };
            AtAngles { r_s, r_t, .. } =
                angular(tracer, rays, hits, hits.ns, coefficients, lobes, crossing.as_ref(), clear);
        }
        report_end(tracer, rays, [r_s, r_t], mirror, clear, number);
    }
}

/// The normals that rays of a sample leave by.
struct Chosen<L: Lanes> {
    /// Those of facets where surfaces are rough.
    ns: V3<L>,
    /// The lanes of lobes, whose facets lose no light.
    lossless: u32,
    /// Of these the shares of the light that are reflected and that pass.
    kept: [L; 2],
}

/// Chooses a facet for each of the lanes that are `rough`.
#[inline(always)]
fn choose_facets<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    between: Option<&Interface<L>>,
    [rough, clear]: [u32; 2],
) -> Chosen<L> {
    let s = tracer.s;
    let zero = L::lit(s, 0.0);
    let mut ns = hits.ns;
    let mut lossless = 0;
    let mut kept = [zero; 2];
    if rough != 0 {
        let chosen = tracer.sampler.square(s, rays.path, Choice::Facet);
        let facet = visible_facet(s, hits.ns, -rays.dir, coefficients.alpha, chosen);
        ns = V3::select(L::mask(s, rough), facet, ns);
        if let Some(lobes) = lobes
            && rough & lobes.lanes != 0
        {
            lossless = rough & lobes.lanes;
            let eta = match between {
                Some(between) if clear & lossless != 0 => {
                    let sheets = into_varnish(s, tracer.world, &tracer.media, rays, hits, bend(tracer));
                    L::select(L::mask(s, hits.closed), between.n1 / between.n2, sheets)
                }
                _ => L::lit(s, 1.0),
            };
            let Facets { normal, reflected, passed } = facets(tracer, rays, hits, lobes, lossless, clear, eta);
            (ns, kept) = (V3::select(L::mask(s, lossless), normal, ns), [reflected, passed]);
        }
    }
    Chosen { ns, lossless, kept }
}

/// r_s and r_t where they depend on the angle of incidence, and the lanes where they do on the wavelength, too.
#[inline(always)]
fn angular<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    ns: V3<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    crossing: Option<&Crossing<L>>,
    clear: u32,
) -> AtAngles<L> {
    let bent = match crossing {
        Some(Crossing { n1, n2, refraction, .. }) => {
            Some(Bent { lanes: clear & hits.closed, eta: *n1 / *n2, refraction })
        }
        None => None,
    };
    at_angles(tracer.s, tracer.world, &tracer.media, rays, hits, ns, coefficients, lobes, bent, bend(tracer))
}

/// How far the indices of refraction are from their means for the light of the samples, if anything disperses.
#[inline(always)]
fn bend<L: Lanes, O: Observer<L>, V: Variant>(tracer: &Tracer<'_, L, O, V>) -> Option<L> {
    let disperses = V::DETAILS && tracer.world.effects.has(Effect::Dispersion);
    disperses.then_some(tracer.wavelengths.bend)
}

/// The crossing of a surface.
struct Crossing<L: Lanes> {
    n1: L,
    n2: L,
    refraction: Refraction<L>,
    /// Mean dispersion in front of the surface and behind it.
    dispersion: [L; 2],
    dir: V3<L>,
    /// The media behind the surface.
    media: L::Ids,
    /// Lanes whose surface lies between equal media and is invisible.
    unseen: u32,
}

impl<L: Lanes> Crossing<L> {
    fn snell(&self, s: L::Simd) -> Snell {
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
fn between<L: Lanes, O: Observer<L>, V: Variant>(
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

#[inline(always)]
fn cross<L: Lanes, O: Observer<L>, V: Variant>(
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

/// Reports the rays that `max_depth` has cut off.
fn report_end<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    [r_s, r_t]: [V3<L>; 2],
    mirror: u32,
    clear: u32,
    number: u32,
) {
    for (kind, lanes, factor) in [(RayKind::Reflected, mirror, r_s), (RayKind::Transmitted, clear, r_t)] {
        if lanes != 0 {
            tracer.observer.not_followed(number, kind, rays.weight.times(factor), NotFollowed::Depth);
        }
    }
}
