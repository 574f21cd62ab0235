//! How textbooks start secondary rays: off a sphere, along the same directions as strahl's.

use crate::common::naive;
use crate::common::numbers::Numbers;
use glam::DVec3;

/// Names of the usual ways, the least t that counts, and the offset along the normal.
pub const NAIVE: [(&str, f64, f64); 3] = [("t > 0", 0.0, 0.0), ("t > 1e-4", 1e-4, 0.0), ("offset 1e-3", 0.0, 1e-3)];

/// What became of naive secondary rays.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct Naive {
    pub rays: usize,
    /// Rays away from the sphere that met it.
    pub self_hits: usize,
    /// Rays into it that did not leave it, or not within 2 % of where they do.
    pub lost: usize,
}

impl Naive {
    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.self_hits += other.self_hits;
        self.lost += other.lost;
    }
}

/// From where a naive ray along `d` from `o` meets the sphere, one ray along `out` and one the other way.
pub fn leave(lab: &Numbers, (c, r): (DVec3, f64), (o, d): (DVec3, DVec3), out: DVec3) -> [Naive; 3] {
    NAIVE.map(|(_, least, offset)| {
        let mut found = Naive::default();
        let Some(t) = naive::sphere(lab, o, d, c, r, 0.0) else { return found };
        let p = naive::point(lab, o, d, t);
        let n = naive::normalize(lab, p - c);
        if n.dot(out) <= 0.0 {
            return found;
        }
        found.rays = 1;
        let [above, below] = [n, -n].map(|n| naive::add(lab, p, lab.round3(n * offset)));
        found.self_hits = usize::from(naive::sphere(lab, above, out, c, r, least).is_some());
        let chord = 2.0 * r * n.dot(out) / out.length();
        let exit = naive::sphere(lab, below, -out, c, r, least);
        let right = exit.is_some_and(|t| (t * out.length() - chord).abs() <= 0.02 * chord + 64.0 * lab.u * r);
        found.lost = usize::from(!right);
        found
    })
}
