//! Names of pictures in the store, as jobs ask for them: `shots/{date}/{job}.{ext}`.
//!
//! What a tenant names is below `results/TENANT/`, whatever it writes: nobody overwrites the pictures of others, or scenes.

use std::fmt::Write;
use std::str::FromStr;

/// Bytes of a template.
const BYTES: usize = 200;
/// Words in a template. The longest stands for 45 letters, so that a name has less than 512 bytes.
const WORDS: usize = 4;
/// The words, and what stands for them.
pub(crate) const WORDS_OF_KEYS: [(&str, &str); 8] = [
    ("job", "the job's id"),
    ("scene", "the scene's id"),
    ("image", "the picture's id"),
    ("frame", "the frame's number, with four digits; of a sequence only"),
    ("width", "pixels across"),
    ("height", "pixels down"),
    ("date", "the day on which the job was accepted, 2026-11-24"),
    ("ext", "the ending of the picture's format: png, jpg, webp, exr, pfm"),
];

/// Stands for itself until there are frames.
pub(crate) const FRAME: &str = "{frame}";

/// A template of names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct KeyTemplate(Vec<Part>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Text(String),
    Word(&'static str),
}

impl KeyTemplate {
    /// The name in the store for what the words stand for. An error names a word that stands for nothing here.
    pub(crate) fn fill(&self, tenant: &str, value: impl Fn(&str) -> Option<String>) -> Result<String, String> {
        let mut name = format!("results/{tenant}/");
        for part in &self.0 {
            match part {
                Part::Text(text) => name += text,
                Part::Word(word) => {
                    let value =
                        value(word).ok_or_else(|| format!("{{{word}}} stands for nothing in this job's store.key"))?;
                    // All of them are ids and numbers, or FRAME.
                    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '{' | '}');
                    let _ = write!(name, "{}", value.chars().filter(|c| is_plain(*c)).collect::<String>());
                }
            }
        }
        Ok(name)
    }

    /// The template for the frames of a sequence, each of which has a name of its own.
    pub(crate) fn of_frames(self) -> Result<Self, String> {
        if self == Self::default() {
            return "{job}/{frame}.{ext}".parse();
        }
        match self.0.contains(&Part::Word("frame")) {
            true => Ok(self),
            false => Err("store.key of a sequence has {frame} in it, or all frames would have one name".into()),
        }
    }
}

impl Default for KeyTemplate {
    fn default() -> Self {
        Self(vec![Part::Word("job"), Part::Text(".".into()), Part::Word("ext")])
    }
}

impl FromStr for KeyTemplate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = || WORDS_OF_KEYS.map(|(word, _)| format!("{{{word}}}")).join(" ");
        let wrong = |why: String| {
            format!("store.key {text:?} {why}: it has parts of A-Z a-z 0-9 . _ - between slashes, and {}", all())
        };
        if text.is_empty() || text.len() > BYTES {
            return Err(format!("store.key has 1 to {BYTES} bytes"));
        }
        let (mut parts, mut rest) = (Vec::new(), text);
        while !rest.is_empty() {
            let (plain, more) = rest.split_at(rest.find('{').unwrap_or(rest.len()));
            if !plain.is_empty() {
                parts.push(Part::Text(plain.to_owned()));
            }
            rest = more;
            if let Some(more) = rest.strip_prefix('{') {
                let (word, more) = more.split_once('}').ok_or_else(|| wrong("has no } for its {".into()))?;
                let known = WORDS_OF_KEYS.iter().find(|(known, _)| *known == word);
                parts.push(Part::Word(known.ok_or_else(|| wrong(format!("names {{{word}}}")))?.0));
                rest = more;
            }
        }
        if parts.iter().filter(|part| matches!(part, Part::Word(_))).count() > WORDS {
            return Err(wrong(format!("has more than {WORDS} words")));
        }
        // With every word of plain letters the name is one if its text is.
        let example = Self(parts.clone()).fill("t", |_| Some("x".into()))?;
        let is_part = |part: &str| {
            let plain = part.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-'));
            plain && !part.is_empty() && !part.starts_with('.')
        };
        if !example.split('/').all(is_part) {
            return Err(wrong("is no name".into()));
        }
        if text.ends_with(".json") {
            return Err(wrong("is the name of another picture's report, which ends in .json".into()));
        }
        Ok(Self(parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fill(template: &str) -> Result<String, String> {
        let value = |word: &str| match word {
            "job" => Some("01-ab".to_owned()),
            "ext" => Some("png".to_owned()),
            "scene" => Some("../../x".to_owned()),
            _ => None,
        };
        template.parse::<KeyTemplate>()?.fill("acme", value)
    }

    #[test]
    fn names_are_below_the_tenants_own_prefix() {
        assert_eq!(fill("a/b_{job}.{ext}").unwrap(), "results/acme/a/b_01-ab.png");
        assert_eq!(fill("latest.png").unwrap(), "results/acme/latest.png");
        assert_eq!(fill("{scene}").unwrap(), "results/acme/x", "what stands for a word is no path");
        assert_eq!(KeyTemplate::default(), "{job}.{ext}".parse().unwrap());
        assert!(fill("{frame}").unwrap_err().contains("{frame} stands for nothing"));
        let frames = |key: &str| key.parse::<KeyTemplate>().unwrap().of_frames();
        assert_eq!(
            frames("{job}.{ext}").unwrap().fill("t", |word| Some(format!("{{{word}}}"))).unwrap(),
            "results/t/{job}/{frame}.{ext}"
        );
        assert!(frames("a/{frame}.png").is_ok() && frames("{job}.png").unwrap_err().contains("{frame}"));
        for wrong in [
            "",
            "/a",
            "a.png.json",
            "a/",
            "a//b",
            "..",
            "../x",
            "a/../b",
            "a/./b",
            "{job}/..",
            ".hidden",
            "a/.b",
            "a b",
            "ü",
            "a\\b",
            "a%2f",
            "{jobs}",
            "{job",
            "{",
            "{}",
            "a\u{0}",
            "{job}{job}{job}{job}{job}",
            &"a".repeat(201),
        ] {
            assert!(fill(wrong).is_err(), "{wrong}");
        }
    }
}
