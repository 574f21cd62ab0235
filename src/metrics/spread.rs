//! Mean, quantiles and maximum of the errors of a picture's pixels.

use schemars::JsonSchema;
use serde::Serialize;

/// How errors are spread over a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "ErrorSpread")]
pub struct Spread {
    /// Their mean.
    pub mean: f64,
    /// 95 % are not larger.
    pub p95: f64,
    /// 99 % are not larger.
    pub p99: f64,
    /// 99.9 % are not larger.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of some numbers; all 0 if there are none.
    pub fn of(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let count = errors.len();
        // The smallest error that is not below the part p of all.
        let quantile = |p: f64| match (p * count as f64).ceil() as usize {
            0 => errors.first().copied().unwrap_or(0.0),
            rank => errors[rank.min(count) - 1],
        };
        let mean = if count == 0 { 0.0 } else { errors.iter().sum::<f64>() / count as f64 };
        Self {
            mean,
            p95: quantile(0.95),
            p99: quantile(0.99),
            p999: quantile(0.999),
            max: errors.last().copied().unwrap_or(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_numbers_that_occurred() {
        let spread = Spread::of((1..=1000).rev().map(f64::from).collect());
        assert_eq!(
            (spread.mean, spread.p95, spread.p99, spread.p999, spread.max),
            (500.5, 950.0, 990.0, 999.0, 1000.0)
        );
        assert_eq!(Spread::of(vec![]).max, 0.0);
        assert_eq!(Spread::of(vec![3.0]).p95, 3.0);
    }
}
