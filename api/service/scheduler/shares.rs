//! What lanes and tenants have had: the milliseconds of their turns, divided by their weight (virtual time, as in weighted
//! fair queueing). Who has had least is next. Who has been away starts where the others are, so nobody saves up turns.

use super::task::{Class, Task};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

/// Tenants whose use is remembered after they have gone.
const REMEMBERED: usize = 1_024;

/// Everybody's shares.
#[derive(Debug, Default)]
pub(crate) struct Shares {
    classes: [Share; 3],
    tenants: [HashMap<Arc<str>, Share>; 3],
    /// What those had had who were served last: of all lanes, and of the tenants of each.
    classes_now: f64,
    tenants_now: [f64; 3],
    /// Milliseconds that the turns of each lane have taken.
    spent: [f64; 3],
}

/// What somebody has had.
#[derive(Debug, Default)]
struct Share {
    had: f64,
    members: usize,
    /// Of these, those that have had a turn.
    begun: usize,
}

impl Share {
    fn join(&mut self, now: f64) {
        if self.members == 0 {
            self.had = self.had.max(now);
        }
        self.members += 1;
    }
}

impl Shares {
    /// One more who may want turns.
    pub(crate) fn join(&mut self, task: &Task) {
        let class = task.class as usize;
        self.classes[class].join(self.classes_now);
        self.tenants[class].entry(Arc::clone(&task.tenant)).or_default().join(self.tenants_now[class]);
    }

    /// One has its first turn.
    pub(crate) fn begin(&mut self, class: Class, tenant: &Arc<str>) {
        self.tenants[class as usize].entry(Arc::clone(tenant)).or_default().begun += 1;
    }

    /// How many have had a turn.
    pub(crate) fn begun(&self, class: Class, tenant: &Arc<str>) -> usize {
        self.tenants[class as usize].get(tenant).map_or(0, |share| share.begun)
    }

    /// One less, which may have begun.
    pub(crate) fn leave(&mut self, task: &Task, begun: bool) {
        let class = task.class as usize;
        self.classes[class].members -= 1;
        let now = self.tenants_now[class];
        let tenants = &mut self.tenants[class];
        if let Some(share) = tenants.get_mut(&task.tenant) {
            share.members -= 1;
            share.begun -= usize::from(begun);
        }
        if tenants.len() > REMEMBERED {
            tenants.retain(|_, share| share.members > 0 || share.had > now);
        }
    }

    /// The lane and the tenant that have had least of those who wait; they are served now.
    pub(crate) fn serve<'a>(&mut self, waiting: impl Iterator<Item = &'a Task> + Clone) -> Option<(Class, Arc<str>)> {
        let first = |a: f64, b: f64| a.total_cmp(&b);
        let class = [Class::Tiles, Class::Renders, Class::Jobs]
            .into_iter()
            .filter(|class| waiting.clone().any(|task| task.class == *class))
            .min_by(|a, b| first(self.classes[*a as usize].had, self.classes[*b as usize].had))?;
        let had = |tenant: &Arc<str>| self.tenants[class as usize].get(tenant).map_or(0.0, |share| share.had);
        let in_lane = waiting.filter(|task| task.class == class);
        let tenant = in_lane.map(|task| &task.tenant).min_by(|a, b| first(had(a), had(b)))?;
        self.classes_now = self.classes[class as usize].had;
        self.tenants_now[class as usize] = had(tenant);
        Some((class, Arc::clone(tenant)))
    }

    /// A turn has taken so long.
    pub(crate) fn charge(&mut self, class: Class, tenant: &Arc<str>, weight: u32, took: Duration) {
        let milliseconds = took.as_secs_f64() * 1e3;
        self.spent[class as usize] += milliseconds;
        self.classes[class as usize].had += milliseconds;
        if let Some(share) = self.tenants[class as usize].get_mut(tenant) {
            share.had += milliseconds / f64::from(weight.max(1));
        }
    }

    /// Seconds that the turns of a lane have taken.
    pub(crate) fn spent(&self, class: Class) -> f64 {
        self.spent[class as usize] / 1e3
    }
}
