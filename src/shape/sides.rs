//! Which sides of a surface rays can hit.

use crate::lanes::Lanes;

/// The sides from which a surface can be met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sides {
    /// Both: the usual case.
    Both,
    /// Only by rays against the outward normal: a one-sided surface.
    Outside,
    /// Only by rays along the outward normal: a one-sided surface of a hollow body.
    Inside,
}

impl Sides {
    /// The mask, if intersections from outside count.
    #[inline(always)]
    pub fn outside<L: Lanes>(self, s: L::Simd, mask: L::Mask) -> L::Mask {
        if self == Self::Inside { L::mask(s, 0) } else { mask }
    }

    /// The mask, if intersections from inside count.
    #[inline(always)]
    pub fn inside<L: Lanes>(self, s: L::Simd, mask: L::Mask) -> L::Mask {
        if self == Self::Outside { L::mask(s, 0) } else { mask }
    }
}
