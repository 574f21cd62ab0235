//! Which effects a kernel is compiled for. What a scene does not call for is not even in the kernel that traces it.
//!
//! Each variant is another copy of the kernel, so there are few, and the general one traces every scene to the same bytes. Within
//! a variant a kernel asks the scene's [`SceneEffects`](crate::scene::effects::SceneEffects) once for a packet of rays.

use crate::lanes::Real;
use crate::scene::world::World;
use std::fmt::Debug;

/// What a variant is compiled for beside camera rays, shadow rays and Phong's model, as constants.
pub trait Variant: Copy + Debug + 'static {
    /// Reflected and transmitted rays, the media they are in, and surfaces in the same place.
    const SECONDARY: bool;
    /// The footprints of rays, over which checkers are averaged.
    const FOOTPRINTS: bool;
    /// What goes beyond Whitted's model: see [`SceneEffects::has_details`](crate::scene::effects::SceneEffects::has_details)
    /// and [`SceneEffects::needs_sampling`](crate::scene::effects::SceneEffects::needs_sampling).
    const DETAILS: bool;
}

/// Local illumination only.
#[derive(Debug, Clone, Copy)]
pub struct Local;
/// Whitted's model: local illumination, reflection, transmission.
#[derive(Debug, Clone, Copy)]
pub struct Whitted;
/// Whitted's model with the checkerboards of his picture, averaged over footprints.
#[derive(Debug, Clone, Copy)]
pub struct Filtered;
/// Everything: the general kernel.
#[derive(Debug, Clone, Copy)]
pub struct General;

impl Variant for Local {
    const SECONDARY: bool = false;
    const FOOTPRINTS: bool = false;
    const DETAILS: bool = false;
}

impl Variant for Whitted {
    const SECONDARY: bool = true;
    const FOOTPRINTS: bool = false;
    const DETAILS: bool = false;
}

impl Variant for Filtered {
    const SECONDARY: bool = true;
    const FOOTPRINTS: bool = true;
    const DETAILS: bool = false;
}

impl Variant for General {
    const SECONDARY: bool = true;
    const FOOTPRINTS: bool = true;
    const DETAILS: bool = true;
}

/// The variants there are. `src/DECISIONS.md` says what each one saves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as the types")]
pub enum KernelVariant {
    Local,
    Whitted,
    Filtered,
    General,
}

impl KernelVariant {
    /// The variant for the effects of a world.
    ///
    /// What mirrors or transmits counts even where no ray that leaves it is followed: what such rays could have brought has
    /// to be known.
    pub fn of<R: Real>(world: &World<R>) -> Self {
        let details = world.effects.has_details() || world.angular;
        match () {
            () if details || world.effects.needs_sampling() => Self::General,
            () if world.filters_checkers() => Self::Filtered,
            () if world.transmits || world.reflects => Self::Whitted,
            () => Self::Local,
        }
    }

    /// What it is compiled for: reflection, transmission, footprints, details, samples.
    pub fn axes(self) -> [bool; 5] {
        fn of<V: Variant>() -> [bool; 5] {
            [V::SECONDARY, V::SECONDARY, V::FOOTPRINTS, V::DETAILS, V::DETAILS]
        }
        match self {
            Self::Local => of::<Local>(),
            Self::Whitted => of::<Whitted>(),
            Self::Filtered => of::<Filtered>(),
            Self::General => of::<General>(),
        }
    }
}
