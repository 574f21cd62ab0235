//! r_s L_s + r_t L_t: the reflected and the transmitted ray.

use super::crossing::{Crossing, bend, between, cross};
use super::distant_lights::CERTAIN;
use super::facets::{Facets, facets};
use super::footprint::curvatures;
use super::fresnel::{AtAngles, Bent, at_angles, conductors, into_varnish};
use super::interface::Interface;
use super::kernel::{Tracer, stage};
use super::observer::{NotFollowed, Observer};
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::{Choice, child};
use super::shaded::Shaded;
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::scene::effects::Effect;
use crate::shading::material::Coefficients;
use crate::shading::microfacet::{smith_g1, visible_facet};
use crate::shading::optics::{Refraction, reflect};

/// Stacks the rays that leave from what the rays hit, the transmitted one on top of the reflected one. The share that the
/// dielectric of lobes has reflected comes back: 0 where that is not known.
#[inline(always)]
pub(super) fn scatter<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    shaded: Shaded<'_, L>,
) -> L {
    stage::<L, V, _>(
        tracer.s,
        #[inline(always)]
        || scatter_in(tracer, shaded),
    )
}

#[inline(always)]
fn scatter_in<L: Lanes, O: Observer<L>, V: Variant>(tracer: &mut Tracer<'_, L, O, V>, shaded: Shaded<'_, L>) -> L {
    let Shaded { rays, hits, coefficients, lobes, .. } = shaded;
    let s = tracer.s;
    let zero = L::lit(s, 0.0);
    if !V::SECONDARY {
        return zero;
    }
    let r_s = coefficients.reflection;
    let mut mirror = r_s.x.max(r_s.y).max(r_s.z).gt(zero).bits() & hits.found;
    if V::DETAILS && tracer.world.angular {
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
        end_at_max_depth(tracer, shaded, [mirror, clear]);
        return zero;
    }

    let rough = if V::DETAILS && tracer.world.effects.has(Effect::Gloss) {
        coefficients.alpha.gt(zero).bits() & (mirror | clear)
    } else {
        0
    };
    let between = if clear != 0 { Some(between(tracer, rays, hits, clear)) } else { None };
    let facets = choose_facets(tracer, shaded, between.as_ref(), [rough, clear]);
    let curvature = if V::FOOTPRINTS && tracer.world.has_footprints() {
        curvatures(s, tracer.world, hits, mirror | clear)
    } else {
        zero
    };
    let mut crossing = match between {
        Some(between) => Some(cross(tracer, rays, hits, facets.ns, clear, [rough, facets.lossless], between)),
        None => None,
    };
    if let Some(crossing) = &mut crossing {
        spread_through_sheets(s, shaded, &facets, clear, crossing);
    }
    let shares = shares(tracer, shaded, facets.ns, crossing.as_ref(), clear);
    let mut reflected_weight = rays.weight.times(shares.r_s);
    let (mut passing, mut cone) = (None, [zero; 3]);
    let (mut total, mut split) = (0, 0);
    if let Some(crossing) = &crossing {
        let of = transmitted(tracer, shaded, &facets, &shares, curvature, clear, crossing, &mut reflected_weight);
        (total, split, cone) = (of.total, of.split, of.cone);
        passing = Some(of.rays);
    }
    let everywhere = if tracer.world.rules.spd_counts { clear } else { total };
    let reflecting = mirror | everywhere;
    if reflecting != 0 {
        send_reflected(tracer, shaded, &facets, curvature, reflected_weight, reflecting, split | shares.tinted);
    }
    if let Some(passing) = passing
        && passing.active != 0
    {
        if V::FOOTPRINTS {
            tracer.cones.next = cone;
        }
        tracer.send(passing);
    }
    shares.layer
}

/// What passes surfaces.
struct Passing<L: Lanes> {
    rays: RayPacket<L>,
    cone: [L; 3],
    /// The lanes where it is reflected instead: by total internal reflection.
    total: u32,
    /// The lanes whose reflected light is of one wavelength.
    split: u32,
}

