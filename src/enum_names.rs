//! Choices that have names: the enum itself is the one list of its words, for flags, queries, JSON and the contract.

use schemars::{JsonSchema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde::de::value::{Error, StrDeserializer};
use serde_json::Value;

/// A word and what it stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Word {
    /// As it is written.
    pub name: String,
    /// Its meaning, if the enum says it.
    pub about: Option<String>,
}

/// The words of an enum without fields, in its order.
pub fn words<T: JsonSchema>() -> Vec<Word> {
    let schema = SchemaGenerator::default().into_root_schema_for::<T>();
    let texts = |value: &Value| value.as_str().map(str::to_owned);
    let choices = |of: &str| schema.get(of).and_then(Value::as_array).into_iter().flatten();
    // Variants with a meaning each have a schema of their own; the others share one.
    let shared = |one: &Value| one["enum"].as_array().into_iter().flatten().filter_map(texts).collect::<Vec<_>>();
    let one = |one: &Value| match texts(&one["const"]) {
        Some(name) => vec![Word { name, about: texts(&one["description"]) }],
        None => shared(one).into_iter().map(|name| Word { name, about: None }).collect(),
    };
    choices("oneOf")
        .flat_map(one)
        .chain(shared(schema.as_value()).into_iter().map(|name| Word { name, about: None }))
        .collect()
}

/// The choice that a word stands for.
pub fn choice<T: DeserializeOwned>(word: &str) -> Option<T> {
    T::deserialize(StrDeserializer::<Error>::new(word)).ok()
}

/// What is expected where none of the words stands: `single or double`.
pub fn expected<T: JsonSchema>() -> String {
    list(words::<T>().into_iter().map(|word| word.name), "or")
}

/// `a, b and c`.
pub fn list(items: impl Iterator<Item = String>, last: &str) -> String {
    let items: Vec<String> = items.collect();
    match items.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., end] => format!("{} {last} {end}", most.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::maps::MapKind;
    use crate::scene::description::Precision;

    #[test]
    fn an_enum_is_the_list_of_its_words() {
        assert_eq!(expected::<Precision>(), "single or double");
        assert_eq!(expected::<MapKind>(), "proved, rays, time, depth or samples");
        assert!(words::<MapKind>().iter().all(|word| word.about.is_some()));
        for word in words::<MapKind>() {
            assert!(choice::<MapKind>(&word.name).is_some(), "{word:?}");
        }
        assert_eq!(choice::<Precision>("Single"), None);
    }
}
