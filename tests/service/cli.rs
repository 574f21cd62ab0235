//! The command as its users see it: the real binary, its files, its streams, its exit codes.

use crate::common::service::PATIENCE;
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const BALL: &str = r#"{
  "version": 1,
  "image": { "width": 40, "height": 30 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "materials": { "red": { "diffuse": [0.8, 0.2, 0.1], "reflection": 0.2 } },
  "objects": [
    { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "red" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }
  ]
}"#;

const NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nb 0.1 0.2 0.3\n\
                   l 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";

/// A folder of its own for each test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(test);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("ball.json"), BALL).unwrap();
    std::fs::write(folder.join("ball.nff"), NFF).unwrap();
    folder
}

fn strahl(folder: &Path, args: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A command that does not read its input may be gone already.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

/// Most resident bytes of a command that succeeds, as far as one sees from outside until it ends.
#[cfg(target_os = "linux")]
fn most_resident(folder: &Path, args: &[&str]) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_strahl"));
    let mut child = command.args(args).current_dir(folder).stderr(Stdio::null()).spawn().unwrap();
    let mut most = 0;
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
        most = most.max(kilobytes.unwrap_or(0) * 1_024);
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return most;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[track_caller]
fn done(folder: &Path, args: &[&str], input: &str) -> Vec<u8> {
    let output = strahl(folder, args, input);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

#[track_caller]
fn fails(folder: &Path, args: &[&str], input: &str, code: i32, part: &str) {
    let output = strahl(folder, args, input);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    let error = text.lines().find(|line| !line.starts_with("warning: ")).unwrap_or_default();
    assert!(error.starts_with("error: ") && text.contains(part), "{args:?}: {part} in {text}");
}

fn size(png: &[u8]) -> (u32, u32) {
    let picture = image::load_from_memory(png).unwrap();
    (picture.width(), picture.height())
}

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

/// One file with all of them, or one for each.
#[test]
fn layers_come_with_a_picture() {
    let folder = folder("layers");
    let all = "distance,normal,object,share:/objects/1";
    done(&folder, &["render", "ball.json", "-o", "a.exr", "--layers", all], "");
    let exr = std::fs::read(folder.join("a.exr")).unwrap();
    let has = |text: &str| exr.windows(text.len()).any(|part| part == text.as_bytes());
    assert!(["R\0", "Z\0", "N.X\0", "crypto_object02.A\0", "share.Y\0", "/objects/1"].into_iter().all(has));
    done(&folder, &["render", "ball.json", "-o", "a.png", "--layers", all], "");
    for layer in ["distance", "normal", "object", "share"] {
        assert_eq!(size(&std::fs::read(folder.join(format!("a.{layer}.png"))).unwrap()), (40, 30), "{layer}");
    }
    // The picture itself is as without.
    let alone = |name: &str, more: &[&str]| {
        done(&folder, &[&["render", "ball.json", "-o", name], more].concat(), "");
        std::fs::read(folder.join(name)).unwrap()
    };
    assert_eq!(alone("b.png", &[]), std::fs::read(folder.join("a.png")).unwrap());
    let to_stdout = ["render", "ball.json", "-o", "-", "--format", "exr", "--layers", all];
    assert_eq!(done(&folder, &to_stdout, ""), exr);

    let wrong = |args: &[&str], part: &str| {
        fails(&folder, &[&["render", "ball.json", "--layers"], args].concat(), "", 2, part);
    };
    wrong(&["normals"], "did you mean \"normal\"");
    wrong(&["share"], "share:/objects/3");
    wrong(&["share:/objects/2", "-o", "c.png"], "2 objects");
    wrong(&["normal", "-o", "c.jpg"], ".exr");
    wrong(&["normal", "-o", "-", "--format", "png"], "--format exr");
}

#[test]
fn a_scene_is_rendered_into_every_format() {
    let folder = folder("render");
    for (name, magic) in [("a.png", b"\x89PNG".as_slice()), ("a.exr", b"\x76\x2f\x31\x01"), ("a.pfm", b"PF\n")] {
        done(&folder, &["render", "ball.json", "-o", name], "");
        assert!(std::fs::read(folder.join(name)).unwrap().starts_with(magic), "{name}");
    }
    assert_eq!(size(&std::fs::read(folder.join("a.png")).unwrap()), (40, 30));
    done(&folder, &["render", "ball.nff", "-o", "n.png", "--width", "9", "--height", "7"], "");
    assert_eq!(size(&std::fs::read(folder.join("n.png")).unwrap()), (9, 7));
    // Pixels of a device, of the size that the scene says or the command line.
    for (args, expected) in [
        (&["--dpr", "2"][..], (80, 60)),
        (&["--dpr", "0.5", "--width", "10"], (5, 15)),
        (&["--dpr", "2", "--frames", "2"], (80, 60)),
        (&["--dpr", "0.5", "--size", "og"], (600, 315)),
    ] {
        done(&folder, &[&["render", "ball.json", "-o", "d.png"], args].concat(), "");
        assert_eq!(size(&std::fs::read(folder.join("d.png")).unwrap()), expected, "{args:?}");
    }
    let deep = done(&folder, &["render", "ball.json", "-o", "-", "--format", "png", "--bits", "16"], "");
    assert_eq!(image::load_from_memory(&deep).unwrap().color(), image::ColorType::Rgb16);
}

#[test]
fn a_dash_is_standard_input_and_output() {
    let folder = folder("dash");
    let png = ["render", "-", "-o", "-", "--format", "png"];
    let json = done(&folder, &png, BALL);
    assert_eq!(size(&json), (40, 30));
    assert_eq!(
        size(&done(&folder, &[&png[..], &["--input", "nff", "--width", "8", "--height", "8"]].concat(), NFF)),
        (8, 8)
    );
    assert_eq!(size(&done(&folder, &[&png[..], &["--width", "8", "--height", "8"]].concat(), NFF)), (8, 8), "sniffed");
}

#[test]
fn threads_and_regions_never_change_a_pixel() {
    let folder = folder("threads");
    let png = ["render", "ball.json", "-o", "-", "--format", "png"];
    let one = done(&folder, &[&png[..], &["--threads", "1"]].concat(), "");
    assert_eq!(one, done(&folder, &[&png[..], &["--threads", "3"]].concat(), ""));
    let part = done(&folder, &[&png[..], &["--region", "5,6,20,10"]].concat(), "");
    let crop = image::load_from_memory(&one).unwrap().crop_imm(5, 6, 20, 10);
    assert_eq!(image::load_from_memory(&part).unwrap().to_rgb8(), crop.to_rgb8());
}

#[test]
fn stats_say_what_the_picture_cost() {
    let folder = folder("stats");
    done(&folder, &["render", "ball.json", "-o", "a.png", "--stats", "stats.json"], "");
    let stats: Value = serde_json::from_slice(&std::fs::read(folder.join("stats.json")).unwrap()).unwrap();
    assert!(stats["plan"]["effects"].is_array(), "{stats}");
    for phase in ["parse", "plan", "bvh", "trace", "refine", "png"] {
        assert!(stats["cost"]["phases_ms"][phase].is_number(), "{phase} in {stats}");
    }
    for kind in ["camera", "shadow", "reflected", "transmitted"] {
        assert!(stats["cost"]["rays"][kind].is_u64(), "{kind} in {stats}");
    }
    assert!(stats["cost"]["wall_ms"].is_number() && stats["cost"]["camera_hits"].is_u64(), "{stats}");
    assert!(stats["error"].as_object().is_some_and(|error| error.len() == 3), "{stats}");
    let proved = &stats["error"]["proved"];
    assert!(proved["max_codes"].as_u64() <= Some(1) && proved["identical_fraction"].is_number(), "{stats}");
    assert!(
        proved["reference"].is_string() && proved["ceiling"].is_array() && proved["not_covered"].is_array(),
        "{stats}"
    );
    assert_eq!(stats["replay"]["render"]["accuracy"], json!({ "proved": { "max_codes": 1 } }), "{stats}");
}

#[test]
fn a_tradeoff_is_a_page_and_numbers() {
    let folder = folder("tradeoff");
    let args = ["tradeoff", "ball.json", "-o", "t.html", "--json", "t.json", "--seconds", "3"];
    let output = strahl(&folder, &args, "");
    let said = String::from_utf8(output.stderr).unwrap();
    let t: Value = serde_json::from_slice(&std::fs::read(folder.join("t.json")).unwrap()).unwrap();
    let answer = t["choices"]["answer"].as_str().unwrap();
    assert!(output.status.success() && said.lines().any(|line| line == answer), "{answer} in {said}");
    let choices = t["choices"]["all"].as_array().unwrap();
    assert!(choices.iter().any(|choice| choice["name"] == "proved:1") && choices.len() <= 11, "{choices:?}");
    let times: Vec<f64> = choices.iter().map(|choice| choice["request_ms"].as_f64().unwrap()).collect();
    let least = t["choices"]["load_ms"].as_f64().unwrap() + t["choices"]["encode_ms"].as_f64().unwrap();
    assert!(times.is_sorted() && times[0] > least, "{choices:?}");
    let points = t["points"].as_array().unwrap();
    assert!(points.len() >= 24, "{}", points.len());
    for point in points {
        assert!(point["time"]["median_ms"].as_f64() >= point["time"]["min_ms"].as_f64(), "{point}");
        assert!(point["rays"]["camera"].as_u64() >= Some(1200), "{point}");
        // In double precision nothing but the end of the recursion makes a difference.
        let (proved, measured) = (&point["proved_codes"], &point["measured"]["truncation"]["codes"]["error"]["max"]);
        if point["settings"]["precision"] == "double" {
            assert!(proved.is_u64() && measured.as_f64() <= proved.as_f64(), "{point}");
        }
        for source in ["truncation", "sampling", "total"] {
            let error = &point["measured"][source];
            for measure in ["/codes/error/max", "/codes/error/p999", "/codes/identical", "/flip/p99", "/ciede2000/mean"]
            {
                assert!(error.pointer(measure).is_some_and(Value::is_number), "{measure} in {source} of {point}");
            }
        }
    }
    assert_eq!(t["fronts"].as_array().map(Vec::len), Some(4), "{t}");
    assert!(t["advice"].as_array().is_some_and(|advice| !advice.is_empty()), "{t}");
    assert_eq!(t["circumstances"]["asked_size"], t["circumstances"]["size"], "so small a picture is not scaled down");

    let page = std::fs::read_to_string(folder.join("t.html")).unwrap();
    // What one needs to choose comes before anything folds out: the answer, pictures and a plot, for broad and slim screens.
    let (first, rest) = page.split_once("<details>").unwrap();
    let shown = first.matches("data:image/png;base64,").count();
    assert!(first.contains(&format!("<p class=\"answer\">{answer}</p>")) && (1..=3).contains(&shown), "{first}");
    for word in ["knee", "front"] {
        assert!(!page.contains(&format!(" {word} ")), "{word}");
    }
    assert_eq!((first.matches("<svg").count(), rest.matches("<svg").count()), (2, 4));
    assert_eq!(rest.matches("data:image/png;base64,").count(), 3 * points.len());
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for word in ["http:", "https:", "<script"] {
        assert!(!outside.contains(word), "{word}");
    }
    done(&folder, &["tradeoff", "ball.json", "-o", "t.svg", "--seconds", "1"], "");
    let drawing = std::fs::read_to_string(folder.join("t.svg")).unwrap();
    assert!(drawing.starts_with("<svg") && !drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
    fails(&folder, &["tradeoff", "ball.json", "-o", "t.png"], "", 2, ".html");
}

#[test]
fn settings_that_are_those_of_the_reference_have_no_error() {
    let folder = folder("tradeoff-exact");
    let settings = [
        "--max-depth",
        "1000",
        "--min-weight",
        "0",
        "--samples",
        "64",
        "--precision",
        "double",
        "--antialias",
        "false",
    ];
    let args = [&["tradeoff", "ball.json", "-o", "-", "--json", "t.json", "--seconds", "6"], &settings[..]].concat();
    done(&folder, &args, "");
    let t: Value = serde_json::from_slice(&std::fs::read(folder.join("t.json")).unwrap()).unwrap();
    assert_eq!(t["reference"]["min_weight"], 0.0, "{}", t["reference"]);
    let asked = t["points"].as_array().unwrap().iter().find(|p| p["sweeps"][0] == "as_asked").unwrap();
    for source in ["truncation", "sampling", "total"] {
        let error = &asked["measured"][source];
        assert_eq!(
            (&error["codes"]["error"]["max"], &error["codes"]["identical"]),
            (&0.0.into(), &1.0.into()),
            "{asked}"
        );
        assert_eq!((&error["flip"]["max"], &error["rms_codes"]), (&0.0.into(), &0.0.into()), "{asked}");
    }
}

#[test]
fn rays_are_answered_line_by_line() {
    let folder = folder("rays");
    let rays = "{\"origin\":[0,1,5],\"direction\":[0,0,-1]}\n{\"origin\":[0,5,0],\"direction\":[0,1,0]}\n";
    let answers = done(&folder, &["rays", "ball.json", "--precision", "double"], rays);
    let answers: Vec<Value> = answers.split(|b| *b == b'\n').filter_map(|l| serde_json::from_slice(l).ok()).collect();
    assert_eq!(answers.len(), 2);
    assert_eq!((&answers[0]["hit"], &answers[1]["hit"]), (&true.into(), &false.into()));

    let output = strahl(&folder, &["rays", "ball.json"], &format!("nonsense\n{rays}"));
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines[0]["error"].is_string() && lines[0]["line"] == 1, "{text}");
}

#[test]
fn plans_and_trees_are_shown() {
    let folder = folder("plans");
    let tree: Value = serde_json::from_slice(&done(&folder, &["tree", "ball.json", "--pixel", "20,15"], "")).unwrap();
    assert!(tree.is_object());
    done(&folder, &["tree", "ball.json", "--pixel", "20,15", "--format", "dot"], "");
    let plan: Value =
        serde_json::from_slice(&done(&folder, &["explain", "ball.json", "--format", "json"], "")).unwrap();
    assert!(plan["effects"].is_array(), "{plan}");
    let actual = done(&folder, &["explain", "ball.json", "--analyze"], "");
    assert!(String::from_utf8_lossy(&actual).contains("camera rays"));
}

#[test]
fn plans_have_estimates_and_with_analyze_what_was_traced() {
    let folder = folder("analyze");
    let json = |args: &[&str]| -> Value {
        let args = [&["explain", "ball.json", "--format", "json"], args].concat();
        serde_json::from_slice(&done(&folder, &args, "")).unwrap()
    };
    let plan = json(&[]);
    assert_eq!(plan["precision"], "single", "{plan}");
    assert!(plan["kernel"].is_string() && plan["kernel_hash"].is_string() && plan["warnings"].is_array(), "{plan}");
    assert!(plan["depth"]["requested"].is_null(), "{plan}");
    assert!(plan["estimate"]["rays"].as_u64() >= Some(40 * 30), "{plan}");
    assert!(plan["explain_ms"].as_f64() > Some(0.0), "{plan}");
    let effects = plan["effects"].as_array().unwrap();
    assert!(effects.len() >= 15);
    for effect in effects {
        assert!(effect["est"]["rays"].is_u64() && effect["reason"].is_string() && effect["act"].is_null(), "{effect}");
    }

    // So few pixels are all traced by the pilot: without antialiasing it knows everything.
    let analyzed = json(&["--analyze", "--antialias", "false"]);
    let shadows = analyzed["effects"].as_array().unwrap().iter().find(|e| e["effect"] == "shadows").unwrap();
    assert_eq!(shadows["est"]["rays"], shadows["act"]["rays"], "{shadows}");
    assert_eq!(shadows["act"]["rays"], analyzed["actual"]["rays"]["shadow"], "{analyzed}");
    assert!(shadows["act"]["ms_estimated"].is_f64(), "{shadows}");
    for effect in analyzed["effects"].as_array().unwrap() {
        let act = &effect["act"];
        assert_eq!(act["share_ms"], act["ms_estimated"], "{effect}");
        assert!(act["saves_ms"].is_null() || effect["state"] == "on", "{effect}");
    }

    let table = done(&folder, &["explain", "ball.json", "--analyze"], "");
    let table = String::from_utf8(table).unwrap();
    assert!(table.lines().all(|line| line.chars().count() <= 100), "{table}");
    let depth = format!("{} reached by the picture's rays", analyzed["depth"]["reached"]);
    assert!(table.contains(&depth) && table.contains("actual rays"), "{table}");
}

/// The numbers of a little-endian grey PFM.
fn numbers(pfm: &[u8]) -> Vec<f32> {
    let lines = pfm.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(2).unwrap();
    let (floats, rest) = pfm[lines.0 + 1..].as_chunks::<4>();
    assert!(rest.is_empty());
    assert!(pfm.starts_with(b"Pf\n"));
    floats.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

#[test]
fn maps_add_up_to_the_picture() {
    let folder = folder("map");
    let map = |of: &str| {
        done(&folder, &["map", "ball.json", "--of", of, "-o", "map.pfm"], "");
        numbers(&std::fs::read(folder.join("map.pfm")).unwrap())
    };
    done(&folder, &["render", "ball.json", "-o", "ball.png", "--stats", "stats.json"], "");
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join("stats.json")).unwrap()).unwrap();
    let kinds = ["camera", "shadow", "reflected", "transmitted", "gathered"];
    let rays: u64 = kinds.iter().map(|kind| report["cost"]["rays"][kind].as_u64().unwrap()).sum();
    let most = |values: &[f32]| f64::from(values.iter().copied().fold(0.0, f32::max));

    let (of_pixels, depths, codes) = (map("rays"), map("depth"), map("proved"));
    assert_eq!(of_pixels.len(), 40 * 30);
    assert_eq!(of_pixels.iter().map(|rays| *rays as u64).sum::<u64>(), rays);
    assert_eq!(Some(most(&depths)), report["cost"]["deepest"].as_f64());
    assert_eq!(Some(most(&codes)), report["error"]["proved"]["max_codes"].as_f64());
    assert!(map("time").iter().all(|nanoseconds| *nanoseconds > 0.0));

    done(&folder, &["map", "ball.json", "--of", "rays", "-o", "map.png"], "");
    assert!(std::fs::read(folder.join("map.png")).unwrap().starts_with(b"\x89PNG"));
    fails(&folder, &["map", "ball.json", "--of", "rays", "-o", "map.gif"], "", 2, "use .png, .pfm or .exr");
}

#[test]
fn what_was_expected_stands_beside_what_it_took() {
    let folder = folder("predicted");
    let stats = ["render", "ball.json", "-o", "ball.png", "--stats", "stats.json", "--width", "800", "--height", "600"];
    done(&folder, &stats, "");
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join("stats.json")).unwrap()).unwrap();
    let predicted = &report["cost"]["predicted"];
    let share = predicted["pilot_pixels"].as_f64().unwrap() / predicted["pixels"].as_f64().unwrap();
    // One pixel of 256, and no more than a 16th however many rays antialiasing adds.
    assert!((1.0 / 256.0..=1.0 / 16.0).contains(&share), "{predicted}");
    let interval = &predicted["ms_ci"];
    assert!(interval[0].as_f64() < predicted["ms"].as_f64() && predicted["ms"].as_f64() < interval[1].as_f64());
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

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < PATIENCE, "it never comes to pass that {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Whether a process has a handler for SIGINT, the second signal (Linux tells).
fn handles_ctrl_c(pid: u32) -> bool {
    let Ok(status) = std::fs::read_to_string(format!("/proc/{pid}/status")) else {
        return cfg!(not(target_os = "linux"));
    };
    let caught = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigCgt:")?.trim(), 16).ok());
    caught.is_some_and(|signals| signals & 0b10 != 0)
}

