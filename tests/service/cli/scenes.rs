//! What commands say of a scene: warnings, problems, other formats, and the contract.

use super::{BALL, done, fails, folder, strahl};
use serde_json::Value;
use std::path::Path;

/// Whatever a command does with a scene, it says what is odd about it.
#[test]
fn commands_warn_of_what_is_odd_about_a_scene() {
    let folder = folder("odd");
    std::fs::write(
        folder.join("dark.json"),
        BALL.replace(r#""version": 1,"#, r#""version": 1, "lights": [], "ambient": 0,"#),
    )
    .unwrap();
    let ray = r#"{"origin":[0,0,5],"direction":[0,0,-1]}"#;
    for args in [
        &["render", "dark.json", "-o", "a.png"][..],
        &["frame", "dark.json", "--frame", "0", "-o", "f.png"],
        &["tile", "dark.json", "--of", "2", "--index", "0", "-o", "0.tile"],
        &["map", "dark.json", "--of", "rays", "-o", "m.png"],
        &["tree", "dark.json", "--pixel", "9,9"],
        &["rays", "dark.json"],
        &["gallery", "dark.json", "-o", "g.html"],
        &["tradeoff", "dark.json", "--seconds", "1", "-o", "t.html"],
    ] {
        let output = strahl(&folder, args, ray);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && text.contains("warning: dark.json: "), "{args:?}: {text}");
        assert!(text.contains("there is no light"), "{args:?}: {text}");
    }
}

#[test]
fn nff_is_imported_and_the_import_is_a_scene() {
    let folder = folder("import");
    done(&folder, &["import", "ball.nff", "-o", "imported.json"], "");
    let text = done(&folder, &["validate", "imported.json"], "");
    assert!(String::from_utf8_lossy(&text).contains("is valid"));
    let same = |args: &[&str]| done(&folder, &[&["render", "-o", "-", "--format", "png"], args].concat(), "");
    assert_eq!(same(&["ball.nff"]), same(&["imported.json"]));
    fails(&folder, &["import", "imported.json"], "", 1, "scene JSON already");
    std::fs::write(folder.join("a.png"), b"\x89PNG\r\n\x1a\n\0\0").unwrap();
    for command in ["render", "validate", "import"] {
        fails(&folder, &[command, "a.png"], "", 1, "a PNG picture");
    }
}

/// With the settings that decide what is written, too.
#[test]
fn an_imported_model_is_the_picture_of_the_model() {
    let folder = folder("import-model");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/models/Box.glb");
    std::fs::copy(from, folder.join("box.glb")).unwrap();
    for fidelity in ["fast", "faithful"] {
        let size = ["--width", "40", "--height", "40"];
        done(&folder, &[&["import", "box.glb", "--fidelity", fidelity, "-o", "box.json"][..], &size].concat(), "");
        let picture = |file: &str, flags: &[&str]| {
            let args =
                ["render", file, "-o", "-", "--format", "png", "--width", "40", "--height", "40", "--samples", "4"];
            done(&folder, &[&args, flags].concat(), "")
        };
        assert!(picture("box.json", &[]) == picture("box.glb", &["--fidelity", fidelity]), "{fidelity}");
    }
    // The size of the picture decides where the camera stands.
    let settings = ["--width", "30", "--height", "16", "--dpr", "2", "--view", "front", "--background", "#336699"];
    done(&folder, &[&["import", "box.glb", "-o", "wide.json"][..], &settings].concat(), "");
    let picture = |args: &[&str]| done(&folder, &[&["render", "-o", "-", "--format", "png"], args].concat(), "");
    assert!(picture(&["wide.json"]) == picture(&[&["box.glb"][..], &settings].concat()));
}

