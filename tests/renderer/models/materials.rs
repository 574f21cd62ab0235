//! Materials of glTF files: extensions that do nothing, and numbers that scenes do not take.

use super::default_look::{FRONT, imported, matte, overrides, quads};
use serde_json::{Value, json};
use strahl::models::ModelFormat;
use strahl::scene::description::{Channel, Pbr};
use strahl::scene::model::import;
use strahl::scene::problem::Code;
use strahl::scene::{Files, Format, NoFiles, Overrides, load};

/// A square whose material has an extension.
fn square(name: &str, extension: Value) -> Vec<u8> {
    let mut material = matte([0.8, 0.4, 0.2]);
    material["extensions"] = json!({ name: extension });
    quads(&[(FRONT, material)], json!({ "extensionsUsed": [name] }))
}

fn warnings(bytes: &[u8]) -> Vec<String> {
    let description = imported(bytes, ModelFormat::Gltf, &overrides("front")).description;
    description.import_warnings.into_iter().map(|warning| warning.detail).collect()
}

#[test]
fn extensions_that_do_nothing_are_not_warned_of() {
    for (name, idle, active) in [
        ("KHR_materials_sheen", json!({ "sheenRoughnessFactor": 0.5 }), json!({ "sheenColorFactor": [0, 0, 0.1] })),
        ("KHR_materials_iridescence", json!({ "iridescenceIor": 1.8 }), json!({ "iridescenceFactor": 0.1 })),
        ("KHR_materials_anisotropy", json!({ "anisotropyRotation": 1 }), json!({ "anisotropyStrength": 0.1 })),
        (
            "KHR_materials_diffuse_transmission",
            json!({ "diffuseTransmissionColorFactor": [1, 0, 0] }),
            json!({ "diffuseTransmissionFactor": 0.1 }),
        ),
    ] {
        for nothing in [json!({}), idle] {
            assert_eq!(warnings(&square(name, nothing)), [""; 0], "{name}");
        }
        let warned = warnings(&square(name, active));
        assert!(matches!(warned.as_slice(), [only] if only.starts_with("not-simulated: ")), "{name}: {warned:?}");
    }
    for nothing in [json!({}), json!({ "thicknessFactor": 0, "attenuationColor": [1, 0, 0] })] {
        assert_eq!(warnings(&square("KHR_materials_volume", nothing)), [""; 0]);
    }
}

#[test]
fn extensions_that_nobody_knows_are_named() {
    let warned = |names: &[&str]| warnings(&quads(&[(FRONT, matte([0.8; 3]))], json!({ "extensionsUsed": names })));
    assert_eq!(warned(&["KHR_texture_transform", "KHR_materials_sheen"]), [""; 0]);
    assert_eq!(warned(&["MSFT_lod"]), ["skipped: extensions: extensions that are not known: MSFT_lod"]);
    let all = warned(&["A_a", "KHR_lights_punctual", "B_b", "C_c", "D_d", "E_e", "F_f"]);
    assert_eq!(all, ["skipped: extensions: extensions that are not known: A_a, B_b, C_c, D_d and E_e, and more"]);
}

#[test]
fn files_for_readers_of_later_versions_are_refused() {
    let read = |asset: Value| {
        let bytes = quads(&[(FRONT, matte([0.8; 3]))], json!({ "asset": asset }));
        import(ModelFormat::Gltf, &bytes, &overrides("front"), &NoFiles)
            .map_err(|problems| problems.0[0].pointer.clone())
    };
    assert!(read(json!({ "version": "2.1", "minVersion": "2.0" })).is_ok());
    for (asset, pointer) in [
        (json!({ "version": "2.1", "minVersion": "2.1" }), "/asset/minVersion"),
        (json!({ "version": "2.0", "minVersion": "3.0" }), "/asset/minVersion"),
        (json!({ "version": "1.0" }), "/asset/version"),
    ] {
        assert_eq!(read(asset).unwrap_err(), pointer);
    }
}

