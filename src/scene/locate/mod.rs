//! Places in a scene's text: from JSON pointers to lines and columns, and back.
//!
//! One pass of a scanner locates any number of them.

mod scanner;

use super::limits::PROBLEMS_FOUND;
use super::problem::{Code, Problem, push_token};
use crate::control;
use scanner::{Event, Scanner, Token};
use std::collections::{HashMap, HashSet};
use std::fmt;

/// Bytes of a pointer. Those into a scene whose names are short enough have about 1,300 at most; of longer ones the last tokens
/// are left out.
const POINTER_BYTES: usize = 2_048;

/// Gives every problem without a line the line and column of the value of its pointer, or of the key itself where the key
/// is the problem. Where there is no such value, it takes the innermost existing one around it.
pub fn locate(text: &[u8], problems: &mut [Problem]) {
    let mut tree = Tree::default();
    let targets: Vec<(usize, usize)> = (0..problems.len())
        .filter(|&i| problems[i].line.is_none())
        .map(|i| (i, tree.add(&problems[i].pointer)))
        .collect();
    if targets.is_empty() {
        return;
    }
    let mut lines = Lines::new(text);
    let mut path: Vec<Option<usize>> = Vec::new();
    let mut scanner = Scanner::new(text, usize::MAX);
    while let Some(event) = scanner.next() {
        let child = |token: Token<'_>| match path.last() {
            None => Some(0),
            Some(parent) => parent.and_then(|node| tree.child(node, &token.to_string())),
        };
        match event {
            Event::Key { start, token } => {
                if let Some(node) = child(token) {
                    tree.nodes[node].key = Some(lines.place(start));
                }
            }
            Event::Value { start, opens, token } => {
                let node = child(token);
                if let Some(node) = node {
                    tree.nodes[node].value = Some(lines.place(start));
                }
                if opens {
                    path.push(node);
                }
            }
            Event::Close => {
                path.pop();
            }
        }
    }
    for (i, node) in targets {
        let problem = &mut problems[i];
        let is_key = matches!(problem.code, Code::UnknownKey | Code::DuplicateName | Code::Unsupported);
        if let Some((line, column)) = tree.nearest(node, is_key) {
            (problem.line, problem.column) = (Some(line), Some(column));
        }
        shorten(&mut problem.pointer);
    }
}

fn shorten(pointer: &mut String) {
    while pointer.len() > POINTER_BYTES {
        pointer.truncate(pointer.rfind('/').unwrap_or(0));
    }
}

/// Keys that occur twice in their object. serde's derived types refuse these, but give no place.
pub fn duplicate_keys(text: &[u8]) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut lines = Lines::new(text);
    let mut seen: Vec<HashSet<String>> = Vec::new();
    let mut scanner = Scanner::new(text, usize::MAX);
    while let Some(event) = scanner.next() {
        if control::step(1) {
            break;
        }
        match event {
            Event::Key { start, token } => {
                if seen.last_mut().is_some_and(|seen| !seen.insert(token.to_string())) {
                    let detail = "this key is given twice in the same object; keep one of the two";
                    let (line, column) = lines.place(start);
                    let problem = Problem::new(pointer(scanner.path()), Code::DuplicateName, detail);
                    problems.push(Problem { line: Some(line), column: Some(column), ..problem });
                    if problems.len() >= PROBLEMS_FOUND {
                        break;
                    }
                }
            }
            Event::Value { opens: true, .. } => seen.push(HashSet::new()),
            Event::Value { opens: false, .. } => {}
            Event::Close => {
                seen.pop();
            }
        }
    }
    problems
}

/// The pointer of the innermost value that has begun at a byte offset.
pub fn innermost(text: &[u8], offset: usize) -> String {
    let mut scanner = Scanner::new(text, offset);
    while scanner.next().is_some() {}
    pointer(scanner.path())
}

/// The byte offset of a line and a column, both from 1; the end of the text if there is no such place.
pub fn offset(text: &[u8], line: usize, column: usize) -> usize {
    let mut start = 0;
    for _ in 1..line {
        match text[start..].iter().position(|&byte| byte == b'\n') {
            Some(length) => start += length + 1,
            None => return text.len(),
        }
    }
    start.saturating_add(column.saturating_sub(1)).min(text.len())
}

/// Line and column of a byte offset, both from 1.
pub fn place(text: &[u8], offset: usize) -> (u32, u32) {
    Lines::new(text).place(offset)
}

fn pointer<'t>(path: impl Iterator<Item = Token<'t>>) -> String {
    let mut pointer = String::new();
    for token in path.take_while(|token| !matches!(token, Token::None)) {
        let longer = push_token(&pointer, token);
        if longer.len() > POINTER_BYTES {
            break;
        }
        pointer = longer;
    }
    pointer
}

impl fmt::Display for Token<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Token::None => Ok(()),
            Token::Index(index) => write!(f, "{index}"),
            Token::Key(raw) => {
                let quoted = [b"\"", *raw, b"\""].concat();
                f.write_str(
                    &serde_json::from_slice(&quoted).unwrap_or_else(|_| String::from_utf8_lossy(raw).into_owned()),
                )
            }
        }
    }
}

