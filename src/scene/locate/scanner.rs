//! A scanner of JSON tokens, without recursion and without a grammar.
//!
//! It runs on text that `serde_json` has read, at least up to the offset asked for, so it checks nothing. On other text it
//! may find nonsense, but does not panic.

use crate::control;
use crate::scene::limits::JSON_DEPTH;

/// One step of a path: to a value of an object or of an array. None before the first.
#[derive(Debug, Clone, Copy)]
pub(super) enum Token<'t> {
    None,
    /// What stands between the key's quotes.
    Key(&'t [u8]),
    Index(u64),
}

/// What begins or ends. The token is the way there from the array or object around it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Event<'t> {
    Key {
        start: usize,
        token: Token<'t>,
    },
    /// A value; it `opens` if it is an array or object.
    Value {
        start: usize,
        opens: bool,
        token: Token<'t>,
    },
    Close,
}

/// An array or object that has not ended, and the way to its current value.
#[derive(Debug, Clone, Copy)]
struct Frame<'t> {
    token: Token<'t>,
    is_object: bool,
    key_is_next: bool,
}

/// Text to events. Commas and colons are skipped.
#[derive(Debug)]
pub(super) struct Scanner<'t> {
    text: &'t [u8],
    at: usize,
    end: usize,
    stack: Vec<Frame<'t>>,
}

impl<'t> Scanner<'t> {
    /// Of a text, up to what is at the offset `end`, which does not end there.
    pub(super) fn new(text: &'t [u8], end: usize) -> Self {
        Self { text, at: 0, end, stack: Vec::new() }
    }

    /// The way to the current value.
    pub(super) fn path(&self) -> impl Iterator<Item = Token<'t>> {
        self.stack.iter().map(|frame| frame.token)
    }

    pub(super) fn next(&mut self) -> Option<Event<'t>> {
        while matches!(self.text.get(self.at)?, b' ' | b'\t' | b'\r' | b'\n' | b',' | b':') {
            self.at += 1;
        }
        if self.at > self.end || control::step(1) {
            return None;
        }
        let start = self.at;
        self.at += 1;
        match self.text[start] {
            open @ (b'{' | b'[') => {
                let token = self.begin_value();
                let is_object = open == b'{';
                self.stack.push(Frame { token: Token::None, is_object, key_is_next: is_object });
                // serde_json has the same limit.
                (self.stack.len() as u64 <= JSON_DEPTH.max + 1).then_some(Event::Value { start, opens: true, token })
            }
            b'}' | b']' if start == self.end => None,
            b'}' | b']' => {
                self.stack.pop()?;
                Some(Event::Close)
            }
            b'"' => {
                let token = Token::Key(self.string());
                if let Some(frame) = self.stack.last_mut().filter(|frame| frame.key_is_next) {
                    (frame.token, frame.key_is_next) = (token, false);
                    return Some(Event::Key { start, token });
                }
                Some(Event::Value { start, opens: false, token: self.begin_value() })
            }
            _ => {
                let rest = &self.text[self.at..];
                let ends = |byte: &u8| matches!(byte, b'{' | b'}' | b'[' | b']' | b'"' | b',' | b':' | 0..=b' ');
                self.at += rest.iter().position(ends).unwrap_or(rest.len());
                Some(Event::Value { start, opens: false, token: self.begin_value() })
            }
        }
    }

    /// The way to a value that begins: in an array it is the next one.
    fn begin_value(&mut self) -> Token<'t> {
        let Some(frame) = self.stack.last_mut() else { return Token::None };
        frame.key_is_next = frame.is_object;
        if !frame.is_object {
            frame.token = Token::Index(if let Token::Index(index) = frame.token { index + 1 } else { 0 });
        }
        frame.token
    }

    /// Reads to the closing quote, or to the end.
    fn string(&mut self) -> &'t [u8] {
        let start = self.at;
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'"' => {
                    self.at += 1;
                    return &self.text[start..self.at - 1];
                }
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at = self.text.len();
        &self.text[start.min(self.at)..]
    }
}
