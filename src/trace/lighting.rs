//! L_Phong: ambient light, and for each light a shadow ray and Phong's model.

use super::colored_shadows::absorption_transmittance;
use super::distant_lights::{is_seen, lobe_ray_transmittance, mis_weighted};
use super::hits::Hits;
use super::kernel::{Tracer, stage};
use super::observer::Observer;
use super::opacity::transmittance_with_holes;
use super::pixel_sum::PixelSum;
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::Choice;
use super::shaded::Shaded;
use super::soft_highlights::SoftHighlights;
use crate::accel::{Blockers, transmittance};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::{Rays, leave};
use crate::scene::effects::Effect;
use crate::scene::world::{Pruning, World};
use crate::shading::light::{Light, Place};
use crate::shading::lobe_highlights::limited;
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;
use crate::shading::phong::{highlight_cosine, power};
use crate::trace::variants::Variant;

/// Shadow rays end this many roundings before the light: a light that lies on a surface would be shadowed by it at random.
const LIGHT_MARGIN: f64 = 16.0;

/// A shadow ray is traced only if its light could add this share of `min_weight` to the pixel.
pub(crate) const SHADOW_SHARE: f64 = 0.25;

/// Cosine between light and facet below which shadow rays start on the curved surface that a smooth mesh approximates.
/// They move there gradually (as in Cycles, D11065), since nothing in between can cast a shadow.
const GRAZING: f64 = 0.1;

/// Cosine between light and facet from which on a flat or convex body hides nothing from its outside, whatever is rounded.
const CLEARLY: f64 = 1.0 / 64.0;

/// Adds the local illumination of what the rays hit to `sum`, and with it `own`, the light of details on the way and at the
/// surface.
#[inline(always)]
pub(super) fn illuminate<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    shaded: Shaded<'_, L>,
    own: V3<L>,
    sum: &mut PixelSum<L>,
) {
    stage::<L, V, _>(
        tracer.s,
        #[inline(always)]
        || illuminate_in(tracer, shaded, own, sum),
    );
}

#[inline(always)]
fn illuminate_in<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    Shaded { rays, hits, coefficients, lobes, number }: Shaded<'_, L>,
    own: V3<L>,
    sum: &mut PixelSum<L>,
) {
    let s = tracer.s;
    let world = tracer.world;
    // Gathered light takes the place of ambient light, but for what wide lobes reflect of it.
    let gathers = V::DETAILS && world.effects.has(Effect::ColorBleeding) && !rays.gathered;
    let mut share = coefficients.ambient;
    if gathers {
        let none = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        share = lobes.map_or(none, |lobes| V3::select(L::mask(s, lobes.lanes), lobes.reflected_from_around(), none));
    }
    let mut ambient = rays.weight.times(share.times(V3::splat(s, world.ambient)));
    if V::DETAILS {
        ambient = own + ambient;
    }
    let ambient = tracer.bounded(ambient);
    sum.add(s, hits.found, ambient);
    if O::WATCHING {
        tracer.observer.contributes(number, ambient);
    }
    if world.lights.is_empty() {
        return;
    }
    let zero = L::lit(s, 0.0);
    let found = L::mask(s, hits.found);
    // The SPD's rules count shadow rays from the facets, also those that add nothing.
    let spd = if world.rules.spd_counts { hits.found } else { 0 };
    let smooth = hits.smooth & !spd;
    for (index, light) in world.lights.iter().enumerate() {
        let mut place = light.middle(s);
        let mut chosen = None;
        if V::DETAILS
            && let Some(area) = &light.area
        {
            let square = tracer.sampler.square(s, rays.path, Choice::Light(index));
            place = light.place(s, area, hits.surface.point, square);
            chosen = Some((area, square));
        }
        let arrival = light.arrive(s, hits.surface.point, &place);
        let mut soft = None;
        if V::DETAILS
            && let (Some((area, square)), Some(lobes)) = (chosen, lobes)
            && !lobe_rays_reach(world, light, rays)
            && !brings_scattered_light(rays)
        {
            soft = SoftHighlights::find(s, light, area, rays, hits, lobes, (&place, arrival.to_light), square);
            if let Some(soft) = &soft {
                soft.add(tracer, rays, hits, index, number, sum);
            }
        }
        // NaN, at the light's own position, is neither side.
        let facet_cosine = hits.ng.dot(arrival.to_light);
        let facing = found & (facet_cosine.gt(zero) | L::mask(s, smooth));
        let mut cosine = hits.ns.dot(arrival.to_light);
        let mut faces = cosine.gt(zero);
        if V::DETAILS
            && let Some(lobes) = lobes
        {
            (cosine, faces) = lobes.faces(s, arrival.to_light, cosine);
        }
        let lit = facing & faces & arrival.strength.gt(zero);
        if !(lit | (facing & L::mask(s, spd))).any() {
            continue;
        }
        let mut radiance = phong(s, rays, hits, coefficients, light, arrival.to_light, cosine, arrival.strength, lit);
        if V::DETAILS
            && let Some(lobes) = lobes
        {
            let reflected = reflected(s, rays, hits, lobes, arrival.to_light, cosine);
            let reflected = match &soft {
                Some(soft) => V3::select(L::mask(s, soft.lanes), soft.of_place, reflected),
                None => reflected,
            };
            let of_lobes = reflected.times(V3::splat(s, light.color)) * arrival.strength;
            radiance = V3::select(L::mask(s, lobes.lanes), of_lobes, radiance);
        }
        let added = rays.weight.times(radiance);
        let negligible = is_negligible(tracer, lit, added, light, arrival.strength) & !L::mask(s, spd);
        if negligible.any() {
            tracer.counts.shadow_skipped += u64::from(negligible.bits().count_ones());
            tracer.record_omitted_light(negligible, added);
        }
        let lit = lit & !negligible;
        let cast = lit | (facing & L::mask(s, spd));
        if !cast.any() {
            continue;
        }
        let ShadowResult { origin, transmittance, cast } =
            cast_shadow_rays(tracer, index, &place, facet_cosine, smooth, cast, rays, hits);
        let mut arrived = radiance.times(transmittance);
        if V::DETAILS
            && let Some(lobes) = lobes
            && lobe_rays_reach(world, light, rays)
        {
            let shadow = shadow_rays(s, &place, origin, cast & L::mask(s, lobes.lanes));
            let transmittance = [transmittance, lobe_ray_transmittance(tracer, shadow, transmittance, rays, hits)];
            arrived =
                mis_weighted(s, light, &place, rays, hits, [coefficients.diffuse, radiance], lobes, transmittance);
        }
        let radiance = tracer.bounded(rays.weight.times(arrived));
        sum.add(s, lit.bits(), radiance);
        if O::WATCHING {
            let added = V3::select(lit, radiance, V3 { x: zero, y: zero, z: zero });
            tracer.observer.shadow(number, index, origin, arrival.to_light, transmittance, added);
        }
    }
}

