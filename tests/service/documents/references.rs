//! What the documents name exists: files, headings, routes with their parameters, flags.

use super::pages::{Page, book, documents, root};
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

fn report(problems: Vec<String>) {
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn links_and_pictures_lead_somewhere() {
    let pages = documents();
    let problem = |page: &Page, place: String, target: &str| {
        if target.starts_with("https://") || target.starts_with("http://") {
            return None;
        }
        let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
        let path = if file.is_empty() { root().join(&page.path) } else { page.folder().join(file) };
        let Ok(path) = path.canonicalize() else { return Some(format!("{place}: there is no {target}")) };
        if page.path.starts_with("docs/") && !path.starts_with(root().join("docs").canonicalize().unwrap()) {
            return Some(format!("{place}: {target} is not part of the book"));
        }
        let is_page = |other: &&Page| root().join(&other.path).canonicalize().unwrap() == path;
        let missing = !anchor.is_empty()
            && !pages.iter().find(is_page).is_some_and(|other| other.anchors().iter().any(|own| own == anchor));
        missing.then(|| format!("{place}: {target} names no heading"))
    };
    report(
        pages
            .iter()
            .flat_map(|page| {
                page.links().filter_map(|(place, target)| problem(page, place, target)).collect::<Vec<_>>()
            })
            .collect(),
    );
}

#[test]
fn all_pages_are_in_the_summary() {
    let pages = book();
    let listed: BTreeSet<&str> =
        pages.iter().find(|page| page.path == "docs/SUMMARY.md").unwrap().links().map(|(_, target)| target).collect();
    let own = pages.iter().filter_map(|page| page.path.strip_prefix("docs/")).filter(|name| *name != "SUMMARY.md");
    assert_eq!(listed, own.collect());
}

#[test]
fn files_that_are_named_exist() {
    let folders = ["src/", "api/", "tests/", "benches/", "scenes/", "docs/", "examples/", ".ci/"];
    let mut problems = Vec::new();
    // The change log names what there was.
    for page in documents().iter().filter(|page| page.path != "CHANGELOG.md") {
        for (place, code) in page.inline_code() {
            let is_path = |word: &&str| folders.iter().any(|folder| word.starts_with(folder)) || word.ends_with(".rs");
            let Some(path) = code.split_whitespace().find(is_path) else { continue };
            // {a,b} and * stand for several files, NAME for the reader's.
            let path = path.split(['{', '*']).next().unwrap().split("NAME").next().unwrap();
            // Documents about the code name its files without their first folder.
            if ["", "src", "api"].iter().all(|folder| !root().join(folder).join(path).exists()) {
                problems.push(format!("{place}: there is no {path}"));
            }
        }
    }
    report(problems);
}

/// The routes of the contract: methods, path, names of query parameters.
fn routes() -> Vec<(BTreeSet<String>, String, BTreeSet<String>)> {
    let contract: Value = serde_json::from_slice(&std::fs::read(root().join("api/openapi.json")).unwrap()).unwrap();
    let paths = contract["paths"].as_object().unwrap();
    let route = |(path, item): (&String, &Value)| {
        let operations = item.as_object().unwrap();
        let parameters = operations.values().filter_map(|operation| operation["parameters"].as_array()).flatten();
        let query = parameters.filter(|one| one["in"] == "query").map(|one| one["name"].as_str().unwrap().to_owned());
        let mut methods: BTreeSet<String> = operations.keys().map(|method| method.to_uppercase()).collect();
        // OpenAPI 3.1 has no place for QUERY, which is answered where POST is.
        if methods.contains("POST") {
            methods.insert("QUERY".to_owned());
        }
        (methods, path.clone(), query.collect())
    };
    paths.iter().map(route).collect()
}

/// Whether a path is one of a route: `{id}` stands for a segment or the start of one, in both.
fn is_path(path: &str, route: &str) -> bool {
    let (path, route): (Vec<&str>, Vec<&str>) = (path.split('/').collect(), route.split('/').collect());
    let fits = |(own, theirs): (&&str, &&str)| own == theirs || theirs.starts_with('{');
    path.len() == route.len() && path.iter().zip(&route).all(fits)
}

#[test]
fn requests_that_are_named_are_in_the_contract() {
    let routes = routes();
    let mut problems = Vec::new();
    for page in book() {
        for (place, code) in page.inline_code() {
            let (method, target) = match code.split_once(' ') {
                Some((method, target)) if ["GET", "POST", "QUERY", "PATCH", "DELETE"].contains(&method) => {
                    (Some(method), target)
                }
                _ => (None, code),
            };
            let is_target = target.starts_with("/v1/") || (method.is_some() && target.starts_with('/'));
            if !is_target || target.contains("...") {
                continue;
            }
            let (path, query) = target.split_once('?').unwrap_or((target, ""));
            let found = routes.iter().find(|(methods, route, _)| {
                is_path(path, route) && method.is_none_or(|method| methods.contains(method))
            });
            match found {
                // A page may name a group of routes by what they begin with.
                None if method.is_none() && routes.iter().any(|(_, route, _)| route.starts_with(path)) => {}
                None => problems.push(format!("{place}: the contract has no {code}")),
                Some((_, _, parameters)) => problems.extend(
                    query
                        .split('&')
                        .filter_map(|pair| pair.split('=').next())
                        .filter(|name| !name.is_empty() && !parameters.contains(*name))
                        .map(|name| format!("{place}: {code}: there is no parameter {name}")),
                ),
            }
        }
    }
    report(problems);
}

#[test]
fn flags_that_are_named_exist() {
    let help = |args: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let own = help(&["--help"]);
    let commands = own.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let mut pages = vec![help(&["key", "new", "--help"]), help(&["key", "signer", "--help"])];
    pages.extend(commands.filter_map(|line| line.split_whitespace().next()).map(|command| help(&[command, "--help"])));
    let is_part = |c: char| !(c.is_ascii_alphanumeric() || c == '-');
    let known: BTreeSet<&str> =
        pages.iter().flat_map(|text| text.split(is_part)).filter(|word| word.starts_with("--")).collect();
    assert!(known.contains("--max-depth") && known.contains("--drain-timeout"), "{known:?}");
    let mut problems = Vec::new();
    for page in book() {
        for (place, code) in
            page.inline_code().filter(|(_, code)| code.starts_with("strahl ") || code.starts_with("--"))
        {
            for flag in
                code.split(is_part).filter(|word| word.starts_with("--") && word.len() > 2 && !known.contains(word))
            {
                problems.push(format!("{place}: no command has {flag}"));
            }
        }
    }
    report(problems);
}

#[test]
fn recipes_that_are_named_exist() {
    let recipes = std::fs::read_to_string(root().join("justfile")).unwrap();
    let has =
        |name: &str| recipes.lines().any(|line| line.split([' ', ':']).next() == Some(name) && line.contains(':'));
    for page in documents() {
        for (place, code) in page.inline_code() {
            let recipe = code.strip_prefix("just ").and_then(|rest| rest.split(' ').next());
            assert!(recipe.is_none_or(has), "{place}: the justfile has no recipe of `{code}`");
        }
    }
}

#[test]
fn the_readme_is_short_and_shows_every_folder_of_scenes() {
    let pages = book();
    let readme = pages.iter().find(|page| page.path == "README.md").unwrap();
    assert!(readme.lines <= 150, "README.md has {} lines", readme.lines);
    for folder in std::fs::read_dir(root().join("scenes")).unwrap().map(|entry| entry.unwrap().path()) {
        let name = folder.file_name().unwrap().to_str().unwrap();
        let picture = format!("docs/pictures/{name}-");
        assert!(
            !folder.is_dir() || readme.links().any(|(_, target)| target.starts_with(&picture)),
            "no picture of {name}"
        );
    }
}
