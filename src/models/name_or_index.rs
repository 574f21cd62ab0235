//! One of several things of a file: by its place, or by its name.

use super::fault::{Fault, Kind};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Bytes of the longest name.
const NAME: usize = 62;

/// A number from 0, or a name. It is small, and copied with the settings that hold it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameOrIndex {
    /// By its place, from 0.
    Index(u32),
    /// By its name.
    Name(Name),
}

/// A short name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name {
    bytes: [u8; NAME],
    length: u8,
}

impl Name {
    fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl NameOrIndex {
    /// What may be written.
    pub const WRITTEN: &'static str = "a number from 0, or a name of at most 62 bytes";

    /// The place among things of these names.
    pub(super) fn find<'a>(
        &self,
        what: &str,
        pointer: &str,
        names: impl ExactSizeIterator<Item = Option<&'a str>> + Clone,
    ) -> Result<usize, Fault> {
        let found = match self {
            Self::Index(index) => Some(*index as usize).filter(|index| *index < names.len()),
            Self::Name(name) => names.clone().position(|other| other == Some(name.as_str())),
        };
        found.ok_or_else(|| {
            let listed: Vec<&str> = names.clone().flatten().take(20).collect();
            let listed = if listed.is_empty() { String::new() } else { format!(" ({})", listed.join(", ")) };
            let detail = format!("there is no {what} {self}: the file has {}{listed}", counted(names.len()));
            Fault::new(pointer, Kind::UnknownReference, detail)
        })
    }
}

/// How many things a file has, as messages say it.
pub fn counted(count: usize) -> String {
    if count == 0 { "none".to_owned() } else { format!("{count}, counted from 0") }
}

impl fmt::Display for NameOrIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index(index) => index.fmt(f),
            Self::Name(name) => f.write_str(name.as_str()),
        }
    }
}

impl FromStr for NameOrIndex {
    type Err = String;

    /// What is written with digits alone is a place.
    fn from_str(text: &str) -> Result<Self, String> {
        if !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()) {
            return text.parse().map(Self::Index).map_err(|_| format!("expected {}", Self::WRITTEN));
        }
        let mut name = Name { bytes: [0; NAME], length: text.len() as u8 };
        let room = name.bytes.get_mut(..text.len()).filter(|room| !room.is_empty());
        room.ok_or_else(|| format!("expected {}", Self::WRITTEN))?.copy_from_slice(text.as_bytes());
        Ok(Self::Name(name))
    }
}

impl Serialize for NameOrIndex {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Index(index) => serializer.serialize_u32(*index),
            Self::Name(name) => serializer.serialize_str(name.as_str()),
        }
    }
}

impl<'de> Deserialize<'de> for NameOrIndex {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = NameOrIndex;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(NameOrIndex::WRITTEN)
            }
            fn visit_u64<E: Error>(self, index: u64) -> Result<NameOrIndex, E> {
                u32::try_from(index).map(NameOrIndex::Index).map_err(E::custom)
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<NameOrIndex, E> {
                name.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for NameOrIndex {
    fn schema_name() -> Cow<'static, str> {
        "NameOrIndex".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "One of several in a file: its place, from 0, or its name.",
            "type": ["integer", "string"], "minimum": 0, "maximum": u32::MAX, "minLength": 1, "maxLength": NAME,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_found_by_place_and_by_name() {
        let names = [Some("Survey"), None, Some("Run")];
        let find =
            |text: &str| text.parse::<NameOrIndex>().unwrap().find("animation", "/animations", names.into_iter());
        assert_eq!(find("Run").unwrap(), 2);
        assert_eq!(find("1").unwrap(), 1);
        let fault = format!("{:?}", find("Walk").unwrap_err());
        assert!(fault.contains("no animation Walk: the file has 3") && fault.contains("Survey, Run"), "{fault}");
        assert!(find("3").is_err());
        assert!("".parse::<NameOrIndex>().is_err() && "x".repeat(63).parse::<NameOrIndex>().is_err());
        for text in ["7", "\"Run fast\""] {
            let which: NameOrIndex = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&which).unwrap(), text);
        }
    }
}
