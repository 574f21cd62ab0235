//! The table of effects: what it says is on is what the kernels read, what it says is removed leaves no trace, and what it
//! takes out of a built scene is what a description without it would not have.

use crate::common::{Random, on_own_threads, read, scene_names};
use data_encoding::BASE64;
use image::{ImageFormat, Rgb, RgbImage};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::LazyLock;
use strahl::accel::Blockers;
use strahl::film::Region;
use strahl::lanes::Real;
use strahl::render::{Control, render};
use strahl::scene::compile::Precise;
use strahl::scene::effects::{Effect, State};
use strahl::scene::world::{Pruning, World};
use strahl::scene::{Format, Loaded, Overrides, Scene, load};
use strahl::shading::light::{Falloff, Source};
use strahl::shading::material::{Fresnel, Material};
use strahl::shading::texture::bump::BumpMap;
use strahl::shading::texture::checker::BaseColor;
use strahl::shading::texture::pattern::Pattern;
use strahl::trace::variants::KernelVariant;

fn loaded(description: &Value) -> Loaded {
    load(description.to_string().as_bytes(), Format::Json, &Overrides::default())
        .unwrap_or_else(|problems| panic!("{problems}\n{description:#}"))
}

fn pixels(scene: &Scene) -> Vec<[f32; 3]> {
    let region = Region::whole(scene.width, scene.height);
    render(scene, region, &Control::default()).unwrap().film.pixels
}

/// Every scene of the repository, small, as it is and as it looks with other settings.
fn small_scenes() -> Vec<(String, Value)> {
    let mut scenes = Vec::new();
    for name in scene_names().into_iter().filter(|name| !name.starts_with("spheres/flake_9")) {
        let mut scene: Value = serde_json::from_slice(&read(&format!("scenes/{name}.json"))).unwrap();
        scene["image"] = json!({ "width": 32, "height": 20 });
        scenes.push((name.clone(), scene.clone()));
        scene["render"]["max_depth"] = json!(1);
        scenes.push((format!("{name}, one ray deep"), scene.clone()));
        scene["render"] = json!({ "min_weight": 1, "shadows": "transmissive" });
        scene["lights"] = json!([]);
        scenes.push((format!("{name}, in the dark"), scene));
    }
    scenes
}

/// Pictures of two colours, of one, and a flat normal map.
static IMAGES: LazyLock<[String; 3]> = LazyLock::new(|| {
    [
        RgbImage::from_fn(4, 4, |x, y| Rgb([(x * 60) as u8, (y * 60) as u8, 200])),
        RgbImage::from_pixel(2, 2, Rgb([255, 0, 255])),
        RgbImage::from_pixel(2, 2, Rgb([128, 128, 255])),
    ]
    .map(|image| {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        format!("data:image/png;base64,{}", BASE64.encode(bytes.get_ref()))
    })
});

fn one_of(r: &mut Random, values: &[Value]) -> Value {
    values[r.below(values.len())].clone()
}

/// A colour that is black more often than chance would have it.
fn gray(r: &mut Random) -> Value {
    if r.below(3) == 0 { json!(0) } else { json!(r.between(0.1, 0.9)) }
}

fn diffuse(r: &mut Random) -> Value {
    let (a, b) = (gray(r), gray(r));
    let b = if r.below(3) == 0 { a.clone() } else { b };
    let image = |k: usize| json!({ "image": { "source": IMAGES[k], "mapping": { "planar": { "axes": "xy" } } } });
    match r.below(8) {
        0 => json!({ "checker": { "a": a, "b": b, "size": 0.5, "axes": "xyz" } }),
        1 => json!({ "gradient": { "from": [-1, 0, 0], "to": [1, 0.5, 0], "a": a, "b": b } }),
        2 => json!({ "noise": { "a": a, "b": b } }),
        3 => image(0),
        4 => image(1),
        _ => gray(r),
    }
}

