//! Sequences: each is refused with its problems, or its frames are scenes that are refused with theirs, or rendered.

use std::convert::Infallible;
use std::sync::LazyLock;
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::compile::Original;
use strahl::scene::{Format, Loaded, NoFiles, NotLoaded, Overrides, load};
use strahl::sequence::Sequence;

/// Text that is longer says nothing new.
const MOST: usize = 1 << 14;

/// A scene with a body that moves.
const SCENE: &str = r#"{
  "version": 1,
  "image": { "width": 4, "height": 4 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "definitions": { "ball": [{ "sphere": { "center": [0, 1, 0], "radius": 1 } }] },
  "objects": [{ "instance": { "of": "ball", "motion": { "translate": [1, 0, 0], "rotate_deg": { "axis": [0, 1, 0], "angle": 9 } } } }],
  "render": { "samples": 1, "antialias": false, "accuracy": { "fixed": {} } }
}"#;

pub(super) fn json(text: &[u8]) {
    static BASE: LazyLock<Loaded> =
        LazyLock::new(|| load(SCENE.as_bytes(), Format::Json, &Overrides::default()).expect("it is a scene"));
    let Some(sequence) =
        Some(text).filter(|text| text.len() <= MOST).and_then(|text| serde_json::from_slice::<Sequence>(text).ok())
    else {
        return;
    };
    if let Err(problems) = sequence.check() {
        assert!(!problems.0.is_empty() && problems.0.iter().all(|problem| problem.pointer.starts_with("/frames/")));
        return;
    }
    let (original, last) = (Original { description: &BASE.description, scene: &BASE.scene }, sequence.count() - 1);
    // Patches may ask for more than one waits for.
    let settings =
        Overrides { width: Some(4), height: Some(4), max_depth: Some(3), samples: Some(1), ..Overrides::default() };
    for number in [0, last / 2, last] {
        let accept = |_: &_| Ok::<_, Infallible>(());
        match sequence.frame(number).load_if(original, &settings, &NoFiles, &accept) {
            Ok(loaded) => {
                let picture =
                    render(&loaded.scene, Region::whole(4, 4), &Control::default()).expect("nobody cancels it");
                assert!(
                    picture.film.pixels.as_flattened().iter().all(|channel| channel.is_finite() && *channel >= 0.0)
                );
            }
            Err(NotLoaded::Problems(problems)) => {
                assert!(problems.0.iter().all(|problem| problem.detail.contains("in frame")), "{problems:?}");
            }
        }
    }
}
