//! Pausing, cancelling and watching work from outside.
//!
//! A working thread *enters* a [`Control`]. Loops that may run long count their steps with `step`, and after a number of steps
//! the thread checks the controls that it has entered: it waits while one is paused, and stops if one is cancelled. So a render
//! can be paused and resumed anywhere, also inside the traversal of a hierarchy.

use parking_lot::{Condvar, Mutex};
use std::cell::{Cell, RefCell};
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Steps between two looks. A step takes at most some microseconds, so a thread looks every few milliseconds at least.
const STEPS: i32 = 1_024;

thread_local! {
    /// Controls that this thread has entered.
    static ENTERED: RefCell<Vec<Control>> = const { RefCell::new(Vec::new()) };
    /// Steps until the next look; below 0 once the thread is to stop.
    static LEFT: Cell<i32> = const { Cell::new(STEPS) };
}

/// The work was cancelled before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

/// Shared between work and the code that pauses, cancels or watches it. Clones are the same control.
#[derive(Debug, Clone, Default)]
pub struct Control(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    cancelled: AtomicBool,
    deadline: Option<Instant>,
    /// Whether there is anything to look at behind the lock.
    interrupted: AtomicBool,
    pause: Mutex<Pause>,
    changed: Condvar,
    done: AtomicU64,
    total: AtomicU64,
    rays: AtomicU64,
}

#[derive(Debug, Default)]
struct Pause {
    /// When the current pause began.
    since: Option<Instant>,
    /// How long all pauses before it were.
    before: Duration,
    /// When the work was paused or cancelled, until a thread has noticed.
    unnoticed: Option<Instant>,
}

impl Pause {
    fn total(&self) -> Duration {
        self.before + self.since.map_or(Duration::ZERO, |since| since.elapsed())
    }
}

impl Control {
    /// A control that is cancelled at an instant.
    pub fn until(deadline: Instant) -> Self {
        Self(Arc::new(Shared { deadline: Some(deadline), ..Shared::default() }))
    }

    /// Stops the work, within milliseconds, paused or not.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
        self.0.pause.lock().unnoticed = Some(Instant::now());
        self.0.interrupted.store(true, Ordering::Relaxed);
        self.0.changed.notify_all();
    }

    /// Whether the work is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed) || self.0.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Lets the threads of the work wait, as soon as they look.
    pub fn pause(&self) {
        let mut pause = self.0.pause.lock();
        let now = Instant::now();
        pause.since.get_or_insert(now);
        pause.unnoticed = Some(now);
        self.0.interrupted.store(true, Ordering::Relaxed);
    }

    /// Lets them go on.
    pub fn resume(&self) {
        let mut pause = self.0.pause.lock();
        if let Some(since) = pause.since.take() {
            pause.before += since.elapsed();
            pause.unnoticed = None;
            self.0.interrupted.store(self.0.cancelled.load(Ordering::Relaxed), Ordering::Relaxed);
            self.0.changed.notify_all();
        }
    }

    /// How long no thread has noticed that the work was paused or cancelled.
    pub fn unnoticed(&self) -> Duration {
        self.0.pause.lock().unnoticed.map_or(Duration::ZERO, |since| since.elapsed())
    }

    /// Makes this thread look at the control until the guard is dropped. Work of others must not run on the thread
    /// meanwhile, as it may while a rayon pool of several users waits.
    #[must_use]
    pub fn enter(&self) -> Entered {
        ENTERED.with_borrow_mut(|entered| entered.push(self.clone()));
        Entered(PhantomData)
    }

    /// Makes this thread look at the control, and at no other, until [`leave_all`].
    pub fn enter_for_good(&self) {
        leave_all();
        ENTERED.with_borrow_mut(|entered| entered.push(self.clone()));
    }

    /// Pixels finished so far. With antialiasing pixels that get more samples count again.
    pub fn done(&self) -> u64 {
        self.0.done.load(Ordering::Relaxed)
    }

    /// Pixels to do, as far as known.
    pub fn total(&self) -> u64 {
        self.0.total.load(Ordering::Relaxed)
    }

    /// Rays traced so far, also of work that was cancelled.
    pub fn rays(&self) -> u64 {
        self.0.rays.load(Ordering::Relaxed)
    }

    pub(crate) fn add_done(&self, pixels: u64) {
        self.0.done.fetch_add(pixels, Ordering::Relaxed);
    }

    pub(crate) fn add_total(&self, pixels: u64) {
        self.0.total.fetch_add(pixels, Ordering::Relaxed);
    }

    /// Sets both, for work that is not counted in pixels.
    pub fn set_progress(&self, done: u64, total: u64) {
        self.0.done.store(done, Ordering::Relaxed);
        self.0.total.store(total, Ordering::Relaxed);
    }

    /// Adds to the rays traced so far, where a part of the work has a control of its own.
    pub fn add_rays(&self, rays: u64) {
        self.0.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// Whether what this thread has made is useless, since this control or one that it has entered is cancelled.
    pub(crate) fn stops(&self) -> bool {
        self.is_cancelled() || is_cancelled()
    }

    /// Waits while paused; whether the work is to stop.
    fn look(&self) -> bool {
        if self.0.interrupted.load(Ordering::Relaxed) {
            let mut pause = self.0.pause.lock();
            pause.unnoticed = None;
            while pause.since.is_some() && !self.is_cancelled() {
                self.0.changed.wait(&mut pause);
            }
        }
        self.is_cancelled()
    }
}

