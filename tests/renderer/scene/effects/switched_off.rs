//! What is removed from a scene leaves no trace, and what is taken out of a built scene is gone.

use super::{all_scenes, judge, loaded, pixels};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Mutex;
use strahl::scene::description::Color;
use strahl::scene::effects::{Effect, State};

/// Calls for each material.
fn each_material(scene: &mut Value, mut change: impl FnMut(&mut Value)) {
    scene["materials"].as_object_mut().into_iter().flatten().for_each(|(_, material)| change(material));
}

fn each_light(scene: &mut Value, mut change: impl FnMut(&str, &mut Value)) {
    for light in scene["lights"].as_array_mut().into_iter().flatten() {
        light.as_object_mut().unwrap().iter_mut().for_each(|(kind, keys)| change(kind, keys));
    }
}

/// Calls for the keys of each object, those of groups and definitions too.
fn each_object(list: &mut Value, change: &mut impl FnMut(&str, &mut Value)) {
    for object in list.as_array_mut().into_iter().flatten() {
        for (kind, keys) in object.as_object_mut().unwrap() {
            if kind == "group" {
                each_object(&mut keys["objects"], change);
            }
            change(kind, keys);
        }
    }
}

fn each_object_of(scene: &mut Value, mut change: impl FnMut(&str, &mut Value)) {
    each_object(&mut scene["objects"], &mut change);
    for (_, list) in scene["definitions"].as_object_mut().into_iter().flatten() {
        each_object(list, &mut change);
    }
}

/// The color in the place of one of a kind.
fn plain(color: &mut Value, kind: &str, image: &Value) {
    let Some(texture) = color.get(kind) else { return };
    *color = if kind == "image" {
        image.clone()
    } else if texture["a"] == texture["b"] {
        texture["a"].clone()
    } else {
        let [a, b] = ["a", "b"].map(|key| rgb(&texture[key]));
        json!(std::array::from_fn::<f64, 3, _>(|c| 0.5 * (a[c] + b[c])))
    };
}

/// Red, green and blue of a color.
fn rgb(color: &Value) -> [f64; 3] {
    let color: Color = serde_json::from_value(color.clone()).unwrap();
    color.0.to_array()
}

fn is_black(color: &Value) -> bool {
    color.is_null() || rgb(color) == [0.0; 3]
}

/// Effects that no material asks for.
const OF_SCENES: [Effect; 9] = [
    Effect::Shadows,
    Effect::Fog,
    Effect::SpotLights,
    Effect::LightFalloff,
    Effect::SoftShadows,
    Effect::DepthOfField,
    Effect::AlphaChannel,
    Effect::ToneMapping,
    Effect::Antialiasing,
];

/// Writes a description, in which every default is written down, without an effect. False where that is no matter of one
/// effect alone.
fn switch_off(scene: &mut Value, effect: Effect) -> bool {
    // Keys of `pbr` each ask for several effects.
    let mut materials = scene["materials"].as_object().into_iter().flatten();
    if materials.any(|(_, material)| !material["pbr"].is_null()) && !OF_SCENES.contains(&effect) {
        return false;
    }
    match effect {
        Effect::AmbientLight => scene["ambient"] = json!(0),
        Effect::DiffuseReflection => {
            scene["materials"]["plain"] = json!({ "diffuse": 0.8 });
            each_object_of(scene, |kind, keys| {
                if !["group", "instance"].contains(&kind) && keys["material"].is_null() {
                    keys["material"] = json!("plain");
                }
            });
            each_material(scene, |material| {
                let diffuse = std::mem::replace(&mut material["diffuse"], json!(0));
                if material["ambient"].is_null() {
                    material["ambient"] = diffuse;
                }
            });
        }
        Effect::Shadows => scene["render"]["shadows"] = json!("none"),
        Effect::TransmissiveShadows => scene["render"]["shadows"] = json!("opaque"),
        Effect::Reflection => each_material(scene, |material| {
            material["reflection"] = json!(0);
            if material["fresnel"] == "conductor" {
                material["fresnel"] = json!("none");
            }
        }),
        Effect::Transmission => each_material(scene, |material| material["transmission"] = json!(0)),
        Effect::Fog => scene["fog"] = Value::Null,
        Effect::Refraction => each_material(scene, |material| {
            if !is_black(&material["transmission"]) {
                material["ior"] = json!(1);
            }
        }),
        Effect::CheckerTexture | Effect::GradientTexture | Effect::NoiseTexture | Effect::ImageTexture => {
            let kind = effect.name().trim_end_matches("_texture");
            each_material(scene, |material| {
                for key in ["diffuse", "ambient"] {
                    // The color of the picture of one color.
                    plain(&mut material[key], kind, &json!("#ff00ff"));
                }
            });
        }
        Effect::EnvironmentMap => scene["environment"] = Value::Null,
        Effect::SpotLights => {
            for light in scene["lights"].as_array_mut().unwrap() {
                if let Some(mut spot) = light.as_object_mut().unwrap().remove("spot") {
                    let keys = spot.as_object_mut().unwrap();
                    ["direction", "inner_deg", "outer_deg"].iter().for_each(|key| drop(keys.remove(*key)));
                    light["point"] = spot;
                }
            }
        }
        Effect::LightFalloff => each_light(scene, |kind, keys| {
            if kind != "directional" {
                keys["falloff"] = json!("none");
            }
        }),
        Effect::SoftShadows => each_light(scene, |_, keys| keys["area"] = Value::Null),
        Effect::DepthOfField => {
            scene["camera"]["pinhole"]["aperture"] = json!(0);
            scene["camera"]["pinhole"]["focus_distance"] = Value::Null;
        }
        Effect::MotionBlur => each_object_of(scene, |kind, keys| {
            if ["group", "instance"].contains(&kind) {
                keys["motion"] = Value::Null;
            }
        }),
        Effect::ColorBleeding => scene["render"]["color_bleeding"] = json!(false),
        Effect::AlphaChannel => scene["film"]["background"] = json!("scene"),
        Effect::ToneMapping => {
            scene["film"]["exposure"] = json!(0);
            scene["film"]["tone"] = json!("none");
        }
        Effect::Antialiasing => scene["render"]["antialias"] = json!(false),
        Effect::ColoredShadows
        | Effect::TotalReflection
        | Effect::HollowBodies
        | Effect::SmoothNormals
        | Effect::Instancing
        | Effect::SpecialProjection
        | Effect::GlobalIllumination
        | Effect::EnvironmentSampling
        | Effect::EmitterSampling
        | Effect::DoublePrecision => return false,
        // One key of materials asks for it.
        _ => {
            let key = match effect {
                Effect::Highlights => "specular",
                Effect::Gloss => "roughness",
                Effect::BumpMapping => "bump",
                Effect::NormalMapping => "normal_map",
                _ => effect.name(),
            };
            each_material(scene, |material| drop(material.as_object_mut().unwrap().remove(key)));
        }
    }
    true
}

