//! A disk that is full or broken for a while: nothing is promised that is not kept, and what waited for it goes on.

use super::crash::{SCENE, open};
use super::record::State;
use crate::service::error::Error;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::journal::set_fault;
use std::io::ErrorKind;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

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
    set_fault(&path, Some(fault));
    wait_until(&|| job.done.load(Ordering::Relaxed) == 4);
    thread::sleep(Duration::from_millis(700));
    assert!(!job.record().state.is_final(), "{:?}", job.record().failure);
    set_fault(&path, None);
    assert_eq!(opened.wait(&job), State::Succeeded);
    assert!(opened.jobs.picture(&job).unwrap().is_some());
    let id = job.record().id.clone();
    drop(opened);
    assert_eq!(open(&pool, &path).unwrap().jobs.find(&id).unwrap().record().state, State::Succeeded);
}
