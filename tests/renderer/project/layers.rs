//! Imports point downwards: the layers of the library from the bottom up, and no folder in a cycle of imports.

use super::house_rules::sources;
use crate::common::root;
use std::collections::{BTreeMap, BTreeSet};

/// The modules that a table of ARCHITECTURE.md lists below a heading, from the bottom up.
fn layers_below(heading: &str) -> Vec<String> {
    let map = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, table) = map.split_once(&format!("| {heading} | What |\n|---|---|\n")).expect(heading);
    let cells = table.lines().map_while(|row| row.strip_prefix("| ")?.split(" |").next());
    let mut layers: Vec<String> =
        cells.flat_map(|cell| cell.split(", ")).map(|name| name.trim_matches('`').to_owned()).collect();
    layers.reverse();
    layers
}

/// Checks that the map lists all modules of a folder, and that none imports one above it.
fn assert_downwards(source: &Source, heading: &str) {
    let layers = layers_below(heading);
    let layers: Vec<&str> = layers.iter().map(String::as_str).collect();
    let modules: BTreeSet<_> = source.files.keys().map(|module| module[0].as_str()).collect();
    assert_eq!(modules, layers.iter().copied().collect(), "each module has its place below \"{heading}\"");
    assert_eq!(source.upward(&layers), [""; 0], "{heading}");
}

#[test]
fn the_library_imports_downwards_only() {
    assert_downwards(&Source::read("src"), "Module of `src`");
}

#[test]
fn no_folder_of_the_library_is_in_a_cycle() {
    assert_eq!(Source::read("src").folder_cycles(), [""; 0]);
}

#[test]
fn the_program_imports_downwards_only() {
    let program = Source::read("api");
    for (folder, heading) in [("", "Module of `api`"), ("http", "Module of `http`"), ("service", "Module of `service`")]
    {
        assert_downwards(&program.folder(folder), heading);
    }
    assert_eq!(program.folder_cycles(), [""; 0]);
}

#[test]
fn routes_do_not_import_each_other() {
    let routes = Source::read("api").folder("http").folder("routes");
    let others: Vec<_> = routes.imports().filter(|(from, to)| from[0] != to[0]).collect();
    assert!(others.is_empty(), "{others:?}");
}

#[test]
fn only_serve_and_what_makes_its_files_starts_http() {
    let program = Source::read("api");
    let from: BTreeSet<_> = program.imports().filter(|(from, to)| from[0] == "cli" && to[0] == "http").collect();
    let from: BTreeSet<_> = from.into_iter().map(|(from, _)| from[1].as_str()).collect();
    assert_eq!(from, BTreeSet::from(["key", "openapi", "serve"]));
}

#[test]
fn violations_are_found() {
    let source = Source::of(&[
        ("math.rs", "use std::f64;\nuse crate::scene::limits::{self, MAX};\n"),
        ("scene/mod.rs", "pub use load::load;"),
        ("scene/limits.rs", "//! Like [`x`](crate::trace::x).\n#[cfg(test)]\nmod tests {\n    use crate::trace;\n}\n"),
        ("scene/load.rs", "fn load() { super::read::all(crate::math::PI) }"),
        ("scene/read/mod.rs", "mod words;"),
        ("scene/read/words.rs", "use {crate::{math, scene::{load::load as l, limits}}, std::fs};"),
        ("trace.rs", "use crate::math;"),
    ]);
    assert_eq!(source.upward(&["math", "scene", "trace"]), ["math imports scene::limits"]);
    assert_eq!(source.folder_cycles(), ["math.rs, scene/", "scene/load.rs, scene/read/"]);
}

/// The modules of a crate and what they import of it.
struct Source {
    /// The paths of the imported modules, by the path of the module that imports them; `crate` itself is left out.
    files: BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
    /// Modules that are folders.
    folders: BTreeSet<Vec<String>>,
}

impl Source {
    fn read(folder: &str) -> Self {
        let base = root().join(folder);
        let files: Vec<(String, String)> = sources(folder)
            .into_iter()
            .map(|(path, text)| (path.strip_prefix(&base).unwrap().to_str().unwrap().to_owned(), text))
            .collect();
        Self::of(&files)
    }

    fn of<P: AsRef<str>, T: AsRef<str>>(files: &[(P, T)]) -> Self {
        let mut texts = BTreeMap::new();
        let mut folders = BTreeSet::new();
        for (path, text) in files {
            let mut module: Vec<String> = path.as_ref().trim_end_matches(".rs").split('/').map(str::to_owned).collect();
            match module.last().map(String::as_str) {
                // The roots of crates name modules, and tests are above all layers.
                Some("lib" | "main" | "tests") => continue,
                Some(name) if name.ends_with("_tests") => continue,
                Some("mod") => {
                    module.pop();
                    folders.insert(module.clone());
                }
                _ => {}
            }
            texts.insert(module, text.as_ref());
        }
        let imports = |module: &Vec<String>, text: &str| -> BTreeSet<Vec<String>> {
            let known = |path: Vec<String>| {
                let end = (1..=path.len()).rev().find(|end| texts.contains_key(&path[..*end]))?;
                Some(path[..end].to_vec())
            };
            paths(text, module).into_iter().filter_map(known).filter(|to| to != module).collect()
        };
        let files = texts.iter().map(|(module, text)| (module.clone(), imports(module, text))).collect();
        Self { files, folders }
    }

