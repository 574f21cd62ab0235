//! The folders of `--data` and `--cache`: whose they are, what is removed from them, and what is given out when a file in them is
//! spoilt.

use super::jobs::{LONG, ended, job, mirrors, submit, succeeded, text, until};
use crate::common::service::{PATIENCE, Service};
use crate::common::{BALL, SLOW};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The exit code and the words of a service that does not start.
fn refused(flags: &[&str]) -> (Option<i32>, String) {
    match Service::try_start(flags) {
        Err(refused) => refused,
        Ok(service) => panic!("it starts:\n{}", service.log()),
    }
}

/// All files in a folder by their paths, with what is in them.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        match entry.file_type().unwrap().is_dir() {
            true => found.extend(files(&entry.path())),
            false => drop(found.insert(entry.path(), fs::read(entry.path()).unwrap())),
        }
    }
    found
}

/// The files of a folder in `--data` or `--cache`, by name.
fn names(folder: &Path, part: &str) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(folder.join(part)).unwrap().map(name).collect();
    names.sort();
    names
}

/// A service with a folder for jobs.
fn start(data: &Path) -> Service {
    Service::start(&["--data", data.to_str().unwrap()])
}

#[test]
fn a_service_without_its_folders_is_not_ready() {
    let root = tempfile::tempdir().unwrap();
    let service = start(root.path());
    let (pictures, away) = (root.path().join("pictures"), root.path().join("away"));
    let wait_for = |status: &str| {
        let started = Instant::now();
        while service.get("/readyz").json()["status"] != status {
            assert!(started.elapsed() < PATIENCE, "the service is not {status}");
        }
    };
    wait_for("ready");
    fs::rename(&pictures, &away).unwrap();
    wait_for("unwritable");
    assert_eq!(service.get("/readyz").status, 503);
    fs::rename(&away, &pictures).unwrap();
    wait_for("ready");
}

#[test]
fn a_folder_of_somebody_else_is_refused_and_nothing_in_it_is_touched() {
    let root = tempfile::tempdir().unwrap();
    let home = root.path().join("home");
    for file in ["jobs/applications/cv.txt", "scenes/film.blend", "pictures/1.jpg", "pictures/2.jpg"] {
        fs::create_dir_all(home.join(file).parent().unwrap()).unwrap();
        fs::write(home.join(file), vec![7; 1_000_000]).unwrap();
    }
    let before = files(&home);
    for flag in ["--data", "--cache"] {
        let (code, said) = refused(&[flag, home.to_str().unwrap(), "--disk-cache-bytes", "1500000"]);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("does not belong to strahl") && said.contains("Name a new folder"), "{said}");
    }
    assert_eq!(files(&home), before);

    // In a folder of the service, too, it removes only what it has written.
    let data = root.path().join("data");
    drop(start(&data));
    let strangers = ["scenes/film.blend", "pictures/1.jpg", "tiles/cv.txt", "notes.txt"].map(|file| data.join(file));
    strangers.iter().for_each(|file| fs::write(file, "mine").unwrap());
    let service = Service::start(&["--data", data.to_str().unwrap(), "--data-bytes", "500000"]);
    succeeded(&service, &submit(&service, BALL, ""));
    drop(service);
    assert!(strangers.iter().all(|file| fs::read(file).unwrap() == b"mine"));
}

#[test]
fn each_folder_has_one_use_and_one_service() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name).to_str().unwrap().to_owned();
    fs::create_dir(at("a")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
    for (data, cache) in [("a", "a"), ("a", "a/cache"), ("a/data", "a"), ("link", "a"), ("a", "link/cache")] {
        let (code, said) = refused(&["--data", &at(data), "--cache", &at(cache)]);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("one is in the other"), "{said}");
    }
    assert_eq!(fs::read_dir(at("a")).unwrap().count(), 0, "nothing is left there");
    let service = Service::start(&["--data", &at("data"), "--cache", &at("cache")]);
    for (flag, folder) in [("--data", "data"), ("--cache", "cache")] {
        let (code, said) = refused(&[flag, &at(folder)]);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("Another process uses the folder"), "{said}");
    }
    drop(service);
    let (code, said) = refused(&["--data", &at("cache")]);
    assert_eq!((code, said.contains("another purpose (cache)")), (Some(2), true), "{said}");
}