/// Writes the description without an effect that has been removed, if one key says no more than that.
fn switch_off_removed(scene: &mut Value, effect: Effect, on: &[Effect]) -> bool {
    match effect {
        // Where no ray passes through bodies, light and the eye may still be inside of them.
        Effect::Transmission => {
            let inside = [Effect::TransmissiveShadows, Effect::Absorption, Effect::Fog];
            if inside.iter().any(|effect| on.contains(effect)) {
                return false;
            }
        }
        // A varnish has an index, too.
        Effect::Refraction if on.contains(&Effect::Fresnel) => return false,
        Effect::EnvironmentMap => {
            let intensity = scene["environment"]["intensity"].as_f64().unwrap();
            let color = if intensity == 0.0 { json!("#000000") } else { json!("#ff00ff") };
            scene["background"] = json!(rgb(&color).map(|channel| channel * intensity));
        }
        // What surfaces gather takes the place of ambient light wherever it is asked for.
        _ => {}
    }
    switch_off(scene, effect)
}

#[test]
fn switching_off_what_was_removed_changes_no_byte() {
    let removed_in: Mutex<BTreeMap<&str, usize>> = Mutex::default();
    judge(all_scenes(1_000), |description| {
        let before = loaded(description);
        let written = serde_json::to_value(&before.description).unwrap();
        let having = |state: State| -> Vec<Effect> {
            before.scene.effects.iter().filter(|entry| entry.state == state).map(|entry| entry.effect).collect()
        };
        let (on, removed) = (having(State::On), having(State::Removed));
        let without = |effects: &[Effect]| {
            let mut scene = written.clone();
            for effect in effects {
                switch_off_removed(&mut scene, *effect, &on);
            }
            pixels(&loaded(&scene).scene)
        };
        removed.iter().for_each(|effect| *removed_in.lock().unwrap().entry(effect.name()).or_default() += 1);
        let expected = pixels(&before.scene);
        if without(&removed) == expected {
            return Vec::new();
        }
        let guilty: Vec<&str> =
            removed.iter().filter(|effect| without(&[**effect]) != expected).map(|effect| effect.name()).collect();
        vec![format!("{guilty:?} were removed, but show")]
    });
    let removed_in = removed_in.into_inner().unwrap();
    println!("{removed_in:?}");
    assert!(removed_in.len() >= 20, "few effects are ever removed: {removed_in:?}");
}

#[test]
fn what_is_taken_out_of_a_built_scene_is_gone() {
    judge(all_scenes(200), |description| {
        let mut description = description.clone();
        // Bounds stay as they were built, so nothing may depend on them.
        let depth = description["render"]["max_depth"].as_u64().unwrap_or(4);
        description["render"]["accuracy"] = json!({ "fixed": {} });
        description["render"]["max_depth"] = json!(depth.min(6));
        let built = loaded(&description);
        let written = serde_json::to_value(&built.description).unwrap();
        let mut wrong = Vec::new();
        for entry in built.scene.effects.iter().filter(|entry| entry.state == State::On) {
            let Some(scene) = built.scene.without(entry.effect) else { continue };
            let mut other = written.clone();
            if !switch_off(&mut other, entry.effect) {
                continue;
            }
            let (here, there) = (pixels(&scene), pixels(&loaded(&other).scene));
            // The mean of two colors is rounded before or after, and what moves has coordinates of its own.
            let rounds = [Effect::CheckerTexture, Effect::MotionBlur].contains(&entry.effect);
            let off = |(a, b): (&[f32; 3], &[f32; 3])| {
                (0..3).any(|c| if rounds { (a[c] - b[c]).abs() > 1e-4 * a[c].max(1.0) } else { a[c] != b[c] })
            };
            // At edges roundings are seen.
            let many = if rounds { here.len() / 16 } else { 0 };
            // The mean of a picture is not that of its color in the description.
            if entry.effect != Effect::ImageTexture && here.iter().zip(&there).filter(|pair| off(*pair)).count() > many
            {
                wrong.push(format!("without {}", entry.effect.name()));
            }
        }
        wrong
    });
}
