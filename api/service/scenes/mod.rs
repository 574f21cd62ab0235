//! Scenes: their ids, their canonical texts, and the cache of those that are built.

pub(crate) mod cache;
pub(crate) mod files;
pub(crate) mod ids;
mod load_memory;
pub(crate) mod prepared;
pub(crate) mod sent_scene;
pub(crate) mod shared_scenes;
pub(crate) mod store;
pub(crate) mod texture_folder;
mod views;
