//! The color of a surface: the same everywhere, or a pattern.

use super::color::{Color, ColorVisitor, EXPECTED};
use super::material::Checker;
use super::texture::{Gradient, ImageMap, Noise};
use crate::math::Rgb;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer};
use serde::ser::{Serialize, Serializer};
use std::{borrow::Cow, fmt};

/// A color, or a pattern of colors. What serde derives is for patterns: a color has several forms, each with its message.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case")]
pub enum Diffuse {
    /// The same everywhere.
    #[serde(skip)]
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

impl Diffuse {
    /// The picture, if it is one.
    pub fn image(&self) -> Option<&ImageMap> {
        match self {
            Self::Image(image) => Some(image),
            _ => None,
        }
    }
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
            pattern => Self::serialize(pattern, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Diffuse {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
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
                Diffuse::deserialize(MapAccessDeserializer::new(map))
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
            "description": "A color, or a pattern: {\"checker\": {...}}, \"gradient\", \"image\" or \"noise\".",
            "anyOf": kinds
        })
    }
}
