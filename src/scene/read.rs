//! JSON text to [`Description`], reporting every problem of its shape at once.
//!
//! A good scene is deserialised straight from the text. Only when that fails is the text read again, into a
//! [`Value`], for [`diagnose`] to say all that is wrong with it.

use super::diagnose::diagnose;
use super::limits::{JSON_DEPTH, PROBLEMS, SCENE_BYTES};
use super::locate;
use super::mend::{Mended, mend};
use super::problem::{Code, Problem};
use super::{Description, Problems};
use serde::de::IgnoredAny;
use serde_json::Value;

/// Longest text of which all problems are reported. A [`Value`] takes up to 16 times the bytes of its text, so of a
/// longer one only the first problem is.
const DIAGNOSED_BYTES: usize = 32 << 20;

/// The version this program reads.
const VERSION: u32 = 1;

/// Why a text is no scene.
#[derive(Debug)]
pub struct Unreadable {
    /// What is wrong with it, in the order of the text, with line and column.
    pub problems: Problems,
    /// What is right in it, to check further; none if it is no JSON, or of another version.
    pub mended: Option<Box<Mended>>,
}

impl Unreadable {
    fn one(problem: Problem) -> Self {
        Self { problems: Problems::one(problem), mended: None }
    }
}

/// Reads scene JSON: the shape is checked completely, ranges and references are not if the shape is right.
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
    let error = match serde_json::from_slice::<Description>(text) {
        Ok(description) if description.version == VERSION => return Ok(description),
        Ok(description) => return Err(Unreadable::one(wrong_version(text, &description.version.to_string()))),
        Err(error) => error,
    };
    if text.len() > DIAGNOSED_BYTES {
        let problem = match serde_json::from_slice::<IgnoredAny>(text) {
            Ok(_) => first_problem(text, &error),
            Err(error) => not_json(text, &error),
        };
        return Err(Unreadable::one(problem));
    }
    // The category of the first error does not tell whether this is JSON: a number in the place of an object is a
    // syntax error to serde_json's enums.
    match serde_json::from_slice::<Value>(text) {
        Ok(scene) => Err(all_problems(text, scene, &error)),
        Err(error) => Err(Unreadable::one(not_json(text, &error))),
    }
}

/// The text without a byte order mark.
pub(super) fn strip_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

fn all_problems(text: &[u8], scene: Value, error: &serde_json::Error) -> Unreadable {
    // What another version means by its keys is not for this one to say.
    if let Some(version) = scene.get("version").filter(|v| v.is_number() && v.as_u64() != Some(u64::from(VERSION))) {
        return Unreadable::one(wrong_version(text, &version.to_string()));
    }
    let findings = diagnose(&scene);
    let mut problems: Vec<Problem> = findings.iter().map(|finding| finding.problem.clone()).collect();
    locate::locate(text, &mut problems);
    problems.extend(locate::duplicate_keys(text));
    if problems.is_empty() {
        problems.push(first_problem(text, error));
    }
    problems.sort_by_key(|problem| (problem.line, problem.column));
    problems.truncate(PROBLEMS.max as usize);
    Unreadable { problems: Problems(problems), mended: mend(scene, &findings).map(Box::new) }
}

fn wrong_version(text: &[u8], version: &str) -> Problem {
    let detail = format!("this is scene format version {version}, and this program reads version {VERSION}");
    let mut problem = [Problem::new("/version", Code::Unsupported, detail)];
    locate::locate(text, &mut problem);
    let [problem] = problem;
    problem
}

/// serde's own words for its first error in what is JSON.
fn first_problem(text: &[u8], error: &serde_json::Error) -> Problem {
    beyond_limits(text, error).unwrap_or_else(|| {
        let words = match words(error).as_str() {
            "expected value" => "a value of the wrong type".to_owned(),
            words => words.to_owned(),
        };
        at_error(text, error, Code::WrongType, &words)
    })
}

fn not_utf8(text: &[u8], at: usize) -> Problem {
    let detail = match text {
        [0x1f, 0x8b, ..] => "the scene is compressed with gzip; JSON has to come uncompressed",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "the scene is UTF-16; save it as UTF-8",
        _ => "this byte is not UTF-8; save the scene as UTF-8",
    };
    placed(text, at, Code::InvalidJson, detail)
}

