//! Observers of the recursion: the kernel reports events of every ray. The observer `()` gets no events and costs nothing.

use super::hits::Hits;
use super::ray_packet::{RayKind, RayPacket};
use crate::lanes::{Lanes, V3};
use crate::shading::media::Media;

/// Why a ray was not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NotFollowed {
    /// The chain has reached `max_depth`.
    Depth,
    /// Its weight is below what the pruning rule asks for: `min_weight`, or what the proof can spare.
    Weight,
    /// The sample has reached the limit on rays.
    Budget,
    /// Others stand for it (`roulette.rs`).
    Roulette,
}

/// The angles of Snell's law at a surface, of lane 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Snell {
    /// Index on the side the ray comes from.
    pub n1: f64,
    /// Index on the other side.
    pub n2: f64,
    /// theta1 in radians.
    pub theta1: f64,
    /// theta2 in radians; pi/2 under total internal reflection.
    pub theta2: f64,
    /// Whether all is reflected.
    pub total: bool,
    /// Unpolarised Fresnel reflectance, for information: materials without `fresnel` have constants instead.
    pub reflectance: f64,
}

/// Receives the events of a kernel with one lane.
pub(crate) trait Observer<L: Lanes> {
    /// Whether events are sent at all.
    const WATCHING: bool;
    /// A ray is followed; returns its number, which its children name as their parent.
    fn ray(&mut self, ray: &RayPacket<L>, media: &Media<L::Real>) -> u32;
    /// A sample outside the image circle, where it is dark.
    fn outside(&mut self);
    /// Radiance that a ray adds to the pixel, weight included.
    fn contributes(&mut self, ray: u32, radiance: V3<L>);
    /// What a ray hits.
    fn hits(&mut self, number: u32, ray: &RayPacket<L>, hits: &Hits<L>);
    /// A shadow ray to a light, what it lets through, and what it adds to the pixel, weight included.
    fn shadow(&mut self, ray: u32, light: usize, origin: V3<L>, to_light: V3<L>, passed: V3<L>, radiance: V3<L>);
    /// Snell's law at the surface a ray hits.
    fn refracts(&mut self, ray: u32, snell: Snell);
    /// The pixel begins, perhaps once more: forget all events.
    fn pixel(&mut self);
    /// A batch of its samples begins.
    fn batch(&mut self);
    /// Forget the events of the batch: it is traced again.
    fn again(&mut self);
    /// A ray that would have had this weight is not followed.
    fn not_followed(&mut self, ray: u32, kind: RayKind, weight: V3<L>, why: NotFollowed);
}

impl<L: Lanes> Observer<L> for () {
    const WATCHING: bool = false;
    #[inline(always)]
    fn ray(&mut self, _: &RayPacket<L>, _: &Media<L::Real>) -> u32 {
        0
    }
    #[inline(always)]
    fn outside(&mut self) {}
    #[inline(always)]
    fn contributes(&mut self, _: u32, _: V3<L>) {}
    #[inline(always)]
    fn hits(&mut self, _: u32, _: &RayPacket<L>, _: &Hits<L>) {}
    #[inline(always)]
    fn shadow(&mut self, _: u32, _: usize, _: V3<L>, _: V3<L>, _: V3<L>, _: V3<L>) {}
    #[inline(always)]
    fn refracts(&mut self, _: u32, _: Snell) {}
    #[inline(always)]
    fn pixel(&mut self) {}
    #[inline(always)]
    fn batch(&mut self) {}
    #[inline(always)]
    fn again(&mut self) {}
    #[inline(always)]
    fn not_followed(&mut self, _: u32, _: RayKind, _: V3<L>, _: NotFollowed) {}
}
