//! Light sources: direction and irradiance factor at a point.

use crate::lanes::{Lanes, Real, V3, circle};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Largest factor of an inverse-square light: a point beside the light is bright, not infinite.
const MAX_STRENGTH: f64 = 1e15;

/// The narrowest disc in the sky that rays are said to find, as the tangent of half its angle. Single precision tells too few
/// directions apart in narrower ones, which are points for highlights: the narrowest of these is ten times as wide.
const NARROWEST_DISC: f64 = 1e-4;

/// A light in the kernel's format.
#[derive(Debug, Clone, Copy)]
pub struct Light<R> {
    /// Where its light comes from.
    pub source: Source<R>,
    /// Color times intensity.
    pub color: [R; 3],
    /// Falloff with distance.
    pub falloff: Falloff<R>,
    /// Its area, if it is more than a point.
    pub area: Option<Area<R>>,
    /// Its place in the scene's list, where there may be others that light nothing.
    pub number: u32,
}

/// Areas around a light's position, or in the sky.
#[derive(Debug, Clone, Copy)]
pub enum Area<R> {
    /// A disc that faces each point it lights. For lights with a position it has a radius, for lights in the sky the tangent
    /// of half its angle.
    Disc {
        /// Radius.
        radius: R,
    },
    /// A parallelogram, by its edges; for lights with a position.
    Parallelogram {
        /// One edge.
        u: [R; 3],
        /// The other edge.
        v: [R; 3],
    },
}

impl<R: Real> Area<R> {
    /// How far it reaches from its middle at most.
    pub fn reach(&self) -> f64 {
        let length = |edge: [R; 3]| DVec3::from_array(edge.map(Real::to_f64)).length();
        match *self {
            Self::Disc { radius } => radius.to_f64(),
            Self::Parallelogram { u, v } => 0.5 * (length(u) + length(v)),
        }
    }
}

/// Where light comes from, in each lane.
#[derive(Debug, Clone, Copy)]
pub enum Place<L: Lanes> {
    /// From a point.
    Point(V3<L>),
    /// From infinitely far away, in this unit direction.
    Sky(V3<L>),
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

/// Falloff with the distance d.
#[derive(Debug, Clone, Copy)]
pub enum Falloff<R> {
    /// Not at all.
    None,
    /// 1 - d/reach, never below 0.
    Linear {
        /// Distance at which the light is 0.
        reach: R,
    },
    /// 1/d^2.
    InverseSquare,
    /// 1/d^2 (1 - (d/range)^4), never below 0.
    Windowed {
        /// Distance at which the light is 0.
        range: R,
    },
}

/// Highest density of a choice: its inverse is a number, too.
const HIGHEST_PDF: f64 = 1e30;

/// A parallelogram as directions meet it.
struct Edges<R> {
    /// Unit normal.
    normal: [R; 3],
    /// Area.
    size: R,
    /// What the scalar products with a way from its middle along it are: shares of its edges.
    shares: [[R; 3]; 2],
}

impl<R: Real> Edges<R> {
    /// Of two edges. Worked out in double precision: squares of areas would not fit into single.
    #[inline(always)]
    fn of(u: &[R; 3], v: &[R; 3]) -> Self {
        let [u, v] = [u, v].map(|edge| DVec3::from_array(edge.map(Real::to_f64)));
        let normal = u.cross(v);
        let size = normal.length();
        let unit = normal / size;
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        Self {
            normal: narrow(unit),
            size: R::from_f64(size),
            shares: [narrow(v.cross(unit) / size), narrow(unit.cross(u) / size)],
        }
    }
}

/// The square of a length.
#[inline(always)]
fn square<L: Lanes>(s: L::Simd, length: L::Real) -> L {
    L::splat(s, length) * L::splat(s, length)
}

/// Light that arrives at points.
#[derive(Debug, Clone, Copy)]
pub struct Arrival<L: Lanes> {
    /// Unit direction towards the light; NaN at a point light's own position.
    pub to_light: V3<L>,
    /// Factor on the light's color: falloff and cone; 0 at a point light's own position.
    pub strength: L,
}

impl<R: Real> Light<R> {
    /// The light's middle.
    #[inline(always)]
    pub fn middle<L: Lanes<Real = R>>(&self, s: L::Simd) -> Place<L> {
        match self.source {
            Source::Point { position } | Source::Spot { position, .. } => Place::Point(V3::splat(s, position)),
            Source::Directional { to_light } => Place::Sky(V3::splat(s, to_light)),
        }
    }

