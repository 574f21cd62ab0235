//! Quantiles of Student's t distribution.

use crate::math::{exp, pow};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The two-sided quantile: the t that is exceeded in magnitude with a probability of `doubt`, 0 to 1, for at least 3 degrees
/// of `freedom` (Hill, Student's t-Quantiles, CACM 13(10), 1970, Algorithm 396), to six digits.
pub(super) fn student_t(freedom: u32, doubt: f64) -> f64 {
    let n = f64::from(freedom);
    let a = 1.0 / (n - 0.5);
    let b = 48.0 / (a * a);
    let mut c = ((20_700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
    let d = ((94.5 / (b + c) - 3.0) / b + 1.0) * (a * PI / 2.0).sqrt() * n;
    let y = pow(d * doubt, 2.0 / n);
    let square = if y > 0.05 + a {
        let x = lower_normal(doubt / 2.0);
        let y = x * x;
        if freedom < 5 {
            c += 0.3 * (n - 4.5) * (x + 0.6);
        }
        c += (((0.05 * d * x - 5.0) * x - 7.0) * x - 2.0) * x + b;
        let y = (((((0.4 * y + 6.3) * y + 36.0) * y + 94.5) / c - y - 3.0) / b + 1.0) * x;
        exp(a * y * y) - 1.0
    } else {
        ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0) * (n + 1.0)
            / (n + 2.0)
            + 1.0 / y
    };
    (n * square).sqrt()
}

/// The x below which a standard normal variable falls with a probability of at most one half.
fn lower_normal(probability: f64) -> f64 {
    let (mut low, mut high) = (-40.0, 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if 0.5 * libm::erfc(-middle * FRAC_1_SQRT_2) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_published_tables() {
        // Two-sided; NIST/SEMATECH e-Handbook, 1.3.6.7.2, and the limit of the normal distribution.
        let table = [
            (3, 0.05, 3.182),
            (7, 0.05, 2.365),
            (7, 0.2, 1.415),
            (7, 0.002, 4.785),
            (15, 0.05, 2.131),
            (30, 0.01, 2.750),
            (100, 0.05, 1.984),
            (1_000, 0.002, 3.098),
            (1_000_000, 0.05, 1.960),
        ];
        for (freedom, doubt, t) in table {
            assert!((student_t(freedom, doubt) - t).abs() < 1e-3, "{freedom} {doubt} {}", student_t(freedom, doubt));
        }
    }
}
