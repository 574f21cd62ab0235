//! Effects that are asked for in vain, by keys, by geometry or by what else is in the scene: without them the picture is the same to
//! the last bit and takes the same rays, and a little more of what is missing switches them on.

use super::light_traps::{of_hidden_lights, of_lights};
use super::random_scene::picture;
use super::{judge, loaded};
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::effects::State;

/// A scene with an effect in vain, the same without it, and one in which it shows, as changes of a scene.
pub(super) struct Trap {
    pub(super) effect: &'static str,
    pub(super) asked: Value,
    pub(super) without: Value,
    pub(super) shown: Value,
}

/// Changes a value: objects key by key, arrays by what is appended to them (`+`), and null removes.
pub(super) fn change(value: &mut Value, by: &Value) {
    let (Some(object), Some(changes)) = (value.as_object_mut(), by.as_object()) else {
        *value = by.clone();
        return;
    };
    for (key, by) in changes {
        match key.strip_suffix('+') {
            Some(key) => object[key].as_array_mut().unwrap().extend(by.as_array().unwrap().iter().cloned()),
            None if by.is_null() => drop(object.remove(key)),
            None => change(object.entry(key).or_insert(json!({})), by),
        }
    }
}

/// A ball on a floor, of material `m` both, and the settings in which all traps are tried.
fn settings() -> Vec<(&'static str, Value)> {
    let scene = json!({
        "version": 1, "image": { "width": 24, "height": 16 },
        "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } },
        "lights": [{ "point": { "position": [3, 4, 3] } }],
        "materials": { "m": { "diffuse": 0.5 } },
        "objects": [
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } },
            { "plane": { "point": [0, -1.5, 0], "normal": [0, 1, 0], "material": "m" } }
        ],
        "ambient": 0.1, "background": [0.25, 0.5, 0.75], "render": {}
    });
    let with = |changes: Value| {
        let mut scene = scene.clone();
        change(&mut scene, &changes);
        scene
    };
    vec![
        ("plain", scene.clone()),
        ("double", with(json!({ "render": { "precision": "double", "max_depth": 4 } }))),
        (
            "fixed",
            with(
                json!({ "render": { "accuracy": { "fixed": {} }, "shadows": "transmissive" }, "fog": { "density": 0.02 } }),
            ),
        ),
    ]
}

fn image(rgb: [[u8; 3]; 2]) -> Value {
    json!({ "source": picture(rgb), "mapping": { "planar": { "axes": "xy" } } })
}

/// Traps of one change: what asks for the effect, and what is added to make it show.
pub(super) fn trap(effect: &'static str, asked: Value, without: Value, added: &Value) -> Trap {
    let mut shown = asked.clone();
    change(&mut shown, added);
    Trap { effect, asked, without, shown }
}

/// A body of a material `g` that shows an effect, as one that shows it and as one that does not.
fn of_body(effect: &'static str, material: Value, plain: Value, vain: Value, body: Value) -> Trap {
    let scene = |material: &Value, body: &Value| {
        let mut body = body.clone();
        body.as_object_mut().unwrap().values_mut().next().unwrap()["material"] = json!("g");
        json!({ "materials": { "g": material }, "objects+": [body] })
    };
    Trap { effect, asked: scene(&material, &vain), without: scene(&plain, &vain), shown: scene(&material, &body) }
}

fn ball() -> Value {
    json!({ "sphere": { "center": [1.2, 0.5, 1.5], "radius": 0.5 } })
}

/// Sheets of all kinds.
fn sheets() -> [Value; 5] {
    [
        json!({ "quad": { "vertices": [[-1, -1, 2], [1, -1, 2], [1, 1, 2], [-1, 1, 2]] } }),
        json!({ "triangle": { "vertices": [[-1, -1, 2], [1, -1, 2], [0, 1, 2]] } }),
        json!({ "polygon": { "vertices": [[-1, -1, 2], [1, -1, 2], [1.5, 0, 2], [1, 1, 2], [-1, 1, 2]] } }),
        json!({ "disc": { "center": [0, 0.5, 2], "normal": [0, 0, 1], "radius": 1 } }),
        json!({ "cylinder": { "base": [-0.5, 0, 2], "top": [1, 0.5, 2], "radius": 0.5, "capped": false } }),
    ]
}

