//! Variations of a scene that is built: a merge patch (RFC 7396) on its canonical text.
//!
//! What a patch does not name is not read again, and a scene with the same objects is built in the same hierarchies: another
//! camera of a million triangles takes milliseconds.

use super::check::settings_are_sound;
use super::compile::Original;
use super::files::Files;
use super::load::{Accept, NotLoaded, Steps, meant, prepare, with_rest};
use super::nff::NffOptions;
use super::problem::{Code, unless_cancelled};
use super::read::{Unreadable, read_json};
use super::{Description, Loaded, Overrides, Problem, Problems, locate};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

/// The variation of a scene, if `accept` wants it, as [`load_if`](super::load_if) does. Problems have the pointers of the
/// scene that results, and no lines.
pub fn vary_if<E>(
    original: Original<'_>,
    patch: &[u8],
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    vary_with(original, patch, &|_| Ok(()), overrides, files, accept)
}

/// The same for what `change` makes of the patched scene.
pub fn vary_with<E>(
    original: Original<'_>,
    patch: &[u8],
    change: &dyn Fn(&mut Description) -> Result<(), Problem>,
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    let start = Instant::now();
    let mut description = described(original.description, patch, overrides).map_err(without_places)?;
    change(&mut description).map_err(Problems::one)?;
    // A mistake in the scene is reported even where an override replaces it.
    let overrides = if settings_are_sound(&description) { *overrides } else { Overrides::default() };
    overrides.apply(&mut description);
    let steps = Steps::read(start);
    let own = original.description;
    if Arc::ptr_eq(&own.objects, &description.objects) && Arc::ptr_eq(&own.definitions, &description.definitions) {
        description.take_models_of(own);
    }
    let assets = prepare(&mut description, files)?;
    let (whole, known) = (description.whole(), own.whole());
    let known = Some(Original { description: &known, scene: original.scene });
    let checked = steps.checked(&whole, files, accept, known).map_err(|error| meant(&description, error));
    let (pictures, mut warnings) = checked?;
    warnings.splice(0..0, description.warnings_of_models());
    let nff = NffOptions::default();
    let built = steps.build(&whole, nff, pictures, warnings, known);
    let scene = built.map_err(|problems| meant(&description, NotLoaded::Problems(problems)))?;
    drop(whole);
    Ok(steps.loaded(description, scene, nff, assets))
}

/// The description that a patch makes of another one.
fn described(original: &Description, patch: &[u8], overrides: &Overrides) -> Result<Description, Problems> {
    let Value::Object(patch) = read(patch)? else {
        let detail = "a patch is an object with the keys of a scene that change, such as {\"camera\": {...}}";
        return Err(Problems::one(Problem::new("", Code::WrongType, detail)));
    };
    let mut scene = around(original, &patch);
    let left = Left::by(original, &patch);
    merge(&mut scene, Value::Object(patch));
    unless_cancelled()?;
    let text = serde_json::to_vec(&scene).unwrap_or_default();
    drop(scene);
    match read_json(&text) {
        Ok(mut description) => {
            left.fill(&mut description);
            Ok(description)
        }
        Err(Unreadable { problems, mended: None }) => Err(problems),
        Err(Unreadable { problems, mended: Some(mut mended) }) => {
            left.fill(&mut mended.description);
            Err(with_rest(&text, problems, *mended, overrides))
        }
    }
}

/// What a patch leaves of the large parts of a scene.
struct Left<'a> {
    original: &'a Description,
    /// Names of materials that it changes; none if it replaces or removes all.
    materials: Option<BTreeSet<String>>,
    /// Likewise of definitions.
    definitions: Option<BTreeSet<String>>,
    objects: bool,
}

impl<'a> Left<'a> {
    fn by(original: &'a Description, patch: &Map<String, Value>) -> Self {
        let changed = |key: &str| match patch.get(key) {
            Some(Value::Object(names)) => Some(names.keys().cloned().collect()),
            Some(_) => None,
            None => Some(BTreeSet::new()),
        };
        let (materials, definitions) = (changed("materials"), changed("definitions"));
        Self { original, materials, definitions, objects: !patch.contains_key("objects") }
    }

