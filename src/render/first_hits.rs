//! What the camera rays of pixels meet first: one ray through the middle of each pixel, and fixed samples of it.
//!
//! Pixels do not depend on each other, so that any part of a picture has the numbers of the whole.

use super::packets::TraceJob;
use crate::film::cryptomatte::{RANKS, Ranks};
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::scene::Scene;
use crate::scene::compile::LEAST_SHARE;
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::trace::batch::SampleBatch;
use crate::trace::counts::RayCounts;
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::pixel::Samples;
use crate::trace::ray_packet::RayPacket;
use crate::trace::variants::General;
use smallvec::SmallVec;

/// Samples of each pixel for what is averaged or counted over it, whatever the picture has.
pub(super) const SAMPLES: u32 = 16;

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// What the ray through the middle meets.
    pub(super) middle: bool,
    /// What the samples meet.
    pub(super) samples: bool,
    /// Their colors, too.
    pub(super) albedo: bool,
    /// Whose surface the ray through the middle meets.
    pub(super) sources: bool,
}

/// What the rays of some pixels meet, in the order of the pixels.
#[derive(Debug, Default)]
pub(super) struct FirstHits {
    pub(super) middles: Vec<Middle>,
    pub(super) sampled: Vec<Sampled>,
    pub(super) rays: RayCounts,
}

/// What the ray through the middle of a pixel meets.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Middle {
    pub(super) distance: f32,
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    /// The [source](crate::scene::compile::Sources) of its item, where it is asked for.
    pub(super) source: Option<u32>,
}

/// What the samples of a pixel meet.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sampled {
    pub(super) albedo: [f32; 3],
    /// Indices in `objects`, with their shares.
    pub(super) objects: Ranks,
    /// Indices of materials.
    pub(super) materials: Ranks,
}

/// How much of a surface is there at least where the middle of a pixel shows it.
const LEAST_OPACITY: f64 = 0.5;

const NOTHING: Middle = Middle { distance: f32::INFINITY, position: [0.0; 3], normal: [0.0; 3], source: None };

/// Traces the pixels at `at`, a packet at a time.
pub(super) fn first_hits<L: Lanes>(
    s: L::Simd,
    scene: &Scene,
    job: &TraceJob<'_, L::Real>,
    at: &[[u32; 2]],
    wanted: Wanted,
    out: &mut FirstHits,
) {
    let _entered = job.control.enter();
    // In functions of their own: each holds the search for hits.
    if wanted.middle {
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let mut pass = Pass::<L>::new(s, scene, job);
                for packet in at.chunks(L::COUNT) {
                    pass.middles(packet, wanted.sources, &mut out.middles);
                }
                out.rays = out.rays + pass.tracer.counts;
            },
        );
    }
    if wanted.samples {
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let mut pass = Pass::<L>::new(s, scene, job);
                for packet in at.chunks(L::COUNT) {
                    pass.samples(packet, wanted.albedo, &mut out.sampled);
                }
                out.rays = out.rays + pass.tracer.counts;
            },
        );
    }
}

/// What a primitive is of.
#[derive(Debug, Clone, Copy)]
struct Names {
    /// Index in `objects`.
    object: u32,
    /// The item of the scene itself.
    source: u32,
    material: u32,
}

/// The state of tracing packets.
struct Pass<'a, L: Lanes> {
    s: L::Simd,
    scene: &'a Scene,
    world: &'a World<L::Real>,
    tracer: Tracer<'a, L, (), General>,
    rays: RayPacket<L>,
    hits: Hits<L>,
    /// The last primitive met, with its names.
    last: Option<(u64, Names)>,
}

impl<'a, L: Lanes> Pass<'a, L> {
    #[inline(always)]
    fn new(s: L::Simd, scene: &'a Scene, job: &'a TraceJob<'_, L::Real>) -> Self {
        let tracer = Tracer::new(s, job.world, &job.camera, &job.eye, job.pruning, ());
        Self { s, scene, world: job.world, tracer, rays: RayPacket::none(s), hits: Hits::none(s), last: None }
    }

