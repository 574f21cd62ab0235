//! How far inside of a picture points of the scene are seen.

use super::{Basis, View};
use crate::lanes::{Lanes, Real, V3};
use glam::DVec3;

/// The edges of a whole picture, whatever window of it is rendered.
#[derive(Debug, Clone, Copy)]
pub struct PictureEdges<R> {
    eye: [R; 3],
    forward: [R; 3],
    /// Right and up, divided by half the extent of the picture at distance 1, or at any distance if rays are parallel.
    sides: [[R; 3]; 2],
    parallel: bool,
}

impl<R: Real> PictureEdges<R> {
    /// Those of a flat picture of half this width and height: at distance 1, or at any if its rays are parallel. `None` if the view
    /// has no direction.
    pub fn new(view: &View, half: [f64; 2], parallel: bool) -> Option<Self> {
        let basis = Basis::new(view)?;
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        Some(Self {
            eye: narrow(basis.eye),
            forward: narrow(basis.forward),
            sides: [narrow(basis.right / half[0]), narrow(basis.up / half[1])],
            parallel,
        })
    }

    /// 1 in the middle of the picture, 0 at its edges, and less outside; points behind a pinhole are outside.
    #[inline(always)]
    pub fn inside<L: Lanes<Real = R>>(&self, s: L::Simd, point: V3<L>) -> L {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let way = point - V3::splat(s, self.eye);
        let [right, up] = self.sides;
        let (x, y) = (way.dot(V3::splat(s, right)).abs(), way.dot(V3::splat(s, up)).abs());
        let depth = if self.parallel { one } else { way.dot(V3::splat(s, self.forward)) };
        L::select(depth.gt(zero), one - x.max(y) / depth, -one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_one_and_edges_are_zero() {
        let view = View { eye: [1.0, 2.0, 3.0], look_at: [1.0, 2.0, -7.0], up: [0.0, 1.0, 0.0] };
        for (parallel, depth) in [(false, 4.0), (true, 1.0)] {
            let edges = PictureEdges::<f64>::new(&view, [0.5, 0.25], parallel).unwrap();
            let inside =
                |x: f64, y: f64| edges.inside::<f64>((), V3 { x: 1.0 + x * depth, y: 2.0 + y * depth, z: -1.0 });
            for (x, y, expected) in
                [(0.0, 0.0, 1.0), (0.5, 0.0, 0.0), (0.0, -0.25, 0.0), (-0.25, 0.0, 0.5), (1.0, 0.1, -1.0)]
            {
                assert_eq!(inside(x, y), expected, "{parallel} {x} {y}");
            }
        }
        let edges = PictureEdges::<f64>::new(&view, [1.0; 2], false).unwrap();
        assert_eq!(edges.inside::<f64>((), V3 { x: 1.0, y: 2.0, z: 4.0 }), -1.0);
    }
}
