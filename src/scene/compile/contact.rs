//! Marks bodies that might touch others. Only at their surfaces the kernel searches for other surfaces in the same place
//! (`trace/coincident.rs`). Bodies that are clearly apart, or clearly inside a ball or a box, cost nothing.
//!
//! The marks are conservative: a body without one is further from everything than any rounding.

use crate::accel::{Bounds, Extent, Geometry, Item, Shape};
use crate::control;
use crate::lanes::Real;
use glam::DVec3;
use rayon::prelude::*;

/// Distances below this number of roundings of the coordinates count as contact.
const ROUNDINGS: f64 = 256.0;
/// Most pairs of overlapping boxes that are compared; with more, every body is marked.
const MAX_PAIRS: usize = 5_000_000;

/// Marks the items of one geometry that might touch another one there.
pub(super) fn mark_siblings<R: Real>(items: &mut [Item<R>], extents: &[Option<Extent>]) {
    let boxes: Vec<Option<Bounds>> = items.iter().zip(extents).map(|(item, extent)| bounds(item, extent)).collect();
    let largest = boxes.iter().flatten().map(|b| b.min.abs().max(b.max.abs()).max_element()).fold(0.0, f64::max);
    let slack = ROUNDINGS * R::ROUNDOFF * largest;
    // Sweep along x: only items that overlap in x are compared. Unbounded ones come first and never end.
    let stretch =
        |i: usize| boxes[i].map_or((f64::NEG_INFINITY, f64::INFINITY), |b| (b.min.x - slack, b.max.x + slack));
    let mut order: Vec<(f64, usize)> = (0..items.len()).map(|i| (stretch(i).0, i)).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut marked = vec![false; items.len()];
    let mut open: Vec<usize> = Vec::new();
    let mut pairs = 0;
    for (start, i) in order {
        open.retain(|&j| stretch(j).1 >= start);
        pairs += open.len();
        if pairs > MAX_PAIRS || control::step(1 + (open.len() / 16) as u32) {
            marked.fill(true);
            break;
        }
        for &j in &open {
            let known = marked[i] && marked[j];
            if known || are_apart((&items[i], boxes[i]), (&items[j], boxes[j]), slack) {
                continue;
            }
            (marked[i], marked[j]) = (true, true);
        }
        open.push(i);
    }
    for (item, marked) in items.iter_mut().zip(marked) {
        item.may_touch = marked;
    }
}

/// Marks the items inside of placed geometries that might touch something. Geometries come after those they place.
pub(super) fn mark_placed<R>(geometries: &mut [Geometry<R>]) {
    let mut exposed = vec![false; geometries.len()];
    for index in (0..geometries.len()).rev() {
        for item in &mut geometries[index].items {
            item.may_touch |= exposed[index];
            if let Shape::Instance(instance) = &item.shape {
                exposed[instance.geometry as usize] |= item.may_touch;
            }
        }
    }
}

/// Box around an item, if it has bounds.
pub(super) fn bounds<R: Real>(item: &Item<R>, extent: &Option<Extent>) -> Option<Bounds> {
    match &item.shape {
        Shape::Mesh(mesh) => Some(Bounds::around(mesh.vertices.iter().map(|v| DVec3::from_array(v.map(Real::to_f64))))),
        _ => extent.map(|extent| extent.bounds),
    }
}

type Boxed<'a, R> = (&'a Item<R>, Option<Bounds>);

/// Whether two items are certainly further apart than `slack`.
fn are_apart<R: Real>(a: Boxed<'_, R>, b: Boxed<'_, R>, slack: f64) -> bool {
    if let (Some(a), Some(b)) = (a.1, b.1)
        && ((a.min - slack).cmpgt(b.max).any() || (b.min - slack).cmpgt(a.max).any())
    {
        return true;
    }
    lies_clear(a, b, slack) || lies_clear(b, a, slack)
}

/// Whether `b` lies inside the ball or box `a`, or in front of or behind the plane `a`, with `slack` to spare.
fn lies_clear<R: Real>((a, _): Boxed<'_, R>, (b, bounds): Boxed<'_, R>, slack: f64) -> bool {
    let Some(bounds) = bounds else { return false };
    let point = |p: [R; 3]| DVec3::from_array(p.map(Real::to_f64));
    match (&a.shape, &b.shape) {
        (Shape::Sphere(a), Shape::Sphere(b)) => {
            let distance = point(a.center).distance(point(b.center));
            distance + b.radius.to_f64() + slack < a.radius.to_f64()
                || a.radius.to_f64() + b.radius.to_f64() + slack < distance
        }
        (Shape::Sphere(a), _) => {
            bounds.corners().iter().all(|p| p.distance(point(a.center)) + slack < a.radius.to_f64())
        }
        (Shape::Cuboid(a), _) => {
            (point(a.min) + slack).cmplt(bounds.min).all() && (point(a.max) - slack).cmpgt(bounds.max).all()
        }
        (Shape::Plane(a), _) => {
            let heights = bounds.corners().map(|p| point(a.normal).dot(p - point(a.point)));
            heights.iter().all(|h| *h > slack) || heights.iter().all(|h| *h < -slack)
        }
        _ => false,
    }
}
