//! Colors as a scene writes them: a grey number, linear `[r, g, b]`, or sRGB `"#rrggbb"`.

use crate::math::{self, Rgb};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::{borrow::Cow, fmt};

/// A linear color.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Color(pub Rgb);

/// How [`Color::from_hex`] is written, as a regular expression.
pub(in crate::scene) const HEX: &str = "^#[0-9a-fA-F]{6}$";

impl Color {
    /// 0 0 0.
    pub const BLACK: Self = Self(Rgb::ZERO);
    /// 1 1 1.
    pub const WHITE: Self = Self(Rgb::ONE);

    /// [`Self::WHITE`], as a function for serde.
    pub fn white() -> Self {
        Self::WHITE
    }

    /// Whether it is 0 0 0.
    pub fn is_black(&self) -> bool {
        *self == Self::BLACK
    }

    /// Reads `#rrggbb`, taken as sRGB.
    pub fn from_hex(text: &str) -> Option<Self> {
        let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
        let code = u32::from_str_radix(digits, 16).ok()?;
        let channel = |shift: u32| math::srgb_to_linear(f64::from((code >> shift) & 0xff) / 255.0);
        Some(Self(Rgb::new(channel(16), channel(8), channel(0))))
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.to_array().serialize(serializer)
    }
}

pub(super) const EXPECTED: &str = "a number, [r, g, b] or \"#rrggbb\"";

pub(super) struct ColorVisitor;

impl<'de> Visitor<'de> for ColorVisitor {
    type Value = Color;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(EXPECTED)
    }
    fn visit_f64<E: Error>(self, grey: f64) -> Result<Color, E> {
        Ok(Color(Rgb::splat(grey)))
    }
    fn visit_u64<E: Error>(self, grey: u64) -> Result<Color, E> {
        self.visit_f64(grey as f64)
    }
    fn visit_i64<E: Error>(self, grey: i64) -> Result<Color, E> {
        self.visit_f64(grey as f64)
    }
    fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
        Color::from_hex(text).ok_or_else(|| E::custom(format_args!("{text:?} is no color; write it as \"#rrggbb\"")))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Color, A::Error> {
        let mut rgb = [0.0; 3];
        for (i, channel) in rgb.iter_mut().enumerate() {
            *channel = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &"three numbers"))?;
        }
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::invalid_length(4, &"three numbers"));
        }
        Ok(Color(Rgb::from_array(rgb)))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColorVisitor)
    }
}

impl JsonSchema for Color {
    fn schema_name() -> Cow<'static, str> {
        "Color".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schemars::json_schema!({
            "description": "A color: a grey number, linear [r, g, b], or sRGB \"#rrggbb\". No channel below 0.",
            "anyOf": [
                { "type": "number", "minimum": 0 },
                { "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 3, "maxItems": 3 },
                { "type": "string", "pattern": HEX }
            ]
        })
    }
}
