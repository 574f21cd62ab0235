//! Extractors of handlers: the body, the query and the headers of a request.

pub(crate) mod accept;
pub(crate) mod body;
pub(crate) mod body_part;
pub(crate) mod bounded;
pub(crate) mod conditions;
pub(crate) mod json_body;
pub(crate) mod named_job;
pub(crate) mod parameter;
pub(crate) mod path;
pub(crate) mod picture_parameters;
pub(crate) mod prefer;
pub(crate) mod query;
pub(crate) mod scene_request;
mod scene_settings;
pub(crate) mod scene_types;
pub(crate) mod variation;