/// Whether rays that leave from what `rays` hit find a light themselves.
#[inline(always)]
fn lobe_rays_reach<L: Lanes>(world: &World<L::Real>, light: &Light<L::Real>, rays: &RayPacket<L>) -> bool {
    rays.depth < world.rules.max_depth && is_seen::<L>(world, light)
}

/// Whether highlights on what rays meet would be caustics where they come from, which are not simulated: found one by one they are grain.
#[inline(always)]
fn brings_scattered_light<L: Lanes>(rays: &RayPacket<L>) -> bool {
    rays.gathered || rays.kind == RayKind::Gathered
}

/// Shadow rays from a surface to a place of a light, and what they found.
pub(super) struct ShadowResult<L: Lanes> {
    /// Where shadow rays start.
    pub(super) origin: V3<L>,
    /// The share of each channel that arrives.
    pub(super) transmittance: V3<L>,
    /// The lanes whose shadow rays were traced.
    pub(super) cast: L::Mask,
}

/// Casts shadow rays to a place of a light, in the lanes of `cast`. `facet_cosine` is that between the place and the facet.
#[inline(always)]
pub(super) fn cast_shadow_rays<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    light: usize,
    place: &Place<L>,
    facet_cosine: L,
    smooth: u32,
    mut cast: L::Mask,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
) -> ShadowResult<L> {
    let (s, world) = (tracer.s, tracer.world);
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let on_facets = smooth & cast.bits() == 0;
    let origin = if on_facets { hits.surface.leave(hits.ng) } else { from_curve(s, hits, facet_cosine, smooth) };
    let mut transmittance = V3 { x: one, y: one, z: one };
    if V::DETAILS
        && world.lights[light].area.is_some()
        && world.rules.shadows.is_some()
        && let Some(cells) = &world.light_cells
    {
        let [open, blocked] = cells.known(s, light, hits.surface.point, cast.bits());
        // From outside, where the light does not graze the surface.
        let outside = (hits.entering ^ hits.hollow) | !hits.closed;
        let open = open & outside & !smooth & facet_cosine.gt(L::lit(s, CLEARLY)).bits();
        transmittance = V3::select(L::mask(s, blocked), V3 { x: zero, y: zero, z: zero }, transmittance);
        cast = cast & !L::mask(s, open | blocked);
    }
    if let Some(blockers) = world.rules.shadows
        && cast.any()
    {
        tracer.count_shadow_rays(cast.bits());
        let shadow = shadow_rays(s, place, origin, cast);
        transmittance = V3::select(cast, shadow_transmittance(tracer, blockers, shadow, rays, hits), transmittance);
    }
    ShadowResult { origin, transmittance, cast }
}

