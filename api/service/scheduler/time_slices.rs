//! One task has the pool at a time, for a time slice. If others wait then, it is paused wherever it is, and goes on later.
//!
//! A task that does not notice that it is paused keeps its threads busy, but not the pool: the next one has threads of its
//! own, and the system shares the processors among them. So no task holds up others for long.

use super::fair_queue::{FairQueue, Waiting};
use super::task::{Class, Task};
use parking_lot::{Condvar, Mutex, MutexGuard};
use std::fmt;
use std::io;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant};
use strahl::render::{Cancelled, Control};
use tokio::sync::oneshot;

/// How long a task has the pool while others wait.
const SLICE: Duration = Duration::from_millis(25);
/// A picture in a time is not paused so shortly before it ends, since it may not go on in time.
const LAST: Duration = Duration::from_millis(200);
/// Pause between two looks at the flag that cancels, for those who wait on a thread.
const BETWEEN_LOOKS: Duration = Duration::from_millis(10);
/// A task that has not noticed for so long that it was paused or cancelled does not stop any more.
const STALLED: Duration = Duration::from_secs(10);

/// The scheduler. It ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Scheduler(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// The owner, the queue or the end has changed.
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    owner: Option<Owner>,
    queue: FairQueue<Candidate>,
    over: bool,
}

/// The task that has the pool.
#[derive(Debug)]
struct Owner {
    id: u64,
    task: Task,
    candidate: Candidate,
    began: Instant,
}

/// What a task waits with.
struct Candidate {
    control: Control,
    /// When it ends by itself.
    ends: Option<Instant>,
    /// Starts it; none if it was paused.
    start: Option<Start>,
}

/// Hands the slices to the task that waits for them.
type Start = Box<dyn FnOnce(Slices) + Send>;

/// A task that may want the pool; it has left when this is dropped.
#[derive(Debug)]
pub(crate) struct Scheduled {
    shared: Arc<Shared>,
    id: u64,
    task: Task,
    control: Control,
}

/// The right to work on the pool, in as many slices as it takes, until this is dropped.
#[derive(Debug)]
pub(crate) struct Slices {
    shared: Arc<Shared>,
    id: u64,
}

impl fmt::Debug for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Candidate").field("ends", &self.ends).finish_non_exhaustive()
    }
}

impl Scheduler {
    /// Starts the thread that ends time slices.
    pub(crate) fn start() -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let watched = Arc::clone(&shared);
        thread::Builder::new().name("scheduler".into()).spawn(move || watched.end_slices())?;
        Ok(Self(shared))
    }

    /// A task joins, at the end of those of equal rank.
    pub(crate) fn join(&self, task: Task, control: Control) -> Scheduled {
        let id = self.0.state.lock().queue.join(&task);
        Scheduled { shared: Arc::clone(&self.0), id, task, control }
    }

    /// Whether a task has the pool.
    pub(crate) fn is_taken(&self) -> bool {
        self.0.state.lock().owner.is_some()
    }

    /// Whether a task does not stop although it was paused or cancelled.
    pub(crate) fn is_stalled(&self) -> bool {
        let state = self.0.state.lock();
        let candidates = state.queue.iter().chain(state.owner.iter().map(|owner| &owner.candidate));
        candidates.filter(|candidate| candidate.start.is_none()).any(|paused| paused.control.unnoticed() > STALLED)
    }

    /// Seconds that a lane has had the pool.
    pub(crate) fn spent(&self, class: Class) -> f64 {
        self.0.state.lock().queue.spent(class)
    }
}

impl Drop for Scheduler {
    fn drop(&mut self) {
        self.0.state.lock().over = true;
        self.0.changed.notify_all();
    }
}

impl Shared {
    /// Ends slices that are over, as long as there is a scheduler.
    fn end_slices(self: &Arc<Self>) {
        let mut state = self.state.lock();
        while !state.over {
            let now = Instant::now();
            match state.slice_end() {
                Some(end) if end <= now => {
                    let start = state.preempt(now);
                    MutexGuard::unlocked(&mut state, || self.start(start));
                }
                Some(end) => drop(self.changed.wait_until(&mut state, end)),
                None => self.changed.wait(&mut state),
            }
        }
    }