fn material(r: &mut Random) -> Value {
    let mut material = json!({
        "diffuse": diffuse(r), "specular": gray(r), "reflection": gray(r), "transmission": gray(r),
        "ior": one_of(r, &[json!(1), json!(1.5)]),
        "fresnel": one_of(r, &[json!("none"), json!("none"), json!("dielectric"), json!("conductor")]),
        "absorption": one_of(r, &[json!(0), json!(0.5)]), "emission": one_of(r, &[json!(0), json!(0), json!(0.3)]),
        "roughness": one_of(r, &[json!(0), json!(0), json!(0.3)]),
        "dispersion": one_of(r, &[json!(0), json!(0), json!(0.02)])
    });
    if r.below(3) == 0 {
        material["ambient"] = diffuse(r);
    }
    let image = |k: usize| json!({ "source": IMAGES[k], "mapping": { "planar": { "axes": "xy" } } });
    let image = image(one_of(r, &[json!(0), json!(1), json!(2)]).as_u64().unwrap() as usize);
    match r.below(5) {
        0 => {
            let texture = one_of(r, &[json!({ "noise": {} }), json!({ "image": image })]);
            material["bump"] = json!({ "height": one_of(r, &[json!(0), json!(0.1)]), "texture": texture });
        }
        1 => material["normal_map"] = json!({ "image": image }),
        _ => {}
    }
    material
}

fn body(r: &mut Random) -> Value {
    let (p, q, size) = (r.point(1.5), r.point(1.5), r.between(0.2, 1.2));
    let min: [f64; 3] = std::array::from_fn(|i| p[i].min(q[i]));
    let mut max: [f64; 3] = std::array::from_fn(|i| p[i].max(q[i]));
    if r.below(4) == 0 {
        max[1] = min[1];
    }
    let tilted = r.point(1.0);
    let upright = one_of(r, &[json!([0, 1, 0]), json!(tilted)]);
    let mut body = match r.below(7) {
        0 | 1 => json!({ "sphere": { "center": p, "radius": size } }),
        // Of surfaces in the same place another one may be met where light passes.
        2 => json!({ "plane": { "point": [0, r.between(-2.0, -1.0), 0], "normal": upright } }),
        3 => json!({ "box": { "min": min, "max": max } }),
        4 => json!({ "disc": { "center": p, "normal": q, "radius": size } }),
        5 => json!({ "cylinder": { "base": p, "top": q, "radius": 0.3, "capped": r.below(2) == 0 } }),
        _ => {
            let normals: Vec<_> = (0..3).map(|_| r.point(1.0)).collect();
            json!({ "mesh": { "vertices": [p, q, r.point(1.5)], "faces": [[0, 1, 2]], "normals": normals } })
        }
    };
    let (kind, keys) = body.as_object_mut().unwrap().iter_mut().next().unwrap();
    if !["disc", "mesh"].contains(&kind.as_str()) && r.below(6) == 0 {
        keys["hollow"] = json!(true);
    }
    if r.below(8) > 0 {
        keys["material"] = one_of(r, &[json!("a"), json!("b")]);
    }
    body
}

fn object(r: &mut Random) -> Value {
    let object = body(r);
    let motion = one_of(r, &[json!({}), json!({ "translate": [0, 0, 0] }), json!({ "translate": [0.2, 0.1, 0] })]);
    let transform = one_of(r, &[json!({}), json!({ "translate": [0.1, 0, 0], "scale": 0.9 })]);
    match r.below(10) {
        0 => json!({ "group": { "objects": [object], "transform": transform, "motion": motion } }),
        1 => json!({ "instance": { "of": "thing", "transform": transform } }),
        _ => object,
    }
}

