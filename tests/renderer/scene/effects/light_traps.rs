//! Lights that are asked for in vain: black ones, those that end before any surface, and those that something opaque hides.

use super::pairs::{Trap, change, trap};
use serde_json::{Value, json};

pub(super) fn of_lights() -> Vec<Trap> {
    let dim = json!({ "intensity": 0.05 });
    let black = |light: Value| {
        let scene = |by: &Value| {
            let mut light = light.clone();
            change(light.as_object_mut().unwrap().values_mut().next().unwrap(), by);
            json!({ "lights+": [light] })
        };
        (scene(&json!({ "intensity": 0 })), scene(&dim))
    };
    let area = json!({ "point": { "position": [-2, 3, 2], "area": { "disc": { "radius": 0.8 } } } });
    let lights = [
        ("soft_shadows", area.clone()),
        ("soft_shadows", json!({ "directional": { "direction": [1, -2, -1], "area": { "angle_deg": 20 } } })),
        ("spot_lights", json!({ "spot": { "position": [-2, 3, 2], "direction": [2, -3, -2], "outer_deg": 20 } })),
        ("light_falloff", json!({ "point": { "position": [-2, 3, 2], "falloff": "inverse_square" } })),
    ];
    let mut traps: Vec<Trap> = lights
        .iter()
        .map(|(effect, light)| {
            let (asked, shown) = black(light.clone());
            Trap { effect, asked, without: json!({}), shown }
        })
        .collect();
    // It ends before it gets anywhere.
    let ends = |y: f64| json!({ "point": { "position": [-2, y, 2], "falloff": { "linear": { "reach": 5 } } } });
    let range = |y: f64| json!({ "point": { "position": [-2, y, 2], "falloff": { "windowed": { "range": 5 } } } });
    for [asked, shown] in [[ends(1_000.0), ends(3.0)], [range(1_000.0), range(3.0)]] {
        let with = |light: Value| json!({ "lights+": [light] });
        traps.push(Trap { effect: "light_falloff", asked: with(asked), without: json!({}), shown: with(shown) });
    }
    // On what scatters none of it.
    let dark = json!({ "diffuse": 0, "emission": 0.25 });
    for (effect, light) in lights {
        let scene = |specular: f64| json!({ "lights": [light], "materials": { "m": { "diffuse": 0, "emission": 0.25, "specular": specular } } });
        let without = json!({ "lights": [], "materials": { "m": dark } });
        traps.push(Trap { effect, asked: scene(0.0), without, shown: scene(0.5) });
    }
    let dark = json!({ "materials": { "m": dark } });
    let gathers = json!({ "materials": { "m": { "diffuse": 0, "emission": 0.25, "ambient": 0.5 } }, "render": { "color_bleeding": true } });
    let gathered = json!({ "materials": { "m": { "diffuse": 0, "emission": 0.25 } }, "ambient": 0 });
    traps.extend([
        trap(
            "shadows",
            dark.clone(),
            json!({ "materials": { "m": { "diffuse": 0, "emission": 0.25 } }, "render": { "shadows": "none" } }),
            &json!({ "materials": { "m": { "specular": 0.01 } } }),
        ),
        trap(
            "ambient_light",
            dark.clone(),
            json!({ "materials": { "m": { "diffuse": 0, "emission": 0.25 } }, "ambient": 0 }),
            &json!({ "materials": { "m": { "ambient": 0.01 } } }),
        ),
        trap(
            "color_bleeding",
            gathers.clone(),
            gathered.clone(),
            &json!({ "materials": { "m": { "diffuse": 0.01 } } }),
        ),
        trap("ambient_light", gathers, gathered, &json!({ "materials": { "m": { "diffuse": 0.01 } } })),
        trap(
            "color_bleeding",
            json!({ "render": { "color_bleeding": true, "max_depth": 1 } }),
            json!({ "render": { "max_depth": 1 } }),
            &json!({ "render": { "max_depth": 2 } }),
        ),
        trap(
            "highlights",
            json!({ "materials": { "m": { "specular": 0.5 } }, "lights": [] }),
            json!({ "lights": [] }),
            &json!({ "lights": [{ "point": { "position": [3, 4, 3], "intensity": 0.05 } }] }),
        ),
    ]);
    traps
}

/// Lights below the floor, or outside of a room.
pub(super) fn of_hidden_lights() -> Vec<Trap> {
    let room = json!({ "box": { "min": [-6, -6, -6], "max": [6, 6, 6], "material": "m" } });
    let bumps = json!({ "m": { "bump": { "height": 0.3, "texture": { "noise": { "size": 0.2 } } } } });
    let surroundings = [
        json!({}),
        json!({ "objects+": [room] }),
        json!({ "materials": bumps }),
        json!({ "objects+": [room], "materials": bumps }),
    ];
    let lights = |place: [f64; 3], up: f64| {
        let area = |area: Value| json!({ "point": { "position": place, "area": area } });
        [
            ("soft_shadows", area(json!({ "disc": { "radius": 0.8 } }))),
            ("soft_shadows", area(json!({ "parallelogram": { "u": [0.5, 0, 0], "v": [0, 0.5, 0.5] } }))),
            ("spot_lights", json!({ "spot": { "position": place, "direction": [0, up, 0], "outer_deg": 40 } })),
            ("light_falloff", json!({ "point": { "position": place, "falloff": "inverse_square", "intensity": 4 } })),
        ]
    };
    let sky = |up: f64| {
        let area = json!({ "angle_deg": 20 });
        ("soft_shadows", json!({ "directional": { "direction": [1, up, -1], "area": area } }))
    };
    let mut traps = Vec::new();
    for around in &surroundings {
        let is_room = around.get("objects+").is_some();
        let places =
            if is_room { vec![[-2.0, 9.0, 2.0], [8.0, 2.0, 2.0]] } else { vec![[-2.0, -4.0, 2.0], [9.0, -2.5, -40.0]] };
        for place in places {
            // The sun shines where there is no room.
            let hidden = lights(place, 1.0).into_iter().chain([sky(if is_room { -2.0 } else { 2.0 })]);
            let shown = lights([-2.0, 3.0, 2.0], -1.0).into_iter().chain([sky(-2.0)]);
            for ((effect, hidden), (_, light)) in hidden.zip(shown) {
                let with = |light: Value, around: &Value| {
                    let mut scene = around.clone();
                    scene["lights+"] = json!([light]);
                    scene
                };
                let is_sky = hidden.get("directional").is_some();
                let open = if is_sky && is_room {
                    json!({ "materials": around.get("materials").cloned().unwrap_or(json!({})) })
                } else {
                    around.clone()
                };
                traps.push(Trap {
                    effect,
                    asked: with(hidden, around),
                    without: around.clone(),
                    shown: with(light, &open),
                });
            }
        }
    }
    traps
}
