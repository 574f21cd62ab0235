//! Triangulates a planar polygon, convex or not, by cutting off ears (Meisters 1975; D. Eberly, "Triangulation by Ear
//! Clipping", 2002). Quadratic time in the worst case, linear for convex polygons.
//!
//! The polygon is projected along the largest component of its normal, which keeps the other coordinates exactly. An
//! orientation whose sign could be wrong by rounding counts as 0, so nearly collinear corners count as collinear.

use crate::control;
use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// Twice the area of the polygon along its normal (Newell's formula); its front sees the vertices counter-clockwise.
pub fn newell_normal(vertices: &[[f64; 3]]) -> DVec3 {
    let Some(&origin) = vertices.first() else { return DVec3::ZERO };
    // relative to a vertex: coordinates far from the origin must not cancel
    let spoke = |vertex: &[f64; 3]| DVec3::from_array(*vertex) - DVec3::from_array(origin);
    vertices.windows(2).map(|edge| spoke(&edge[0]).cross(spoke(&edge[1]))).sum()
}

/// Whether the polygon's area is 0, or so small for its extent that it may be rounding.
pub fn has_no_area(vertices: &[[f64; 3]]) -> bool {
    let Some(&origin) = vertices.first() else { return true };
    let origin = DVec3::from_array(origin);
    let extent = vertices.iter().map(|&vertex| DVec3::from_array(vertex).distance_squared(origin)).fold(0.0, f64::max);
    let normal = newell_normal(vertices).length();
    normal.is_nan() || normal <= 1e-12 * extent
}

/// Cuts a planar polygon into triangles with the same orientation, as indices of its vertices.
///
/// Corners may be collinear, and boundaries may touch at vertices (so that a hole can be joined to the outside by a
/// double edge). None if edges cross or the area is 0.
pub fn triangulate(vertices: &[[f64; 3]]) -> Option<Vec<[u32; 3]>> {
    if has_no_area(vertices) {
        return None;
    }
    if vertices.len() == 3 {
        return Some(vec![[0, 1, 2]]);
    }
    let points = project(vertices);
    if edges_cross(&points) {
        return None;
    }
    Ring::new(points).clip()
}

/// Projects the polygon along the axis in which it extends least, so that it runs counter-clockwise.
fn project(vertices: &[[f64; 3]]) -> Vec<DVec2> {
    let normal = newell_normal(vertices);
    let axis = normal.abs().max_position();
    let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (x, y) = (y, x);
    }
    vertices.iter().map(|vertex| DVec2::new(vertex[x], vertex[y])).collect()
}

/// Twice the signed area of the triangle a b c; 0 where rounding hides the sign (bound: Shewchuk 1997, `ccwerrboundA`).
fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let area = left - right;
    let bound = 3.330_669_073_875_471_6e-16 * (left.abs() + right.abs());
    if area.abs() > bound { area } else { 0.0 }
}

/// Whether two edges cross in points that are inside both. A sweep along x keeps the pairs few.
fn edges_cross(points: &[DVec2]) -> bool {
    let ends = |edge: usize| (points[edge], points[(edge + 1) % points.len()]);
    let span = |edge: usize| {
        let (a, b) = ends(edge);
        (a.min(b), a.max(b))
    };
    let cross = |one: usize, other: usize| {
        let ((a, b), (c, d)) = (ends(one), ends(other));
        orientation(a, b, c) * orientation(a, b, d) < 0.0 && orientation(c, d, a) * orientation(c, d, b) < 0.0
    };
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&one, &other| span(one).0.x.total_cmp(&span(other).0.x));
    let mut active: Vec<usize> = Vec::new();
    for edge in order {
        let (low, high) = span(edge);
        if control::step(1 + (active.len() / 64) as u32) {
            return false;
        }
        active.retain(|&other| span(other).1.x >= low.x);
        let meets = |other: usize| {
            let (other_low, other_high) = span(other);
            other_low.y <= high.y && other_high.y >= low.y
        };
        if active.iter().any(|&other| meets(other) && cross(edge, other)) {
            return true;
        }
        active.push(edge);
    }
    false
}

/// The rest of the polygon: a ring of vertices.
struct Ring {
    points: Vec<DVec2>,
    previous: Vec<usize>,
    next: Vec<usize>,
    /// Some vertex of the ring.
    any: usize,
    /// How many vertices it has.
    len: usize,
    /// The vertices at which it does not turn left: only they can lie in an ear.
    blunt: Vec<usize>,
}

impl Ring {
    fn new(points: Vec<DVec2>) -> Self {
        let len = points.len();
        let previous = (0..len).map(|i| (i + len - 1) % len).collect();
        let next = (0..len).map(|i| (i + 1) % len).collect();
        let mut ring = Self { points, previous, next, any: 0, len, blunt: Vec::new() };
        ring.drop_spikes();
        ring.blunt = ring.vertices().filter(|&vertex| ring.turn(vertex) <= 0.0).collect();
        ring
    }