/// Pointers as a tree of their tokens, so that values without a pointer cost nothing.
#[derive(Debug)]
struct Tree {
    nodes: Vec<Node>,
}

#[derive(Debug, Default)]
struct Node {
    parent: usize,
    children: HashMap<String, usize>,
    key: Option<(u32, u32)>,
    value: Option<(u32, u32)>,
}

impl Default for Tree {
    fn default() -> Self {
        Self { nodes: vec![Node::default()] }
    }
}

impl Tree {
    fn add(&mut self, pointer: &str) -> usize {
        pointer.split('/').skip(1).fold(0, |parent, token| {
            let token = token.replace("~1", "/").replace("~0", "~");
            let next = self.nodes.len();
            let node = *self.nodes[parent].children.entry(token).or_insert(next);
            if node == next {
                self.nodes.push(Node { parent, ..Node::default() });
            }
            node
        })
    }

    fn child(&self, node: usize, token: &str) -> Option<usize> {
        self.nodes[node].children.get(token).copied()
    }

    fn nearest(&self, mut node: usize, is_key: bool) -> Option<(u32, u32)> {
        if is_key && self.nodes[node].key.is_some() {
            return self.nodes[node].key;
        }
        while self.nodes[node].value.is_none() && node != 0 {
            node = self.nodes[node].parent;
        }
        self.nodes[node].value
    }
}

/// Line numbers of growing offsets.
#[derive(Debug)]
struct Lines<'t> {
    text: &'t [u8],
    at: usize,
    line: u32,
    line_start: usize,
}

impl<'t> Lines<'t> {
    fn new(text: &'t [u8]) -> Self {
        Self { text, at: 0, line: 1, line_start: 0 }
    }

    fn place(&mut self, offset: usize) -> (u32, u32) {
        let offset = offset.min(self.text.len());
        for at in self.at..offset {
            if self.text[at] == b'\n' {
                self.line = self.line.saturating_add(1);
                self.line_start = at + 1;
            }
        }
        self.at = self.at.max(offset);
        (self.line, u32::try_from(offset - self.line_start + 1).unwrap_or(u32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str =
        "{\n  \"a\": [10, {\"b~/c\": true}],\n  \"d\\u0065\": { \"x\": \"}\\\"\", \"y\": {} },\n  \"x\": 1\n}";

    fn at(pointer: &str, code: Code) -> Option<(u32, u32)> {
        let mut problems = [Problem::new(pointer, code, "")];
        locate(TEXT.as_bytes(), &mut problems);
        problems[0].line.zip(problems[0].column)
    }

    #[test]
    fn pointers_lead_to_values() {
        for (pointer, place) in [
            ("", (1, 1)),
            ("/a", (2, 8)),
            ("/a/0", (2, 9)),
            ("/a/1/b~0~1c", (2, 22)),
            ("/de", (3, 14)),
            ("/de/x", (3, 21)),
            ("/de/y", (3, 33)),
            ("/x", (4, 8)),
            // It does not exist: the innermost value around it.
            ("/a/2", (2, 8)),
            ("/de/y/z/0", (3, 33)),
            ("/nothing", (1, 1)),
        ] {
            assert_eq!(at(pointer, Code::OutOfRange), Some(place), "{pointer}");
        }
        assert_eq!(at("/de/y", Code::UnknownKey), Some((3, 28)));
    }

    #[test]
    fn offsets_lead_to_pointers() {
        for (token, pointer) in
            [("10", "/a/0"), ("true", "/a/1/b~0~1c"), ("{}", "/de/y"), ("}\\\"", "/de/x"), ("1\n", "/x"), ("]", "/a/1")]
        {
            assert_eq!(innermost(TEXT.as_bytes(), TEXT.find(token).unwrap()), pointer, "{token}");
        }
        assert_eq!(offset(TEXT.as_bytes(), 4, 8), TEXT.find("1\n").unwrap());
        assert_eq!(offset(TEXT.as_bytes(), 9, 1), TEXT.len());
    }

    #[test]
    fn finds_duplicates_behind_escapes() {
        let found = duplicate_keys(br#"{"a": {"a": 1, "b": [{"c": 0}, {"c": 0, "\u0063": 1}]}, "a": 2}"#);
        let found: Vec<_> = found.iter().map(|p| (p.pointer.as_str(), p.column)).collect();
        assert_eq!(found, [("/a/b/1/c", Some(41)), ("/a", Some(57))]);
    }

    proptest! {
        #[test]
        fn nothing_panics(text in r#"[\[\]{}",:\\a0\n ]{0,60}"#, pointer in "(/[a0]){0,3}", at in 0_usize..70) {
            let mut problems = [Problem::new(pointer, Code::UnknownKey, "")];
            locate(text.as_bytes(), &mut problems);
            duplicate_keys(text.as_bytes());
            innermost(text.as_bytes(), at);
            offset(text.as_bytes(), at, at);
            place(text.as_bytes(), at);
        }
    }
}
