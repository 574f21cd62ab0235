//! Which effects a scene calls for.

pub mod effects;
pub mod explain;
mod use_of;
