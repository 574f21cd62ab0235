//! Which tenants have had which of the things that all tenants share. What an answer says about caches is about its own
//! tenant: others learn nothing from it of what a tenant renders.

use super::lru_cache::LruCache;
use crate::service::ANONYMOUS;
use std::hash::{BuildHasher, RandomState};

/// Things that are remembered; of those had longest ago nobody is said to have had them.
const REMEMBERED: u64 = 65_536;

/// Hashes of tenants and names.
#[derive(Debug)]
pub(crate) struct SeenBy {
    hasher: RandomState,
    seen: LruCache<u64, ()>,
}

impl Default for SeenBy {
    fn default() -> Self {
        Self { hasher: RandomState::new(), seen: LruCache::new(REMEMBERED) }
    }
}

impl SeenBy {
    /// Notes that a tenant has something; whether it had it before. Where all are one tenant there is nobody to hide it from.
    pub(crate) fn note(&self, tenant: &str, name: &str) -> bool {
        let key = self.hasher.hash_one((tenant, name));
        let before = tenant == ANONYMOUS || self.seen.get(&key).is_some();
        self.seen.put(key, (), 1);
        before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tenant_has_seen_what_it_has_had() {
        let seen = SeenBy::default();
        assert_eq!(
            [seen.note("a", "x"), seen.note("a", "x"), seen.note("b", "x"), seen.note("a", "y")],
            [false, true, false, false]
        );
        assert!(seen.note(ANONYMOUS, "z"));
    }
}
