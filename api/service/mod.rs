//! What commands and HTTP share: scenes, pictures, jobs, the farm, and the scheduler of the rendering threads.

pub(crate) mod addresses;
pub(crate) mod assets;
pub(crate) mod clock;
pub(crate) mod concurrency_limit;
pub(crate) mod deliveries;
pub(crate) mod error;
pub(crate) mod farm;
pub(crate) mod hash;
pub(crate) mod jobs;
pub(crate) mod limits;
pub(crate) mod memory;
pub(crate) mod memory_budget;
pub(crate) mod pictures;
pub(crate) mod requests;
pub(crate) mod scenes;
pub(crate) mod scheduler;
pub(crate) mod sequences;
pub(crate) mod stop_signals;
pub(crate) mod storage;
pub(crate) mod storage_threads;
pub(crate) mod tls;
pub(crate) mod tradeoff;
pub(crate) mod values;

/// The tenant of all requests where there are no keys.
pub(crate) const ANONYMOUS: &str = "anonymous";

/// Whether a tenant may have this name: 1 to 64 letters, digits and `-`. Names are parts of keys, URLs and names of files, so they
/// must not contain the characters between those parts.
pub(crate) fn is_tenant_name(name: &str) -> bool {
    (1..=64).contains(&name.len()) && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
}
