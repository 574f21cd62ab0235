//! The slow twin of the torus: the same roots, one ray at a time.

use super::{Sides, Torus};
use crate::lanes::Real;
use crate::math;

impl<R: Real> Torus<R> {
    pub(super) fn slow_root(&self, o: [f64; 3], d: [f64; 3], (t_min, t_max): (f64, f64), sides: Sides) -> Option<R> {
        let major = self.major_radius.to_f64();
        let r = self.minor_radius.to_f64() / major;
        let (o, d) = (glam::DVec3::from_array(o) / major, glam::DVec3::from_array(d));
        // x is the length along the unit direction, in major radii; t = x / speed.
        let speed = d.length() / major;
        let dir = d / d.length();

        let middle = -o.dot(dir);
        let closest = o + dir * middle;
        let half_chord = (1.0 + r) * (1.0 + r) * (1.0 + 1e-9) - closest.length_squared();
        if half_chord.is_nan() || half_chord < 0.0 {
            return None;
        }
        let half_chord = half_chord.sqrt();
        let (low, high) = ((t_min * speed - middle).max(-half_chord), half_chord);
        if low >= high {
            return None;
        }

        let g = |x: f64| {
            let p = closest + dir * x;
            let rho = math::hypot(p.x, p.y);
            (rho - 1.0 - r) * (rho - 1.0 + r) + p.z * p.z
        };
        let slope = |x: f64| {
            let p = closest + dir * x;
            let rho = math::hypot(p.x, p.y);
            2.0 * ((rho - 1.0) * (p.x * dir.x + p.y * dir.y) / rho + p.z * dir.z)
        };
        // (p.p + 1 - r^2)^2 - 4 (x^2 + y^2) along p = closest + x dir, where closest.dir = 0.
        let k = closest.length_squared() + 1.0 - r * r;
        let across = closest.x * closest.x + closest.y * closest.y;
        let along = closest.x * dir.x + closest.y * dir.y;
        let lean = dir.x * dir.x + dir.y * dir.y;
        let quartic = [k * k - 4.0 * across, -8.0 * along, 2.0 * k - 4.0 * lean, 0.0, 1.0];
        let bends = turns(quartic, low, high);

        // A ray that starts within a few roundings of the tube does not meet it there. Rays that leave it start further
        // off, so this does not affect them.
        let noise = 8.0 * f64::EPSILON * r;
        let roots = sign_changes(g, slope, bends.as_slice(), low, high, noise);
        roots.as_slice().iter().find_map(|&x| {
            let t = R::from_f64((x + middle) / speed);
            let seen = match sides {
                Sides::Both => true,
                Sides::Outside => slope(x) <= 0.0,
                Sides::Inside => slope(x) >= 0.0,
            };
            (seen && t.to_f64() > t_min && t.to_f64() < t_max).then_some(t)
        })
    }
}

/// Upper bound on steps of one root's refinement; bisection alone needs 60.
const MAX_STEPS: usize = 80;

/// At most four values in increasing order.
#[derive(Debug, Clone, Copy, Default)]
struct Roots {
    values: [f64; 4],
    len: usize,
}

impl Roots {
    fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }

    fn push(&mut self, x: f64) {
        if self.len < 4 {
            self.values[self.len] = x;
            self.len += 1;
        }
    }
}

/// Where `f` changes its sign on [low, high]. It is monotone between the `turns`, which are in increasing order. Touching
/// zero without crossing it is not a root, and a zero at `low` is not one either: values of at most `noise` there count
/// as zero, and the slope decides the sign.
fn sign_changes(
    f: impl Fn(f64) -> f64,
    slope: impl Fn(f64) -> f64,
    turns: &[f64],
    low: f64,
    high: f64,
    noise: f64,
) -> Roots {
    let mut roots = Roots::default();
    let mut a = low;
    let mut fa = f(a);
    if fa.abs() <= noise {
        fa = slope(a);
    }
    for b in turns.iter().copied().filter(|t| *t > low && *t < high).chain([high]) {
        let fb = f(b);
        if (fa < 0.0) != (fb < 0.0) {
            roots.push(refine(&f, &slope, a, b, fa < 0.0));
        }
        (a, fa) = (b, fb);
    }
    roots
}

/// Newton's method, held inside the shrinking bracket [a, b] by bisection.
fn refine(f: &impl Fn(f64) -> f64, slope: &impl Fn(f64) -> f64, mut a: f64, mut b: f64, rising: bool) -> f64 {
    let mut x = 0.5 * (a + b);
    for _ in 0..MAX_STEPS {
        let y = f(x);
        if y == 0.0 {
            return x;
        }
        if (y < 0.0) == rising {
            a = x;
        } else {
            b = x;
        }
        let newton = x - y / slope(x);
        let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
        if next == x || next <= a || next >= b {
            return next;
        }
        if (next - x).abs() <= f64::EPSILON * next.abs() {
            return next;
        }
        x = next;
    }
    x
}

/// Places where the quartic c\[4\] x^4 + ... + c\[0\] has slope 0 on [low, high], in increasing order.
fn turns(c: [f64; 5], low: f64, high: f64) -> Roots {
    let d1 = [c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4]];
    let d2 = [d1[1], 2.0 * d1[2], 3.0 * d1[3]];
    let bends = quadratic_roots(d2);
    let cubic = |x: f64| d1[0] + x * (d1[1] + x * (d1[2] + x * d1[3]));
    let square = |x: f64| d2[0] + x * (d2[1] + x * d2[2]);
    sign_changes(cubic, square, bends.as_slice(), low, high, 0.0)
}

fn quadratic_roots(c: [f64; 3]) -> Roots {
    let mut roots = Roots::default();
    let half = -0.5 * c[1];
    let discriminant = half * half - c[2] * c[0];
    if discriminant >= 0.0 {
        let q = half + discriminant.sqrt().copysign(half);
        let (mut u, mut v) = (q / c[2], c[0] / q);
        if u > v {
            (u, v) = (v, u);
        }
        for root in [u, v] {
            if root.is_finite() {
                roots.push(root);
            }
        }
    }
    roots
}
