//! Scenes that render, and likely not as they were meant.

use serde_json::{Value, json};
use strahl::scene::{Format, Overrides, load};

/// Pointers of the warnings of a lit ball.
fn warned(diffuse: Value, background: Value) -> Vec<String> {
    let scene = json!({
        "version": 1,
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "background": background,
        "lights": [{ "point": { "position": [3, 3, 3] } }],
        "materials": { "red": { "diffuse": diffuse } },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } }]
    });
    let loaded = load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap();
    loaded.scene.warnings.into_iter().map(|warning| warning.pointer).collect()
}

#[test]
fn codes_in_the_place_of_colors_are_noticed() {
    for color in [json!([1, 0, 0]), json!("#ff0000"), json!(0.5), json!({ "checker": { "a": 1, "b": 0 } })] {
        assert!(warned(color, json!(40)).is_empty());
    }
    assert_eq!(warned(json!([255, 0, 0]), json!([10, 20, 255])), ["/materials/red/diffuse", "/background"]);
}
