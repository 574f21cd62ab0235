//! Processor time of a thread: what work took, without the time in which it was paused, the system ran something else, or the
//! whole process was stopped. A [`Stopwatch`](crate::control::Stopwatch) would count all but the first.

#[cfg(unix)]
use rustix::time::{ClockId, clock_gettime};

/// Nanoseconds of processor time since a start on the same thread.
pub(super) struct ThreadTime(f64);

impl ThreadTime {
    pub(super) fn start() -> Self {
        Self(now())
    }

    pub(super) fn nanoseconds(&self) -> f64 {
        now() - self.0
    }
}

#[cfg(unix)]
#[inline(never)]
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

/// Other systems have wall time.
#[cfg(not(unix))]
fn now() -> f64 {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64() * 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;
    use std::time::Duration;

    #[test]
    #[cfg(unix)]
    fn time_in_which_a_thread_does_nothing_does_not_count() {
        let time = ThreadTime::start();
        thread::sleep(Duration::from_millis(200));
        assert!(time.nanoseconds() < 1e8, "{}", time.nanoseconds());
        let mut work = 1u64;
        while time.nanoseconds() < 2e6 {
            work = std::hint::black_box(work.wrapping_mul(3));
        }
    }
}
