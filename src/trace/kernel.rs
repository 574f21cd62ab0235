//! Whitted's recursion as a loop over packets of rays on an explicit stack: depth takes memory, but not the thread's stack.
//!
//! A lane does not depend on the others: every operation is lane by lane, of surfaces at the same distance the one written
//! first wins, and the rays of each lane are followed in depth-first order, transmitted before reflected. So the value of a
//! pixel depends neither on the packet it is traced in nor on the width of a packet.

use super::attenuation::along;
use super::certificate::Certificate;
use super::color_bleeding::scatter_diffuse;
use super::counts::RayCounts;
use super::eye_media::media_at;
use super::hits::Hits;
use super::lighting::illuminate;
use super::observer::Observer;
use super::ray_cones::{RayCones, around};
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::{Choice, Sampler};
use super::secondary::scatter;
use super::texturing::apply_textures;
use super::wavelengths::Wavelengths;
use crate::accel::Nearest;
use crate::camera::{Camera, Cone};
use crate::control;
use crate::lanes::{Ids, Lanes, Mask, Real, V3};
use crate::ray::Rays;
use crate::scene::effects::Effect;
use crate::scene::world::{Pruning, World};
use crate::shading::media::{Media, Medium, OUTSIDE};
use crate::trace::variants::{General, Variant};
use std::marker::PhantomData;

/// Largest radiance that a ray adds to a pixel, so that nothing overflows in single precision. Only materials with r_s + r_t
/// above 1, of which a warning tells, and extremely bright lights come near.
const MAX_RADIANCE: f64 = 1e28;

/// Share of a pixel over which textures are averaged for a sample of a batch. There may be any number of batches.
const BATCH_SHARE: f64 = 1.0 / 1_024.0;

/// Traces packets of samples through a world. Reused from packet to packet.
#[derive(Debug)]
pub struct Tracer<'a, L: Lanes, O, V = General> {
    pub(super) s: L::Simd,
    pub(super) world: &'a World<L::Real>,
    camera: &'a Camera<L::Real>,
    pub(super) observer: O,
    pub(super) media: Media<L::Real>,
    /// Rays waiting to be followed.
    pub(super) stack: Vec<RayPacket<L>>,
    /// What ends chains of rays besides their length.
    pub(crate) pruning: Pruning,
    /// The smallest weight followed, times the sample's own, or w U where something is to be proved.
    pub(super) min_weight: L,
    /// The weight of a sample.
    pub(super) share: L,
    /// The bound on what is omitted.
    pub(super) certificate: Certificate<L>,
    /// What was traced so far.
    pub counts: RayCounts,
    /// Rays of each sample so far: whole numbers that every format holds.
    pub(super) followed: L,
    /// What a packet counts for between two checks for cancellation: each light takes a step.
    steps: u32,
    /// The choices of the current sample, in the general variant.
    pub(crate) sampler: Sampler,
    /// The wavelengths of the current sample, in scenes with dispersion.
    pub(super) wavelengths: Wavelengths<L>,
    eye_media: Vec<Medium<L::Real>>,
    /// The cones of the current rays, in the general variant.
    pub(super) cones: RayCones<L>,
    variant: PhantomData<V>,
}

impl<'a, L: Lanes, O: Observer<L>, V: Variant> Tracer<'a, L, O, V> {
    /// A tracer for packets of `L::COUNT` samples. The camera is the world's, or that seen through a window.
    #[inline(always)]
    pub fn new(
        s: L::Simd,
        world: &'a World<L::Real>,
        camera: &'a Camera<L::Real>,
        eye_media: &[Medium<L::Real>],
        pruning: Pruning,
        observer: O,
    ) -> Self {
        Self {
            s,
            world,
            camera,
            observer,
            media: Media::default(),
            stack: Vec::new(),
            pruning,
            min_weight: L::lit(s, 0.0),
            share: L::lit(s, 1.0),
            certificate: Certificate::new(s),
            counts: RayCounts::default(),
            followed: L::lit(s, 0.0),
            steps: 1 + world.lights.len() as u32,
            sampler: Sampler::default(),
            wavelengths: Wavelengths::yellow(s),
            eye_media: eye_media.to_vec(),
            cones: RayCones::new(s, if V::DETAILS { camera.cone() } else { Cone::default() }),
            variant: PhantomData,
        }
    }

