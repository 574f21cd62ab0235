//! Light that rays bring to each lobe of a surface, and light of what is bright, which is looked for by itself: in each sample one
//! direction of the surroundings and one point of what glows.
//!
//! What both may find is shared by the balance heuristic (Veach and Guibas, Optimally Combining Sampling Techniques for Monte Carlo
//! Rendering, 1995): with a density p of the one and q of the other, the one counts p / (p + q) of it. Lobes share with the choice one
//! by one, so no sample is more than its lobe would reflect of the brightest light.

use super::hits::Hits;
use super::kernel::Tracer;
use super::lighting::SHADOW_SHARE;
use super::observer::Observer;
use super::opacity::transmittance_with_holes;
use super::ray_packet::RayPacket;
use super::sampling::Choice;
use super::variants::Variant;
use crate::accel::{Blockers, Coherence, Shape};
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::scene::effects::Effect;
use crate::scene::world::{Pruning, World};
use crate::shading::bright_directions::BrightDirections;
use crate::shading::emitters::Emitters;
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;
use glam::DVec3;
use std::f64::consts::PI;

/// The part of the way to a point of a lamp that shadow rays ask for: the lamp itself hides nothing.
const WAY: f64 = 1.0 - 1.0 / 1024.0;

/// A direction for each lane from which light may come.
struct LightSample<L: Lanes> {
    dir: V3<L>,
    /// How far the light is.
    distance: L,
    /// How likely the direction was, by solid angle.
    density: L,
    radiance: V3<L>,
}

/// The share of the one way to find a light of which both may find it.
#[inline(always)]
pub(super) fn balance_heuristic<L: Lanes>(density: L, other: L) -> L {
    density / (density + other)
}

/// What surfaces send to the rays of light that is looked for, weighted as the rays are.
#[inline(never)]
pub(super) fn sample_direct_light<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
) -> V3<L> {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || {
            let (s, world) = (tracer.s, tracer.world);
            let mut light = V3::splat(s, [L::Real::default(); 3]);
            if let Some(bright) = &world.bright_directions {
                let square = tracer.sampler.square(s, rays.path, Choice::Surroundings);
                let chosen = direction(s, bright, square, hits.found);
                light = light + direct_light(tracer, rays, hits, coefficients, lobes, &chosen);
            }
            if let Some(emitters) = &world.emitters {
                let square = tracer.sampler.square(s, rays.path, Choice::Emitter);
                let chosen = point(s, emitters, hits.surface.point, square, hits.found);
                light = light + direct_light(tracer, rays, hits, coefficients, lobes, &chosen);
            }
            light
        },
    )
}

/// Numbers of what is chosen, lane by lane.
type Numbers<L> = [[<L as Lanes>::Real; MAX_LANES]; 8];

#[inline(always)]
fn of_numbers<L: Lanes>(s: L::Simd, numbers: &Numbers<L>) -> LightSample<L> {
    let [x, y, z, distance, density, red, green, blue] = numbers.each_ref();
    LightSample {
        dir: V3 { x: L::load(s, x), y: L::load(s, y), z: L::load(s, z) },
        distance: L::load(s, distance),
        density: L::load(s, density),
        radiance: V3 { x: L::load(s, red), y: L::load(s, green), z: L::load(s, blue) },
    }
}

#[inline(always)]
fn put<L: Lanes>(numbers: &mut Numbers<L>, lane: usize, of_lane: [f64; 8]) {
    for (column, number) in numbers.iter_mut().zip(of_lane) {
        column[lane] = L::Real::from_f64(number);
    }
}

/// Directions of the surroundings for points of the unit square.
#[inline(always)]
fn direction<L: Lanes>(s: L::Simd, bright: &BrightDirections, [a, b]: [L; 2], lanes: u32) -> LightSample<L> {
    let mut numbers: Numbers<L> = [[L::Real::default(); MAX_LANES]; 8];
    for lane in lanes_of(lanes) {
        let chosen = bright.choose([a.lane(lane).to_f64(), b.lane(lane).to_f64()]);
        let ([x, y, z], [red, green, blue]) = (chosen.dir, chosen.radiance);
        put::<L>(&mut numbers, lane, [x, y, z, f64::INFINITY, chosen.density, red, green, blue]);
    }
    of_numbers(s, &numbers)
}

/// Points of what glows.
#[inline(always)]
fn point<L: Lanes>(s: L::Simd, emitters: &Emitters, from: V3<L>, [a, b]: [L; 2], lanes: u32) -> LightSample<L> {
    let mut numbers: Numbers<L> = [[L::Real::default(); MAX_LANES]; 8];
    for lane in lanes_of(lanes) {
        let place = DVec3::from_array(from.lane(lane).map(Real::to_f64));
        let chosen = emitters.choose(place, [a.lane(lane).to_f64(), b.lane(lane).to_f64()]);
        let ([x, y, z], [red, green, blue]) = (chosen.dir.to_array(), chosen.radiance);
        put::<L>(&mut numbers, lane, [x, y, z, chosen.distance, chosen.density, red, green, blue]);
    }
    of_numbers(s, &numbers)
}

