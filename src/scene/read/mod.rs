//! JSON text to [`Description`] and other types, reporting every problem of its shape at once.
//!
//! A correct scene is deserialised straight from the text. Only when that fails, the text is read again into a [`Value`],
//! and `diagnose` reports all its problems.

mod diagnose;
mod mend;
mod syntax;
mod wording;

use super::limits::{PROBLEMS_FOUND, SCENE_BYTES};
use super::problem::{Code, Problem, unless_cancelled};
use super::schema::{schema, schema_of};
use super::{Description, Problems, locate};
use crate::strict_json;
use diagnose::{Finding, diagnose};
use schemars::JsonSchema;
use serde::de::{Deserialize, IgnoredAny};
use serde_json::Value;
use syntax::{first_problem, not_json, not_utf8};

pub use mend::Mended;

/// Longest text of which all problems are reported, since a [`Value`] takes up to 16 times the bytes of its text. Of a
/// longer one only the first problem is reported.
const DIAGNOSED_BYTES: usize = 8 << 20;

/// The version this program reads.
const VERSION: u32 = 1;

/// Why a text is not a scene.
#[derive(Debug)]
pub struct Unreadable {
    /// Its problems in the order of the text, with line and column.
    pub problems: Problems,
    /// The readable rest of it, to be checked further; none if it is not JSON, or of another version.
    pub mended: Option<Box<Mended>>,
}

impl Unreadable {
    fn one(problem: Problem) -> Self {
        Self { problems: Problems::one(problem), mended: None }
    }
}

/// Reads scene JSON and checks its shape completely. If the shape is right, ranges and references are left to be checked.
pub fn read_json(text: &[u8]) -> Result<Description, Unreadable> {
    if text.len() as u64 > SCENE_BYTES.max {
        let detail =
            format!("the scene has {} bytes, above the limit {} = {}", text.len(), SCENE_BYTES.name, SCENE_BYTES.max);
        return Err(Unreadable::one(Problem::new("", Code::Limit, detail)));
    }
    // RFC 8259 lets a reader ignore a byte order mark, and some editors insist on writing one.
    let text = strip_mark(text);
    if let Err(error) = std::str::from_utf8(text) {
        return Err(Unreadable::one(not_utf8(text, error.valid_up_to())));
    }
    let error = match strict_json::from_slice::<Description>(text) {
        Ok(description) if description.version == VERSION => return Ok(description),
        Ok(description) => return Err(Unreadable::one(wrong_version(text, &description.version.to_string()))),
        Err(error) => error,
    };
    unless_cancelled().map_err(|problems| Unreadable { problems, mended: None })?;
    match value(text, &error) {
        Ok(scene) => Err(all_problems(text, scene, &error)),
        Err(problem) => Err(Unreadable::one(problem)),
    }
}

/// Reads JSON as another type, and checks its shape completely by the schema of that type. `name` is what it is.
pub fn read_as<'a, T: Deserialize<'a> + JsonSchema>(text: &'a [u8], name: &str) -> Result<T, Problems> {
    let text = strip_mark(text);
    strict_json::from_slice(text).map_err(|error| {
        let found = value(text, &error)
            .map(|value| problems(text, &diagnose(schema_of::<T>().as_value(), name, &value), &error));
        Problems(found.unwrap_or_else(|problem| vec![problem]))
    })
}

/// The value of a text that serde has refused, or its only problem if there is none, or if it is too long.
fn value(text: &[u8], error: &serde_json::Error) -> Result<Value, Problem> {
    if text.len() > DIAGNOSED_BYTES {
        return Err(match serde_json::from_slice::<IgnoredAny>(text) {
            Ok(_) => first_problem(text, error),
            Err(error) => not_json(text, &error),
        });
    }
    // serde's first error does not say whether the text is JSON: a number instead of an object is a syntax error to
    // enums.
    serde_json::from_slice(text).map_err(|error| not_json(text, &error))
}

/// Problems in the order of the text; if none was found, the one that serde has found.
fn problems(text: &[u8], findings: &[Finding], error: &serde_json::Error) -> Vec<Problem> {
    let mut problems: Vec<Problem> = findings.iter().map(|finding| finding.problem.clone()).collect();
    locate::locate(text, &mut problems);
    problems.extend(locate::duplicate_keys(text));
    if problems.is_empty() {
        problems.push(first_problem(text, error));
    }
    problems.sort_by_key(|problem| (problem.line, problem.column));
    problems.truncate(PROBLEMS_FOUND);
    problems
}

/// The text without a byte order mark.
pub(super) fn strip_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

fn all_problems(text: &[u8], scene: Value, error: &serde_json::Error) -> Unreadable {
    // In another version keys may have another meaning.
    if let Some(version) = scene.get("version").filter(|v| v.is_number() && v.as_u64() != Some(u64::from(VERSION))) {
        return Unreadable::one(wrong_version(text, &version.to_string()));
    }
    let findings = diagnose(schema(), "scene", &scene);
    let problems = Problems(problems(text, &findings, error));
    Unreadable { problems, mended: mend::mend(scene, &findings).map(Box::new) }
}

fn wrong_version(text: &[u8], version: &str) -> Problem {
    let detail = format!("this is scene format version {version}, and this program reads version {VERSION}");
    let mut problem = [Problem::new("/version", Code::Unsupported, detail)];
    locate::locate(text, &mut problem);
    let [problem] = problem;
    problem
}

#[cfg(test)]
mod agreement_tests;
#[cfg(test)]
mod tests;
