//! Ray cones: the widths of the rays of a packet, from the cone of a pixel, the distances on the way and the surfaces that have
//! bent them (Akenine-Moeller et al., Texture Level of Detail Strategies for Real-Time Ray Tracing, Ray Tracing Gems, 2019).
//!
//! They have a stack of their own beside that of the rays, so that variants without footprints do not carry them. Beside them lies how
//! likely the direction of each ray was, where it was chosen.

use super::hits::Hits;
use crate::camera::Cone;
use crate::lanes::{Column, Columns, Lanes, V3, parts};
use crate::shading::texture::environment::Environment;

/// The cone of each ray where it starts: `[width, spread, density]`, the width and what it gains in a unit of distance. Both may
/// be below 0, where a cone has been turned inside out by a focus. The density is that of the choice among directions, by solid
/// angle, and 0 where nothing was chosen, or nothing else might have chosen it.
pub(super) type Cones<L> = [L; 3];

/// The cones of a packet's rays.
#[derive(Debug)]
pub(crate) struct RayCones<L> {
    /// The cone of a whole pixel.
    pixel: Cone,
    /// The cones of the current rays.
    current: Cones<L>,
    /// The cones of the next rays.
    pub(super) next: Cones<L>,
    /// Those of each entry of the stack of rays.
    waiting: Vec<Cones<L>>,
    /// Lanes whose shading normal bumps have tilted.
    pub(super) tilted: u32,
}

impl<L: Lanes> RayCones<L> {
    #[inline(always)]
    pub(super) fn new(s: L::Simd, pixel: Cone) -> Self {
        let nothing = [L::lit(s, 0.0); 3];
        Self { pixel, current: nothing, next: nothing, waiting: Vec::new(), tilted: 0 }
    }

    /// Starts at the eye, with a sample that has a given share of its pixel.
    #[inline(always)]
    pub(super) fn restart(&mut self, s: L::Simd, share: f64) {
        let part = share.sqrt();
        self.current = [self.pixel.width * part, self.pixel.spread * part, 0.0].map(|x| L::lit(s, x));
        self.waiting.clear();
    }

    /// The current rays have hit something: the next ones start there.
    #[inline(always)]
    pub(super) fn hit(&mut self, s: L::Simd, hits: &Hits<L>) {
        let [width, spread, _] = self.current;
        self.next = [L::select(L::mask(s, hits.found), width + spread * hits.t, width), spread, L::lit(s, 0.0)];
        self.tilted = 0;
    }

    /// Rays have been put on the stack.
    #[inline(always)]
    pub(super) fn push(&mut self) {
        self.waiting.push(self.next);
    }

    /// Rays have been taken from the stack.
    #[inline(always)]
    pub(super) fn pop(&mut self) {
        if let Some(cones) = self.waiting.pop() {
            self.current = cones;
        }
    }

    /// The current rays go on as they are.
    #[inline(always)]
    pub(super) fn go_on(&mut self) {
        self.next = self.current;
    }

    /// The cones of mirrored rays. A normal that turns by `curvature` in a unit of length turns them by twice as much.
    #[inline(always)]
    pub(super) fn mirrored(&self, s: L::Simd, curvature: L) -> Cones<L> {
        let [width, spread, _] = self.next;
        [width, spread + L::lit(s, 2.0) * curvature * width, L::lit(s, 0.0)]
    }

    /// The cones of transmitted rays: with t = eta d + (eta cos_1 - cos_2) n, they widen as d and n do. In `unseen` lanes the
    /// surface is invisible, and the current ray goes on. It finds its light alone: shadow rays end at such a surface.
    #[inline(always)]
    pub(super) fn transmitted(&self, s: L::Simd, curvature: L, eta: L, bend: L, unseen: L::Mask) -> Cones<L> {
        let ([width, spread, _], [start, old, _]) = (self.next, self.current);
        let spread = L::select(unseen, old, eta * spread + bend * curvature * width);
        [L::select(unseen, start, width), spread, L::lit(s, 0.0)]
    }

    /// How likely the directions of the current rays were.
    #[inline(always)]
    pub(super) fn densities(&self) -> L {
        self.current[2]
    }

    /// The next rays have directions of a density.
    #[inline(always)]
    pub(super) fn chosen(&mut self, density: L) {
        self.next[2] = density;
    }

    /// Widths of the rays where they hit.
    #[inline(always)]
    pub(super) fn widths(&self) -> L {
        self.next[0].abs()
    }

    /// Angles of the cones of the current rays.
    pub(super) fn spreads(&self) -> L {
        self.current[1].abs()
    }
}

/// The environment map in the directions of some lanes, over cones of some angles.
#[inline(never)]
pub(super) fn around<L: Lanes>(s: L::Simd, environment: &Environment, dir: V3<L>, lanes: u32, spreads: L) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let (dirs, spreads) = (Columns::of(dir), Column::of(spreads));
            let mut seen = Columns::of(V3::<L>::splat(s, [L::Real::default(); 3]));
            for (first, lanes) in parts::<L>(lanes) {
                let (dir, spread) = (dirs.part::<L::Double>(s, first), spreads.part(s, first));
                seen.put(s, first, L::Double::mask(s, lanes), environment.radiance(s, dir, spread, lanes));
            }
            seen.lanes(s)
        },
    )
}