    /// The proof of instructions this tracer was made with.
    #[inline(always)]
    pub fn simd(&self) -> L::Simd {
        self.s
    }

    /// Gives the observer back.
    pub fn into_observer(self) -> O {
        self.observer
    }

    /// Makes `rays` the camera rays of the samples at (x, y), in pixels from the upper left corner, to be followed with
    /// `weight`. What lies outside of the picture's circle is added to `sum`.
    #[inline(always)]
    pub fn sample(
        &mut self,
        x: L,
        y: L,
        active: u32,
        weight: L::Real,
        rays: &mut RayPacket<L>,
        hits: &mut Hits<L>,
        sum: &mut V3<L>,
    ) {
        let s = self.s;
        let weight = L::splat(s, weight);
        self.share = weight;
        self.stack.clear();
        if V::DETAILS {
            self.cones.restart(s, if self.certificate.batch == 0 { weight } else { L::lit(s, BATCH_SHARE) });
        }

        let mut primary = self.camera.primary(s, x, y);
        if V::DETAILS
            && let Some(lens) = self.camera.lens()
        {
            primary = lens.bend(s, &primary, self.sampler.square(s, 0, Choice::Lens));
        }
        self.make_choices(hits);
        let seen = primary.seen.bits() & active;
        let weight = V3 { x: weight, y: weight, z: weight };
        // Field by field: as a whole it would be made elsewhere and copied.
        rays.origin = primary.origin;
        rays.dir = primary.dir;
        rays.t_min = L::lit(s, 0.0);
        rays.weight = weight;
        rays.active = seen;
        rays.media = self.media_at_eye(&primary.origin, seen, hits.time);
        rays.depth = 1;
        rays.kind = RayKind::Camera;
        rays.path = 0;
        rays.dispersed = 0;
        rays.parent = 0;
        if seen != active {
            let background = weight.times(V3::splat(s, self.world.background));
            self.add(sum, active & !seen, background);
            if O::WATCHING {
                self.observer.outside(background);
            }
        }
        self.counts.camera += u64::from(seen.count_ones());
        self.counts.deepest = self.counts.deepest.max(1);
    }

    /// What is chosen once for a sample, beside the place on the lens.
    #[inline(always)]
    pub(super) fn make_choices(&mut self, hits: &mut Hits<L>) {
        let s = self.s;
        if V::DETAILS
            && self.world.effects.has(Effect::Dispersion)
            && let Some(spectrum) = &self.world.spectrum
        {
            self.wavelengths = Wavelengths::choose(s, spectrum, &self.sampler);
        }
        let moves = V::DETAILS && self.world.effects.has(Effect::MotionBlur);
        hits.time = if moves { Some(self.sampler.number(s, Choice::Time)) } else { None };
    }

    /// Follows rays and their descendants. Once cancelled it returns early, and the sum is useless. `rays` and `hits` are
    /// buffers of the caller, since they are expensive to create and to move.
    #[inline(always)]
    pub(crate) fn follow_from(&mut self, rays: &mut RayPacket<L>, hits: &mut Hits<L>, sum: &mut V3<L>) {
        loop {
            if control::step(self.steps) {
                return;
            }
            if rays.active != 0 {
                self.follow(rays, hits, sum);
            }
            if !self.pop(rays) {
                return;
            }
        }
    }

    #[inline(always)]
    fn media_at_eye(&mut self, origin: &V3<L>, active: u32, time: Option<L>) -> L::Ids {
        let s = self.s;
        if !V::SECONDARY || !self.world.transmits {
            return L::Ids::splat(s, u64::from(OUTSIDE));
        }
        if self.world.shared_eye {
            return L::Ids::splat(s, u64::from(self.media.list(&self.eye_media)));
        }
        L::Ids::from_fn(s, |lane| {
            if active & (1 << lane) == 0 {
                return u64::from(OUTSIDE);
            }
            let around = media_at::<L>(s, self.world, origin.lane(lane), time.map(|time| time.lane(lane)));
            u64::from(self.media.list(&around))
        })
    }

