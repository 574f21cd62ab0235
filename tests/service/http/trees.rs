//! Drawings of the rays of a pixel.

use crate::common::service::Service;
use roxmltree::{Document, Node};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// A mirror and a glass ball with hostile names, a light that one of them hides, and antialiasing.
const STAGE: &str = r#"{
  "version": 1, "image": { "width": 48, "height": 32 }, "background": [0.3, 0.5, 0.8], "ambient": 0.2,
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "lights": [{ "point": { "position": [0, 6, -3] } }, { "directional": { "direction": [1, -1, -1] } }],
  "materials": {
    "mirror": { "diffuse": 0.3, "reflection": 0.6 },
    "glass": { "diffuse": 0.02, "reflection": 0.1, "transmission": 0.9, "ior": 1.5 }
  },
  "objects": [
    { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "glass", "name": "<script>alert(1)</script>]]>&\"'" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "mirror" } }
  ],
  "render": { "samples": 4 }
}"#;

/// A drawing that a browser can show: XML, and nothing that runs or is loaded from elsewhere.
fn drawing<'a>(text: &'a str) -> Document<'a> {
    let drawing = Document::parse(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    for node in drawing.descendants() {
        assert!(!node.has_tag_name("script") && !node.has_tag_name("foreignObject"), "{text}");
        for attribute in node.attributes() {
            assert!(!attribute.name().starts_with("on"), "{text}");
            if attribute.name() == "href" {
                assert!(attribute.value().starts_with("data:image/png;base64,"), "{text}");
                continue;
            }
            assert!(!attribute.value().contains("NaN") && !attribute.value().contains("inf"), "{text}");
        }
    }
    drawing
}

fn texts<'a>(drawing: &Document<'a>, of: &str) -> Vec<String> {
    let of = drawing.descendants().filter(|node| node.has_tag_name(of));
    of.filter_map(|node| node.text().map(str::to_owned)).collect()
}

fn has(texts: &[String], part: &str) -> bool {
    texts.iter().any(|text| text.contains(part))
}

fn ask(service: &Service, query: &str) -> String {
    let answer = service.post_json(&format!("/v1/tree?x=24&y=14&{query}"), STAGE);
    assert_eq!((answer.status, answer.header("content-type")), (200, "image/svg+xml"), "{query}: {}", answer.text());
    answer.text()
}

