//! All problems with the shape of a scene, in sentences.
//!
//! serde stops at the first error. So when it fails, this walks the [`Value`] along the schema, that of scenes or of another
//! type. Where the schema has alternatives, the key or the type of the value decides which one is
//! meant, so problems have precise pointers. (A general validator reports the errors of every alternative, thirteen for each
//! misspelt object, and keeps all of them in memory before it reports one.) Tests check that this walk and the schema agree
//! on which scenes are wrong.

use super::wording;
use crate::control;
use crate::enum_names::list;
use crate::scene::description::{Color, HEX};
use crate::scene::limits::{NAME_BYTES, PROBLEMS, PROBLEMS_FOUND};
use crate::scene::problem::{Code, Problem, did_you_mean, name_too_long, push_token, quoted};
use crate::scene::schema::Node;
use serde_json::{Map, Value};
use std::rc::Rc;

/// One problem, and the change to the scene that lets the rest of it be checked.
#[derive(Debug)]
pub(super) struct Finding {
    pub(super) problem: Problem,
    pub(super) mend: Mend,
}

/// A change that makes a scene readable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Mend {
    /// None: the value is out of range, but readable.
    Keep,
    /// Remove a key.
    Remove { object: String, key: String },
    /// Replace the part around it by a stand-in.
    Replace(Rc<Part>),
}

/// A part of a scene that can be replaced as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) pointer: String,
    /// Name of its schema, or its key.
    pub(super) kind: String,
}

/// All problems of shape and range, at most [`PROBLEMS_FOUND`], by the schema of what the value should be.
pub(super) fn diagnose(root: &Value, name: &str, value: &Value) -> Vec<Finding> {
    let whole = Rc::new(Part { pointer: String::new(), kind: name.to_owned() });
    let mut walk = Walk { root, found: Vec::new(), path: String::new(), part: whole };
    walk.visit(Node { schema: root, name }, value);
    walk.found
}

struct Walk<'s> {
    root: &'s Value,
    found: Vec<Finding>,
    /// Pointer of the current value.
    path: String,
    /// The innermost part around it.
    part: Rc<Part>,
}

impl<'s> Walk<'s> {
    /// Whether there is no use in looking for more.
    fn full(&self) -> bool {
        self.found.len() >= PROBLEMS_FOUND || control::step(1)
    }

