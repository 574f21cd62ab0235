//! How fast a camera goes from one key to the next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The speed between two keys. All are polynomials, which give the same bits on every machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ease {
    /// Steady.
    #[default]
    Linear,
    /// From rest.
    In,
    /// To rest.
    Out,
    /// From rest to rest.
    InOut,
}

impl Ease {
    /// How much of the way is done after a share of the time. 0 and 1 are exact.
    pub fn way(self, time: f64) -> f64 {
        match self {
            Self::Linear => time,
            Self::In => time * time,
            Self::Out => time * (2.0 - time),
            Self::InOut => time * time * (3.0 - 2.0 * time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_begin_and_end_in_time_and_never_go_back() {
        for ease in [Ease::Linear, Ease::In, Ease::Out, Ease::InOut] {
            assert_eq!((ease.way(0.0), ease.way(1.0)), (0.0, 1.0), "{ease:?}");
            let ways: Vec<f64> = (0..=100).map(|i| ease.way(f64::from(i) / 100.0)).collect();
            assert!(ways.is_sorted(), "{ease:?}");
        }
        assert_eq!([Ease::In, Ease::Out, Ease::InOut].map(|ease| ease.way(0.5)), [0.25, 0.75, 0.5]);
    }
}