/// The id of a scene does not say what is in the files beside it.
#[test]
fn parts_of_a_scene_whose_files_have_changed_do_not_fit_together() {
    let folder = folder("changed");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let scene = r#"{ "version": 1, "image": { "width": 8, "height": 8 }, "objects": [{ "model": { "asset": "it.obj" } }],
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } } }"#;
    write("placed.json", scene);
    write("it.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let tile = |index: &str| {
        let to = format!("part{index}.tile");
        done(&folder, &["tile", "placed.json", "--of", "2", "--index", index, "-o", &to], "")
    };
    let assemble = ["assemble", "placed.json", "part{index}.tile", "--of", "2", "-o", "whole.png"];
    tile("0");
    tile("1");
    done(&folder, &assemble, "");
    write("it.obj", "v -1 -1 0\nv 1 -1 0\nv 0 2 0\nf 1 2 3\n");
    tile("1");
    fails(&folder, &assemble, "", 65, "was rendered when a model or a picture of the scene was another file");
}

#[test]
fn no_result_replaces_a_file_of_the_scene() {
    let folder = folder("replaced");
    let model = "mtllib box.mtl\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    std::fs::write(folder.join("box.obj"), model).unwrap();
    std::fs::write(folder.join("box.mtl"), "newmtl wood\nmap_Kd box.png\n").unwrap();
    done(&folder, &["render", "ball.json", "-o", "box.png", "--width", "8", "--height", "8"], "");
    let _ = std::fs::remove_file(folder.join("linked.png"));
    std::fs::hard_link(folder.join("box.png"), folder.join("linked.png")).unwrap();
    std::fs::copy(folder.join("box.png"), folder.join("0.png")).unwrap();
    let patch = r#"{ "materials": { "m": { "diffuse": { "image": { "source": "0.png" } } } } }"#;
    std::fs::write(folder.join("two.json"), format!(r#"{{ "patches": [{{}}, {patch}] }}"#)).unwrap();
    done(&folder, &["tile", "ball.json", "--of", "1", "--index", "0", "-o", "0.tile"], "");
    let files = ["ball.json", "ball.nff", "box.obj", "box.mtl", "box.png", "two.json", "0.png", "0.tile"];
    let bytes = || files.map(|file| std::fs::read(folder.join(file)).unwrap());
    let before = bytes();
    for args in [
        // The picture's name is that of the texture, without being asked for.
        &["render", "box.obj"][..],
        &["render", "box.obj", "-o", "./box.png"],
        &["render", "box.obj", "-o", "a.png", "--stats", "box.mtl"],
        &["render", "ball.json", "-o", "a.png", "--stats", "ball.json"],
        &["render", "box.obj", "-o", "box.png", "--frames", "2"],
        &["map", "box.obj", "--of", "rays", "-o", "box.png"],
        &["explain", "ball.json", "--analyze", "--stats", "ball.json"],
        &["tradeoff", "ball.json", "-o", "a.html", "--json", "ball.json"],
        &["import", "ball.nff", "-o", "ball.nff"],
        &["import", "box.obj", "-o", "box.mtl"],
        &["render", "box.obj", "-o", "linked.png"],
        &["render", "ball.json", "--frames", "two.json", "-o", "a.webp", "--stats", "two.json"],
        // The first frame would be a texture of the second.
        &["render", "ball.json", "--frames", "two.json", "-o", "#.png"],
        &["tile", "box.obj", "--of", "2", "--index", "0", "-o", "box.png"],
        &["tile", "store:ball.json", "--store", ".", "--of", "2", "--index", "0", "-o", "store:ball.json"],
        &["frame", "box.obj", "--frame", "0", "-o", "box.png"],
        &["frame", "ball.json", "--sequence", "two.json", "--frame", "0", "-o", "a.png", "--stats", "two.json"],
        &["gallery", "box.obj", "-o", "box.png"],
        &["assemble", "ball.json", "{index}.tile", "--of", "1", "-o", "a.png", "--stats", "0.tile"],
    ] {
        fails(&folder, args, "", 2, "belongs to the scene: name another file for the result");
        assert!(bytes() == before, "{args:?}");
    }
    done(&folder, &["render", "box.obj", "-o", "box-picture.png", "--width", "8", "--height", "8"], "");
    done(&folder, &["render", "box.obj", "-o", "box-picture.png", "--width", "8", "--height", "8"], "");
    for args in [
        &["render", "ball.json", "-o", "a.png", "--stats", "a.png"][..],
        &["render", "ball.json", "--layers", "normal", "-o", "a.png", "--stats", "a.normal.png"],
        &["tradeoff", "ball.json", "-o", "t.svg", "--json", "t.svg"],
    ] {
        fails(&folder, args, "", 2, "cannot be two results: name another file for one of them");
    }
}

#[test]
fn validation_reports_every_problem() {
    let folder = folder("validate");
    let bad = BALL.replace("\"radius\": 1", "\"radius\": -1").replace("[0, 1, 0] } }\n  ]", "[0, 0, 0] } }\n  ]");
    std::fs::write(folder.join("bad.json"), bad).unwrap();
    fails(&folder, &["validate", "bad.json"], "", 1, "/objects/0/sphere/radius");
    fails(&folder, &["validate", "bad.json"], "", 1, "2 problems");
    let output = strahl(&folder, &["validate", "bad.json", "--format", "json"], "");
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["valid"], report["errors"].as_array().map(Vec::len)), (&false.into(), Some(2)), "{report}");
    let good: Value =
        serde_json::from_slice(&done(&folder, &["validate", "ball.json", "--format", "json"], "")).unwrap();
    assert_eq!(good["valid"], true);
}