/// The transmitted rays. What is reflected totally joins what is reflected anyhow, whose weight is given.
#[inline(always)]
fn transmitted<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    Shaded { rays, hits, coefficients, number, .. }: Shaded<'_, L>,
    facets: &Chosen<L>,
    shares: &AtAngles<L>,
    curvature: L,
    clear: u32,
    crossing: &Crossing<L>,
    reflected_weight: &mut V3<L>,
) -> Passing<L> {
    let s = tracer.s;
    let zero = L::lit(s, 0.0);
    let total = crossing.refraction.total.bits() & clear & hits.closed;
    tracer.counts.total_internal_reflections += u64::from(total.count_ones());
    if O::WATCHING {
        tracer.observer.refracts(number, crossing.snell(s));
    }
    // Under total internal reflection r_t joins r_s; dielectrics have none left.
    let mut weight = rays.weight.times(shares.r_t);
    *reflected_weight = V3::select(L::mask(s, total), *reflected_weight + weight, *reflected_weight);
    let (mut split, mut split_mirrored) = (0, 0);
    if V::DETAILS && tracer.world.effects.has(Effect::Dispersion) {
        // Light is split where it is bent, and where its reflection depends on the index.
        let [before, behind] = crossing.dispersion;
        split = before.max(behind).gt(zero).bits() & clear & !rays.dispersed;
        weight = V3::select(L::mask(s, split), weight.times(tracer.wavelengths.color), weight);
        split_mirrored = if tracer.world.angular { split } else { split & total };
        let mask = L::mask(s, split_mirrored);
        *reflected_weight = V3::select(mask, reflected_weight.times(tracer.wavelengths.color), *reflected_weight);
    }
    let mut active = clear & !total;
    if facets.rough != 0 {
        // Facets of an invisible surface hide nothing.
        let seen = facets.rough & !crossing.unseen;
        active &= crossing.dir.dot(hits.ng).lt(zero).bits() | !seen;
        let open = smith_g1(s, hits.ns, crossing.dir, coefficients.alpha);
        let kept = weight * L::select(L::mask(s, facets.lossless), facets.kept[1], open);
        weight = V3::select(L::mask(s, seen), kept, weight);
    }
    // Invisible surfaces leave a ray's origin as it is, so that what lies behind is hit at the same bits.
    let unseen = L::mask(s, crossing.unseen);
    let mut cone = [zero; 3];
    if V::FOOTPRINTS {
        let Refraction { cos_incident, cos_transmitted, .. } = crossing.refraction;
        let eta = crossing.n1 / crossing.n2;
        cone = tracer.cones.transmitted(s, curvature, eta, eta * cos_incident - cos_transmitted, unseen);
    }
    let behind = hits.surface.leave(-hits.ng);
    let rays = RayPacket {
        origin: V3::select(unseen, rays.origin, behind),
        dir: crossing.dir,
        t_min: L::select(unseen, hits.t, zero),
        weight,
        active,
        media: crossing.media,
        depth: rays.depth + 1,
        kind: RayKind::Transmitted,
        straight: rays.straight,
        gathered: rays.gathered,
        path: child(rays.path, RayKind::Transmitted),
        dispersed: rays.dispersed | split | shares.tinted,
        parent: number,
    };
    Passing { rays, cone, total, split: split_mirrored }
}

/// Sends the reflected rays of `active` lanes; the light of those that are `split` is of one wavelength.
#[inline(always)]
fn send_reflected<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    Shaded { rays, hits, coefficients, lobes, number }: Shaded<'_, L>,
    facets: &Chosen<L>,
    curvature: L,
    mut weight: V3<L>,
    mut active: u32,
    split: u32,
) {
    let s = tracer.s;
    let zero = L::lit(s, 0.0);
    let rough = facets.rough;
    let mut dir = reflect(s, rays.dir, facets.ns);
    if rough != 0 {
        // Light that facets reflect below the surface is lost, but for those of lobes.
        let above = dir.dot(hits.ng).gt(zero).bits() & dir.dot(hits.ns).gt(zero).bits();
        active &= above | !rough;
        let open = smith_g1(s, hits.ns, dir, coefficients.alpha);
        let kept = weight * L::select(L::mask(s, facets.lossless), facets.kept[0], open);
        weight = V3::select(L::mask(s, rough), kept, weight);
    }
    let tilted = if V::DETAILS { tracer.cones.tilted } else { 0 };
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
        weight,
        active,
        media: rays.media,
        depth: rays.depth + 1,
        kind: RayKind::Reflected,
        straight: false,
        gathered: rays.gathered,
        path: child(rays.path, RayKind::Reflected),
        dispersed: rays.dispersed | split,
        parent: number,
    });
}

