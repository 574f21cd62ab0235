//! What is wrong with a model, and what of it is not simulated.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Faults that are looked for in one model.
const MOST: usize = 50;

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// JSON pointer into the glTF; empty for other formats.
    pub pointer: String,
    /// What kind of fault it is.
    pub kind: Kind,
    /// One sentence that says what is wrong and what to do.
    pub detail: String,
    /// Where it is.
    pub place: Place,
}

/// Kinds of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Kind {
    /// The file does not follow its format.
    Invalid,
    WrongType,
    MissingKey,
    OutOfRange,
    /// It needs bytes that are not there.
    OutOfBounds,
    UnknownReference,
    /// A part that it names is not there.
    MissingPart,
    Cycle,
    Degenerate,
    Limit,
    Unsupported,
    Cancelled,
}

/// Where a fault is in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Place {
    /// Where its pointer leads to.
    #[default]
    Pointer,
    /// At an offset of the JSON text, which gives the rest of the pointer too.
    Json(usize),
    /// In a line and a column, from 1.
    Line(u32, u32),
    /// At an offset of the file.
    Offset(u64),
}

impl Fault {
    /// A fault at a pointer.
    pub fn new(pointer: impl Into<String>, kind: Kind, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), kind, detail: detail.into(), place: Place::Pointer }
    }

    /// The same at a place.
    pub(super) fn at(self, place: Place) -> Self {
        Self { place, ..self }
    }

    /// The same below a pointer, if it has none.
    pub(super) fn under(self, pointer: impl fmt::Display) -> Self {
        if self.pointer.is_empty() { Self { pointer: pointer.to_string(), ..self } } else { self }
    }

    /// That nobody waits for the model any more.
    pub(super) fn cancelled() -> Self {
        Self::new("", Kind::Cancelled, "loading was cancelled")
    }
}

/// The faults of a model, at least one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// A single fault.
    pub fn one(fault: Fault) -> Self {
        Self(vec![fault])
    }

    /// Notes one, unless it is known; whether more are wanted. After one that bounds the work none are.
    pub(super) fn push(&mut self, fault: Fault) -> bool {
        if self.0.len() < MOST && !self.0.contains(&fault) {
            self.0.push(fault);
        }
        self.0.len() < MOST && !self.0.iter().any(|fault| matches!(fault.kind, Kind::Cancelled | Kind::Limit))
    }

    /// Notes what is wrong with a result, which is given back if nothing is.
    pub(super) fn note<T>(&mut self, result: Result<T, Fault>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(fault) => {
                self.push(fault);
                None
            }
        }
    }

    /// Fails if there are any.
    pub(super) fn none_or_err(&mut self) -> Result<(), Self> {
        if self.0.is_empty() { Ok(()) } else { Err(std::mem::take(self)) }
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self::one(fault)
    }
}

/// What is not as the file says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// What happens to it.
    pub subject: Subject,
    /// A stable short name of what it is about, such as `sheen`.
    pub what: &'static str,
    /// One sentence for people.
    pub detail: String,
    /// Where the file says it first, if it is one place.
    pub pointer: String,
}

/// What happens to something of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "ImportWarningCode")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Subject {
    NotSimulated,
    Approximated,
    Skipped,
    Assumed,
}

impl Subject {
    /// Its name in warnings.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotSimulated => "not-simulated",
            Self::Approximated => "approximated",
            Self::Skipped => "skipped",
            Self::Assumed => "assumed",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.subject.name(), self.what, self.detail)
    }
}

/// For numbers that a file has, but as NaN or infinity: places of surfaces may not be missing, all else may.
pub(super) fn warn_of_gaps(warnings: &mut Vec<Warning>) {
    let detail =
        "some normals, texture coordinates or colors are no numbers: normals follow from faces there, all else is 0";
    warn(warnings, Subject::Assumed, "numbers", String::new(), detail);
}

/// Notes a warning, once for each thing it is about.
pub(super) fn warn(warnings: &mut Vec<Warning>, subject: Subject, what: &'static str, pointer: String, detail: &str) {
    if !warnings.iter().any(|known| known.what == what && known.subject == subject) {
        warnings.push(Warning { subject, what, detail: detail.to_owned(), pointer });
    }
}