    /// Puts it in the place of what stands for it.
    fn fill(&self, description: &mut Description) {
        let Self { original, materials, definitions, objects } = self;
        let is_left = |changed: &Option<BTreeSet<String>>, name: &str| {
            changed.as_ref().is_some_and(|changed| !changed.contains(name))
        };
        for (name, material) in description.materials.iter_mut().filter(|(name, _)| is_left(materials, name)) {
            material.clone_from(&original.materials[name]);
        }
        if definitions.as_ref().is_some_and(BTreeSet::is_empty) {
            description.definitions = Arc::clone(&original.definitions);
        } else {
            let own = Arc::make_mut(&mut description.definitions).iter_mut();
            for (name, list) in own.filter(|(name, _)| is_left(definitions, name)) {
                list.clone_from(&original.definitions[name]);
            }
        }
        if *objects {
            description.objects = Arc::clone(&original.objects);
        }
    }
}

/// The scene as JSON, with something small in the place of objects, and of materials and definitions that a patch does not
/// name.
fn around(original: &Description, patch: &Map<String, Value>) -> Value {
    let mut small = Description { objects: Arc::default(), definitions: Arc::default(), ..original.clone() };
    let mut scene = small.settings();
    let named = |key: &str, name: &String| patch.get(key).is_some_and(|names| names.get(name).is_some());
    let materials = original.materials.iter().map(|(name, material)| {
        // All values of a description can be written as JSON.
        let value = named("materials", name).then(|| serde_json::to_value(material).unwrap_or_default());
        (name.clone(), value.unwrap_or_else(|| Value::Object(Map::new())))
    });
    scene["materials"] = Value::Object(materials.collect());
    // Lists are replaced as a whole.
    let definitions = original.definitions.keys().map(|name| (name.clone(), Value::Array(Vec::new())));
    scene["definitions"] = Value::Object(definitions.collect());
    // A scene has at least one.
    scene["objects"] = json!([{ "sphere": { "center": [0, 0, 0], "radius": 1 } }]);
    scene
}

/// A patch as a tree.
fn read(patch: &[u8]) -> Result<Value, Problems> {
    let wrong = |error: serde_json::Error| Problem::new("", Code::InvalidJson, format!("the patch: {error}"));
    let value = serde_json::from_slice(patch).map_err(|error| Problems::one(wrong(error)))?;
    let twice = locate::duplicate_keys(patch);
    if twice.is_empty() { Ok(value) } else { Err(Problems(twice)) }
}

/// RFC 7396. Both are as deep as their reader allows.
fn merge(target: &mut Value, patch: Value) {
    let Value::Object(patch) = patch else {
        *target = patch;
        return;
    };
    if !target.is_object() {
        *target = Value::Object(Map::new());
    }
    let Value::Object(target) = target else { return };
    for (key, value) in patch {
        if value.is_null() {
            target.remove(&key);
        } else {
            merge(target.entry(key).or_insert(Value::Null), value);
        }
    }
}

/// Places in a text that nobody has sent say nothing.
fn without_places(Problems(mut problems): Problems) -> Problems {
    for problem in &mut problems {
        (problem.line, problem.column) = (None, None);
    }
    Problems(problems)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 7396, appendix A.
    #[test]
    fn patches_merge_as_the_standard_says() {
        for (original, patch, result) in [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "b"}), json!({"b": "c"}), json!({"a": "b", "b": "c"})),
            (json!({"a": "b"}), json!({"a": null}), json!({})),
            (json!({"a": "b", "b": "c"}), json!({"a": null}), json!({"b": "c"})),
            (json!({"a": ["b"]}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "c"}), json!({"a": ["b"]}), json!({"a": ["b"]})),
            (json!({"a": {"b": "c"}}), json!({"a": {"b": "d", "c": null}}), json!({"a": {"b": "d"}})),
            (json!({"a": [{"b": "c"}]}), json!({"a": [1]}), json!({"a": [1]})),
            (json!(["a", "b"]), json!(["c", "d"]), json!(["c", "d"])),
            (json!({"a": "b"}), json!(["c"]), json!(["c"])),
            (json!({"a": "foo"}), json!(null), json!(null)),
            (json!({"a": "foo"}), json!("bar"), json!("bar")),
            (json!({"e": null}), json!({"a": 1}), json!({"e": null, "a": 1})),
            (json!([1, 2]), json!({"a": "b", "c": null}), json!({"a": "b"})),
            (json!({}), json!({"a": {"bb": {"ccc": null}}}), json!({"a": {"bb": {}}})),
        ] {
            let mut merged = original.clone();
            merge(&mut merged, patch.clone());
            assert_eq!(merged, result, "{original} with {patch}");
        }
    }
}
