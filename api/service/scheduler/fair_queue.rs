//! Whose turn it is on the pool: one piece of work has it at a time, and this is the order.
//!
//! Three lanes have equal shares of the time: tiles that somebody looks at, renders that somebody waits for, and jobs. So
//! what is interactive has at least half of it when both want it, and all of it when no job does. Within a lane tenants
//! share by weight, within a tenant the higher priority goes first, which for jobs grows with the time since they were accepted.
//! Two renders of a tenant go around, so that a short one ends before a long one that came first; others wait until one of
//! them has ended, since each that has begun takes memory. Jobs go one after the other.

use super::shares::Shares;
use super::task::{Class, Task, aged};
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};
use strahl::render::Cancelled;
use tokio::sync::oneshot;

/// Pause between two looks at the flag that cancels, for those who wait on a thread.
const BETWEEN_LOOKS: Duration = Duration::from_millis(10);

/// The order, and the line of those who wait.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scheduler(Arc<Mutex<State>>);

/// Somebody who may want turns; it has left when this is dropped.
#[derive(Debug)]
pub(crate) struct Scheduled {
    scheduler: Scheduler,
    task: Task,
    number: u64,
    /// Whether it has had a turn.
    begun: Arc<AtomicBool>,
}

/// Renders of a tenant that go around.
const AROUND: usize = 2;

/// The pool is its owner's until this is dropped.
#[derive(Debug)]
pub(crate) struct Slice {
    scheduler: Scheduler,
    class: Class,
    tenant: Arc<str>,
    weight: u32,
    began: Instant,
}

#[derive(Debug, Default)]
struct State {
    taken: bool,
    waiting: Vec<Waiter>,
    /// Numbers of members and waiters.
    count: u64,
    shares: Shares,
}

struct Waiter {
    id: u64,
    task: Task,
    number: u64,
    begun: Arc<AtomicBool>,
    /// Hands the turn over. If nobody takes it any more, it is dropped, and the next one has it.
    wake: Box<dyn FnOnce(Slice) + Send>,
}

impl fmt::Debug for Waiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Waiter").field("id", &self.id).field("task", &self.task).finish_non_exhaustive()
    }
}

impl Scheduler {
    /// Somebody joins, at the end of those of equal rank.
    pub(crate) fn join(&self, task: Task) -> Scheduled {
        let mut state = self.state();
        state.shares.join(&task);
        let number = state.number();
        Scheduled { scheduler: self.clone(), task, number, begun: Arc::default() }
    }

    /// Whether somebody has the turn.
    pub(crate) fn is_taken(&self) -> bool {
        self.state().taken
    }

    /// Seconds that the turns of a lane have taken.
    pub(crate) fn spent(&self, class: Class) -> f64 {
        self.state().shares.spent(class)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic between two lines of this file leaves at worst unfair shares.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives the turn to the next one, if nobody has it and somebody wants it.
    fn hand_over(&self, mut state: MutexGuard<'_, State>) {
        if state.taken {
            return;
        }
        let Some(next) = state.next() else { return };
        let Waiter { task: Task { class, tenant, weight, .. }, wake, begun, .. } = state.waiting.swap_remove(next);
        if !begun.swap(true, Ordering::Relaxed) {
            state.shares.begin(class, &tenant);
        }
        state.taken = true;
        drop(state);
        // Without the lock: if the other side has gone, the turn is dropped here, which takes it.
        wake(Slice { scheduler: self.clone(), class, tenant, weight, began: Instant::now() });
    }
}

impl State {
    fn number(&mut self) -> u64 {
        self.count += 1;
        self.count
    }

    /// Which waiter is next.
    fn next(&mut self) -> Option<usize> {
        let (class, tenant) = self.shares.serve(self.waiting.iter().map(|waiter| &waiter.task))?;
        let theirs = |(_, Waiter { task, .. }): &(usize, &Waiter)| task.class == class && task.tenant == tenant;
        let theirs = self.waiting.iter().enumerate().filter(theirs);
        let begun = |(_, waiter): &(usize, &Waiter)| waiter.begun.load(Ordering::Relaxed);
        // If all that have begun are busy elsewhere, the pool is not kept waiting for them.
        let full =
            class == Class::Renders && self.shares.begun(class, &tenant) >= AROUND && theirs.clone().any(|w| begun(&w));
        theirs.filter(|waiter| !full || begun(waiter)).max_by(|(_, a), (_, b)| a.rank(b)).map(|(next, _)| next)
    }
}

impl Waiter {
    /// Since when it stands in line, which it does anew after each turn.
    fn place(&self) -> u64 {
        if self.begun.load(Ordering::Relaxed) { self.id } else { self.number }
    }

