//! Everything that is wrong with the shape of a scene, said in sentences.
//!
//! serde stops at the first error. So when it fails, the scene's [`Value`] is held against the [`schema`], branch by
//! branch: where the schema offers alternatives, the scene's own key or the type of its value names the one that is
//! meant, and the problems keep their precise pointers. (A general validator lists what is wrong with every
//! alternative, thirteen for each misspelt object, and takes memory for all of them before it reports one.)
//! The tests check against the `jsonschema` crate that both refuse the same scenes.

use super::limits::PROBLEMS;
use super::problem::{Code, Problem, did_you_mean, push_token};
use super::schema::schema;
use super::wording::{self, list, quoted};
use serde_json::{Map, Value};
use std::rc::Rc;

/// One problem, and what has to happen to the scene so that the rest of it can be checked.
#[derive(Debug)]
pub(super) struct Finding {
    pub(super) problem: Problem,
    pub(super) mend: Mend,
}

/// What makes a scene readable again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Mend {
    /// Nothing: the value is out of range, but readable.
    Keep,
    /// Remove a key.
    Remove { object: String, key: String },
    /// Put a stand-in in the place of the part around it.
    Replace(Rc<Part>),
}

/// A part of a scene that can be replaced as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) pointer: String,
    /// Name of its schema, or its key.
    pub(super) kind: String,
}

/// Keys of the scene format that this version does not have yet, by schema.
const LATER: &[(&str, &[&str])] = &[
    ("Material", &["fresnel", "absorption", "emission", "roughness"]),
    ("PointLight", &["area"]),
    ("DirectionalLight", &["area"]),
    ("SpotLight", &["area"]),
    ("Accuracy", &["proved", "time", "rays"]),
];

/// All problems of shape and range, at most [`PROBLEMS`].
pub(super) fn diagnose(scene: &Value) -> Vec<Finding> {
    let root = schema();
    let whole = Rc::new(Part { pointer: String::new(), kind: "scene".to_owned() });
    let mut walk = Walk { root, found: Vec::new(), path: String::new(), part: whole };
    walk.visit(Node { schema: root, name: "scene" }, scene);
    walk.found
}

/// A schema and the name it goes by: that of the nearest definition around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<'s> {
    pub(super) schema: &'s Value,
    pub(super) name: &'s str,
}

impl<'s> Node<'s> {
    /// Follows references.
    pub(super) fn resolve(self, root: &'s Value) -> Self {
        let mut node = self;
        while let Some(name) = node.schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            node = Node { schema: &root["$defs"][name], name };
        }
        node
    }

    /// The schemas one of which has to fit, without alternatives of alternatives; just this one if there is no choice.
    pub(super) fn alternatives(self, root: &'s Value) -> Vec<Self> {
        let node = self.resolve(root);
        match node.schema["oneOf"].as_array().or_else(|| node.schema["anyOf"].as_array()) {
            None => vec![node],
            Some(choices) => {
                choices.iter().flat_map(|schema| Node { schema, name: node.name }.alternatives(root)).collect()
            }
        }
    }

    /// The key of an alternative that is an object with just this key.
    pub(super) fn tag(self) -> Option<&'s str> {
        match self.schema["required"].as_array().map(Vec::as_slice) {
            Some([tag]) if self.schema["properties"].as_object().is_some_and(|keys| keys.len() == 1) => tag.as_str(),
            _ => None,
        }
    }

    /// The strings it allows, if it lists them.
    pub(super) fn words(self) -> Vec<&'s str> {
        let listed = self.schema["enum"].as_array().map_or(&[][..], Vec::as_slice);
        listed.iter().chain(self.schema.get("const")).filter_map(Value::as_str).collect()
    }

    /// Its JSON types.
    pub(super) fn types(self) -> Vec<&'s str> {
        match &self.schema["type"] {
            Value::Array(types) => types.iter().filter_map(Value::as_str).collect(),
            name => name.as_str().into_iter().collect(),
        }
    }

    fn takes(self, value: &Value) -> bool {
        self.types().iter().any(|name| match *name {
            "null" => value.is_null(),
            "boolean" => value.is_boolean(),
            "number" => value.is_number(),
            // As serde has it: 5.0 is no integer.
            "integer" => value.is_i64() || value.is_u64(),
            "string" => value.is_string(),
            "array" => value.is_array(),
            _ => value.is_object(),
        })
    }
}

