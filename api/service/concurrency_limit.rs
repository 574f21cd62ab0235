//! Concurrency limits: event streams of a tenant, tiles of a client. One that asks for everything leaves room for the others.

use parking_lot::Mutex;
use std::collections::HashMap;
use std::fmt::Debug;
use std::hash::Hash;
use std::sync::Arc;

/// Permits in use by holder.
#[derive(Debug)]
pub(crate) struct ConcurrencyLimit<K>(Arc<Mutex<HashMap<K, u32>>>);

/// A permit, which is given back when dropped.
#[derive(Debug)]
pub(crate) struct Permit<K: Hash + Eq> {
    places: Arc<Mutex<HashMap<K, u32>>>,
    who: K,
}

impl<K> Default for ConcurrencyLimit<K> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<K: Hash + Eq + Clone> ConcurrencyLimit<K> {
    /// Another permit for `who`. None if it has `most` already.
    pub(crate) fn enter(&self, who: K, most: u32) -> Option<Permit<K>> {
        self.enter_if(who, |own, _| own < most)
    }

    /// The same if `may` says so of the permits that `who` has, and of a function that counts all.
    pub(crate) fn enter_if(&self, who: K, may: impl FnOnce(u32, &dyn Fn() -> u64) -> bool) -> Option<Permit<K>> {
        let mut taken = self.0.lock();
        let count = taken.get(&who).copied().unwrap_or(0);
        may(count, &|| all(&taken)).then(|| {
            taken.insert(who.clone(), count + 1);
            Permit { places: Arc::clone(&self.0), who }
        })
    }

    /// All permits in use.
    pub(crate) fn taken(&self) -> u64 {
        all(&self.0.lock())
    }
}

fn all<K>(taken: &HashMap<K, u32>) -> u64 {
    taken.values().copied().map(u64::from).sum()
}

impl<K: Hash + Eq> Drop for Permit<K> {
    fn drop(&mut self) {
        let mut taken = self.places.lock();
        if let Some(count) = taken.get_mut(&self.who) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.who);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looking and entering are one step: of many that come at once none is too many.
    #[test]
    fn a_bound_on_all_holds_for_those_who_come_at_once() {
        let places = ConcurrencyLimit::default();
        let start = std::sync::Barrier::new(32);
        let enter = |who: u32| {
            start.wait();
            places.enter_if(who, |_, all| all() < 5)
        };
        let held: Vec<_> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..32).map(|who| scope.spawn(move || enter(who))).collect();
            all.into_iter().filter_map(|one| one.join().unwrap()).collect()
        });
        assert_eq!((held.len(), places.taken()), (5, 5));
    }

    #[test]
    fn each_has_its_share_and_gives_it_back() {
        let places = ConcurrencyLimit::default();
        let held: Vec<_> = (0..2).map(|_| places.enter("a", 2).unwrap()).collect();
        assert!(places.enter("a", 2).is_none());
        assert!(places.enter("b", 2).is_some(), "others have their own");
        assert_eq!(places.taken(), 2);
        drop(held);
        assert!(places.enter("a", 1).is_some());
        assert!(places.0.lock().is_empty(), "nothing is left of those who have none");
    }
}