#[test]
fn the_contract_in_the_repository_is_the_one_in_the_code() {
    let text = done(&folder("openapi"), &["openapi"], "");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/openapi.json");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let stored = std::fs::read(&path).unwrap();
    assert!(stored == text, "api/openapi.json has drifted: `strahl openapi > api/openapi.json`");
}

#[test]
fn the_schema_is_json() {
    let schema: Value = serde_json::from_slice(&done(&folder("schema"), &["schema"], "")).unwrap();
    assert!(schema["properties"]["camera"].is_object());
}

#[test]
fn mistakes_have_an_exit_code_and_a_sentence() {
    let folder = folder("mistakes");
    fails(&folder, &["render", "nothing.json", "-o", "a.png"], "", 1, "nothing.json cannot be read");
    fails(&folder, &["render", "-", "-o", "a.png"], "{", 1, "standard input");
    fails(&folder, &["render", "ball.json", "-o", "nowhere/a.png"], "", 1, "no folder nowhere");
    fails(&folder, &["render", "ball.json", "-o", "a.gif"], "", 2, "a.gif names no format");
    fails(&folder, &["render", "ball.json", "-o", "-"], "", 2, "--format");
    fails(&folder, &["render", "ball.json", "-o", "a.exr", "--bits", "16"], "", 2, "--bits is for PNG");
    fails(&folder, &["render", "ball.json", "-o", "a.png", "--spd-counts"], "", 2, "NFF");
    fails(&folder, &["render", "ball.json", "-o", "a.png", "--region", "30,0,11,1"], "", 2, "40 x 30");
    fails(&folder, &["render", "ball.json", "-o", "a.png", "--region", "1,2,3"], "", 2, "four whole numbers");
    fails(&folder, &["render", "ball.json", "-o", "a.png", "--threads", "0"], "", 2, "--threads");
    fails(&folder, &["render"], "", 2, "<SCENE>");
    fails(&folder, &["tree", "ball.json"], "", 2, "--pixel");
    fails(&folder, &["tree", "ball.json", "--pixel", "40,0"], "", 2, "40 x 30");
    fails(&folder, &["explain", "ball.json", "--region", "0,0,1,1"], "", 2, "--analyze");
    fails(&folder, &["rays", "-"], "", 2, "--rays FILE");
    fails(&folder, &["rendr"], "", 2, "render");
    let help = strahl(&folder, &["render", "--help"], "");
    assert!(help.status.success() && String::from_utf8_lossy(&help.stdout).contains("--min-weight"));
}
