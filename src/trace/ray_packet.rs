//! The packet of rays that the kernel follows.

use crate::accel::Coherence;
use crate::lanes::{Ids, Lanes, V3};
use crate::shading::media::OUTSIDE;
use schemars::JsonSchema;
use serde::Serialize;

/// Whitted's kinds of rays that are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RayKind {
    Camera,
    Reflected,
    Transmitted,
    /// From a diffuse surface, for the light that others scatter.
    Gathered,
}

/// A packet of rays to follow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayPacket<L: Lanes> {
    /// Start.
    pub origin: V3<L>,
    /// Unit direction.
    pub dir: V3<L>,
    /// Distance beyond which it sees: 0, or where it has passed an invisible surface.
    pub t_min: L,
    /// What its radiance is multiplied with on the way to the pixel.
    pub weight: V3<L>,
    /// Lanes that hold a ray.
    pub active: u32,
    /// The media the ray is in.
    pub media: L::Ids,
    /// Rays in the chain so far, this one included.
    pub depth: u32,
    /// Its kind.
    pub kind: RayKind,
    /// Whether the camera sees through it: nothing has reflected it.
    pub straight: bool,
    /// Whether it brings light that a diffuse surface has gathered: what it meets has ambient light, and gathers no more.
    pub gathered: bool,
    /// Names its place in the tree of rays, for [`Sampler`](super::sampling::Sampler).
    pub path: u32,
    /// Lanes whose light has been split into wavelengths.
    pub dispersed: u32,
    /// The observer's number of the ray it comes from.
    pub parent: u32,
}

impl<L: Lanes> RayPacket<L> {
    /// No rays, to be overwritten.
    #[inline(always)]
    pub(crate) fn none(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        let nowhere = V3 { x: zero, y: zero, z: zero };
        Self {
            origin: nowhere,
            dir: nowhere,
            t_min: zero,
            weight: nowhere,
            active: 0,
            media: L::Ids::splat(s, u64::from(OUTSIDE)),
            depth: 0,
            kind: RayKind::Camera,
            straight: true,
            gathered: false,
            path: 0,
            dispersed: 0,
            parent: 0,
        }
    }

    /// Whether these rays, and the shadow rays from what they hit, keep together.
    #[inline(always)]
    pub(super) fn coherence(&self) -> Coherence {
        if self.kind == RayKind::Camera { Coherence::Coherent } else { Coherence::Incoherent }
    }

    /// Where they begin to see.
    #[inline(always)]
    pub(crate) fn start(&self) -> V3<L> {
        self.origin + self.dir * self.t_min
    }
}
