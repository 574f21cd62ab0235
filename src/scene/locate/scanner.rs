//! A scanner of JSON tokens, without recursion and without a grammar.
//!
//! It runs on text that `serde_json` has read, at least up to the offset asked for, so it checks nothing. On other text it
//! may find nonsense, but does not panic.

use crate::control;
use crate::scene::limits::JSON_DEPTH;

#[derive(Debug, Clone, Copy)]
pub(super) enum Event<'t> {
    /// A key; `raw` is what stands between the quotes.
    Key { start: usize, raw: &'t [u8] },
    /// A value begins; it has an index if it is an array's, and `opens` if it is an array or object.
    Value { start: usize, opens: bool, index: Option<u64> },
    /// An array or object ends.
    Close,
}

#[derive(Debug, Clone, Copy)]
enum Frame {
    Array { next: u64 },
    Object { key_is_next: bool },
}

/// Text to events. Commas and colons are skipped.
#[derive(Debug)]
pub(super) struct Scanner<'t> {
    text: &'t [u8],
    /// Offset behind the last event's token.
    pub(super) at: usize,
    stack: Vec<Frame>,
}

impl<'t> Scanner<'t> {
    pub(super) fn new(text: &'t [u8]) -> Self {
        Self { text, at: 0, stack: Vec::new() }
    }

    pub(super) fn next(&mut self) -> Option<Event<'t>> {
        while matches!(self.text.get(self.at)?, b' ' | b'\t' | b'\r' | b'\n' | b',' | b':') {
            self.at += 1;
        }
        if control::step(1) {
            return None;
        }
        let start = self.at;
        self.at += 1;
        match self.text[start] {
            open @ (b'{' | b'[') => {
                let index = self.begin_value();
                self.stack.push(if open == b'{' {
                    Frame::Object { key_is_next: true }
                } else {
                    Frame::Array { next: 0 }
                });
                // serde_json has the same limit.
                (self.stack.len() as u64 <= JSON_DEPTH.max + 1).then_some(Event::Value { start, opens: true, index })
            }
            b'}' | b']' => {
                self.stack.pop()?;
                Some(Event::Close)
            }
            b'"' => {
                let raw = self.string();
                if let Some(Frame::Object { key_is_next: key_is_next @ true }) = self.stack.last_mut() {
                    *key_is_next = false;
                    return Some(Event::Key { start, raw });
                }
                Some(Event::Value { start, opens: false, index: self.begin_value() })
            }
            _ => {
                let rest = &self.text[self.at..];
                let ends = |byte: &u8| matches!(byte, b'{' | b'}' | b'[' | b']' | b'"' | b',' | b':' | 0..=b' ');
                self.at += rest.iter().position(ends).unwrap_or(rest.len());
                Some(Event::Value { start, opens: false, index: self.begin_value() })
            }
        }
    }

    /// Counts a value in the array around it, and returns its index.
    fn begin_value(&mut self) -> Option<u64> {
        match self.stack.last_mut()? {
            Frame::Array { next } => {
                *next += 1;
                Some(*next - 1)
            }
            Frame::Object { key_is_next } => {
                *key_is_next = true;
                None
            }
        }
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
