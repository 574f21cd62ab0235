//! The files that deploy a farm name commands, flags, variables and ports that the program has.

use super::pages::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// All files of `deploy/`, and the Dockerfile, with their texts.
fn files() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, to: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { walk(&path, to) } else { to.push(path) }
        }
    }
    let mut paths = vec![root().join("Dockerfile")];
    walk(&root().join("deploy"), &mut paths);
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

fn help(command: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_strahl")).args(command).arg("--help").output().unwrap();
    assert!(output.status.success(), "{command:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The words of a text that begin with a prefix and go on with letters of a kind.
fn words<'a>(text: &'a str, prefix: &str, is_part: fn(u8) -> bool) -> BTreeSet<&'a str> {
    let word = |(at, _)| {
        let rest = &text[at..];
        let end = rest.bytes().position(|b| !is_part(b)).unwrap_or(rest.len());
        rest[..end].trim_end_matches(['_', '-'])
    };
    text.match_indices(prefix).map(word).collect()
}

/// The commands of the program in a file: lists that begin with one.
fn commands(text: &str) -> Vec<Vec<&str>> {
    let lists = text.match_indices('[').filter_map(|(at, _)| Some(&text[at + 1..at + text[at..].find(']')?]));
    let words = lists.map(|list| list.split(',').map(|word| word.trim().trim_matches('"')).collect::<Vec<_>>());
    let is_one =
        |words: &Vec<&str>| matches!(words[..], ["serve" | "node" | "healthcheck", ..] | ["farm", "accounts", ..]);
    words.filter(is_one).collect()
}

#[test]
fn deployments_use_flags_that_there_are() {
    let mut seen = BTreeSet::new();
    for (path, text) in files() {
        for words in commands(&text) {
            let command = if words[0] == "farm" { &words[..2] } else { &words[..1] };
            let help = help(command);
            let flags = words.iter().filter(|word| word.starts_with("--"));
            for flag in flags {
                let is_there = help.split([' ', '\n', ',', '=']).any(|word| word == *flag);
                assert!(is_there, "{}: {command:?} has no {flag}", path.display());
            }
            seen.insert(words[0].to_owned());
        }
    }
    assert_eq!(seen, BTreeSet::from(["farm", "node", "serve"].map(str::to_owned)));
}

#[test]
fn deployments_use_variables_that_there_are() {
    let is_part = |b: u8| b.is_ascii_uppercase() || b == b'_';
    let known = [help(&["serve"]), help(&["node"])].concat();
    // The image's tag is a variable of the compose file.
    let known: BTreeSet<&str> = words(&known, "STRAHL_", is_part).into_iter().chain(["STRAHL_VERSION"]).collect();
    let mut seen = 0;
    for (path, text) in files() {
        for name in words(&text, "STRAHL_", is_part) {
            assert!(known.contains(name), "{}: there is no {name}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
}

#[test]
fn images_have_versions() {
    for (path, text) in files() {
        for line in text.lines().filter_map(|line| line.trim_start().trim_start_matches("- ").strip_prefix("image: ")) {
            let is_inline = line.starts_with('{') && line.contains("tag: ");
            // Overlays give the program's image its version.
            let has_version = line == "strahl" || line.rsplit('/').next().is_some_and(|name| name.contains(':'));
            assert!((has_version || is_inline) && !line.contains("latest"), "{}: {line}", path.display());
        }
    }
}

#[test]
fn ports_of_pods_are_those_that_the_program_listens_on() {
    let front = std::fs::read_to_string(root().join("deploy/kubernetes/base/front.yaml")).unwrap();
    let command = commands(&front).into_iter().find(|words| words[0] == "serve").unwrap();
    let port = |flag: &str| {
        let at = command.iter().position(|word| *word == flag).unwrap();
        command[at + 1].rsplit(':').next().unwrap().to_owned()
    };
    let said: BTreeMap<&str, &str> = (front.lines())
        .filter_map(|line| line.trim().strip_prefix("- {name: ")?.strip_suffix('}')?.split_once(", containerPort: "))
        .collect();
    assert_eq!(said, BTreeMap::from([("http", &*port("--listen")), ("admin", &*port("--admin-listen"))]));
    let network = std::fs::read_to_string(root().join("deploy/kubernetes/base/network.yaml")).unwrap();
    for port in said.values() {
        assert!(network.contains(&format!("port: {port}}}")), "a policy lets {port} through");
    }
}
