//! Where bytes are kept: LRU caches in memory, files on disk.

pub(crate) mod blob_store;
pub(crate) mod blobs;
pub(crate) mod disk;
pub(crate) mod folder;
pub(crate) mod hit_counter;
mod left_behind;
pub(crate) mod lru_cache;
pub(crate) mod objects;
pub(crate) mod revisions;
pub(crate) mod seen_by;
pub(crate) mod shared_blobs;
#[cfg(test)]
pub(crate) mod test_journal;
