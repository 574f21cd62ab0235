//! Broken scenes, and what their authors are told.

use super::*;
use crate::scene::limits::PROBLEMS;
use crate::scene::{Format, Overrides};

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
            "line 5, column 2: /objects/0/spere: no such kind of object \"spere\"; did you mean \"sphere\"? Here kinds are \
                 \"sphere\", \"plane\", \"disc\", \"triangle\", \"quad\", \"box\", \"cylinder\", \"cone\", \"torus\", \"mesh\", \
                 \"polygon\", \"group\", \"instance\" and \"model\" [UnknownKey]",
        ),
        (
            r#"{"sphere": {"center": [0, 0, 0], "radius": 1}, "material": "red"}"#,
            "line 5, column 1: /objects/0: an object has exactly one key, which names its kind; here it is \"sphere\", \
                 so \"material\" must go or move inside it [WrongType]",
        ),
        (
            r#"{"type": "sphere", "center": [0, 0, 0], "radius": 1}"#,
            "line 5, column 1: /objects/0: write {\"sphere\": {...}} around the other keys, in place of \"type\" [WrongType]",
        ),
        (
            r#"{"sphere": {"center": [0, 0, 0], "radius": 1, "material": {"diffuse": 1}}}"#,
            "line 5, column 59: /objects/0/sphere/material: must be a string, is an object; define it in /materials and write \
                 its name [WrongType]",
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
            "line 5, column 47: /objects/0/sphere/radius: this key is given twice in the same object; keep one of the two \
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
            "\"materials\": {\"a/b\": {\"roughness\": 12, \"diffuse\": \"#12345g\"}}",
            "line 7, column 36: /materials/a~1b/roughness: must be at least 0 and at most 1, is 12 [OutOfRange]\n\
                 line 7, column 51: /materials/a~1b/diffuse: \"#12345g\" is no color; write \"#rrggbb\", [r, g, b] or a grey \
                 number [WrongType]",
        ),
        (
            "\"materials\": {\"m\": {\"diffuse\": true}, \"m\": {}}",
            "line 7, column 39: /materials/m: this key is given twice in the same object; keep one of the two [DuplicateName]",
        ),
        (
            "\"materials\": {\"m\": {\"diffuse\": true}}",
            "line 7, column 32: /materials/m/diffuse: must be a number, an array of 3 numbers, \"#rrggbb\" or \
                 an object whose only key names its kind: \"checker\", \"gradient\", \"image\" or \"noise\", is true \
                 [WrongType]",
        ),
        (
            "\"materials\": {\"m\": {\"ambient\": {\"chequer\": {}}}}",
            "line 7, column 33: /materials/m/ambient/chequer: no such kind of pattern \"chequer\"; did you mean \
                 \"checker\"? Here kinds are \"checker\", \"gradient\", \"image\" and \"noise\" [UnknownKey]",
        ),
        (
            "\"materials\": {\"m\": {\"metallic\": 1}}",
            "line 7, column 21: /materials/m/metallic: unknown key \"metallic\"; it is a key of \"pbr\" [UnknownKey]",
        ),
        (
            "\"render\": {\"accuracy\": {\"time\": 200}}",
            "line 7, column 33: /render/accuracy/time: must be {\"ms\": {...}}, is 200; write {\"ms\": 200} [WrongType]",
        ),
        (
            "\"render\": {\"accuracy\": \"time:200\"}",
            "line 7, column 24: /render/accuracy: must be an object whose only key names its kind: \"fixed\", \"proved\", \
                 \"time\", \"rays\" or \"statistical\", is \"time:200\"; write {\"time\": {...}} [WrongType]",
        ),
        (
            "\"lights\": [{\"point\": {\"position\": [0, 0, 0], \"falloff\": \"quadratic\"}}]",
            "line 7, column 57: /lights/0/point/falloff: no such falloff \"quadratic\"; write \"none\", \"inverse_square\", \
                 {\"linear\": {...}} or {\"windowed\": {...}} [WrongType]",
        ),
        (
            "\"render\": {\"accuracy\": {\"guessed\": {\"max_codes\": 1}}, \"shadows\": \"soft\", \"antialias\": \"true\"}",
            "line 7, column 25: /render/accuracy/guessed: no such kind of accuracy mode \"guessed\"; kinds are \"fixed\", \
                 \"proved\", \"time\", \"rays\" and \"statistical\" [UnknownKey]\n\
                 line 7, column 66: /render/shadows: no such shadow mode \"soft\"; write \"opaque\", \"transmissive\" or \
                 \"none\" [WrongType]\n\
                 line 7, column 87: /render/antialias: must be true or false, is \"true\"; write it without quotes [WrongType]",
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
            "{\"version\": 1,\n \"objects\": [.5]}",
            "line 2, column 14: /objects/0: not valid JSON: .5 is not how JSON writes a number; write 0.5 [InvalidJson]",
        ),
        (
            "{\"version\": 1,\n \"objects\": [+1]}",
            "line 2, column 14: /objects/0: not valid JSON: +1 is not how JSON writes a number; write 1 [InvalidJson]",
        ),
        (
            "{\"version\": 1,\n \"objects\": [0x10]}",
            "line 2, column 14: /objects/0: not valid JSON: 0x10 is not how JSON writes a number; write 16 [InvalidJson]",
        ),
        (
            "{\"version\": 1,\n \"objects\": [NaN]}",
            "line 2, column 14: /objects/0: not valid JSON: NaN is not a JSON number; numbers must be finite [InvalidJson]",
        ),
        (
            "{\"objects\": [1, -Infinity]}",
            "line 1, column 17: /objects/1: not valid JSON: -Infinity is not a JSON number; numbers must be finite \
                 [InvalidJson]",
        ),
        (
            "{\"image\": {\"width\": 1e999}}",
            "line 1, column 21: /image/width: 1e999 is too large: numbers are 64-bit floats and must be finite \
                 [OutOfRange]",
        ),
        (
            "{\"objects\": [1,]}",
            "line 1, column 16: /objects/0: not valid JSON: remove the comma before the closing bracket [InvalidJson]",
        ),
        ("{} x", "line 1, column 4: not valid JSON: something follows the end of the scene [InvalidJson]"),
        ("{'a': 1}", "line 1, column 2: not valid JSON: strings and keys stand between double quotes [InvalidJson]"),
        ("// scene\n{}", "line 1, column 1: not valid JSON: there are no comments in JSON [InvalidJson]"),
        (
            "{\"objects\": [",
            "line 1, column 13: /objects: not valid JSON: the text ends too early (EOF while parsing a list) [InvalidJson]",
        ),
        (
            &format!("{{\"name\": {deep}"),
            ": /name/0/0/0/0/0/0/0: more than 127 levels of arrays and objects, the limit json_depth [Limit]",
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
fn long_keys_and_strings_are_not_repeated() {
    let long = "x".repeat(100_000);
    let text = scene(&format!("{{\"{long}\": 1}}, {{\"disc\": \"{long}\"}}, {{\"plane\": {{\"{long}\": 1}}}}"), "");
    let seen = seen(text.as_bytes());
    assert!(seen.len() < 1500 && seen.lines().count() == 4, "{seen}");
}

#[test]
fn reports_up_to_the_limit_of_problems_and_counts_on() {
    let found = |count| Problems(problems(scene(&vec!["1"; count].join(","), "").as_bytes()));
    let some = found(60);
    assert_eq!((some.reported().0.len() as u64, some.reported().1), (PROBLEMS.max, 10));
    assert_eq!((some.count().as_str(), found(2_000).count().as_str()), ("60", "1000 or more"));
}

#[test]
fn names_that_are_too_long_are_one_problem_each() {
    let long = "n".repeat(5_000);
    let ball = format!(r#"{{"sphere": {{"center": [0, 0, 0], "radius": 1, "name": "{long}", "material": "{long}"}}}}"#);
    let more = format!(
        ",\n\"name\": \"{long}\",\n\"materials\": {{\"{long}\": {{\"diffus\": 1, \"ior\": 1e9}}}},\n\
         \"definitions\": {{\"{long}\": []}}"
    );
    let [broken, sound] = [&more, &more.replace("\"diffus\": 1, ", "")].map(|more| {
        let found = crate::scene::load(scene(&ball, more).as_bytes(), Format::Json, &Overrides::default());
        found.unwrap_err().0
    });
    for found in [broken, sound] {
        let pointers: Vec<_> = found.iter().map(|problem| (problem.pointer.as_str(), problem.line)).collect();
        let name = "/objects/0/sphere/name";
        let expected = ["/name", "/materials", "/definitions", name, "/objects/0/sphere/material"];
        assert!(
            expected.iter().all(|place| pointers.iter().filter(|(at, _)| at == place).count() == 1),
            "{pointers:?}"
        );
        assert_eq!(found.len(), 5, "{pointers:?}");
        let at = |place: &str| pointers.iter().find(|(pointer, _)| *pointer == place).and_then(|(_, line)| *line);
        assert_eq!([name, "/name", "/materials", "/definitions"].map(at), [5, 7, 8, 9].map(Some));
        for problem in &found {
            assert!(problem.detail.contains("5000 bytes, over the limit of 256 (name_bytes)"), "{problem}");
            assert!(problem.detail.len() < 200, "{problem}");
        }
    }
    let longest = scene(&ball.replace(&long, &"n".repeat(256)), "");
    assert_eq!(problems(longest.as_bytes()), []);
}

/// A type that is not a scene, with one inside that is checked elsewhere.
#[derive(Debug, PartialEq, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Order {
    /// Not looked at.
    #[schemars(schema_with = "anything")]
    scene: Value,
    /// 0 to 100.
    #[schemars(range(max = 100))]
    priority: Option<u8>,
    #[serde(default)]
    labels: Vec<String>,
}

fn anything(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "$ref": "#/elsewhere" })
}

