//! The problem of a text that is not JSON, in words for its author.

use crate::scene::limits::JSON_DEPTH;
use crate::scene::locate;
use crate::scene::problem::{Code, Problem};
use std::ops::Range;

/// Bytes of serde's words that are repeated as they are; those about every key there may be have about 500.
const LONGEST_MESSAGE: usize = 1_024;
/// Levels that the pointer of what is nested too deeply has.
const SHOWN_LEVELS: usize = 8;

/// serde's own words for its first error in a text that is JSON.
pub(super) fn first_problem(text: &[u8], error: &serde_json::Error) -> Problem {
    beyond_limits(text, error).unwrap_or_else(|| {
        let words = match words(error).as_str() {
            "expected value" => "a value of the wrong type".to_owned(),
            words => words.to_owned(),
        };
        at_error(text, error, Code::WrongType, &words)
    })
}

/// A problem at the first byte that is not UTF-8.
pub(super) fn not_utf8(text: &[u8], at: usize) -> Problem {
    let detail = match text {
        [0x1f, 0x8b, ..] => "the scene is compressed with gzip; JSON has to come uncompressed",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "the scene is UTF-16; save it as UTF-8",
        _ => "this byte is not UTF-8; save the scene as UTF-8",
    };
    placed(text, at, Code::InvalidJson, detail)
}

/// The problem where the text stops being readable JSON.
pub(super) fn not_json(text: &[u8], error: &serde_json::Error) -> Problem {
    beyond_limits(text, error).unwrap_or_else(|| {
        let at = locate::offset(text, error.line(), error.column());
        let detail = format!("not valid JSON: {}", explanation(text, at, &words(error)));
        at_error(text, error, Code::InvalidJson, &detail)
    })
}

/// The problem of JSON that is nested too deeply, or has a number that is too large.
fn beyond_limits(text: &[u8], error: &serde_json::Error) -> Option<Problem> {
    let (code, detail) = match words(error).as_str() {
        "recursion limit exceeded" => (
            Code::Limit,
            format!("more than {} levels of arrays and objects, the limit {}", JSON_DEPTH.max, JSON_DEPTH.name),
        ),
        "number out of range" => {
            let at = locate::offset(text, error.line(), error.column());
            let token = excerpt(text, token_around(text, at));
            (Code::OutOfRange, format!("{token} is too large: numbers are 64-bit floats and must be finite"))
        }
        _ => return None,
    };
    let mut problem = at_error(text, error, code, &detail);
    if code == Code::Limit {
        // All the way down would say nothing that line and column do not.
        let end = problem.pointer.match_indices('/').nth(SHOWN_LEVELS).map_or(problem.pointer.len(), |(end, _)| end);
        problem.pointer.truncate(end);
    }
    Some(problem)
}

fn explanation(text: &[u8], at: usize, words: &str) -> String {
    let token = excerpt(text, token_around(text, at));
    let byte = text.get(at).copied().unwrap_or(b' ');
    if text.iter().all(u8::is_ascii_whitespace) {
        return "the text is empty".to_owned();
    }
    if ["nan", "inf", "infinity"].contains(&token.trim_start_matches(['-', '+']).to_ascii_lowercase().as_str()) {
        return format!("{token} is not a JSON number; numbers must be finite");
    }
    if let Some(number) = other_number(token) {
        return format!("{token} is not how JSON writes a number; write {number}");
    }
    match byte {
        b'\'' => return "strings and keys stand between double quotes".to_owned(),
        b'/' | b'#' if words.starts_with("expected") || words.starts_with("key") || words.starts_with("trailing") => {
            return "there are no comments in JSON".to_owned();
        }
        _ => {}
    }
    match words {
        "trailing comma" => "remove the comma before the closing bracket".to_owned(),
        "trailing characters" => "something follows the end of the scene".to_owned(),
        "key must be a string" => "a key stands between double quotes".to_owned(),
        _ if words.starts_with("EOF") => format!("the text ends too early ({words})"),
        _ if ["True", "False", "None"].contains(&token) => format!("write true, false or null, not {token}"),
        _ => words.to_owned(),
    }
}

/// The number that a token is in other languages, but not in JSON: `.5`, `+1`, `5.`, `0x1f`.
fn other_number(token: &str) -> Option<String> {
    if let Some(digits) = token.strip_prefix("0x").or_else(|| token.strip_prefix("0X")) {
        return Some(u32::from_str_radix(digits, 16).ok()?.to_string());
    }
    let is_other = token.starts_with(['+', '.']) || token.starts_with("-.") || token.ends_with('.');
    let number: f64 = token.parse().ok().filter(|number: &f64| is_other && number.is_finite())?;
    Some(number.to_string())
}

/// A problem where serde stopped reading; at the beginning of the word or number it stopped in.
fn at_error(text: &[u8], error: &serde_json::Error, code: Code, detail: &str) -> Problem {
    let at = locate::offset(text, error.line(), error.column());
    placed(text, token_around(text, at).start, code, detail)
}

fn placed(text: &[u8], at: usize, code: Code, detail: &str) -> Problem {
    let (line, column) = locate::place(text, at);
    Problem { line: Some(line), column: Some(column), ..Problem::new(locate::innermost(text, at), code, detail) }
}

/// serde's message without its position. It may quote a value of any length: the end says what is expected instead.
fn words(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let message = message.rfind(" at line ").map_or(message.as_str(), |end| &message[..end]);
    if message.len() <= LONGEST_MESSAGE {
        return message.to_owned();
    }
    let begin: String = message.chars().take(64).collect();
    let end = message.char_indices().rev().nth(255).map_or("", |(at, _)| &message[at..]);
    format!("{begin}…{end}")
}

/// The bare word or number around an offset, at most 40 bytes to either side; empty if there is none.
fn token_around(text: &[u8], at: usize) -> Range<usize> {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.' | b'_');
    let at = at.min(text.len());
    let length = text[at..].iter().take(40).take_while(|byte| is_part(byte)).count();
    if length == 0 {
        return at..at;
    }
    at - text[..at].iter().rev().take(40).take_while(|byte| is_part(byte)).count()..at + length
}

/// Bytes of the text, for a message.
fn excerpt(text: &[u8], range: Range<usize>) -> &str {
    std::str::from_utf8(&text[range]).unwrap_or_default()
}