#[test]
fn a_database_that_is_gone_empty_or_damaged_is_no_reason_to_remove_pictures() {
    let root = tempfile::tempdir().unwrap();
    let (data, copy) = (root.path().join("data"), root.path().join("copy"));
    let service = start(&data);
    let id = submit(&service, BALL, "");
    succeeded(&service, &id);
    let picture = service.get(&format!("/v1/jobs/{id}/image")).body;
    drop(service);
    let before = files(&data);
    let database = data.join("jobs.redb");
    let whole = fs::read(&database).unwrap();
    let used: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] != 0).collect();
    let flipped = (0..24).map(|number| {
        let mut bytes = whole.clone();
        bytes[used[used.len() * number / 24]] ^= 4;
        ("flipped", Some(bytes))
    });
    let others = [("gone", None), ("empty", Some(Vec::new())), ("half", Some(whole[..whole.len() / 2].to_vec()))];
    let mut refusals = 0;
    for (what, bytes) in others.into_iter().chain(flipped) {
        let _ = fs::remove_dir_all(&copy);
        for (path, contents) in before.iter().filter(|(path, _)| **path != database) {
            let path = copy.join(path.strip_prefix(&data).unwrap());
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, contents).unwrap();
        }
        if let Some(bytes) = bytes {
            fs::write(copy.join("jobs.redb"), bytes).unwrap();
        }
        match Service::try_start(&["--data", copy.to_str().unwrap()]) {
            Err((code, said)) => {
                refusals += 1;
                assert_eq!(code, Some(1), "{what}: {said}");
                assert!(said.contains("Restore jobs.redb") && !said.contains("panicked"), "{what}: {said}");
                assert!(!said.contains("Another process"), "{what}: {said}");
            }
            // What was flipped may be a part of the file that nothing needs, or of its last change, which then was not made.
            Ok(service) => {
                assert_eq!(what, "flipped");
                succeeded(&service, &id);
                assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, picture, "{}", service.log());
            }
        }
        assert_eq!(names(&copy, "pictures"), names(&data, "pictures"), "{what}");
        assert_eq!(names(&copy, "scenes"), names(&data, "scenes"), "{what}");
    }
    assert!(refusals >= 3, "{refusals}");
    let service = start(&data);
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, picture, "it is all there still");
}

#[test]
fn an_older_copy_of_the_database_removes_nothing_before_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    drop(start(data));
    let older = fs::read(data.join("jobs.redb")).unwrap();
    let service = start(data);
    let id = submit(&service, BALL, "");
    succeeded(&service, &id);
    drop(service);
    let newer = fs::read(data.join("jobs.redb")).unwrap();
    let kept = (names(data, "scenes"), names(data, "pictures"));

    fs::write(data.join("jobs.redb"), older).unwrap();
    let service = start(data);
    service.get(&format!("/v1/jobs/{id}")).problem(404, "not-found");
    service.wait_for_log("files that no job needs");
    drop(service);
    assert_eq!((names(data, "scenes"), names(data, "pictures")), kept);
    fs::write(data.join("jobs.redb"), newer).unwrap();
    succeeded(&start(data), &id);
}

#[test]
fn files_that_no_job_needs_go_where_there_is_no_room() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    drop(start(data));
    let older = fs::read(data.join("jobs.redb")).unwrap();
    let service = start(data);
    let large = r#""settings": { "width": 200, "height": 150 }, "output": { "format": "pfm" }"#;
    succeeded(&service, &submit(&service, BALL, large));
    drop(service);
    let large = names(data, "pictures");
    fs::write(data.join("jobs.redb"), older).unwrap();
    let service = Service::start(&["--data", data.to_str().unwrap(), "--data-bytes", "450000"]);
    succeeded(&service, &submit(&service, BALL, ""));
    assert!(large.iter().all(|name| !names(data, "pictures").contains(name)), "{large:?}");
}

/// What there is to spoil: one picture in each folder, a small one, and the texts of their scenes.
struct Served {
    data: PathBuf,
    cache: PathBuf,
    /// What is asked for, and the right answer.
    answers: Vec<(String, Vec<u8>)>,
}

