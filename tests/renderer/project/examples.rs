//! The programs in `examples/` do what they say.

use crate::common::root;

#[path = "../../../examples/explain.rs"]
#[allow(dead_code, reason = "its main function runs as a program only")]
mod explain;
#[path = "../../../examples/render.rs"]
#[allow(dead_code, reason = "its main function runs as a program only")]
mod render;
#[path = "../../../examples/tradeoff.rs"]
#[allow(dead_code, reason = "its main function runs as a program only")]
mod tradeoff;

#[test]
fn a_scene_is_rendered_into_a_png_and_its_cost_is_said() {
    let picture = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("example.png");
    let said = render::run(&root().join("scenes/whitted/whitted.json"), &picture).unwrap();
    assert_eq!(image::open(&picture).unwrap().width(), 960);
    assert!(said.starts_with("960 x 540 pixels\n") && said.contains("codes off"), "{said}");
}

#[test]
fn effects_are_explained() {
    let said = explain::run(&root().join("scenes/whitted/whitted.json")).unwrap();
    let reflection = said.lines().find(|line| line.starts_with("reflection ")).expect("it is on");
    assert!(reflection.ends_with("/materials/metal/reflection"), "{reflection}");
    assert!(said.lines().last().unwrap().starts_with("about ") && !said.contains("fog"), "{said}");
}

#[test]
fn deeper_pictures_take_more_rays_and_have_smaller_errors() {
    let said = tradeoff::run(&root().join("scenes/mirrors/hall.json"), 80, 50).unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = said.lines().skip(1).map(numbers).collect();
    assert_eq!(rows.len(), 5, "{said}");
    assert!(rows.windows(2).all(|pair| pair[0][1] < pair[1][1] && pair[0][3] > pair[1][3]), "{said}");
}
