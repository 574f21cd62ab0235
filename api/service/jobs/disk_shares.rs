//! How the disk is shared. Each tenant may have an equal part of it, and more as long as nobody else wants it: where there is
//! no room, pictures are deleted of the tenant that has most beyond its part. So nobody deletes pictures of others that keep
//! to theirs.

use super::files::Files;
use super::job::Job;
use super::record::Record;
use super::registry::Registry;
use super::retention::disk_of;
use std::collections::HashMap;
use std::sync::Arc;

/// What tenants have.
#[derive(Debug)]
pub(super) struct DiskShares {
    tenants: HashMap<String, Holding>,
    /// Which files count.
    kinds: Kinds,
    /// All there is.
    budget: u64,
}

/// Files that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kinds {
    /// Scenes, pictures, and what open jobs may write.
    All,
    /// Scenes.
    Scenes,
}

/// What a tenant has.
#[derive(Debug, Default)]
struct Holding {
    /// Bytes of each file, and how many of the tenant's jobs share it.
    files: HashMap<String, (u64, usize)>,
    bytes: u64,
    /// Bytes that it is about to write.
    wanted: u64,
    /// Scenes of jobs that have not ended, and their bytes: they cannot be deleted.
    waiting: HashMap<String, u64>,
    /// Jobs with pictures, and when they ended; the oldest comes last.
    finished: Vec<(Option<u64>, Arc<Job>)>,
}

impl Holding {
    fn add(&mut self, name: &str, bytes: u64) {
        let (_, jobs) = self.files.entry(name.to_owned()).or_insert((bytes, 0));
        *jobs += 1;
        self.bytes += if *jobs == 1 { bytes } else { 0 };
    }

    fn remove(&mut self, name: &str) {
        if let Some((bytes, jobs)) = self.files.get_mut(name) {
            *jobs -= 1;
            self.bytes -= if *jobs == 0 { *bytes } else { 0 };
        }
    }
}

impl DiskShares {
    /// What tenants have of a number of bytes, and one of them wants some more.
    pub(super) fn of(
        registry: &Registry,
        files: &Files,
        kinds: Kinds,
        budget: u64,
        wanted: Option<(&str, u64)>,
    ) -> Self {
        let mut shares = Self { tenants: HashMap::new(), kinds, budget };
        for job in registry.jobs.values() {
            let record = job.record();
            let holding = shares.tenants.entry(record.tenant.clone()).or_default();
            for name in names(&record, kinds) {
                holding.add(&name, files.size(&name));
            }
            if !record.state.is_final() {
                holding.waiting.insert(record.spec.scene.clone(), files.size(&record.spec.scene));
            }
            if record.has_picture() {
                holding.finished.push((record.ended, Arc::clone(job)));
            }
        }
        for job in registry.open.iter().filter(|_| kinds == Kinds::All) {
            let record = job.record();
            shares.tenants.entry(record.tenant.clone()).or_default().wanted += disk_of(&record);
        }
        if let Some((tenant, bytes)) = wanted {
            shares.tenants.entry(tenant.to_owned()).or_default().wanted += bytes;
        }
        for holding in shares.tenants.values_mut() {
            holding.finished.sort_by_key(|(ended, _)| std::cmp::Reverse(*ended));
        }
        shares
    }

    /// Bytes that a tenant can have besides what others need not give up.
    pub(super) fn room(&self, tenant: &str) -> u64 {
        let others = self.tenants.iter().filter(|(name, _)| *name != tenant);
        let kept = others.map(|(_, holding)| holding.bytes.min(self.part())).sum();
        self.budget.saturating_sub(kept)
    }

    /// Bytes of scenes of waiting jobs that a tenant may still have: all of them half of what others leave.
    pub(super) fn room_for_waiting(&self, tenant: &str) -> u64 {
        let (mut own, mut others) = (0, 0);
        for (name, holding) in &self.tenants {
            *(if name == tenant { &mut own } else { &mut others }) += holding.waiting.values().sum::<u64>();
        }
        let left = self.budget.saturating_sub(others);
        if own == 0 { left } else { (left / 2).saturating_sub(own) }
    }

    /// The job whose picture is deleted next; none if all keep to their parts.
    pub(super) fn next(&mut self) -> Option<Arc<Job>> {
        let part = self.part();
        let may_lose = |holding: &&mut Holding| {
            let takes = holding.bytes + holding.wanted;
            !holding.finished.is_empty() && (takes > part || holding.wanted > 0)
        };
        let all = self.tenants.values_mut().filter(may_lose);
        let holding = all.max_by_key(|holding| holding.bytes + holding.wanted)?;
        let (_, job) = holding.finished.pop()?;
        names(&job.record(), self.kinds).iter().for_each(|name| holding.remove(name));
        Some(job)
    }

    fn part(&self) -> u64 {
        self.budget / self.tenants.len().max(1) as u64
    }
}

/// Files of a job.
fn names(record: &Record, kinds: Kinds) -> Vec<String> {
    let scene = record.needs_scene().then(|| record.spec.scene.clone());
    let has_pictures = kinds == Kinds::All && record.has_pictures();
    let pictures = if has_pictures { record.picture_names() } else { Vec::new() };
    scene.into_iter().chain(pictures).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tenants with pictures of 10 bytes each, of which so many can go, and what each wants.
    fn shares(budget: u64, tenants: &[(&str, u64, u64)]) -> DiskShares {
        let holding = |&(name, bytes, wanted): &(&str, u64, u64)| {
            (name.to_owned(), Holding { bytes, wanted, ..Holding::default() })
        };
        DiskShares { tenants: tenants.iter().map(holding).collect(), kinds: Kinds::All, budget }
    }

    #[test]
    fn there_is_room_for_what_others_need_not_keep() {
        let shares = shares(90, &[("small", 10, 0), ("large", 70, 0), ("new", 0, 0)]);
        assert_eq!(["small", "large", "new"].map(|tenant| shares.room(tenant)), [60, 80, 50]);
    }

    #[test]
    fn what_waits_leaves_half_of_the_room_to_others() {
        let waits = |bytes: u64| [("scene".to_owned(), bytes)].into();
        let mut shares = shares(100, &[("large", 0, 0), ("small", 0, 0)]);
        assert_eq!(["large", "new"].map(|tenant| shares.room_for_waiting(tenant)), [100, 100]);
        shares.tenants.get_mut("large").unwrap().waiting = waits(40);
        assert_eq!(["large", "small", "new"].map(|tenant| shares.room_for_waiting(tenant)), [10, 60, 60]);
        shares.tenants.get_mut("small").unwrap().waiting = waits(20);
        assert_eq!(["large", "small", "new"].map(|tenant| shares.room_for_waiting(tenant)), [0, 10, 40]);
    }

    #[test]
    fn files_that_jobs_of_a_tenant_share_count_once() {
        let mut holding = Holding::default();
        holding.add("a", 10);
        holding.add("a", 10);
        holding.add("b", 5);
        assert_eq!(holding.bytes, 15);
        holding.remove("a");
        assert_eq!(holding.bytes, 15);
        holding.remove("a");
        assert_eq!(holding.bytes, 5);
    }
}
