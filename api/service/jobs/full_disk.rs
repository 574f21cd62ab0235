//! A disk that is full for a while: nothing is promised that is not kept, and what waited for room goes on.

use super::crash::{SCENE, open};
use super::record::State;
use crate::service::error::Error;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::journal::set_full;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

#[test]
fn what_cannot_be_written_is_refused_until_there_is_room() {
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let opened = open(&pool, &path).unwrap();
    let first = opened.submit(SCENE, None);
    assert_eq!(opened.wait(&first), State::Succeeded);
    let id = first.record().id.clone();

    set_full(&path, true);
    let refused = opened.try_submit(&format!("{SCENE} "), None).unwrap_err();
    assert!(matches!(&refused, Error::Busy { detail, .. } if detail.contains("disk")), "{refused:?}");
    assert!(opened.jobs.forget(&first).is_err());
    assert!(opened.jobs.find(&id).is_some() && opened.jobs.picture(&first).unwrap().is_some());
    opened.jobs.tick();
    assert!(opened.jobs.is_unwritable());

    set_full(&path, false);
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
    let pool = Pool::start(Some(1), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data");
    let opened = open(&pool, &path).unwrap();
    let expected = opened.submit(SCENE, None);
    assert_eq!(opened.wait(&expected), State::Succeeded);
    // Enough work that the disk is full before it is done.
    let job = opened.submit(&SCENE.replacen('{', "{ \"render\": { \"samples\": 1024 },", 1), None);
    let started = Instant::now();
    let wait_until = |is_so: &dyn Fn() -> bool| {
        while !is_so() {
            assert!(started.elapsed() < Duration::from_secs(60), "{:?}", job.record());
            thread::sleep(Duration::from_millis(1));
        }
    };
    wait_until(&|| job.record().state == State::Running);
    set_full(&path, true);
    wait_until(&|| job.done.load(Ordering::Relaxed) == 4);
    thread::sleep(Duration::from_millis(700));
    assert!(!job.record().state.is_final(), "{:?}", job.record().failure);
    set_full(&path, false);
    assert_eq!(opened.wait(&job), State::Succeeded);
    assert!(opened.jobs.picture(&job).unwrap().is_some());
    let id = job.record().id.clone();
    drop(opened);
    assert_eq!(open(&pool, &path).unwrap().jobs.find(&id).unwrap().record().state, State::Succeeded);
}