/// While it lives, its thread looks at a control.
#[derive(Debug)]
pub struct Entered(PhantomData<*const ()>);

impl Drop for Entered {
    fn drop(&mut self) {
        ENTERED.with_borrow_mut(Vec::pop);
        LEFT.set(STEPS);
    }
}

/// Makes this thread look at no control any more.
pub fn leave_all() {
    ENTERED.with_borrow_mut(Vec::clear);
    LEFT.set(STEPS);
}

/// Counts steps of some microseconds at most, fewer than 2^30; waits where the work is paused. True once it is to stop.
#[inline(always)]
pub(crate) fn step(steps: u32) -> bool {
    // Written before it is compared, which makes one instruction of both.
    let left = LEFT.get() - steps as i32;
    LEFT.set(left);
    left < 0 && look()
}

/// Waits where the work of this thread is paused. True once it is to stop.
#[cold]
#[inline(never)]
fn look() -> bool {
    let stops = ENTERED.with_borrow(|entered| entered.iter().any(Control::look));
    LEFT.set(if stops { -1 } else { STEPS });
    stops
}

/// Looks at once, before work of milliseconds: waits where the work of this thread is paused, and fails once it is cancelled.
pub fn look_now() -> Result<(), Cancelled> {
    if look() { Err(Cancelled) } else { Ok(()) }
}

/// Whether [`step`] has said that the work of this thread is to stop.
#[inline(always)]
pub(crate) fn is_stopping() -> bool {
    LEFT.get() < 0
}

/// Counts steps of some microseconds at most; waits where the work of this thread is paused, and fails once it is cancelled.
#[inline]
pub fn checkpoint(steps: u32) -> Result<(), Cancelled> {
    if step(steps) { Err(Cancelled) } else { Ok(()) }
}

/// Whether the work of this thread is to stop.
fn is_cancelled() -> bool {
    is_stopping() || ENTERED.with_borrow(|entered| entered.iter().any(Control::is_cancelled))
}

/// Milliseconds that have passed, pauses included.
pub fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Measures working time of one thread: what its controls were paused is left out.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    started: Instant,
    paused: Duration,
}

impl Stopwatch {
    /// Begins.
    pub fn start() -> Self {
        Self { started: Instant::now(), paused: paused() }
    }

    /// Time worked since the start.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed().saturating_sub(paused().saturating_sub(self.paused))
    }

    /// The same in milliseconds.
    pub fn milliseconds(&self) -> f64 {
        self.elapsed().as_secs_f64() * 1e3
    }
}

fn paused() -> Duration {
    ENTERED.with_borrow(|entered| entered.iter().map(|control| control.0.pause.lock().total()).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    /// Steps until told to stop; how many there were.
    fn work() -> u64 {
        let mut steps = 0;
        while !step(1) {
            steps += 1;
        }
        steps
    }

    #[test]
    fn cancelled_work_stops_also_while_it_is_paused() {
        let control = Control::default();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let _entered = control.enter();
                work();
                assert!(is_cancelled() && checkpoint(1).is_err());
            });
            control.pause();
            thread::sleep(Duration::from_millis(20));
            assert!(!worker.is_finished());
            control.cancel();
        });
        // A thread that has left looks no more.
        assert!(!is_cancelled());
    }

    #[test]
    fn a_pause_does_not_count_as_work() {
        let control = Control::default();
        let _entered = control.enter();
        let (stopwatch, wall) = (Stopwatch::start(), Instant::now());
        control.pause();
        thread::scope(|scope| {
            scope.spawn(|| {
                thread::sleep(Duration::from_millis(50));
                control.resume();
            });
            for _ in 0..=STEPS {
                assert!(!step(1));
            }
        });
        let paused = wall.elapsed().saturating_sub(stopwatch.elapsed());
        assert!(paused >= Duration::from_millis(50), "{paused:?}");
        assert_eq!(control.unnoticed(), Duration::ZERO);
    }

    #[test]
    fn a_deadline_stops_work() {
        let control = Control::until(Instant::now() + Duration::from_millis(500));
        let _entered = control.enter();
        assert!(!control.is_cancelled());
        assert!(work() > 0);
        assert!(control.is_cancelled());
    }

    #[test]
    fn nobody_has_noticed_until_a_thread_looks() {
        let control = Control::default();
        control.cancel();
        thread::sleep(Duration::from_millis(2));
        assert!(control.unnoticed() >= Duration::from_millis(2));
        let _entered = control.enter();
        work();
        assert_eq!(control.unnoticed(), Duration::ZERO);
    }
}