fn light(r: &mut Random) -> Value {
    let size = one_of(r, &[json!(0), json!(0.5)]);
    let color = gray(r);
    let at = [r.between(-3.0, 3.0), r.between(0.5, 4.0), r.between(-3.0, 3.0)];
    let mut light = match r.below(3) {
        0 => json!({ "point": { "position": at, "color": color } }),
        1 => json!({ "directional": { "direction": [0.3, -1, at[2]], "color": color } }),
        _ => json!({ "spot": { "position": at, "direction": at.map(|x| -x), "outer_deg": 60, "color": color } }),
    };
    let (kind, keys) = light.as_object_mut().unwrap().iter_mut().next().unwrap();
    let directional = kind == "directional";
    if r.below(4) == 0 {
        keys["area"] = if directional { json!({ "angle_deg": size }) } else { json!({ "disc": { "radius": size } }) };
    }
    if !directional && r.below(3) == 0 {
        keys["falloff"] = json!("inverse_square");
    }
    light
}

/// A scene that asks for many things, a good part of them in vain.
fn random_scene(seed: u64) -> Value {
    let mut random = Random::new(seed);
    let r = &mut random;
    let eye = [r.between(-1.0, 1.0), r.between(0.2, 2.0), 5.0];
    let view = json!({ "eye": eye, "look_at": [0, 0, 0] });
    let with = |key: &str, value: Value| {
        let mut view = view.clone();
        view[key] = value;
        view
    };
    let camera = match r.below(8) {
        0 => json!({ "orthographic": with("height", json!(4)) }),
        1 => json!({ "fisheye": with("fov_deg", json!(120)) }),
        2 => json!({ "pinhole": with("focus_distance", json!(4)) }),
        3 => json!({ "pinhole": with("aperture", json!(0.2)) }),
        _ => json!({ "pinhole": view }),
    };
    // Single bodies may hide no light.
    let count = [1, 1, 2, 4, 6][r.below(5)];
    let mut scene = json!({
        "version": 1, "image": { "width": 16, "height": 10 }, "camera": camera,
        "background": gray(r), "ambient": gray(r),
        "lights": (0..r.below(4)).map(|_| light(r)).collect::<Vec<_>>(),
        "materials": { "a": material(r), "b": material(r), "unused": material(r) },
        "definitions": { "thing": [body(r)], "unplaced": [body(r)] },
        "objects": (0..count).map(|_| object(r)).collect::<Vec<_>>(),
        "render": {
            "shadows": one_of(r, &[json!("opaque"), json!("opaque"), json!("transmissive"), json!("none")]),
            "precision": one_of(r, &[json!("single"), json!("double")]),
            "antialias": r.below(2) == 0
        }
    });
    let render = scene["render"].as_object_mut().unwrap();
    let mut ask = |key: &str, value: Value| render.insert(key.to_owned(), value);
    match r.below(5) {
        0 => ask("max_depth", json!(1)),
        1 => ask("min_weight", one_of(r, &[json!(1), json!(0.95), json!(0.3)])),
        2 => ask("max_depth", json!(6)),
        3 => ask("accuracy", one_of(r, &[json!({ "proved": { "max_codes": 0 } }), json!({ "fixed": {} })])),
        _ => None,
    };
    if r.below(6) == 0 {
        ask("color_bleeding", json!(true));
    }
    if r.below(3) > 0 {
        ask("samples", one_of(r, &[json!(2), json!(16)]));
    }
    if r.below(5) == 0 {
        scene["fog"] = json!({ "density": one_of(r, &[json!(0), json!(0.1)]) });
    }
    if r.below(4) == 0 {
        let image = &IMAGES[r.below(2)];
        scene["environment"] = json!({ "image": image, "intensity": one_of(r, &[json!(0), json!(0.5)]) });
    }
    scene
}

/// The scenes of the tests below. Some random ones are refused.
fn all_scenes(count: usize) -> Vec<(String, Value)> {
    let random = (0..)
        .map(|seed| (format!("seed {seed}"), random_scene(seed)))
        .filter(|(_, scene)| load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).is_ok());
    small_scenes().into_iter().chain(random.take(count)).collect()
}