    /// Gives the pool to the next task, if it is free and somebody wants it.
    fn hand_over(self: &Arc<Self>, mut state: MutexGuard<'_, State>) {
        let start = state.serve();
        drop(state);
        self.changed.notify_all();
        self.start(start);
    }

    /// Starts a task. The lock is free: if the other side has gone, the slices are dropped here, which takes it.
    fn start(self: &Arc<Self>, task: Option<(u64, Start)>) {
        if let Some((id, start)) = task {
            start(Slices { shared: Arc::clone(self), id });
        }
    }
}

impl State {
    /// When the owner's slice ends, if anybody else wants the pool.
    fn slice_end(&self) -> Option<Instant> {
        let owner = self.owner.as_ref().filter(|_| !self.queue.is_empty())?;
        let end = owner.began + SLICE;
        // Once it should have ended, it is paused like any other.
        Some(owner.candidate.ends.filter(|ends| (end..end + LAST).contains(ends)).unwrap_or(end))
    }

    /// Lets the owner wait like all others, and go on if it is next.
    fn preempt(&mut self, now: Instant) -> Option<(u64, Start)> {
        let Owner { id, task, candidate, began } = self.owner.take()?;
        self.queue.charge(id, &task, now - began);
        let control = candidate.control.clone();
        self.queue.push(id, task, candidate);
        let start = self.serve();
        if self.owner.as_ref().is_none_or(|owner| owner.id != id) {
            control.pause();
        }
        start
    }

    /// Makes the next task the owner. It goes on, or is yet to be started.
    fn serve(&mut self) -> Option<(u64, Start)> {
        if self.owner.is_some() {
            return None;
        }
        let Waiting { id, task, with: mut candidate, .. } = self.queue.pop()?;
        candidate.control.resume();
        let start = candidate.start.take();
        self.owner = Some(Owner { id, task, candidate, began: Instant::now() });
        start.map(|start| (id, start))
    }
}

impl Scheduled {
    /// For how long it has had the pool, in slices that are over.
    pub(crate) fn had(&self) -> Duration {
        self.shared.state.lock().queue.had(self.id)
    }

    /// Waits for the pool without a thread. Who stops waiting has left the queue at once.
    pub(crate) async fn wait(&self) -> Result<Slices, Cancelled> {
        let (sender, receiver) = oneshot::channel();
        let _place = self.queue(None, move |slices| drop(sender.send(slices)));
        receiver.await.map_err(|_| Cancelled)
    }

    /// Waits for the pool on this thread. `ends`: when the work ends by itself.
    pub(crate) fn wait_here(&self, ends: Option<Instant>) -> Result<Slices, Cancelled> {
        let (sender, receiver) = mpsc::channel();
        let _place = self.queue(ends, move |slices| drop(sender.send(slices)));
        loop {
            if self.control.is_cancelled() {
                return Err(Cancelled);
            }
            match receiver.recv_timeout(BETWEEN_LOOKS) {
                Ok(slices) => return Ok(slices),
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return Err(Cancelled),
            }
        }
    }

