//! Every effect the renderer knows, by subject: whether a scene calls for it, and why.

pub(super) mod choices;
pub(super) mod light;
pub(super) mod passing;
pub(super) mod picture;
pub(super) mod surfaces;
