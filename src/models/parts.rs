//! The parts of a model: which names it may use, and a `multipart/form-data` body (RFC 7578) that holds all of them.
//!
//! Such a body is kept as it came. It names its boundary itself, in its first line, so it stands for the whole model: it has one
//! hash, and jobs and caches need to know nothing of parts.

use super::data_uri::{self, percent_decoded};
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

/// Most parts of a body.
const PARTS: usize = 4_096;
/// Most bytes of the headers of a part.
const HEADERS: usize = 4_096;
/// Longest boundary (RFC 2046, section 5.1.1).
const BOUNDARY: usize = 70;
/// What is wrong with a body without any.
const NO_PARTS: &str = "the body has no parts";

/// A file in a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part<'a> {
    /// Its file name; without one, the name of the form's field.
    pub name: &'a str,
    /// Whether it has a file name.
    pub is_file: bool,
    /// What is in it.
    pub bytes: &'a [u8],
}

/// Whether bytes begin as a body of parts does.
pub fn is_multipart(bytes: &[u8]) -> bool {
    boundary(bytes).is_some_and(|(_, rest)| {
        let headers = &rest[..rest.len().min(HEADERS)];
        find(&headers.to_ascii_lowercase(), b"content-disposition:").is_some()
    })
}

/// The first line, which is the delimiter, and what follows it.
fn boundary(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let start = Some(&bytes[..bytes.len().min(HEADERS)]).filter(|start| start.starts_with(b"--"))?;
    let (line, rest) = match find(start, b"\r\n") {
        Some(end) => (&bytes[..end], &bytes[end + 2..]),
        None => (start, &bytes[start.len()..]),
    };
    // Gateways may add blanks (RFC 2046, section 5.1.1).
    let end = line.iter().rposition(|byte| !is_blank(byte)).map_or(0, |last| last + 1);
    (3..=BOUNDARY + 2).contains(&end).then_some((&line[..end], rest))
}

fn is_blank(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

fn find(text: &[u8], what: &[u8]) -> Option<usize> {
    let first = *what.first()?;
    let mut at = 0;
    loop {
        at += text.get(at..)?.iter().position(|byte| *byte == first)?;
        if text[at..].starts_with(what) {
            return Some(at);
        }
        at += 1;
    }
}

/// The parts of a body, in their order. An error says what is wrong with it.
pub fn split(bytes: &[u8]) -> Result<Vec<Part<'_>>, String> {
    let (boundary, mut rest) = boundary(bytes).ok_or("the body does not begin with a boundary")?;
    let delimiter = [b"\r\n", boundary].concat();
    if boundary.ends_with(b"--") && find(rest, &delimiter).is_none() {
        return Err(NO_PARTS.into());
    }
    let mut parts = Vec::new();
    loop {
        let head = rest.get(..rest.len().min(HEADERS)).unwrap_or_default();
        // A part without headers begins with an empty line.
        let end = if head.starts_with(b"\r\n") { Some(0) } else { find(head, b"\r\n\r\n").map(|end| end + 2) };
        let number = parts.len() + 1;
        let end = end.ok_or_else(|| format!("the headers of part {number} do not end within {HEADERS} bytes"))?;
        let (name, is_file) = name_of(&rest[..end]).ok_or_else(|| format!("part {number} has no name in UTF-8"))?;
        let content = &rest[end + 2..];
        let length =
            find(content, &delimiter).ok_or_else(|| format!("part {number} does not end with the boundary"))?;
        parts.push(Part { name, is_file, bytes: &content[..length] });
        rest = &content[length + delimiter.len()..];
        if rest.starts_with(b"--") {
            return Ok(parts);
        }
        let blanks = rest.iter().take_while(|byte| is_blank(byte)).count();
        rest = rest[blanks..]
            .strip_prefix(b"\r\n")
            .ok_or_else(|| format!("the line after part {number} is no boundary"))?;
        if parts.len() >= PARTS {
            return Err(format!("there are more than {PARTS} parts"));
        }
    }
}

/// The file name of a part and true, or its name and false.
fn name_of(headers: &[u8]) -> Option<(&str, bool)> {
    let headers = std::str::from_utf8(headers).ok()?;
    let is_disposition =
        |line: &&str| line.get(..20).is_some_and(|key| key.eq_ignore_ascii_case("content-disposition:"));
    let line = headers.split("\r\n").find(is_disposition)?;
    let parameter = |key: &str| {
        let start = line.find(key).map(|at| at + key.len())?;
        let value = &line[start..];
        let end = value.find('"')?;
        Some(&value[..end])
    };
    let file = parameter(" filename=\"").filter(|name| !name.is_empty());
    file.map(|name| (name, true)).or_else(|| parameter(" name=\"").map(|name| (name, false)))
}