    /// Removes vertices that repeat a neighbour, or where the boundary turns back on itself: ears at their neighbours would
    /// lie outside.
    fn drop_spikes(&mut self) {
        let mut waiting: Vec<usize> = self.vertices().collect();
        while let Some(vertex) = waiting.pop() {
            let (a, c) = (self.previous[vertex], self.next[vertex]);
            let is_left = self.next[a] == vertex && self.len > 3;
            if is_left && self.turn(vertex) == 0.0 {
                let [before, tip, after] = [a, vertex, c].map(|i| self.points[i]);
                if (before - tip).dot(after - tip) >= 0.0 {
                    self.remove(vertex);
                    waiting.extend([a, c]);
                }
            }
        }
    }

    fn clip(mut self) -> Option<Vec<[u32; 3]>> {
        let mut triangles = Vec::with_capacity(self.len.saturating_sub(2));
        let mut waiting: VecDeque<usize> = self.vertices().collect();
        let mut is_waiting = vec![true; self.points.len()];
        let mut clipped_since_refill = false;
        while self.len > 3 {
            if control::step(1 + (self.blunt.len() / 64) as u32) {
                // Nobody will look at it.
                return Some(vec![[0, 1, 2]]);
            }
            let Some(tip) = waiting.pop_front() else {
                // Cutting an ear makes ears only of its neighbours, unless vertices touch. So this is rare.
                if !clipped_since_refill {
                    let flat = self.vertices().find(|&vertex| self.turn(vertex) == 0.0)?;
                    self.remove(flat);
                }
                clipped_since_refill = false;
                waiting.extend(self.vertices());
                waiting.iter().for_each(|&vertex| is_waiting[vertex] = true);
                continue;
            };
            is_waiting[tip] = false;
            if self.is_ear(tip) {
                let (a, c) = (self.previous[tip], self.next[tip]);
                triangles.push([a as u32, tip as u32, c as u32]);
                self.remove(tip);
                clipped_since_refill = true;
                for neighbour in [a, c] {
                    if !is_waiting[neighbour] {
                        is_waiting[neighbour] = true;
                        waiting.push_back(neighbour);
                    }
                }
            }
        }
        let last = self.any;
        let turn = self.turn(last);
        if turn > 0.0 {
            triangles.push([self.previous[last] as u32, last as u32, self.next[last] as u32]);
        }
        (turn >= 0.0 && !triangles.is_empty()).then_some(triangles)
    }