struct Walk<'s> {
    root: &'s Value,
    found: Vec<Finding>,
    /// Pointer of the value at hand.
    path: String,
    /// The innermost part around it.
    part: Rc<Part>,
}

impl<'s> Walk<'s> {
    fn full(&self) -> bool {
        self.found.len() as u64 >= PROBLEMS.max
    }

    fn add(&mut self, pointer: String, code: Code, detail: String, mend: Mend) {
        if !self.full() {
            self.found.push(Finding { problem: Problem::new(pointer, code, detail), mend });
        }
    }

    /// Reports the value at hand, which makes the part around it unreadable.
    fn unreadable(&mut self, code: Code, detail: String) {
        let mend = self.replace_part();
        self.add(self.path.clone(), code, detail, mend);
    }

    fn replace_part(&self) -> Mend {
        Mend::Replace(Rc::clone(&self.part))
    }

    fn visit(&mut self, node: Node<'s>, value: &Value) {
        let is_whole = node.schema.get("$ref").is_some();
        let node = node.resolve(self.root);
        let outer = Rc::clone(&self.part);
        if is_whole && matches!(node.name, "Object" | "Light" | "Material" | "Camera") {
            self.enter_part(node.name);
        }
        let alternatives = node.alternatives(self.root);
        match alternatives.as_slice() {
            [only] if only.tag().is_none() => self.check(*only, value),
            _ => self.choose(node, &alternatives, value),
        }
        self.part = outer;
    }

    fn enter_part(&mut self, kind: &str) {
        self.part = Rc::new(Part { pointer: self.path.clone(), kind: kind.to_owned() });
    }

    fn visit_child(&mut self, token: impl std::fmt::Display, node: Node<'s>, value: &Value) {
        if self.full() {
            return;
        }
        let length = self.path.len();
        let outer = Rc::clone(&self.part);
        let path = push_token(&self.path, &token);
        let at_top = length == 0;
        let in_definitions = self.path == "/definitions";
        self.path = path;
        if at_top {
            self.enter_part(&token.to_string());
        } else if in_definitions {
            self.enter_part("Definition");
        }
        self.visit(node, value);
        self.part = outer;
        self.path.truncate(length);
    }

