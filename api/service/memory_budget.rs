//! How much memory requests, jobs and caches take together.
//!
//! Whoever makes something large takes a [`Share`] before, which goes with it for as long as it is there. What has no room is
//! refused, once the caches have forgotten what they keep.

use super::ANONYMOUS;
use super::error::Error;
use parking_lot::{Mutex, MutexGuard};
use std::collections::HashMap;
use std::fmt::{self, Debug, Formatter};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

/// The least budget: the program, and some work.
pub(crate) const LEAST: u64 = 128 << 20;
/// Bytes that the program takes beside what is counted.
const PROGRAM: u64 = 32 << 20;
/// Seconds until there may be room again.
const RETRY_AFTER: u32 = 2;

/// The budget. Clones are the same one.
#[derive(Debug, Clone)]
pub(crate) struct MemoryBudget(Arc<Account>);

struct Account {
    limit: u64,
    taken: AtomicU64,
    /// What bodies of requests take of it, by tenant.
    bodies: Mutex<HashMap<String, u64>>,
    caches: Mutex<Vec<Weak<dyn Evict>>>,
}

/// What can forget some of what it keeps.
pub(crate) trait Evict: Send + Sync {
    /// Bytes that are kept.
    fn bytes(&self) -> u64;
    /// Forgets the value asked for longest ago; false if there is none.
    fn evict(&self) -> bool;
}

/// A part of the budget, given back when it is dropped.
#[derive(Debug)]
pub(crate) struct Share {
    budget: MemoryBudget,
    bytes: u64,
    /// What the same request has beside: it cannot wait for that to become free.
    beside: u64,
}

/// What the bodies of a tenant's requests take, this one's part of which is given back when it is dropped. Beside another one none
/// may grow beyond half of the budget with it, so that what one tenant sends, and does not finish, leaves room for others.
#[derive(Debug)]
struct BodyShare {
    budget: MemoryBudget,
    tenant: String,
    bytes: u64,
}

/// Bytes together with their share.
#[derive(Debug)]
pub(crate) struct MeteredBytes {
    bytes: Vec<u8>,
    share: Share,
    body: Option<BodyShare>,
}

impl MemoryBudget {
    /// A budget of a number of bytes, of which the program takes some.
    pub(crate) fn new(limit: u64) -> Self {
        let (bodies, caches) = Default::default();
        Self(Arc::new(Account { limit, taken: AtomicU64::new(PROGRAM), bodies, caches }))
    }

    /// Bytes that one piece of work can have.
    pub(crate) fn most(&self) -> u64 {
        self.0.limit - PROGRAM
    }

    /// Bytes that are taken.
    pub(crate) fn taken(&self) -> u64 {
        self.0.taken.load(Ordering::Relaxed)
    }

    /// A cache that gives way when there is no room.
    pub(crate) fn evict_from(&self, cache: Weak<dyn Evict>) {
        self.caches().push(cache);
    }

    /// A share that grows, for one who has some bytes beside.
    pub(crate) fn share(&self, beside: u64) -> Share {
        Share { budget: self.clone(), bytes: 0, beside }
    }

    /// No bytes yet.
    pub(crate) fn empty(&self) -> MeteredBytes {
        MeteredBytes { bytes: Vec::new(), share: self.share(0), body: None }
    }

    /// No bytes yet of a body that a tenant sends.
    pub(crate) fn body_of(&self, tenant: &str) -> MeteredBytes {
        // Without keys all clients are one tenant, from which none is protected.
        let has_tenants = tenant != ANONYMOUS;
        let body = has_tenants.then(|| BodyShare { budget: self.clone(), tenant: tenant.to_owned(), bytes: 0 });
        MeteredBytes { body, ..self.empty() }
    }

    /// A share for a few bytes that are there already.
    pub(crate) fn metered(&self, bytes: Vec<u8>) -> Result<MeteredBytes, Error> {
        let mut share = self.share(0);
        share.grow(bytes.len() as u64)?;
        Ok(MeteredBytes { bytes, share, body: None })
    }