    /// Of a disc in the sky that rays can find, the direction of its middle and the tangent of half its angle.
    pub fn sky_disc(&self) -> Option<([R; 3], R)> {
        match (self.source, self.area) {
            (Source::Directional { to_light }, Some(Area::Disc { radius })) => {
                (radius >= R::from_f64(NARROWEST_DISC)).then_some((to_light, radius))
            }
            _ => None,
        }
    }

    /// How likely [`Self::place`] chooses a direction of a disc in the sky, by solid angle: 1 / (pi tan^2 cos^3), and 0 beside it.
    #[inline(always)]
    pub fn disc_pdf<L: Lanes<Real = R>>(&self, s: L::Simd, dir: V3<L>) -> L {
        let zero = L::lit(s, 0.0);
        let Some((to_light, radius)) = self.sky_disc() else { return zero };
        let middle = V3::<L>::splat(s, to_light);
        let (along, across, radius) = (middle.dot(dir), middle.cross(dir), L::splat(s, radius));
        // The sine does not cancel in narrow discs.
        let inside = along.gt(zero) & across.dot(across).le(radius * radius * along * along);
        L::select(inside, L::lit(s, FRAC_1_PI) / (radius * radius * along * along * along), zero)
    }

    /// How likely [`Self::place`] chooses a place that it has chosen, by solid angle. It is huge where the area is seen edge-on, and finite.
    #[inline(always)]
    pub fn chosen_pdf<L: Lanes<Real = R>>(&self, s: L::Simd, area: &Area<R>, point: V3<L>, place: &Place<L>) -> L {
        let (position, middle) = match (*place, self.middle(s)) {
            (Place::Point(position), Place::Point(middle)) => (position - point, middle - point),
            (Place::Sky(dir), Place::Sky(middle)) => {
                let along = middle.dot(dir);
                return match area {
                    Area::Disc { radius } => L::lit(s, FRAC_1_PI) / (square::<L>(s, *radius) * along * along * along),
                    Area::Parallelogram { .. } => L::lit(s, f64::INFINITY),
                };
            }
            _ => return L::lit(s, 0.0),
        };
        // d^2 / (A cos), in ratios of lengths and with what is known of the place: of directions along the area the cosine is rounding.
        let squared = position.dot(position);
        let distance = squared.sqrt();
        let pdf = match area {
            Area::Disc { radius } => {
                let ratio = distance / L::splat(s, *radius);
                ratio * ratio * (distance / middle.dot(middle).sqrt()) * L::lit(s, FRAC_1_PI)
            }
            Area::Parallelogram { u, v } => {
                let Edges { normal, size, .. } = Edges::of(u, v);
                squared / L::splat(s, size) * (distance / position.dot(V3::splat(s, normal)).abs())
            }
        };
        pdf.min(L::lit(s, HIGHEST_PDF))
    }

    /// Where a direction from a point meets the light's area, and how likely [`Self::place`] chooses that, by solid angle: 0 beside it.
    #[inline(always)]
    pub fn place_pdf<L: Lanes<Real = R>>(&self, s: L::Simd, area: &Area<R>, point: V3<L>, dir: V3<L>) -> (L, Place<L>) {
        let zero = L::lit(s, 0.0);
        let middle = match self.middle(s) {
            Place::Point(position) => position - point,
            Place::Sky(_) => return (self.disc_pdf(s, dir), Place::Sky(dir)),
        };
        let (pdf, inside, distance) = match area {
            Area::Disc { radius } => {
                let distance = middle.dot(middle).sqrt();
                let way = middle * (L::lit(s, 1.0) / distance);
                let (along, across, radius) = (way.dot(dir), way.cross(dir), L::splat(s, *radius) / distance);
                let inside = along.gt(zero) & across.dot(across).le(radius * radius * along * along);
                let pdf = L::lit(s, FRAC_1_PI) / (radius * radius * along * along * along);
                (pdf, inside, distance / along)
            }
            Area::Parallelogram { u, v } => {
                let Edges { normal, size, shares } = Edges::of(u, v);
                let normal = V3::splat(s, normal);
                let cosine = dir.dot(normal);
                let distance = middle.dot(normal) / cosine;
                let from_middle = dir * distance - middle;
                let half = L::lit(s, 0.5);
                let [a, b] = [V3::splat(s, shares[0]), V3::splat(s, shares[1])];
                let inside = from_middle.dot(a).abs().le(half) & from_middle.dot(b).abs().le(half) & distance.gt(zero);
                (distance * distance / (L::splat(s, size) * cosine.abs()), inside, distance)
            }
        };
        (L::select(inside, pdf.min(L::lit(s, HIGHEST_PDF)), zero), Place::Point(point + dir * distance))
    }

