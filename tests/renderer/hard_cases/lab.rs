//! Scenes, rays and pictures for the cases, in one precision.

use super::evidence::Evidence;
use crate::common::Random;
use crate::common::numbers::Numbers;
use crate::common::questions;
use glam::DVec3;
use serde_json::{Value, json};
use std::ops::Deref;
use strahl::film::Region;
use strahl::inspect::query::{RayHit, RayQuery, answer};
use strahl::inspect::tree::{Tree, trace_pixel};
use strahl::render::{Control, Picture, render};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Loaded, Overrides, Problems, Scene, load};

/// One precision, in which it loads and renders.
#[derive(Clone, Copy)]
pub struct Lab(Numbers);

impl Deref for Lab {
    type Target = Numbers;
    fn deref(&self) -> &Numbers {
        &self.0
    }
}

impl Lab {
    pub fn new(precision: Precision) -> Self {
        Self(Numbers::new(precision))
    }

    /// Loads a whole scene file.
    pub fn load(&self, description: &Value) -> Result<Loaded, Problems> {
        self.load_text(&description.to_string())
    }

    /// Loads a scene's text.
    pub fn load_text(&self, text: &str) -> Result<Loaded, Problems> {
        let overrides = Overrides { precision: Some(self.precision), ..Overrides::default() };
        load(text.as_bytes(), Format::Json, &overrides)
    }

    /// A scene of objects; `more` replaces keys.
    pub fn scene(&self, objects: Value, more: Value) -> Scene {
        self.load(&description(objects, more)).unwrap_or_else(|p| panic!("{p}")).scene
    }

    /// The rays of a ray from `eye` along `direction`.
    pub fn tree(&self, eye: DVec3, direction: DVec3, objects: Value, more: Value) -> Tree {
        let mut more = more;
        more["camera"] = toward(eye, direction);
        trace_pixel(&self.scene(objects, more), 0, 0)
    }

    /// The picture of a scene.
    pub fn picture(&self, objects: Value, more: Value) -> Picture {
        picture(&self.scene(objects, more))
    }
}

/// The orthographic camera whose only pixel starts at `eye`.
pub fn toward(eye: DVec3, direction: DVec3) -> Value {
    let d = direction.abs();
    let up = if d.y > d.x.max(d.z) { [1, 0, 0] } else { [0, 1, 0] };
    json!({ "orthographic": { "eye": eye.to_array(), "look_at": (eye + direction).to_array(), "up": up, "height": 1 } })
}

/// An orthographic camera on the z axis of `center` that looks at a square of edge `height`.
pub fn from_front(center: [f64; 3], away: f64, height: f64) -> Value {
    let eye = [center[0], center[1], center[2] + away];
    json!({ "orthographic": { "eye": eye, "look_at": center, "height": height } })
}

/// A square picture.
pub fn square(edge: u32) -> Value {
    json!({ "width": edge, "height": edge })
}

/// A scene without lights before a black background, one sample for each pixel.
pub fn description(objects: Value, more: Value) -> Value {
    let plain = |ambient: [f64; 3]| json!({ "ambient": ambient, "diffuse": 0 });
    let clear = |ior: f64| json!({ "ambient": 0, "diffuse": 0, "transmission": 1, "ior": ior });
    let mut description = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "lights": [],
        "ambient": 1,
        "materials": {
            "red": plain([1.0, 0.0, 0.0]),
            "green": plain([0.0, 1.0, 0.0]),
            "matt": { "ambient": 0, "diffuse": 0.8 },
            "mirror": { "ambient": 0, "diffuse": 0, "reflection": 1 },
            "glass": clear(1.5),
            "water": clear(1.33),
            "nothing": clear(1.0)
        },
        "objects": objects,
        "render": { "antialias": false }
    });
    for (key, value) in more.as_object().unwrap() {
        match (&mut description[key], value) {
            (Value::Object(old), Value::Object(new)) if ["materials", "render"].contains(&key.as_str()) => {
                old.extend(new.clone());
            }
            (old, new) => *old = new.clone(),
        }
    }
    description
}

/// Renders the whole picture.
pub fn picture(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

/// What a ray hits.
pub fn hit(scene: &Scene, origin: DVec3, direction: DVec3) -> Option<RayHit> {
    hit_within(scene, origin, direction, 0.0, None)
}

/// What a ray hits in a range.
pub fn hit_within(scene: &Scene, origin: DVec3, direction: DVec3, t_min: f64, t_max: Option<f64>) -> Option<RayHit> {
    answer(scene, &RayQuery { origin: origin.into(), direction: direction.into(), t_min, t_max }).at
}

/// Whether all numbers of a hit are finite.
pub fn finite(hit: &RayHit) -> bool {
    let vectors = [hit.point, hit.normal, hit.reflected, hit.transmitted.unwrap_or_default()];
    hit.t.is_finite() && hit.reflectance.is_finite() && vectors.iter().flatten().all(|x| x.is_finite())
}

/// A random unit vector.
pub fn direction(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from_array(random.point(1.0));
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// Asks the ground truth's questions whose names contain one of the words; none means all.
pub fn ask(lab: &Lab, evidence: &mut Evidence, file: &str, words: &[&str]) {
    let mut asked = 0;
    for outcome in questions::ask(file, lab.precision) {
        if words.is_empty() || words.iter().any(|word| outcome.name.contains(word)) {
            asked += 1;
            let why = outcome.check.as_ref().err().cloned().unwrap_or_default();
            evidence.check(outcome.check.is_ok(), || format!("{}: {why}", outcome.name));
            evidence.measure(outcome.worst);
        }
    }
    assert!(asked > 0, "no question of {file} has any of {words:?}");
}

/// Evidence for questions with exact answers.
pub fn truth() -> Evidence {
    Evidence::measuring(1.0, "of the error allowed")
}

/// The rows of a file of exact answers, for naive code.
pub fn rows(file: &str) -> Vec<Value> {
    questions::queries(file)
}

/// A vector of a row.
pub fn vector(value: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| value[i].as_f64().unwrap()))
}

/// A sphere's JSON.
pub fn ball(center: [f64; 3], radius: f64, material: &str) -> Value {
    json!({ "sphere": { "center": center, "radius": radius, "material": material } })
}
