//! Whose turn it is on the pool: one piece of work has it at a time, and this is the order.
//!
//! Three lanes have equal shares of the time: tiles that somebody looks at, renders that somebody waits for, and jobs. So
//! what is interactive has at least half of it when both want it, and all of it when no job does. Within a lane tenants
//! share by weight, within a tenant the higher priority goes first, which for jobs grows with the time since they were accepted.
//! Two renders of a tenant go around, so that a short one ends before a long one that came first; others wait until one of
//! them has ended, since each that has begun takes memory. Jobs go one after the other.

use super::shares::Shares;
use super::task::{Lane, Seat, aged};
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
pub(crate) struct Turns(Arc<Mutex<State>>);

/// Somebody who may want turns; it has left when this is dropped.
#[derive(Debug)]
pub(crate) struct Member {
    turns: Turns,
    seat: Seat,
    number: u64,
    /// Whether it has had a turn.
    begun: Arc<AtomicBool>,
}

/// Renders of a tenant that go around.
const AROUND: usize = 2;

/// The pool is its owner's until this is dropped.
#[derive(Debug)]
pub(crate) struct Turn {
    turns: Turns,
    lane: Lane,
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
    seat: Seat,
    number: u64,
    begun: Arc<AtomicBool>,
    /// Hands the turn over. If nobody takes it any more, it is dropped, and the next one has it.
    wake: Box<dyn FnOnce(Turn) + Send>,
}

impl fmt::Debug for Waiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Waiter").field("id", &self.id).field("seat", &self.seat).finish_non_exhaustive()
    }
}

impl Turns {
    /// Somebody joins, at the end of those of equal rank.
    pub(crate) fn join(&self, seat: Seat) -> Member {
        let mut state = self.state();
        state.shares.join(&seat);
        let number = state.number();
        Member { turns: self.clone(), seat, number, begun: Arc::default() }
    }

    /// Whether somebody has the turn.
    pub(crate) fn is_taken(&self) -> bool {
        self.state().taken
    }

    /// Seconds that the turns of a lane have taken.
    pub(crate) fn spent(&self, lane: Lane) -> f64 {
        self.state().shares.spent(lane)
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
        let Waiter { seat: Seat { lane, tenant, weight, .. }, wake, begun, .. } = state.waiting.swap_remove(next);
        if !begun.swap(true, Ordering::Relaxed) {
            state.shares.begin(lane, &tenant);
        }
        state.taken = true;
        drop(state);
        // Without the lock: if the other side has gone, the turn is dropped here, which takes it.
        wake(Turn { turns: self.clone(), lane, tenant, weight, began: Instant::now() });
    }
}

impl State {
    fn number(&mut self) -> u64 {
        self.count += 1;
        self.count
    }

    /// Which waiter is next.
    fn next(&mut self) -> Option<usize> {
        let (lane, tenant) = self.shares.serve(self.waiting.iter().map(|waiter| &waiter.seat))?;
        let theirs = |(_, Waiter { seat, .. }): &(usize, &Waiter)| seat.lane == lane && seat.tenant == tenant;
        let theirs = self.waiting.iter().enumerate().filter(theirs);
        let begun = |(_, waiter): &(usize, &Waiter)| waiter.begun.load(Ordering::Relaxed);
        // If all that have begun are busy elsewhere, the pool is not kept waiting for them.
        let full =
            lane == Lane::Renders && self.shares.begun(lane, &tenant) >= AROUND && theirs.clone().any(|w| begun(&w));
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
        let aged = |waiter: &Self| aged(waiter.seat.priority(), waiter.seat.waiting_since);
        let by_age = match self.seat.lane {
            Lane::Tiles => self.number.cmp(&other.number),
            Lane::Renders => other.place().cmp(&self.place()),
            Lane::Jobs => other.number.cmp(&self.number),
        };
        match self.seat.lane {
            Lane::Jobs => aged(self).total_cmp(&aged(other)).then(by_age),
            Lane::Tiles | Lane::Renders => self.seat.priority().cmp(&other.seat.priority()).then(by_age),
        }
    }
}

