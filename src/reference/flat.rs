//! Shapes with flat sides: plane, disc, polygon and box.

use super::ray::{Ball, Crossing, Ray};
use super::shape::Shape;
use glam::{DVec2, DVec3};

/// A plane through a point. As a body, the half-space behind it.
#[derive(Debug)]
pub(super) struct Plane {
    pub(super) point: DVec3,
    /// Unit.
    pub(super) normal: DVec3,
}

impl Plane {
    fn height(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }
}

impl Shape for Plane {
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let slope = ray.dir.dot(self.normal);
        if slope == 0.0 {
            return Vec::new();
        }
        let t = (self.point - ray.origin).dot(self.normal) / slope;
        let near_plane = ray.at(t);
        let point = near_plane - self.normal * self.height(near_plane);
        vec![Crossing::flat(t, point, self.normal)]
    }

    fn contains(&self, point: DVec3) -> bool {
        self.height(point) < 0.0
    }

    fn ball(&self) -> Option<Ball> {
        None
    }

    fn volume(&self) -> Option<f64> {
        Some(f64::INFINITY)
    }
}

/// The part of a plane within a radius of its point.
#[derive(Debug)]
pub(super) struct Disc {
    pub(super) plane: Plane,
    pub(super) radius: f64,
}

impl Shape for Disc {
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut found = self.plane.crossings(ray);
        found.retain(|crossing| crossing.point.distance(self.plane.point) <= self.radius);
        found
    }

    fn ball(&self) -> Option<Ball> {
        Some(Ball { center: self.plane.point, radius: self.radius })
    }
}

/// The part of a plane inside a closed chain of edges.
#[derive(Debug)]
pub(super) struct Polygon {
    plane: Plane,
    vertices: Vec<DVec3>,
}

impl Polygon {
    pub(super) fn new(vertices: Vec<DVec3>) -> Self {
        let first = vertices[0];
        // Newell's normal: the sum over the edges is twice the area vector, for concave outlines too.
        let area: DVec3 = edges(&vertices).map(|(a, b)| (a - first).cross(b - first)).sum();
        let mean = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        Self { plane: Plane { point: mean, normal: area.normalize() }, vertices }
    }

    /// Even-odd rule, on the coordinate plane the polygon faces most.
    fn is_inside(&self, point: DVec3) -> bool {
        let n = self.plane.normal.abs();
        let project = |v: DVec3| match n.max_element() {
            largest if largest == n.x => DVec2::new(v.y, v.z),
            largest if largest == n.y => DVec2::new(v.z, v.x),
            _ => DVec2::new(v.x, v.y),
        };
        let p = project(point);
        let mut inside = false;
        for (a, b) in edges(&self.vertices) {
            // Upwards, so that two polygons that share an edge compute the same crossing.
            let (a, b) = (project(a), project(b));
            let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
            if low.y <= p.y && p.y < high.y && p.x < low.x + (high.x - low.x) * ((p.y - low.y) / (high.y - low.y)) {
                inside = !inside;
            }
        }
        inside
    }
}

impl Shape for Polygon {
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut found = self.plane.crossings(ray);
        found.retain(|crossing| self.is_inside(crossing.point));
        found
    }

    fn ball(&self) -> Option<Ball> {
        Some(Ball::around_points(&self.vertices))
    }
}

fn edges(vertices: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    vertices.iter().copied().zip(vertices.iter().copied().cycle().skip(1))
}

/// A box with sides parallel to the axes.
#[derive(Debug)]
pub(super) struct AxisBox {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl AxisBox {
    /// Whether it encloses nothing, having no thickness along some axis.
    fn is_flat(&self) -> bool {
        self.min.cmpeq(self.max).any()
    }
}

impl Shape for AxisBox {
    /// Kay and Kajiya's slabs (1986); a flat box has one surface, not two that coincide.
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.dir[axis]);
            let (min, max) = (self.min[axis], self.max[axis]);
            if d == 0.0 {
                if o < min || o > max {
                    return Vec::new();
                }
                continue;
            }
            let (first, second) = if d > 0.0 { (min, max) } else { (max, min) };
            if (first - o) / d > enter.0 {
                enter = ((first - o) / d, axis);
            }
            if (second - o) / d < leave.0 {
                leave = ((second - o) / d, axis);
            }
        }
        if enter.0 > leave.0 {
            return Vec::new();
        }
        let side = |(t, axis): (f64, usize), outward: f64| {
            let mut normal = DVec3::ZERO;
            normal[axis] = outward;
            let mut point = ray.at(t);
            point[axis] = if outward > 0.0 { self.max[axis] } else { self.min[axis] };
            Crossing::flat(t, point, normal)
        };
        let mut found = vec![side(enter, -ray.dir[enter.1].signum())];
        if !self.is_flat() {
            found.push(side(leave, ray.dir[leave.1].signum()));
        }
        found
    }

    fn contains(&self, point: DVec3) -> bool {
        point.cmpgt(self.min).all() && point.cmplt(self.max).all()
    }

    fn ball(&self) -> Option<Ball> {
        Some(Ball { center: self.min.midpoint(self.max), radius: self.min.distance(self.max) / 2.0 })
    }

    fn volume(&self) -> Option<f64> {
        (!self.is_flat()).then_some((self.max - self.min).element_product())
    }
}
