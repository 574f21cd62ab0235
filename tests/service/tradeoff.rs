//! Trade-offs of scenes of the repository: every picture is compared, and the settings that are named are those that were
//! measured.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

fn strahl(args: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).to_str().unwrap().to_owned()
}

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tradeoff").join(test);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn read(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}

/// The trade-off of a scene, and its page.
fn tradeoff(folder: &Path, name: &str, more: &[&str]) -> (Value, String) {
    let (json, page) = (folder.join("t.json"), folder.join("t.html"));
    let args = ["tradeoff", &scene(name), "-o", page.to_str().unwrap(), "--json", json.to_str().unwrap()];
    strahl(&[&args, more].concat());
    (read(&json), std::fs::read_to_string(&page).unwrap())
}

fn rays(counts: &Value) -> u64 {
    let kinds = ["camera", "shadow", "reflected", "transmitted", "gathered"];
    kinds.iter().map(|kind| counts[kind].as_u64().unwrap()).sum()
}

#[test]
fn dear_scenes_are_compared_in_a_smaller_picture() {
    let folder = folder("dear");
    for name in ["whitted/whitted.json", "refraction/glass_of_water.json"] {
        let (t, page) = tradeoff(&folder, name, &["--seconds", "12"]);
        let choices = &t["choices"];
        assert!(choices["reference"].is_object(), "{name}: {}", choices["answer"]);
        let all = choices["all"].as_array().unwrap();
        let measured = || all.iter().filter(|choice| choice["request_ms"].is_number());
        assert!(measured().count() > 5 && measured().all(|choice| choice["difference"].is_object()), "{name}: {all:?}");
        let answer = choices["answer"].as_str().unwrap();
        assert!(!answer.contains("judged") && !answer.contains("could not"), "{answer}");
        assert!(page.contains("class=\"choices\"") && page.contains("Compared are pictures"), "{name}");
    }
}

#[test]
fn what_is_named_is_what_was_measured() {
    let folder = folder("named");
    let (picture, stats) = (folder.join("a.png"), folder.join("stats.json"));
    // Without a bound on endless recursion, with a named depth, and with neither.
    for name in ["whitted/whitted.json", "mirrors/hall.json", "shapes/all.json"] {
        let size = ["--width", "32", "--height", "20"];
        let (t, _) = tradeoff(&folder, name, &[&size[..], &["--seconds", "8"]].concat());
        assert_eq!(t["choices"]["size"], t["circumstances"]["asked_size"], "{name}");
        let named = |of: &Value| of.as_array().unwrap().clone();
        let choices = named(&t["choices"]["all"]).into_iter().filter(|choice| choice["rays"].is_object());
        let points = named(&t["points"]).into_iter().filter(|point| point["settings"]["max_codes"].is_number());
        let points = points.filter(|point| point["rays"].is_object());
        // A busy machine measures points in a picture of another size, and says so.
        let all: Vec<(Value, &Value)> = choices
            .map(|choice| (choice, &t["choices"]["size"]))
            .chain(points.map(|point| (point, &t["circumstances"]["size"])))
            .collect();
        assert!(all.len() > 10, "{name}: {all:?}");
        for (measured, size) in all {
            let settings = &measured["settings"];
            let number = |key: &str| settings[key].to_string();
            let mut args: Vec<String> = ["render", &scene(name)].map(str::to_owned).to_vec();
            let [width, height] = [0, 1].map(|side| size[side].to_string());
            args.extend(["--width".to_owned(), width, "--height".to_owned(), height]);
            args.extend(["-o", picture.to_str().unwrap(), "--stats", stats.to_str().unwrap()].map(str::to_owned));
            match settings["max_codes"].as_u64() {
                Some(codes) => args.extend(["--accuracy".to_owned(), format!("proved:{codes}")]),
                None => args.extend(["--accuracy", "fixed", "--min-weight", &number("min_weight")].map(str::to_owned)),
            }
            if settings["max_depth"].is_u64() {
                args.extend(["--max-depth".to_owned(), number("max_depth")]);
            }
            args.extend(["--samples".to_owned(), number("samples"), "--antialias".to_owned(), number("antialias")]);
            args.extend(["--precision".to_owned(), settings["precision"].as_str().unwrap().to_owned()]);
            strahl(&args.iter().map(String::as_str).collect::<Vec<_>>());
            let rendered = rays(&read(&stats)["cost"]["rays"]);
            assert_eq!(rays(&measured["rays"]), rendered, "{name}: {settings}");
        }
    }
}

