//! The place in the JSON that is being checked: a linked list on the stack, formatted only when there is a problem.

use crate::scene::problem::push_token;

/// A JSON pointer under construction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path<'a> {
    parent: Option<&'a Self>,
    token: Token<'a>,
}

#[derive(Debug, Clone, Copy)]
enum Token<'a> {
    Root,
    Key(&'a str),
    Index(usize),
}

impl<'a> Path<'a> {
    pub(super) const ROOT: Path<'static> = Path { parent: None, token: Token::Root };

    pub(super) fn key<'b>(&'b self, key: &'b str) -> Path<'b> {
        Path { parent: Some(self), token: Token::Key(key) }
    }

    pub(super) fn index(&self, index: usize) -> Path<'_> {
        Path { parent: Some(self), token: Token::Index(index) }
    }

    pub(super) fn pointer(&self) -> String {
        let before = self.parent.map_or_else(String::new, Path::pointer);
        match self.token {
            Token::Root => before,
            Token::Key(key) => push_token(&before, key),
            Token::Index(index) => push_token(&before, index),
        }
    }
}