/// What is wrong with which scenes.
fn judge(scenes: Vec<(String, Value)>, wrong: impl Fn(&Value) -> Vec<String> + Sync) {
    let found: Vec<String> = on_own_threads(|| {
        let each = |(name, scene): &(String, Value)| -> Vec<String> {
            wrong(scene).into_iter().map(|what| format!("{name}: {what}")).collect()
        };
        scenes.par_iter().flat_map_iter(each).collect()
    });
    assert!(found.is_empty(), "{} of {}:\n{}", found.len(), scenes.len(), found[..found.len().min(20)].join("\n"));
}

/// What the kernels read, item by item.
struct Told<'a, R> {
    world: &'a World<R>,
}

impl<R: Real> Told<'_, R> {
    fn any(&self, test: impl Fn(&Material<R>, bool) -> bool) -> bool {
        let items = self.world.geometries.iter().flat_map(|geometry| &geometry.items);
        let mut bodies = items.filter(|item| !item.is_placed());
        bodies.any(|item| test(&self.world.materials[item.material as usize], item.closed && !item.hollow))
    }

    fn item(&self, test: impl Fn(&strahl::accel::Item<R>) -> bool) -> bool {
        self.world.geometries.iter().flat_map(|geometry| &geometry.items).any(test)
    }

    fn light(&self, test: impl Fn(&strahl::shading::light::Light<R>) -> bool) -> bool {
        self.world.lights.iter().any(|light| bright(light.color) && test(light))
    }

    /// Whether a ray may be followed that leaves a surface, from the rules alone.
    fn follows(&self) -> bool {
        let most = |material: &Material<R>| {
            let channel = |c: usize| {
                let (r_s, r_t) = (material.reflection[c].to_f64(), material.transmission[c].to_f64());
                if material.fresnel == Fresnel::Conductor { 1.0 } else { r_s + r_t }
            };
            channel(0).max(channel(1)).max(channel(2))
        };
        let split = self.world.spectrum.as_ref().map_or(1.0, |spectrum| spectrum.strongest().max_element());
        let heavy = |least: f64| self.any(|material, _| most(material) * split >= least * (1.0 - 1e-6));
        self.world.rules.max_depth > 1 && !matches!(self.world.rules.pruning, Pruning::Weight(least) if !heavy(least))
    }

    fn has_pattern(&self, test: fn(&Pattern) -> bool) -> bool {
        self.any(|material, _| {
            let textures = material.textures.as_ref();
            textures.is_some_and(|all| [&all.diffuse, &all.ambient].into_iter().flatten().any(test))
        })
    }

    fn has_bump(&self, test: fn(&BumpMap) -> bool) -> bool {
        self.any(|material, _| material.textures.as_ref().and_then(|textures| textures.bump.as_ref()).is_some_and(test))
    }

    fn of(&self, effect: Effect) -> Option<bool> {
        let (world, zero) = (self.world, R::from_f64(0.0));
        let gathers = world.rules.color_bleeding && world.rules.max_depth > 1;
        let transmissive = world.rules.shadows == Some(Blockers::Transmissive);
        let absorbs = |m: &Material<R>, filled: bool| filled && bright(m.absorption) && bright(m.transmission);
        let mirrors = |m: &Material<R>| bright(m.reflection) || m.fresnel == Fresnel::Conductor;
        let checks = |color: &BaseColor<R>| matches!(color, BaseColor::Checker { .. });
        let shines = |color: &BaseColor<R>| match *color {
            BaseColor::Uniform(color) => bright(color),
            BaseColor::Checker { a, b, .. } => bright(a) || bright(b),
        };
        Some(match effect {
            Effect::AmbientLight => bright(world.ambient),
            Effect::DiffuseReflection => (self.light(|_| true) || gathers) && self.any(|m, _| shines(&m.diffuse)),
            Effect::Highlights => self.light(|_| true) && self.any(|m, _| bright(m.specular)),
            Effect::Shadows => world.rules.shadows.is_some(),
            Effect::TransmissiveShadows => transmissive && self.any(|m, _| bright(m.transmission)),
            Effect::ColoredShadows => transmissive && self.any(absorbs),
            Effect::Reflection => self.follows() && self.any(|m, _| mirrors(m)),
            Effect::Transmission => self.follows() && self.any(|m, _| bright(m.transmission)),
            Effect::Absorption => self.any(absorbs),
            Effect::Emission => self.any(|m, _| bright(m.emission)),
            Effect::Fog => world.fog.is_some(),
            Effect::Fresnel => {
                let shows = |m: &Material<R>| bright(m.reflection) || bright(m.transmission);
                let dielectric = |m: &Material<R>| m.fresnel == Fresnel::Dielectric && shows(m);
                self.follows() && self.any(|m, _| dielectric(m) || m.fresnel == Fresnel::Conductor)
            }
            Effect::TotalReflection | Effect::Refraction => {
                let bends = |m: &Material<R>, filled| filled && bright(m.transmission) && m.ior != R::from_f64(1.0);
                self.follows() && self.any(bends)
            }
            Effect::HollowBodies => self.item(|item| item.hollow),
            Effect::CheckerTexture => self.any(|m, _| checks(&m.diffuse) || m.ambient.as_ref().is_some_and(checks)),
            Effect::GradientTexture => self.has_pattern(|pattern| matches!(pattern, Pattern::Gradient { .. })),
            Effect::NoiseTexture => self.has_pattern(|pattern| matches!(pattern, Pattern::Noise { .. })),
            Effect::ImageTexture => self.has_pattern(|pattern| matches!(pattern, Pattern::Image(_))),
            Effect::BumpMapping => self.has_bump(|bump| !matches!(bump, BumpMap::Normals(_))),
            Effect::NormalMapping => self.has_bump(|bump| matches!(bump, BumpMap::Normals(_))),
            Effect::EnvironmentMap => world.environment.is_some(),
            Effect::SmoothNormals => self.item(|item| item.is_smooth()),
            Effect::SpotLights => self.light(|light| matches!(light.source, Source::Spot { .. })),
            Effect::LightFalloff => self.light(|light| !matches!(light.falloff, Falloff::None)),
            Effect::Instancing => self.item(|item| item.is_placed()),
            Effect::SoftShadows => world.lights.iter().any(|light| light.area.is_some()),
            Effect::Gloss => {
                self.follows() && self.any(|m, _| m.alpha > zero && (mirrors(m) || bright(m.transmission)))
            }
            Effect::Dispersion => self.follows() && self.any(|m, _| m.dispersion > zero && bright(m.transmission)),
            Effect::DepthOfField => world.camera.lens().is_some(),
            Effect::ColorBleeding => gathers,
            _ => return None,
        })
    }
}