    /// What is in a folder, as if it were all there is.
    fn folder(&self, name: &str) -> Self {
        if name.is_empty() {
            return Self { files: self.files.clone(), folders: self.folders.clone() };
        }
        let inside = |module: &Vec<String>| (module.len() > 1 && module[0] == name).then(|| module[1..].to_vec());
        let files =
            self.files.iter().filter_map(|(from, to)| Some((inside(from)?, to.iter().filter_map(inside).collect())));
        Self { files: files.collect(), folders: self.folders.iter().filter_map(inside).collect() }
    }

    fn imports(&self) -> impl Iterator<Item = (&Vec<String>, &Vec<String>)> {
        self.files.iter().flat_map(|(from, all)| all.iter().map(move |to| (from, to)))
    }

    /// Imports of a layer that is not below.
    fn upward(&self, layers: &[&str]) -> Vec<String> {
        let layer = |module: &[String]| layers.iter().position(|layer| *layer == module[0]);
        self.imports()
            .filter(|(from, to)| from[0] != to[0] && layer(from) <= layer(to))
            .map(|(from, to)| format!("{} imports {}", from.join("::"), to.join("::")))
            .collect()
    }

    /// Neighbours in a folder that import each other in a circle, at least one of which is a folder itself.
    fn folder_cycles(&self) -> Vec<String> {
        let mut neighbours: BTreeMap<&[String], BTreeSet<&[String]>> = BTreeMap::new();
        for (from, to) in self.imports() {
            let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
            // What a folder's own file says is no neighbour of what is in the folder.
            if common < from.len() && common < to.len() {
                neighbours.entry(&from[..=common]).or_default().insert(&to[..=common]);
            }
        }
        let mut cycles = BTreeSet::new();
        for folder in neighbours.keys().filter(|module| self.folders.contains(**module)) {
            let circle: BTreeSet<String> = (neighbours.keys())
                .filter(|other| reaches(&neighbours, folder, other) && reaches(&neighbours, other, folder))
                .map(|module| module.join("/") + if self.folders.contains(*module) { "/" } else { ".rs" })
                .collect();
            if !circle.is_empty() {
                cycles.insert(circle.into_iter().collect::<Vec<_>>().join(", "));
            }
        }
        cycles.into_iter().collect()
    }
}

/// Whether imports lead from one module to another.
fn reaches(imports: &BTreeMap<&[String], BTreeSet<&[String]>>, from: &[String], to: &[String]) -> bool {
    let (mut open, mut seen) = (vec![from], BTreeSet::new());
    while let Some(module) = open.pop() {
        for next in imports.get(module).into_iter().flatten() {
            if *next == to {
                return true;
            }
            if seen.insert(*next) {
                open.push(next);
            }
        }
    }
    false
}

/// The paths that the code of a module names which begin with `crate` or `super`, without comments and tests.
fn paths(text: &str, module: &[String]) -> Vec<Vec<String>> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code: String = code.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n");
    let mut paths = Vec::new();
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            let before = code[..at].chars().next_back();
            if before.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':') {
                tree(&mut code[at..].chars().peekable(), &mut Vec::new(), &mut paths);
            }
        }
    }
    paths.into_iter().map(|path| absolute(&path, module)).collect()
}

/// Reads one tree of paths, like `a::{b, c::d}`.
fn tree(code: &mut std::iter::Peekable<std::str::Chars<'_>>, prefix: &mut Vec<String>, paths: &mut Vec<Vec<String>>) {
    let length = prefix.len();
    let skip =
        |code: &mut std::iter::Peekable<std::str::Chars<'_>>| while code.next_if(|c| c.is_whitespace()).is_some() {};
    loop {
        skip(code);
        if code.next_if_eq(&'{').is_some() {
            loop {
                tree(code, prefix, paths);
                skip(code);
                if code.next_if_eq(&',').is_none() {
                    code.next_if_eq(&'}');
                    break;
                }
            }
            break;
        }
        let mut name = String::new();
        while let Some(c) = code.next_if(|c| c.is_alphanumeric() || *c == '_') {
            name.push(c);
        }
        if !name.is_empty() {
            prefix.push(name);
        }
        let mut rest = code.clone();
        if (rest.next(), rest.next()) == (Some(':'), Some(':')) {
            *code = rest;
            continue;
        }
        paths.push(prefix.clone());
        // A new name for it.
        while code.next_if(|c| c.is_alphanumeric() || *c == '_' || *c == ' ').is_some() {}
        break;
    }
    prefix.truncate(length);
}

fn absolute(path: &[String], module: &[String]) -> Vec<String> {
    let up = path.iter().take_while(|name| *name == "super").count();
    let base = if path[0] == "crate" { &[] } else { &module[..module.len().saturating_sub(up)] };
    base.iter().chain(path[up.max(1)..].iter()).filter(|name| *name != "self").cloned().collect()
}
