//! What a scene asks for that a trade-off cannot compare: each of its settings says how many samples there are.

use crate::scene::description::Accuracy;

/// What is not compared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeftOut {
    /// The scene's own mode, if that chooses which samples are traced.
    mode: Option<Accuracy>,
    /// Whether the scene leaves the number of samples to its pixels.
    adaptive: bool,
}

impl LeftOut {
    /// Of a scene with a mode, which may leave the number of samples to its pixels.
    pub fn of(accuracy: Accuracy, adaptive: bool) -> Self {
        let chooses = matches!(accuracy, Accuracy::Time(_) | Accuracy::Rays(_) | Accuracy::Statistical(_));
        Self { mode: chooses.then_some(accuracy), adaptive }
    }

    /// Whether the scene's own mode is.
    pub(super) fn has_mode(&self) -> bool {
        self.mode.is_some()
    }

    /// Whether the number of samples is.
    pub(super) fn is_adaptive(&self) -> bool {
        self.adaptive
    }

    /// A sentence for each.
    pub(super) fn remarks(&self) -> Vec<String> {
        let mode = self.mode.map(|mode| {
            format!("Not compared is the scene's own mode, {mode}, since it chooses which samples are traced: here each setting says it.")
        });
        let adaptive = self.adaptive.then(|| {
            "Not compared is that each pixel chooses its number of samples, as the scene names none: here each setting says it."
                .to_owned()
        });
        [mode, adaptive].into_iter().flatten().collect()
    }
}
