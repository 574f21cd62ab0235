//! Folders of jobs with spoilt files: the service starts or says why not, and serves no wrong picture.

use super::requests::{SCENE, get, json, post, word};
use crate::http::in_process::InProcess;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The database is checked by redb, which panics at some of what is in it; the service does not stop because of that, but
/// fuzzers do.
const DATABASE: &str = "jobs.redb";

/// A folder with finished jobs: its files, their pictures, and what the jobs are called.
struct Template {
    files: Vec<(PathBuf, Vec<u8>)>,
    jobs: Vec<(String, Vec<u8>)>,
}

static TEMPLATE: LazyLock<Template> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("there is room");
    let service = open(folder.path()).expect("it starts");
    let jobs = ["png", "exr"].map(|format| {
        let job = format!(r#"{{ "scene": {SCENE}, "output": {{ "format": "{format}" }} }}"#);
        let job = word(&json(&service.ask(post("/v1/jobs", job))), "id");
        let ended = get(&format!("/v1/jobs/{job}"), ("Prefer", b"wait=20")).expect("a request");
        assert_eq!(json(&service.ask(ended))["state"], "succeeded");
        let picture = service.ask(get(&format!("/v1/jobs/{job}/image"), ("Accept", b"*/*")).expect("a request"));
        (job, picture.into_body())
    });
    drop(service);
    let mut files = Vec::new();
    collect(folder.path(), folder.path(), &mut files);
    files.sort();
    Template { files, jobs: jobs.into() }
});

/// Spoils a file, as the bytes say: which, where, how, and with what.
pub(super) fn folder(bytes: &[u8]) {
    let [which, how, a, b, rest @ ..] = bytes else { return };
    let folder = tempfile::tempdir().expect("there is room");
    let names = TEMPLATE.files.iter().map(|(name, _)| name).filter(|name| !name.ends_with(DATABASE));
    let spoilt = names.clone().nth(usize::from(*which) % names.count());
    for (name, contents) in &TEMPLATE.files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("it is in the folder")).expect("there is room");
        let mut contents = contents.clone();
        if Some(name) == spoilt {
            let at = usize::from(u16::from_le_bytes([*a, *b])) * (contents.len() + 1) / 65_536;
            match how % 4 {
                0 => contents.truncate(at),
                1 => contents.extend(rest),
                2 => contents.iter_mut().skip(at).zip(rest).for_each(|(old, new)| *old ^= new),
                _ => drop(contents.splice(at.., rest.iter().copied())),
            }
        }
        fs::write(path, contents).expect("there is room");
    }
    let Some(service) = open(folder.path()) else { return };
    for (job, picture) in &TEMPLATE.jobs {
        let answer = service.ask(get(&format!("/v1/jobs/{job}/image"), ("Accept", b"*/*")).expect("a request"));
        assert!(answer.status() != 200 || answer.body() == picture, "a wrong picture: {spoilt:?}");
    }
}

fn open(folder: &Path) -> Option<InProcess> {
    InProcess::start(&["--data", folder.to_str().expect("text")]).ok()
}

/// The files of a folder and what is in them.
fn collect(base: &Path, folder: &Path, into: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("a file").path();
        match path.is_dir() {
            true => collect(base, &path, into),
            false => into.push((path.strip_prefix(base).expect("inside").to_owned(), fs::read(&path).expect("a file"))),
        }
    }
}