    fn choose(&mut self, node: Node<'s>, alternatives: &[Node<'s>], value: &Value) {
        let fitting = alternatives.iter().filter(|choice| choice.takes(value));
        match value {
            Value::Object(object) => {
                let kinds: Vec<(&str, Node<'s>)> =
                    fitting.clone().filter_map(|choice| Some((choice.tag()?, *choice))).collect();
                if !kinds.is_empty() {
                    return self.check_kind(node, &kinds, object);
                }
            }
            Value::String(word) => {
                let words: Vec<&str> = alternatives.iter().flat_map(|choice| choice.words()).collect();
                if words.contains(&word.as_str()) {
                    return;
                }
                let kinds = alternatives.iter().filter_map(|choice| choice.tag());
                if let Some(kind) = kinds.clone().find(|kind| kind == word) {
                    let detail = format!("\"{kind}\" needs its keys: write {{\"{kind}\": {{...}}}}");
                    return self.unreadable(Code::WrongType, detail);
                }
                if !words.is_empty() {
                    let detail = format!(
                        "no such {} {}{}; write {}",
                        wording::noun(node.name),
                        wording::shown(value),
                        did_you_mean(word, words.iter().copied().chain(kinds)),
                        wording::expected(node, self.root),
                    );
                    return self.unreadable(Code::WrongType, detail);
                }
            }
            _ => {}
        }
        match fitting.clone().next() {
            Some(choice) => self.check(*choice, value),
            None => self.wrong_type(node, value),
        }
    }

    /// An object whose only key names what it is.
    fn check_kind(&mut self, node: Node<'s>, kinds: &[(&'s str, Node<'s>)], object: &Map<String, Value>) {
        // A kind may be written as the alternative of a type within a type (`Diffuse` or null).
        let name = kinds.first().map_or(node.name, |(_, choice)| choice.name);
        let noun = wording::noun(name);
        let all = || list(kinds.iter().map(|(kind, _)| quoted(kind)), "and");
        let known: Vec<&str> = kinds.iter().map(|(kind, _)| *kind).filter(|kind| object.contains_key(*kind)).collect();
        match (object.iter().next(), object.len(), known.as_slice()) {
            (Some((key, value)), 1, _) => {
                if let Some((_, choice)) = kinds.iter().find(|(kind, _)| kind == key) {
                    let inner = Node { schema: &choice.schema["properties"][key.as_str()], name };
                    self.visit_child(key, inner, value);
                    return;
                }
                let pointer = push_token(&self.path, key);
                let mend = self.replace_part();
                if is_later(name, key) {
                    let detail = format!("the {noun} \"{key}\" is not available in this version; there is {}", all());
                    return self.add(pointer, Code::Unsupported, detail, mend);
                }
                let near = did_you_mean(key, kinds.iter().map(|(kind, _)| *kind));
                let near = if near.is_empty() { ";".to_owned() } else { near };
                let detail = format!("no such kind of {noun} \"{key}\"{near} Kinds are {}", all());
                self.add(pointer, Code::UnknownKey, detail, mend);
            }
            (_, count, [kind]) if count > 1 => {
                let others = list(object.keys().filter(|key| key != kind).map(|key| quoted(key)), "and");
                let detail = format!(
                    "{} {noun} has exactly one key, which names its kind; here it is \"{kind}\", so {others} must go \
                     or move inside it",
                    wording::article(noun),
                );
                self.unreadable(Code::WrongType, detail);
            }
            (_, count, _) => {
                let has = if count == 0 {
                    "it has none".to_owned()
                } else {
                    format!("it has {}", list(object.keys().take(5).map(|key| quoted(key)), "and"))
                };
                let detail = format!(
                    "{} {noun} has exactly one key, which names its kind, and {has}; kinds are {}",
                    wording::article(noun),
                    all()
                );
                self.unreadable(Code::WrongType, detail);
            }
        }
    }

    /// Checks against a schema without choices.
    fn check(&mut self, node: Node<'s>, value: &Value) {
        if !node.takes(value) {
            return self.wrong_type(node, value);
        }
        match value {
            Value::Object(object) => self.check_object(node, object),
            Value::Array(elements) => self.check_array(node, elements),
            Value::Number(_) => {
                if let Some(detail) = wording::out_of_range(node, value) {
                    let readable = !node.types().contains(&"integer") || value.as_u64().is_some_and(fits_u32);
                    if readable {
                        self.add(self.path.clone(), Code::OutOfRange, detail, Mend::Keep);
                    } else {
                        self.unreadable(Code::OutOfRange, detail);
                    }
                }
            }
            Value::String(word) => {
                let words = node.words();
                if !words.is_empty() && !words.contains(&word.as_str()) {
                    let near = did_you_mean(word, words.iter().copied());
                    let detail =
                        format!("must be {}, is {}{near}", wording::expected(node, self.root), wording::shown(value));
                    self.unreadable(Code::WrongType, detail);
                } else if node.schema.get("pattern").is_some() && super::color::Color::from_hex(word).is_none() {
                    let shown = wording::shown(value);
                    let detail = format!("{shown} is no colour; write \"#rrggbb\", [r, g, b] or a grey number");
                    self.unreadable(Code::WrongType, detail);
                }
            }
            Value::Null | Value::Bool(_) => {}
        }
    }

    fn check_object(&mut self, node: Node<'s>, object: &Map<String, Value>) {
        let keys = node.schema["properties"].as_object();
        let rest = &node.schema["additionalProperties"];
        let required = node.schema["required"].as_array().map_or(&[][..], Vec::as_slice);
        let mut missing: Vec<&str> =
            required.iter().filter_map(Value::as_str).filter(|key| !object.contains_key(*key)).collect();
        let complete = missing.is_empty();
        for (key, value) in object {
            if let Some(schema) = keys.and_then(|keys| keys.get(key)) {
                self.visit_child(key, Node { schema, name: node.name }, value);
            } else if rest.is_object() {
                self.visit_child(key, Node { schema: rest, name: node.name }, value);
            } else {
                let names = || keys.into_iter().flat_map(Map::keys).map(String::as_str);
                // One slip of the finger is one problem: not unknown here and missing there.
                let meant = missing.iter().position(|name| !did_you_mean(key, [*name]).is_empty());
                let near = match meant {
                    Some(i) => did_you_mean(key, [missing.remove(i)]),
                    None => did_you_mean(key, names().filter(|name| !object.contains_key(*name))),
                };
                self.unknown_key(node, key, near, names(), complete);
            }
            if self.full() {
                return;
            }
        }
        if !missing.is_empty() {
            let hint = if self.path.is_empty() && missing == ["version"] { "; write \"version\": 1" } else { "" };
            let (noun, verb) = if missing.len() == 1 { ("key", "is") } else { ("keys", "are") };
            let names = list(missing.iter().map(|name| quoted(name)), "and");
            self.unreadable(Code::MissingKey, format!("the {noun} {names} {verb} missing{hint}"));
        }
    }

    fn unknown_key<'k>(
        &mut self,
        node: Node<'s>,
        key: &str,
        near: String,
        names: impl Iterator<Item = &'k str>,
        complete: bool,
    ) {
        let pointer = push_token(&self.path, key);
        // An object that lacks a key stays unreadable without this one; the scene itself gets what it lacks.
        let mend = if complete || self.path.is_empty() {
            Mend::Remove { object: self.path.clone(), key: key.to_owned() }
        } else {
            self.replace_part()
        };
        if is_later(node.name, key) {
            let detail = format!("\"{key}\" is not available in this version; remove it");
            return self.add(pointer, Code::Unsupported, detail, mend);
        }
        let names = list(names.map(quoted), "and");
        let hint = match (near.is_empty(), names.is_empty()) {
            (false, _) => near,
            (true, false) => format!("; keys here are {names}"),
            (true, true) => "; there are no keys here".to_owned(),
        };
        self.add(pointer, Code::UnknownKey, format!("unknown key \"{key}\"{hint}"), mend);
    }

    fn check_array(&mut self, node: Node<'s>, elements: &[Value]) {
        let least = node.schema["minItems"].as_u64();
        let most = node.schema["maxItems"].as_u64();
        let count = elements.len() as u64;
        if most.is_some() && least == most && Some(count) != least {
            let detail = format!("must be {}, has {count}", wording::expected(node, self.root));
            return self.unreadable(Code::WrongType, detail);
        }
        if let Some(least) = least.filter(|least| count < *least) {
            let detail = format!("must have at least {least} {}, has {count}", wording::elements(least));
            self.add(self.path.clone(), Code::OutOfRange, detail, Mend::Keep);
        }
        let items = Node { schema: &node.schema["items"], name: node.name };
        for (i, element) in elements.iter().enumerate() {
            if self.full() {
                return;
            }
            self.visit_child(i, items, element);
        }
    }

    fn wrong_type(&mut self, node: Node<'s>, value: &Value) {
        let hint = wording::type_hint(node, value, self.root);
        let detail = format!("must be {}, is {}{hint}", wording::expected(node, self.root), wording::shown(value));
        self.unreadable(Code::WrongType, detail);
    }
}

