//! 100,000 random mutations of valid scenes: no panic, and every refusal says where. One that hangs would never let the test end.

use crate::common::{Random, on_own_threads, read};
use rayon::prelude::*;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::model::ModelOptions;
use strahl::scene::nff::NffOptions;
use strahl::scene::{Format, Overrides, load};

const MUTATIONS: u64 = 100_000;

/// Small pictures and shallow trees, whatever the mutated scene asks for.
const SMALL: Overrides = Overrides {
    width: Some(6),
    height: Some(4),
    dpr: None,
    max_depth: Some(4),
    min_weight: None,
    accuracy: None,
    samples: Some(1),
    antialias: Some(false),
    fidelity: None,
    precision: None,
    background: None,
    exposure: None,
    tone: None,
    seen_from: None,
    nff: NffOptions { two_sided: false, spd_counts: false },
    model: ModelOptions::NONE,
};

fn odd_value(random: &mut Random) -> Value {
    match random.below(18) {
        0 => json!(0),
        1 => json!(-1),
        2 => json!(1e-320),
        3 => json!(1e14),
        4 => json!(-1e300),
        5 => json!(1e308),
        6 => json!(-0.0),
        7 => json!(0.5),
        8 => json!([]),
        9 => json!({}),
        10 => json!(null),
        11 => json!(true),
        12 => json!("glass"),
        13 => json!("#12345g"),
        14 => json!([1, 2, 3, 4]),
        15 => json!([0, 0, 0]),
        16 => json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } }),
        _ => json!(random.between(-2.0, 2.0)),
    }
}

/// A random place in the document.
fn pick<'a>(random: &mut Random, value: &'a mut Value) -> &'a mut Value {
    let size = value.as_array().map_or(0, Vec::len) + value.as_object().map_or(0, serde_json::Map::len);
    if size == 0 || random.below(8) == 0 {
        return value;
    }
    let i = random.below(size);
    match value {
        Value::Array(list) => pick(random, &mut list[i]),
        Value::Object(map) => pick(random, map.values_mut().nth(i).unwrap()),
        other => other,
    }
}

fn mutate_value(random: &mut Random, scene: &mut Value) {
    for _ in 0..1 + random.below(3) {
        let kind = random.below(5);
        let odd = odd_value(random);
        let place = pick(random, scene);
        match (kind, place) {
            (0, Value::Object(map)) => {
                map.insert(["radius", "materia", "of", "objects", "transform", "x"][random.below(6)].into(), odd);
            }
            (1, Value::Object(map)) if !map.is_empty() => {
                let key = map.keys().nth(random.below(map.len())).cloned();
                key.and_then(|key| map.remove(&key));
            }
            (2, Value::Array(list)) => list.push(odd),
            (3, Value::Array(list)) if !list.is_empty() => {
                let copy = list[random.below(list.len())].clone();
                list.push(copy);
            }
            (_, place) => *place = odd,
        }
    }
}

fn mutate_bytes(random: &mut Random, text: &mut Vec<u8>) {
    const TOKENS: [&str; 14] =
        ["{", "}", "[", "]", ",", ":", "\"", "NaN", "1e999", "-", "\\u0000", "null", "\u{7f}", "[[[["];
    for _ in 0..1 + random.below(4) {
        if text.is_empty() {
            return;
        }
        let at = random.below(text.len());
        match random.below(4) {
            0 => text[at] = random.bits() as u8,
            1 => drop(text.remove(at)),
            2 => text.truncate(at.max(1)),
            _ => drop(text.splice(at..at, TOKENS[random.below(TOKENS.len())].bytes())),
        }
    }
}

fn check(text: &[u8], format: Format) {
    let show = || String::from_utf8_lossy(text).into_owned();
    // As the scene is, only to be accepted or refused; then small enough to be rendered, too.
    if let Err(problems) = load(text, format, &Overrides::default()) {
        assert!(!problems.0.is_empty(), "refused without a reason: {}", show());
    }
    match load(text, format, &SMALL) {
        Ok(loaded) => {
            let picture = render(&loaded.scene, Region::whole(6, 4), &Control::default()).unwrap();
            assert!(picture.film.pixels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{}", show());
        }
        Err(problems) => {
            assert!(!problems.0.is_empty(), "refused without a reason: {}", show());
            for problem in &problems.0 {
                assert!(!problem.detail.is_empty(), "{}", show());
                let somewhere = problem.line.is_some() || !problem.pointer.is_empty();
                assert!(somewhere, "a problem without a place: {problem}\n{}", show());
            }
        }
    }
}

#[test]
fn mutated_scenes_are_rendered_or_refused_with_a_place() {
    let scenes = ["whitted/whitted", "shapes/all", "lights/stage", "refraction/glass_of_water", "cameras/fisheye"]
        .map(|name| read(&format!("scenes/{name}.json")));
    let values = scenes.each_ref().map(|text| serde_json::from_slice::<Value>(text).unwrap());
    let mutate = |seed| {
        let mut random = Random::new(seed);
        let which = random.below(scenes.len());
        if random.below(2) == 0 {
            let mut value = values[which].clone();
            mutate_value(&mut random, &mut value);
            check(&serde_json::to_vec(&value).unwrap(), Format::Json);
        } else {
            let mut text = scenes[which].clone();
            mutate_bytes(&mut random, &mut text);
            check(&text, Format::Json);
        }
    };
    on_own_threads(|| (0..MUTATIONS).into_par_iter().for_each(mutate));
}

#[test]
fn mutated_nff_files_are_rendered_or_refused_with_a_line() {
    let files =
        ["balls_s1.nff", "mount_s2.nff", "assimp_WithCamera.nff"].map(|f| read(&format!("tests/inputs/nff/{f}")));
    let mutate = |seed| {
        let mut random = Random::new(seed);
        let mut text = files[random.below(files.len())].clone();
        mutate_bytes(&mut random, &mut text);
        check(&text, Format::Nff);
    };
    on_own_threads(|| (0..MUTATIONS / 10).into_par_iter().for_each(mutate));
}
