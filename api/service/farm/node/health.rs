//! What a node thinks of itself: jobs that fail here again and again are left to others, and a node on which all fail, or whose
//! pictures differ, takes no work.

use super::golden;
use parking_lot::Mutex;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Pieces of one job that may fail here before it is left to others.
const OF_JOB: usize = 3;
/// Jobs that may fail here, one after the other without a success, before the node doubts itself.
const JOBS: usize = 3;
/// How long both are avoided.
const AVOIDED: Duration = Duration::from_secs(600);
/// Time between two looks at the known picture.
const CHECK_INTERVAL: Duration = Duration::from_secs(3_600);
/// The same while the node takes no work.
const CHECK_INTERVAL_EXCLUDED: Duration = Duration::from_secs(60);
/// Jobs that are remembered.
const REMEMBERED: usize = 1_000;
/// Likewise of those that are too large, which each heartbeat names.
const REMEMBERED_LARGE: usize = 100;

/// Why a node takes no work, if it does not, and since when.
pub(super) type Exclusion = Option<(String, Instant)>;

/// The health of a node.
#[derive(Debug)]
pub(super) struct Health {
    failures: Mutex<Failures>,
    /// Why it takes no work, if it does not, and since when.
    excluded: watch::Sender<Exclusion>,
    /// Asks for a look at the known picture.
    check_requested: tokio::sync::Notify,
}

#[derive(Debug, Default)]
struct Failures {
    /// Pieces that failed, by job.
    of_jobs: HashMap<String, HashSet<u64>>,
    /// Jobs that are left to others, since when.
    avoided: HashMap<String, Instant>,
    /// Scenes that are left to nodes with more memory, by the names of their texts, since when.
    too_large: HashMap<String, Instant>,
    /// Jobs that have failed since the last success.
    in_a_row: HashSet<String>,
}

impl Health {
    pub(super) fn new() -> Self {
        Self {
            failures: Mutex::default(),
            excluded: watch::Sender::new(None),
            check_requested: tokio::sync::Notify::new(),
        }
    }

    /// Whether the job is left to others.
    pub(super) fn avoids(&self, job: &str) -> bool {
        self.failures.lock().avoided.get(job).is_some_and(|since| since.elapsed() < AVOIDED)
    }

    /// A scene that this node has too little memory for is left to others. That is no failure.
    pub(super) fn leave(&self, scene: &str) {
        let too_large = &mut self.failures.lock().too_large;
        too_large.insert(scene.to_owned(), Instant::now());
        if too_large.len() > REMEMBERED_LARGE
            && let Some(oldest) = too_large.iter().min_by_key(|(_, since)| **since).map(|(scene, _)| scene.clone())
        {
            too_large.remove(&oldest);
        }
    }

    /// Those scenes.
    pub(super) fn too_large(&self) -> BTreeSet<String> {
        let failures = self.failures.lock();
        let lately = failures.too_large.iter().filter(|(_, since)| since.elapsed() < AVOIDED);
        lately.map(|(scene, _)| scene.clone()).collect()
    }

    /// Whether a scene is one of them.
    pub(super) fn is_too_large(&self, scene: &str) -> bool {
        self.failures.lock().too_large.get(scene).is_some_and(|since| since.elapsed() < AVOIDED)
    }

    /// A piece was rendered.
    pub(super) fn succeeded(&self) {
        self.failures.lock().in_a_row.clear();
    }

    /// A piece has failed.
    pub(super) fn failed(&self, job: &str, piece: u64) {
        let mut failures = self.failures.lock();
        if failures.of_jobs.len() >= REMEMBERED {
            failures.of_jobs.clear();
        }
        failures.avoided.retain(|_, since| since.elapsed() < AVOIDED);
        let pieces = failures.of_jobs.entry(job.to_owned()).or_default();
        pieces.insert(piece);
        if pieces.len() >= OF_JOB {
            failures.of_jobs.remove(job);
            failures.avoided.insert(job.to_owned(), Instant::now());
        }
        failures.in_a_row.insert(job.to_owned());
        if failures.in_a_row.len() >= JOBS {
            failures.in_a_row.clear();
            drop(failures);
            self.exclude(format!("pieces of {JOBS} jobs have failed here, and none was rendered between them"));
        }
    }

    /// Takes no work from now on.
    pub(super) fn exclude(&self, why: String) {
        tracing::error!(why, "this node takes no work");
        self.excluded.send_replace(Some((why, Instant::now())));
    }

    /// Why it takes no work.
    pub(super) fn excluded(&self) -> watch::Receiver<Exclusion> {
        self.excluded.subscribe()
    }

    /// Asks for a check of the known picture soon.
    pub(super) fn request_check(&self) {
        self.check_requested.notify_one();
    }

    /// Renders the known picture, and excludes this node if it has other bytes.
    pub(super) async fn check_golden(&self) {
        let found = tokio::task::spawn_blocking(golden::check).await;
        let found = found.unwrap_or_else(|_| Err("the check of a known picture has failed".into()));
        let since = self.excluded.borrow().as_ref().map(|(_, since)| *since);
        match (found, since) {
            (Err(why), None) => self.exclude(why),
            (Ok(()), Some(since)) if since.elapsed() >= AVOIDED => {
                tracing::info!("this node takes work again");
                self.excluded.send_replace(None);
            }
            _ => {}
        }
    }

    /// Checks it every few minutes, and when asked to.
    pub(super) async fn run(&self) {
        loop {
            let until = if self.excluded.borrow().is_some() { CHECK_INTERVAL_EXCLUDED } else { CHECK_INTERVAL };
            let mut changes = self.excluded();
            tokio::select! {
                () = tokio::time::sleep(until) => {}
                () = self.check_requested.notified() => {}
                // From now on it looks more often.
                _ = changes.changed() => continue,
            }
            self.check_golden().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_that_fails_again_and_again_is_left_to_others() {
        let health = Health::new();
        for piece in [1, 1, 2] {
            health.failed("a", piece);
            assert!(!health.avoids("a"), "the same piece counts once");
        }
        health.failed("a", 3);
        assert!(health.avoids("a") && !health.avoids("b"));
        assert!(health.excluded().borrow().is_none(), "it may be the job's fault");
    }

    #[test]
    fn a_scene_that_is_too_large_is_left_to_others_and_no_failure() {
        let health = Health::new();
        for scene in 0..=REMEMBERED_LARGE {
            health.leave(&scene.to_string());
        }
        assert!(health.is_too_large("100") && !health.is_too_large("0") && !health.avoids("100"), "the oldest went");
        assert_eq!(health.too_large().len(), REMEMBERED_LARGE);
        assert!(health.excluded().borrow().is_none());
    }

    #[test]
    fn a_node_on_which_all_jobs_fail_takes_no_work() {
        let health = Health::new();
        health.failed("a", 1);
        health.failed("b", 1);
        health.succeeded();
        health.failed("c", 1);
        health.failed("a", 2);
        assert!(health.excluded().borrow().is_none());
        health.failed("b", 2);
        assert!(health.excluded().borrow().is_some());
    }
}
