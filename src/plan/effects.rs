//! Which effects a kernel is compiled for. What a scene does not call for is not even in the kernel that traces it.
//!
//! Each axis doubles the kernels, so there are few, and the general kernel traces every scene to the same bytes.

use crate::lanes::Real;
use crate::scene::world::World;
use std::fmt::Debug;

/// What a kernel follows beside camera and shadow rays, as constants.
pub trait Effects: Copy + Debug + 'static {
    /// Mirrored rays, those of total internal reflection included.
    const REFLECTION: bool;
    /// Rays through bodies, the media they are in, and surfaces in the same place.
    const TRANSMISSION: bool;
}

/// Local illumination only.
#[derive(Debug, Clone, Copy)]
pub struct Local;
/// Mirrors, and nothing that light passes.
#[derive(Debug, Clone, Copy)]
pub struct Mirrors;
/// Everything: the general kernel.
#[derive(Debug, Clone, Copy)]
pub struct Everything;

impl Effects for Local {
    const REFLECTION: bool = false;
    const TRANSMISSION: bool = false;
}

impl Effects for Mirrors {
    const REFLECTION: bool = true;
    const TRANSMISSION: bool = false;
}

impl Effects for Everything {
    const REFLECTION: bool = true;
    const TRANSMISSION: bool = true;
}

/// The kernels there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as the types")]
pub enum Specialised {
    Local,
    Mirrors,
    Everything,
}

impl Specialised {
    /// The kernel for the effects that a world calls for.
    pub fn of<R: Real>(world: &World<R>) -> Self {
        let zero = R::from_f64(0.0);
        let reflects = world.materials.iter().any(|material| material.reflection.iter().any(|c| *c > zero));
        match () {
            () if world.transmits => Self::Everything,
            () if reflects && world.rules.max_depth > 1 => Self::Mirrors,
            () => Self::Local,
        }
    }
}