#[test]
fn codes_of_a_pixel_are_those_of_the_picture() {
    let service = Service::start(&[]);
    let film = r#""image": { "width": 48, "height": 32 }, "film": { "exposure": 1, "tone": "khronos_pbr_neutral" }"#;
    for scene in [STAGE.to_owned(), STAGE.replace(r#""image": { "width": 48, "height": 32 }"#, film)] {
        let answer = service.post_json("/v1/render", &scene);
        let picture = image::load_from_memory(&answer.body).unwrap().to_rgb8();
        for [x, y] in [[3, 3], [24, 14], [24, 30]] {
            let tree: Value = service.post_json(&format!("/v1/tree?x={x}&y={y}"), &scene).json();
            assert_eq!(tree["codes"], json!(picture.get_pixel(x, y).0), "{x}, {y}");
            assert!(tree["codes_off"].as_u64().unwrap() <= 1, "{x}, {y}: the default proves a code");
        }
    }
}

#[test]
fn rays_are_drawn_into_the_picture() {
    let service = Service::start(&[]);
    let text = ask(&service, "format=overlay");
    let overlay = drawing(&text);
    let pictures = overlay.descendants().filter(|node| node.has_tag_name("image")).count();
    let (legend, rays) = (texts(&overlay, "text"), texts(&overlay, "title"));
    assert_eq!(pictures, 1);
    for part in
        ["from the eye: 1", "reflected", "transmitted", "that it reaches", "pixel 24, 14, the first of 4 samples"]
    {
        assert!(has(&legend, part), "{part}: {legend:?}");
    }
    assert!(has(&rays, "<script>alert(1)</script>]]>&\"'"), "{rays:?}");

    let bare = ask(&service, "format=overlay&picture=false");
    assert!(
        !bare.contains("<image") && drawing(&bare).root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg"))
    );

    let aside = ask(&service, "format=overlay&from=6,3,4&to=0,0.5,0&all_samples=true");
    let aside = drawing(&aside);
    let legend = texts(&aside, "text");
    assert!(has(&legend, "all 4 samples (the ring is its eye)") && has(&legend, "from the eye: 4"), "{legend:?}");
    // From aside the camera's rays are lines.
    let is_long = |node: &Node<'_, '_>| node.attribute("d").is_some_and(|path| path.contains('L'));
    assert!(aside.descendants().filter(is_long).count() > 8);
}

/// What is seen from the second camera is the picture of the scene with that camera.
#[test]
fn the_picture_from_another_camera_is_that_of_the_scene_with_it() {
    let service = Service::start(&[]);
    let moved = STAGE.replace("[0, 1, 5]", "[6, 3, 4]");
    let own = service.post_json("/v1/tree?x=0&y=0&format=overlay", &moved).text();
    let other = ask(&service, "format=overlay&from=6,3,4&to=0,0.5,0");
    let picture = |text: &str| {
        let drawing = drawing(text);
        let image = drawing.descendants().find(|node| node.has_tag_name("image")).unwrap();
        image.attribute("href").unwrap().to_owned()
    };
    assert!(picture(&own) == picture(&other));
    assert!(picture(&own) != picture(&ask(&service, "format=overlay")));
}

#[test]
fn trees_say_what_they_show() {
    let service = Service::start(&[]);
    let text = ask(&service, "format=svg&accuracy=fixed&max_depth=3");
    let (one, rays) =
        (drawing(&text), service.post_json("/v1/tree?x=24&y=14&accuracy=fixed&max_depth=3", STAGE).json());
    let texts_of = |drawing: &Document<'_>| texts(drawing, "text");
    let legend = texts_of(&one);
    for part in ["from the eye: 1", "the first of 4 samples", "transmitted", "/objects/1", "\u{2264}"] {
        assert!(has(&legend, part), "{part}: {legend:?}");
    }
    for material in ["glass", "mirror"] {
        assert!(legend.iter().any(|text| text == material), "{material}: {legend:?}");
    }
    assert!(has(&texts(&one, "title"), "to /objects/1 of mirror, weight"));
    let all = ask(&service, "format=svg&accuracy=fixed&max_depth=3&all_samples=true");
    assert!(has(&texts_of(&drawing(&all)), "from the eye: 4"));
    // As data it has all samples, and the bound of each ray that was not followed.
    let rays = rays["rays"].as_array().unwrap();
    assert_eq!(rays.iter().filter(|ray| ray["kind"] == "camera").count(), 4);
    let first = &rays[0]["hit"];
    assert_eq!((&first["object"], &first["material"]), (&"/objects/0".into(), &"/materials/glass".into()));
    let ended: Vec<_> = rays.iter().filter_map(|ray| ray["not_followed"].as_array()).flatten().collect();
    assert!(!ended.is_empty() && ended.iter().all(|ended| ended["codes"].as_u64() <= Some(255)), "{ended:?}");
}

/// Each ray that was not followed has a bound of its own: those of two do not add up, since codes are rounded.
#[test]
fn pruned_rays_have_their_own_bounds() {
    let service = Service::start(&[]);
    let query = "accuracy=fixed&max_depth=2";
    let rays = service.post_json(&format!("/v1/tree?x=24&y=14&{query}"), STAGE).json();
    // Of the first sample: up to the second camera ray.
    let of_first = rays["rays"].as_array().unwrap()[1..].iter().take_while(|ray| ray["kind"] != "camera");
    let ended = of_first.filter_map(|ray| ray["not_followed"].as_array());
    let drawn = ask(&service, &format!("format=svg&{query}"));
    let drawn = texts(&drawing(&drawn), "text");
    let mut bounds = 0;
    for ended in ended.flatten() {
        let letter = if ended["kind"] == "reflected" { 'R' } else { 'T' };
        let bound = if ended["codes"] == 255 { "any".to_owned() } else { format!("\u{2264}{}", ended["codes"]) };
        assert!(drawn.contains(&format!("{letter} {bound}")), "{ended}: {drawn:?}");
        bounds += 1;
    }
    assert!(bounds >= 3, "{drawn:?}");
}

/// Letters are at most about 0.6 of their size across.
#[test]
fn legends_have_room() {
    let service = Service::start(&[]);
    let narrow = STAGE.replace("\"width\": 48", "\"width\": 8");
    for query in ["format=svg", "format=overlay&picture=false", "format=overlay&picture=false&from=6,3,4&to=0,0.5,0"] {
        let answer = service.post_json(&format!("/v1/tree?x=4&y=3&{query}"), &narrow).text();
        let drawing = drawing(&answer);
        let size = |node: &Node<'_, '_>, name: &str| node.attribute(name).and_then(|size| size.parse::<f64>().ok());
        let root = drawing.root_element();
        let (width, usual) = (size(&root, "width").unwrap(), size(&root, "font-size").unwrap());
        for node in drawing.descendants().filter(|node| node.has_tag_name("text")) {
            let text = node.text().unwrap_or_default();
            if node.attribute("text-anchor").is_none() {
                let letter = 0.6 * size(&node, "font-size").unwrap_or(usual);
                let end = size(&node, "x").unwrap() + letter * text.chars().count() as f64;
                assert!(end <= width, "{query}: {text} ends at {end} of {width}");
            }
        }
    }
}

#[test]
fn what_no_drawing_has_is_refused() {
    let service = Service::start(&[]);
    for (query, part) in [
        ("format=overlay&from=1,2,3", "go together"),
        ("format=overlay&from=1,2&to=0,0,0", "three numbers"),
        ("format=overlay&from=1,2,inf&to=0,0,0", "three numbers"),
        ("format=svg&from=1,2,3&to=0,0,0", "format=overlay"),
        ("picture=false", "format=overlay"),
    ] {
        let answer = service.post_json(&format!("/v1/tree?x=1&y=1&{query}"), STAGE);
        assert_eq!(answer.status, 400, "{query}");
        assert!(answer.text().contains(part), "{query}: {}", answer.text());
    }
    let here = service.post_json("/v1/tree?x=1&y=1&format=overlay&from=1,2,3&to=1,2,3", STAGE);
    assert_eq!(here.status, 422, "{}", here.text());
}

/// `UPDATE_GOLDEN=1` draws it anew: look at it.
#[test]
fn the_overlay_of_the_documents_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let flags = "--pixel 220,165 --width 480 --height 270 --overlay --from 10,4.5,4 --to 3,1.8,-3.2";
    let mut command = Command::new(env!("CARGO_BIN_EXE_strahl"));
    let scene = root.join("scenes/whitted/whitted.json");
    let drawn = command.arg("tree").arg(scene).args(flags.split(' ')).output().unwrap();
    let text = String::from_utf8(drawn.stdout).unwrap();
    drawing(&text);
    let path = root.join("docs/pictures/whitted-rays.svg");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap() == text, "docs/pictures/whitted-rays.svg is not current");
    let page = std::fs::read_to_string(root.join("docs/command.md")).unwrap();
    assert!(page.contains(flags) && page.contains("pictures/whitted-rays.svg"));
}

