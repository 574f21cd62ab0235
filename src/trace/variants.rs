//! Which effects a kernel is compiled for. What a scene does not call for is not even in the kernel that traces it.
//!
//! Each axis doubles the kernels, so there are few, and the general kernel traces every scene to the same bytes. Within
//! an axis a kernel asks the scene's [`Called`](crate::scene::called::Called) once for a packet of rays.

use crate::lanes::Real;
use crate::scene::world::World;
use std::fmt::Debug;

/// What a kernel follows beside camera and shadow rays, as constants.
pub trait Effects: Copy + Debug + 'static {
    /// Mirrored rays, those of total internal reflection included.
    const REFLECTION: bool;
    /// Rays through bodies, the media they are in, and surfaces in the same place.
    const TRANSMISSION: bool;
    /// What surfaces, bodies and the space between them do beyond the lecture's model: see [`Called::details`](crate::scene::called::Called::details).
    const DETAILS: bool;
    /// Means over many choices, of which each sample makes one: see [`Called::sampled`](crate::scene::called::Called::sampled).
    const SAMPLED: bool;
}

/// A choice of effects.
#[derive(Debug, Clone, Copy)]
pub struct Only<const REFLECTION: bool, const TRANSMISSION: bool, const DETAILS: bool, const SAMPLED: bool>;

impl<const REFLECTION: bool, const TRANSMISSION: bool, const DETAILS: bool, const SAMPLED: bool> Effects
    for Only<REFLECTION, TRANSMISSION, DETAILS, SAMPLED>
{
    const REFLECTION: bool = REFLECTION;
    const TRANSMISSION: bool = TRANSMISSION;
    const DETAILS: bool = DETAILS;
    const SAMPLED: bool = SAMPLED;
}

/// Local illumination only.
pub type Local = Only<false, false, false, false>;
/// Mirrors, and nothing that light passes.
pub type Mirrors = Only<true, false, false, false>;
/// The lecture's whole model.
pub type Clear = Only<true, true, false, false>;
/// Details, and nothing that light passes.
pub type DetailedMirrors = Only<true, false, true, false>;
/// Everything that is no mean over choices.
pub type Detailed = Only<true, true, true, false>;
/// Everything: the general kernel.
pub type Everything = Only<true, true, true, true>;

/// The kernels there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as the types")]
pub enum Specialised {
    Local,
    Mirrors,
    Clear,
    DetailedMirrors,
    Detailed,
    Everything,
}

impl Specialised {
    /// The kernel for the effects that a world calls for.
    pub fn of<R: Real>(world: &World<R>) -> Self {
        match () {
            () if world.called.sampled() => Self::Everything,
            () if world.called.details() && world.transmits => Self::Detailed,
            () if world.called.details() => Self::DetailedMirrors,
            () if world.transmits => Self::Clear,
            () if world.reflects && world.rules.max_depth > 1 => Self::Mirrors,
            () => Self::Local,
        }
    }
}

impl Specialised {
    /// What it is compiled for: reflection, transmission, details, samples.
    pub fn axes(self) -> [bool; 4] {
        fn of<E: Effects>() -> [bool; 4] {
            [E::REFLECTION, E::TRANSMISSION, E::DETAILS, E::SAMPLED]
        }
        match self {
            Self::Local => of::<Local>(),
            Self::Mirrors => of::<Mirrors>(),
            Self::Clear => of::<Clear>(),
            Self::DetailedMirrors => of::<DetailedMirrors>(),
            Self::Detailed => of::<Detailed>(),
            Self::Everything => of::<Everything>(),
        }
    }
}
