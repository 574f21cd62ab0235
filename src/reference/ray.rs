//! Rays, their crossings of surfaces, and bounding balls. Everything in f64, one ray at a time.

use glam::{DAffine3, DVec3};

/// A half-line; `t` counts in units of `dir`, which has any length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    pub(super) dir: DVec3,
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.dir * t
    }

    /// The same line in coordinates around `center`, its origin moved to the point closest to it; also by which t.
    ///
    /// Formulas then work with numbers of the object's size, however far away the ray starts.
    pub(super) fn around(&self, center: DVec3) -> (f64, Self) {
        let offset = self.origin - center;
        let t = -offset.dot(self.dir) / self.dir.length_squared();
        (t, Self { origin: offset + self.dir * t, dir: self.dir })
    }

    /// The ray in the coordinates `to_object` leads to; t stays the same.
    pub(super) fn transformed(&self, to_object: &DAffine3) -> Self {
        Self { origin: to_object.transform_point3(self.origin), dir: to_object.transform_vector3(self.dir) }
    }
}

/// Where a line passes a shape's surface, in the shape's own coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) t: f64,
    /// The point, moved onto the surface as well as f64 allows.
    pub(super) point: DVec3,
    /// Out of the shape; any length but 0.
    pub(super) normal: DVec3,
    /// Interpolated normal, where the shape has one.
    pub(super) shading: Option<DVec3>,
    /// Vector to the curved surface that interpolated normals suggest, on the side the ray comes from.
    pub(super) lift: DVec3,
}

impl Crossing {
    /// A crossing of a surface without shading normals.
    pub(super) fn flat(t: f64, point: DVec3, normal: DVec3) -> Self {
        Self { t, point, normal, shading: None, lift: DVec3::ZERO }
    }
}

/// A ball that surely contains something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

impl Ball {
    /// A ball around points.
    pub(super) fn around_points(points: &[DVec3]) -> Self {
        Self::around_balls(points.iter().map(|&center| Self { center, radius: 0.0 }))
    }

    /// A ball around balls: centred in their bounding box.
    pub(super) fn around_balls(balls: impl Iterator<Item = Self> + Clone) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for ball in balls.clone() {
            low = low.min(ball.center - ball.radius);
            high = high.max(ball.center + ball.radius);
        }
        let center = low.midpoint(high);
        let radius = balls.map(|ball| ball.center.distance(center) + ball.radius).fold(0.0, f64::max);
        Self { center, radius }
    }

    /// A ball around the transformed ball.
    ///
    /// The largest stretch of A is the root of the largest eigenvalue of A^T A, which no row's sum of magnitudes is
    /// below (Gershgorin 1931): exact for rotations with a scale, so nesting does not make the balls grow.
    pub(super) fn transformed(&self, to_world: &DAffine3) -> Self {
        let gram = to_world.matrix3.transpose() * to_world.matrix3;
        let row_sums = gram.x_axis.abs() + gram.y_axis.abs() + gram.z_axis.abs();
        Self { center: to_world.transform_point3(self.center), radius: self.radius * row_sums.max_element().sqrt() }
    }

    /// Whether the ray may meet the ball for a t in [near, far]; when in doubt, yes.
    pub(super) fn may_meet(&self, ray: &Ray, near: f64, far: f64) -> bool {
        let (middle, line) = ray.around(self.center);
        let radius = self.generous_radius(ray.origin);
        let half_chord_squared = radius * radius - line.origin.length_squared();
        if half_chord_squared < 0.0 {
            return false;
        }
        let half = half_chord_squared.sqrt() / ray.dir.length();
        middle - half <= far && middle + half >= near
    }

    /// Whether the ball may contain the point; when in doubt, yes.
    pub(super) fn may_contain(&self, point: DVec3) -> bool {
        point.distance(self.center) <= self.generous_radius(point)
    }

    /// The radius with room for every rounding error on the way here from `origin`.
    fn generous_radius(&self, origin: DVec3) -> f64 {
        self.radius + 1e-9 * (self.radius + origin.distance(self.center))
    }
}