fn bright<R: Real>(color: [R; 3]) -> bool {
    color.iter().any(|channel| *channel > R::from_f64(0.0))
}

#[test]
fn what_the_plan_says_is_on_is_what_the_kernel_was_told() {
    judge(all_scenes(1_000), |description| {
        let scene = loaded(description).scene;
        let state = |effect: Effect| scene.effects.iter().find(|entry| entry.effect == effect).unwrap().state;
        let (effects, axes, told): (_, _, Vec<(Effect, Option<bool>)>) = match &scene.world {
            Precise::Single(world) => (
                world.effects,
                KernelVariant::of(world).axes(),
                Effect::ALL.iter().map(|effect| (*effect, Told { world }.of(*effect))).collect(),
            ),
            Precise::Double(world) => (
                world.effects,
                KernelVariant::of(world).axes(),
                Effect::ALL.iter().map(|effect| (*effect, Told { world }.of(*effect))).collect(),
            ),
        };
        let mut wrong = Vec::new();
        for (effect, told) in told {
            let on = state(effect) == State::On;
            let told = told.unwrap_or_else(|| match effect {
                Effect::Antialiasing => scene.refines(),
                Effect::DoublePrecision => matches!(scene.world, Precise::Double(_)),
                Effect::SpecialProjection => description["camera"].get("pinhole").is_none(),
                _ => effects.has(effect),
            });
            let flagged = effects.has(effect) || effect == Effect::Antialiasing && on;
            if (on, on) != (told, flagged) {
                wrong.push(format!(
                    "{} is {:?}, the kernel was told {told}, its flag is {flagged}",
                    effect.name(),
                    state(effect)
                ));
            }
        }
        // Kernels hold what is on.
        let named = description["render"]["samples"].as_u64();
        let default = if effects.needs_sampling() { 64 } else { 1 };
        if u64::from(scene.samples) != named.unwrap_or(default) || effects.needs_sampling() && !axes[3] {
            wrong.push(format!("{} samples, kernel {axes:?}", scene.samples));
        }
        let reflects = effects.has(Effect::Reflection) || effects.has(Effect::TotalReflection);
        let lacks = reflects && !axes[0] || effects.has(Effect::Transmission) && !axes[1];
        if lacks || effects.has_details() && !axes[2] {
            wrong.push(format!("the kernel {axes:?} lacks what is on"));
        }
        wrong
    });
}

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

