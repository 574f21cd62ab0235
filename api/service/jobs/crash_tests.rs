//! Crashes at every moment in the lives of jobs: whatever a kill or a power cut leaves on disk, the service starts, no job that
//! was accepted is lost, and no picture is another one.

use super::outbox::{DeliveryKind, DeliveryState};
use super::record::{JobSpec, Record, State};
use super::{DATA, Job, JobObserver, Jobs};
use crate::service::error::{Error, StartError};
use crate::service::limits::JobLimits;
use crate::service::memory_budget::MemoryBudget;
use crate::service::pictures::file::PictureFile;
use crate::service::scenes::cache::SceneCache;
use crate::service::scenes::store::SceneStore;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::disk::Change;
use crate::service::storage::folder::Folder;
use crate::service::storage::lru_cache::LruCache;
use crate::service::storage::test_journal::{self, Loss, Tree};
use std::collections::HashSet;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use strahl::film::FileFormat;
use strahl::scene::{Format, Overrides};

/// Longest wait for anything.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);

pub(super) const SCENE: &str = r#"{
  "version": 1,
  "image": { "width": 48, "height": 40 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "background": [0.3, 0.5, 0.8],
  "materials": { "red": { "diffuse": [0.8, 0.2, 0.1] } },
  "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "red" } }]
}"#;

struct Nobody;

impl JobObserver for Nobody {
    fn ended(&self, _: &Record, _: State) {}
    fn attempted(&self, _: DeliveryKind, _: DeliveryState) {}
}

/// A service as far as jobs need one.
pub(super) struct Opened {
    pub(super) jobs: Arc<Jobs>,
    _folder: Folder,
}

pub(super) fn open(pool: &Arc<Pool>, path: &Path) -> Result<Opened, StartError> {
    let limits = JobLimits {
        jobs: 10,
        job_max_pixels: 10_000,
        job_max_samples_total: 10_000,
        job_memory_bytes: 1 << 30,
        data_bytes: 1 << 30,
        job_timeout: Duration::from_secs(60),
        keep_pictures: Duration::from_secs(600),
        keep_records: Duration::from_secs(600),
        keep_jobs: 100,
        data: Some(path.to_owned()),
        durable: true,
    };
    let cache = Arc::new(SceneCache::new(0, MemoryBudget::new(1 << 30), None, SceneStore::Memory(LruCache::new(0))));
    let mut folder = Folder::open(path, &DATA)?;
    let jobs = Jobs::open(&mut folder, limits, Arc::clone(pool), cache, None, Arc::new(Nobody))?;
    Ok(Opened { jobs, _folder: folder })
}

impl Opened {
    pub(super) fn submit(&self, scene: &str, made: Option<&PictureFile>) -> Arc<Job> {
        self.try_submit(scene, made).expect("it is accepted")
    }

    pub(super) fn try_submit(&self, scene: &str, made: Option<&PictureFile>) -> Result<Arc<Job>, Error> {
        let (format, settings) = (Format::Json, Overrides::default());
        let record = Record {
            tenant: "acme".into(),
            scene_id: Some(format!("s_{}", "a".repeat(32))),
            image_id: Some(format!("i_{}_aaaaaa_a", "a".repeat(32))),
            width: 48,
            height: 40,
            // Four tiles.
            edge: 32,
            scene_bytes: 1_000,
            ..Record::new(JobSpec { scene: String::new(), format, settings, output: FileFormat::Png8 })
        };
        self.jobs.submit(record, scene.as_bytes(), 10, None, made)
    }

