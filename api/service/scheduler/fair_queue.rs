//! Who has the pool next: tasks that wait, and the order among them.
//!
//! Three lanes have equal shares of the time: tiles that somebody looks at, renders that somebody waits for, and jobs. So
//! what is interactive has at least half of it when both want it, and all of it when no job does. Within a lane tenants
//! share by weight, within a tenant the higher priority goes first, which for jobs grows with the time since they were accepted.
//! Renders of a tenant take turns while they are young, so that a short one ends before long ones that came first (as in
//! multilevel feedback queues, Corbató 1962). Of those that have turned out to be long only two take turns with them, or all would end late; and few
//! begin at all, since each that has begun takes memory. Jobs go one after the other.

use super::shares::Shares;
use super::task::{Class, Task, aged};
use std::cmp::Reverse;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::time::{Duration, Instant};

/// Time of the pool for which a render is young.
const YOUNG: Duration = Duration::from_millis(200);

/// Renders of a tenant that are not young any more, and take turns.
const LONG: usize = 2;

/// Renders of a tenant that have begun and not ended.
const BEGUN: usize = 8;

/// The queue. A task joins it once, and then waits in it any number of times, each time with a `T`.
#[derive(Debug)]
pub(super) struct FairQueue<T> {
    waiting: Vec<Waiting<T>>,
    /// Ids of tasks that have joined and have had the pool, and for how long.
    begun: HashMap<u64, Duration>,
    /// Tasks that have joined and places that were taken.
    count: u64,
    shares: Shares,
}

/// A task that waits.
#[derive(Debug)]
pub(super) struct Waiting<T> {
    pub(super) id: u64,
    pub(super) task: Task,
    /// Since when it waits: a task that has had the pool begins anew.
    place: u64,
    pub(super) with: T,
}

impl<T> Default for FairQueue<T> {
    fn default() -> Self {
        Self { waiting: Vec::new(), begun: HashMap::new(), count: 0, shares: Shares::default() }
    }
}

impl<T> FairQueue<T> {
    /// A task joins; its id.
    pub(super) fn join(&mut self, task: &Task) -> u64 {
        self.shares.join(task);
        self.number()
    }

    /// A task leaves for good.
    pub(super) fn leave(&mut self, id: u64, task: &Task) {
        self.remove(id, |_| true);
        let begun = self.begun.remove(&id).is_some();
        self.shares.leave(task, begun);
    }

    /// A task begins to wait.
    pub(super) fn push(&mut self, id: u64, task: Task, with: T) {
        let place = if self.begun.contains_key(&id) { self.number() } else { id };
        self.waiting.push(Waiting { id, task, place, with });
    }

    /// A task waits no more, if it waits with such a `T`.
    pub(super) fn remove(&mut self, id: u64, such: impl Fn(&T) -> bool) -> Option<T> {
        let place = self.waiting.iter().position(|waiting| waiting.id == id && such(&waiting.with))?;
        Some(self.waiting.swap_remove(place).with)
    }

    /// The next one.
    pub(super) fn pop(&mut self) -> Option<Waiting<T>> {
        let (class, tenant) = self.shares.serve(self.waiting.iter().map(|waiting| &waiting.task))?;
        let of_tenant = |(_, Waiting { task, .. }): &(usize, &Waiting<T>)| task.class == class && task.tenant == tenant;
        let mut of_tenant: Vec<(usize, &Waiting<T>)> = self.waiting.iter().enumerate().filter(of_tenant).collect();
        if class == Class::Renders {
            self.leave_those_in_turn(&mut of_tenant, self.shares.begun(class, &tenant));
        }
        let now = Instant::now();
        let next = of_tenant.into_iter().max_by(|(_, a), (_, b)| a.rank(b, now))?.0;
        let next = self.waiting.swap_remove(next);
        if let Entry::Vacant(entry) = self.begun.entry(next.id) {
            entry.insert(Duration::ZERO);
            self.shares.begin(class, &tenant);
        }
        Some(next)
    }