    /// The name that was meant, for problems that are reported.
    fn near_name<'a>(&self, given: &str, names: impl IntoIterator<Item = &'a str>) -> String {
        let is_told = given.len() <= KEY_BYTES && (self.found.len() as u64) < PROBLEMS.max;
        if is_told { did_you_mean(given, names) } else { String::new() }
    }

    fn add(&mut self, pointer: String, code: Code, detail: String, mend: Mend) {
        if !self.full() {
            self.found.push(Finding { problem: Problem::new(pointer, code, detail), mend });
        }
    }

    /// Reports the current value, which makes the part around it unreadable.
    fn unreadable(&mut self, code: Code, detail: String) {
        let mend = self.replace_part();
        self.add(self.path.clone(), code, detail, mend);
    }

    fn replace_part(&self) -> Mend {
        Mend::Replace(Rc::clone(&self.part))
    }

    fn visit(&mut self, node: Node<'s>, value: &Value) {
        if self.full() {
            return;
        }
        let is_whole = node.schema.get("$ref").is_some();
        let node = node.resolve(self.root);
        let outer = Rc::clone(&self.part);
        if is_whole && matches!(node.name, "Object" | "Light" | "Material" | "Camera") {
            self.enter_part(node.name);
        }
        let alternatives = node.alternatives(self.root);
        match alternatives.as_slice() {
            [only] => self.check(*only, value),
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
                // One key, or null in its place, is no choice between kinds.
                let is_choice = kinds.len() > 1 || alternatives.iter().any(|choice| !choice.words().is_empty());
                if is_choice && !kinds.is_empty() {
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
                        self.near_name(word, words.iter().copied().chain(kinds)),
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
        let kinds_are = || match kinds {
            [(kind, _)] => format!("the only kind is \"{kind}\""),
            _ => format!("kinds are {}", list(kinds.iter().map(|(kind, _)| quoted(kind)), "and")),
        };
        let known: Vec<&str> = kinds.iter().map(|(kind, _)| *kind).filter(|kind| object.contains_key(*kind)).collect();
        match (object.iter().next(), object.len(), known.as_slice()) {
            (Some((key, value)), 1, _) => {
                if let Some((_, choice)) = kinds.iter().find(|(kind, _)| kind == key) {
                    let inner = Node { schema: &choice.schema["properties"][key.as_str()], name };
                    self.visit_child(key, inner, value);
                    return;
                }
                if key.len() > KEY_BYTES {
                    let detail = format!("no such kind of {noun}, a key of {} bytes; {}", key.len(), kinds_are());
                    return self.unreadable(Code::UnknownKey, detail);
                }
                let pointer = push_token(&self.path, key);
                let mend = self.replace_part();
                let near = self.near_name(key, kinds.iter().map(|(kind, _)| *kind));
                let kinds_are = match near.as_str() {
                    "" => format!("; {}", kinds_are()),
                    near => format!("{near} Here {}", kinds_are()),
                };
                let detail = format!("no such kind of {noun} \"{key}\"{kinds_are}");
                self.add(pointer, Code::UnknownKey, detail, mend);
            }
            (_, count, [kind]) if count > 1 => {
                let others = list(object.keys().filter(|key| key != kind).take(5).map(|key| quoted(key)), "and");
                let detail = format!(
                    "{} {noun} has exactly one key, which names its kind; here it is \"{kind}\", so {others} must go \
                     or move inside it",
                    wording::article(noun),
                );
                self.unreadable(Code::WrongType, detail);
            }
            (_, count, _) => {
                // As other formats write it: {"type": "sphere", ...}.
                let said = ["type", "kind", "shape"].iter().find_map(|key| Some((*key, object.get(*key)?.as_str()?)));
                if let Some((key, kind)) = said.filter(|(_, said)| kinds.iter().any(|(kind, _)| kind == said)) {
                    let detail = format!("write {{\"{kind}\": {{...}}}} around the other keys, in place of \"{key}\"");
                    return self.unreadable(Code::WrongType, detail);
                }
                let has = if count == 0 {
                    "it has none".to_owned()
                } else {
                    format!("it has {}", list(object.keys().take(5).map(|key| quoted(key)), "and"))
                };
                let detail = format!(
                    "{} {noun} has exactly one key, which names its kind, and {has}; {}",
                    wording::article(noun),
                    kinds_are(),
                );
                self.unreadable(Code::WrongType, detail);
            }
        }
    }

    /// Checks against a schema without choices.
    fn check(&mut self, node: Node<'s>, value: &Value) {
        if node.is_anything() {
            return;
        }
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
                    let near = self.near_name(word, words.iter().copied());
                    let detail =
                        format!("must be {}, is {}{near}", wording::expected(node, self.root), wording::shown(value));
                    self.unreadable(Code::WrongType, detail);
                } else if node.schema.get("minLength").is_some() && word.is_empty() {
                    self.unreadable(Code::WrongType, "must not be empty".into());
                } else if node.schema.get("maxLength").is_some()
                    && let Some(detail) = name_too_long(word)
                {
                    self.add(self.path.clone(), Code::Limit, detail, Mend::Keep);
                } else if node.schema.get("pattern").is_some_and(|it| it == HEX) && Color::from_hex(word).is_none() {
                    let shown = wording::shown(value);
                    let detail = format!("{shown} is no color; write \"#rrggbb\", [r, g, b] or a grey number");
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
            } else if rest.is_object() && key.len() as u64 > NAME_BYTES.max {
                self.long_name(key);
            } else if rest.is_object() {
                self.visit_child(key, Node { schema: rest, name: node.name }, value);
            } else if *rest == Value::Bool(false) {
                let names = || keys.into_iter().flat_map(Map::keys).map(String::as_str);
                // A misspelt key is one problem, not an unknown key and a missing one.
                let meant = missing.iter().position(|name| !self.near_name(key, [*name]).is_empty());
                let near = match meant {
                    Some(i) => self.near_name(key, [missing.remove(i)]),
                    None => self.near_name(key, names().filter(|name| !object.contains_key(*name))),
                };
                self.unknown_key(key, near, keys, complete);
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

    /// Values of names that are too long are not looked at: each problem would repeat the name.
    fn long_name(&mut self, name: &str) {
        let mend = Mend::Remove { object: self.path.clone(), key: name.to_owned() };
        self.add(push_token(&self.path, name), Code::Limit, name_too_long(name).unwrap_or_default(), mend);
    }

    fn unknown_key(&mut self, key: &str, near: String, keys: Option<&'s Map<String, Value>>, complete: bool) {
        let names = keys.into_iter().flat_map(Map::keys).map(String::as_str);
        // A key of one of the objects inside.
        let mut inside = keys.into_iter().flatten().filter(|(name, schema)| self.has_key(Node { schema, name }, key));
        let owner = if near.is_empty() { inside.next().map(|(name, _)| name.clone()) } else { None };
        // An object that misses a key stays unreadable when this one is removed; missing keys of the scene are added.
        let mend = if complete || self.path.is_empty() {
            Mend::Remove { object: self.path.clone(), key: key.to_owned() }
        } else {
            self.replace_part()
        };
        if key.len() > KEY_BYTES {
            return self.add(self.path.clone(), Code::UnknownKey, format!("unknown key of {} bytes", key.len()), mend);
        }
        let pointer = push_token(&self.path, key);
        let names = list(names.map(quoted), "and");
        let hint = match (near.is_empty(), owner, names.is_empty()) {
            (false, ..) => near,
            (true, Some(owner), _) => format!("; it is a key of \"{owner}\""),
            (true, None, false) => format!("; keys here are {names}"),
            (true, None, true) => "; there are no keys here".to_owned(),
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
        // Most of a large scene are coordinates, which are fine: a fast path.
        if items.is_any_number() && elements.iter().all(Value::is_number) {
            return;
        }
        for (i, element) in elements.iter().enumerate() {
            if self.full() {
                return;
            }
            self.visit_child(i, items, element);
        }
    }

    fn wrong_type(&mut self, node: Node<'s>, value: &Value) {
        let hint = wording::type_hint(node, value, self.root);
        let hint = if self.path.ends_with("/material") && value.is_object() {
            "; define it in /materials and write its name".to_owned()
        } else {
            hint
        };
        let detail = format!("must be {}, is {}{hint}", wording::expected(node, self.root), wording::shown(value));
        self.unreadable(Code::WrongType, detail);
    }

    /// Whether a schema is that of objects with a key.
    fn has_key(&self, node: Node<'s>, key: &str) -> bool {
        node.alternatives(self.root).iter().any(|choice| choice.schema["properties"].get(key).is_some())
    }
}

/// Longest key that is compared with known ones and repeated in messages.
const KEY_BYTES: usize = 64;

fn fits_u32(value: u64) -> bool {
    u32::try_from(value).is_ok()
}