#[test]
fn ctrl_c_stops_a_render_and_leaves_no_file() {
    let folder = folder("interrupt");
    let slow = BALL
        .replace("\"width\": 40, \"height\": 30", "\"width\": 8000, \"height\": 8000")
        .replace("\"version\": 1,", "\"version\": 1, \"render\": { \"samples\": 1024, \"max_depth\": 1000 },");
    std::fs::write(folder.join("slow.json"), slow).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(["render", "slow.json", "-o", "slow.png"])
        .current_dir(&folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    until("it handles SIGINT", || handles_ctrl_c(child.id()));
    // Long enough that it renders.
    std::thread::sleep(Duration::from_millis(700));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let mut status = None;
    until("it ends", || {
        status = child.try_wait().unwrap();
        status.is_some()
    });
    assert_eq!(status.unwrap().code(), Some(130));
    assert!(!folder.join("slow.png").exists());
}

#[test]
fn pictures_lie_beside_their_scene() {
    let folder = folder("pictures_lie_beside_their_scene");
    let picture = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([(x * 200) as u8, (y * 200) as u8, 0]));
    std::fs::create_dir_all(folder.join("inner/maps")).unwrap();
    picture.save(folder.join("inner/maps/a.png")).unwrap();
    let scene = BALL.replace(
        r#""diffuse": [0.8, 0.2, 0.1]"#,
        r#""diffuse": { "image": { "source": "maps/a.png", "mapping": { "spherical": {} } } }"#,
    );
    std::fs::write(folder.join("inner/ball.json"), &scene).unwrap();
    // Beside the scene, wherever the command runs; not beside the command.
    done(&folder, &["render", "inner/ball.json", "-o", "out.png"], "");
    done(&folder.join("inner"), &["render", "ball.json", "-o", "out.png"], "");
    std::fs::write(folder.join("ball.json"), &scene).unwrap();
    fails(&folder, &["render", "ball.json", "-o", "out.png"], "", 1, "maps/a.png");
    fails(&folder.join("inner"), &["render", "-", "-o", "out.png"], &scene, 1, "files are not read here");
    done(&folder, &["validate", "inner/ball.json"], "");
}

