//! Whitted's recursion as a loop over packets of rays on an explicit stack: depth takes memory, but not the thread's stack.
//!
//! A lane does not depend on the others: every operation is lane by lane, of surfaces at the same distance the one written
//! first wins, and the rays of each lane are followed in depth-first order: what is scattered (with global illumination), then
//! transmitted and reflected ones. So the value of a pixel depends neither on the packet it is traced in nor on the width of a
//! packet.

use super::attenuation::attenuate;
use super::batch::SamplePacket;
use super::certificate::Certificate;
use super::clearcoat::scatter_clearcoat;
use super::color_bleeding::scatter_diffuse;
use super::counts::{LaneCounts, RayCounts};
use super::environment_light::light_from_around;
use super::eye_media::media_at;
use super::footprint::footprints;
use super::hits::Hits;
use super::lighting::illuminate;
use super::observer::Observer;
use super::opacity::continue_through;
use super::pbr::lobes_of;
use super::pixel_sum::PixelSum;
use super::proof::{BatchProof, thresholds};
use super::ray_cones::RayCones;
use super::ray_packet::{RayKind, RayPacket};
use super::roulette::Roulette;
use super::sampled_light::{emission_mis_weight, sample_direct_light};
use super::sampling::{Choice, Dimensions, Sampler};
use super::secondary::scatter;
use super::shaded::Shaded;
use super::shadow_catcher::shadow_catcher_opacity;
use super::texturing::apply_textures;
use super::wavelengths::Wavelengths;
use crate::accel::Nearest;
use crate::camera::{Camera, Cone};
use crate::control;
use crate::film::Display;
use crate::lanes::{Ids, Lanes, Mask, Real, V3};
use crate::ray::Rays;
use crate::scene::effects::Effect;
use crate::scene::world::{Pruning, World};
use crate::shading::material::Coefficients;
use crate::shading::media::{Media, Medium, OUTSIDE};
use crate::trace::variants::{General, Variant};
use std::marker::PhantomData;

/// Largest radiance that a ray adds to a pixel, so that nothing overflows in single precision. Only materials with r_s + r_t
/// above 1, of which a warning tells, and extremely bright lights come near.
const MAX_RADIANCE: f64 = 1e28;

/// Traces packets of samples through a world. Reused from packet to packet.
#[derive(Debug)]
pub(crate) struct Tracer<'a, L: Lanes, O, V = General> {
    pub(super) s: L::Simd,
    pub(super) world: &'a World<L::Real>,
    pub(super) camera: &'a Camera<L::Real>,
    pub(super) observer: O,
    pub(super) media: Media<L::Real>,
    /// Rays waiting to be followed.
    pub(super) stack: Vec<RayPacket<L>>,
    /// What ends chains of rays besides their length.
    pub(crate) pruning: Pruning,
    /// What samples begin with: the least weight followed, or w U, and the most light that skipped lights may add.
    pub(super) thresholds: (f64, f64),
    /// The samples at work.
    pub(super) samples: SamplePacket,
    /// The bound on what they omit.
    pub(super) certificate: Certificate<L>,
    /// The proof of their batch.
    pub(super) proof: BatchProof<L>,
    /// What was traced so far.
    pub counts: RayCounts,
    /// Those of each sample of the batch, if asked for.
    pub(crate) lane_counts: Option<Box<LaneCounts>>,
    /// Which children of the current rays are followed, where that is drawn.
    pub(super) roulette: Roulette<L>,
    /// Rays of each sample in this round: whole numbers that every format holds.
    pub(super) followed: L,
    /// What a packet counts for between two checks for cancellation: each light takes a step.
    steps: u32,
    /// The choices of the samples at work, in the general variant.
    pub(crate) sampler: Sampler,
    /// The coordinates that they take.
    pub(super) dimensions: Dimensions,
    /// Their wavelengths, in scenes with dispersion.
    pub(super) wavelengths: Wavelengths<L>,
    eye_media: Vec<Medium<L::Real>>,
    /// The cones of the current rays, in variants with footprints.
    pub(super) cones: RayCones<L>,
    variant: PhantomData<V>,
}

