//! Parameters as the contract has them: their names, and the values that they take.

use serde_json::{Value, json};
use strahl::enum_names::list;
use strahl::models::NameOrIndex;
use strahl::scene::description::{Accuracy, FilmBackground};
use strahl::scene::model::View;

/// A parameter, for the contract.
#[derive(Debug)]
pub(crate) struct Parameter {
    /// Its name.
    pub(crate) name: &'static str,
    /// What it means.
    pub(crate) about: &'static str,
    /// Whether it must be given.
    pub(crate) required: bool,
    pub(super) values: Values,
}

/// Values of a parameter.
#[derive(Debug, Clone)]
pub(super) enum Values {
    Text,
    /// Any number of texts, each as a parameter of the same name.
    Texts,
    Flag,
    /// A whole number within a range, and the limit that gives the range.
    Whole(u64, u64, Option<&'static str>),
    /// A number of at least the first and at most the second, and the limit that gives the latter.
    Number(f64, Option<f64>, Option<&'static str>),
    Words(Vec<String>),
    /// Three numbers.
    Point,
    Accuracy,
    View,
    Background,
    Sheet,
    /// A number from 0, or a name.
    NameOrIndex,
}

/// The largest whole number that the contract's format int64 holds.
pub(super) const MAX_WHOLE: u64 = i64::MAX as u64;

/// More pixels than any picture has.
pub(super) const MAX_PIXELS: u64 = u32::MAX as u64;

/// Columns and rows of a sheet, as a pattern.
const SHEET: &str = "^([1-9][0-9]{0,2}|1000)x([1-9][0-9]{0,2}|1000)$";
/// Most columns, and most rows.
pub(super) const SHEET_SIDE: u32 = 1_000;

/// Three numbers as a pattern.
const POINT: &str = "^ *[-+.0-9eE]+ *, *[-+.0-9eE]+ *, *[-+.0-9eE]+ *$";

impl Parameter {
    /// Its schema.
    pub(crate) fn schema(&self) -> Value {
        match &self.values {
            Values::Text => json!({ "type": "string" }),
            Values::NameOrIndex => json!({ "type": "string", "minLength": 1, "maxLength": 62 }),
            Values::Texts => json!({ "type": "array", "items": { "type": "string" } }),
            Values::Flag => json!({ "type": "boolean" }),
            Values::Whole(least, MAX_PIXELS, _) => json!({ "type": "integer", "format": "int32", "minimum": least }),
            Values::Whole(least, MAX_WHOLE, _) => json!({ "type": "integer", "format": "int64", "minimum": least }),
            Values::Whole(least, most, _) => {
                json!({ "type": "integer", "format": "int32", "minimum": least, "maximum": most })
            }
            Values::Number(least, most, _) => {
                let mut schema = json!({ "type": "number", "format": "double", "minimum": least });
                if let Some(most) = most {
                    schema["maximum"] = json!(most);
                }
                schema
            }
            Values::Words(words) => json!({ "type": "string", "enum": words }),
            Values::Point => json!({ "type": "string", "pattern": POINT }),
            Values::Accuracy => json!({ "type": "string", "pattern": Accuracy::PATTERN }),
            Values::View => json!({ "type": "string", "pattern": View::PATTERN }),
            Values::Sheet => json!({ "type": "string", "pattern": SHEET }),
            Values::Background => json!({ "type": "string", "pattern": FilmBackground::PATTERN }),
        }
    }
}

impl Values {
    /// The expected values in words.
    pub(super) fn expected(&self) -> String {
        match self {
            Self::Text | Self::Texts => "text".into(),
            Self::Flag => "true or false".into(),
            Self::Whole(_, MAX_PIXELS, _) => "a whole number of pixels".into(),
            Self::Whole(_, MAX_WHOLE, _) => "a whole number below 2^63".into(),
            Self::Whole(least, most, None) => format!("a whole number from {least} to {most}"),
            Self::Whole(least, most, Some(limit)) => format!("a whole number from {least} to {most} ({limit})"),
            Self::Number(least, None, _) => format!("a number of at least {least}"),
            Self::Number(least, Some(most), None) => format!("a number from {least} to {most}"),
            Self::Number(least, Some(most), Some(limit)) => {
                format!("a number from {least} to {} ({limit})", (most * 1e3).round() / 1e3)
            }
            Self::Words(words) => list(words.iter().cloned(), "or"),
            Self::Point => "three numbers, as 1,-2.5,3".into(),
            Self::Accuracy => Accuracy::WRITTEN.into(),
            Self::View => View::WRITTEN.into(),
            Self::Sheet => "columns and rows, as 6x6".into(),
            Self::Background => FilmBackground::WRITTEN.into(),
            Self::NameOrIndex => NameOrIndex::WRITTEN.into(),
        }
    }
}