/// The colour in the place of one of a kind.
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

/// Red, green and blue of a colour.
fn rgb(color: &Value) -> [f64; 3] {
    let color: strahl::scene::description::Color = serde_json::from_value(color.clone()).unwrap();
    color.0.to_array()
}

fn is_black(color: &Value) -> bool {
    color.is_null() || rgb(color) == [0.0; 3]
}

/// Writes a description, in which every default is written down, without an effect. False where that is no matter of one
/// effect alone.
fn switch_off(scene: &mut Value, effect: Effect) -> bool {
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
                    // The colour of the picture of one colour.
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
        Effect::Antialiasing => scene["render"]["antialias"] = json!(false),
        Effect::ColoredShadows
        | Effect::TotalReflection
        | Effect::HollowBodies
        | Effect::SmoothNormals
        | Effect::Instancing
        | Effect::SpecialProjection
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
    let removed_in: std::sync::Mutex<BTreeMap<&str, usize>> = std::sync::Mutex::default();
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
            // The mean of two colours is rounded before or after, and what moves has coordinates of its own.
            let rounds = [Effect::CheckerTexture, Effect::MotionBlur].contains(&entry.effect);
            let off = |(a, b): (&[f32; 3], &[f32; 3])| {
                (0..3).any(|c| if rounds { (a[c] - b[c]).abs() > 1e-4 * a[c].max(1.0) } else { a[c] != b[c] })
            };
            // At edges roundings are seen.
            let many = if rounds { here.len() / 16 } else { 0 };
            // The mean of a picture is not that of its colour in the description.
            if entry.effect != Effect::ImageTexture && here.iter().zip(&there).filter(|pair| off(*pair)).count() > many
            {
                wrong.push(format!("without {}", entry.effect.name()));
            }
        }
        wrong
    });
}

