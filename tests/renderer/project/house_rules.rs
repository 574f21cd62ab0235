//! The house rules that a compiler does not check.

use crate::common::{read, root};
use std::path::{Path, PathBuf};

fn rust_files(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

pub(super) fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    rust_files(&root().join(folder), &mut files);
    assert!(!files.is_empty());
    files.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn the_renderer_knows_no_network_no_runtime_and_no_environment() {
    for (path, text) in sources("src") {
        for word in ["axum", "tokio", "hyper", "tower", "clap", "std::env", "std::net", "std::fs", "tracing"] {
            let used = text.lines().any(|line| {
                let code = line.split("//").next().unwrap_or("");
                code.contains(&format!("{word}::")) || code.contains(&format!("use {word}"))
            });
            assert!(!used, "{} uses {word}", path.display());
        }
    }
}

#[test]
fn the_reference_shares_no_intersection_or_shading_code() {
    for (path, text) in sources("src/reference") {
        for module in ["accel", "shape", "shading", "trace", "lanes", "camera", "render", "ray"] {
            assert!(!text.contains(&format!("crate::{module}")), "{} uses crate::{module}", path.display());
        }
    }
}

#[test]
fn every_file_says_what_it_is() {
    for folder in ["src", "api", "tests", "benches"] {
        for (path, text) in sources(folder) {
            assert!(text.starts_with("//!"), "{} has no first line that says what it is", path.display());
        }
    }
}

#[test]
fn the_schema_in_the_repository_is_the_one_in_the_code() {
    let text = strahl::scene::schema::schema_text();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(root().join("api/scene.schema.json"), &text).unwrap();
    }
    let stored = String::from_utf8(read("api/scene.schema.json")).unwrap();
    assert!(stored == text, "api/scene.schema.json has drifted: `strahl schema > api/scene.schema.json`");
}

#[test]
fn every_scene_names_the_schema() {
    for name in crate::common::scene_names() {
        let scene: serde_json::Value = serde_json::from_slice(&read(&format!("scenes/{name}.json"))).unwrap();
        assert_eq!(scene["$schema"], "../../api/scene.schema.json", "{name}");
    }
}

/// What robustness costs is measured against these (`benches/naive/compare.py`).
#[test]
fn every_naive_patch_still_applies_alone_and_with_the_others() {
    let mut patches: Vec<PathBuf> = std::fs::read_dir(root().join("benches/naive"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "patch"))
        .collect();
    patches.sort();
    assert!(patches.len() >= 5, "the patches have gone: {patches:?}");
    let check = |patches: &[PathBuf]| {
        let git = std::process::Command::new("git")
            .args(["apply", "--check"])
            .args(patches)
            .current_dir(root())
            // A repository around this folder is none of ours: git would look for the files there.
            .env("GIT_CEILING_DIRECTORIES", root().parent().unwrap())
            .output()
            .unwrap_or_else(|error| panic!("this test needs git, which applies patches: {error}"));
        let said = String::from_utf8_lossy(&git.stderr);
        assert!(git.status.success(), "make these patches again, the code below them has changed: {patches:?}\n{said}");
    };
    for patch in &patches {
        check(std::slice::from_ref(patch));
    }
    check(&patches);
}