    /// Greater goes first; both are of the same tenant and lane.
    fn rank(&self, other: &Self) -> std::cmp::Ordering {
        let aged = |waiter: &Self| aged(waiter.task.priority(), waiter.task.waiting_since);
        let by_age = match self.task.class {
            Class::Tiles => self.number.cmp(&other.number),
            Class::Renders => other.place().cmp(&self.place()),
            Class::Jobs => other.number.cmp(&self.number),
        };
        match self.task.class {
            Class::Jobs => aged(self).total_cmp(&aged(other)).then(by_age),
            Class::Tiles | Class::Renders => self.task.priority().cmp(&other.task.priority()).then(by_age),
        }
    }
}

impl Scheduled {
    /// Waits without a thread. Who stops waiting is out of the line at once.
    pub(crate) async fn turn(&self) -> Result<Slice, Cancelled> {
        let (sender, receiver) = oneshot::channel();
        let _place = self.line_up(None, move |turn| drop(sender.send(turn)));
        receiver.await.map_err(|_| Cancelled)
    }

    /// Waits on this thread.
    pub(crate) fn turn_or(&self, cancelled: &AtomicBool) -> Result<Slice, Cancelled> {
        self.wait(None, cancelled)
    }

    /// Gives a turn back and asks for the next, so that whoever is first in line has it: perhaps the same member.
    pub(crate) fn pass(&self, turn: Slice, cancelled: &AtomicBool) -> Result<Slice, Cancelled> {
        self.wait(Some(turn), cancelled)
    }

    fn wait(&self, before: Option<Slice>, cancelled: &AtomicBool) -> Result<Slice, Cancelled> {
        let (sender, receiver) = mpsc::channel();
        let _place = self.line_up(before, move |turn| drop(sender.send(turn)));
        loop {
            if cancelled.load(Ordering::Relaxed) {
                return Err(Cancelled);
            }
            match receiver.recv_timeout(BETWEEN_LOOKS) {
                Ok(turn) => return Ok(turn),
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return Err(Cancelled),
            }
        }
    }