/// A lone plane, a lone ball: no shadow rays, and the same picture as with them.
#[test]
fn shadow_rays_are_left_out_only_where_nothing_can_hide_a_light() {
    let scene = |object: Value, light: Value| {
        json!({
            "version": 1, "image": { "width": 32, "height": 20 },
            "camera": { "pinhole": { "eye": [0, 2, 5], "look_at": [0, 0, 0] } },
            "lights": [light], "objects": [object]
        })
    };
    let plane = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } });
    let tilted = json!({ "plane": { "point": [0, 0, 0], "normal": [0.1, 1, 0] } });
    let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } });
    let around = json!({ "sphere": { "center": [0, 0, 0], "radius": 30 } });
    let block = json!({ "box": { "min": [-1, -1, -1], "max": [1, 1, 1] } });
    let disc = json!({ "disc": { "center": [0, 0, 0], "normal": [1, 2, 3], "radius": 1 } });
    let ring = json!({ "torus": { "center": [0, 0, 0], "major_radius": 1, "minor_radius": 0.3 } });
    let sheet = json!({ "quad": { "vertices": [[-1, 0, 1], [1, 0, 1], [1, 1, -1], [-1, 0, -1]] } });
    let placed = json!({ "group": { "objects": [ball], "transform": { "scale": 2 } } });
    let sun = json!({ "directional": { "direction": [1, -2, -1.5] } });
    let lamp = json!({ "point": { "position": [3, 4, 3], "area": { "disc": { "radius": 0.5 } } } });
    let edge = json!({ "point": { "position": [3, 1.00001, 3] } });
    for (object, light, shadows) in [
        (&plane, &sun, false),
        (&plane, &lamp, false),
        (&tilted, &sun, false),
        (&tilted, &lamp, true),
        (&ball, &sun, false),
        (&ball, &lamp, false),
        (&around, &lamp, true),
        (&block, &sun, false),
        (&block, &lamp, false),
        (&block, &edge, true),
        (&disc, &lamp, false),
        (&ring, &sun, true),
        (&sheet, &sun, true),
        (&placed, &sun, true),
    ] {
        let description = scene(object.clone(), light.clone());
        let built = loaded(&description);
        let region = Region::whole(32, 20);
        let picture = render(&built.scene, region, &Control::default()).unwrap();
        let state = built.scene.effects.iter().find(|entry| entry.effect == Effect::Shadows).unwrap();
        let expected = if shadows { State::On } else { State::Removed };
        assert_eq!((state.state, picture.rays.shadow > 0), (expected, shadows), "{description}: {}", state.reason);
        // A body that hides nothing, far away, brings the shadow rays back.
        let mut with = description.clone();
        with["objects"] = json!([object, { "sphere": { "center": [0, 0, 1e6], "radius": 1 } }]);
        let with = render(&loaded(&with).scene, region, &Control::default()).unwrap();
        assert!(with.rays.shadow > 0);
        assert_eq!(with.film.pixels, picture.film.pixels, "{description}");
    }
}

/// The two cases in which plans and kernels once disagreed.
#[test]
fn black_lights_and_rays_that_weigh_too_little_ask_for_no_samples() {
    let ball = json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } }]);
    let mut description = json!({
        "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "lights": [
            { "point": { "position": [3, 4, 3], "color": 0, "area": { "disc": { "radius": 1 } } } },
            { "point": { "position": [3, 4, 3] } }
        ],
        "materials": { "m": { "reflection": 0.5 } }, "objects": ball
    });
    let state = |description: &Value, effect: Effect| {
        let entry = loaded(description).scene.effects.into_iter().find(|entry| entry.effect == effect).unwrap();
        (entry.state, entry.because)
    };
    assert_eq!(state(&description, Effect::SoftShadows), (State::Removed, vec!["/lights/0".into()]));
    assert_eq!(state(&description, Effect::Antialiasing).0, State::On);
    assert_eq!(loaded(&description).scene.samples, 1);
    description["materials"]["m"]["roughness"] = json!(0.5);
    assert_eq!(loaded(&description).scene.samples, 64);
    description["render"] = json!({ "min_weight": 1 });
    assert_eq!(state(&description, Effect::Gloss), (State::Removed, vec!["/render/min_weight".into()]));
    assert_eq!(loaded(&description).scene.samples, 1);
    // A perfect mirror is heavy enough.
    description["materials"]["m"]["reflection"] = json!(1);
    assert_eq!(state(&description, Effect::Gloss).0, State::On);
}