#[test]
fn metal_lets_no_light_through_that_could_be_rough() {
    let glass = |metallic: f64| {
        let mut material = matte([0.8; 3]);
        material["pbrMetallicRoughness"]["metallicFactor"] = json!(metallic);
        material["pbrMetallicRoughness"]["roughnessFactor"] = json!(0.5);
        material["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
        warnings(&quads(&[(FRONT, material)], json!({ "extensionsUsed": ["KHR_materials_transmission"] })))
    };
    let is_warned = |metallic| glass(metallic).iter().any(|warning| warning.starts_with("approximated: rough-glass"));
    assert!(is_warned(0.0) && !is_warned(1.0));
}

/// Of the file, where they are written: the scene's own pointers lead nowhere in it.
#[test]
fn transforms_beyond_all_numbers_are_refused_where_they_are_written() {
    for (key, far) in [("scale", json!([1e300, 1])), ("offset", json!([0, -1e16]))] {
        let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": { key: far } } });
        let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": info } });
        let more = json!({
            "extensionsUsed": ["KHR_texture_transform"],
            "textures": [{ "source": 0 }],
            "images": [{ "uri": "data:image/png;base64,iVBORw0KGgo=" }]
        });
        let bytes = quads(&[(FRONT, material)], more);
        let problem = &import(ModelFormat::Gltf, &bytes, &Overrides::default(), &NoFiles).unwrap_err().0[0];
        let pointer = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform";
        assert_eq!((problem.pointer.as_str(), problem.code), (pointer, Code::OutOfRange), "{problem}");
        assert!(problem.line.is_some(), "{problem}");
    }
}

/// Programs write the largest number there is for a distance without end, and powers of watts for lamps.
#[test]
fn numbers_that_are_too_large_look_like_the_largest() {
    let pbr = |extensions: Value| -> Pbr {
        let mut material = matte([0.8; 3]);
        material["emissiveFactor"] = json!([1, 0.5, 0]);
        let used: Vec<&String> = extensions.as_object().unwrap().keys().collect();
        let more = json!({ "extensionsUsed": used });
        material["extensions"] = extensions.clone();
        let bytes = quads(&[(FRONT, material)], more);
        let loaded = load(&bytes, Format::Gltf, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
        *loaded.description.materials["material"].pbr.clone().unwrap()
    };
    let glow = pbr(json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 1e300 } }));
    let Channel::Value(color) = glow.emissive else { panic!("{glow:?}") };
    assert_eq!(color.0.to_array(), [1e15, 1e15, 0.0]);
    let clear = |distance: f64| {
        pbr(json!({
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationColor": [0.5, 1, 1], "attenuationDistance": distance }
        }))
    };
    assert!(clear(f64::from(f32::MAX)).attenuation.is_none());
    assert_eq!(clear(1e-30).attenuation.unwrap().distance, 1e-15);
    assert_eq!(clear(3.0).attenuation.unwrap().distance, 3.0);
}

/// A surface that is open has no inside, so its glass bends nothing, and absorbs what the file says of its thickness.
#[test]
fn open_glass_keeps_its_color() {
    let mut material = matte([0.8, 0.6, 0.4]);
    material["extensions"] = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_dispersion": { "dispersion": 1 },
        "KHR_materials_volume": { "thicknessFactor": 2, "attenuationDistance": 1, "attenuationColor": [0.5, 1, 0.25] }
    });
    let names = ["KHR_materials_transmission", "KHR_materials_dispersion", "KHR_materials_volume"];
    let bytes = quads(&[(FRONT, material)], json!({ "extensionsUsed": names }));
    let description = imported(&bytes, ModelFormat::Gltf, &overrides("front")).description;
    let pbr =
        description.materials.iter().find_map(|(_, material)| material.pbr.as_ref().filter(|pbr| pbr.thin)).unwrap();
    let Channel::Value(color) = &pbr.base_color else { panic!("{pbr:?}") };
    let expected = [0.8 * 0.25, 0.6, 0.4 * 0.0625];
    assert!((0..3).all(|c| (color.0[c] - expected[c]).abs() < 1e-6), "{color:?}");
    assert_eq!(pbr.dispersion, 0.0);
}

/// The library of a glass.
struct Glass;

impl Files for Glass {
    fn read(&self, _: &str) -> Result<Vec<u8>, String> {
        Ok(b"newmtl glass\nillum 7\nd 0.1\nNi 1.5\n".to_vec())
    }
}

/// Programs compute both ends of a seam, as sin 0 and sin 2 pi, which is -2.4e-16.
#[test]
fn seams_that_nearly_close_are_closed() {
    let cube = |gap: f64| {
        let mut obj = String::from("mtllib glass.mtl\nusemtl glass\n");
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let mut corner = [side; 3];
                    (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (a * side, b);
                    let [x, y, z] = corner.map(|x| x + if axis == 0 { gap } else { 0.0 });
                    obj.push_str(&format!("v {x:e} {y:e} {z:e}\n"));
                }
                obj.push_str("f -4 -3 -2 -1\n");
            }
        }
        let imported = import(ModelFormat::Obj, obj.as_bytes(), &overrides("front"), &Glass).unwrap();
        imported.description.import_warnings.iter().any(|warning| warning.detail.contains("open-volume"))
    };
    for (gap, is_open) in [(0.0, false), (1e-15, false), (1e-7, false), (1e-3, true)] {
        assert_eq!(cube(gap), is_open, "{gap}");
    }
}
