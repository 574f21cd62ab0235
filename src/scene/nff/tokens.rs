//! Splits NFF text into tokens, which are separated by white space, without `#` comments. Line ends are `\n`, `\r\n` and
//! `\r`. The text is bytes, because comments may be in any encoding.

use crate::models::text::quoted;
use crate::scene::problem::{Code, Problem};

/// A place in the file, from 1; columns count bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) line: u32,
    pub(super) column: u32,
}

impl Place {
    pub(super) fn problem(self, code: Code, detail: impl Into<String>) -> Problem {
        Problem { line: Some(self.line), column: Some(self.column), ..Problem::new("", code, detail) }
    }
}

/// One word or number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'a> {
    pub(super) text: &'a [u8],
    pub(super) place: Place,
    /// Whether it is the first of its line.
    pub(super) starts_line: bool,
}

impl Token<'_> {
    /// Whether it is written with the characters of a C `%g` number, so not `nan`, `inf` or hexadecimal.
    pub(super) fn is_number(&self) -> bool {
        self.text.iter().any(u8::is_ascii_digit)
            && self.text.iter().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'))
    }

    /// Its value; infinite if it is too large.
    pub(super) fn number(&self) -> Option<f64> {
        // Of what C writes in other ways only `inf` and `nan` are parsed.
        fast_float2::parse(self.text).ok().filter(|number: &f64| number.is_finite() || self.is_number())
    }

    /// For messages: in quotes, and no longer than a line.
    pub(super) fn quoted(&self) -> String {
        quoted(self.text)
    }
}

/// The tokens of a text, with one token of lookahead.
#[derive(Debug)]
pub(super) struct Tokens<'a> {
    text: &'a [u8],
    at: usize,
    line: u32,
    line_start: usize,
    /// Whether a token was found on this line.
    line_used: bool,
    ahead: Option<Token<'a>>,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        let mut tokens = Self { text, at: 0, line: 1, line_start: 0, line_used: false, ahead: None };
        tokens.ahead = tokens.read();
        tokens
    }

    /// The next token, without taking it.
    pub(super) fn peek(&self) -> Option<Token<'a>> {
        self.ahead
    }

    /// The place of the next token, or of the end of the text.
    pub(super) fn place(&self) -> Place {
        self.ahead.map_or_else(|| self.place_of(self.at), |token| token.place)
    }

    fn place_of(&self, at: usize) -> Place {
        Place { line: self.line, column: (at - self.line_start) as u32 + 1 }
    }

    fn read(&mut self) -> Option<Token<'a>> {
        loop {
            match *self.text.get(self.at)? {
                b'\r' if self.text.get(self.at + 1) == Some(&b'\n') => self.at += 1,
                b'\n' | b'\r' => {
                    self.at += 1;
                    self.line += 1;
                    self.line_start = self.at;
                    self.line_used = false;
                }
                b'#' => self.skip_while(|byte| !matches!(byte, b'\n' | b'\r')),
                byte if is_space(byte) => self.at += 1,
                _ => break,
            }
        }
        let start = self.at;
        let place = self.place_of(start);
        self.skip_while(|byte| byte != b'#' && !is_space(byte));
        let starts_line = !std::mem::replace(&mut self.line_used, true);
        Some(Token { text: &self.text[start..self.at], place, starts_line })
    }

    fn skip_while(&mut self, skips: impl Fn(u8) -> bool) {
        self.at += self.text[self.at..].iter().take_while(|byte| skips(**byte)).count();
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        let token = self.ahead.take()?;
        self.ahead = self.read();
        Some(token)
    }
}

/// As C's `isspace`.
fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_white_space_separates_and_comments_vanish() {
        let text = b"\xEF\xBB\xBFs 1\t-2#tail\r\n\x0c.5 # Stra\xDFe\r  p\n\n#x\nq";
        let found: Vec<_> = Tokens::new(text)
            .map(|t| (t.text.escape_ascii().to_string(), t.place.line, t.place.column, t.starts_line))
            .collect();
        let expected = [
            ("s", 1, 1, true),
            ("1", 1, 3, false),
            ("-2", 1, 5, false),
            (".5", 2, 2, true),
            ("p", 3, 3, true),
            ("q", 6, 1, true),
        ];
        assert_eq!(found, expected.map(|(text, line, column, first)| (text.to_owned(), line, column, first)));
    }

    #[test]
    fn numbers_are_those_of_c_without_the_odd_ones() {
        let value = |text: &str| Tokens::new(text.as_bytes()).next().unwrap().number();
        assert_eq!(value("1e-16"), Some(1e-16));
        assert_eq!(value("-0").map(f64::to_bits), Some((-0.0_f64).to_bits()));
        assert_eq!(value(".5"), Some(0.5));
        assert_eq!(value("5."), Some(5.0));
        assert_eq!(value("+5E+2"), Some(500.0));
        assert_eq!(value("1e999"), Some(f64::INFINITY));
        for odd in ["nan", "inf", "infinity", "0x10", "1e", "-", ".", "1-2", "1,5", "1_000", "\u{661}"] {
            assert_eq!(value(odd), None, "{odd}");
        }
    }

    #[test]
    fn messages_quote_short_and_printable() {
        let long = [b'x'; 100];
        assert_eq!(Tokens::new(&long).next().unwrap().quoted().len(), 45);
        assert_eq!(Tokens::new(b"\xDF").next().unwrap().quoted(), r#""\xdf""#);
    }
}
