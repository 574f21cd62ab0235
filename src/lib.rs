//! strahl renders JSON scenes with Whitted's recursive ray tracing (T. Whitted, *An Improved Illumination Model for Shaded
//! Display*, CACM 23(6), 1980), and says what a picture costs and how accurate it is.
//!
//! # From a scene to a picture
//!
//! Four steps, each a pure function of the one before:
//!
//! | Step | Function | Result |
//! |---|---|---|
//! | load | [`scene::load()`] | reads JSON or NFF into a [`scene::Description`] and compiles it into an immutable [`Scene`](scene::Scene). This is the only step that can fail; [`scene::Problems`] lists every mistake with its place. |
//! | plan | [`plan::Plan::new`] | which effects the scene calls for, why, and what they should take |
//! | render | [`render::render()`] | a [`render::Picture`]: pixels in linear light, ray counts, times and bounds |
//! | encode | [`film::encode()`] | the bytes of a PNG, JPEG, WebP, OpenEXR or PFM file |
//!
//! ```
//! use strahl::film::{FileFormat, Region, encode};
//! use strahl::render::{Control, render};
//! use strahl::scene::{Format, Overrides, load};
//!
//! let json = br#"{ "version": 1, "image": { "width": 64, "height": 36 },
//!   "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.8, 0] } },
//!   "materials": { "mirror": { "diffuse": 0.1, "reflection": 0.8 } },
//!   "objects": [ { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "mirror" } },
//!                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } } ] }"#;
//!
//! let scene = load(json, Format::Json, &Overrides::default())?.scene;
//! let picture = render(&scene, Region::whole(64, 36), &Control::default()).expect("it is not cancelled");
//! std::fs::write(std::env::temp_dir().join("ball.png"), encode(&picture.film, FileFormat::Png8))?;
//!
//! // What it cost, and how accurate it is. By default it is proved that no pixel is more than one 8-bit code off.
//! assert!(picture.rays.camera >= 64 * 36 && picture.rays.reflected > 0);
//! assert!(picture.trace_ms > 0.0);
//! assert!(picture.proof().max_codes <= 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A mistake is reported with its place and what to do:
//!
//! ```
//! use strahl::scene::{Format, Overrides, load};
//!
//! let json = br#"{ "version": 1, "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } },
//!   "objects": [ { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glas" } } ],
//!   "materials": { "glass": { "transmission": 0.9 } } }"#;
//! let problems = load(json, Format::Json, &Overrides::default()).unwrap_err();
//! assert_eq!(
//!     problems.to_string(),
//!     "line 2, column 76: /objects/0/sphere/material: no material \"glas\"; did you mean \"glass\"?",
//! );
//! ```
//!
//! # What a scene calls for
//!
//! The renderer simulates only that. The plan says what it is, and why:
//!
//! ```
//! use strahl::plan::Plan;
//! use strahl::scene::{Format, Overrides, load};
//!
//! # let json = br#"{ "version": 1, "image": { "width": 64, "height": 36 },
//! #   "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.8, 0] } },
//! #   "materials": { "mirror": { "diffuse": 0.1, "reflection": 0.8 } },
//! #   "objects": [ { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "mirror" } },
//! #                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } } ] }"#;
//! let mut loaded = load(json, Format::Json, &Overrides::default())?;
//! let plan = Plan::new(&mut loaded.description, &loaded.scene);
//! let reflection = plan.explanation.effects.iter().find(|effect| effect.effect == "reflection").expect("it is listed");
//! assert_eq!(reflection.because, ["/materials/mirror/reflection"]);
//! assert!(plan.explanation.names_on().all(|name| name != "transmission"));
//! # Ok::<(), strahl::scene::Problems>(())
//! ```
//!
//! `examples/` has three programs to start from: `render`, `explain`, and `tradeoff`, which measures what accuracy costs.
//!
//! # Modules
//!
//! `ARCHITECTURE.md` has the map: which module imports which, from the top down. A scene goes through `scene` (text to
//! [`scene::Scene`]), `plan` says what it calls for, `render` makes its picture of the rays of `trace`, `inspect` answers questions about
//! single rays and pixels, `tradeoff` says what accuracy costs.
//!
//! The kernel in `trace` is written once, over a number type of `lanes`: 16 single-precision or 8 double-precision lanes for
//! packets of rays, one lane for single rays. So precision, instruction set and number of threads never change how a picture
//! is computed.

pub mod accel;
pub mod bound;
pub mod camera;
pub mod control;
pub mod enum_names;
pub mod film;
pub mod inspect;
pub mod lanes;
pub mod math;
pub mod metrics;
pub mod models;
pub mod plan;
pub mod ray;
pub mod reference;
pub mod render;
pub mod scene;
pub mod sequence;
pub mod shading;
pub mod shape;
mod strict_json;
pub mod trace;
pub mod tradeoff;