impl Served {
    fn new(root: &Path) -> Self {
        let (data, cache) = (root.join("data"), root.join("cache"));
        let service = Self::start(&data, &cache);
        let id = submit(&service, BALL, r#""settings": { "width": 120, "height": 80 }"#);
        let image = succeeded(&service, &id)["links"]["picture"].as_str().unwrap().to_owned();
        let known = service.post_json("/v1/scenes", BALL).json();
        let links = ["self"].map(|link| text(&known["links"][link]).to_owned());
        let paths = [
            format!("/v1/jobs/{id}/image"),
            image,
            format!("/v1/jobs/{id}/preview"),
            format!("/v1/jobs/{id}/tile?x=10&y=10&w=20&h=20"),
            format!("/v1/images/{}.png", text(&known["image_id"])),
            links[0].clone(),
        ];
        let answers = paths.map(|path| {
            let answer = service.get(&path);
            assert_eq!(answer.status, 200, "{path}: {}", answer.text());
            (path, answer.body)
        });
        Self { data, cache, answers: answers.into() }
    }

    fn start(data: &Path, cache: &Path) -> Service {
        Service::start(&["--data", data.to_str().unwrap(), "--cache", cache.to_str().unwrap()])
    }
}

#[test]
fn what_is_spoilt_on_disk_is_never_given_out() {
    let root = tempfile::tempdir().unwrap();
    let served = Served::new(root.path());
    let before: BTreeMap<_, _> = files(&served.data).into_iter().chain(files(&served.cache)).collect();
    let spoilable =
        before.iter().filter(|(path, _)| !path.ends_with("jobs.redb") && !path.ends_with("strahl-folder.toml"));
    let spoilable: Vec<_> = spoilable.collect();
    assert_eq!(spoilable.len(), 7, "three pictures, a small one, two scenes and a claim: {:?}", before.keys());
    for (path, whole) in spoilable {
        let flip = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            bytes
        };
        let last = whole.len() - 1;
        let cut = whole[..whole.len() / 2].to_vec();
        let longer = [&whole[..], b"more"].concat();
        for spoilt in [flip(0), flip(70), flip(whole.len() / 2), flip(last), cut, Vec::new(), longer] {
            fs::write(path, spoilt).unwrap();
            let service = Served::start(&served.data, &served.cache);
            for (asked, right) in &served.answers {
                let answer = service.get(asked);
                if answer.status == 200 {
                    assert_eq!(&answer.body, right, "{asked} with {} spoilt", path.display());
                } else {
                    // A scene cannot be made again. Whoever has it may send it again.
                    assert!(
                        path.starts_with(served.cache.join("scenes")) || path.starts_with(served.data.join("scenes"))
                    );
                    assert!(matches!(answer.status, 404 | 410), "{asked}: {}", answer.text());
                }
                let digest = answer.header("repr-digest");
                if !digest.is_empty() {
                    let sha256 = data_encoding::BASE64.encode(&Sha256::digest(right));
                    assert_eq!(digest, format!("sha-256=:{sha256}:"));
                }
            }
            let again = service.post_json("/v1/render?width=120&height=80", BALL);
            assert_eq!(again.body, served.answers[0].1, "the same picture for somebody who sends the scene");
            // Nobody has asked for the claim.
            if !path.to_string_lossy().ends_with(".anonymous") {
                service.wait_for_log("damaged");
            }
            drop(service);
            before.iter().for_each(|(path, whole)| fs::write(path, whole).unwrap());
        }
    }
}

#[test]
fn a_picture_that_cannot_be_made_again_is_gone_when_its_file_is_spoilt() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    let service = start(data);
    let in_time = r#""settings": { "accuracy": "time:20" }"#;
    let id = submit(&service, BALL, in_time);
    succeeded(&service, &id);
    let picture = data.join("pictures").join(&id);
    drop(service);
    let mut bytes = fs::read(&picture).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&picture, bytes).unwrap();
    let service = start(data);
    let problem = service.get(&format!("/v1/jobs/{id}/image")).problem(410, "gone");
    assert!(text(&problem["detail"]).contains("damaged") && text(&problem["detail"]).contains("submit"), "{problem}");
}

#[test]
fn spoilt_tiles_are_rendered_again() {
    let folder = tempfile::tempdir().unwrap();
    let service = start(folder.path());
    let id = submit(&service, &mirrors(), LONG);
    until(&service, &id, |job| job["progress"]["tiles_done"].as_u64() >= Some(4));
    drop(service);
    let tiles = folder.path().join("tiles").join(&id);
    let mut bytes = fs::read(&tiles).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&tiles, bytes).unwrap();
    let service = start(folder.path());
    assert!(succeeded(&service, &id)["stats"]["tiles_recovered"].as_u64() >= Some(1));
    let alone = Service::start(&[]).post_json("/v1/render?width=384&height=384&samples=4", &mirrors());
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, alone.body);
    service.wait_for_log("rendered again");
}

