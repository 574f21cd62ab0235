//! Pictures of models in all their formats.

use crate::common::read as file;
use data_encoding::{BASE64, HEXLOWER};
use image::codecs::webp::WebPEncoder;
use image::{DynamicImage, ImageFormat, RgbaImage};
use sha2::{Digest, Sha256};
use std::io::Cursor;
use strahl::film::Region;
use strahl::models::ModelFormat;
use strahl::models::ktx2::{Ktx2, MAGIC};
use strahl::render::{Control, render};
use strahl::scene::model::import;
use strahl::scene::{Format, NoFiles, Overrides, load};

/// A square without light whose texture is a picture, from the front.
fn square(extension: &str, media_type: &str, picture: &[u8]) -> String {
    let points: Vec<u8> = [[-1.0_f32, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]
        .into_iter()
        .flatten()
        .chain([0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        .flat_map(f32::to_le_bytes)
        .chain([0, 1, 2, 0, 2, 3])
        .collect();
    let texture = match extension {
        "" => r#"{"source": 0}"#.to_owned(),
        name => format!(r#"{{"extensions": {{"{name}": {{"source": 0}}}}}}"#),
    };
    let required =
        if extension.is_empty() { String::new() } else { format!(r#""extensionsRequired": ["{extension}"],"#) };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, {required}
        "buffers": [{{"byteLength": 86, "uri": "data:application/octet-stream;base64,{}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 32}},
            {{"buffer": 0, "byteOffset": 80, "byteLength": 6}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}},
            {{"bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR"}}],
        "images": [{{"uri": "data:{media_type};base64,{}"}}], "textures": [{texture}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}},
            "extensions": {{"KHR_materials_unlit": {{}}}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
        "nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}]}}"#,
        BASE64.encode(&points),
        BASE64.encode(picture)
    )
}

fn shown(model: &str) -> Vec<[f32; 3]> {
    shown_as(model.as_bytes(), Format::Gltf)
}

fn shown_as(model: &[u8], format: Format) -> Vec<[f32; 3]> {
    let mut overrides = Overrides { width: Some(32), height: Some(32), antialias: Some(false), ..Overrides::default() };
    overrides.model.view = Some("front".parse().unwrap());
    let loaded = load(model, format, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let picture = render(&loaded.scene, Region::whole(32, 32), &Control::default()).unwrap();
    picture.film.pixels
}

/// Three blocks across and two down, all of one color, and their picture.
fn blocks() -> (Vec<u8>, RgbaImage) {
    let colors = [[255, 0, 0, 255], [0, 200, 0, 255], [0, 0, 120, 255], [9, 99, 199, 255], [250; 4], [17, 3, 88, 255]];
    let mut level = Vec::new();
    for color in colors {
        // Five bits of the mode, then four bytes.
        let bits = u128::from(u32::from_le_bytes(color)) << 5 | 0b1_0111;
        level.extend(bits.to_le_bytes());
    }
    let picture = RgbaImage::from_fn(10, 8, |x, y| image::Rgba(colors[(x / 4 + 3 * (y / 4)) as usize]));
    (level, picture)
}

/// KTX 2.0 with one level of UASTC.
fn ktx2(width: u32, height: u32, level: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let descriptor = 104_u32;
    for word in [0, 1, width, height, 0, 0, 1, 1, 0, descriptor, 44, 0, 0, 0, 0, 0, 0] {
        bytes.extend(u32::to_le_bytes(word));
    }
    for word in [148, level.len() as u64, level.len() as u64] {
        bytes.extend(u64::to_le_bytes(word));
    }
    for word in [44, 0, 40 << 16 | 2, 166, 0x0303, 16, 0, 127 << 16, 0, 0, u32::MAX] {
        bytes.extend(u32::to_le_bytes(word));
    }
    bytes.extend(level);
    bytes
}

#[test]
fn a_picture_is_the_same_in_all_formats() {
    let (level, picture) = blocks();
    let mut png = Vec::new();
    picture.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
    let mut webp = Vec::new();
    DynamicImage::from(picture.clone()).write_with_encoder(WebPEncoder::new_lossless(&mut webp)).unwrap();
    let ktx2 = ktx2(10, 8, &level);
    assert_eq!(Ktx2::read(&ktx2).unwrap().decode().unwrap().into_flattened(), picture.into_raw());
    let expected = shown(&square("", "image/png", &png));
    assert!(expected.iter().any(|pixel| *pixel != expected[0]));
    assert_eq!(shown(&square("EXT_texture_webp", "image/webp", &webp)), expected);
    assert_eq!(shown(&square("KHR_texture_basisu", "image/ktx2", &ktx2)), expected);
}

fn png(picture: &RgbaImage) -> Vec<u8> {
    let mut png = Vec::new();
    picture.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
    png
}

#[test]
fn enlarged_pixels_are_squares_where_the_sampler_says_nearest() {
    let picture = RgbaImage::from_fn(2, 1, |x, _| image::Rgba([[255, 0, 0, 255], [0, 255, 0, 255]][x as usize]));
    let smooth = square("", "image/png", &png(&picture));
    let textures = r#""textures": [{"source": 0}]"#;
    assert!(smooth.contains(textures));
    let sampler = r#""samplers": [{"magFilter": 9728}], "textures": [{"source": 0, "sampler": 0}]"#;
    let mixed = |model: &str| shown(model).into_iter().filter(|[r, g, _]| r.min(*g) > 0.05).count();
    assert!(mixed(&smooth) > 100);
    assert_eq!(mixed(&smooth.replace(textures, sampler)), 0);
}

/// Options of a picture do to texture coordinates, whose v is 0 at the bottom, what the numbers in the file would.
#[test]
fn options_of_mtl_move_and_repeat_a_picture() {
    let picture = png(&blocks().1);
    let shown = |options: &str, uv: [[f64; 2]; 4]| {
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {options} data:image/png;base64,{}\n", BASE64.encode(&picture));
        let lines: String = uv.iter().map(|[u, v]| format!("vt {u} {v}\n")).collect();
        let obj = format!(
            "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n{lines}usemtl a\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
        );
        let part = |name: &str, text: &str| {
            format!("--cut\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n{text}\r\n")
        };
        let body = part("a.obj", &obj) + &part("a.mtl", &mtl) + "--cut--\r\n";
        shown_as(body.as_bytes(), Format::Parts)
    };
    let plain = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let moved = plain.map(|[u, v]| [2.0 * u + 0.25, 0.5 * v + 0.125]);
    let expected = shown("", moved);
    assert!(expected != shown("", plain));
    let differ = |pixels: Vec<[f32; 3]>| {
        let pairs = pixels.as_flattened().iter().zip(expected.as_flattened());
        pairs.filter(|(a, b)| (*a - *b).abs() > 1e-3).count()
    };
    assert_eq!(differ(shown("-s 2 0.5 1 -o 0.25 0.125 0", plain)), 0);
    assert!(differ(shown("-s 2 0.5 1", plain)) > 100);
}

/// Without a warning, with its strength, and told apart from the normals of the surface.
#[test]
fn clearcoat_has_the_normals_of_its_own_picture() {
    let model = square("", "image/png", &png(&RgbaImage::from_pixel(2, 2, image::Rgba([190, 100, 220, 255]))));
    let coated = |normals: &str| {
        let coat = format!(r#""KHR_materials_clearcoat": {{"clearcoatFactor": 1{normals}}}"#);
        let model = model.replace(r#""KHR_materials_unlit": {}"#, &coat);
        assert!(model.contains("KHR_materials_clearcoat"));
        model
    };
    let leans = coated(r#", "clearcoatNormalTexture": {"index": 0, "scale": 0.5}"#);
    let imported = import(ModelFormat::Gltf, leans.as_bytes(), &Overrides::default(), &NoFiles).unwrap();
    let warnings = &imported.description.import_warnings;
    assert!(warnings.iter().all(|warning| !warning.detail.starts_with("approx")), "{warnings:?}");
    let pbr = imported.description.materials.iter().find_map(|(_, material)| material.pbr.as_deref()).unwrap();
    assert_eq!(pbr.clearcoat_normal.as_ref().map(|normals| normals.factor), Some(0.5));
    assert_eq!(pbr.normal, None);
    assert_ne!(shown(&leans), shown(&coated("")));
}

/// A lit square with a normal map that is the same everywhere.
fn bumpy(normal: [u8; 3], tangent: Option<[f32; 4]>, has_normals: bool) -> Vec<[f32; 3]> {
    let [x, y, z] = normal;
    let model = square("", "image/png", &png(&RgbaImage::from_pixel(2, 2, image::Rgba([x, y, z, 255]))));
    let model = model.replace(
        r#""pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},"#,
        r#""pbrMetallicRoughness": {"metallicFactor": 0}, "normalTexture": {"index": 0},"#,
    );
    let model = model.replace(r#""KHR_materials_unlit": {}"#, "");
    let Some(tangent) = tangent else { return shown(&model) };
    let numbers = [[tangent; 4].as_flattened(), [[0.0, 0.0, 1.0]; 4].as_flattened()].concat();
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let buffer = format!(r#""buffers": [{{"byteLength": 112, "uri": "data:;base64,{}"}}, "#, BASE64.encode(&bytes));
    let attributes =
        if has_normals { r#""TEXCOORD_0": 1, "TANGENT": 3, "NORMAL": 4"# } else { r#""TEXCOORD_0": 1, "TANGENT": 3"# };
    let model = model
        .replace(r#""buffers": ["#, &buffer)
        .replace(r#""buffer": 0"#, r#""buffer": 1"#)
        .replace(
            r#""byteLength": 6}]"#,
            r#""byteLength": 6}, {"buffer": 0, "byteLength": 64}, {"buffer": 0, "byteOffset": 64, "byteLength": 48}]"#,
        )
        .replace(
            r#""type": "SCALAR"}]"#,
            r#""type": "SCALAR"}, {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"},
                {"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC3"}]"#,
        )
        .replace(r#""TEXCOORD_0": 1"#, attributes);
    shown(&model)
}

#[test]
fn tangents_of_a_model_turn_its_normal_map() {
    let differ = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let normal = [200, 160, 230];
    let by_texture = bumpy(normal, None, true);
    assert!(differ(&by_texture, &bumpy(normal, Some([1.0, 0.0, 0.0, 1.0]), true)) < 1e-5);
    // Turned half around, and with the other hand.
    for (tangent, same) in [([-1.0, 0.0, 0.0, 1.0], [56, 96, 230]), ([1.0, 0.0, 0.0, -1.0], [200, 96, 230])] {
        let turned = bumpy(normal, Some(tangent), true);
        assert!(differ(&turned, &bumpy(same, None, true)) < 1e-5, "{tangent:?}");
        assert!(differ(&turned, &by_texture) > 0.01, "{tangent:?}");
        // Without normals they are to be ignored (glTF 2.0, section 3.7.2.1).
        assert!(differ(&bumpy(normal, Some(tangent), false), &by_texture) < 1e-5, "{tangent:?}");
    }
}

/// The KTX 2.0 file in a model of `tests/inputs`.
fn inside(name: &str) -> Vec<u8> {
    let model = file(&format!("tests/inputs/models/{name}"));
    let at = model.windows(MAGIC.len()).position(|bytes| bytes == MAGIC).unwrap();
    model[at..].to_vec()
}

/// The bytes that the transcoder of Basis Universal (three.js 0.183) gives, by their SHA-256. Blocks of all nineteen modes of UASTC,
/// filled with random bits, are in one of the files.
#[test]
fn pixels_are_those_of_the_transcoder_of_basis_universal() {
    let folder = |name: &str| file(&format!("tests/inputs/models/ktx2/{name}"));
    for (picture, size, sum) in [
        (folder("alpha_etc1s.ktx2"), [150, 93], "e29ed6f0fd9b4d7e3b10875b02a7c29f0311d1bad1772d3e25541b30e23b383e"),
        (folder("grey_etc1s.ktx2"), [150, 93], "839fc5f5d2c4ce18de6a24ac904ccb6932c1ffc5d665d21864c34ddafae31cd1"),
        (folder("alpha_uastc.ktx2"), [150, 93], "76b955023db62c108e8b5adfc70bae6de42a7a6a22c1c3064ec718cfeec3b56b"),
        (folder("modes_uastc.ktx2"), [76, 48], "7bd5c3f746200fa3b44b09f4ab1e8989b757f6e3a1d4ad74348d2d77665fe87b"),
        (
            inside("own_quad_ktx2_etc1s.glb"),
            [512, 512],
            "eba13c23427c99bded40c3c8e66110a0fb53ec77c832ae2064863c7fdc493965",
        ),
        (
            inside("own_quad_ktx2_uastc.glb"),
            [2048, 2048],
            "32e85ca15777213531771884546736dba1ceb363e584333d54cbf1acd659b834",
        ),
    ] {
        let picture = Ktx2::read(&picture).unwrap();
        assert_eq!([picture.width, picture.height], size);
        let pixels = picture.decode().unwrap().into_flattened();
        assert_eq!(HEXLOWER.encode(&Sha256::digest(&pixels)), sum, "{size:?}");
    }
}

/// Whatever is written in a file, it is read or refused.
#[test]
fn cut_and_changed_ktx2_files_break_nothing() {
    for name in ["alpha_etc1s.ktx2", "grey_etc1s.ktx2", "alpha_uastc.ktx2", "modes_uastc.ktx2"] {
        let whole = file(&format!("tests/inputs/models/ktx2/{name}"));
        let decode = |bytes: &[u8]| {
            let picture = Ktx2::read(bytes)?;
            if u64::from(picture.width) * u64::from(picture.height) > 1 << 20 {
                Err("is large".into())
            } else {
                picture.decode()
            }
        };
        assert!(decode(&whole).is_ok());
        for end in (0..whole.len()).step_by(61) {
            let _ = decode(&whole[..end]);
        }
        for at in (0..whole.len()).step_by(37) {
            for flip in [0x01, 0x80, 0xff] {
                let mut changed = whole.clone();
                changed[at] ^= flip;
                let _ = decode(&changed);
            }
        }
    }
    for (at, byte, why) in [
        (12, 37, "format"),
        (36, 6, "two dimensions"),
        (24, 0, "two dimensions"),
        (0, 0, "no KTX"),
        (44, 3, "Universal"),
    ] {
        let mut changed = inside("own_quad_ktx2_uastc.glb");
        changed[at] = byte;
        if at == 24 {
            changed[24..28].fill(0);
        }
        let refusal = Ktx2::read(&changed).unwrap_err();
        assert!(refusal.contains(why), "{refusal}");
    }
}
