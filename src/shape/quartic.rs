//! Real roots of low-degree polynomials on an interval, isolated by the roots of their derivatives.

/// Upper bound on steps of one root's refinement; bisection alone needs 60.
const MAX_STEPS: usize = 80;

/// At most four values in increasing order.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Roots {
    values: [f64; 4],
    len: usize,
}

impl Roots {
    pub(super) fn as_slice(&self) -> &[f64] {
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
pub(super) fn sign_changes(
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
pub(super) fn turns(c: [f64; 5], low: f64, high: f64) -> Roots {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(c: [f64; 5], low: f64, high: f64) -> Vec<f64> {
        let f = |x: f64| c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])));
        let slope = |x: f64| c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4]));
        sign_changes(f, slope, turns(c, low, high).as_slice(), low, high, 0.0).as_slice().to_vec()
    }

    #[test]
    fn finds_the_roots_of_products() {
        // (x-1)(x-2)(x-3)(x-4)
        let roots = solve([24.0, -50.0, 35.0, -10.0, 1.0], 0.0, 10.0);
        assert_eq!(roots.len(), 4);
        for (root, exact) in roots.iter().zip([1.0, 2.0, 3.0, 4.0]) {
            assert!((root - exact).abs() < 1e-12, "{root}");
        }
        assert_eq!(solve([24.0, -50.0, 35.0, -10.0, 1.0], 1.5, 3.5).len(), 2);
    }

    #[test]
    fn touching_is_no_root_and_neither_is_no_contact() {
        assert!(solve([1.0, 0.0, 2.0, 0.0, 1.0], -5.0, 5.0).is_empty());
        assert_eq!(solve([-1.0, 0.0, 0.0, 0.0, 1.0], -5.0, 5.0).len(), 2);
    }
}