    fn line_up(&self, before: Option<Slice>, wake: impl FnOnce(Slice) + Send + 'static) -> InLine {
        let mut state = self.scheduler.state();
        let id = state.number();
        let (task, number, begun) = (self.task.clone(), self.number, Arc::clone(&self.begun));
        state.waiting.push(Waiter { id, task, number, begun, wake: Box::new(wake) });
        // Its end must come after its owner stands in line again, or the next one would be chosen without it.
        drop(state);
        drop(before);
        self.scheduler.hand_over(self.scheduler.state());
        InLine { scheduler: self.scheduler.clone(), id }
    }
}

impl Drop for Scheduled {
    fn drop(&mut self) {
        let mut state = self.scheduler.state();
        state.shares.leave(&self.task, self.begun.load(Ordering::Relaxed));
    }
}

impl Drop for Slice {
    fn drop(&mut self) {
        let scheduler = self.scheduler.clone();
        let mut state = scheduler.state();
        state.taken = false;
        state.shares.charge(self.class, &self.tenant, self.weight, self.began.elapsed());
        scheduler.hand_over(state);
    }
}

/// A place in the line, left when dropped.
#[derive(Debug)]
struct InLine {
    scheduler: Scheduler,
    id: u64,
}

impl Drop for InLine {
    fn drop(&mut self) {
        self.scheduler.state().waiting.retain(|waiter| waiter.id != self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU8;
    use std::thread;

    static GOING_ON: AtomicBool = AtomicBool::new(false);

    fn task(class: Class, tenant: &str) -> Task {
        Task::new(class, tenant, 1)
    }

    /// Lets all take turns of a millisecond while one thread holds the first, and says who had which.
    fn order(scheduler: &Scheduler, members: Vec<(Scheduled, &'static str)>, each: usize) -> Vec<&'static str> {
        let served = Mutex::new(Vec::new());
        let first = scheduler.join(task(Class::Renders, "first"));
        let held = first.turn_or(&GOING_ON).unwrap();
        thread::scope(|scope| {
            let count = members.len();
            for (scheduled, name) in members {
                let served = &served;
                scope.spawn(move || {
                    let mut turn = scheduled.turn_or(&GOING_ON).unwrap();
                    for round in 1..=each {
                        served.lock().unwrap().push(name);
                        thread::sleep(Duration::from_millis(1));
                        if round < each {
                            turn = scheduled.pass(turn, &GOING_ON).unwrap();
                        }
                    }
                });
            }
            while scheduler.state().waiting.len() < count {
                thread::yield_now();
            }
            drop(held);
        });
        served.into_inner().unwrap()
    }

    #[test]
    fn one_tenants_many_jobs_delay_anothers_by_a_round() {
        let scheduler = Scheduler::default();
        let mut members: Vec<_> = (0..50).map(|_| (scheduler.join(task(Class::Jobs, "many")), "many")).collect();
        members.push((scheduler.join(task(Class::Jobs, "one")), "one"));
        let served = order(&scheduler, members, 1);
        assert!(served.iter().position(|name| *name == "one") <= Some(1), "{served:?}");
    }

    #[test]
    fn interactive_work_has_half_of_the_turns_and_jobs_the_rest() {
        let scheduler = Scheduler::default();
        let members = vec![
            (scheduler.join(task(Class::Jobs, "a")), "job"),
            (scheduler.join(task(Class::Jobs, "b")), "job"),
            (scheduler.join(task(Class::Renders, "a")), "render"),
        ];
        let served = order(&scheduler, members, 40);
        let renders = served[..60].iter().filter(|name| **name == "render").count();
        assert!((25..=35).contains(&renders), "{renders} of 60: {served:?}");
    }

    #[test]
    fn weights_share_out_a_lane() {
        let scheduler = Scheduler::default();
        let heavy = Task { weight: 3, ..task(Class::Jobs, "heavy") };
        let members = vec![(scheduler.join(heavy), "heavy"), (scheduler.join(task(Class::Jobs, "light")), "light")];
        let served = order(&scheduler, members, 40);
        let heavy = served[..40].iter().filter(|name| **name == "heavy").count();
        assert!((26..=34).contains(&heavy), "{heavy} of 40: {served:?}");
    }

    #[test]
    fn priorities_come_before_age_and_tiles_are_newest_first() {
        let scheduler = Scheduler::default();
        let important = Task { priority: Arc::new(AtomicU8::new(90)), ..task(Class::Jobs, "a") };
        let members = vec![
            (scheduler.join(task(Class::Jobs, "a")), "first"),
            (scheduler.join(task(Class::Jobs, "a")), "second"),
            (scheduler.join(important), "important"),
        ];
        assert_eq!(order(&scheduler, members, 2), ["important", "important", "first", "first", "second", "second"]);
        let render = |name| (scheduler.join(task(Class::Renders, "a")), name);
        let members = vec![render("first"), render("second"), render("third")];
        assert_eq!(order(&scheduler, members, 2), ["first", "second", "first", "second", "third", "third"]);
        let tile = |name| (scheduler.join(task(Class::Tiles, "a")), name);
        assert_eq!(order(&scheduler, vec![tile("old"), tile("middle"), tile("new")], 1), ["new", "middle", "old"]);
    }

    #[test]
    fn who_has_been_away_has_saved_nothing() {
        let scheduler = Scheduler::default();
        let busy = scheduler.join(task(Class::Jobs, "busy"));
        let mut turn = busy.turn_or(&GOING_ON).unwrap();
        for _ in 0..20 {
            thread::sleep(Duration::from_millis(1));
            turn = busy.pass(turn, &GOING_ON).unwrap();
        }
        drop(turn);
        let members = vec![(busy, "busy"), (scheduler.join(task(Class::Jobs, "new")), "new")];
        let served = order(&scheduler, members, 20);
        let new = served[..20].iter().filter(|name| **name == "new").count();
        assert!((8..=12).contains(&new), "{new} of 20: {served:?}");
    }

    #[test]
    fn who_stops_waiting_is_passed_over() {
        let scheduler = Scheduler::default();
        let [first, second, third] = [(); 3].map(|()| scheduler.join(task(Class::Jobs, "a")));
        let held = first.turn_or(&GOING_ON).unwrap();
        let given_up = AtomicBool::new(true);
        assert!(second.turn_or(&given_up).is_err());
        assert!(scheduler.state().waiting.is_empty());
        drop(held);
        assert!(third.turn_or(&GOING_ON).is_ok());
    }

    #[tokio::test]
    async fn a_future_that_is_dropped_leaves_the_line_and_loses_no_turn() {
        let scheduler = Scheduler::default();
        let [first, second, third] = [(); 3].map(|()| scheduler.join(task(Class::Renders, "a")));
        let held = first.turn().await.unwrap();
        let waiting = tokio::time::timeout(Duration::from_millis(20), second.turn()).await;
        assert!(waiting.is_err() && scheduler.state().waiting.is_empty());
        drop(held);
        assert!(third.turn().await.is_ok());
    }
}