/// Each setting has the samples that its name says, also where the scene's own mode would choose them.
#[test]
fn modes_that_choose_samples_are_left_out_and_named() {
    let folder = folder("left-out");
    let size = ["--width", "60", "--height", "34", "--seconds", "10"];
    for mode in ["statistical:2,0.9", "time:200", "rays:100000"] {
        let (t, page) = tradeoff(&folder, "whitted/whitted.json", &[&size[..], &["--accuracy", mode]].concat());
        let remarks = t["choices"]["remarks"].as_array().unwrap();
        let said = format!("the scene's own mode, {mode},");
        assert!(remarks.iter().any(|remark| remark.as_str().unwrap().contains(&said)), "{mode}: {remarks:?}");
        assert!(page.contains(mode), "{mode}");
        let [width, height] = [0, 1].map(|side| t["circumstances"]["size"][side].as_u64().unwrap());
        let points = t["points"].as_array().unwrap().iter().filter(|point| point["rays"].is_object());
        let plain: Vec<_> = points.filter(|point| point["settings"]["antialias"] == false).collect();
        assert!(plain.len() > 10, "{mode}: {plain:?}");
        for point in plain {
            let samples = point["settings"]["samples"].as_u64().unwrap() * width * height;
            // A proof may trace some of them once more.
            let most = samples + if point["settings"]["max_codes"].is_null() { 0 } else { samples / 10 };
            let camera = point["rays"]["camera"].as_u64().unwrap();
            assert!((samples..=most).contains(&camera), "{mode}: {camera} of {samples}: {}", point["settings"]);
        }
        let is_asked = |point: &Value| point["sweeps"].as_array().unwrap().contains(&"as_asked".into());
        assert!(!t["points"].as_array().unwrap().iter().any(is_asked), "{mode}");
    }
    // Pixels of a scene that names no samples choose their number.
    let (t, _) = tradeoff(&folder, "effects/soft_shadows.json", &["--width", "48", "--height", "27", "--seconds", "3"]);
    let remarks = t["choices"]["remarks"].to_string();
    assert!(remarks.contains("each pixel chooses its number of samples"), "{remarks}");
}

#[test]
fn a_page_says_what_is_proved_and_which_setting_is_the_default() {
    let folder = folder("said");
    let (t, page) = tradeoff(&folder, "whitted/whitted.json", &["--width", "48", "--height", "27", "--seconds", "3"]);
    let remarks = t["choices"]["remarks"].as_array().unwrap();
    assert!(remarks.iter().any(|remark| remark.as_str().unwrap().contains("depth 10")), "{remarks:?}");
    assert!(page.contains("\u{2264} 1 (to depth 10)"));
    let (t, page) =
        tradeoff(&folder, "effects/soft_shadows.json", &["--width", "48", "--height", "27", "--seconds", "3"]);
    // Its default has as many samples as each pixel asks for, so what is compared is not the default, and is asked for with its samples.
    assert!(!t["choices"]["answer"].as_str().unwrap().contains("default"), "{}", t["choices"]["answer"]);
    assert!(page.contains("proved:1&amp;samples=64"));
    let all = t["choices"]["all"].as_array().unwrap();
    // Its pixels have many samples already.
    assert!(!all.iter().any(|choice| choice["name"] == "no antialiasing"), "{all:?}");
    assert!(page.contains("logarithmic"));
    let (t, page) = tradeoff(&folder, "shapes/all.json", &["--width", "48", "--height", "27", "--seconds", "3"]);
    assert!(t["choices"]["answer"].as_str().unwrap().contains("default (proved:1)"), "{}", t["choices"]["answer"]);
    assert!(page.contains("proved:1") && !page.contains("samples="));
}

/// Black before nothing: what depth changes is alpha alone.
#[test]
fn alpha_is_measured() {
    let folder = folder("alpha");
    let ball = |x: f64| serde_json::json!({ "sphere": { "center": [x, 0, 0], "radius": 0.9, "material": "glass" } });
    let scene = serde_json::json!({
        "version": 1, "image": { "width": 48, "height": 32 }, "lights": [], "film": { "background": "transparent" },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "materials": { "glass": { "ambient": 0, "diffuse": 0, "transmission": 0.9 } },
        "objects": [ball(-1.0), ball(0.0), ball(1.0)],
    });
    let file = folder.join("glass.json");
    std::fs::write(&file, scene.to_string()).unwrap();
    let (t, _) = tradeoff(&folder, file.to_str().unwrap(), &["--seconds", "3"]);
    let all = t["choices"]["all"].as_array().unwrap();
    let shallow = all.iter().find(|choice| choice["name"] == "depth 3").unwrap();
    let most = shallow["difference"]["codes"]["error"]["max"].as_f64().unwrap();
    assert!(most > 10.0 && most <= shallow["proved_codes"].as_f64().unwrap(), "{shallow}");
}