fn of_sheets() -> Vec<Trap> {
    let glass = json!({ "diffuse": 0, "transmission": 0.8, "ior": 1.5 });
    let with = |key: &str, value: Value| {
        let mut glass = glass.clone();
        glass[key] = value;
        glass
    };
    let straight = json!({ "diffuse": 0, "transmission": 0.8 });
    let traps = sheets().into_iter().flat_map(|sheet| {
        [
            of_body("dispersion", with("dispersion", json!(0.05)), glass.clone(), sheet.clone(), ball()),
            of_body("absorption", with("absorption", json!(0.5)), glass.clone(), sheet.clone(), ball()),
            of_body("refraction", glass.clone(), straight.clone(), sheet, ball()),
        ]
    });
    traps.collect()
}

/// Bodies of every kind of material behind, in and around what hides them.
fn hidden() -> Vec<Trap> {
    let color = json!({ "image": image([[255, 0, 255], [0, 255, 0]]) });
    let kinds = [
        ("transmission", json!({ "diffuse": 0, "transmission": 0.8 })),
        ("refraction", json!({ "diffuse": 0, "transmission": 0.8, "ior": 1.5 })),
        ("dispersion", json!({ "diffuse": 0, "transmission": 0.8, "ior": 1.5, "dispersion": 0.05 })),
        ("absorption", json!({ "diffuse": 0, "transmission": 0.8, "absorption": 0.5 })),
        ("reflection", json!({ "reflection": 0.5 })),
        ("gloss", json!({ "reflection": 0.5, "roughness": 0.3 })),
        ("fresnel", json!({ "reflection": 1, "fresnel": "dielectric" })),
        ("highlights", json!({ "specular": 0.5 })),
        ("emission", json!({ "emission": 0.5 })),
        ("image_texture", json!({ "diffuse": color })),
        ("bump_mapping", json!({ "bump": { "height": 0.1, "texture": { "noise": {} } } })),
    ];
    let places =
        [[0.0, 0.0, 0.0], [0.5, -2.5, 0.0]].map(|center| json!({ "sphere": { "center": center, "radius": 0.5 } }));
    kinds
        .into_iter()
        .flat_map(|(effect, material)| {
            let mut traps: Vec<Trap> = places
                .iter()
                .map(|place| Trap {
                    without: json!({}),
                    ..of_body(effect, material.clone(), json!({}), place.clone(), ball())
                })
                .collect();
            // Outside of a room that is around everything else.
            let room = json!({ "box": { "min": [-6, -6, -6], "max": [6, 6, 6], "material": "m" } });
            let mut outside =
                of_body(effect, material, json!({}), json!({ "sphere": { "center": [0, 9, 0], "radius": 1 } }), ball());
            for scene in [&mut outside.asked, &mut outside.shown] {
                scene["objects+"].as_array_mut().unwrap().push(room.clone());
            }
            outside.without = json!({ "objects+": [room] });
            traps.push(outside);
            traps
        })
        .collect()
}

fn of_surfaces() -> Vec<Trap> {
    let patterns = [
        ("checker_texture", json!({ "checker": { "a": 0.5, "b": 0.25, "size": 0.5, "axes": "xyz" } }), "checker"),
        (
            "gradient_texture",
            json!({ "gradient": { "from": [-1, 0, 0], "to": [1, 0.5, 0], "a": 0.5, "b": 0.25 } }),
            "gradient",
        ),
        ("noise_texture", json!({ "noise": { "a": 0.5, "b": 0.25 } }), "noise"),
    ];
    let mut traps = Vec::new();
    for (effect, pattern, kind) in patterns {
        // Of one color, and where no light shows it.
        let asked = json!({ "materials": { "m": { "diffuse": { kind: { "b": 0.5 } } } } });
        let mut whole = json!({ "materials": { "m": { "diffuse": null } } });
        change(&mut whole, &json!({ "materials": { "m": { "diffuse": pattern } } }));
        let shown = whole.clone();
        let mut same = shown.clone();
        change(&mut same, &asked);
        traps.push(Trap { effect, asked: same, without: json!({}), shown: shown.clone() });
        let mut unlit = shown.clone();
        change(&mut unlit, &json!({ "lights": [], "materials": { "m": { "ambient": 0.5 } } }));
        let without = json!({ "lights": [], "materials": { "m": { "ambient": 0.5 } } });
        traps.push(trap(effect, unlit, without, &json!({ "materials": { "m": { "ambient": pattern } } })));
    }
    traps
}

