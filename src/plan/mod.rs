//! Which effects a scene calls for.

pub mod explain;
mod use_of;