    /// Of the renders of a tenant that wait, of which so many have begun, leaves those that take turns.
    fn leave_those_in_turn(&self, waiting: &mut Vec<(usize, &Waiting<T>)>, begun: usize) {
        let had = |waiting: &Waiting<T>| self.begun.get(&waiting.id);
        // If all that have begun are busy elsewhere, the pool is not kept waiting for them.
        if begun >= BEGUN && waiting.iter().any(|(_, it)| had(it).is_some()) {
            waiting.retain(|(_, it)| had(it).is_some());
        }
        let is_long = |it: &Waiting<T>| had(it).is_some_and(|had| *had >= YOUNG);
        let mut long: Vec<(Reverse<u8>, u64)> =
            waiting.iter().filter(|(_, it)| is_long(it)).map(|(_, it)| (Reverse(it.task.priority()), it.id)).collect();
        long.sort_unstable();
        let in_turn = &long[..long.len().min(LONG)];
        waiting.retain(|(_, it)| !is_long(it) || in_turn.iter().any(|(_, id)| *id == it.id));
    }

    /// A task has had the pool.
    pub(super) fn charge(&mut self, id: u64, task: &Task, time: Duration) {
        self.begun.entry(id).and_modify(|had| *had += time);
        self.shares.charge(task.class, &task.tenant, task.weight, time);
    }

    /// For how long a task that has joined has had the pool.
    pub(super) fn had(&self, id: u64) -> Duration {
        self.begun.get(&id).copied().unwrap_or_default()
    }

