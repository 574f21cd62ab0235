//! A disk that is full or broken for a while: nothing is promised that is not kept, and what waited for it goes on.

use super::crash_tests::{PATIENCE, SCENE, open};
use super::job::{Job, Stopped};
use super::record::State;
use crate::service::error::Error;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::test_journal::set_fault;
use std::io::ErrorKind;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

/// Another scene, which has another picture.
fn other_scene() -> String {
    SCENE.replacen('{', "{ \"render\": { \"samples\": 4 },", 1)
}

fn wait_until(job: &Job, is_so: impl Fn() -> bool) {
    let started = Instant::now();
    while !is_so() {
        assert!(started.elapsed() < PATIENCE, "{:?}", job.record());
        thread::sleep(Duration::from_millis(1));
    }
}

/// A full disk, a volume that is mounted again to be read only, and errors of the device.
const FAULTS: [ErrorKind; 3] = [ErrorKind::StorageFull, ErrorKind::ReadOnlyFilesystem, ErrorKind::Other];

#[test]
fn what_cannot_be_written_is_refused_until_there_is_room() {
    FAULTS.into_iter().for_each(refused_until_healed);
}

fn refused_until_healed(fault: ErrorKind) {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let opened = open(&pool, &path).unwrap();
    let first = opened.submit(SCENE, None);
    assert_eq!(opened.wait(&first), State::Succeeded);
    let id = first.record().id.clone();

    set_fault(&path, Some(fault));
    let refused = opened.try_submit(&format!("{SCENE} "), None).unwrap_err();
    assert!(matches!(&refused, Error::Busy { detail, .. } if detail.contains("its operator has to")), "{refused:?}");
    assert!(opened.jobs.forget(&first).is_err());
    assert!(opened.jobs.find(&id).is_some() && opened.jobs.picture(&first).unwrap().is_some());
    opened.jobs.tick();
    assert!(opened.jobs.is_unwritable());

    set_fault(&path, None);
    opened.jobs.tick();
    assert!(!opened.jobs.is_unwritable());
    let second = opened.submit(&format!("{SCENE} "), None);
    assert_eq!(opened.wait(&second), State::Succeeded);
    opened.jobs.forget(&first).unwrap();
    drop(opened);
    let opened = open(&pool, &path).unwrap();
    assert!(opened.jobs.find(&id).is_none());
    assert_eq!(opened.jobs.find(&second.record().id).unwrap().record().state, State::Succeeded);
}

#[test]
fn a_job_waits_until_its_picture_can_be_kept() {
    FAULTS.into_iter().for_each(waits_until_healed);
}

fn waits_until_healed(fault: ErrorKind) {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let opened = open(&pool, &path).unwrap();
    let expected = opened.submit(SCENE, None);
    assert_eq!(opened.wait(&expected), State::Succeeded);
    // All but its picture can be kept.
    let pictures = path.join("pictures");
    set_fault(&pictures, Some(fault));
    let job = opened.submit(&other_scene(), None);
    wait_until(&job, || job.waits.load(Ordering::Relaxed));
    assert_eq!(job.done.load(Ordering::Relaxed), 4);
    thread::sleep(Duration::from_millis(700));
    assert!(!job.record().state.is_final(), "{:?}", job.record().failure);
    set_fault(&pictures, None);
    assert_eq!(opened.wait(&job), State::Succeeded);
    assert!(opened.jobs.picture(&job).unwrap().is_some());
    let id = job.record().id.clone();
    drop(opened);
    assert_eq!(open(&pool, &path).unwrap().jobs.find(&id).unwrap().record().state, State::Succeeded);
}

#[test]
fn a_job_that_waits_for_the_disk_can_be_canceled() {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let opened = open(&pool, &path).unwrap();
    let pictures = path.join("pictures");
    set_fault(&pictures, Some(ErrorKind::ReadOnlyFilesystem));
    let job = opened.submit(&other_scene(), None);
    wait_until(&job, || job.waits.load(Ordering::Relaxed));
    set_fault(&path, Some(ErrorKind::ReadOnlyFilesystem));
    assert!(opened.jobs.is_unwritable());
    job.stop(Stopped::Canceled);
    // Longer than between two tries, so that it has heard of it.
    thread::sleep(Duration::from_millis(1_500));
    assert!(!job.record().state.is_final(), "nobody hears what is not kept");
    set_fault(&path, None);
    set_fault(&pictures, None);
    assert_eq!(opened.wait(&job), State::Canceled);
    assert!(!opened.jobs.is_unwritable());
}

/// As where a volume is away, and what it is mounted on is there.
#[test]
fn nothing_is_kept_in_the_place_of_what_comes_back() {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [path, away] = ["data", "away"].map(|name| folder.path().join(name));
    let opened = open(&pool, &path).unwrap();
    let first = opened.submit(SCENE, None);
    assert_eq!(opened.wait(&first), State::Succeeded);
    // The file of the records is closed once it cannot be written.
    set_fault(&path, Some(ErrorKind::Other));
    assert!(opened.jobs.forget(&first).is_err());
    std::fs::rename(&path, &away).unwrap();
    std::fs::create_dir(&path).unwrap();
    set_fault(&path, None);
    opened.jobs.tick();
    assert!(opened.jobs.is_unwritable());
    assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
    std::fs::remove_dir(&path).unwrap();
    std::fs::rename(&away, &path).unwrap();
    opened.jobs.tick();
    assert!(!opened.jobs.is_unwritable());
    let second = opened.submit(&format!("{SCENE} "), None);
    assert_eq!(opened.wait(&second), State::Succeeded);
    drop(opened);
    let opened = open(&pool, &path).unwrap();
    for job in [&first, &second] {
        assert_eq!(opened.jobs.find(&job.record().id).unwrap().record().state, State::Succeeded);
    }
}
