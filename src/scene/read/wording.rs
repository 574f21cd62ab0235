//! The phrases of `diagnose`'s sentences.

use crate::enum_names::list;
use crate::scene::problem::quoted;
use crate::scene::schema::Node;
use serde_json::Value;

/// What a schema expects: `an array of 3 numbers`, `"x" or "y"`.
pub(super) fn expected(node: Node<'_>, root: &Value) -> String {
    let choices = node.alternatives(root);
    let kinds: Vec<&str> = choices.iter().filter_map(|choice| choice.tag()).collect();
    let mut phrases: Vec<String> = Vec::new();
    for choice in &choices {
        let words = choice.words();
        if !words.is_empty() {
            phrases.extend(words.into_iter().map(quoted));
        } else if choice.tag().is_none() {
            phrases.extend(choice.types().into_iter().filter_map(|name| phrase(name, *choice, root)));
        }
    }
    if kinds.len() > 3 {
        let kinds = list(kinds.into_iter().map(quoted), "or");
        phrases.push(format!("an object whose only key names its kind: {kinds}"));
    } else {
        phrases.extend(kinds.into_iter().map(|kind| format!("{{\"{kind}\": {{...}}}}")));
    }
    list(phrases.into_iter(), "or")
}

fn phrase(name: &str, node: Node<'_>, root: &Value) -> Option<String> {
    Some(match name {
        "integer" => "a whole number".to_owned(),
        "number" => "a number".to_owned(),
        "boolean" => "true or false".to_owned(),
        "string" if node.schema.get("pattern").is_some() => "\"#rrggbb\"".to_owned(),
        "string" => "a string".to_owned(),
        "object" => "an object".to_owned(),
        "array" => {
            let items = Node { schema: &node.schema["items"], name: node.name }.resolve(root);
            let of = match items.types().first() {
                Some(&"number") => "numbers".to_owned(),
                Some(&"integer") => "whole numbers".to_owned(),
                Some(&"array") => phrase("array", items, root)?.replacen("an array", "arrays", 1),
                _ => return Some("an array".to_owned()),
            };
            match node.schema["maxItems"].as_u64() {
                Some(count) => format!("an array of {count} {of}"),
                None => format!("an array of {of}"),
            }
        }
        // Null means a missing key: messages do not offer it.
        _ => return None,
    })
}

/// A value, short enough for a sentence.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(_) | Value::Number(_) => value.to_string(),
        Value::String(text) => quoted(text),
        Value::Array(elements) => match elements.len() {
            0 => "an empty array".to_owned(),
            1 => "an array of 1 element".to_owned(),
            count => format!("an array of {count} elements"),
        },
        Value::Object(_) => "an object".to_owned(),
    }
}

/// Advice on a value of the wrong type, where there is an obvious one.
pub(super) fn type_hint(node: Node<'_>, value: &Value, root: &Value) -> String {
    let choices = node.alternatives(root);
    let wants = |name: &str| choices.iter().any(|choice| choice.types().contains(&name));
    match value {
        Value::String(text) if (wants("number") || wants("integer")) && text.trim().parse::<f64>().is_ok() => {
            "; write it without quotes".to_owned()
        }
        Value::String(text) if wants("boolean") && matches!(text.as_str(), "true" | "false") => {
            "; write it without quotes".to_owned()
        }
        // As queries write it: "time:200".
        Value::String(text) => {
            let kind = text.split(':').next().unwrap_or_default();
            let is_kind = choices.iter().any(|choice| choice.tag() == Some(kind));
            if is_kind { format!("; write {{\"{kind}\": {{...}}}}") } else { String::new() }
        }
        Value::Number(number) if wants("integer") && number.as_f64().is_some_and(|x| x.fract() == 0.0) => {
            "; write it without decimal point and exponent".to_owned()
        }
        Value::Number(_) => match choices.as_slice() {
            [only] => only.tag().map_or_else(String::new, |key| format!("; write {{\"{key}\": {value}}}")),
            _ => String::new(),
        },
        _ => String::new(),
    }
}

/// `must be above 0 and at most 360, is 400` for a number outside its range.
pub(super) fn out_of_range(node: Node<'_>, value: &Value) -> Option<String> {
    let number = value.as_f64()?;
    let bound = |key: &str| node.schema[key].as_f64();
    let limits = [
        ("minimum", "at least", bound("minimum").is_some_and(|limit| number < limit)),
        ("exclusiveMinimum", "above", bound("exclusiveMinimum").is_some_and(|limit| number <= limit)),
        ("maximum", "at most", bound("maximum").is_some_and(|limit| number > limit)),
        ("exclusiveMaximum", "below", bound("exclusiveMaximum").is_some_and(|limit| number >= limit)),
    ];
    if limits.iter().all(|(_, _, broken)| !broken) {
        return None;
    }
    let phrases = limits.iter().filter_map(|(key, phrase, _)| bound(key).map(|limit| format!("{phrase} {limit}")));
    Some(format!("must be {}, is {value}", list(phrases, "and")))
}

/// The noun for a schema's name.
pub(super) fn noun(name: &str) -> &'static str {
    match name {
        "Object" => "object",
        "Camera" => "camera",
        "Light" => "light",
        "Falloff" => "falloff",
        "Accuracy" => "accuracy mode",
        "Diffuse" => "pattern",
        "Mapping" => "mapping",
        "Relief" => "relief",
        "Shadows" => "shadow mode",
        "Precision" => "precision",
        "Fresnel" => "Fresnel law",
        _ => "value",
    }
}

/// The article of a noun.
pub(super) fn article(noun: &str) -> &'static str {
    if noun.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
}

/// `element` or its plural.
pub(super) fn elements(count: u64) -> &'static str {
    if count == 1 { "element" } else { "elements" }
}
