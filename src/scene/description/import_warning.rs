//! What the file of a model says and a scene does not, kept with the scene that was made of it.

use super::Fidelity;
use crate::models::Subject;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What of a model is approximated, left out or assumed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportWarning {
    /// What happens to it.
    pub code: Subject,
    /// One sentence, of at most 1024 characters.
    #[schemars(length(max = 1024))]
    pub detail: String,
    /// The fidelity that it holds for. Default: each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<Fidelity>,
}

impl ImportWarning {
    /// Whether it holds for pictures of a fidelity.
    pub fn holds_for(&self, fidelity: Fidelity) -> bool {
        self.fidelity.is_none_or(|of| of == fidelity)
    }
}