fn of_pictures() -> Vec<Trap> {
    let noise = json!({ "height": 0.1, "texture": { "noise": {} } });
    let tilted = json!({ "image": image([[128, 128, 255], [200, 100, 200]]) });
    let mut traps = Vec::new();
    let uniform = |b| json!({ "materials": { "m": { "diffuse": { "image": image([[255, 0, 255], b]) } } } });
    let pbr = |opacity: Value| json!({ "materials": { "m": { "diffuse": null, "pbr": { "opacity": opacity } } } });
    traps.extend([
        Trap { effect: "opacity", asked: pbr(json!({ "alpha": 1, "mode": "blend", "cutoff": 0.5 })), without: pbr(Value::Null),
            shown: pbr(json!({ "alpha": 0.5, "mode": "blend", "cutoff": 0.5 })) },
        Trap { effect: "image_texture", asked: uniform([255, 0, 255]), without: json!({ "materials": { "m": { "diffuse": [1, 0, 1] } } }),
            shown: uniform([255, 0, 0]) },
        Trap { effect: "bump_mapping", asked: json!({ "materials": { "m": { "bump": { "height": 0, "texture": { "noise": {} } } } } }),
            without: json!({}), shown: json!({ "materials": { "m": { "bump": noise } } }) },
        Trap { effect: "bump_mapping",
            asked: json!({ "materials": { "m": { "bump": { "height": 0.1, "texture": { "image": image([[80, 80, 80]; 2]) } } } } }),
            without: json!({}),
            shown: json!({ "materials": { "m": { "bump": { "height": 0.1, "texture": { "image": image([[80, 80, 80], [99, 99, 99]]) } } } } }) },
        Trap { effect: "normal_mapping", asked: json!({ "materials": { "m": { "normal_map": { "image": image([[128, 128, 255]; 2]) } } } }),
            without: json!({}), shown: json!({ "materials": { "m": { "normal_map": tilted } } }) },
    ]);
    // On what no light shows.
    for (effect, key, map) in [("bump_mapping", "bump", noise), ("normal_mapping", "normal_map", tilted)] {
        let dark = json!({ "diffuse": 0, "emission": 0.25 });
        let mut material = dark.clone();
        material[key] = map;
        traps.push(trap(
            effect,
            json!({ "materials": { "m": material } }),
            json!({ "materials": { "m": dark } }),
            &json!({ "materials": { "m": { "specular": 0.05 } } }),
        ));
    }
    traps
}

/// Dispersion of layers that no volume shows, and what makes one of them.
fn of_layers(layers: Value, shown: Value, fidelity: &str) -> Trap {
    let scene = |layers: Value| {
        let mut scene = json!({
            "materials": { "m": { "diffuse": null, "pbr": { "metallic": 0, "roughness": 0, "ior": 1.5 } } },
            "render": { "fidelity": fidelity, "samples": 4 }
        });
        change(&mut scene["materials"]["m"]["pbr"], &layers);
        scene
    };
    let (without, mut asked) = (scene(layers.clone()), scene(layers));
    asked["materials"]["m"]["pbr"]["dispersion"] = json!(2);
    trap("dispersion", asked, without, &json!({ "materials": { "m": { "pbr": shown } } }))
}

fn of_rays() -> Vec<Trap> {
    let of = |effect, material: Value, added: Value| {
        trap(effect, json!({ "materials": { "m": material } }), json!({}), &json!({ "materials": { "m": added } }))
    };
    // What mirrors no deeper than the camera's rays.
    let deep = |effect, material: Value, key: Value| {
        let asked = json!({ "materials": { "m": material }, "render": { "max_depth": 1 } });
        let mut with = asked.clone();
        change(&mut with, &json!({ "materials": { "m": key } }));
        trap(effect, with, asked, &json!({ "render": { "max_depth": 3 } }))
    };
    vec![
        of("gloss", json!({ "roughness": 0.3 }), json!({ "reflection": 0.05 })),
        of("fresnel", json!({ "fresnel": "dielectric", "ior": 1.5 }), json!({ "reflection": 0.5 })),
        of("dispersion", json!({ "dispersion": 0.05 }), json!({ "transmission": 0.5, "ior": 1.5 })),
        of(
            "dispersion",
            json!({ "dispersion": 0.1, "fresnel": "dielectric", "ior": 1.5 }),
            json!({ "reflection": 0.5 }),
        ),
        of_layers(json!({ "transmission": 1, "thin": true }), json!({ "thin": false }), "fast"),
        of_layers(json!({ "metallic": 1, "transmission": 1 }), json!({ "metallic": 0 }), "faithful"),
        of("absorption", json!({ "absorption": 0.5 }), json!({ "transmission": 0.1 })),
        // An opaque ball beside the eye, and around it.
        of_body(
            "absorption",
            json!({ "absorption": 0.05 }),
            json!({}),
            ball(),
            json!({ "sphere": { "center": [0, 0, 4], "radius": 8 } }),
        ),
        deep("gloss", json!({ "reflection": 0.5 }), json!({ "roughness": 0.3 })),
        Trap {
            effect: "emission",
            asked: json!({ "materials": { "other": { "emission": 1 } } }),
            without: json!({}),
            shown: json!({ "materials": { "m": { "emission": 0.01 } } }),
        },
        Trap {
            effect: "transmissive_shadows",
            asked: json!({ "render": { "shadows": "transmissive" } }),
            without: json!({ "render": { "shadows": "opaque" } }),
            shown: json!({ "render": { "shadows": "transmissive" }, "materials": { "m": { "transmission": 0.3 } } }),
        },
        Trap {
            effect: "depth_of_field",
            asked: json!({ "camera": { "pinhole": { "focus_distance": 3, "aperture": 0 } } }),
            without: json!({}),
            shown: json!({ "camera": { "pinhole": { "focus_distance": 3, "aperture": 0.2 } } }),
        },
        Trap {
            effect: "fog",
            asked: json!({ "fog": { "density": 0 } }),
            without: json!({ "fog": null }),
            shown: json!({ "fog": { "density": 0.05 } }),
        },
    ]
}

