//! Markdown as far as the documents use it: fenced blocks, inline code, links and headings.

use std::path::{Path, PathBuf};

/// One document.
#[derive(Debug)]
pub(super) struct Page {
    /// The file, as seen from the repository.
    pub(super) path: String,
    pub(super) lines: usize,
    pub(super) blocks: Vec<Block>,
    /// Everything outside of fenced blocks, line by line.
    pub(super) prose: Vec<(usize, String)>,
}

/// A fenced block.
#[derive(Debug)]
pub(super) struct Block {
    /// Where it begins: file and line.
    pub(super) place: String,
    /// The first word after the fence.
    pub(super) language: String,
    /// The others: what the tests should do with it.
    pub(super) marks: Vec<String>,
    pub(super) lines: Vec<String>,
}

impl Block {
    pub(super) fn is_marked(&self, mark: &str) -> bool {
        self.marks.iter().any(|own| own == mark)
    }

    pub(super) fn text(&self) -> String {
        self.lines.iter().map(|line| format!("{line}\n")).collect()
    }
}

/// The repository.
pub(super) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All pages of the book, and the README.
pub(super) fn book() -> Vec<Page> {
    let mut names = vec!["README.md".to_owned()];
    for file in std::fs::read_dir(root().join("docs")).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_some_and(|e| e == "md") {
            names.push(format!("docs/{}", path.file_name().unwrap().to_str().unwrap()));
        }
    }
    names.sort();
    assert!(names.len() >= 9, "the book has gone: {names:?}");
    names.iter().map(|name| Page::read(name)).collect()
}

/// The book and the documents for developers.
pub(super) fn documents() -> Vec<Page> {
    let others = ["ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "api/DECISIONS.md", "src/DECISIONS.md"];
    book().into_iter().chain(others.map(Page::read)).collect()
}

impl Page {
    fn read(path: &str) -> Self {
        let text = std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut page = Self { path: path.to_owned(), lines: text.lines().count(), blocks: vec![], prose: vec![] };
        let mut open: Option<(usize, Block)> = None;
        for (number, line) in (1..).zip(text.lines()) {
            let bare = line.trim_start();
            match (open.take(), bare.strip_prefix("```")) {
                (None, Some(info)) => {
                    let mut words = info.split_whitespace().map(str::to_owned);
                    let block = Block {
                        place: format!("{path}:{number}"),
                        language: words.next().unwrap_or_default(),
                        marks: words.collect(),
                        lines: Vec::new(),
                    };
                    open = Some((line.len() - bare.len(), block));
                }
                (None, None) => page.prose.push((number, line.to_owned())),
                (Some((_, block)), Some(_)) => page.blocks.push(block),
                (Some((indent, mut block)), None) => {
                    block.lines.push(line.get(indent..).unwrap_or(bare).to_owned());
                    open = Some((indent, block));
                }
            }
        }
        assert!(open.is_none(), "{path}: a fence is never closed");
        page
    }

    /// What stands between backticks, with its place.
    pub(super) fn inline_code(&self) -> impl Iterator<Item = (String, &str)> {
        self.prose.iter().flat_map(|(number, line)| {
            let place = format!("{}:{number}", self.path);
            line.split('`').skip(1).step_by(2).map(move |code| (place.clone(), code))
        })
    }

    /// The targets of links and pictures, with their places.
    pub(super) fn links(&self) -> impl Iterator<Item = (String, &str)> {
        self.prose.iter().flat_map(|(number, line)| {
            let place = format!("{}:{number}", self.path);
            line.split("](")
                .skip(1)
                .filter_map(|rest| rest.split(')').next())
                .map(move |target| (place.clone(), target))
        })
    }

    /// The folder that links start from.
    pub(super) fn folder(&self) -> PathBuf {
        root().join(Path::new(&self.path).parent().unwrap())
    }

    /// The names under which headings can be linked to.
    pub(super) fn anchors(&self) -> Vec<String> {
        let headings = self.prose.iter().filter_map(|(_, line)| line.strip_prefix('#'));
        let name = |heading: &str| {
            let kept = heading.trim_start_matches('#').trim().to_lowercase();
            kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
        };
        headings.map(name).collect()
    }
}