fn is_later(name: &str, key: &str) -> bool {
    LATER.iter().any(|(schema, keys)| *schema == name && keys.contains(&key))
}

fn fits_u32(value: u64) -> bool {
    u32::try_from(value).is_ok()
}

#[cfg(test)]
mod tests {
    use super::super::Description;
    use super::super::mend::mend;
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    /// A scene that uses most of the format.
    fn rich() -> Value {
        json!({
            "version": 1,
            "image": { "width": 64 },
            "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "vfov_deg": 30 } },
            "background": "#102030",
            "lights": [
                { "point": { "position": [0, 9, 0], "falloff": { "linear": { "reach": 20 } } } },
                { "spot": { "position": [0, 9, 0], "direction": [0, -1, 0], "falloff": "inverse_square" } }
            ],
            "materials": {
                "floor": { "diffuse": { "checker": { "a": 0, "b": [1, 1, 1], "axes": "xyz" } }, "ambient": null },
                "a/b~c": { "ior": 1.33, "transmission": 0.9 }
            },
            "definitions": { "pair": [{ "box": { "min": [0, 0, 0], "max": [1, 1, 1] } }] },
            "objects": [
                { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "floor", "hollow": true } },
                { "mesh": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]] } },
                { "group": {
                    "objects": [{ "instance": { "of": "pair", "transform": { "scale": 2 } } }],
                    "transform": { "rotate_deg": { "axis": [0, 1, 0], "angle": 45 }, "scale": [1, 2, 3] }
                } }
            ],
            "render": { "precision": "double", "accuracy": { "fixed": {} } }
        })
    }

    /// Pointers of all values.
    fn pointers(value: &Value, pointer: String, all: &mut Vec<String>) {
        match value {
            Value::Object(object) => object.iter().for_each(|(k, v)| pointers(v, push_token(&pointer, k), all)),
            Value::Array(array) => {
                array.iter().enumerate().for_each(|(i, v)| pointers(v, push_token(&pointer, i), all))
            }
            _ => {}
        }
        all.push(pointer);
    }

    /// Replaces, removes or renames something.
    fn spoil(scene: &mut Value, which: usize, how: usize) {
        let mut all = Vec::new();
        pointers(scene, String::new(), &mut all);
        let Some(value) = scene.pointer_mut(&all[which % all.len()]) else { return };
        let junk = [
            json!(null),
            json!(-1),
            json!(0.5),
            json!(1e300),
            json!(5_000_000_000_u64),
            json!("sphere"),
            json!("none"),
            json!("#ffeedd"),
            json!([]),
            json!([1, 2, 3]),
            json!({}),
            json!({ "sphere": 1, "plane": 2 }),
            json!({ "checker": {} }),
            json!(true),
        ];
        match (how % (junk.len() + 4), value) {
            (0, Value::Object(object)) => {
                object.insert("radus".to_owned(), json!(1));
            }
            (1, Value::Object(object)) => {
                if let Some(key) = object.keys().nth(which % object.len().max(1)).cloned() {
                    object.remove(&key);
                }
            }
            (2, Value::Object(object)) => {
                if let Some(key) = object.keys().nth(which % object.len().max(1)).cloned() {
                    let moved = object.remove(&key).unwrap_or_default();
                    object.insert(format!("{key}x"), moved);
                }
            }
            (3, Value::Array(array)) => array.push(json!(0)),
            (how, value) => *value = junk[how % junk.len()].clone(),
        }
    }

    #[test]
    fn nothing_is_wrong_with_the_rich_scene() {
        assert!(diagnose(&rich()).is_empty(), "{:?}", diagnose(&rich()));
    }

    #[test]
    fn knows_every_keyword_of_the_schema() {
        const KNOWN: &str = "$ref $defs $id $schema title description default format type properties required \
            additionalProperties oneOf anyOf enum const items minItems maxItems minimum maximum exclusiveMinimum \
            exclusiveMaximum pattern";
        fn check(schema: &Value) {
            let Some(keys) = schema.as_object() else { return };
            for (key, value) in keys {
                assert!(KNOWN.split_whitespace().any(|known| known == key), "{key}");
                match key.as_str() {
                    "properties" | "$defs" => value.as_object().unwrap().values().for_each(check),
                    "oneOf" | "anyOf" => value.as_array().unwrap().iter().for_each(check),
                    "items" | "additionalProperties" => check(value),
                    _ => {}
                }
            }
        }
        check(schema());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        /// Three judges agree on randomly spoilt scenes, and every mended scene is readable.
        #[test]
        fn agrees_with_jsonschema_and_serde(spoils in proptest::collection::vec((0_usize..400, 0_usize..18), 1..4)) {
            static VALIDATOR: std::sync::LazyLock<jsonschema::Validator> =
                std::sync::LazyLock::new(|| jsonschema::validator_for(schema()).unwrap());
            let mut scene = rich();
            for (which, how) in spoils {
                spoil(&mut scene, which, how);
            }
            let findings = diagnose(&scene);
            prop_assert_eq!(VALIDATOR.is_valid(&scene), findings.is_empty(), "{:#} {:?}", scene, findings);
            let readable = serde_json::from_str::<Description>(&scene.to_string());
            let only_ranges = findings.iter().all(|finding| finding.mend == Mend::Keep);
            prop_assert_eq!(readable.is_ok(), only_ranges, "{:#} {:?} {:?}", scene, findings, readable);
            let is_object = scene.is_object();
            prop_assert_eq!(mend(scene, &findings).is_some(), is_object);
        }
    }
}