/// The part that is the model: the one with a name that ends as those of models do, else the first. An error says which parts
/// cannot be told apart.
pub fn model_of<'a>(parts: &[Part<'a>]) -> Result<Part<'a>, String> {
    let mut numbers = HashMap::new();
    for (number, part) in (1..).zip(parts) {
        let path = own_path(part.name);
        if let Some(first) = numbers.insert(path.clone(), number) {
            return Err(format!("parts {first} and {number} have the same name, {}: rename one", shown(&path)));
        }
    }
    const ENDINGS: [&str; 5] = [".gltf", ".glb", ".obj", ".stl", ".ply"];
    let is_model = |part: &&Part<'_>| {
        let name = part.name.to_ascii_lowercase();
        ENDINGS.iter().any(|ending| name.ends_with(ending))
    };
    let mut models = parts.iter().filter(is_model);
    match (models.next(), models.next()) {
        (Some(one), Some(other)) => {
            let [one, other] = [one, other].map(|part| shown(part.name));
            Err(format!("{one} and {other} are both models: send one of them, and the parts that it names"))
        }
        (one, _) => one.or(parts.first()).copied().ok_or_else(|| NO_PARTS.to_owned()),
    }
}

/// The first field of a form that is no file: it has no file name, and no ending of one, and is not the model.
pub fn field_of<'a>(parts: &[Part<'a>], model: &Part<'_>) -> Option<&'a str> {
    parts
        .iter()
        .map(|part| (part.name, part.is_file))
        .find(|(name, is_file)| !is_file && !name.contains('.') && *name != model.name)
        .map(|(name, _)| name)
}

/// A name in quotes, not too long.
fn shown(name: &str) -> String {
    let short: String = name.chars().take(60).collect();
    if short.len() < name.len() { format!("{:?}", short + "...") } else { format!("{short:?}") }
}

/// The parts of a body by their paths.
#[derive(Debug)]
pub struct Named<'a> {
    parts: HashMap<Cow<'a, str>, &'a [u8]>,
    read: RefCell<HashSet<String>>,
}

impl<'a> Named<'a> {
    /// Those parts, of which no two have the same path ([`model_of`]).
    pub fn new(parts: &[Part<'a>]) -> Self {
        let parts = parts.iter().map(|part| (own_path(part.name), part.bytes)).collect();
        Self { parts, read: RefCell::default() }
    }

    /// The bytes of the part that a model means by a name.
    pub fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let path = own_path(name);
        let bytes = self.parts.get(&path).ok_or("is none of the parts of the request")?;
        self.read.borrow_mut().insert(path.into_owned());
        Ok(bytes.to_vec())
    }

    /// Whether a part has been read.
    pub fn has_read(&self, name: &str) -> bool {
        self.read.borrow().contains(&*own_path(name))
    }
}

/// The plain path of a name, or the name itself if it leads out of the folder.
fn own_path(name: &str) -> Cow<'_, str> {
    plain_path(name).map_or(name.into(), Cow::from)
}

/// Reads what a model means by a name: what has exactly that name, else what has its plain path.
pub fn exact_or_plain(name: &str, read: impl Fn(&str) -> Result<Vec<u8>, String>) -> Result<Vec<u8>, String> {
    read(name).or_else(|why| plain_path(name).filter(|plain| plain != name).map_or(Err(why), |plain| read(&plain)))
}

/// The path of a file in the folder of a model as all systems write it: backslashes, which Windows has, are slashes; `.` and empty
/// segments are left out. None if it leads out of the folder.
pub fn plain_path(name: &str) -> Option<String> {
    let segments = name.split(['/', '\\']);
    let is_outside =
        name.starts_with(['/', '\\']) || has_scheme(name) || segments.clone().any(|segment| segment == "..");
    let segments = segments.filter(|segment| !matches!(*segment, "" | "."));
    (!is_outside).then(|| segments.collect::<Vec<_>>().join("/"))
}

/// Whether a name begins with a scheme, or with the letter of a drive.
fn has_scheme(name: &str) -> bool {
    name.split(['/', '\\']).next().is_some_and(|first| first.contains(':'))
}

/// What a URI of a model says.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Uri {
    /// Bytes.
    Data(Vec<u8>),
    /// The name of a part.
    Name(String),
}