    /// Seconds that a lane has had the pool.
    pub(super) fn spent(&self, class: Class) -> f64 {
        self.shares.spent(class)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.waiting.iter().map(|waiting| &waiting.with)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    fn number(&mut self) -> u64 {
        self.count += 1;
        self.count
    }
}

impl<T> Waiting<T> {
    /// Greater goes first; both are of the same tenant and lane.
    fn rank(&self, other: &Self, now: Instant) -> std::cmp::Ordering {
        let aged = |waiting: &Self| aged(waiting.task.priority(), waiting.task.waiting_since, now);
        match self.task.class {
            Class::Tiles => self.task.priority().cmp(&other.task.priority()).then(self.id.cmp(&other.id)),
            Class::Renders => self.task.priority().cmp(&other.task.priority()).then(other.place.cmp(&self.place)),
            Class::Jobs => aged(self).total_cmp(&aged(other)).then(other.id.cmp(&self.id)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::AtomicU8;

    fn task(class: Class, tenant: &str) -> Task {
        Task::new(class, tenant, 1)
    }

    #[test]
    fn a_task_has_had_its_own_turns_alone() {
        let mut queue = FairQueue::default();
        let (task, ms) = (task(Class::Renders, "a"), Duration::from_millis(25));
        let ids = [(); 2].map(|()| queue.join(&task));
        for turn in 0..6 {
            queue.push(ids[turn % 2], task.clone(), ());
            let next = queue.pop().unwrap();
            queue.charge(next.id, &task, ms);
        }
        assert_eq!(ids.map(|id| queue.had(id)), [3 * ms; 2]);
        queue.leave(ids[0], &task);
        assert_eq!(queue.had(ids[0]), Duration::ZERO);
    }

    /// Lets each task have the pool for a millisecond `each` times, and says who had it when.
    fn order(queue: &mut FairQueue<&'static str>, tasks: Vec<(Task, &'static str)>, each: usize) -> Vec<&'static str> {
        let mut left = HashMap::new();
        for (task, name) in tasks {
            let id = queue.join(&task);
            left.insert(id, each);
            queue.push(id, task, name);
        }
        let mut served = Vec::new();
        while let Some(Waiting { id, task, with, .. }) = queue.pop() {
            served.push(with);
            queue.charge(id, &task, Duration::from_millis(1));
            let more = left.get_mut(&id).unwrap();
            *more -= 1;
            if *more > 0 { queue.push(id, task, with) } else { queue.leave(id, &task) }
        }
        served
    }

    fn order_of(tasks: Vec<(Task, &'static str)>, each: usize) -> Vec<&'static str> {
        order(&mut FairQueue::default(), tasks, each)
    }

    #[test]
    fn one_tenants_many_jobs_delay_anothers_by_a_round() {
        let mut tasks: Vec<_> = (0..50).map(|_| (task(Class::Jobs, "many"), "many")).collect();
        tasks.push((task(Class::Jobs, "one"), "one"));
        let served = order_of(tasks, 1);
        assert!(served.iter().position(|name| *name == "one") <= Some(1), "{served:?}");
    }

    #[test]
    fn interactive_work_has_half_of_the_time_and_jobs_the_rest() {
        let tasks = vec![
            (task(Class::Jobs, "a"), "job"),
            (task(Class::Jobs, "b"), "job"),
            (task(Class::Renders, "a"), "render"),
        ];
        let served = order_of(tasks, 40);
        let renders = served[..60].iter().filter(|name| **name == "render").count();
        assert!((25..=35).contains(&renders), "{renders} of 60: {served:?}");
    }

    #[test]
    fn weights_share_out_a_lane() {
        let heavy = Task { weight: 3, ..task(Class::Jobs, "heavy") };
        let served = order_of(vec![(heavy, "heavy"), (task(Class::Jobs, "light"), "light")], 40);
        let heavy = served[..40].iter().filter(|name| **name == "heavy").count();
        assert!((26..=34).contains(&heavy), "{heavy} of 40: {served:?}");
    }

    #[test]
    fn priorities_come_before_age_and_tiles_are_newest_first() {
        let important = Task { priority: Arc::new(AtomicU8::new(90)), ..task(Class::Jobs, "a") };
        let tasks =
            vec![(task(Class::Jobs, "a"), "first"), (task(Class::Jobs, "a"), "second"), (important, "important")];
        assert_eq!(order_of(tasks, 2), ["important", "important", "first", "first", "second", "second"]);
        let render = |name| (task(Class::Renders, "a"), name);
        let tasks = vec![render("first"), render("second"), render("third")];
        assert_eq!(order_of(tasks, 2), ["first", "second", "third", "first", "second", "third"]);
        let tile = |name| (task(Class::Tiles, "a"), name);
        assert_eq!(order_of(vec![tile("old"), tile("middle"), tile("new")], 1), ["new", "middle", "old"]);
    }

    #[test]
    fn long_renders_hold_up_no_short_one_and_two_of_them_take_turns() {
        let mut queue = FairQueue::default();
        let render = task(Class::Renders, "a");
        let serve = |queue: &mut FairQueue<u64>, time: u64| {
            let Waiting { id, task, with, .. } = queue.pop().unwrap();
            queue.charge(id, &task, Duration::from_millis(time));
            queue.push(id, task, with);
            with
        };
        let join = |queue: &mut FairQueue<u64>, name: u64| {
            let id = queue.join(&render);
            queue.push(id, render.clone(), name);
            id
        };
        let ids: Vec<u64> = (0..20).map(|name| join(&mut queue, name)).collect();
        // Eight begin, and turn out to be long; the others wait.
        let served: Vec<u64> = (0..80).map(|_| serve(&mut queue, 25)).collect();
        assert!(served[..64].iter().all(|name| *name < 8), "{served:?}");
        assert!(served[64..].iter().all(|name| *name < 2), "{served:?}");
        // The next one begins when one has ended, and has each third turn.
        queue.leave(ids[0], &render);
        let served: Vec<u64> = (0..6).map(|_| serve(&mut queue, 25)).collect();
        assert_eq!(served.iter().filter(|name| **name == 8).count(), 2, "{served:?}");
    }

    #[test]
    fn jobs_of_one_age_go_in_the_order_in_which_they_came() {
        let job = task(Class::Jobs, "a");
        let tasks = ["first", "second", "third"].map(|name| (job.clone(), name));
        assert_eq!(order_of(tasks.into(), 2), ["first", "first", "second", "second", "third", "third"]);
    }

    #[test]
    fn who_has_been_away_has_saved_nothing() {
        let mut queue = FairQueue::default();
        let busy = task(Class::Jobs, "busy");
        let id = queue.join(&busy);
        for _ in 0..20 {
            queue.push(id, busy.clone(), "busy");
            queue.pop().unwrap();
            queue.charge(id, &busy, Duration::from_millis(1));
        }
        let served = order(&mut queue, vec![(busy, "busy"), (task(Class::Jobs, "new"), "new")], 20);
        let new = served[..20].iter().filter(|name| **name == "new").count();
        assert!((8..=12).contains(&new), "{new} of 20: {served:?}");
    }

    #[test]
    fn who_stops_waiting_is_passed_over() {
        let mut queue = FairQueue::default();
        let [first, second] = [(); 2].map(|()| task(Class::Jobs, "a"));
        let ids = [queue.join(&first), queue.join(&second)];
        queue.push(ids[0], first, "first");
        queue.push(ids[1], second, "second");
        assert_eq!(queue.remove(ids[0], |_| true), Some("first"));
        assert_eq!(queue.pop().unwrap().with, "second");
        assert!(queue.pop().is_none() && queue.is_empty());
    }
}