impl<'a, L: Lanes, O: Observer<L>, V: Variant> Tracer<'a, L, O, V> {
    /// A tracer for packets of `L::COUNT` samples. The camera is the world's, or that seen through a window.
    #[inline(always)]
    pub(crate) fn new(
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
            thresholds: thresholds(pruning, &world.display, &world.ceiling),
            samples: SamplePacket::default(),
            certificate: Certificate::new(s),
            proof: BatchProof::new(),
            counts: RayCounts::default(),
            lane_counts: None,
            roulette: Roulette::off(s),
            followed: L::lit(s, 0.0),
            steps: 1 + world.lights.len() as u32,
            sampler: Sampler::default(),
            dimensions: Dimensions::of(world.effects),
            wavelengths: Wavelengths::yellow(s),
            eye_media: eye_media.to_vec(),
            cones: RayCones::new(s, if V::FOOTPRINTS { camera.cone() } else { Cone::default() }),
            variant: PhantomData,
        }
    }

    /// The proof of instructions this tracer was made with.
    #[inline(always)]
    pub(crate) fn simd(&self) -> L::Simd {
        self.s
    }

    /// Whether samples tell how much of the background they see.
    #[inline(always)]
    pub(crate) fn is_transparent(&self) -> bool {
        V::DETAILS && self.world.transparent
    }

    /// How light becomes colors.
    pub(crate) fn display(&self) -> &'a Display {
        &self.world.display
    }

    /// The observer.
    pub(crate) fn observer(&mut self) -> &mut O {
        &mut self.observer
    }

    /// Gives the observer back.
    pub(crate) fn into_observer(self) -> O {
        self.observer
    }

    /// Makes `rays` the camera rays of the samples at (x, y), in pixels from the upper left corner.
    #[inline(always)]
    pub(crate) fn sample(&mut self, x: L, y: L, active: u32, rays: &mut RayPacket<L>, hits: &mut Hits<L>) {
        let s = self.s;
        self.stack.clear();
        if V::FOOTPRINTS {
            self.cones.restart(s, self.share());
        }

        let mut primary = self.camera.primary(s, x, y);
        if V::DETAILS
            && let Some(lens) = self.camera.lens()
        {
            primary = lens.bend(s, &primary, self.sampler.square(s, 0, Choice::Lens));
        }
        self.make_choices(hits);
        let seen = primary.seen.bits() & active;
        let weight = V3::splat(s, [L::Real::from_f64(1.0); 3]);
        // Field by field: as a whole it would be made elsewhere and copied.
        rays.origin = primary.origin;
        rays.dir = primary.dir;
        rays.t_min = L::lit(s, 0.0);
        rays.weight = weight;
        rays.active = seen;
        rays.media = self.media_at_eye(&primary.origin, seen, hits.time);
        rays.depth = 1;
        rays.kind = RayKind::Camera;
        rays.straight = true;
        rays.gathered = false;
        rays.path = 0;
        rays.dispersed = 0;
        rays.parent = 0;
        if seen != active {
            // Beyond the circle of a dome there is no scene.
            if self.is_transparent() {
                // All of it: nothing is in between.
                self.see_through(active & !seen, weight);
            }
            if O::WATCHING {
                self.observer.outside();
            }
        }
        self.counts.camera += u64::from(seen.count_ones());
        self.counts.deepest = self.counts.deepest.max(1);
        self.count_lanes(seen, 1);
    }

    /// Counts a ray of some lanes, the last of a chain of `depth`, where pixels are counted one by one.
    #[inline(always)]
    pub(super) fn count_lanes(&mut self, lanes: u32, depth: u32) {
        if let Some(counts) = &mut self.lane_counts {
            counts.add(lanes << self.proof.first(), depth);
        }
    }

    /// Counts a shadow ray of some lanes.
    #[inline(always)]
    pub(super) fn count_shadow_rays(&mut self, lanes: u32) {
        self.counts.shadow += u64::from(lanes.count_ones());
        self.count_lanes(lanes, 0);
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
        hits.time = if moves { Some(self.sampler.time(s)) } else { None };
    }

    /// Follows rays and their descendants. Once cancelled it returns early, and the sum is useless. `rays` and `hits` are
    /// buffers of the caller, since they are expensive to create and to move.
    #[inline(always)]
    pub(crate) fn follow_from(&mut self, rays: &mut RayPacket<L>, hits: &mut Hits<L>, sum: &mut PixelSum<L>) {
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
        if !V::SECONDARY || !self.world.has_media() {
            return L::Ids::splat(s, u64::from(OUTSIDE));
        }
        if self.world.shared_eye {
            return L::Ids::splat(s, u64::from(self.media.list(&self.eye_media)));
        }
        self.media_at_each(origin, active, time)
    }

    /// The media at the eye where each ray has its own.
    #[inline(never)]
    fn media_at_each(&mut self, origin: &V3<L>, active: u32, time: Option<L>) -> L::Ids {
        let s = self.s;
        L::vectorize(
            s,
            #[inline(always)]
            || {
                L::Ids::from_fn(s, |lane| {
                    if active & (1 << lane) == 0 {
                        return u64::from(OUTSIDE);
                    }
                    let around = media_at::<L>(s, self.world, origin.lane(lane), time.map(|time| time.lane(lane)));
                    u64::from(self.media.list(&around))
                })
            },
        )
    }

    /// Shades what the rays hit and stacks the rays that leave from there.
    #[inline(always)]
    fn follow(&mut self, rays: &RayPacket<L>, hits: &mut Hits<L>, sum: &mut PixelSum<L>) {
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
        if rays.depth == 1 && self.world.usage.rounded {
            hits.leave_eye(s, self.world, &cast, rays.coherence());
        }
        // The light that a ray itself brings is added in one step, so that the ray tree adds up to the last bit.
        let mut own = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let faded;
        let rays = if V::DETAILS && self.world.effects.fade() {
            let attenuation = attenuate(s, self.world, &self.media, rays, hits.t - rays.t_min);
            own = rays.weight.times(attenuation.added);
            faded = RayPacket { weight: rays.weight.times(attenuation.transmittance), ..*rays };
            &faded
        } else {
            rays
        };
        if V::DETAILS {
            // Children stand for what arrives: the light of the way is there whether they are followed or not.
            self.begin_roulette(rays);
        }
        let found = hits.found;
        let missed = rays.active & !found;
        if missed != 0 {
            let background = self.background(rays, missed, own);
            sum.add(s, missed, background);
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
        let mut coefficients = self.coefficients(rays, hits);
        let mut lobes = None;
        let there;
        let mut rays = rays;
        if V::DETAILS {
            let (widths, mut clearcoat) = (self.cones.widths(), hits.ns);
            if self.world.effects.has_textures() {
                self.cones.tilted =
                    apply_textures(s, self.world, rays, widths, hits, &mut coefficients, &mut clearcoat);
            }
            if self.world.effects.has(Effect::MetallicRoughness) {
                lobes = lobes_of(s, self.world, rays, widths, clearcoat, hits, &mut coefficients);
            }
            if let Some(lobes) = &lobes
                && self.world.effects.has(Effect::Opacity)
            {
                // The light of the way is there, whatever is of the surface. Other lanes add it with their own light, as they do alone.
                let apart = lobes.lanes & hits.found;
                let alone = self.bounded(own);
                sum.add(s, apart, alone);
                if O::WATCHING && apart != 0 {
                    self.observer.contributes(number, alone);
                }
                own = V3::select(L::mask(s, apart), V3::splat(s, [L::Real::from_f64(0.0); 3]), own);
                let mut opacity = lobes.opacity;
                if self.world.effects.has(Effect::ShadowCatcher) {
                    opacity = shadow_catcher_opacity(self, rays, hits, opacity, lobes.occlusion);
                }
                continue_through(self, rays, hits, opacity, lobes.lanes, number);
                if hits.found == 0 {
                    return;
                }
                let part = L::select(L::mask(s, lobes.lanes), opacity, L::lit(s, 1.0));
                there = RayPacket { weight: rays.weight * part, ..*rays };
                rays = &there;
            }
            if self.world.effects.has(Effect::Emission) {
                let mut emission = hits.emission(s, self.world);
                if let Some(lobes) = &lobes {
                    emission = V3::select(L::mask(s, lobes.lanes), lobes.emission, emission);
                }
                if self.world.effects.has(Effect::EmitterSampling)
                    && let Some(emitters) = &self.world.emitters
                {
                    let densities = self.cones.densities();
                    emission = emission * emission_mis_weight(s, self.world, emitters, rays, hits, densities);
                }
                own = own + rays.weight.times(emission);
            }
            if self.world.effects.has(Effect::EnvironmentLight)
                && let Some(surroundings) = &self.world.surroundings
            {
                let gathers = self.world.effects.has(Effect::ColorBleeding) && !rays.gathered;
                let light = light_from_around(s, surroundings, rays, hits, &coefficients, lobes.as_ref(), gathers);
                own = own + rays.weight.times(light);
            }
            if self.world.effects.has(Effect::GlobalIllumination) {
                own = own + sample_direct_light(self, rays, hits, &coefficients, lobes.as_ref());
            }
        }
        let (hits, lobes) = (&*hits, lobes.as_ref());
        let shaded = Shaded { rays, hits, coefficients: &coefficients, lobes, number };
        illuminate(self, shaded, own, sum);
        let global_illumination = V::DETAILS && self.world.effects.has(Effect::GlobalIllumination);
        let of_surface = self.cones.next;
        if V::DETAILS {
            if !global_illumination && self.world.effects.has(Effect::ColorBleeding) && !rays.gathered {
                scatter_diffuse(self, rays, hits, &coefficients, number);
            }
            if let Some(lobes) = lobes
                && (global_illumination || lobes.apart != 0)
            {
                scatter_clearcoat(self, rays, hits, lobes, number);
            }
        }
        let reflected = scatter(self, shaded);
        if global_illumination {
            self.cones.next = of_surface;
            if let Some(lobes) = lobes {
                // What a sample's facet does not reflect gets below.
                let below = lobes.below(s, reflected);
                coefficients.diffuse = V3::select(L::mask(s, lobes.lanes), below, coefficients.diffuse);
            }
            scatter_diffuse(self, rays, hits, &coefficients, number);
        }
    }

    /// The coefficients of what the rays have hit, without textures.
    #[inline(always)]
    pub(super) fn coefficients(&mut self, rays: &RayPacket<L>, hits: &Hits<L>) -> Coefficients<L> {
        let s = self.s;
        if V::FOOTPRINTS {
            self.cones.hit(s, hits);
        }
        stage::<L, V, _>(
            s,
            #[inline(always)]
            || {
                let widths = self.cones.widths();
                let extents = || footprints(s, self.world, rays, widths, hits);
                let filters = V::FOOTPRINTS && self.world.filters_checkers();
                hits.coefficients(s, self.world, if filters { Some(&extents) } else { None })
            },
        )
    }

    /// Radiance limited to [`MAX_RADIANCE`]: materials that amplify light cannot make it infinite.
    #[inline(always)]
    pub(super) fn bounded(&self, radiance: V3<L>) -> V3<L> {
        let max = L::lit(self.s, MAX_RADIANCE);
        V3 { x: radiance.x.min(max), y: radiance.y.min(max), z: radiance.z.min(max) }
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