    fn vertices(&self) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(self.any), |&vertex| Some(self.next[vertex])).take(self.len)
    }

    /// Above 0 where the ring turns left, which is a convex corner.
    fn turn(&self, vertex: usize) -> f64 {
        orientation(self.points[self.previous[vertex]], self.points[vertex], self.points[self.next[vertex]])
    }

    fn is_ear(&self, tip: usize) -> bool {
        if self.turn(tip) <= 0.0 {
            return false;
        }
        let [a, b, c] = [self.previous[tip], tip, self.next[tip]].map(|vertex| self.points[vertex]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        !self.blunt.iter().any(|&vertex| {
            let p = self.points[vertex];
            // a vertex on a corner is the corner itself or touches it, and does not cut into the ear
            p.cmpge(low).all()
                && p.cmple(high).all()
                && ![a, b, c].contains(&p)
                && orientation(c, a, p) >= 0.0
                && orientation(a, b, p) >= 0.0
                && orientation(b, c, p) >= 0.0
        })
    }

    fn remove(&mut self, vertex: usize) {
        let (a, c) = (self.previous[vertex], self.next[vertex]);
        self.next[a] = c;
        self.previous[c] = a;
        self.any = a;
        self.len -= 1;
        self.blunt.retain(|&other| other != vertex && other != a && other != c);
        for neighbour in [a, c] {
            if self.turn(neighbour) <= 0.0 {
                self.blunt.push(neighbour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    fn lift(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
        points.iter().map(|&[x, y]| [x, y, 0.25 * x - 0.5 * y]).collect()
    }

    fn polar(radius: f64, angle: f64) -> [f64; 2] {
        let (sin, cos) = math::sin_cos(angle);
        [radius * cos, radius * sin]
    }

    /// All triangles turn as the polygon does, their areas sum to its area, and each point inside lies in one of them.
    fn check(vertices: &[[f64; 3]]) {
        let triangles = triangulate(vertices).expect("it is simple");
        let normal = newell_normal(vertices);
        let mut area = 0.0;
        for triangle in &triangles {
            let part = newell_normal(&triangle.map(|i| vertices[i as usize])).dot(normal.normalize());
            assert!(part > 0.0, "{triangle:?} is turned");
            area += part;
        }
        assert!((area - normal.length()).abs() <= 1e-9 * area, "{area} of {}", normal.length());
        let points = project(vertices);
        let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.min(*p), h.max(*p)));
        for i in 0..20 {
            for j in 0..20 {
                let at = DVec2::new((f64::from(i) + 0.513) / 20.0, (f64::from(j) + 0.487) / 20.0);
                let p = low + at * (high - low);
                let around = |corners: &[DVec2]| {
                    let crossings = (0..corners.len()).filter(|&k| {
                        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                        // upwards, so that both triangles at an edge round alike
                        let (a, b) = if a.y < b.y { (a, b) } else { (b, a) };
                        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
                    });
                    crossings.count() % 2
                };
                let covers = triangles.iter().map(|t| around(&t.map(|k| points[k as usize]))).sum::<usize>();
                assert_eq!(covers, around(&points), "{p}");
            }
        }
    }

    /// In all six directions of projection.
    fn check_everywhere(points: &[[f64; 2]]) {
        let lifted = lift(points);
        for [x, y, z] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]] {
            let turned: Vec<_> = lifted.iter().map(|v| [v[x], v[y], v[z]]).collect();
            check(&turned);
        }
    }

    #[test]
    fn convex_and_simple_concave() {
        check_everywhere(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        check_everywhere(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        check_everywhere(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 1.0]]);
        check_everywhere(&(0..100).map(|i| polar(3.0, f64::from(i) / 100.0 * TAU)).collect::<Vec<_>>());
    }

    #[test]
    fn all_vertices_stay_in_use_where_they_are_collinear() {
        let outline: Vec<[f64; 2]> = (0..5)
            .map(|i| [f64::from(i), 0.0])
            .chain((0..5).map(|i| [5.0, f64::from(i)]))
            .chain((0..5).map(|i| [5.0 - f64::from(i), 5.0]))
            .chain((0..5).map(|i| [0.0, 5.0 - f64::from(i)]))
            .collect();
        check_everywhere(&outline);
        assert_eq!(triangulate(&lift(&outline)).unwrap().len(), 18);
    }

    #[test]
    fn gears() {
        // 36 teeth of 4 vertices, as in the SPD gears
        let gear = (0..144).map(|i| polar([1.0, 1.0, 0.9, 0.9][i % 4], i as f64 / 144.0 * TAU));
        check_everywhere(&gear.collect::<Vec<_>>());
    }

    #[test]
    fn combs_and_spirals() {
        let teeth = 300;
        let comb = (0..2 * teeth + 1).map(|i| [f64::from(i), if i % 2 == 0 { 100.0 } else { 1.0 }]);
        let comb = comb.chain([[f64::from(2 * teeth), 0.0], [0.0, 0.0]]).collect::<Vec<_>>();
        check_everywhere(&comb);
        let arm = |width: f64| (0..400).map(move |i| polar(f64::from(i) * 0.1 + width, f64::from(i) * 0.1));
        let inward = arm(0.3).collect::<Vec<_>>().into_iter().rev();
        check_everywhere(&arm(0.0).chain(inward).collect::<Vec<_>>());
    }

    #[test]
    fn a_hole_may_be_joined_by_a_double_edge() {
        let outside = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]];
        let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0]];
        check_everywhere(&[outside, hole].concat());
    }

    #[test]
    fn doubled_vertices_and_spikes_vanish() {
        check_everywhere(&[[0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]);
        check_everywhere(&[[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        check_everywhere(&[[3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]]);
        check_everywhere(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]]);
    }

    #[test]
    fn refuses_what_has_no_inside() {
        let none = |points: &[[f64; 2]]| assert_eq!(triangulate(&lift(points)), None, "{points:?}");
        none(&[]);
        none(&[[0.0, 0.0], [1.0, 0.0]]);
        none(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]);
        none(&[[0.0, 0.0], [1.0, 0.1], [2.0, 0.2], [3.0, 0.3]]);
        none(&[[0.0, 0.0], [f64::NAN, 0.0], [1.0, 1.0]]);
        // bow ties, with and without area, and a pentagram
        none(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        none(&[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 1.0]]);
        none(&(0..5).map(|i| polar(1.0, f64::from(i) * 0.8 * PI)).collect::<Vec<_>>());
    }

    #[test]
    fn the_largest_polygon_is_quick() {
        let comb = (0..9997).map(|i| [f64::from(i), if i % 2 == 0 { 100.0 } else { 1.0 }]);
        let comb = comb.chain([[9996.0, 0.0], [0.0, 0.0]]).collect::<Vec<_>>();
        let start = std::time::Instant::now();
        assert_eq!(triangulate(&lift(&comb)).unwrap().len(), 9997);
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }

    proptest! {
        // Rounded as in a file, which makes collinear corners likely, but not so much that edges could cross.
        #[test]
        fn random_stars_with_and_without_a_hole(radii in prop::collection::vec(0.05_f64..1.0, 3..80), decimals in 2..7) {
            let scale = math::pow(10.0, f64::from(decimals));
            let count = radii.len() as f64;
            let star = |size: f64| -> Vec<[f64; 3]> {
                let corners = radii.iter().enumerate().map(|(i, r)| polar(size * r, i as f64 / count * TAU));
                corners.map(|p| p.map(|x| (x * scale).round() / scale)).map(|[x, y]| [x, y, 0.0]).collect()
            };
            let outside = star(10.0);
            check(&outside);
            let hole = star(5.0);
            let inward = hole.iter().chain([&hole[0]]).rev();
            let bridged: Vec<_> = outside.iter().chain([&outside[0]]).chain(inward).copied().collect();
            check(&bridged);
        }
    }
}
