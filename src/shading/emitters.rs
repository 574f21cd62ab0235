//! Bodies that glow, as lights: a triangle, an ellipse or a ball of them, chosen in proportion to its power, and then a point of its surface
//! (Shirley, Wang and Zimmerman, Monte Carlo Techniques for Direct Lighting Calculations, 1996). Of a ball a direction in the cone is
//! chosen in which it is seen: all of them bring the same light.

use glam::DVec3;
use std::f64::consts::PI;

/// Surfaces that glow.
#[derive(Debug, Default)]
pub struct Emitters {
    lamps: Vec<Lamp>,
    /// Power of those before each, and of all, without the factor pi.
    before: Vec<f64>,
    /// By material, the density by area with which a point of a triangle of it is chosen; 0 of those that are not.
    densities: Vec<f64>,
    most: [f64; 3],
}

/// A surface that glows, of which any point emits the same.
#[derive(Debug, Clone, Copy)]
pub struct Lamp {
    /// Its form.
    pub form: Form,
    /// Index of its material.
    pub material: usize,
    /// What it emits.
    pub radiance: [f64; 3],
}

/// Forms of lamps, in the coordinates of the scene.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Form {
    Triangle([DVec3; 3]),
    /// Both axes go from the centre to the border.
    Ellipse {
        center: DVec3,
        axes: [DVec3; 2],
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
}

/// A point of a lamp that was chosen for a place.
#[derive(Debug, Clone, Copy)]
pub struct ChosenPoint {
    /// From the place to the point, unit.
    pub dir: DVec3,
    /// How far it is.
    pub distance: f64,
    /// How likely its direction was, by solid angle; 0 where the lamp is seen from its edge.
    pub density: f64,
    /// What it emits.
    pub radiance: [f64; 3],
}

impl Form {
    fn area(&self) -> f64 {
        match self {
            Self::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
            Self::Ellipse { axes: [u, v], .. } => PI * u.cross(*v).length(),
            Self::Sphere { radius, .. } => 4.0 * PI * radius * radius,
        }
    }
}

fn brightness(radiance: [f64; 3]) -> f64 {
    radiance.iter().sum()
}

impl Emitters {
    /// Those of a scene with so many materials; none if nothing glows.
    pub fn new(lamps: Vec<Lamp>, materials: usize) -> Option<Self> {
        let mut before = vec![0.0];
        let mut all = 0.0;
        let mut most = [0.0_f64; 3];
        for lamp in &lamps {
            all += lamp.form.area() * brightness(lamp.radiance);
            before.push(all);
            most = std::array::from_fn(|c| most[c].max(lamp.radiance[c]));
        }
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let mut densities = vec![0.0; materials];
        lamps.iter().for_each(|lamp| densities[lamp.material] = brightness(lamp.radiance) / all);
        Some(Self { lamps, before, densities, most })
    }

    /// The brightest of them.
    pub fn most(&self) -> [f64; 3] {
        self.most
    }

    /// Bytes of memory they take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.lamps[..]) + size_of_val(&self.before[..]) + size_of_val(&self.densities[..])
    }

    /// The density by area with which a point of a material is chosen, but of a ball that is seen from outside; 0 of a material that
    /// is none of the scene's own, as layers have for bodies.
    pub fn density(&self, material: usize) -> f64 {
        self.densities.get(material).copied().unwrap_or(0.0)
    }

    /// The density by solid angle with which a direction to a ball of a material is chosen, from outside of it.
    pub fn density_of_ball(&self, material: usize, center: DVec3, radius: f64, place: DVec3) -> Option<f64> {
        let power = self.density(material) * 4.0 * PI * radius * radius;
        Some(power / (2.0 * PI * versine_of_cone(place - center, radius)?))
    }

    /// The point for a place and a point of the unit square.
    pub fn choose(&self, place: DVec3, [a, b]: [f64; 2]) -> ChosenPoint {
        let power = a * self.before[self.lamps.len()];
        let index = self.before.partition_point(|sum| *sum <= power).clamp(1, self.lamps.len()) - 1;
        let lamp = &self.lamps[index];
        let (start, end) = (self.before[index], self.before[index + 1]);
        // What is left of the number is as good as another one.
        let a = ((power - start) / (end - start)).clamp(0.0, 1.0);
        if let Form::Sphere { center, radius } = lamp.form
            && let Some(density) = self.density_of_ball(lamp.material, center, radius, place)
        {
            let (dir, distance) = towards_ball(center - place, radius, [a, b]);
            return ChosenPoint { dir, distance, density, radiance: lamp.radiance };
        }
        let (point, normal) = lamp.form.point([a, b]);
        let way = point - place;
        let squared = way.length_squared();
        let distance = squared.sqrt();
        let dir = way / distance;
        let facing = dir.dot(normal).abs();
        let seen = facing > 0.0 && squared > 0.0;
        let density = if seen { self.density(lamp.material) * squared / facing } else { 0.0 };
        ChosenPoint { dir, distance, density, radiance: lamp.radiance }
    }
}

/// Places that are nearer to a ball, as a share of its radius, are not outside of it: the roundings of a place on its inside would
/// decide, and both ways to find the ball must agree.
const BESIDE: f64 = 1e-4;

/// 1 - cos of half of the angle of the cone in which a ball is seen from outside of it, in a form that does not cancel.
fn versine_of_cone(out: DVec3, radius: f64) -> Option<f64> {
    let squared = radius * radius / out.length_squared();
    (squared < 1.0 - 2.0 * BESIDE).then(|| squared / (1.0 + (1.0 - squared).sqrt()))
}

