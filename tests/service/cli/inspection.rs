//! Rays, trees, maps and plans.

use super::{done, fails, folder, strahl};
use serde_json::Value;
use std::iter;

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

    // So few pixels are all traced by the pilot, if it gets a processor for its 3 ms: without antialiasing it knows everything.
    let shadows_of = |plan: &Value| {
        plan["effects"].as_array().unwrap().iter().find(|effect| effect["effect"] == "shadows").unwrap().clone()
    };
    let analyze = || json(&["--analyze", "--antialias", "false"]);
    let knows_everything = |plan: &Value| shadows_of(plan)["est"]["rays"] == shadows_of(plan)["act"]["rays"];
    let analyzed = iter::repeat_with(analyze).take(20).find(knows_everything).expect("a pilot that traces all pixels");
    let shadows = shadows_of(&analyzed);
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