/// What surfaces send to the rays of the light from some directions, if nothing is in its way.
#[inline(always)]
fn direct_light<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    lobes: Option<&Lobes<L>>,
    chosen: &LightSample<L>,
) -> V3<L> {
    let (s, world) = (tracer.s, tracer.world);
    let (zero, over_pi) = (L::lit(s, 0.0), L::lit(s, 1.0 / PI));
    let black = V3 { x: zero, y: zero, z: zero };
    let (to_light, density) = (chosen.dir, chosen.density);
    let mut cosine = hits.ns.dot(to_light);
    let mut faces = cosine.gt(zero);
    if let Some(lobes) = lobes {
        (cosine, faces) = lobes.faces(s, to_light, cosine);
    }
    let facing = hits.ng.dot(to_light).gt(zero) & faces;
    let lit = L::mask(s, hits.found) & facing & density.gt(zero) & density.lt(L::lit(s, f64::INFINITY));
    let mut reflected = coefficients.diffuse * (cosine * balance_heuristic(density, cosine * over_pi));
    if let Some(lobes) = lobes {
        let [own, over] = lobes.sampled_lobes(s, hits.ns, to_light, -rays.dir, cosine);
        let (own_share, over_share) =
            (balance_heuristic(density, own.density), balance_heuristic(density, over.density));
        let all = reflected + own.reflected * own_share + over.reflected * over_share;
        reflected = V3::select(L::mask(s, lobes.lanes), all, reflected);
    }
    let radiance = reflected.times(chosen.radiance) * (over_pi / density);
    let added = V3::select(lit, rays.weight.times(radiance), black);
    let most = added.x.max(added.y).max(added.z);
    // Against the eye there is no facet between: a lobe is infinite there, and its share none.
    let finite = L::lit(s, f64::INFINITY);
    let lit = lit & most.gt(zero) & added.x.lt(finite) & added.y.lt(finite) & added.z.lt(finite);
    let negligible = match tracer.pruning {
        Pruning::Proved { .. } => tracer.may_skip_light(lit, added),
        Pruning::Weight(_) => lit & !most.ge(tracer.certificate.min_weight * L::lit(s, SHADOW_SHARE)),
    };
    if negligible.any() {
        tracer.counts.shadow_skipped += u64::from(negligible.bits().count_ones());
        tracer.record_omitted_light(negligible, added);
    }
    let lit = lit & !negligible;
    if !lit.any() {
        return black;
    }
    tracer.count_shadow_rays(lit.bits());
    let t_max = chosen.distance * L::lit(s, WAY);
    let shadow = Rays { origin: hits.surface.leave(hits.ng), dir: to_light, t_min: zero, t_max, active: lit };
    // What passes bodies is found by rays, which they bend.
    let blockers = if world.effects.has(Effect::Opacity) { Blockers::Holed } else { Blockers::Opaque };
    let left = transmittance_with_holes(s, world, blockers, shadow, Coherence::Incoherent, hits.time);
    V3::select(lit, added.times(left), black)
}

/// How much rays count of the surroundings that they see, where these are looked for, too.
#[inline(never)]
pub(super) fn environment_mis_weight<L: Lanes>(
    s: L::Simd,
    bright: &BrightDirections,
    dir: V3<L>,
    densities: L,
    lanes: u32,
) -> L {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let chosen = densities.gt(L::lit(s, 0.0)).bits() & lanes;
            let mut others = [L::Real::default(); MAX_LANES];
            for lane in lanes_of(chosen) {
                others[lane] = L::Real::from_f64(bright.density(dir.lane(lane).map(Real::to_f64)));
            }
            L::select(L::mask(s, chosen), balance_heuristic(densities, L::load(s, &others)), L::lit(s, 1.0))
        },
    )
}

/// How much rays count of the glow of what they have hit, where it is looked for, too.
#[inline(never)]
pub(super) fn emission_mis_weight<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    emitters: &Emitters,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    densities: L,
) -> L {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let chosen = densities.gt(L::lit(s, 0.0)).bits() & hits.found;
            let (mut by_area, mut by_angle) = ([L::Real::default(); MAX_LANES], [L::Real::default(); MAX_LANES]);
            for lane in lanes_of(chosen) {
                let item = world.owner(hits.expanded.lane(lane)).item;
                let material = item.material as usize;
                let of_ball = match &item.shape {
                    Shape::Sphere(ball) => {
                        let center = DVec3::from_array(ball.center.map(Real::to_f64));
                        let place = DVec3::from_array(rays.origin.lane(lane).map(Real::to_f64));
                        emitters.density_of_ball(material, center, ball.radius.to_f64(), place)
                    }
                    _ => None,
                };
                match of_ball {
                    Some(density) => by_angle[lane] = L::Real::from_f64(density),
                    None => by_area[lane] = L::Real::from_f64(emitters.density(material)),
                }
            }
            // Along the surface 0/0 would be the density of what is found otherwise.
            let facing = rays.dir.dot(hits.ng).abs().max(L::lit(s, L::Real::SMALLEST));
            let others = L::load(s, &by_area) * hits.t * hits.t / facing + L::load(s, &by_angle);
            L::select(L::mask(s, chosen), balance_heuristic(densities, others), L::lit(s, 1.0))
        },
    )
}