impl Member {
    /// Waits without a thread. Who stops waiting is out of the line at once.
    pub(crate) async fn turn(&self) -> Result<Turn, Cancelled> {
        let (sender, receiver) = oneshot::channel();
        let _place = self.line_up(None, move |turn| drop(sender.send(turn)));
        receiver.await.map_err(|_| Cancelled)
    }

    /// Waits on this thread.
    pub(crate) fn turn_or(&self, cancelled: &AtomicBool) -> Result<Turn, Cancelled> {
        self.wait(None, cancelled)
    }

    /// Gives a turn back and asks for the next, so that whoever is first in line has it: perhaps the same member.
    pub(crate) fn pass(&self, turn: Turn, cancelled: &AtomicBool) -> Result<Turn, Cancelled> {
        self.wait(Some(turn), cancelled)
    }

    fn wait(&self, before: Option<Turn>, cancelled: &AtomicBool) -> Result<Turn, Cancelled> {
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

    fn line_up(&self, before: Option<Turn>, wake: impl FnOnce(Turn) + Send + 'static) -> Place {
        let mut state = self.turns.state();
        let id = state.number();
        let (seat, number, begun) = (self.seat.clone(), self.number, Arc::clone(&self.begun));
        state.waiting.push(Waiter { id, seat, number, begun, wake: Box::new(wake) });
        // Its end must come after its owner stands in line again, or the next one would be chosen without it.
        drop(state);
        drop(before);
        self.turns.hand_over(self.turns.state());
        Place { turns: self.turns.clone(), id }
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        let mut state = self.turns.state();
        state.shares.leave(&self.seat, self.begun.load(Ordering::Relaxed));
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let turns = self.turns.clone();
        let mut state = turns.state();
        state.taken = false;
        state.shares.charge(self.lane, &self.tenant, self.weight, self.began.elapsed());
        turns.hand_over(state);
    }
}

/// A place in the line, left when dropped.
#[derive(Debug)]
struct Place {
    turns: Turns,
    id: u64,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.turns.state().waiting.retain(|waiter| waiter.id != self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU8;
    use std::thread;

    static GOING_ON: AtomicBool = AtomicBool::new(false);

    fn seat(lane: Lane, tenant: &str) -> Seat {
        Seat::new(lane, tenant, 1)
    }

    /// Lets all take turns of a millisecond while one thread holds the first, and says who had which.
    fn order(turns: &Turns, members: Vec<(Member, &'static str)>, each: usize) -> Vec<&'static str> {
        let served = Mutex::new(Vec::new());
        let first = turns.join(seat(Lane::Renders, "first"));
        let held = first.turn_or(&GOING_ON).unwrap();
        thread::scope(|scope| {
            let count = members.len();
            for (member, name) in members {
                let served = &served;
                scope.spawn(move || {
                    let mut turn = member.turn_or(&GOING_ON).unwrap();
                    for round in 1..=each {
                        served.lock().unwrap().push(name);
                        thread::sleep(Duration::from_millis(1));
                        if round < each {
                            turn = member.pass(turn, &GOING_ON).unwrap();
                        }
                    }
                });
            }
            while turns.state().waiting.len() < count {
                thread::yield_now();
            }
            drop(held);
        });
        served.into_inner().unwrap()
    }

    #[test]
    fn one_tenants_many_jobs_delay_anothers_by_a_round() {
        let turns = Turns::default();
        let mut members: Vec<_> = (0..50).map(|_| (turns.join(seat(Lane::Jobs, "many")), "many")).collect();
        members.push((turns.join(seat(Lane::Jobs, "one")), "one"));
        let served = order(&turns, members, 1);
        assert!(served.iter().position(|name| *name == "one") <= Some(1), "{served:?}");
    }

    #[test]
    fn interactive_work_has_half_of_the_turns_and_jobs_the_rest() {
        let turns = Turns::default();
        let members = vec![
            (turns.join(seat(Lane::Jobs, "a")), "job"),
            (turns.join(seat(Lane::Jobs, "b")), "job"),
            (turns.join(seat(Lane::Renders, "a")), "render"),
        ];
        let served = order(&turns, members, 40);
        let renders = served[..60].iter().filter(|name| **name == "render").count();
        assert!((25..=35).contains(&renders), "{renders} of 60: {served:?}");
    }

    #[test]
    fn weights_share_out_a_lane() {
        let turns = Turns::default();
        let heavy = Seat { weight: 3, ..seat(Lane::Jobs, "heavy") };
        let members = vec![(turns.join(heavy), "heavy"), (turns.join(seat(Lane::Jobs, "light")), "light")];
        let served = order(&turns, members, 40);
        let heavy = served[..40].iter().filter(|name| **name == "heavy").count();
        assert!((26..=34).contains(&heavy), "{heavy} of 40: {served:?}");
    }

    #[test]
    fn priorities_come_before_age_and_tiles_are_newest_first() {
        let turns = Turns::default();
        let important = Seat { priority: Arc::new(AtomicU8::new(90)), ..seat(Lane::Jobs, "a") };
        let members = vec![
            (turns.join(seat(Lane::Jobs, "a")), "first"),
            (turns.join(seat(Lane::Jobs, "a")), "second"),
            (turns.join(important), "important"),
        ];
        assert_eq!(order(&turns, members, 2), ["important", "important", "first", "first", "second", "second"]);
        let render = |name| (turns.join(seat(Lane::Renders, "a")), name);
        let members = vec![render("first"), render("second"), render("third")];
        assert_eq!(order(&turns, members, 2), ["first", "second", "first", "second", "third", "third"]);
        let tile = |name| (turns.join(seat(Lane::Tiles, "a")), name);
        assert_eq!(order(&turns, vec![tile("old"), tile("middle"), tile("new")], 1), ["new", "middle", "old"]);
    }

    #[test]
    fn who_has_been_away_has_saved_nothing() {
        let turns = Turns::default();
        let busy = turns.join(seat(Lane::Jobs, "busy"));
        let mut turn = busy.turn_or(&GOING_ON).unwrap();
        for _ in 0..20 {
            thread::sleep(Duration::from_millis(1));
            turn = busy.pass(turn, &GOING_ON).unwrap();
        }
        drop(turn);
        let members = vec![(busy, "busy"), (turns.join(seat(Lane::Jobs, "new")), "new")];
        let served = order(&turns, members, 20);
        let new = served[..20].iter().filter(|name| **name == "new").count();
        assert!((8..=12).contains(&new), "{new} of 20: {served:?}");
    }

    #[test]
    fn who_stops_waiting_is_passed_over() {
        let turns = Turns::default();
        let [first, second, third] = [(); 3].map(|()| turns.join(seat(Lane::Jobs, "a")));
        let held = first.turn_or(&GOING_ON).unwrap();
        let given_up = AtomicBool::new(true);
        assert!(second.turn_or(&given_up).is_err());
        assert!(turns.state().waiting.is_empty());
        drop(held);
        assert!(third.turn_or(&GOING_ON).is_ok());
    }

    #[tokio::test]
    async fn a_future_that_is_dropped_leaves_the_line_and_loses_no_turn() {
        let turns = Turns::default();
        let [first, second, third] = [(); 3].map(|()| turns.join(seat(Lane::Renders, "a")));
        let held = first.turn().await.unwrap();
        let waiting = tokio::time::timeout(Duration::from_millis(20), second.turn()).await;
        assert!(waiting.is_err() && turns.state().waiting.is_empty());
        drop(held);
        assert!(third.turn().await.is_ok());
    }
}
