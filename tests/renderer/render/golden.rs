//! Pictures of every scene, compared with pictures that a person has looked at: `tests/golden/*.png`, and those that the
//! documents show: `docs/pictures/*.png`.
//!
//! They must agree in every pixel: the renderer computes the same bits on every machine. After a change that is meant to
//! change pictures, look at them and bless them: `UPDATE_GOLDEN=1 cargo test --release --test renderer golden`.

use crate::common::{load_scene, read, render_whole, root, scene_names};
use std::path::PathBuf;
use strahl::film::{FileFormat, Film, encode};
use strahl::scene::{Format, Overrides, load};

const WIDTH: u32 = 240;

/// Models with their pictures: the first is that of the documents.
const MODELS: [(&str, &str); 4] = [
    ("model-figure", "RiggedFigure.glb"),
    ("model-unlit", "UnlitTest.glb"),
    ("model-lights", "LightsPoint.glb"),
    ("model-instances", "own_instances_1000.glb"),
];

fn pixels(png: &[u8]) -> image::RgbaImage {
    image::load_from_memory(png).unwrap().to_rgba8()
}

fn render_model(file: &str, side: u32) -> Film {
    let overrides = Overrides { width: Some(side), height: Some(side), ..Overrides::default() };
    let bytes = read(&format!("tests/inputs/models/{file}"));
    render_whole(&load(&bytes, Format::Gltf, &overrides).unwrap_or_else(|problems| panic!("{file}: {problems}")))
}

/// Compares a film with its golden picture; says what differs.
fn compare(name: &str, film: &Film) -> Result<(), String> {
    compare_in("tests/golden", name, film)
}

/// Compares a film with the picture of a folder; says what differs.
fn compare_in(folder: &str, name: &str, film: &Film) -> Result<(), String> {
    let path = root().join(folder).join(format!("{name}.png"));
    let png = encode(film, FileFormat::Png8);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, png).unwrap();
        return Ok(());
    }
    let golden = std::fs::read(&path)
        .map_err(|_| format!("{name}: no golden picture; render it with UPDATE_GOLDEN=1 and look at it"))?;
    let (new, old) = (pixels(&png), pixels(&golden));
    if new.dimensions() != old.dimensions() {
        return Err(format!("{name}: {:?} pixels instead of {:?}", new.dimensions(), old.dimensions()));
    }
    let differing = new.pixels().zip(old.pixels()).filter(|(a, b)| a != b).count();
    if differing > 0 {
        let shown = root().join("target").join(format!("{}-{name}.png", folder.replace('/', "-")));
        std::fs::write(&shown, png).unwrap();
        return Err(format!("{name}: {differing} pixels differ; the new picture is {}", shown.display()));
    }
    Ok(())
}

fn report(results: impl IntoIterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_scene_looks_as_it_did() {
    report(scene_names().iter().map(|name| {
        let loaded = load_scene(name, WIDTH, Overrides::default());
        assert!(loaded.scene.warnings.is_empty(), "{name}: {:?}", loaded.scene.warnings);
        compare(&name.replace('/', "-"), &render_whole(&loaded))
    }));
}

#[test]
fn the_hall_of_mirrors_shows_what_depth_buys() {
    report([3, 5, 100].map(|depth| {
        let overrides = Overrides { max_depth: Some(depth), ..Overrides::default() };
        compare(&format!("mirrors-hall-depth-{depth}"), &render_whole(&load_scene("mirrors/hall", WIDTH, overrides)))
    }));
}

#[test]
fn every_model_looks_as_it_did() {
    report(MODELS.map(|(name, file)| compare(name, &render_model(file, WIDTH))));
    let (name, file) = MODELS[0];
    let side = pixels(&read(&format!("docs/pictures/{name}.png"))).width();
    report([compare_in("docs/pictures", name, &render_model(file, side))]);
}

#[test]
fn no_golden_picture_has_lost_its_scene() {
    let expected: Vec<String> = scene_names()
        .iter()
        .map(|name| name.replace('/', "-"))
        .chain([3, 5, 100].map(|depth| format!("mirrors-hall-depth-{depth}")))
        .chain(MODELS.map(|(name, _)| name.to_owned()))
        .collect();
    for file in std::fs::read_dir(root().join("tests/golden")).unwrap() {
        let name = file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(expected.contains(&name), "tests/golden/{name}.png belongs to no scene");
    }
}

/// Their names are FOLDER-SCENE or FOLDER-SCENE-depth-N. Pictures of other code, naive-*, are not made by this renderer.
#[test]
fn pictures_of_the_documents_are_current() {
    let scenes = scene_names();
    let is_picture = |path: &PathBuf| path.extension().is_some_and(|e| e == "png");
    let folder = std::fs::read_dir(root().join("docs/pictures")).unwrap().map(|file| file.unwrap().path());
    let names = folder.filter(is_picture).map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned());
    // Tests of their own hold those.
    let is_other = |name: &String| ["naive-", "layer-", "model-"].iter().any(|start| name.starts_with(start));
    report(names.filter(|name| !is_other(name)).map(|name| {
        let (scene, depth) =
            name.split_once("-depth-").map_or((name.as_str(), None), |(scene, n)| (scene, n.parse().ok()));
        let scene = scenes.iter().find(|known| known.replace('/', "-") == scene);
        let scene = scene.ok_or_else(|| format!("docs/pictures/{name}.png belongs to no scene"))?;
        let width = pixels(&read(&format!("docs/pictures/{name}.png"))).width();
        let overrides = Overrides { max_depth: depth, ..Overrides::default() };
        compare_in("docs/pictures", &name, &render_whole(&load_scene(scene, width, overrides)))
    }));
}
