//! Which effects a scene calls for.

pub mod effects;
pub mod explain;
mod sampled;
mod use_of;