/// Reads a URI. Models never name what is on the network, nor what is outside of their folder.
pub(super) fn uri(text: &str) -> Result<Uri, String> {
    if let Some(bytes) = data_uri::decoded(text) {
        return bytes.map(Uri::Data);
    }
    let name = String::from_utf8(percent_decoded(text).into_owned()).unwrap_or_else(|_| text.to_owned());
    if name.is_empty() {
        return Err("names nothing".into());
    }
    if has_scheme(&name) {
        return Err("has a scheme: nothing is ever fetched; send the file as a part, and write its name".into());
    }
    if plain_path(&name).is_none() {
        return Err("leads out of the model's folder: write a name relative to it, without \"..\"".into());
    }
    Ok(Uri::Name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &[u8] = b"--X1\r\nContent-Disposition: form-data; name=\"a\"; filename=\"box.gltf\"\r\n\
        Content-Type: model/gltf+json\r\n\r\n{}\r\n--X1\r\ncontent-disposition: form-data; name=\"box.bin\"\r\n\r\n\
        \r\n--X\r\n\r\n--X1--\r\n";

    #[test]
    fn a_body_is_taken_apart() {
        assert!(is_multipart(BODY) && !is_multipart(b"--\r\n") && !is_multipart(b"glTF"));
        let parts = split(BODY).unwrap();
        let [gltf, bin] = [("box.gltf", true, &b"{}"[..]), ("box.bin", false, b"\r\n--X\r\n")]
            .map(|(name, is_file, bytes)| Part { name, is_file, bytes });
        assert_eq!(parts, [gltf, bin]);
        assert_eq!(model_of(&parts).unwrap(), gltf);
        assert_eq!(field_of(&parts, &gltf), None);
        assert_eq!(field_of(&[gltf, bin, Part { name: "width", ..bin }], &gltf), Some("width"));
        for end in 0..BODY.len() - 4 {
            assert!(split(&BODY[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn blanks_after_a_boundary_are_no_part_of_it() {
        let padded = String::from_utf8_lossy(BODY).replace("--X1\r\n", "--X1 \t\r\n");
        assert!(is_multipart(padded.as_bytes()));
        assert_eq!(split(padded.as_bytes()), split(BODY));
        assert!(!is_multipart(b"--  \r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n\r\n----\r\n"));
    }

    #[test]
    fn a_body_without_parts_says_so() {
        for body in ["--XX--", "--XX--\r\n", "--XX-- \r\n\r\n"] {
            assert_eq!(split(body.as_bytes()), Err(NO_PARTS.to_owned()), "{body:?}");
        }
        // A boundary may end so.
        let body = "--XX--\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n1\r\n--XX----\r\n";
        assert_eq!(split(body.as_bytes()).map(|parts| parts.len()), Ok(1));
    }

    #[test]
    fn a_name_in_two_spellings_is_one_name() {
        let part = |name: &'static str| Part { name, is_file: true, bytes: b"" };
        for (one, other) in [("box.bin", "box.bin"), ("box.bin", "./box.bin"), ("a//b.bin", "a\\b.bin"), ("/a", "/a")] {
            let why = model_of(&[part("box.gltf"), part(one), part(other)]).unwrap_err();
            assert!(why.starts_with("parts 2 and 3 have the same name"), "{why}");
        }
        for (one, other) in [("box.bin", "Box.bin"), ("a/b.bin", "b.bin"), ("../a", "a"), ("/a", "a")] {
            assert!(model_of(&[part("box.gltf"), part(one), part(other)]).is_ok(), "{one} {other}");
        }
    }

    #[test]
    fn names_stay_in_their_folder() {
        assert_eq!(uri("a%20b/c.png"), Ok(Uri::Name("a b/c.png".into())));
        assert_eq!(uri("a\\c.png"), Ok(Uri::Name("a\\c.png".into())));
        assert_eq!(uri("data:x/y;base64,AAE="), Ok(Uri::Data(vec![0, 1])));
        assert_eq!(uri("data:;base64,AAE"), Ok(Uri::Data(vec![0, 1])));
        for wrong in ["", ":", "http://a/b", "../a", "a/%2e%2e/b", "/etc/passwd", "data:x", "data:;base64,!"] {
            assert!(uri(wrong).is_err(), "{wrong}");
        }
        for outside in ["..\\a", "a\\..\\..\\b", "a/..\\b", "\\a", "\\\\server\\a", "C:\\a", "C:a", "%5ca", "./../a"] {
            assert!(uri(outside).is_err(), "{outside}");
        }
    }

    #[test]
    fn names_are_compared_by_their_plain_paths() {
        let part = |name: &'static str, bytes: &'static [u8]| Part { name, is_file: true, bytes };
        let parts = [part("a/b.png", b"1"), part(".\\c.png", b"3"), part("../d.png", b"4")];
        let named = Named::new(&parts);
        for (name, bytes) in [
            ("a/b.png", b"1"),
            ("a\\b.png", b"1"),
            ("a//b.png", b"1"),
            (".\\a\\.\\b.png", b"1"),
            ("c.png", b"3"),
            ("./c.png", b"3"),
            ("../d.png", b"4"),
        ] {
            assert_eq!(named.read(name).as_deref(), Ok(&bytes[..]), "{name}");
        }
        for outside in ["d.png", "./../d.png", "/a/b.png", "\\a\\b.png", "a/../c.png", "C:\\a\\b.png"] {
            assert!(named.read(outside).is_err(), "{outside}");
        }
    }
}