    pub(super) fn wait(&self, job: &Job) -> State {
        let started = Instant::now();
        while !job.record().state.is_final() {
            assert!(started.elapsed() < PATIENCE, "a job does not end");
            thread::sleep(Duration::from_millis(1));
        }
        job.record().state
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        self.jobs.close();
        let started = Instant::now();
        // The thread of a job that has ended holds the file of the records a moment longer.
        while (self.jobs.counts().1 > 0 || Arc::strong_count(&self.jobs) > 1) && started.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// What is known of a job.
#[derive(Debug, Clone)]
struct Promise {
    id: String,
    /// From this change on it is there.
    accepted: usize,
    /// From the first of these on it may be gone, from the second on it is.
    forgotten: [usize; 2],
}

/// What happened in a folder, and what was promised.
#[derive(Clone)]
struct History {
    changes: Vec<Change>,
    promises: Vec<Promise>,
    picture: Vec<u8>,
}

/// Two jobs that share a picture, one of which is forgotten.
fn history(pool: &Arc<Pool>, path: &Path) -> History {
    test_journal::listen(path);
    let opened = open(pool, path).unwrap();
    let rendered = opened.submit(SCENE, None);
    let mut promises = vec![promise(path, &rendered)];
    assert_eq!(opened.wait(&rendered), State::Succeeded);
    let made = opened.jobs.picture(&rendered).unwrap().unwrap();
    let reused = opened.submit(&format!("{SCENE}\n"), Some(&made));
    promises.push(promise(path, &reused));
    promises[0].forgotten[0] = test_journal::length(path);
    opened.jobs.forget(&rendered).unwrap();
    promises[0].forgotten[1] = test_journal::length(path);
    // The end of a process is part of it.
    drop(opened);
    History { changes: test_journal::take(path), promises, picture: made.bytes }
}

fn promise(path: &Path, job: &Job) -> Promise {
    Promise { id: job.record().id.clone(), accepted: test_journal::length(path), forgotten: [usize::MAX; 2] }
}

/// Starts on what every crash from a change on would have left; how many different things that were, or what went wrong.
fn crash_everywhere(pool: &Arc<Pool>, from: &Path, history: &History, first: usize) -> Result<usize, String> {
    let mut seen = HashSet::new();
    for moment in first..=history.changes.len() {
        for loss in
            [Loss::Nothing, Loss::Everything, Loss::Contents, Loss::Names, Loss::Torn, Loss::Some(1), Loss::Some(2)]
        {
            let tree = test_journal::after_crash(from, &history.changes[..moment], loss);
            let mut hasher = DefaultHasher::new();
            (
                &tree,
                history
                    .promises
                    .iter()
                    .map(|p| (p.accepted <= moment, p.forgotten.map(|at| at <= moment)))
                    .collect::<Vec<_>>(),
            )
                .hash(&mut hasher);
            if seen.insert(hasher.finish()) {
                start(pool, &tree, history, moment)
                    .map_err(|why| format!("{loss:?} after change {moment}: {why}\n{:?}", tree.keys()))?;
            }
        }
    }
    Ok(seen.len())
}

fn start(pool: &Arc<Pool>, tree: &Tree, history: &History, moment: usize) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    for (path, contents) in tree {
        let path = folder.path().join(path);
        match contents {
            Some(contents) => fs::write(path, contents).unwrap(),
            None => fs::create_dir_all(path).unwrap(),
        }
    }
    let opened = open(pool, folder.path()).map_err(|refused| format!("it does not start: {refused:?}"))?;
    for Promise { id, accepted, forgotten: [leaving, gone] } in &history.promises {
        let found = opened.jobs.find(id);
        if found.is_some() && moment >= *gone {
            return Err(format!("{id} is there again"));
        }
        if found.is_none() && (*accepted..*leaving).contains(&moment) {
            return Err(format!("{id} is lost"));
        }
        let Some(job) = found else { continue };
        if opened.wait(&job) != State::Succeeded {
            return Err(format!("{id} has failed: {:?}", job.record().failure));
        }
        let picture = opened.jobs.picture(&job).unwrap().ok_or_else(|| format!("{id} has no picture"))?;
        if picture.bytes != history.picture {
            return Err(format!("{id} has another picture"));
        }
    }
    Ok(())
}

#[test]
fn a_crash_at_any_moment_loses_no_job_and_spoils_no_picture() {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let history = history(&pool, &path);
    let count = crash_everywhere(&pool, &path, &history, 0).unwrap_or_else(|why| panic!("{why}"));
    assert!(count > 100, "{count} different crashes of {} changes", history.changes.len());

    // This test sees what each sync is for.
    for left_out in ["jobs.redb", "scenes/", "scenes", "pictures/", "pictures", ""] {
        let is_left_out = |change: &Change| match change {
            Change::Sync(of) => of.starts_with(path.join(left_out)) && left_out.ends_with(['/', 'b']),
            Change::SyncFolder(of) => *of == path.join(left_out) && !left_out.ends_with('/'),
            _ => false,
        };
        let changes = history.changes.iter().map(|change| match change {
            left_out if is_left_out(left_out) => Change::SyncFolder("nowhere".into()),
            change => change.clone(),
        });
        let without = History { changes: changes.collect(), ..history.clone() };
        let seen = crash_everywhere(&pool, &path, &without, history.promises[0].accepted);
        assert!(seen.is_err(), "without syncs of {left_out} a crash loses something");
    }
}