#[test]
fn other_types_are_read_by_their_own_schema() {
    let read = |text: &str| {
        read_as::<Order>(text.as_bytes(), "order")
            .map_err(|problems| problems.0.iter().map(|p| format!("{p} [{:?}]\n", p.code)).collect::<String>())
    };
    let order = read(r#"{"scene": {"any": []}, "priority": 7}"#).unwrap();
    assert_eq!(order, Order { scene: serde_json::json!({"any": []}), priority: Some(7), labels: Vec::new() });
    for (text, expected) in [
        (
            r#"{"scene": 1, "priority": 300, "labels": [1], "prio": 3}"#,
            "line 1, column 26: /priority: must be at least 0 and at most 100, is 300 [OutOfRange]\n\
             line 1, column 42: /labels/0: must be a string, is 1 [WrongType]\n\
             line 1, column 46: /prio: unknown key \"prio\"; keys here are \"labels\", \"priority\" and \"scene\" [UnknownKey]\n",
        ),
        (r#"{"labels": []}"#, "line 1, column 1: the key \"scene\" is missing [MissingKey]\n"),
        (
            r#"{"scene": 1, "scene": 2}"#,
            "line 1, column 14: /scene: this key is given twice in the same object; keep one of the two [DuplicateName]\n",
        ),
        (
            r#"{"scene": 1,}"#,
            "line 1, column 13: /scene: not valid JSON: remove the comma before the closing bracket [InvalidJson]\n",
        ),
        ("[]", "line 1, column 1: must be an object, is an empty array [WrongType]\n"),
    ] {
        assert_eq!(read(text).unwrap_err(), expected, "{text}");
    }
}
