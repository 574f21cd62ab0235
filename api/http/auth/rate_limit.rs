//! Rate limit of a tenant in units of cost: one for each request, and one for each million rays.
//!
//! It is a token bucket that holds the units of a minute. A request needs one unit. The cost of its picture is taken out
//! afterwards, when it is known. This may leave a debt, for which later requests wait, and which the queue bounds.

use parking_lot::Mutex;
use std::time::Instant;

/// Rays that one unit stands for.
const RAYS: u64 = 1_000_000;

/// A tenant's bucket.
#[derive(Debug)]
pub(crate) struct RateLimit {
    pub(crate) per_minute: u32,
    bucket: Mutex<Bucket>,
}

#[derive(Debug)]
struct Bucket {
    units: f64,
    /// What was taken here and is not yet reported to other fronts of a farm.
    unreported: f64,
    at: Instant,
}

/// State of a bucket, for the `RateLimit` headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Left {
    /// Units in a minute.
    pub(crate) per_minute: u32,
    /// Units in the bucket.
    pub(crate) units: u32,
    /// Seconds until the bucket is full.
    pub(crate) full_in: u32,
}

impl RateLimit {
    /// A full bucket.
    pub(crate) fn new(per_minute: u32) -> Self {
        Self {
            per_minute,
            bucket: Mutex::new(Bucket { units: f64::from(per_minute), unreported: 0.0, at: Instant::now() }),
        }
    }

    /// Takes one unit, or returns the seconds until there is one.
    pub(crate) fn enter(&self, now: Instant) -> Result<(), u32> {
        self.with(now, |bucket, per_second| {
            if bucket.units >= 1.0 {
                bucket.take(1.0);
                Ok(())
            } else {
                Err(whole((1.0 - bucket.units) / per_second).max(1))
            }
        })
    }

    /// Takes the cost of an answer's or a job's rays.
    pub(crate) fn charge(&self, rays: u64, now: Instant) {
        self.with(now, |bucket, _| bucket.take((rays / RAYS) as f64));
    }

    /// Takes what was spent at another front.
    pub(crate) fn spent_elsewhere(&self, units: f64, now: Instant) {
        self.with(now, |bucket, _| bucket.units -= units.max(0.0));
    }

    /// What was taken here since the last call.
    pub(crate) fn spent_here(&self) -> f64 {
        std::mem::take(&mut self.bucket.lock().unreported)
    }

    /// The state of the bucket.
    pub(crate) fn left(&self, now: Instant) -> Left {
        self.with(now, |bucket, per_second| Left {
            per_minute: self.per_minute,
            units: bucket.units.max(0.0) as u32,
            full_in: whole((f64::from(self.per_minute) - bucket.units) / per_second),
        })
    }

    fn with<T>(&self, now: Instant, act: impl FnOnce(&mut Bucket, f64) -> T) -> T {
        // At worst a panic leaves a unit too many.
        let mut bucket = self.bucket.lock();
        let most = f64::from(self.per_minute);
        let per_second = most / 60.0;
        bucket.units = (bucket.units + now.saturating_duration_since(bucket.at).as_secs_f64() * per_second).min(most);
        bucket.at = now;
        act(&mut bucket, per_second)
    }
}

impl Bucket {
    fn take(&mut self, units: f64) {
        self.units -= units;
        self.unreported += units;
    }
}

/// Seconds, rounded up.
fn whole(seconds: f64) -> u32 {
    seconds.ceil() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_minute_has_its_units_and_debts_are_waited_for() {
        let rate_limit = RateLimit::new(60);
        let start = Instant::now();
        for _ in 0..60 {
            assert_eq!(rate_limit.enter(start), Ok(()));
        }
        assert_eq!(rate_limit.enter(start), Err(1));
        let later = start + Duration::from_secs(2);
        assert_eq!(rate_limit.enter(later), Ok(()));
        rate_limit.charge(30_000_000, later);
        assert_eq!(rate_limit.enter(later), Err(30));
        assert_eq!(rate_limit.left(later), Left { per_minute: 60, units: 0, full_in: 89 });
        let much_later = later + Duration::from_secs(3_600);
        assert_eq!(rate_limit.left(much_later), Left { per_minute: 60, units: 60, full_in: 0 });
    }

    #[test]
    fn what_is_spent_elsewhere_is_spent_and_not_told_again() {
        let [here, there] = [60, 60].map(RateLimit::new);
        let now = Instant::now();
        assert_eq!(here.enter(now), Ok(()));
        here.charge(9_000_000, now);
        let told = here.spent_here();
        there.spent_elsewhere(told, now);
        assert_eq!((told, here.spent_here(), there.spent_here()), (10.0, 0.0, 0.0));
        assert_eq!([&here, &there].map(|limit| limit.left(now).units), [50; 2]);
    }

    #[test]
    fn small_pictures_cost_no_more_than_their_request() {
        let rate_limit = RateLimit::new(10);
        let now = Instant::now();
        rate_limit.charge(999_999, now);
        assert_eq!(rate_limit.left(now).units, 10);
    }
}
