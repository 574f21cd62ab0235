//! Light sources: direction and irradiance factor at a point.

use crate::lanes::{Lanes, Real, V3};

/// Largest factor of an inverse-square light, so that a point beside the light is bright, not infinite.
const MAX_STRENGTH: f64 = 1e15;

/// A light in the kernel's format.
#[derive(Debug, Clone, Copy)]
pub struct Light<R> {
    /// Where its light comes from.
    pub source: Source<R>,
    /// Colour times intensity.
    pub color: [R; 3],
    /// How it fades with distance.
    pub falloff: Falloff<R>,
}

/// Kinds of sources.
#[derive(Debug, Clone, Copy)]
pub enum Source<R> {
    /// A point that shines everywhere.
    Point {
        /// Where it is.
        position: [R; 3],
    },
    /// Parallel light.
    Directional {
        /// Unit direction towards the light.
        to_light: [R; 3],
    },
    /// A point that shines into a cone.
    Spot {
        /// Where it is.
        position: [R; 3],
        /// Unit direction of the axis.
        axis: [R; 3],
        /// 1 - cos of the angle within which it is fully lit.
        inner: R,
        /// 1 - cos of the angle beyond which it is dark.
        outer: R,
    },
}

/// How light fades.
#[derive(Debug, Clone, Copy)]
pub enum Falloff<R> {
    /// Not at all.
    None,
    /// 1 - d/reach, never below 0.
    Linear {
        /// Distance at which the light is gone.
        reach: R,
    },
    /// 1/d^2.
    InverseSquare,
}

/// Light arriving at points.
#[derive(Debug, Clone, Copy)]
pub struct Arrival<L: Lanes> {
    /// Unit direction towards the light; NaN at a point light's own position.
    pub to_light: V3<L>,
    /// Factor on the light's colour: falloff and cone; 0 at a point light's own position.
    pub strength: L,
}

impl<R: Real> Light<R> {
    /// The light's position, unless it is infinitely far.
    pub fn position(&self) -> Option<[R; 3]> {
        match self.source {
            Source::Point { position } | Source::Spot { position, .. } => Some(position),
            Source::Directional { .. } => None,
        }
    }

    /// What arrives at points if nothing is in between.
    #[inline(always)]
    pub fn arrive<L: Lanes<Real = R>>(&self, s: L::Simd, point: V3<L>) -> Arrival<L> {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let position = match self.source {
            Source::Directional { to_light } => return Arrival { to_light: V3::splat(s, to_light), strength: one },
            Source::Point { position } | Source::Spot { position, .. } => V3::<L>::splat(s, position),
        };
        let way = position - point;
        let squared = way.dot(way);
        let distance = squared.sqrt();
        let to_light = way * (one / distance);
        let mut strength = match self.falloff {
            Falloff::None => one,
            Falloff::Linear { reach } => (one - distance / L::splat(s, reach)).max(zero),
            Falloff::InverseSquare => one / squared,
        };
        if let Source::Spot { axis, inner, outer, .. } = self.source {
            let (inner, outer) = (L::splat(s, inner), L::splat(s, outer));
            let axis = V3::splat(s, axis);
            let cosine = -to_light.dot(axis);
            // 1 - cos(a) = sin^2(a) / (1 + cos(a)) keeps its digits in narrow cones, where the cosine has none left.
            let across = to_light.cross(axis);
            let versine = across.dot(across) / (one + cosine);
            let versine = L::select(cosine.gt(zero), versine, one - cosine);
            let part = ((outer - versine) / (outer - inner)).max(zero).min(one);
            let smooth = part * part * (L::lit(s, 3.0) - L::lit(s, 2.0) * part);
            let hard = L::select(versine.le(outer), one, zero);
            strength = strength * L::select(inner.lt(outer), smooth, hard);
        }
        let strength = strength.min(L::lit(s, MAX_STRENGTH));
        Arrival { to_light, strength: L::select(squared.gt(zero), strength, zero) }
    }
}