    fn queue(&self, ends: Option<Instant>, start: impl FnOnce(Slices) + Send + 'static) -> Place<'_> {
        let mut state = self.shared.state.lock();
        let candidate = Candidate { control: self.control.clone(), ends, start: Some(Box::new(start)) };
        state.queue.push(self.id, self.task.clone(), candidate);
        self.shared.hand_over(state);
        Place(self)
    }
}

impl Drop for Scheduled {
    fn drop(&mut self) {
        self.shared.state.lock().queue.leave(self.id, &self.task);
    }
}

impl Slices {
    /// When the work ends by itself.
    pub(crate) fn end_at(&self, ends: Instant) {
        let mut state = self.shared.state.lock();
        if let Some(owner) = state.owner.as_mut().filter(|owner| owner.id == self.id) {
            owner.candidate.ends = Some(ends);
        }
    }
}

impl Drop for Slices {
    fn drop(&mut self) {
        let mut state = self.shared.state.lock();
        if let Some(Owner { id, task, began, .. }) = state.owner.take_if(|owner| owner.id == self.id) {
            state.queue.charge(id, &task, began.elapsed());
        } else if let Some(paused) = state.queue.remove(self.id, |_| true) {
            // It has ended before it noticed.
            paused.control.resume();
        }
        self.shared.hand_over(state);
    }
}

/// A place in the queue of a task that has not been started, left when dropped.
#[derive(Debug)]
struct Place<'a>(&'a Scheduled);

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.0.shared.state.lock().queue.remove(self.0.id, |candidate| candidate.start.is_some());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn join(scheduler: &Scheduler, class: Class, tenant: &str) -> Scheduled {
        scheduler.join(Task::new(class, tenant, 1), Control::default())
    }

    #[test]
    fn a_task_is_paused_when_its_slice_is_over_and_goes_on_after_the_others() {
        let scheduler = Scheduler::start().unwrap();
        let (long, short) = (join(&scheduler, Class::Renders, "a"), join(&scheduler, Class::Renders, "b"));
        let slices = long.wait_here(None).unwrap();
        thread::sleep(2 * SLICE);
        // Nobody waits.
        assert_eq!(long.control.unnoticed(), Duration::ZERO);
        // One of these slices is not over before one looks.
        let is_paused = |_| {
            let _others = short.wait_here(None).unwrap();
            long.control.unnoticed() > Duration::ZERO
        };
        assert!((0..10).any(is_paused));
        assert_eq!(long.control.unnoticed(), Duration::ZERO);
        assert!(scheduler.is_taken());
        drop(slices);
        assert!(!scheduler.is_taken());
    }

    #[test]
    fn a_paused_task_that_ends_without_noticing_leaves_the_queue() {
        let scheduler = Scheduler::start().unwrap();
        let (first, second) = (join(&scheduler, Class::Jobs, "a"), join(&scheduler, Class::Jobs, "b"));
        let slices = first.wait_here(None).unwrap();
        let others = second.wait_here(None).unwrap();
        drop(slices);
        assert!(scheduler.0.state.lock().queue.is_empty() && scheduler.is_taken());
        drop(others);
        assert!(!scheduler.is_taken() && first.wait_here(None).is_ok());
    }

    #[test]
    fn a_picture_in_a_time_is_not_paused_shortly_before_its_end() {
        let scheduler = Scheduler::start().unwrap();
        let (timed, other) = (join(&scheduler, Class::Renders, "a"), join(&scheduler, Class::Renders, "b"));
        let end = Instant::now() + LAST / 2;
        let _slices = timed.wait_here(Some(end)).unwrap();
        let _others = other.wait_here(None).unwrap();
        assert!(Instant::now() >= end);
    }

    #[test]
    fn who_is_cancelled_waits_no_more() {
        let scheduler = Scheduler::start().unwrap();
        let [first, second, third] = [(); 3].map(|()| join(&scheduler, Class::Jobs, "a"));
        let held = first.wait_here(None).unwrap();
        second.control.cancel();
        assert!(second.wait_here(None).is_err());
        assert!(scheduler.0.state.lock().queue.is_empty());
        drop(held);
        assert!(third.wait_here(None).is_ok());
    }

    #[tokio::test]
    async fn a_future_that_is_dropped_leaves_the_queue_and_loses_no_slice() {
        let scheduler = Scheduler::start().unwrap();
        // Jobs of one tenant go one after the other.
        let [first, second, third] = [(); 3].map(|()| join(&scheduler, Class::Jobs, "a"));
        let held = first.wait().await.unwrap();
        let waiting = tokio::time::timeout(Duration::from_millis(20), second.wait()).await;
        assert!(waiting.is_err() && scheduler.0.state.lock().queue.is_empty());
        drop(held);
        assert!(third.wait().await.is_ok());
    }
}