fn of_surroundings() -> Vec<Trap> {
    let map = |a, b, intensity: f64| json!({ "environment": { "image": picture([a, b]), "intensity": intensity } });
    let seen = map([255, 0, 255], [0, 255, 0], 1.0);
    let mut shown = seen.clone();
    shown["fog"] = Value::Null;
    let mut in_fog = seen.clone();
    in_fog["fog"] = json!({ "density": 0.02 });
    let rooms = [
        json!({ "box": { "min": [-9, -9, -9], "max": [9, 9, 9], "material": "m" } }),
        json!({ "sphere": { "center": [0, 0, 0], "radius": 9, "material": "m" } }),
        json!({ "sphere": { "center": [0, 0, 0], "radius": 9, "material": "m", "hollow": true } }),
    ];
    let mut traps = vec![
        Trap {
            effect: "environment_map",
            asked: in_fog,
            without: json!({ "fog": { "density": 0.02 } }),
            shown: shown.clone(),
        },
        Trap {
            effect: "environment_map",
            asked: map([255, 0, 255], [0, 255, 0], 0.0),
            without: json!({ "background": 0 }),
            shown: shown.clone(),
        },
        Trap {
            effect: "environment_map",
            asked: map([255, 0, 255], [255, 0, 255], 1.0),
            without: json!({ "background": [1, 0, 1] }),
            shown: shown.clone(),
        },
    ];
    for room in rooms {
        let mut asked = seen.clone();
        asked["objects+"] = json!([room]);
        traps.push(Trap {
            effect: "environment_map",
            asked,
            without: json!({ "objects+": [room] }),
            shown: shown.clone(),
        });
    }
    traps
}

#[test]
fn what_shows_nothing_is_off_and_a_little_more_switches_it_on() {
    let traps: Vec<Trap> = [
        of_sheets(),
        hidden(),
        of_lights(),
        of_hidden_lights(),
        of_surfaces(),
        of_pictures(),
        of_rays(),
        of_surroundings(),
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut scenes = Vec::new();
    for (setting, scene) in settings() {
        for (number, trap) in traps.iter().enumerate() {
            let with = |changes: &Value| {
                let mut scene = scene.clone();
                change(&mut scene, changes);
                scene
            };
            let name = format!("{setting}, trap {number}, {}", trap.effect);
            scenes.push((name, json!([trap.effect, with(&trap.asked), with(&trap.without), with(&trap.shown)])));
        }
    }
    assert!(scenes.len() >= 150, "{}", scenes.len());
    judge(scenes, |scene| {
        let effect = scene[0].as_str().unwrap();
        let [asked, without, shown] = [1, 2, 3].map(|index| {
            let scene = loaded(&scene[index]).scene;
            let state = scene.effects.iter().find(|entry| entry.effect.name() == effect).unwrap().state;
            (state, render(&scene, Region::whole(24, 16), &Control::default()).unwrap())
        });
        let mut wrong = Vec::new();
        if asked.0 == State::On {
            wrong.push("it is on");
        }
        if asked.1.film.pixels != without.1.film.pixels {
            wrong.push("without it the picture is another one");
        }
        if asked.1.rays != without.1.rays {
            wrong.push("without it there are other rays");
        }
        if shown.0 != State::On {
            wrong.push("it is off where it shows");
        }
        if shown.1.film.pixels == without.1.film.pixels {
            wrong.push("it does not show where it should");
        }
        wrong.into_iter().map(str::to_owned).collect()
    });
}
