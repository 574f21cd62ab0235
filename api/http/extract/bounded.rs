//! Lists and settings of bodies, read no further than they may be large: in memory a list of empty texts takes 16 times its bytes.

use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use std::fmt::{self, Formatter};
use std::marker::PhantomData;

/// Bytes that the settings of a picture may have: as many as a query.
const SETTINGS_BYTES: usize = 1 << 16;

/// A list of which the first `MOST` elements are kept, and all are counted.
#[derive(Debug)]
pub(crate) struct BoundedList<T, const MOST: usize> {
    pub(crate) kept: Vec<T>,
    pub(crate) count: usize,
}

impl<T, const MOST: usize> Default for BoundedList<T, MOST> {
    fn default() -> Self {
        Self { kept: Vec::new(), count: 0 }
    }
}

impl<'de, T: Deserialize<'de>, const MOST: usize> Deserialize<'de> for BoundedList<T, MOST> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor<T, const MOST: usize>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>, const MOST: usize> Visitor<'de> for ListVisitor<T, MOST> {
            type Value = BoundedList<T, MOST>;
            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("an array")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Self::Value, A::Error> {
                let mut kept = Vec::new();
                while kept.len() < MOST
                    && let Some(element) = all.next_element()?
                {
                    kept.push(element);
                }
                let mut count = kept.len();
                // In serde_json reading on after the end of a shorter array is an error.
                while count >= MOST && all.next_element::<IgnoredAny>()?.is_some() {
                    count += 1;
                }
                Ok(BoundedList { kept, count })
            }
        }
        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}

/// Settings of a picture, by the names of query parameters.
#[derive(Debug, Clone, Default)]
pub(crate) struct SettingsObject(pub(crate) Map<String, Value>);

impl<'de> Deserialize<'de> for SettingsObject {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SettingsVisitor;
        impl<'de> Visitor<'de> for SettingsVisitor {
            type Value = SettingsObject;
            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("an object of settings")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut all: A) -> Result<Self::Value, A::Error> {
                let (mut settings, mut bytes) = (Map::new(), 0);
                while let Some((name, value)) = all.next_entry::<String, &'de RawValue>()? {
                    bytes += name.len() + value.get().len();
                    if bytes > SETTINGS_BYTES {
                        return Err(A::Error::custom(format!("settings have at most {SETTINGS_BYTES} bytes")));
                    }
                    settings.insert(name, serde_json::from_str(value.get()).map_err(A::Error::custom)?);
                }
                Ok(SettingsObject(settings))
            }
        }
        deserializer.deserialize_map(SettingsVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_kept_up_to_their_limit() {
        for (text, count) in [("[]", 0), ("[1]", 1), ("[1,2,3]", 3), ("[1,2,3,4,5]", 5)] {
            let list: BoundedList<u8, 3> = serde_json::from_str(text).unwrap();
            assert_eq!((list.kept.len(), list.count), (count.min(3), count), "{text}");
        }
        assert!(serde_json::from_str::<BoundedList<u8, 3>>("[1,2,3,4").is_err());
    }

    #[test]
    fn settings_are_short() {
        let settings: SettingsObject = serde_json::from_str(r#"{"width": 7, "width": 8, "region": [1, 2]}"#).unwrap();
        assert_eq!(Value::Object(settings.0), serde_json::json!({ "width": 8, "region": [1, 2] }));
        let long = format!(r#"{{"width": [{}0]}}"#, "0,".repeat(SETTINGS_BYTES / 2));
        let error = serde_json::from_str::<SettingsObject>(&long).unwrap_err();
        assert!(error.to_string().contains("at most 65536 bytes"), "{error}");
    }
}
