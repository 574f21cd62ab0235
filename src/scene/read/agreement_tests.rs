//! Randomly spoilt scenes: the diagnosis finds problems in just those that `jsonschema` and serde refuse.

use super::diagnose::{Mend, diagnose};
use super::mend::mend;
use crate::scene::Description;
use crate::scene::problem::push_token;
use crate::scene::schema::schema;
use crate::strict_json::Strict;
use proptest::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

/// A scene that uses most of the format.
fn rich() -> Value {
    json!({
        "version": 1,
        "image": { "width": 64 },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "vfov_deg": 30 } },
        "background": "#102030",
        "environment": { "image": "sky.png", "rotate_deg": 90, "intensity": 2 },
        "lights": [
            { "point": { "position": [0, 9, 0], "falloff": { "linear": { "reach": 20 } } } },
            { "spot": { "position": [0, 9, 0], "direction": [0, -1, 0], "falloff": "inverse_square" } }
        ],
        "materials": {
            "floor": { "diffuse": { "checker": { "a": 0, "b": [1, 1, 1], "axes": "xyz" } }, "ambient": null },
            "a/b~c": { "ior": 1.33, "transmission": 0.9 },
            "sky": { "diffuse": { "gradient": { "from": [0, 0, 0], "to": [0, 1, 0], "a": 1, "b": "#0000ff" } } },
            "rough": {
                "diffuse": { "noise": { "a": 0, "b": 1, "octaves": 2 } },
                "bump": { "height": 0.1, "texture": { "noise": { "size": 0.5 } } }
            },
            "globe": {
                "diffuse": { "image": { "source": "a.png", "mapping": { "spherical": {} }, "wrap": "clamp" } },
                "normal_map": { "image": { "source": "b.png", "mapping": { "planar": { "axes": "xy" } } } }
            }
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
        Value::Array(array) => array.iter().enumerate().for_each(|(i, v)| pointers(v, push_token(&pointer, i), all)),
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
    assert!(diagnose(schema(), "scene", &rich()).is_empty());
}

#[test]
fn knows_every_keyword_of_the_schema() {
    const KNOWN: &str = "$ref $defs $id $schema title description default format type properties required \
        additionalProperties oneOf anyOf enum const items minItems maxItems minLength maxLength propertyNames minimum maximum exclusiveMinimum \
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
        let findings = diagnose(schema(), "scene", &scene);
        prop_assert_eq!(VALIDATOR.is_valid(&scene), findings.is_empty(), "{:#} {:?}", scene, findings);
        let readable = Description::deserialize(Strict(&scene));
        let only_ranges = findings.iter().all(|finding| finding.mend == Mend::Keep);
        prop_assert_eq!(readable.is_ok(), only_ranges, "{:#} {:?} {:?}", scene, findings, readable);
        let is_object = scene.is_object();
        prop_assert_eq!(mend(scene, &findings).is_some(), is_object);
    }
}
