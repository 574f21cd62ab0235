//! Words of text formats that go by lines, each with its place.

use super::fault::{Fault, Kind, Place};

/// A word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) text: &'a [u8],
    pub(super) place: Place,
}

/// Bytes for messages: in quotes, escaped, and no longer than a line.
pub(crate) fn quoted(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = &text[..text.len().min(LONGEST)];
    let rest = if shown.len() < text.len() { "..." } else { "" };
    format!("\"{}{rest}\"", shown.escape_ascii())
}

impl Word<'_> {
    /// For messages: in quotes, and no longer than a line.
    pub(super) fn quoted(&self) -> String {
        quoted(self.text)
    }

    /// Its value, which is finite.
    pub(super) fn number(&self) -> Result<f64, Fault> {
        let number = fast_float2::parse(self.text).ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault(Kind::WrongType, format!("expected a number, found {}", self.quoted())))
    }

    /// Its value, or NaN where it is not finite: `nan`, `-inf`, and what C libraries write, as `-nan(ind)`, `-1.#IND` or `1.#QNAN`.
    pub(super) fn number_or_nan(&self) -> Result<f64, Fault> {
        let unsigned = self.text.strip_prefix(b"-").unwrap_or(self.text).to_ascii_lowercase();
        let is_of_c = unsigned.starts_with(b"nan(") || unsigned.starts_with(b"1.#");
        let is_infinite = || fast_float2::parse(self.text).is_ok_and(|number: f64| !number.is_finite());
        if is_of_c || is_infinite() { Ok(f64::NAN) } else { self.number() }
    }

    /// A fault at its place.
    pub(super) fn fault(&self, kind: Kind, detail: String) -> Fault {
        Fault::new("", kind, detail).at(self.place)
    }
}

/// A text, read word by word within lines. `#` starts a comment, but for NaN as
/// some C libraries write it (`1.#QNAN`); a line that ends with `\` goes on in the next one.
#[derive(Debug)]
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
    line_start: usize,
}

impl<'a> Text<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { bytes, at: 0, line: 1, line_start: 0 }
    }

    /// Where the next byte is.
    pub(super) fn place(&self) -> Place {
        Place::Line(self.line, u32::try_from(self.at - self.line_start + 1).unwrap_or(u32::MAX))
    }

    /// The bytes that are left.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The next word of this line.
    pub(super) fn word(&mut self) -> Option<Word<'a>> {
        self.skip_spaces();
        let place = self.place();
        let start = self.at;
        while let Some(byte) = self.bytes.get(self.at)
            && !byte.is_ascii_whitespace()
            && (*byte != b'#' || self.bytes[start..self.at].ends_with(b"1."))
            && !(*byte == b'\\' && self.continues())
        {
            self.at += 1;
        }
        let text = &self.bytes[start..self.at];
        (!text.is_empty()).then_some(Word { text, place })
    }

    /// The next word of this line, which has to be there.
    pub(super) fn expected(&mut self, what: &str) -> Result<Word<'a>, Fault> {
        self.word().ok_or_else(|| Fault::new("", Kind::Invalid, format!("expected {what}")).at(self.place()))
    }

    /// The next number of this line, which has to be there.
    pub(super) fn number(&mut self) -> Result<f64, Fault> {
        self.expected("a number")?.number()
    }

    pub(super) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Fault> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    /// The next word of any line.
    pub(super) fn any_word(&mut self) -> Option<Word<'a>> {
        loop {
            if let Some(word) = self.word() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }

    /// The rest of this line as it is written, for names with spaces. Only a backslash behind a blank continues it: folders of Windows
    /// end with one, too.
    pub(super) fn name(&mut self) -> String {
        self.skip_spaces();
        let mut name = Vec::new();
        loop {
            let rest = &self.bytes[self.at..];
            let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
            self.at += end;
            let line = rest[..end].trim_ascii_end();
            let continued = line.strip_suffix(b"\\").filter(|line| line.last().is_none_or(u8::is_ascii_whitespace));
            name.extend(continued.unwrap_or(line));
            if continued.is_none() || !self.next_line() {
                return String::from_utf8_lossy(name.trim_ascii_end()).into_owned();
            }
        }
    }

    /// Goes to the next line; false at the end of the text.
    pub(super) fn next_line(&mut self) -> bool {
        while let Some(&byte) = self.bytes.get(self.at) {
            self.at += 1;
            let is_end = byte == b'\n' || (byte == b'\r' && self.bytes.get(self.at) != Some(&b'\n'));
            if is_end {
                self.line = self.line.saturating_add(1);
                self.line_start = self.at;
                return true;
            }
        }
        false
    }

    fn skip_spaces(&mut self) {
        loop {
            match self.bytes.get(self.at) {
                Some(b' ' | b'\t' | 0x0b | 0x0c) => self.at += 1,
                Some(b'\r') if self.bytes.get(self.at + 1) != Some(&b'\n') => return,
                Some(b'#') => {
                    let rest = &self.bytes[self.at..];
                    self.at += rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
                    return;
                }
                Some(b'\\') if self.continues() => drop(self.next_line()),
                _ => return,
            }
        }
    }

    /// Whether nothing but the end of the line follows.
    fn continues(&self) -> bool {
        let mut rest = self.bytes[self.at + 1..].iter();
        rest.find(|byte| !matches!(byte, b' ' | b'\t')).is_none_or(|byte| matches!(byte, b'\n' | b'\r'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_on_after_a_backslash_at_their_end() {
        for end in ["\n", "\r\n", "\r"] {
            let text = format!("f 1\t2\\{end}3 \\ {end} 4{end}usemtl\ta b \\{end}c\\d\\{end}e");
            let mut text = Text::new(text.as_bytes());
            let words: Vec<_> = std::iter::from_fn(|| text.word()).map(|word| word.text).collect();
            assert_eq!(words, [b"f", b"1", b"2", b"3", b"4"], "{end:?}");
            assert!(text.next_line());
            let word = text.word().unwrap();
            assert_eq!((word.text, word.place), (&b"usemtl"[..], Place::Line(4, 1)), "{end:?}");
            assert_eq!(text.name(), "a b c\\d\\", "{end:?}");
        }
    }
}