    /// How likely a place near the middle is chosen, by solid angle, as if the area faced the point; infinite if it has no size.
    #[inline(always)]
    pub fn middle_pdf<L: Lanes<Real = R>>(&self, s: L::Simd, area: &Area<R>, point: V3<L>) -> L {
        let far = match self.middle(s) {
            Place::Point(position) => (position - point).dot(position - point),
            Place::Sky(_) if self.sky_disc().is_some() => L::lit(s, 1.0),
            Place::Sky(_) => return L::lit(s, f64::INFINITY),
        };
        let size = match area {
            Area::Disc { radius } => square::<L>(s, *radius) * L::lit(s, PI),
            Area::Parallelogram { u, v } => L::splat(s, Edges::of(u, v).size),
        };
        far / size
    }

    /// The radiance at the rim of a disc in the sky, where it is highest.
    pub fn disc_radiance(&self) -> Option<[f64; 3]> {
        let (_, radius) = self.sky_disc()?;
        let square = radius.to_f64() * radius.to_f64();
        // White scatters 1/pi of what arrives, and shows the color of the light.
        let radiance = crate::math::pow(1.0 + square, 1.5) / square;
        Some(self.color.map(|channel| channel.to_f64() * radiance))
    }

    /// Maps a point (a, b) of the unit square to a place on the light's area, seen from `point`.
    #[inline(always)]
    pub fn place<L: Lanes<Real = R>>(&self, s: L::Simd, area: &Area<R>, point: V3<L>, [a, b]: [L; 2]) -> Place<L> {
        let middle = self.middle(s);
        match area {
            Area::Parallelogram { u, v } => {
                let half = L::lit(s, 0.5);
                let offset = V3::<L>::splat(s, *u) * (a - half) + V3::splat(s, *v) * (b - half);
                match middle {
                    Place::Point(position) => Place::Point(position + offset),
                    Place::Sky(_) => middle,
                }
            }
            Area::Disc { radius } => {
                let way = match middle {
                    Place::Point(position) => (position - point).normalized(s),
                    Place::Sky(to_light) => to_light,
                };
                let [x, y] = circle(s, a);
                let reach = b.sqrt() * L::splat(s, *radius);
                let [right, up] = way.across(s);
                let offset = right * (x * reach) + up * (y * reach);
                match middle {
                    Place::Point(position) => Place::Point(position + offset),
                    Place::Sky(to_light) => Place::Sky((to_light + offset).normalized(s)),
                }
            }
        }
    }

    /// The light that arrives at points from a place of the light if nothing is in between.
    #[inline(always)]
    pub fn arrive<L: Lanes<Real = R>>(&self, s: L::Simd, point: V3<L>, place: &Place<L>) -> Arrival<L> {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let position = match *place {
            Place::Sky(to_light) => return Arrival { to_light, strength: one },
            Place::Point(position) => position,
        };
        let way = position - point;
        let squared = way.dot(way);
        let distance = squared.sqrt();
        let to_light = way * (one / distance);
        let mut strength = match self.falloff {
            Falloff::None => one,
            Falloff::Linear { reach } => (one - distance / L::splat(s, reach)).max(zero),
            Falloff::InverseSquare => one / squared,
            Falloff::Windowed { range } => {
                let part = squared / (L::splat(s, range) * L::splat(s, range));
                (one - part * part).max(zero) / squared
            }
        };
        if let Source::Spot { axis, inner, outer, .. } = self.source {
            let (inner, outer) = (L::splat(s, inner), L::splat(s, outer));
            let axis = V3::splat(s, axis);
            let cosine = -to_light.dot(axis);
            // 1 - cos(a) = sin^2(a) / (1 + cos(a)) does not cancel in narrow cones, where the cosine is near 1.
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
