//! What rays have hit, as it reflects light and lets it pass.

use super::hits::Hits;
use super::ray_packet::RayPacket;
use crate::lanes::Lanes;
use crate::shading::lobes::Lobes;
use crate::shading::material::Coefficients;

/// A packet of rays, and what it has hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shaded<'a, L: Lanes> {
    pub(super) rays: &'a RayPacket<L>,
    pub(super) hits: &'a Hits<L>,
    pub(super) coefficients: &'a Coefficients<L>,
    /// Of materials that have any.
    pub(super) lobes: Option<&'a Lobes<L>>,
    /// The number of the rays in a tree.
    pub(super) number: u32,
}
