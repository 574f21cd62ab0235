//! Makes a scene with problems readable, so that the rest of it can be checked.
//!
//! Every unreadable part is replaced by a harmless one of its kind. So indices and names stay, and other parts may refer to
//! it.

use super::diagnose::{Finding, Mend, Part};
use crate::scene::Description;
use crate::scene::problem::{Code, Problem};
use crate::strict_json;
use serde_json::{Value, json};

/// A scene whose unreadable parts are replaced.
#[derive(Debug)]
pub struct Mended {
    /// The scene, with stand-ins.
    pub description: Description,
    /// Pointers of the stand-ins.
    replaced: Vec<String>,
}

impl Mended {
    /// Whether a problem found in the description is due to a stand-in, not to the scene's author.
    pub fn is_ours(&self, problem: &Problem) -> bool {
        let within = |part: &String| {
            problem.pointer.strip_prefix(part.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        // Where the names themselves are unreadable, references to them are not to blame.
        let names_are_gone = self.replaced.iter().any(|part| part == "/materials" || part == "/definitions");
        self.replaced.iter().any(within) || (names_are_gone && problem.code == Code::UnknownReference)
    }
}

/// Mends a scene as its findings say; none if the whole document is something else.
pub(super) fn mend(mut scene: Value, findings: &[Finding]) -> Option<Mended> {
    let mut replaced = Vec::new();
    for finding in findings {
        match &finding.mend {
            Mend::Keep => {}
            Mend::Remove { object, key } => {
                if let Some(object) = scene.pointer_mut(object).and_then(Value::as_object_mut) {
                    object.remove(key);
                }
            }
            // Missing keys of the scene are added below.
            Mend::Replace(part) if part.pointer.is_empty() => {}
            Mend::Replace(part) => {
                if !replaced.contains(&part.pointer) {
                    replace(&mut scene, part);
                    replaced.push(part.pointer.clone());
                }
            }
        }
    }
    let top = scene.as_object_mut()?;
    for key in ["version", "camera", "objects"] {
        if !top.contains_key(key) {
            top.insert(key.to_owned(), stand_in(key)?);
            replaced.push(format!("/{key}"));
        }
    }
    // As a text, since reading trees, too, would be as much code again as reading scenes.
    let text = serde_json::to_vec(&scene).ok()?;
    Some(Mended { description: strict_json::from_slice(&text).ok()?, replaced })
}

fn replace(scene: &mut Value, part: &Part) {
    match stand_in(&part.kind) {
        Some(value) => {
            if let Some(place) = scene.pointer_mut(&part.pointer) {
                *place = value;
            }
        }
        // A top-level key with a default.
        None => {
            if let Some(top) = scene.as_object_mut() {
                top.remove(&part.kind);
            }
        }
    }
}

fn stand_in(kind: &str) -> Option<Value> {
    let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } });
    match kind {
        "Object" => Some(ball),
        "objects" | "Definition" => Some(json!([ball])),
        "Light" => Some(json!({ "point": { "position": [0, 0, 0] } })),
        "Material" => Some(json!({})),
        "Camera" | "camera" => Some(json!({ "pinhole": { "eye": [0, 0, 1], "look_at": [0, 0, 0] } })),
        "version" => Some(json!(1)),
        _ => None,
    }
}