/// A ray of the picture's own camera is a point, at its pixel, whatever the projection.
#[test]
fn camera_rays_are_points_in_their_own_picture() {
    let service = Service::start(&[]);
    for camera in ["\"fisheye\"", "\"panorama\"", "\"cylinder\"", "\"omnimax\"", "\"pinhole\""] {
        let scene = STAGE.replace("\"pinhole\"", camera).replace("[0, 1, 5]", "[0.1, 1.3, 5.7]");
        // Of the sky: the only ray.
        let text = service.post_json("/v1/tree?x=25&y=2&format=overlay&picture=false", &scene).text();
        let paths: Vec<String> = drawing(&text)
            .descendants()
            .filter(|node| node.attribute("stroke-opacity").is_some())
            .filter_map(|node| node.attribute("d").map(str::to_owned))
            .collect();
        assert_eq!(paths.len(), 1, "{camera}: {paths:?}");
        let numbers: Vec<f64> = paths[0].split(['M', 'L', ',']).filter_map(|number| number.parse().ok()).collect();
        let scale = 800.0 / 48.0;
        for at in numbers.chunks(2) {
            let off = [at[0] / scale - 25.5, at[1] / scale - 2.5];
            // The sample lies anywhere in the pixel.
            assert!(off.iter().all(|off| off.abs() <= 0.51), "{camera}: {off:?}");
            assert!(strahl::math::hypot(at[0] - numbers[0], at[1] - numbers[1]) < 0.05, "{camera}: {paths:?}");
        }
    }
}