/// A triangle of a mesh with normals has some 90 bytes of text. The text is gone when the hierarchy is built.
#[cfg(target_os = "linux")]
#[test]
fn loading_takes_at_most_150_bytes_for_a_triangle() {
    let folder = folder("loading_memory");
    let side: u32 = 400;
    let point = |i: u32| [i % (side + 1), i / (side + 1)].map(|k| f64::from(k) / 3.0 - 66.6);
    let points = (0..(side + 1) * (side + 1)).map(point);
    let vertices: Vec<_> = points.clone().map(|[x, y]| [x, y, 1.0 / (3.0 + x * x + y * y)]).collect();
    let normals: Vec<_> = points.map(|[x, y]| [1.0 / (3.0 + x * x), -1.0 / (3.0 + y * y), 0.9]).collect();
    let square = |i: u32| {
        let a = i / side * (side + 1) + i % side;
        [[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]
    };
    let faces: Vec<_> = (0..side * side).flat_map(square).collect();
    let scene = json!({
        "version": 1,
        "image": { "width": 64, "height": 64 },
        "camera": { "pinhole": { "eye": [0, 0, 200], "look_at": [0, 0, 0] } },
        "objects": [{ "mesh": { "vertices": vertices, "faces": faces, "normals": normals } }],
    });
    std::fs::write(folder.join("sheet.json"), scene.to_string()).unwrap();
    let bytes = |scene: &str| most_resident(&folder, &["render", scene, "--threads", "1", "-o", "sheet.png"]);
    let each = (bytes("sheet.json") - bytes("ball.json")) as f64 / faces.len() as f64;
    assert!(each <= 150.0, "{each} bytes for each triangle");
}
