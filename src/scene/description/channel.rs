//! Channels of a material: a value that is the same everywhere, or the texels of a picture times a factor.

use super::color::Color;
use super::texture::Wrap;
use super::{is_default, number};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::{borrow::Cow, fmt, marker::PhantomData};

/// What channels hold: numbers or colors.
pub trait Factor: Copy + PartialEq + Serialize + DeserializeOwned + JsonSchema {
    /// Name of its channel in the schema.
    const CHANNEL: &'static str;
    /// What a value looks like, for errors.
    const EXPECTED: &'static str;
    /// What changes no texel.
    fn one() -> Self;
}

impl Factor for f64 {
    const CHANNEL: &'static str = "NumberChannel";
    const EXPECTED: &'static str = "a number";
    fn one() -> Self {
        1.0
    }
}

impl Factor for Color {
    const CHANNEL: &'static str = "ColorChannel";
    const EXPECTED: &'static str = super::color::EXPECTED;
    fn one() -> Self {
        Self::WHITE
    }
}

/// A value, or a picture times a value.
#[derive(Debug, Clone, PartialEq)]
pub enum Channel<T: Factor> {
    /// The same everywhere.
    Value(T),
    /// From a picture.
    Textured(Box<Textured<T>>),
}

/// A picture times a value.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, bound = "")]
#[schemars(inline)]
pub struct Textured<T: Factor> {
    /// Factor on the texels. Default 1.
    #[serde(default = "T::one")]
    pub factor: T,
    /// PNG, JPEG, WebP or KTX 2.0 (Basis Universal): `"data:image/png;base64,..."`, or the name of a file beside the scene, where
    /// files may be read. Colors are sRGB, all else is linear.
    pub image: String,
    /// The channel of the picture that is a number. Default `"r"`. Colors take red, green and blue.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<TexelChannel>,
    /// Which texture coordinates of the mesh, 0 for `uvs` or 1 for `uvs1`. Default 0.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(range(min = 0, max = 1))]
    pub uv: u32,
    /// How texture coordinates are moved before the picture is looked up. Default: not at all.
    #[serde(default, skip_serializing_if = "is_default")]
    pub transform: UvTransform,
    /// The texture beyond the edges of the picture, in both directions or `[across, along]`. Default `"repeat"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub wrap: Wraps,
    /// What its pixels look like from near. Default `"smooth"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub enlarged: Enlarged,
}

/// What pixels of a picture look like where they are larger than those of the rendered one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Enlarged {
    /// One color goes over into the next.
    #[default]
    Smooth,
    /// Squares of one color.
    Nearest,
}

/// A channel of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum TexelChannel {
    #[default]
    R,
    G,
    B,
    A,
}

/// A transform of texture coordinates as in KHR_texture_transform: from the upper left corner of the picture, v down; scaled,
/// then rotated, then moved.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct UvTransform {
    /// Moved by. Default [0, 0].
    pub offset: [f64; 2],
    /// Rotated by, in degrees, from -360 to 360; the picture turns clockwise. Default 0.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotate_deg: f64,
    /// Scaled by. Default [1, 1].
    pub scale: [f64; 2],
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotate_deg: 0.0, scale: [number::<1>(); 2] }
    }
}

/// What lies beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Wraps {
    /// The same in both directions.
    Both(Wrap),
    /// Across and along.
    Each([Wrap; 2]),
}

impl Wraps {
    /// Across and along.
    pub fn each(self) -> [Wrap; 2] {
        match self {
            Self::Both(wrap) => [wrap; 2],
            Self::Each(each) => each,
        }
    }
}

impl Default for Wraps {
    fn default() -> Self {
        Self::Both(Wrap::Repeat)
    }
}

impl<T: Factor> Channel<T> {
    /// The value, or the factor on the texels.
    pub fn factor(&self) -> T {
        match self {
            Self::Value(value) => *value,
            Self::Textured(textured) => textured.factor,
        }
    }

    /// The picture, if there is one.
    pub fn textured(&self) -> Option<&Textured<T>> {
        match self {
            Self::Value(_) => None,
            Self::Textured(textured) => Some(textured),
        }
    }
}

impl<T: Factor> Serialize for Channel<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::Textured(textured) => textured.serialize(serializer),
        }
    }
}

struct ChannelVisitor<T>(PhantomData<T>);

impl<'de, T: Factor> Visitor<'de> for ChannelVisitor<T> {
    type Value = Channel<T>;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} or a picture such as {{\"image\": \"...\"}}", T::EXPECTED)
    }
    fn visit_f64<E: Error>(self, x: f64) -> Result<Channel<T>, E> {
        T::deserialize(x.into_deserializer()).map(Channel::Value)
    }
    fn visit_u64<E: Error>(self, x: u64) -> Result<Channel<T>, E> {
        T::deserialize(x.into_deserializer()).map(Channel::Value)
    }
    fn visit_i64<E: Error>(self, x: i64) -> Result<Channel<T>, E> {
        T::deserialize(x.into_deserializer()).map(Channel::Value)
    }
    fn visit_str<E: Error>(self, text: &str) -> Result<Channel<T>, E> {
        T::deserialize(text.into_deserializer()).map(Channel::Value)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Channel<T>, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(seq)).map(Channel::Value)
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Channel<T>, A::Error> {
        Textured::deserialize(MapAccessDeserializer::new(map)).map(|textured| Channel::Textured(Box::new(textured)))
    }
}

impl<'de, T: Factor> Deserialize<'de> for Channel<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ChannelVisitor(PhantomData))
    }
}

impl<T: Factor> JsonSchema for Channel<T> {
    fn schema_name() -> Cow<'static, str> {
        T::CHANNEL.into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let kinds = [generator.subschema_for::<T>(), generator.subschema_for::<Textured<T>>()];
        json_schema!({
            "description": "A value, or a picture times a value: {\"factor\": ..., \"image\": \"...\"}.",
            "anyOf": kinds
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{from_str, json, to_value};

    #[test]
    fn a_channel_is_a_value_or_a_picture() {
        assert_eq!(from_str::<Channel<f64>>("1").unwrap(), Channel::Value(1.0));
        assert_eq!(from_str::<Channel<Color>>("\"#ffffff\"").unwrap(), Channel::Value(Color::WHITE));
        assert_eq!(from_str::<Channel<Color>>("[1, 1, 1]").unwrap(), Channel::Value(Color::WHITE));
        let mapped: Channel<f64> =
            from_str(r#"{ "image": "a.png", "channel": "g", "wrap": ["clamp", "mirror"] }"#).unwrap();
        let textured = mapped.textured().unwrap();
        assert_eq!((textured.factor, textured.channel), (1.0, Some(TexelChannel::G)));
        assert_eq!(textured.wrap.each(), [Wrap::Clamp, Wrap::Mirror]);
        let written = json!({ "factor": 1.0, "image": "a.png", "channel": "g", "wrap": ["clamp", "mirror"] });
        assert_eq!(to_value(&mapped).unwrap(), written);
    }

    #[test]
    fn what_is_neither_is_refused() {
        assert!(from_str::<Channel<f64>>("\"#ffffff\"").is_err());
        assert!(from_str::<Channel<f64>>("[1, 1, 1]").is_err());
        assert!(from_str::<Channel<Color>>("{ \"factor\": 1 }").unwrap_err().to_string().contains("image"));
        assert!(from_str::<Channel<Color>>("{ \"picture\": \"a.png\" }").is_err());
    }
}
