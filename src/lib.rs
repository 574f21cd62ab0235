//! strahl renders JSON scenes with Whitted's recursive ray tracing (CACM 23(6), 1980).

pub mod film;
pub mod math;
pub mod plan;
pub mod reference;
pub mod render;
pub mod scene;
pub mod trace;
