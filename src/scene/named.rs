//! JSON objects whose keys are names that the scene chooses: they keep their order, and a name used twice is an error.

use super::limits::NAME_BYTES;
use super::problem::quoted;
use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::sync::Arc;
use std::{fmt, marker::PhantomData};

/// Values by name, in the order of the JSON.
pub type Named<T> = IndexMap<String, T>;

/// Reads an object, and refuses a name used twice.
pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Named<T>, D::Error> {
    struct Entries<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
        type Value = Named<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object")
        }
        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Named<T>, A::Error> {
            let mut named = Named::default();
            while let Some(name) = map.next_key::<String>()? {
                if named.contains_key(&name) {
                    return Err(A::Error::custom(format_args!("the name {} is given twice", quoted(&name))));
                }
                let value = map.next_value()?;
                named.insert(name, value);
            }
            Ok(named)
        }
    }

    from.deserialize_map(Entries(PhantomData))
}

/// The same for what scenes share.
pub(super) fn shared<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Arc<Named<T>>, D::Error> {
    deserialize(from).map(Arc::new)
}

pub(super) fn schema<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let value = generator.subschema_for::<T>();
    let names = schemars::json_schema!({ "maxLength": NAME_BYTES.max });
    schemars::json_schema!({ "type": "object", "propertyNames": names, "additionalProperties": value })
}
