//! Pictures: what is asked for, rendering it, the file with its cost report, and the cache of files.

pub(crate) mod assembly;
pub(crate) mod cache;
pub(crate) mod file;
pub(crate) mod map;
pub(crate) mod overlay;
pub(crate) mod passes;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod seen;
pub(crate) mod single_flight;
pub(crate) mod spec;
pub(crate) mod tile_bytes;
pub(crate) mod warnings;