    /// Shades what the rays hit and stacks the rays that leave from there.
    #[inline(always)]
    fn follow(&mut self, rays: &RayPacket<L>, hits: &mut Hits<L>, sum: &mut V3<L>) {
        let s = self.s;
        let number = if O::WATCHING { self.observer.ray(rays, &self.media) } else { 0 };
        let mut cast = Rays {
            origin: rays.origin,
            dir: rays.dir,
            t_min: rays.t_min,
            t_max: L::lit(s, f64::INFINITY),
            active: L::mask(s, rays.active),
        };
        if V::SECONDARY {
            hits.find(s, self.world, &mut cast, rays.coherence());
        } else {
            hits.find_nearest(s, self.world, &mut cast, &Nearest::none(s), rays.coherence());
        }
        // The light that a ray itself brings is added in one step, so that the ray tree adds up to the last bit.
        let mut own = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let faded;
        let rays = if V::DETAILS && self.world.effects.fade() {
            let way = along(s, self.world, &self.media, rays, hits.t - rays.t_min);
            own = rays.weight.times(way.added);
            faded = RayPacket { weight: rays.weight.times(way.transmittance), ..*rays };
            &faded
        } else {
            rays
        };
        let found = hits.found;
        let missed = rays.active & !found;
        if missed != 0 {
            let background = rays.weight.times(self.surroundings(rays, missed));
            let background = self.bounded(if V::DETAILS { own + background } else { background });
            self.add(sum, missed, background);
            if O::WATCHING {
                self.observer.contributes(number, background);
            }
        }
        if found == 0 {
            return;
        }
        if rays.kind == RayKind::Camera {
            self.counts.camera_hits += u64::from(found.count_ones());
        }
        if O::WATCHING {
            self.observer.hits(number, rays, hits);
        }
        let mut coefficients = hits.coefficients(s, self.world);
        if V::DETAILS {
            self.cones.hit(s, hits);
            if self.world.effects.has_textures() {
                self.cones.tilted = apply_textures(s, self.world, rays, self.cones.widths(s), hits, &mut coefficients);
            }
            if self.world.effects.has(Effect::Emission) {
                own = own + rays.weight.times(hits.emission(s, self.world));
            }
        }
        illuminate(self, rays, hits, &coefficients, own, number, sum);
        if rays.kind == RayKind::Gathered {
            return;
        }
        if V::DETAILS && self.world.effects.has(Effect::ColorBleeding) {
            scatter_diffuse(self, rays, hits, &coefficients, number);
        }
        scatter(self, rays, hits, &coefficients, number);
    }

    /// Radiance of the surroundings, for rays of some lanes that hit nothing.
    #[inline(always)]
    fn surroundings(&self, rays: &RayPacket<L>, missed: u32) -> V3<L> {
        if V::DETAILS
            && let Some(environment) = &self.world.environment
        {
            return around(self.s, environment, rays.dir, missed, self.cones.spread());
        }
        V3::splat(self.s, self.world.background)
    }

    /// Radiance limited to [`MAX_RADIANCE`]: materials that amplify light cannot make it infinite.
    #[inline(always)]
    pub(super) fn bounded(&self, radiance: V3<L>) -> V3<L> {
        let max = L::lit(self.s, MAX_RADIANCE);
        V3 { x: radiance.x.min(max), y: radiance.y.min(max), z: radiance.z.min(max) }
    }

    /// Adds radiance to the lanes of `lanes`.
    #[inline(always)]
    pub(super) fn add(&self, sum: &mut V3<L>, lanes: u32, radiance: V3<L>) {
        *sum = V3::select(L::mask(self.s, lanes), *sum + radiance, *sum);
    }
}

/// Runs a stage of the kernel: in a function of its own in the general variant, which is too large for one, and inline in
/// the others, where the call would cost up to 4 % of all instructions.
#[inline(always)]
pub(super) fn stage<L: Lanes, V: Variant, T>(s: L::Simd, f: impl FnOnce() -> T) -> T {
    if V::DETAILS { outlined::<L, T>(s, f) } else { f() }
}

#[inline(never)]
fn outlined<L: Lanes, T>(s: L::Simd, f: impl FnOnce() -> T) -> T {
    L::vectorize(s, f)
}

/// A one-lane number of the kernel's format, for events.
pub(crate) fn first<L: Lanes>(x: L) -> f64 {
    x.lane(0).to_f64()
}