/// A direction to a ball that is seen from outside of it, and how far its surface is.
fn towards_ball(way: DVec3, radius: f64, [a, b]: [f64; 2]) -> (DVec3, f64) {
    let versine = a * versine_of_cone(way, radius).unwrap_or(0.0);
    let (far, axis) = (way.length(), way.normalize());
    let (right, up) = axis.any_orthonormal_pair();
    let (sin, cos) = crate::math::sin_cos(2.0 * PI * b);
    let across = (versine * (2.0 - versine)).sqrt();
    let dir = axis * (1.0 - versine) + right * (across * cos) + up * (across * sin);
    let beside = far * across;
    (dir, far * (1.0 - versine) - (radius * radius - beside * beside).max(0.0).sqrt())
}

impl Form {
    /// The point for a point of the unit square, and its unit normal.
    fn point(&self, [a, b]: [f64; 2]) -> (DVec3, DVec3) {
        match *self {
            Self::Triangle([p, q, r]) => {
                let (root, normal) = (a.sqrt(), (q - p).cross(r - p).normalize_or(DVec3::Y));
                (p + (q - p) * (root * (1.0 - b)) + (r - p) * (root * b), normal)
            }
            Self::Ellipse { center, axes: [u, v] } => {
                let (sin, cos) = crate::math::sin_cos(2.0 * PI * b);
                let far = a.sqrt();
                (center + (u * cos + v * sin) * far, u.cross(v).normalize_or(DVec3::Y))
            }
            Self::Sphere { center, radius } => {
                let height = 2.0 * a - 1.0;
                let (sin, cos) = crate::math::sin_cos(2.0 * PI * b);
                let flat = (1.0 - height * height).max(0.0).sqrt();
                let normal = DVec3::new(flat * cos, height, flat * sin);
                (center + normal * radius, normal)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamps() -> Emitters {
        let triangle =
            Form::Triangle([DVec3::new(-1.0, 3.0, 0.0), DVec3::new(1.0, 3.0, 0.0), DVec3::new(0.0, 3.0, 2.0)]);
        let ball = Form::Sphere { center: DVec3::new(2.0, 2.0, 0.0), radius: 0.5 };
        let lamp = |form, material, radiance| Lamp { form, material, radiance };
        let lamps = vec![lamp(triangle, 1, [4.0, 2.0, 1.0]), lamp(ball, 0, [0.5, 1.0, 3.0])];
        Emitters::new(lamps, 3).unwrap()
    }

    /// The irradiance of a ball wholly above the horizon is pi L (R/d)^2 cos, that of a triangle Lambert's sum over its edges.
    #[test]
    fn irradiance_is_that_of_closed_forms() {
        let (lamps, n) = (lamps(), 300);
        for (place, up) in [(DVec3::ZERO, DVec3::Y), (DVec3::new(0.4, -1.0, 0.3), DVec3::new(0.6, 0.8, 0.0))] {
            let mut sum = [0.0; 3];
            for i in 0..n * n {
                let share = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
                let chosen = lamps.choose(place, [share(i % n), share(i / n)]);
                if chosen.density > 0.0 {
                    let weight = chosen.dir.dot(up).max(0.0) / chosen.density / f64::from(n * n);
                    sum = std::array::from_fn(|c| sum[c] + chosen.radiance[c] * weight);
                }
            }
            let out = DVec3::new(2.0, 2.0, 0.0) - place;
            let ball = PI * 0.25 / out.length_squared() * out.normalize().dot(up);
            let corners = [DVec3::new(-1.0, 3.0, 0.0), DVec3::new(1.0, 3.0, 0.0), DVec3::new(0.0, 3.0, 2.0)];
            let ways = corners.map(|corner| (corner - place).normalize());
            let edge = |i: usize| {
                let (a, b) = (ways[i], ways[(i + 1) % 3]);
                crate::math::acos(a.dot(b)) * a.cross(b).normalize().dot(up)
            };
            let triangle = (0.5 * (edge(0) + edge(1) + edge(2))).abs();
            for c in 0..3 {
                let expected = [4.0, 2.0, 1.0][c] * triangle + [0.5, 1.0, 3.0][c] * ball;
                assert!((sum[c] / expected - 1.0).abs() < 2e-3, "{place} {c}: {} for {expected}", sum[c]);
            }
        }
    }

    /// The irradiance below the middle of a disc is pi L R^2 / (R^2 + d^2), and far below an ellipse L A / d^2.
    #[test]
    fn discs_are_lamps() {
        let irradiance = |axes: [DVec3; 2], down: f64| {
            let form = Form::Ellipse { center: DVec3::new(1.0, 2.0, 3.0), axes };
            let lamps = Emitters::new(vec![Lamp { form, material: 0, radiance: [2.0, 0.0, 0.0] }], 1).unwrap();
            let (place, n) = (DVec3::new(1.0, 2.0 - down, 3.0), 400);
            let share = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
            let all = (0..n * n).map(|i| lamps.choose(place, [share(i % n), share(i / n)]));
            all.map(|chosen| chosen.dir.y / chosen.density / f64::from(n * n) * chosen.radiance[0]).sum::<f64>()
        };
        let disc = irradiance([DVec3::X, DVec3::Z], 0.5);
        assert!((disc / (2.0 * PI / 1.25) - 1.0).abs() < 1e-4, "{disc}");
        let ellipse = irradiance([DVec3::X * 0.3, DVec3::Z * 0.1], 50.0);
        assert!((ellipse / (2.0 * PI * 0.03 / 2_500.0) - 1.0).abs() < 1e-4, "{ellipse}");
    }

    #[test]
    fn what_does_not_glow_is_no_lamp() {
        assert!(Emitters::new(Vec::new(), 2).is_none());
        assert_eq!(lamps().density(2), 0.0);
    }
}
