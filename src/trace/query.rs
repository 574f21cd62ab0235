//! Single rays: what `strahl rays` and `POST /v1/rays` answer.

use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// A ray; `t` counts in units of `direction`, which is taken as given.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RayQuery {
    /// Start.
    pub origin: [f64; 3],
    /// Direction, any length but 0.
    pub direction: [f64; 3],
    /// Hits at or below this t do not count. Default 0.
    #[serde(default)]
    pub t_min: f64,
    /// Hits beyond this t do not count. Default: none is too far.
    #[serde(default)]
    pub t_max: Option<f64>,
}

/// What a ray hits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RayAnswer {
    /// Whether it hits anything; the other keys are there only if it does.
    pub hit: bool,
}

/// Follows one ray to its first hit.
pub fn answer(_scene: &Scene, _ray: &RayQuery) -> RayAnswer {
    RayAnswer { hit: false }
}
