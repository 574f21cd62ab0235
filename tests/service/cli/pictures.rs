//! Pictures: formats, streams, regions, layers, what is said of their cost, and how a render is stopped.

#[cfg(target_os = "linux")]
use super::most_resident;
use super::{BALL, NFF, done, fails, folder, size};
use crate::common::service::PATIENCE;
use serde_json::{Value, json};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

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