    /// Bytes that are read from disk, if they are there and there is memory for them.
    pub(crate) fn read(
        &self,
        bytes: u64,
        read: impl FnOnce() -> Result<Option<Vec<u8>>, Error>,
    ) -> Result<Option<MeteredBytes>, Error> {
        let mut share = self.share(0);
        share.grow(bytes)?;
        Ok(read()?.map(|bytes| MeteredBytes { bytes, share, body: None }))
    }

    /// Refuses what one piece of work can never have.
    pub(crate) fn check(&self, needed: u64) -> Result<(), Error> {
        if needed <= self.most() {
            return Ok(());
        }
        let most = self.most();
        let detail = format!(
            "this would take {needed} bytes of memory, and requests can have {most} of the service's (memory_bytes)"
        );
        Err(Error::Limit { name: "memory_bytes", max: self.0.limit, detail })
    }

    fn take(&self, bytes: u64, having: u64) -> Result<(), Error> {
        self.check(bytes.saturating_add(having))?;
        let max = self.0.limit;
        let fits = |taken: u64| taken.checked_add(bytes).filter(|taken| *taken <= max);
        while self.0.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits).is_err() {
            // Caches forget nothing for what has no room without them either.
            let in_use = self.taken().saturating_sub(self.evictable());
            if in_use.saturating_add(bytes) > max || !self.evict() {
                let detail = "other requests take all the memory there is (memory_bytes)".into();
                return Err(Error::Busy { detail, retry_after: RETRY_AFTER });
            }
        }
        Ok(())
    }

    /// Bytes that caches could forget.
    fn evictable(&self) -> u64 {
        self.caches().iter().filter_map(Weak::upgrade).map(|cache| cache.bytes()).sum()
    }

    /// Lets the largest cache forget a value; false if all are empty.
    fn evict(&self) -> bool {
        let caches: Vec<_> = self.caches().iter().filter_map(Weak::upgrade).collect();
        caches.iter().max_by_key(|cache| cache.bytes()).is_some_and(|cache| cache.evict())
    }

    fn caches(&self) -> MutexGuard<'_, Vec<Weak<dyn Evict>>> {
        // A list that only grows.
        self.0.caches.lock()
    }

    fn bodies(&self) -> MutexGuard<'_, HashMap<String, u64>> {
        // Sums, which are right after each statement.
        self.0.bodies.lock()
    }
}

impl Debug for Account {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Account").field("limit", &self.limit).field("taken", &self.taken).finish_non_exhaustive()
    }
}

impl Share {
    /// Its bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Takes more, until it is as large. An error leaves it as it was.
    pub(crate) fn grow(&mut self, bytes: u64) -> Result<(), Error> {
        let more = bytes.saturating_sub(self.bytes);
        self.budget.take(more, self.bytes + self.beside)?;
        self.bytes += more;
        Ok(())
    }

    /// Gives back what is more than some bytes.
    pub(crate) fn shrink(&mut self, bytes: u64) {
        let less = self.bytes.saturating_sub(bytes);
        self.budget.0.taken.fetch_sub(less, Ordering::Relaxed);
        self.bytes -= less;
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.shrink(0);
    }
}

impl BodyShare {
    /// Takes more, until it is as large. One body alone is never too large here.
    fn grow(&mut self, bytes: u64) -> Result<(), Error> {
        let more = bytes.saturating_sub(self.bytes);
        let mut bodies = self.budget.bodies();
        let taken = bodies.entry(self.tenant.clone()).or_default();
        if *taken > self.bytes && taken.saturating_add(more) > self.budget.most() / 2 {
            let detail = "bodies of your other requests take half of the memory there is (memory_bytes)".into();
            return Err(Error::TenantBusy { detail, retry_after: RETRY_AFTER });
        }
        *taken += more;
        self.bytes += more;
        Ok(())
    }
}