/// The share of each channel that arrives along shadow rays from what `rays` hit.
#[inline(always)]
pub(super) fn shadow_transmittance<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    blockers: Blockers,
    shadow: Rays<L>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
) -> V3<L> {
    let (s, world, time) = (tracer.s, tracer.world, hits.time);
    let zero = L::lit(s, 0.0);
    let mut left = if V::DETAILS {
        transmittance_with_holes(s, world, blockers, shadow, rays.coherence(), time)
    } else {
        transmittance(s, &world.geometries, world.root, blockers, shadow, rays.coherence(), time.as_ref())
    };
    if V::DETAILS && world.effects.has(Effect::ColoredShadows) {
        let active = shadow.active & left.x.max(left.y).max(left.z).gt(zero);
        left = left.times(absorption_transmittance(
            s,
            world,
            &mut tracer.media,
            Rays { active, ..shadow },
            rays.media,
            time,
        ));
    }
    left
}

/// The lanes of `lit` whose light adds too little to the pixel for a shadow ray, even if nothing blocks it: less than a
/// quarter of the smallest weight followed, as a share of that light, or of 1 if it is brighter; or what the proof of a
/// pixel can do without.
#[inline(always)]
pub(super) fn is_negligible<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    lit: L::Mask,
    added: V3<L>,
    light: &Light<L::Real>,
    strength: L,
) -> L::Mask {
    if let Pruning::Proved { .. } = tracer.pruning {
        return tracer.may_skip_light(lit, added);
    }
    let s = tracer.s;
    let color = V3::<L>::splat(s, light.color);
    let brightness = color.x.max(color.y).max(color.z) * strength;
    let least = tracer.certificate.min_weight * L::lit(s, SHADOW_SHARE) * brightness.min(L::lit(s, 1.0));
    lit & !added.x.max(added.y).max(added.z).ge(least)
}

/// (k_d (N.L) + k_s (R.V)^m) I for one light.
#[inline(always)]
fn phong<L: Lanes>(
    s: L::Simd,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    light: &Light<L::Real>,
    to_light: V3<L>,
    cosine: L,
    strength: L,
    lit: L::Mask,
) -> V3<L> {
    let mut reflected = coefficients.diffuse * cosine;
    let zero = L::lit(s, 0.0);
    let ks = coefficients.specular;
    let shiny = lit & ks.x.max(ks.y).max(ks.z).gt(zero);
    if shiny.any() {
        let highlight = highlight_cosine(s, hits.ns, to_light, -rays.dir);
        let highlight = power(s, highlight, coefficients.shininess, shiny);
        reflected = reflected + ks * highlight;
    }
    reflected.times(V3::splat(s, light.color)) * strength
}

/// What the lobes of a surface reflect of a light, as a factor on what white would scatter. What others mirror is limited.
#[inline(never)]
fn reflected<L: Lanes>(
    s: L::Simd,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    lobes: &Lobes<L>,
    to_light: V3<L>,
    cosine: L,
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let reflected = lobes.reflected(s, hits.ns, to_light, -rays.dir, cosine);
            if rays.kind == RayKind::Camera { reflected } else { limited(s, reflected) }
        },
    )
}

/// Where shadow rays start from facets that stand for a curved surface, the lanes of `smooth`: on that surface where the
/// light grazes the facet or comes from behind it, else neighbouring facets would draw a saw-toothed shadow line.
#[inline(always)]
fn from_curve<L: Lanes>(s: L::Simd, hits: &Hits<L>, facet_cosine: L, smooth: u32) -> V3<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let share = (one - facet_cosine * L::lit(s, 1.0 / GRAZING)).max(zero).min(one);
    let share = L::select(L::mask(s, smooth), share, zero);
    leave(hits.surface.point + hits.surface.inwards + hits.surface.lift * share, hits.surface.error, hits.ng)
}

/// Segments from the surface to the light; t = 1 is the light, or infinity for directional light.
#[inline(always)]
pub(super) fn shadow_rays<L: Lanes>(s: L::Simd, place: &Place<L>, origin: V3<L>, active: L::Mask) -> Rays<L> {
    let t_min = L::lit(s, 0.0);
    match *place {
        Place::Point(position) => {
            let t_max = L::lit(s, 1.0 - LIGHT_MARGIN * L::Real::ROUNDOFF);
            Rays { origin, dir: position - origin, t_min, t_max, active }
        }
        Place::Sky(dir) => Rays { origin, dir, t_min, t_max: L::lit(s, f64::INFINITY), active },
    }
}