#[test]
fn a_waiting_job_whose_scene_is_spoilt_says_so_and_can_be_sent_again() {
    for is_removed in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let service = start(folder.path());
        for _ in 0..2 {
            submit(&service, SLOW, r#""settings": { "width": 1024, "height": 1024, "samples": 8 }"#);
        }
        let id = submit(&service, BALL, "");
        let scene = names(folder.path(), "scenes").into_iter().map(|name| folder.path().join("scenes").join(name));
        let scene = scene.min_by_key(|path| fs::read(path).unwrap().windows(6).all(|six| six != b"sphere")).unwrap();
        drop(service);
        let mut bytes = fs::read(&scene).unwrap();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        if is_removed { fs::remove_file(&scene) } else { fs::write(&scene, bytes) }.unwrap();
        let service = start(folder.path());
        let all = service.get("/v1/jobs").json();
        for slow in all["jobs"].as_array().unwrap().iter().filter(|job| job["id"] != id.as_str()) {
            service.send("POST", &format!("/v1/jobs/{}/cancel", text(&slow["id"])), &[], b"");
        }
        let failed = ended(&service, &id);
        assert_eq!(failed["state"], "failed");
        let problem = &failed["problem"];
        assert!(text(&problem["type"]).ends_with("/problems/gone"), "{failed}");
        assert!(text(&problem["detail"]).contains("the scene of this job is damaged or gone; submit"), "{failed}");
        succeeded(&service, &submit(&service, BALL, ""));
    }
}

#[test]
fn jobs_with_one_picture_share_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let service = start(folder.path());
    let ids: Vec<String> = (0..5)
        .map(|_| {
            let id = submit(&service, BALL, "");
            succeeded(&service, &id);
            id
        })
        .collect();
    assert_eq!(job(&service, &ids[4])["stats"]["reused"], true);
    assert_eq!(names(folder.path(), "pictures").len(), 2, "the picture and the small one");
    let picture = service.get(&format!("/v1/jobs/{}/image", ids[0])).body;
    for id in &ids[..4] {
        assert_eq!(service.send("DELETE", &format!("/v1/jobs/{id}"), &[], b"").status, 204);
    }
    assert_eq!(service.get(&format!("/v1/jobs/{}/image", ids[4])).body, picture);
    service.send("DELETE", &format!("/v1/jobs/{}", ids[4]), &[], b"");
    assert_eq!((names(folder.path(), "pictures").len(), names(folder.path(), "scenes").len()), (0, 0));
}

#[test]
fn a_folder_of_a_version_without_markers_is_taken_over() {
    let root = tempfile::tempdir().unwrap();
    let served = Served::new(root.path());
    let contents = |path: &Path| {
        let bytes = fs::read(path).unwrap();
        let head = u64::from_le_bytes(bytes[64..72].try_into().unwrap()) as usize;
        (bytes[72..72 + head].to_vec(), bytes[72 + head..].to_vec())
    };
    // As it was written then: a digest of the contents in scenes, none in pictures, and a folder for each job.
    let id = served.answers[0].0.split('/').nth(3).unwrap();
    let old = served.data.join("jobs").join(id);
    fs::create_dir_all(&old).unwrap();
    for name in names(&served.data, "pictures") {
        let (head, body) = contents(&served.data.join("pictures").join(&name));
        match name.ends_with(".preview") {
            true => fs::write(old.join("preview"), body).unwrap(),
            false => fs::write(old.join("picture"), [&head[..], b"\n", &body].concat()).unwrap(),
        }
    }
    for folder in [&served.data, &served.cache] {
        for path in names(folder, "scenes").iter().map(|name| folder.join("scenes").join(name)) {
            let (_, body) = contents(&path);
            fs::write(path, [&Sha256::digest(&body)[..], &body].concat()).unwrap();
        }
        fs::remove_file(folder.join("strahl-folder.toml")).unwrap();
    }
    fs::remove_dir_all(served.data.join("pictures")).unwrap();
    fs::remove_dir(served.data.join("tiles")).unwrap();

    for _ in 0..2 {
        let service = Served::start(&served.data, &served.cache);
        for (path, right) in &served.answers {
            assert_eq!(&service.get(path).body, right, "{path}");
        }
        assert!(!service.log().contains("damaged"), "{}", service.log());
        assert!(!served.data.join("jobs").exists());
    }
}
