//! Assets: sent once, named by their hash, and only for who has sent them. Models and pictures in scenes.

use super::access::KeyFile;
use crate::common::service::{Answer, Service};
use data_encoding::{BASE64, HEXLOWER};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::Path;

fn file(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/models").join(name)).unwrap()
}

fn hash(bytes: &[u8]) -> String {
    HEXLOWER.encode(&Sha256::digest(bytes))
}

fn put(service: &Service, bytes: &[u8]) -> Answer {
    service.send("PUT", &format!("/v1/assets/{}", hash(bytes)), &[], bytes)
}

/// A scene around objects.
fn scene(objects: &Value) -> String {
    json!({
        "version": 1,
        "image": { "width": 48, "height": 32 },
        "camera": { "pinhole": { "eye": [2, 2, 4], "look_at": [0, 0, 0] } },
        "objects": objects,
    })
    .to_string()
}

fn model(bytes: &[u8]) -> Value {
    json!({ "model": { "asset": format!("sha256:{}", hash(bytes)), "transform": { "rotate_deg": { "axis": [0, 1, 0], "angle": 20 } } } })
}

fn render(service: &Service, text: &str) -> Answer {
    service.post_json("/v1/render?format=png", text)
}

#[test]
fn assets_are_sent_found_and_deleted() {
    let service = Service::start(&[]);
    let cube = file("Box.glb");
    let (own, path) = (hash(&cube), format!("/v1/assets/{}", hash(&cube)));
    let missing = |hashes: &[&str]| {
        service.post_json("/v1/assets/missing", &json!({ "sha256": hashes }).to_string()).json()["missing"].clone()
    };
    let other = "0".repeat(64);
    assert_eq!(missing(&[&format!("sha256:{own}"), &other, &own, &other]), json!([own, other]), "each once");
    service.get(&path).problem(404, "not-found");
    service.send("PUT", &format!("/v1/assets/{other}"), &[], &cube).problem(422, "asset-mismatch");
    service.send("PUT", "/v1/assets/abc", &[], &cube).problem(404, "not-found");

    let sent = put(&service, &cube);
    assert_eq!((sent.status, sent.header("location")), (201, path.as_str()));
    assert_eq!(sent.json(), json!({ "sha256": own, "asset": format!("sha256:{own}"), "bytes": cube.len() }));
    assert_eq!([put(&service, &cube).status, service.send("POST", "/v1/assets", &[], &cube).status], [200, 200]);
    assert_eq!(missing(&[&own, &other]), json!([other]));
    let found = service.get(&path);
    assert!(found.body == cube);
    let etag = format!("\"{own}\"");
    assert_eq!(found.header("etag"), etag);
    let again = service.send("GET", &path, &[("If-None-Match", &etag)], b"");
    assert_eq!((again.status, again.body.len(), again.header("etag")), (304, 0, etag.as_str()));
    assert_eq!(service.send("GET", &path, &[("If-None-Match", "\"other\"")], b"").status, 200);
    service.send("GET", &path, &[("If-Match", "\"other\"")], b"").problem(412, "precondition-failed");
    let unknown = format!("/v1/assets/{other}");
    service.send("GET", &unknown, &[("If-None-Match", "*")], b"").problem(404, "not-found");
    assert_eq!(found.header("x-content-type-options"), "nosniff");
    let head = service.send("HEAD", &path, &[], b"");
    assert_eq!((head.status, head.header("content-length")), (200, cube.len().to_string().as_str()));
    let known = service.send("HEAD", &path, &[("If-None-Match", &etag)], b"");
    assert_eq!((known.status, known.header("content-length")), (304, ""), "it would be that of the asset");
    assert_eq!(service.send("HEAD", &path, &[("If-Match", "\"other\"")], b"").status, 412);
    assert_eq!(service.get("/v1/me").json()["asset_bytes"], cube.len());
    let named = format!("/v1/assets/sha256:{own}");
    assert!(service.get(&named).body == cube, "by the name that scenes have for it");
    assert_eq!(service.send("PUT", &named, &[], &cube).header("location"), path);

    let range = format!("bytes 0-{}/{}", cube.len() - 1, cube.len());
    service.send("PUT", &path, &[("Content-Range", &range)], &cube).problem(400, "malformed-request");
    // Who acts on a condition acts on nothing else.
    let with = |method: &str, name: &str, value: &str| {
        let body = if method == "PUT" { &cube[..] } else { b"" };
        service.send(method, &path, &[(name, value)], body)
    };
    for (method, name, value) in [
        ("PUT", "If-None-Match", "*"),
        ("PUT", "If-Match", "\"other\""),
        ("DELETE", "If-None-Match", etag.as_str()),
        ("DELETE", "If-Match", "\"other\""),
    ] {
        with(method, name, value).problem(412, "precondition-failed");
    }
    assert_eq!(with("PUT", "If-Match", "*").status, 200);
    service.send("DELETE", &unknown, &[("If-Match", "\"other\"")], b"").problem(404, "not-found");
    assert_eq!(with("DELETE", "If-Match", &etag).status, 204);
    service.send("DELETE", &path, &[], b"").problem(404, "not-found");
    service.get(&path).problem(404, "not-found");
    with("PUT", "If-Match", "*").problem(412, "precondition-failed");
    service.get(&path).problem(404, "not-found");
    assert_eq!(with("PUT", "If-None-Match", "*").status, 201);
    service.post_json("/v1/assets/missing", r#"{"sha256": ["abc"]}"#).problem(422, "invalid-request");
}

/// A scene and a query have the same times.
#[test]
fn a_time_before_the_animation_is_refused_everywhere() {
    let service = Service::start(&[]);
    let cube = file("AnimatedMorphCube_quantized.glb");
    put(&service, &cube);
    let at = |t: f64| {
        let mut placed = model(&cube);
        placed["model"]["t"] = json!(t);
        render(&service, &scene(&json!([placed])))
    };
    assert_eq!(at(0.0).status, 200);
    let problem = at(-0.5).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/objects/0/model/t", "{problem}");
    let glb = [("Content-Type", "model/gltf-binary")];
    service.send("POST", "/v1/render?t=-0.5", &glb, &cube).problem(400, "invalid-parameter");
}

#[test]
fn scenes_with_models_are_scenes_like_all_others() {
    let service = Service::start(&[]);
    let cube = file("Box.glb");
    let text = scene(&json!([model(&cube), { "sphere": { "center": [1.2, 0, 0], "radius": 0.3 } }]));
    let lacking = render(&service, &text).problem(422, "assets-missing");
    assert_eq!(lacking["missing"], json!([hash(&cube)]));
    assert_eq!(lacking["errors"][0]["pointer"], "#/objects/0/model/asset");
    assert_eq!(lacking["errors"][0]["line"], 1);

    put(&service, &cube);
    let picture = render(&service, &text);
    assert_eq!(picture.status, 200, "{}", picture.text());
    let etag = picture.header("etag").to_owned();
    let again = service.send(
        "QUERY",
        "/v1/render?format=png",
        &[("Content-Type", "application/json"), ("If-None-Match", &etag)],
        text.as_bytes(),
    );
    assert_eq!(again.status, 304);

    let known = service.post_json("/v1/scenes", &text).json();
    let image = known["links"]["image"].as_str().expect("its picture has an id");
    assert!(service.get(image).body == picture.body);
    let kept = service.get(known["links"]["self"].as_str().unwrap()).text();
    assert!(kept.contains(&hash(&cube)) && !kept.contains("faces"), "it says the hash and no mesh: {kept}");
    let tile = format!("/iiif/3/{}/0,0,16,16/max/0/default.png", known["image_id"].as_str().unwrap());
    assert_eq!(service.get(&tile).status, 200);
    // From elsewhere, and the model as another color.
    let patch = json!({ "base": known["scene_id"], "patch": { "camera": { "pinhole": { "eye": [-2, 1, 4] } } } });
    let moved = render(&service, &patch.to_string());
    let whole = render(&service, &text.replace("[2,2,4]", "[-2,1,4]"));
    assert!(moved.status == 200 && moved.body == whole.body && moved.body != picture.body);

    // What a ray hits has a pointer into the text.
    let rays = json!({ "scene": serde_json::from_str::<Value>(&text).unwrap(),
        "rays": [{ "origin": [0, 0, 5], "direction": [0, 0, -1] }] });
    let hit = service.post_json("/v1/rays", &rays.to_string()).text();
    assert!(hit.contains(r#""/objects/0/model""#), "{hit}");
}

#[test]
fn a_model_in_a_scene_looks_as_its_own_meshes_do() {
    let service = Service::start(&[]);
    let cube = file("Box.glb");
    put(&service, &cube);
    let placed = service.post_json(
        "/v1/render?format=pfm",
        &scene(&json!([{ "model": { "asset": format!("sha256:{}", hash(&cube)) } }])),
    );
    let quad = |vertices: Value| json!({ "quad": { "vertices": vertices, "material": "m" } });
    let (l, h) = (-0.5, 0.5);
    let mut same: Value = serde_json::from_str(&scene(&json!([
        quad(json!([[l, l, h], [h, l, h], [h, h, h], [l, h, h]])),
        quad(json!([[h, l, h], [h, l, l], [h, h, l], [h, h, h]])),
        quad(json!([[l, h, h], [h, h, h], [h, h, l], [l, h, l]])),
        quad(json!([[l, l, l], [l, l, h], [l, h, h], [l, h, l]])),
        quad(json!([[l, l, l], [h, l, l], [h, l, h], [l, l, h]])),
        quad(json!([[h, l, l], [l, l, l], [l, h, l], [h, h, l]])),
    ])))
    .unwrap();
    same["materials"] = json!({ "m": { "pbr": { "base_color": [0.8, 0, 0], "metallic": 0, "roughness": 1 } } });
    let same = service.post_json("/v1/render?format=pfm", &same.to_string());
    assert_eq!([placed.status, same.status], [200, 200], "{} {}", placed.text(), same.text());
    let values = |answer: &Answer| -> Vec<f32> {
        let start = answer.body.len() - 48 * 32 * 12;
        answer.body[start..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    let (placed, same) = (values(&placed), values(&same));
    let off = placed.iter().zip(&same).filter(|(a, b)| (*a - *b).abs() > 0.01).count();
    assert!(off < placed.len() / 100, "{off} of {} values differ", placed.len());
    assert!(placed.iter().any(|value| *value > 0.1));
}

#[test]
fn what_is_wrong_with_a_model_in_a_scene_is_said_with_its_place() {
    let service = Service::start(&[]);
    let (broken, cube) = (file("assimp_IndexOutOfRange.glb"), file("Box.glb"));
    put(&service, &broken);
    put(&service, &cube);
    let of =
        |object: Value| render(&service, &scene(&json!([object]))).problem(422, "invalid-scene")["errors"][0].clone();
    let inside = of(model(&broken));
    assert_eq!(inside["pointer"], "#/objects/0/model/asset");
    assert!(inside["detail"].as_str().unwrap().contains("/meshes/0/primitives/0/indices: element 0"), "{inside}");
    let with = |key: &str, value: Value| {
        let mut object = model(&cube);
        object["model"][key] = value;
        of(object)
    };
    assert_eq!(with("materials", json!({ "Blue": { "diffuse": 1 } }))["pointer"], "#/objects/0/model/materials/Blue");
    let wrong = with("materials", json!({ "Red": { "phong": 2 , "diffuse": [2, 0, 0]} }));
    assert_eq!(wrong["pointer"], "#/objects/0/model/materials/Red/phong");
    let wrong = with("materials", json!({ "Red": { "diffuse": [1e40, 0, 0] } }));
    assert_eq!(wrong["pointer"], "#/objects/0/model/materials/Red/diffuse");
    assert!(with("animation", json!("Run"))["detail"].as_str().unwrap().contains("no animation Run"));
    assert_eq!(with("scene", json!(7))["pointer"], "#/objects/0/model/asset");
    let named = of(json!({ "model": { "asset": "duck.glb" } }));
    assert!(named["detail"].as_str().unwrap().contains("cannot be read"), "{named}");
    assert!(of(json!({ "model": { "asset": "sha256:abc" } }))["detail"].as_str().unwrap().contains("64 hexadecimal"));
}

#[test]
fn pictures_are_named_by_their_hash() {
    let service = Service::start(&[]);
    // A PNG of one red pixel.
    let red = BASE64
        .decode(b"iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==")
        .unwrap();
    let with = |source: &str| {
        json!({
            "version": 1,
            "image": { "width": 24, "height": 16 },
            "camera": { "pinhole": { "eye": [0, 0, 4], "look_at": [0, 0, 0] } },
            "materials": { "m": { "diffuse": { "image": { "source": source, "mapping": { "spherical": {} } } } } },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } }],
        })
        .to_string()
    };
    let by_hash = with(&format!("sha256:{}", hash(&red)));
    let lacking = render(&service, &by_hash).problem(422, "assets-missing");
    assert_eq!(lacking["errors"][0]["pointer"], "#/materials/m/diffuse/image/source");
    put(&service, &red);
    let inside = with(&format!("data:image/png;base64,{}", BASE64.encode(&red)));
    let (by_hash, inside) = (render(&service, &by_hash), render(&service, &inside));
    assert_eq!([by_hash.status, inside.status], [200, 200], "{} {}", by_hash.text(), inside.text());
    assert!(by_hash.body == inside.body && by_hash.header("etag") != inside.header("etag"));
}

#[test]
fn a_hash_is_no_permission() {
    let keys = KeyFile::new("assets", "");
    let [acme, bolt] = ["acme", "bolt"].map(|tenant| keys.key(tenant, "render,read,jobs"));
    let service = keys.serve(&["--asset-bytes", "3000"]);
    let cube = file("Box.glb");
    let path = format!("/v1/assets/{}", hash(&cube));
    let send = |key: &str, method: &str, path: &str, body: &[u8]| {
        service.send(method, path, &[("Authorization", key), ("Content-Type", "application/json")], body)
    };
    assert_eq!(send(&acme, "PUT", &path, &cube).status, 201);
    let text = scene(&json!([model(&cube)]));
    assert_eq!(send(&acme, "POST", "/v1/render", text.as_bytes()).status, 200);
    // Its scene and its picture are in the caches by now.
    for method in ["GET", "DELETE"] {
        send(&bolt, method, &path, b"").problem(404, "not-found");
    }
    for path in ["/v1/render", "/v1/scenes", "/v1/explain", "/v1/render/tile?x=0&y=0&w=8&h=8"] {
        send(&bolt, "POST", path, text.as_bytes()).problem(422, "assets-missing");
    }
    assert_eq!(send(&bolt, "PUT", &path, &cube).status, 201, "it has to send the bytes itself");
    assert_eq!(send(&bolt, "POST", "/v1/render", text.as_bytes()).status, 200);
    assert_eq!(send(&acme, "DELETE", &path, b"").status, 204);
    send(&acme, "POST", "/v1/render", text.as_bytes()).problem(422, "assets-missing");
    assert_eq!(send(&bolt, "GET", &path, b"").status, 200);
    // What a kept scene names stays, whatever comes after it.
    assert_eq!(send(&bolt, "POST", "/v1/scenes", text.as_bytes()).status, 201);
    let [first, second] = [[1_u8; 900], [2_u8; 900]];
    assert_eq!(send(&bolt, "POST", "/v1/assets", &first).status, 201);
    assert_eq!(send(&bolt, "POST", "/v1/assets", &second).status, 201);
    assert_eq!(send(&bolt, "GET", &path, b"").status, 200);
    send(&bolt, "GET", &format!("/v1/assets/{}", hash(&first)), b"").problem(404, "not-found");
    send(&bolt, "POST", "/v1/assets", &[3; 3001]).problem(413, "too-large");
}

/// A picture in a material that a scene puts on a model is an asset of the scene.
#[test]
fn pictures_on_models_are_no_permission_either() {
    let keys = KeyFile::new("pictures-on-models", "");
    let [acme, bolt] = ["acme", "bolt"].map(|tenant| keys.key(tenant, "render,read,jobs"));
    let service = keys.serve(&[]);
    let send = |key: &str, method: &str, path: &str, body: &[u8]| {
        service.send(method, path, &[("Authorization", key), ("Content-Type", "application/json")], body)
    };
    let red = BASE64
        .decode(b"iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==")
        .unwrap();
    let cube = file("Box.glb");
    let mut placed = model(&cube);
    let image = json!({ "source": format!("sha256:{}", hash(&red)), "mapping": { "spherical": {} } });
    placed["model"]["materials"] = json!({ "Red": { "diffuse": { "image": image } } });
    let text = scene(&json!([{ "group": { "objects": [placed] } }]));
    let lacking = send(&acme, "POST", "/v1/render", text.as_bytes()).problem(422, "assets-missing");
    assert_eq!(lacking["errors"].as_array().unwrap().len(), 2, "both at once: {lacking}");
    for (key, bytes) in [(&acme, &cube), (&acme, &red), (&bolt, &cube)] {
        assert_eq!(send(key, "PUT", &format!("/v1/assets/{}", hash(bytes)), bytes).status, 201);
    }
    assert_eq!(send(&acme, "POST", "/v1/render", text.as_bytes()).status, 200);
    let lacking = send(&bolt, "POST", "/v1/render", text.as_bytes()).problem(422, "assets-missing");
    let pointer = "#/objects/0/group/objects/0/model/materials/Red/diffuse/image/source";
    assert_eq!(lacking["errors"][0]["pointer"], pointer);
    assert_eq!(send(&acme, "DELETE", &format!("/v1/assets/{}", hash(&red)), b"").status, 204);
    send(&acme, "POST", "/v1/render", text.as_bytes()).problem(422, "assets-missing");
}

#[test]
fn assets_and_jobs_that_name_them_outlive_the_service() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--data", folder.path().to_str().unwrap()];
    let service = Service::start(&flags);
    let cube = file("Box.glb");
    put(&service, &cube);
    let job = json!({ "scene": serde_json::from_str::<Value>(&scene(&json!([model(&cube)]))).unwrap(), "output": { "format": "png" } });
    let headers = [("Content-Type", "application/json"), ("Prefer", "wait=20")];
    let done = service.send("POST", "/v1/jobs", &headers, job.to_string().as_bytes()).json();
    assert_eq!(done["state"], "succeeded", "{done}");
    let image = format!("/v1/jobs/{}/image", done["id"].as_str().unwrap());
    let picture = service.get(&image).body;
    drop(service);
    let service = Service::start(&flags);
    assert!(service.get(&image).body == picture);
    assert!(service.get(&format!("/v1/assets/{}", hash(&cube))).body == cube);
}

#[test]
fn another_view_of_a_model_is_the_same_bytes_as_a_first_one() {
    let [one, other] = [Service::start(&[]), Service::start(&[])];
    for name in ["Box.glb", "RiggedFigure.glb", "LightsPoint.glb", "own_instances_1000.glb"] {
        let bytes = file(name);
        let view = |service: &Service, query: &str| {
            let path = format!("/v1/render?width=64&height=48&format=png&{query}");
            let answer = service.send("POST", &path, &[("Content-Type", "model/gltf-binary")], &bytes);
            assert_eq!(answer.status, 200, "{name} {query}: {}", answer.text());
            let said =
                ["etag", "render-warnings", "render-plan", "render-error"].map(|name| answer.header(name).to_owned());
            (answer.body, said)
        };
        view(&one, "view=front");
        for query in
            ["view=back", "view=top&samples=2", "view=30,120", "light=studio&view=iso", "precision=double&view=left"]
        {
            assert!(view(&one, query) == view(&other, query), "{name} {query}");
        }
    }
}

/// A triangle that glows, as a glTF in one file.
fn lamp() -> Vec<u8> {
    let places: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&places)) }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "materials": [{
            "emissiveFactor": [1, 1, 1],
            "doubleSided": true,
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 5 } },
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    })
    .to_string()
    .into_bytes()
}

/// A model is kept for all, whoever asks first; what is left out of it depends on the fidelity.
#[test]
fn warnings_of_a_model_are_those_of_the_fidelity_that_is_asked_for() {
    let bytes = lamp();
    for order in [["fast", "faithful", "fast"], ["faithful", "fast", "faithful"]] {
        let service = Service::start(&[]);
        assert_eq!(put(&service, &bytes).status, 201);
        for fidelity in order {
            let path = format!("/v1/render?format=png&samples=1&fidelity={fidelity}");
            let answer = service.post_json(&path, &scene(&json!([model(&bytes)])));
            assert_eq!(answer.status, 200, "{}", answer.text());
            let warnings = answer.header("render-warnings");
            assert_eq!(warnings.contains("emissive-light"), fidelity == "fast", "{order:?} {fidelity}: {warnings}");
        }
    }
}