fn not_json(text: &[u8], error: &serde_json::Error) -> Problem {
    beyond_limits(text, error).unwrap_or_else(|| {
        let at = locate::offset(text, error.line(), error.column());
        let detail = format!("not valid JSON: {}", explanation(text, at, token_around(text, at), &words(error)));
        at_error(text, error, Code::InvalidJson, &detail)
    })
}

/// JSON that nests deeper or counts higher than can be read.
fn beyond_limits(text: &[u8], error: &serde_json::Error) -> Option<Problem> {
    let (code, detail) = match words(error).as_str() {
        "recursion limit exceeded" => (
            Code::Limit,
            format!("more than {} levels of arrays and objects, the limit {}", JSON_DEPTH.max, JSON_DEPTH.name),
        ),
        "number out of range" => {
            let token = token_around(text, locate::offset(text, error.line(), error.column()));
            (Code::OutOfRange, format!("{token} is too large: numbers are 64-bit floats and must be finite"))
        }
        _ => return None,
    };
    Some(at_error(text, error, code, &detail))
}

fn explanation(text: &[u8], at: usize, token: &str, words: &str) -> String {
    let byte = text.get(at).copied().unwrap_or(b' ');
    if text.iter().all(u8::is_ascii_whitespace) {
        return "the text is empty".to_owned();
    }
    if ["nan", "inf", "infinity"].contains(&token.trim_start_matches(['-', '+']).to_ascii_lowercase().as_str()) {
        return format!("{token} is not a JSON number; numbers must be finite");
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

/// A problem where serde stopped reading.
fn at_error(text: &[u8], error: &serde_json::Error, code: Code, detail: &str) -> Problem {
    placed(text, locate::offset(text, error.line(), error.column()), code, detail)
}

fn placed(text: &[u8], at: usize, code: Code, detail: &str) -> Problem {
    let (line, column) = locate::place(text, at);
    Problem { line: Some(line), column: Some(column), ..Problem::new(locate::innermost(text, at), code, detail) }
}

/// serde's message without its position.
fn words(error: &serde_json::Error) -> String {
    let message = error.to_string();
    match message.rfind(" at line ") {
        Some(end) => message[..end].to_owned(),
        None => message,
    }
}

/// The bare word or number around an offset, at most 40 bytes of it.
fn token_around(text: &[u8], at: usize) -> &str {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.' | b'_');
    let at = at.min(text.len());
    let start = at - text[..at].iter().rev().take(40).take_while(|byte| is_part(byte)).count();
    let length = text[start..].iter().take(40).take_while(|byte| is_part(byte)).count();
    std::str::from_utf8(&text[start..start + length]).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene around one object and more top-level keys, on known lines.
    fn scene(object: &str, more: &str) -> String {
        format!(
            "{{\n\"version\": 1,\n\"camera\": {{\"pinhole\": {{\"eye\": [0, 0, 5], \"look_at\": [0, 0, 0]}}}},\n\
             \"objects\": [\n{object}\n]{more}\n}}"
        )
    }

    fn problems(text: &[u8]) -> Vec<Problem> {
        read_json(text).map_or_else(|unreadable| unreadable.problems.0, |_| Vec::new())
    }

    fn seen(text: &[u8]) -> String {
        problems(text).iter().map(|p| format!("{p} [{:?}]\n", p.code)).collect()
    }

    #[test]
    fn reads_a_scene() {
        let ball = r#"{"sphere": {"center": [0, 0, 0], "radius": 1}}"#;
        assert_eq!(read_json(scene(ball, "").as_bytes()).unwrap().objects.len(), 1);
        assert!(read_json(format!("\u{feff}{}", scene(ball, "")).as_bytes()).is_ok());
    }

    #[test]
    fn broken_objects() {
        // The object stands on line 5, from column 1.
        for (object, expected) in [
            (
                r#"{"sphere": {"center": [0, 0, 0], "radus": 1}}"#,
                "line 5, column 34: /objects/0/sphere/radus: unknown key \"radus\"; did you mean \"radius\"? [UnknownKey]",
            ),
            (
                r#"{"sphere": {"center": [0, 0, 0]}}"#,
                "line 5, column 12: /objects/0/sphere: the key \"radius\" is missing [MissingKey]",
            ),
            (
                r#"{"sphere": {}}"#,
                "line 5, column 12: /objects/0/sphere: the keys \"center\" and \"radius\" are missing [MissingKey]",
            ),
            (
                r#"{"sphere": {"center": [0, 0], "radius": -1}}"#,
                "line 5, column 23: /objects/0/sphere/center: must be an array of 3 numbers, has 2 [WrongType]\n\
                 line 5, column 41: /objects/0/sphere/radius: must be above 0, is -1 [OutOfRange]",
            ),
            (
                r#"{"sphere": {"center": [0, "0", null], "radius": "1"}}"#,
                "line 5, column 27: /objects/0/sphere/center/1: must be a number, is \"0\"; write it without quotes [WrongType]\n\
                 line 5, column 32: /objects/0/sphere/center/2: must be a number, is null [WrongType]\n\
                 line 5, column 49: /objects/0/sphere/radius: must be a number, is \"1\"; write it without quotes [WrongType]",
            ),
            (
                r#"{"spere": {"center": [0, 0, 0], "radius": 1}}"#,
                "line 5, column 2: /objects/0/spere: no such kind of object \"spere\"; did you mean \"sphere\"? Kinds are \
                 \"sphere\", \"plane\", \"disc\", \"triangle\", \"quad\", \"box\", \"cylinder\", \"cone\", \"torus\", \"mesh\", \
                 \"polygon\", \"group\" and \"instance\" [UnknownKey]",
            ),
            (
                r#"{"sphere": {"center": [0, 0, 0], "radius": 1}, "material": "red"}"#,
                "line 5, column 1: /objects/0: an object has exactly one key, which names its kind; here it is \"sphere\", \
                 so \"material\" must go or move inside it [WrongType]",
            ),
            (
                r#""sphere""#,
                "line 5, column 1: /objects/0: \"sphere\" needs its keys: write {\"sphere\": {...}} [WrongType]",
            ),
            (
                r#"{"mesh": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, -2], [0, 1, 2.0]]}}"#,
                "line 5, column 75: /objects/0/mesh/faces/0/2: must be at least 0 and at most 4294967295, is -2 [OutOfRange]\n\
                 line 5, column 87: /objects/0/mesh/faces/1/2: must be a whole number, is 2.0; write it without decimal \
                 point and exponent [WrongType]",
            ),
            (
                r#"{"sphere": {"center": [0, 0, 0], "radius": 1, "radius": 2}}"#,
                "line 5, column 47: /objects/0/sphere/radius: \"radius\" is given twice in the same object; keep one of them \
                 [DuplicateName]",
            ),
            (
                r#"{"group": {"objects": [{"group": {"objects": [{"disc": 1}]}}]}}"#,
                "line 5, column 56: /objects/0/group/objects/0/group/objects/0/disc: must be an object, is 1 [WrongType]",
            ),
        ] {
            assert_eq!(seen(scene(object, "").as_bytes()).trim_end(), expected, "{object}");
        }
    }

    #[test]
    fn broken_rest() {
        // The rest begins on line 7.
        for (rest, expected) in [
            (
                "\"image\": {\"width\": 0, \"hight\": 3}",
                "line 7, column 20: /image/width: must be at least 1 and at most 16384, is 0 [OutOfRange]\n\
                 line 7, column 23: /image/hight: unknown key \"hight\"; did you mean \"height\"? [UnknownKey]",
            ),
            (
                "\"materials\": {\"a/b\": {\"fresnel\": true, \"diffuse\": \"#12345g\"}}",
                "line 7, column 23: /materials/a~1b/fresnel: \"fresnel\" is not available in this version; remove it [Unsupported]\n\
                 line 7, column 51: /materials/a~1b/diffuse: \"#12345g\" is no colour; write \"#rrggbb\", [r, g, b] or a grey \
                 number [WrongType]",
            ),
            (
                "\"materials\": {\"m\": {\"diffuse\": true}, \"m\": {}}",
                "line 7, column 39: /materials/m: \"m\" is given twice in the same object; keep one of them [DuplicateName]",
            ),
            (
                "\"materials\": {\"m\": {\"diffuse\": true}}",
                "line 7, column 32: /materials/m/diffuse: must be a number, an array of 3 numbers, \"#rrggbb\" or \
                 {\"checker\": {...}}, is true [WrongType]",
            ),
            (
                "\"materials\": {\"m\": {\"ambient\": {\"chequer\": {}}}}",
                "line 7, column 33: /materials/m/ambient/chequer: no such kind of pattern \"chequer\"; did you mean \
                 \"checker\"? Kinds are \"checker\" [UnknownKey]",
            ),
            (
                "\"lights\": [{\"point\": {\"position\": [0, 0, 0], \"falloff\": \"quadratic\"}}]",
                "line 7, column 57: /lights/0/point/falloff: no such falloff \"quadratic\"; write \"none\", \"inverse_square\" or \
                 {\"linear\": {...}} [WrongType]",
            ),
            (
                "\"render\": {\"accuracy\": {\"proved\": {\"max_codes\": 1}}, \"shadows\": \"soft\", \"antialias\": \"true\"}",
                "line 7, column 25: /render/accuracy/proved: the accuracy mode \"proved\" is not available in this version; there \
                 is \"fixed\" [Unsupported]\n\
                 line 7, column 65: /render/shadows: no such shadow mode \"soft\"; write \"opaque\", \"transmissive\" or \
                 \"none\" [WrongType]\n\
                 line 7, column 86: /render/antialias: must be true or false, is \"true\"; write it without quotes [WrongType]",
            ),
        ] {
            let ball = r#"{"sphere": {"center": [0, 0, 0], "radius": 1}}"#;
            let text = scene(ball, &format!(",\n{rest}"));
            assert_eq!(seen(text.as_bytes()).trim_end(), expected, "{rest}");
        }
    }

    #[test]
    fn broken_documents() {
        let deep = "[".repeat(128);
        for (text, expected) in [
            ("", "line 1, column 1: not valid JSON: the text is empty [InvalidJson]"),
            ("[]", "line 1, column 1: must be an object, is an empty array [WrongType]"),
            ("{}", "line 1, column 1: the keys \"version\", \"camera\" and \"objects\" are missing [MissingKey]"),
            (
                "{\"version\": 2, \"scene\": {}}",
                "line 1, column 2: /version: this is scene format version 2, and this program reads version 1 [Unsupported]",
            ),
            (
                "{\"version\": 1,\n \"objects\": [NaN]}",
                "line 2, column 14: /objects/0: not valid JSON: NaN is not a JSON number; numbers must be finite [InvalidJson]",
            ),
            (
                "{\"objects\": [1, -Infinity]}",
                "line 1, column 18: /objects/1: not valid JSON: -Infinity is not a JSON number; numbers must be finite \
                 [InvalidJson]",
            ),
            (
                "{\"image\": {\"width\": 1e999}}",
                "line 1, column 26: /image/width: 1e999 is too large: numbers are 64-bit floats and must be finite \
                 [OutOfRange]",
            ),
            (
                "{\"objects\": [1,]}",
                "line 1, column 16: /objects/0: not valid JSON: remove the comma before the closing bracket [InvalidJson]",
            ),
            ("{} x", "line 1, column 4: not valid JSON: something follows the end of the scene [InvalidJson]"),
            (
                "{'a': 1}",
                "line 1, column 2: not valid JSON: strings and keys stand between double quotes [InvalidJson]",
            ),
            ("// scene\n{}", "line 1, column 1: not valid JSON: there are no comments in JSON [InvalidJson]"),
            (
                "{\"objects\": [",
                "line 1, column 13: /objects: not valid JSON: the text ends too early (EOF while parsing a list) [InvalidJson]",
            ),
            (
                &format!("{{\"name\": {deep}"),
                "more than 127 levels of arrays and objects, the limit json_depth [Limit]",
            ),
        ] {
            let seen = seen(text.as_bytes());
            assert!(seen.trim_end().ends_with(expected), "{text}: {seen}");
        }
        assert!(seen(b"{\"name\": \"\xff\"}").starts_with("line 1, column 11: /name: this byte is not UTF-8"));
        assert!(seen(b"\x1f\x8b\x08").contains("gzip"));
        assert!(seen(b"\xff\xfe{\0").contains("UTF-16"));
    }

    #[test]
    fn stops_at_the_limit_of_problems() {
        let text = scene(&vec!["1"; 1000].join(","), "");
        assert_eq!(problems(text.as_bytes()).len() as u64, PROBLEMS.max);
    }
}
