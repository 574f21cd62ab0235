//! First hits of many single rays, in packets, by the same code as pictures.

use super::query::RayQuery;
use crate::accel::Coherence;
use crate::lanes::{Lanes, Real, V3, dispatch};
use crate::ray::Rays;
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::world::World;
use crate::trace::hits::Hits;
use fearless_simd::{Level, f32x16, f64x8};

/// The first hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Ray parameter, in units of the direction.
    pub t: f64,
    /// The point on the surface.
    pub point: [f64; 3],
    /// Unit geometric normal, pointing out of the body's material.
    pub normal: [f64; 3],
    /// Where a ray starts that leaves on the normal's side.
    pub outside: [f64; 3],
    /// Where a ray starts that leaves on the other side.
    pub inside: [f64; 3],
}

/// The first hit of each ray. Directions should have a length around 1: unlike single rays, packets are not scaled.
pub fn first_hits(scene: &Scene, rays: &[RayQuery]) -> Vec<Option<FirstHit>> {
    let mut answers = Vec::with_capacity(rays.len());
    match &scene.world {
        Precise::Single(world) => dispatch!(Level::new(), follow::<f32x16, f32>(world, rays, &mut answers)),
        Precise::Double(world) => dispatch!(Level::new(), follow::<f64x8, f64>(world, rays, &mut answers)),
    }
    answers
}

fn follow<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &[RayQuery], answers: &mut Vec<Option<FirstHit>>) {
    L::vectorize(
        s,
        #[inline(always)]
        || follow_in::<L>(s, world, rays, answers),
    );
}

#[inline(always)]
fn follow_in<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &[RayQuery], answers: &mut Vec<Option<FirstHit>>) {
    let mut hits = Hits::none(s);
    for (index, packet) in rays.chunks(L::COUNT).enumerate() {
        // Lanes without a ray repeat the last one, switched off.
        let ray = |lane: usize| packet[lane.min(packet.len() - 1)];
        let number = |f: &dyn Fn(RayQuery) -> f64| L::from_fn(s, |lane| L::Real::from_f64(f(ray(lane))));
        let vector = |f: &dyn Fn(RayQuery) -> [f64; 3]| V3::from_fn(s, |lane| f(ray(lane)).map(L::Real::from_f64));
        let mut cast = Rays::<L> {
            origin: vector(&|ray| ray.origin),
            dir: vector(&|ray| ray.direction),
            t_min: number(&|ray| ray.t_min),
            t_max: number(&|ray| ray.t_max.unwrap_or(f64::INFINITY)),
            active: L::mask(s, ((1u64 << packet.len()) - 1) as u32),
        };
        // Both kinds of traversal, for the tests.
        let coherence = if index.is_multiple_of(2) { Coherence::Coherent } else { Coherence::Incoherent };
        hits.find(s, world, &mut cast, coherence);
        hits.leave_eye(s, world, &cast, coherence);
        answers.extend((0..packet.len()).map(|lane| first_hit(&hits, lane)));
    }
}

#[inline(always)]
fn first_hit<L: Lanes>(hits: &Hits<L>, lane: usize) -> Option<FirstHit> {
    let wide = |v: V3<L>| v.lane(lane).map(Real::to_f64);
    let surface = &hits.surface;
    (hits.found & (1 << lane) != 0).then(|| FirstHit {
        t: hits.t.lane(lane).to_f64(),
        point: wide(surface.point),
        normal: wide(surface.ng),
        outside: wide(surface.leave(surface.ng)),
        inside: wide(surface.leave(-surface.ng)),
    })
}
