//! What handlers take out of a request: its body, its query, what its headers ask for.

pub(crate) mod accept;
pub(crate) mod body;
pub(crate) mod conditions;
pub(crate) mod named_job;
pub(crate) mod path;
pub(crate) mod prefer;
pub(crate) mod query;
pub(crate) mod scene_request;
