//! Colours as a scene writes them: a grey number, linear `[r, g, b]`, or sRGB `"#rrggbb"`.

use super::description::{Checker, Gradient, ImageMap, Noise};
use crate::math::{self, Rgb};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer};
use serde::ser::{Serialize, Serializer};
use std::{borrow::Cow, fmt};

/// A linear colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Color(pub Rgb);

impl Color {
    /// 0 0 0.
    pub const BLACK: Self = Self(Rgb::ZERO);
    /// 1 1 1.
    pub const WHITE: Self = Self(Rgb::ONE);

    /// [`Self::WHITE`], as a function for serde.
    pub fn white() -> Self {
        Self::WHITE
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

const EXPECTED: &str = "a number, [r, g, b] or \"#rrggbb\"";

struct ColorVisitor;

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
        Color::from_hex(text).ok_or_else(|| E::custom(format_args!("{text:?} is no colour; write it as \"#rrggbb\"")))
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
            "description": "A colour: a grey number, linear [r, g, b], or sRGB \"#rrggbb\". No channel below 0.",
            "anyOf": [
                { "type": "number", "minimum": 0 },
                { "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 3, "maxItems": 3 },
                { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" }
            ]
        })
    }
}

/// A colour, or a pattern of colours.
#[derive(Debug, Clone, PartialEq)]
pub enum Diffuse {
    /// The same everywhere.
    Uniform(Color),
    /// A checkerboard.
    Checker(Checker),
    /// An even change from one point to another.
    Gradient(Gradient),
    /// A picture.
    Image(ImageMap),
    /// Clouds.
    Noise(Noise),
}

impl Default for Diffuse {
    fn default() -> Self {
        Self::Uniform(Color(Rgb::splat(0.8)))
    }
}

impl Serialize for Diffuse {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Uniform(color) => color.serialize(serializer),
            Self::Checker(checker) => serializer.collect_map([("checker", checker)]),
            Self::Gradient(gradient) => serializer.collect_map([("gradient", gradient)]),
            Self::Image(image) => serializer.collect_map([("image", image)]),
            Self::Noise(noise) => serializer.collect_map([("noise", noise)]),
        }
    }
}

impl<'de> Deserialize<'de> for Diffuse {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum Pattern {
            Checker(Checker),
            Gradient(Gradient),
            Image(ImageMap),
            Noise(Noise),
        }
        struct DiffuseVisitor;
        impl<'de> Visitor<'de> for DiffuseVisitor {
            type Value = Diffuse;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{EXPECTED} or a pattern such as {{\"checker\": {{...}}}}")
            }
            fn visit_f64<E: Error>(self, grey: f64) -> Result<Diffuse, E> {
                ColorVisitor.visit_f64(grey).map(Diffuse::Uniform)
            }
            fn visit_u64<E: Error>(self, grey: u64) -> Result<Diffuse, E> {
                ColorVisitor.visit_u64(grey).map(Diffuse::Uniform)
            }
            fn visit_i64<E: Error>(self, grey: i64) -> Result<Diffuse, E> {
                ColorVisitor.visit_i64(grey).map(Diffuse::Uniform)
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Diffuse, E> {
                ColorVisitor.visit_str(text).map(Diffuse::Uniform)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Diffuse, A::Error> {
                ColorVisitor.visit_seq(seq).map(Diffuse::Uniform)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Diffuse, A::Error> {
                Ok(match Pattern::deserialize(MapAccessDeserializer::new(map))? {
                    Pattern::Checker(checker) => Diffuse::Checker(checker),
                    Pattern::Gradient(gradient) => Diffuse::Gradient(gradient),
                    Pattern::Image(image) => Diffuse::Image(image),
                    Pattern::Noise(noise) => Diffuse::Noise(noise),
                })
            }
        }
        deserializer.deserialize_any(DiffuseVisitor)
    }
}

impl JsonSchema for Diffuse {
    fn schema_name() -> Cow<'static, str> {
        "Diffuse".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut kinds = vec![generator.subschema_for::<Color>()];
        let patterns = [
            ("checker", generator.subschema_for::<Checker>()),
            ("gradient", generator.subschema_for::<Gradient>()),
            ("image", generator.subschema_for::<ImageMap>()),
            ("noise", generator.subschema_for::<Noise>()),
        ];
        kinds.extend(patterns.map(|(name, pattern)| {
            schemars::json_schema!({
                "type": "object",
                "properties": { name: pattern },
                "required": [name],
                "additionalProperties": false
            })
        }));
        schemars::json_schema!({
            "description": "A colour, or a pattern: {\"checker\": {...}}, \"gradient\", \"image\" or \"noise\".",
            "anyOf": kinds
        })
    }
}