    #[inline(always)]
    fn middles(&mut self, packet: &[[u32; 2]], sources: bool, out: &mut Vec<Middle>) {
        let active = ((1u64 << packet.len()) - 1) as u32;
        self.tracer.begin_batch(&SampleBatch::of_pixels(packet, 0, Samples::of_picture(1)), 0);
        let (x, y) = (self.tracer.middles(0), self.tracer.middles(1));
        self.tracer.middle_rays(x, y, active, &mut self.rays, &mut self.hits);
        let mut middles = [NOTHING; MAX_LANES];
        while self.tracer.first_hits(&self.rays, &mut self.hits) {
            let (_, opacity) = self.tracer.first_coefficients(&self.rays, &mut self.hits);
            let there = opacity.ge(L::lit(self.s, LEAST_OPACITY)).bits() & self.hits.found;
            for lane in lanes_of(there) {
                let source = sources.then(|| self.names(self.hits.expanded.lane(lane)).source);
                let hits = &self.hits;
                let distance = hits.t.lane(lane).to_f64() as f32;
                let (position, normal) = (narrow(hits.surface.point, lane), narrow(hits.ns, lane));
                middles[lane] = Middle { distance, position, normal, source };
            }
            self.tracer.pass_on(self.hits.found & !there, &mut self.rays, &self.hits);
        }
        out.extend(&middles[..packet.len()]);
    }

    #[inline(always)]
    fn samples(&mut self, packet: &[[u32; 2]], colors: bool, out: &mut Vec<Sampled>) {
        let s = self.s;
        let active = ((1u64 << packet.len()) - 1) as u32;
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        // As of shares: many thin veils would take long, since each ray is looked for from the eye again.
        let least = L::lit(s, LEAST_SHARE / f64::from(SAMPLES));
        let mut albedo = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let mut shares: [[Shares; 2]; MAX_LANES] = std::array::from_fn(|_| Default::default());
        for sample in 0..SAMPLES {
            self.tracer.begin_batch(&SampleBatch::of_pixels(packet, sample, Samples::of_picture(SAMPLES)), 0);
            self.tracer.begin_samples(active);
            let (x, y) = (self.tracer.coordinates(0), self.tracer.coordinates(1));
            self.tracer.sample(x, y, active, &mut self.rays, &mut self.hits);
            let mut left = L::lit(s, 1.0 / f64::from(SAMPLES));
            while self.tracer.first_hits(&self.rays, &mut self.hits) {
                let mut opacity = one;
                if colors || self.world.effects.has(Effect::Opacity) {
                    let coefficients;
                    (coefficients, opacity) = self.tracer.first_coefficients(&self.rays, &mut self.hits);
                    let found = L::mask(s, self.hits.found);
                    albedo = V3::select(found, albedo + coefficients.diffuse * (left * opacity), albedo);
                }
                let shown = left * opacity;
                for lane in lanes_of(self.hits.found & shown.gt(zero).bits()) {
                    let Names { object, material, .. } = self.names(self.hits.expanded.lane(lane));
                    let share = shown.lane(lane).to_f64() as f32;
                    shares[lane][0].add(object, share);
                    shares[lane][1].add(material, share);
                }
                left = left * (one - opacity);
                self.tracer.pass_on(self.hits.found & left.gt(least).bits(), &mut self.rays, &self.hits);
            }
        }
        for (lane, [objects, materials]) in shares.iter_mut().enumerate().take(packet.len()) {
            let albedo = narrow(albedo, lane);
            out.push(Sampled { albedo, objects: objects.ranked(), materials: materials.ranked() });
        }
    }

    /// What a primitive is of. Most rays meet the same one as the ray before.
    fn names(&mut self, expanded: u64) -> Names {
        if let Some((last, names)) = self.last
            && last == expanded
        {
            return names;
        }
        let owner = self.world.owner(expanded);
        let outermost = owner.instances.first().map_or(owner.item.source, |placed| placed.source);
        let object = self.scene.sources.top(outermost);
        let names = Names { object, source: outermost, material: owner.item.material };
        self.last = Some((expanded, names));
        names
    }
}

/// A lane in the format of films.
#[inline(always)]
fn narrow<L: Lanes>(v: V3<L>, lane: usize) -> [f32; 3] {
    v.lane(lane).map(|x| x.to_f64() as f32)
}

/// The shares of things in a pixel.
#[derive(Debug, Clone, Default)]
struct Shares {
    things: SmallVec<[(u32, f32); SAMPLES as usize]>,
}

impl Shares {
    fn add(&mut self, thing: u32, share: f32) {
        match self.things.iter_mut().find(|(known, _)| *known == thing) {
            Some((_, known)) => *known += share,
            None => self.things.push((thing, share)),
        }
    }

    /// The largest, in their order; of equal ones the first in the scene.
    fn ranked(&mut self) -> Ranks {
        self.things.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut ranks = [(0, 0.0); RANKS];
        for (rank, thing) in ranks.iter_mut().zip(&self.things) {
            *rank = *thing;
        }
        ranks
    }
}
