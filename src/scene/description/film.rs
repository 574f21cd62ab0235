//! The film: how the light of a picture becomes colors.

use super::Color;
use crate::film::ToneMapping;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// How the light of a picture becomes the colors of its file. Light itself does not change, nor what is proved about it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Film {
    /// Exposure in stops, between -32 and 32: each doubles all light, before `tone`. Default 0.
    #[schemars(range(min = -32, max = 32))]
    pub exposure: f64,
    /// How light brighter than white is compressed. Default: not at all. EXR and PFM keep the light as it is, without
    /// exposure and tone.
    pub tone: ToneMapping,
    /// What the camera sees where nothing is. Default: the scene's background.
    pub background: FilmBackground,
}

/// What the camera sees where nothing is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FilmBackground {
    /// The scene's background or environment.
    #[default]
    Scene,
    /// Nothing: PNG, WebP and EXR files are transparent there, also behind bodies that transmit light. Mirrors show the scene's
    /// background.
    Transparent,
    /// A color, which the picture shows as it is, whatever its exposure and tone: the transparent picture over it. EXR files stay
    /// transparent, and mirrors show the scene's background.
    Color(Color),
}

impl FilmBackground {
    /// What may be written in a setting.
    pub const WRITTEN: &'static str = "scene, transparent, or a color as #rrggbb or rrggbb";
    /// The same as a pattern.
    pub const PATTERN: &'static str = "^(scene|transparent|#?[0-9a-fA-F]{6})$";
}

impl FromStr for FilmBackground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A # in a URL begins its fragment.
        let color = || Color::from_hex(&format!("#{}", text.strip_prefix('#').unwrap_or(text))).map(Self::Color);
        match text {
            "scene" => Ok(Self::Scene),
            "transparent" => Ok(Self::Transparent),
            _ => color().ok_or_else(|| format!("expected {}", Self::WRITTEN)),
        }
    }
}

impl Film {
    /// Whether it changes nothing.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
