//! Problems of a scene, in words that tell its author how to fix them.

use super::hashes::{SCHEME, hash_of};
use super::limits::{NAME_BYTES, PROBLEM_BYTES, PROBLEMS, PROBLEMS_FOUND};
use crate::control::{self, Cancelled};
use crate::models::Subject;
use schemars::JsonSchema;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;

/// One thing that is wrong, and where.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "SceneProblem")]
pub struct Problem {
    /// JSON pointer (RFC 6901) of the offending value; empty for the whole document. Files that are not JSON have lines or offsets
    /// instead.
    pub pointer: String,
    /// Stable short name of the kind of problem.
    pub code: Code,
    /// One sentence that says what is wrong and what to do.
    pub detail: String,
    /// Line in the source, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// Column in the source in bytes, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<u32>,
    /// Offset in a binary source, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<u64>,
}

/// Kinds of problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "SceneProblemCode")]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Code {
    InvalidJson,
    InvalidNff,
    /// The file does not follow its format.
    InvalidModel,
    /// The file is of another format.
    OtherFormat,
    WrongType,
    MissingKey,
    UnknownKey,
    DuplicateName,
    OutOfRange,
    /// It needs bytes that are not there.
    OutOfBounds,
    /// A part that a model names is not there.
    MissingPart,
    UnknownReference,
    Cycle,
    Degenerate,
    Limit,
    Unsupported,
    /// Of a model, which is rendered all the same: what is left out since it is not simulated.
    NotSimulated,
    /// Of a model: what is rendered, but not exactly.
    Approximated,
    /// Of a model: what has no picture.
    Skipped,
    /// Of a model: what its file does not say.
    Assumed,
    /// An asset that the scene names has not been sent.
    MissingAsset,
    /// Loading was cancelled. No client reads this.
    Cancelled,
}

impl From<Subject> for Code {
    fn from(subject: Subject) -> Self {
        match subject {
            Subject::NotSimulated => Self::NotSimulated,
            Subject::Approximated => Self::Approximated,
            Subject::Skipped => Self::Skipped,
            Subject::Assumed => Self::Assumed,
        }
    }
}

impl Problem {
    /// A problem at a pointer; line and column are found later, from the source text.
    pub fn new(pointer: impl Into<String>, code: Code, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), code, detail: detail.into(), line: None, column: None, offset: None }
    }

    /// An asset is not there.
    pub fn missing_asset(pointer: impl Into<String>, hash: &str) -> Self {
        Self::new(
            pointer,
            Code::MissingAsset,
            format!(
                "{SCHEME}{hash} is not here: send it to a service with PUT /v1/assets/{hash}; for the command it is a file of that name, {hash}, beside the scene"
            ),
        )
    }

    /// Why a file that a scene names cannot be read. An asset may have been deleted since it was looked for.
    pub(in crate::scene) fn unread(name: &str, why: &str) -> (Code, String) {
        match hash_of(name) {
            Some(_) => (Code::MissingAsset, format!("{name} {why}")),
            None => (Code::UnknownReference, format!("{} {why}", quoted(name))),
        }
    }

    /// The SHA-256 of the asset that is missing.
    pub fn lacks(&self) -> Option<&str> {
        let name = (self.code == Code::MissingAsset).then(|| self.detail.split(' ').next())??;
        hash_of(name)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}")?;
            if let Some(column) = self.column {
                write!(f, ", column {column}")?;
            }
            f.write_str(": ")?;
        }
        if let Some(offset) = self.offset {
            write!(f, "offset {offset}: ")?;
        }
        if !self.pointer.is_empty() {
            write!(f, "{}: ", printable(&self.pointer))?;
        }
        f.write_str(&printable(&self.detail))
    }
}

