//! strahl renders JSON scenes with Whitted's recursive ray tracing (CACM 23(6), 1980).

pub mod accel;
pub mod bound;
pub mod camera;
pub mod film;
pub mod inspect;
pub mod lanes;
pub mod math;
pub mod metrics;
pub mod plan;
pub mod ray;
pub mod reference;
pub mod render;
pub mod scene;
pub mod shading;
pub mod shape;
pub mod trace;
pub mod tradeoff;
pub mod words;