impl Drop for BodyShare {
    fn drop(&mut self) {
        let mut bodies = self.budget.bodies();
        if let Some(taken) = bodies.get_mut(&self.tenant) {
            *taken = taken.saturating_sub(self.bytes);
        }
        bodies.retain(|_, taken| *taken > 0);
    }
}

impl MeteredBytes {
    /// Adds bytes, if there is memory for them.
    pub(crate) fn append(&mut self, more: &[u8]) -> Result<(), Error> {
        if let Some(body) = &mut self.body {
            body.grow((self.bytes.len() + more.len()) as u64)?;
        }
        self.share.grow((self.bytes.len() + more.len()) as u64)?;
        self.bytes.extend_from_slice(more);
        Ok(())
    }

    /// Keeps a part of them only.
    pub(crate) fn keep(&mut self, part: Range<usize>) {
        self.bytes.truncate(part.end);
        self.bytes.drain(..part.start);
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }
}

impl AsRef<[u8]> for MeteredBytes {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::storage::lru_cache::LruCache;

    #[test]
    fn a_part_that_is_kept_has_its_share_until_it_goes() {
        let budget = MemoryBudget::new(PROGRAM + 100);
        let mut bytes = budget.metered(b"{ \"scene\": {} }".to_vec()).unwrap();
        bytes.keep(11..13);
        assert_eq!((bytes.as_ref(), budget.taken()), (&b"{}"[..], PROGRAM + 15));
        drop(bytes);
        assert_eq!(budget.taken(), PROGRAM);
    }

    #[test]
    fn what_never_fits_is_told_from_what_does_not_fit_now() {
        let budget = MemoryBudget::new(PROGRAM + 100);
        let mut first = budget.share(0);
        first.grow(60).unwrap();
        let mut second = budget.share(30);
        assert!(matches!(second.grow(50), Err(Error::Busy { .. })));
        assert!(matches!(second.grow(80), Err(Error::Limit { name: "memory_bytes", .. })));
        second.grow(40).unwrap();
        first.shrink(50);
        second.grow(50).unwrap();
        drop((first, second));
        assert_eq!(budget.taken(), PROGRAM);
    }

    #[test]
    fn bodies_of_one_tenant_take_half() {
        let budget = MemoryBudget::new(PROGRAM + 100);
        let [mut first, mut second] = [0, 1].map(|_| budget.body_of("bolt"));
        first.append(&[0; 40]).unwrap();
        assert!(matches!(second.append(&[0; 20]), Err(Error::TenantBusy { .. })));
        second.append(&[0; 10]).unwrap();
        budget.body_of("acme").append(&[0; 40]).unwrap();
        drop(second);
        first.append(&[0; 50]).unwrap();
        drop(first);
        assert!(budget.bodies().is_empty() && budget.taken() == PROGRAM);
    }

    #[test]
    fn caches_give_way() {
        let budget = MemoryBudget::new(PROGRAM + 100);
        let [small, large] = [0, 1].map(|_| Arc::new(LruCache::<u8, Arc<Share>>::new(1_000)));
        for cache in [&small, &large] {
            budget.evict_from(Arc::<LruCache<u8, Arc<Share>>>::downgrade(cache));
        }
        for (cache, key, bytes) in [(&small, 0, 20), (&large, 0, 30), (&large, 1, 40)] {
            let mut share = budget.share(0);
            share.grow(bytes).unwrap();
            cache.put(key, Arc::new(share), bytes);
        }
        let mut share = budget.share(0);
        share.grow(35).unwrap();
        assert_eq!((small.bytes(), large.bytes()), (20, 40), "the oldest of the largest cache went");
        let refused = budget.share(0).grow(70);
        assert!(matches!(refused, Err(Error::Busy { .. })), "{refused:?}");
        assert_eq!((small.bytes(), large.bytes()), (20, 40), "nothing goes for what has no room without them either");
        share.grow(100).unwrap();
        assert_eq!((small.bytes(), large.bytes(), budget.taken()), (0, 0, PROGRAM + 100));
    }
}
