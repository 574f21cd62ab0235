//! What several tests need: scenes, and the running service.

#[allow(dead_code, reason = "the tests of the farm use all of it")]
pub(crate) mod farm;
pub(crate) mod receiver;
pub(crate) mod service;

/// A ball on a floor: quick.
pub(crate) const BALL: &str = r#"{
  "version": 1,
  "image": { "width": 48, "height": 32 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "background": [0.3, 0.5, 0.8],
  "materials": { "red": { "diffuse": [0.8, 0.2, 0.1], "specular": 0.5, "reflection": 0.2 } },
  "objects": [
    { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "red" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }
  ]
}"#;

/// Two mirrors face to face, a thousand reflections for each sample: slower than any test waits.
pub(crate) const SLOW: &str = r#"{
  "version": 1,
  "image": { "width": 2048, "height": 2048 },
  "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "vfov_deg": 20 } },
  "materials": { "mirror": { "diffuse": 0, "reflection": 1 } },
  "objects": [
    { "plane": { "point": [0, 0, -1], "normal": [0, 0, 1], "material": "mirror" } },
    { "plane": { "point": [0, 0, 1], "normal": [0, 0, -1], "material": "mirror" } }
  ],
  "render": { "max_depth": 1000, "min_weight": 0, "samples": 8, "antialias": false }
}"#;
