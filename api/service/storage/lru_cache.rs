//! Values by key within a number of bytes; the one asked for longest ago goes first.

use crate::service::memory_budget::Evict;
use parking_lot::Mutex;
use std::borrow::Borrow;
use std::hash::Hash;

/// The values. Those that are shared are cheap to clone, as an `Arc` or `Bytes` is.
#[derive(Debug)]
pub(crate) struct LruCache<K: Hash + Eq, V> {
    /// Bytes they may take together; 0 keeps none.
    budget: u64,
    kept: Mutex<Kept<K, V>>,
}

#[derive(Debug)]
struct Kept<K: Hash + Eq, V> {
    values: lru::LruCache<K, (V, u64)>,
    bytes: u64,
}

impl<K: Hash + Eq, V: Clone> LruCache<K, V> {
    /// No values yet, and later as many as fit.
    pub(crate) fn new(budget: u64) -> Self {
        Self { budget, kept: Mutex::new(Kept { values: lru::LruCache::unbounded(), bytes: 0 }) }
    }

    /// The value of a key, which is then the one asked for last.
    pub(crate) fn get<Q: Hash + Eq + ?Sized>(&self, key: &Q) -> Option<V>
    where
        K: Borrow<Q>,
    {
        self.kept.lock().values.get(key).map(|(value, _)| value.clone())
    }

    /// Whether there is a value of a key. This does not count as asking for it.
    pub(crate) fn holds<Q: Hash + Eq + ?Sized>(&self, key: &Q) -> bool
    where
        K: Borrow<Q>,
    {
        self.kept.lock().values.contains(key)
    }

    /// Keeps a value of some bytes, and returns the keys of the values evicted for it. A value larger than the whole budget is
    /// not kept and evicts nothing.
    pub(crate) fn put(&self, key: K, value: V, bytes: u64) -> Vec<K> {
        if bytes > self.budget {
            return Vec::new();
        }
        let mut kept = self.kept.lock();
        kept.bytes += bytes;
        // Two requests may have made the same value at the same time.
        let same = kept.values.put(key, (value, bytes));
        kept.bytes -= same.as_ref().map_or(0, |(_, bytes)| *bytes);
        let mut gone = Vec::new();
        while kept.bytes > self.budget
            && let Some((key, (value, bytes))) = kept.values.pop_lru()
        {
            kept.bytes -= bytes;
            gone.push((key, value));
        }
        // Giving back the memory of a large value takes its time, and others wait for the lock.
        drop(kept);
        drop(same);
        gone.into_iter().map(|(key, _)| key).collect()
    }

    /// Forgets a value; whether there was one.
    pub(crate) fn remove<Q: Hash + Eq + ?Sized>(&self, key: &Q) -> bool
    where
        K: Borrow<Q>,
    {
        let mut kept = self.kept.lock();
        let gone = kept.values.pop(key);
        kept.bytes -= gone.as_ref().map_or(0, |(_, bytes)| *bytes);
        drop(kept);
        gone.is_some()
    }

    /// All keys, in no order.
    pub(crate) fn keys(&self) -> Vec<K>
    where
        K: Clone,
    {
        self.kept.lock().values.iter().map(|(key, _)| key.clone()).collect()
    }

    /// Bytes that are kept.
    pub(crate) fn bytes(&self) -> u64 {
        self.kept.lock().bytes
    }
}

impl<K: Hash + Eq + Send, V: Send> Evict for LruCache<K, V> {
    fn bytes(&self) -> u64 {
        self.kept.lock().bytes
    }

    fn evict(&self) -> bool {
        let mut kept = self.kept.lock();
        let gone = kept.values.pop_lru();
        kept.bytes -= gone.as_ref().map_or(0, |(_, (_, bytes))| *bytes);
        drop(kept);
        gone.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_asked_for_longest_ago_goes_first() {
        let recent = LruCache::new(2);
        assert!(recent.put("a", 1, 1).is_empty() && recent.put("b", 2, 1).is_empty());
        assert_eq!(recent.get("a"), Some(1));
        assert_eq!(recent.put("c", 3, 1), ["b"]);
        assert_eq!(["a", "b", "c"].map(|key| recent.get(key)), [Some(1), None, Some(3)]);
        recent.put("c", 4, 1);
        assert_eq!((recent.get("c"), recent.bytes()), (Some(4), 2), "a value made twice counts once");
        assert!(recent.remove("c") && !recent.remove("c"));
        assert_eq!(recent.bytes(), 1);
    }

    #[test]
    fn a_value_larger_than_the_budget_throws_nothing_out() {
        let recent = LruCache::new(2);
        recent.put("small", (), 1);
        recent.put("large", (), 3);
        assert_eq!(["small", "large"].map(|key| recent.get(key)), [Some(()), None]);
    }
}
