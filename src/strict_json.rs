//! A deserializer that accepts JSON exactly as its schema describes it.
//!
//! serde's derived types accept more: a struct as an array of its fields, and `{"none": null}` for `"none"`. Other programs
//! that follow the schema would refuse such scenes and models.

use crate::control::{self, Cancelled};
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, IgnoredAny, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};
use std::fmt;

/// How serde_json's `RawValue` asks for the text itself, in which nothing is read.
const RAW: &str = "$serde_json::private::RawValue";

/// Reads a whole text.
pub(crate) fn from_slice<'a, T: Deserialize<'a>>(text: &'a [u8]) -> serde_json::Result<T> {
    let mut deserializer = serde_json::Deserializer::from_slice(text);
    let read = T::deserialize(Strict(&mut deserializer))?;
    deserializer.end()?;
    Ok(read)
}

/// Wraps a deserializer, and inside of it everything that leads to inner values.
pub(crate) struct Strict<T>(pub(crate) T);

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Strict<D> {
    type Error = D::Error;

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(Strict(visitor))
    }
    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_ignored_any(visitor)
    }
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_option(Strict(visitor))
    }
    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        if name == RAW {
            return self.0.deserialize_newtype_struct(name, visitor);
        }
        visitor.visit_newtype_struct(self)
    }
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_map(Strict(visitor))
    }
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(Choice(visitor))
    }
}

macro_rules! visit {
    ($($method:ident: $value:ty,)*) => { $(
        fn $method<E: Error>(self, value: $value) -> Result<V::Value, E> {
            self.0.$method(value)
        }
    )* };
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Strict<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }

    visit! {
        visit_bool: bool, visit_i64: i64, visit_u64: u64, visit_f64: f64, visit_str: &str, visit_borrowed_str: &'de str,
        visit_string: String,
    }

    fn visit_none<E: Error>(self) -> Result<V::Value, E> {
        self.0.visit_none()
    }
    fn visit_unit<E: Error>(self) -> Result<V::Value, E> {
        self.0.visit_unit()
    }
    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        self.0.visit_some(Strict(deserializer))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, elements: A) -> Result<V::Value, A::Error> {
        self.0.visit_seq(Strict(elements))
    }
    fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<V::Value, A::Error> {
        self.0.visit_map(Strict(entries))
    }
}

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for Strict<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(Strict(deserializer))
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for Strict<A> {
    type Error = A::Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, A::Error> {
        unless_cancelled()?;
        self.0.next_element_seed(Strict(seed))
    }
    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Strict<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        self.0.next_key_seed(seed)
    }
    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, A::Error> {
        unless_cancelled()?;
        self.0.next_value_seed(Strict(seed))
    }
    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

fn unless_cancelled<E: Error>() -> Result<(), E> {
    control::checkpoint(1).map_err(|Cancelled| E::custom("reading was cancelled"))
}

/// An enum: a string for variants without parameters, an object with one key for those with parameters.
struct Choice<V>(V);

impl<'de, V: Visitor<'de>> Visitor<'de> for Choice<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }
    fn visit_str<E: Error>(self, word: &str) -> Result<V::Value, E> {
        self.0.visit_enum(StrDeserializer::new(word))
    }
    fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<V::Value, A::Error> {
        self.0.visit_enum(Strict(entries))
    }
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for Strict<A> {
    type Error = A::Error;
    type Variant = Self;

    fn variant_seed<K: DeserializeSeed<'de>>(mut self, seed: K) -> Result<(K::Value, Self), A::Error> {
        let kind = self.0.next_key_seed(seed)?;
        Ok((kind.ok_or_else(|| A::Error::custom("an object without the key that names its kind"))?, self))
    }
}

impl<'de, A: MapAccess<'de>> VariantAccess<'de> for Strict<A> {
    type Error = A::Error;

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(mut self, seed: T) -> Result<T::Value, A::Error> {
        let value = self.0.next_value_seed(Strict(seed))?;
        match self.0.next_key::<IgnoredAny>()? {
            None => Ok(value),
            Some(_) => Err(A::Error::custom("a second key beside the one that names the kind")),
        }
    }
    fn unit_variant(self) -> Result<(), A::Error> {
        Err(A::Error::custom("an object in the place of a string"))
    }
    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.newtype_variant_seed(Within(visitor))
    }
    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, A::Error> {
        self.newtype_variant_seed(Within(visitor))
    }
}

/// A variant's fields, without a type of their own.
struct Within<V>(V);

impl<'de, V: Visitor<'de>> DeserializeSeed<'de> for Within<V> {
    type Value = V::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        deserializer.deserialize_any(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::DeserializeOwned;
    use serde_json::value::RawValue;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(default)]
    struct Size {
        width: u32,
        height: u32,
    }

    impl Default for Size {
        fn default() -> Self {
            Self { width: 1, height: 2 }
        }
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Falloff {
        None,
        InverseSquare,
        Linear(Reach),
    }

    #[derive(Debug, PartialEq, Deserialize)]
    struct Reach {
        reach: f64,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Light {
        Point(Point),
        Spot(Size),
    }

    #[derive(Debug, PartialEq, Deserialize)]
    struct Point {
        position: [f64; 3],
        falloff: Option<Falloff>,
    }

    fn strict<T: DeserializeOwned>(text: &str) -> Option<T> {
        T::deserialize(Strict(&mut serde_json::Deserializer::from_str(text))).ok()
    }

    #[test]
    fn takes_what_the_schema_says() {
        assert_eq!(strict(r#"{"width": 3}"#), Some(Size { width: 3, height: 2 }));
        assert_eq!(strict(r#""inverse_square""#), Some(Falloff::InverseSquare));
        assert_eq!(strict(r#"{"linear": {"reach": 2}}"#), Some(Falloff::Linear(Reach { reach: 2.0 })));
        let point = Point { position: [0.0; 3], falloff: Some(Falloff::None) };
        assert_eq!(strict(r#"{"point": {"position": [0, 0, 0], "falloff": "none"}}"#), Some(Light::Point(point)));
    }

    #[test]
    fn leaves_raw_parts_as_they_are() {
        let raw: Option<Vec<Box<RawValue>>> = strict(r#"[{"a":  1}, [2]]"#);
        assert_eq!(raw.unwrap().iter().map(|part| part.get()).collect::<Vec<_>>(), [r#"{"a":  1}"#, "[2]"]);
    }

    /// However deep it is, and whatever numbers and characters it has.
    #[test]
    fn passes_what_is_ignored() {
        let deep = format!("{}{}", "[".repeat(1_000), "]".repeat(1_000));
        for ignored in [&deep, "3e400", r#""\ud800""#] {
            assert_eq!(strict(&format!(r#"{{"width": 3, "more": {ignored}}}"#)), Some(Size { width: 3, height: 2 }));
        }
    }

    #[test]
    fn refuses_what_only_serde_takes() {
        assert_eq!(strict::<Size>("[3, 4]"), None);
        assert_eq!(strict::<Falloff>(r#"{"none": null}"#), None);
        assert_eq!(strict::<Falloff>(r#"{"linear": [2]}"#), None);
        assert_eq!(strict::<Light>(r#"{"point": [[0, 0, 0], "none"]}"#), None);
        assert_eq!(strict::<Light>(r#"{"point": {"position": [0, 0, 0]}, "spot": {}}"#), None);
        assert_eq!(strict::<Light>(r#"{"point": {"position": [0, 0, 0], "falloff": {"linear": [1]}}}"#), None);
    }
}
