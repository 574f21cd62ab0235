//! strahl renders JSON scenes with Whitted's recursive ray tracing (CACM 23(6), 1980).

pub mod accel;
pub mod accuracy;
pub mod bound;
pub mod camera;
pub mod film;
pub mod inspect;
pub mod lanes;
pub mod math;
pub mod plan;
pub mod ray;
pub mod reference;
pub mod render;
pub mod scene;
pub mod shading;
pub mod shape;
pub mod trace;
pub mod words;
