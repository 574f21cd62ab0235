//! Who renders when: a bounded queue before the pool, a weighted-fair order of those who wait, and time slices.

pub(crate) mod admission;
pub(crate) mod fair_queue;
pub(crate) mod pool;
pub(crate) mod shares;
pub(crate) mod task;
pub(crate) mod time_slices;
