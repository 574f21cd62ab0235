//! Hierarchies as textbooks build them: by the median, by surface areas without a look at infinity, and by the middle
//! of the centres without a look at centres that are equal.

use super::{Object, Shape};
use crate::common::naive;
use crate::hard_cases::lab::Lab;
use glam::DVec3;

/// A box around some objects, and the objects or two such boxes.
pub struct Tree {
    low: DVec3,
    high: DVec3,
    below: Below,
}

enum Below {
    Objects(Vec<usize>),
    Halves { axis: usize, halves: Box<[Tree; 2]> },
}

/// Where to cut a list of objects: the axis to sort them along, and how many go to the first half.
type Cut = Option<(usize, usize)>;

fn bounds(shape: &Shape) -> (DVec3, DVec3) {
    match *shape {
        Shape::Sphere(center, radius) => (center - radius, center + radius),
        Shape::Plane(..) => (DVec3::NEG_INFINITY, DVec3::INFINITY),
        Shape::Cuboid(low, high) => (low, high),
        Shape::Triangle([a, b, c]) => (a.min(b).min(c), a.max(b).max(c)),
    }
}

/// Infinity less infinity is no number, and stays so.
fn center(object: &Object) -> DVec3 {
    let (low, high) = bounds(&object.shape);
    (low + high) / 2.0
}

fn around(objects: &[Object], list: &[usize]) -> (DVec3, DVec3) {
    list.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), i| {
        let (l, h) = bounds(&objects[*i].shape);
        (low.min(l), high.max(h))
    })
}

fn sort(objects: &[Object], list: &mut [usize], axis: usize) {
    let key = |i: &usize| center(&objects[*i])[axis];
    list.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
}

fn area((low, high): (DVec3, DVec3)) -> f64 {
    let e = high - low;
    2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
}

/// The widest axis, in halves of equal number.
pub fn median(objects: &[Object], list: &[usize]) -> Cut {
    let (low, high) = around(objects, list);
    (list.len() > 1).then(|| ((high - low).max_position(), list.len() / 2))
}

/// The cut with the least expected cost, if it is cheaper than none.
pub fn areas(objects: &[Object], list: &[usize]) -> Cut {
    let whole = area(around(objects, list));
    let (mut best, mut least) = (None, list.len() as f64);
    for axis in 0..3 {
        let mut sorted = list.to_vec();
        sort(objects, &mut sorted, axis);
        for k in 1..list.len() {
            let (left, right) = sorted.split_at(k);
            let [a, b] = [left, right].map(|half| area(around(objects, half)) * half.len() as f64);
            let cost = 1.0 + (a + b) / whole;
            if cost < least {
                (best, least) = (Some((axis, k)), cost);
            }
        }
    }
    best
}

/// Those whose centres lie below the middle of the centres, until four are left.
pub fn middle(objects: &[Object], list: &[usize]) -> Cut {
    let centers = || list.iter().map(|i| center(&objects[*i]));
    let (low, high) = centers().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
    let axis = (high - low).max_position();
    let below = centers().filter(|c| c[axis] < f64::midpoint(low[axis], high[axis])).count();
    (list.len() > 4).then_some((axis, below))
}

impl Tree {
    /// A hierarchy of all objects; `None` where it gets deeper than `deepest`, for builders that do not end.
    pub fn of(objects: &[Object], cut: fn(&[Object], &[usize]) -> Cut, deepest: u32) -> Option<Self> {
        Self::over(objects, (0..objects.len()).collect(), cut, deepest)
    }

    fn over(objects: &[Object], mut list: Vec<usize>, cut: fn(&[Object], &[usize]) -> Cut, left: u32) -> Option<Self> {
        let (low, high) = around(objects, &list);
        let Some((axis, k)) = cut(objects, &list) else {
            return Some(Self { low, high, below: Below::Objects(list) });
        };
        let left = left.checked_sub(1)?;
        sort(objects, &mut list, axis);
        let far = list.split_off(k);
        let halves = [Self::over(objects, list, cut, left)?, Self::over(objects, far, cut, left)?];
        Some(Self { low, high, below: Below::Halves { axis, halves: Box::new(halves) } })
    }

    /// The nearest hit, of equal ones the first met on the way through the tree, and how many boxes and objects were asked.
    pub fn nearest(&self, lab: &Lab, objects: &[Object], o: DVec3, d: DVec3) -> (Option<usize>, u64) {
        let (mut best, mut asked) = ((f64::INFINITY, None), 0);
        self.search(lab, objects, o, d, &mut best, &mut asked);
        (best.1, asked)
    }

    fn search(
        &self,
        lab: &Lab,
        objects: &[Object],
        o: DVec3,
        d: DVec3,
        best: &mut (f64, Option<usize>),
        asked: &mut u64,
    ) {
        *asked += 1;
        if !naive::slab(lab, o, d, self.low, self.high, false) {
            return;
        }
        match &self.below {
            Below::Objects(list) => {
                for i in list {
                    *asked += 1;
                    if let Some(t) = objects[*i].shape.meet(lab, o, d, 1e-4)
                        && t < best.0
                    {
                        *best = (t, Some(*i));
                    }
                }
            }
            Below::Halves { axis, halves } => {
                let first = usize::from(d[*axis] < 0.0);
                halves[first].search(lab, objects, o, d, best, asked);
                halves[1 - first].search(lab, objects, o, d, best, asked);
            }
        }
    }
}
