//! Where bytes are kept: LRU caches in memory, files on disk.

pub(crate) mod blob_store;
pub(crate) mod data_folder;
pub(crate) mod hit_counter;
pub(crate) mod lru_cache;