/// Leaves out the rays of `mirror` and `clear` lanes, which would be deeper than any may be.
#[inline(always)]
fn end_at_max_depth<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    shaded: Shaded<'_, L>,
    [mirror, clear]: [u32; 2],
) {
    let Shaded { rays, hits, coefficients, number, .. } = shaded;
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
            AtAngles { r_s, r_t, .. } = angular(tracer, shaded, hits.ns, crossing.as_ref(), clear);
        }
        report_end(tracer, rays, [r_s, r_t], mirror, clear, number);
    }
}

/// The normals that rays of a sample leave by.
struct Chosen<L: Lanes> {
    /// The lanes of rough surfaces.
    rough: u32,
    /// Those of facets there, and of surfaces elsewhere.
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
    Shaded { rays, hits, coefficients, lobes, .. }: Shaded<'_, L>,
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
    Chosen { rough, ns, lossless, kept }
}

/// Facets of a thin sheet spread what passes as they spread what they reflect (glTF, KHR_materials_transmission).
#[inline(always)]
fn spread_through_sheets<L: Lanes>(
    s: L::Simd,
    Shaded { rays, hits, lobes, .. }: Shaded<'_, L>,
    facets: &Chosen<L>,
    clear: u32,
    crossing: &mut Crossing<L>,
) {
    let sheets = match lobes {
        Some(lobes) => facets.rough & clear & lobes.lanes & !hits.closed,
        None => 0,
    };
    if sheets != 0 {
        let out = reflect(s, rays.dir, facets.ns);
        let through = out - hits.ns * (L::lit(s, 2.0) * out.dot(hits.ns));
        crossing.dir = V3::select(L::mask(s, sheets), through, crossing.dir);
    }
}

/// The shares of the light that are reflected and pass, in the color of its wavelength where that matters.
#[inline(always)]
fn shares<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    shaded: Shaded<'_, L>,
    ns: V3<L>,
    crossing: Option<&Crossing<L>>,
    clear: u32,
) -> AtAngles<L> {
    let s = tracer.s;
    if !(V::DETAILS && tracer.world.angular) {
        let Coefficients { reflection, transmission, .. } = *shaded.coefficients;
        return AtAngles { r_s: reflection, r_t: transmission, tinted: 0, layer: L::lit(s, 0.0) };
    }
    let mut shares = angular(tracer, shaded, ns, crossing, clear);
    shares.tinted &= !shaded.rays.dispersed;
    if shares.tinted != 0 {
        let mask = L::mask(s, shares.tinted);
        shares.r_s = V3::select(mask, shares.r_s.times(tracer.wavelengths.color), shares.r_s);
        shares.r_t = V3::select(mask, shares.r_t.times(tracer.wavelengths.color), shares.r_t);
    }
    shares
}

/// r_s and r_t where they depend on the angle of incidence, and the lanes where they do on the wavelength, too.
#[inline(always)]
fn angular<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &Tracer<'_, L, O, V>,
    shaded: Shaded<'_, L>,
    ns: V3<L>,
    crossing: Option<&Crossing<L>>,
    clear: u32,
) -> AtAngles<L> {
    let bent = match crossing {
        Some(Crossing { n1, n2, refraction, .. }) => {
            Some(Bent { lanes: clear & shaded.hits.closed, eta: *n1 / *n2, refraction })
        }
        None => None,
    };
    at_angles(tracer.s, tracer.world, &tracer.media, shaded, ns, bent, bend(tracer))
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