/// A line of text for a terminal: keys and names of a scene may have characters that control one, or turn the direction of writing.
/// They become escapes such as `\u{1b}`.
pub fn printable(line: &str) -> Cow<'_, str> {
    let controls = |c: char| {
        (c.is_control() && c != '\t') || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    if !line.contains(controls) {
        return Cow::Borrowed(line);
    }
    let mut text = String::with_capacity(line.len() + 16);
    for c in line.chars() {
        if controls(c) { text.extend(c.escape_default()) } else { text.push(c) }
    }
    Cow::Owned(text)
}

/// The problems found in a scene: at least one, and at most a thousand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// A single problem.
    pub fn one(problem: Problem) -> Self {
        Self(vec![problem])
    }

    /// Those that are reported, and how many others were found.
    pub fn reported(&self) -> (&[Problem], usize) {
        let mut bytes = 0;
        let fits = |problem: &&Problem| {
            bytes += problem.pointer.len() + problem.detail.len();
            bytes <= PROBLEM_BYTES
        };
        let count = self.0.iter().take(PROBLEMS.max as usize).take_while(fits).count().max(1).min(self.0.len());
        (&self.0[..count], self.0.len() - count)
    }

    /// Each place with each sentence once.
    pub(in crate::scene) fn each_once(mut self) -> Self {
        let mut known = HashSet::new();
        self.0.retain(|problem| known.insert((problem.pointer.clone(), problem.detail.clone())));
        self
    }

    /// `12`, or `1000 or more`, after which the check stops.
    pub fn count(&self) -> String {
        let more = if self.0.len() >= PROBLEMS_FOUND { " or more" } else { "" };
        format!("{}{more}", self.0.len())
    }
}

/// Stops loading where the work of this thread is to stop ([`Control`](crate::control::Control)).
pub(in crate::scene) fn unless_cancelled() -> Result<(), Problems> {
    match control::look_now() {
        Ok(()) => Ok(()),
        Err(Cancelled) => Err(Problems::one(Problem::new("", Code::Cancelled, "loading was cancelled"))),
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (reported, more) = self.reported();
        for (i, problem) in reported.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{problem}")?;
        }
        if more > 0 {
            write!(f, "\nand {more} more")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// ` did you mean "..."?` with the candidate nearest to `given`, if one is near enough to be a typing error.
pub fn did_you_mean<'a>(given: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(given, candidates).map_or_else(String::new, |candidate| format!("; did you mean \"{candidate}\"?"))
}

/// The candidate nearest to `given`, if one is near enough to be a typing error.
pub fn nearest<'a>(given: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Computing the distance takes quadratic time, and names this long are not typed by hand.
    if given.len() > SHOWN {
        return None;
    }
    let near = candidates
        .into_iter()
        .take(CANDIDATES)
        .filter(|candidate| candidate.len() <= SHOWN)
        .map(|candidate| (strsim::damerau_levenshtein(given, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().min(given.len()) / 4)
        .min_by_key(|(distance, _)| *distance);
    near.map(|(_, candidate)| candidate)
}

/// Names that a suggestion is looked for among, at about 10 microseconds each.
const CANDIDATES: usize = 1_000;

/// Longest name that suggestions are made for, in bytes, and letters of a text that are shown.
const SHOWN: usize = 64;

/// A text of the scene between quotes, its beginning if it is long.
pub fn quoted(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}", format!("{}…", &text[..end])),
        None => format!("{text:?}"),
    }
}

/// That a name is longer than [`NAME_BYTES`].
pub(in crate::scene) fn name_too_long(name: &str) -> Option<String> {
    (name.len() as u64 > NAME_BYTES.max).then(|| {
        let (limit, max) = (NAME_BYTES.name, NAME_BYTES.max);
        format!("the name {} has {} bytes, over the limit of {max} ({limit}): shorten it", quoted(name), name.len())
    })
}

/// Appends one reference token to a JSON pointer, escaped (RFC 6901 section 3).
pub fn push_token(pointer: &str, token: impl fmt::Display) -> String {
    let token = token.to_string();
    if token.contains(['~', '/']) {
        format!("{pointer}/{}", token.replace('~', "~0").replace('/', "~1"))
    } else {
        format!("{pointer}/{token}")
    }
}
