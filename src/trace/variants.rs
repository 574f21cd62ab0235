//! Which effects a kernel is compiled for. What a scene does not call for is not even in the kernel that traces it.
//!
//! Each axis doubles the kernels, so there are few, and the general kernel traces every scene to the same bytes. Within
//! an axis a kernel asks the scene's [`Called`](crate::scene::called::Called) once for a packet of rays.

use crate::lanes::Real;
use crate::scene::world::World;
use std::fmt::Debug;

/// What a variant is compiled for beside camera rays, shadow rays and Phong's model, as constants.
pub trait Effects: Copy + Debug + 'static {
    /// Reflected and transmitted rays, the media they are in, and surfaces in the same place.
    const SECONDARY: bool;
    /// What goes beyond Whitted's model: see [`Called::details`](crate::scene::called::Called::details) and
    /// [`Called::sampled`](crate::scene::called::Called::sampled).
    const DETAILS: bool;
}

/// Local illumination only.
#[derive(Debug, Clone, Copy)]
pub struct Local;
/// Whitted's model: local illumination, reflection, transmission.
#[derive(Debug, Clone, Copy)]
pub struct Whitted;
/// Everything: the general kernel.
#[derive(Debug, Clone, Copy)]
pub struct Everything;

impl Effects for Local {
    const SECONDARY: bool = false;
    const DETAILS: bool = false;
}

impl Effects for Whitted {
    const SECONDARY: bool = true;
    const DETAILS: bool = false;
}

impl Effects for Everything {
    const SECONDARY: bool = true;
    const DETAILS: bool = true;
}

/// The variants there are. `src/DECISIONS.md` says what each one saves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as the types")]
pub enum Specialised {
    Local,
    Whitted,
    Everything,
}

impl Specialised {
    /// The variant for the effects that a world calls for.
    pub fn of<R: Real>(world: &World<R>) -> Self {
        match () {
            () if world.called.sampled() || world.called.details() => Self::Everything,
            () if world.transmits || (world.reflects && world.rules.max_depth > 1) => Self::Whitted,
            () => Self::Local,
        }
    }

    /// What it is compiled for: reflection, transmission, details, samples.
    pub fn axes(self) -> [bool; 4] {
        match self {
            Self::Local => [false; 4],
            Self::Whitted => [true, true, false, false],
            Self::Everything => [true; 4],
        }
    }
}
