//! Which format a file is in, by its content: those that are read, and common ones that are not, so that they are refused by
//! name.

use super::Format;
use super::problem::{Code, Problem};
use crate::models::{ModelFormat, parts, stl};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// What a file was recognised as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recognised {
    /// Scene JSON, or other JSON.
    Json,
    /// Neutral File Format.
    Nff,
    /// Binary glTF (.glb).
    Glb,
    /// glTF in JSON (.gltf).
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// STL, binary or text.
    Stl,
    /// PLY.
    Ply,
    /// A `multipart/form-data` body with the parts of a model.
    Parts,
    /// Something else that has a name.
    Other(&'static str),
    /// None of these.
    Unknown,
}

/// How files of other formats begin.
const OTHERS: [(&[u8], &str); 12] = [
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"RIFF", "a WebP picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"PF", "a PFM picture"),
    (b"P6", "a PPM picture"),
    (b"#VRML", "VRML"),
    (b"Kaydara FBX", "FBX"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"%PDF", "PDF"),
    (b"<", "XML or HTML"),
];

/// What OBJ files name beside them.
const MATERIALS: &str = "a material library of Wavefront OBJ (.mtl)";

const YAML: &str = "YAML";

/// First words of NFF files.
const NFF: [&[u8]; 8] = [b"v", b"b", b"l", b"f", b"c", b"s", b"p", b"pp"];

/// The keys that tell glTF from a scene.
#[derive(Deserialize)]
struct Keys {
    asset: Option<IgnoredAny>,
    version: Option<IgnoredAny>,
}

/// The format of a file, by its first bytes and, of JSON, by its keys. JSON that breaks off counts as scene JSON.
pub fn recognise(bytes: &[u8]) -> Recognised {
    match recognise_start(bytes) {
        Recognised::Json => match serde_json::from_slice(super::read::strip_mark(bytes)) {
            Ok(Keys { asset: Some(_), version: None }) => Recognised::Gltf,
            _ => Recognised::Json,
        },
        start => start,
    }
}

/// Whether bytes are compressed with gzip (RFC 1952).
pub fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The format of a file by its first bytes alone: glTF in JSON is JSON.
pub fn recognise_start(bytes: &[u8]) -> Recognised {
    if bytes.starts_with(b"glTF") {
        return Recognised::Glb;
    }
    if is_gzip(bytes) {
        return Recognised::Nff;
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Recognised::Ply;
    }
    // Also binary files begin so, against the rules.
    if stl::begins_as_text(bytes) || stl::is_binary(bytes) {
        return Recognised::Stl;
    }
    if parts::is_multipart(bytes) {
        return Recognised::Parts;
    }
    if let Some((_, name)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Recognised::Other(name);
    }
    let text = super::read::strip_mark(bytes).trim_ascii_start();
    if matches!(text.first(), Some(b'{' | b'[')) { Recognised::Json } else { by_first_statement(text) }
}

/// The format of a file that is a model, by its name or its content.
pub(super) fn model_format(bytes: &[u8], name: Option<&str>) -> Option<ModelFormat> {
    let ending = name.and_then(|name| name.rsplit_once('.')).map(|(_, ending)| ending.to_ascii_lowercase());
    let named = match ending.as_deref() {
        Some("gltf" | "glb") => Some(ModelFormat::Gltf),
        Some("obj") => Some(ModelFormat::Obj),
        Some("stl") => Some(ModelFormat::Stl),
        Some("ply") => Some(ModelFormat::Ply),
        _ => None,
    };
    named.or_else(|| match recognise(bytes) {
        Recognised::Glb | Recognised::Gltf => Some(ModelFormat::Gltf),
        Recognised::Obj => Some(ModelFormat::Obj),
        Recognised::Stl => Some(ModelFormat::Stl),
        Recognised::Ply => Some(ModelFormat::Ply),
        _ => None,
    })
}

/// OBJ has numbers behind its `v`, where in NFF it stands alone.
fn by_first_statement(text: &[u8]) -> Recognised {
    // More than any comment at the start of a file.
    let start = &text[..text.len().min(64 << 10)];
    let lines = start.split(|byte| matches!(byte, b'\n' | b'\r'));
    let mut statements = lines.map(|line| line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()));
    let first = statements.find(|words| words.clone().next().is_some_and(|word| !word.starts_with(b"#")));
    let Some(mut words) = first else { return Recognised::Unknown };
    match words.next() {
        Some(b"v") if words.clone().take(3).filter(|word| is_number(word)).count() == 3 => Recognised::Obj,
        Some(b"vn" | b"vt" | b"vp" | b"mtllib" | b"usemtl" | b"o" | b"g") => Recognised::Obj,
        Some(b"newmtl") => Recognised::Other(MATERIALS),
        Some(b"---") => Recognised::Other(YAML),
        Some([name @ .., b':'])
            if !name.is_empty() && name.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_') =>
        {
            Recognised::Other(YAML)
        }
        Some(word) if NFF.contains(&word) => Recognised::Nff,
        _ => Recognised::Unknown,
    }
}

fn is_number(word: &[u8]) -> bool {
    std::str::from_utf8(word).is_ok_and(|word| word.parse::<f64>().is_ok())
}

impl Recognised {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Json => "JSON",
            Self::Nff => "Neutral File Format (NFF)",
            Self::Glb => "binary glTF (.glb)",
            Self::Gltf => "glTF",
            Self::Obj => "Wavefront OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::Parts => "a form with the parts of a model",
            Self::Other(name) => name,
            Self::Unknown => "of an unknown format",
        }
    }

    /// The format of a model; glTF in JSON is known as such only by its keys.
    pub fn model(self) -> Option<Format> {
        match self {
            Self::Glb | Self::Gltf => Some(Format::Gltf),
            Self::Obj => Some(Format::Obj),
            Self::Stl => Some(Format::Stl),
            Self::Ply => Some(Format::Ply),
            Self::Parts => Some(Format::Parts),
            Self::Json | Self::Nff | Self::Other(_) | Self::Unknown => None,
        }
    }

    /// Why a file of this format cannot be read as another, and what to do. None if it is in that format.
    pub fn refused_as(self, format: Format) -> Option<Problem> {
        let what = match (self, format) {
            (Self::Json, Format::Json) | (Self::Nff, Format::Nff) | (Self::Unknown, _) => return None,
            (Self::Glb | Self::Gltf, Format::Gltf)
            | (Self::Obj, Format::Obj)
            | (Self::Stl, Format::Stl)
            | (Self::Ply, Format::Ply)
            | (Self::Parts, Format::Parts) => return None,
            (Self::Json, Format::Nff) => "not NFF: read it as json (--input json; Content-Type: application/json)",
            (Self::Nff, Format::Json) => "not JSON: read it as nff (--input nff; Content-Type: text/x-nff)",
            (Self::Other(name), _) if name.ends_with("picture") => "not a scene: a scene names its pictures",
            (Self::Other(MATERIALS), _) => {
                "without a shape in it: send its .obj, and both as parts of one multipart/form-data body"
            }
            (Self::Other(YAML), _) => "which strahl does not read: write the same as JSON",
            (Self::Json, _) => "not a model: read it as json (--input json; Content-Type: application/json)",
            (Self::Nff, _) => "not a model: read it as nff (--input nff; Content-Type: text/x-nff)",
            (Self::Glb | Self::Gltf, _) => {
                "read it as gltf (--input gltf; Content-Type: model/gltf-binary or model/gltf+json)"
            }
            (Self::Obj, _) => "read it as obj (--input obj; Content-Type: model/obj)",
            (Self::Stl, _) => "read it as stl (--input stl; Content-Type: model/stl)",
            (Self::Ply, _) => "read it as ply (--input ply; Content-Type: model/ply)",
            (Self::Parts, _) => "read it as parts (--input parts; Content-Type: multipart/form-data)",
            (Self::Other(_), _) => "which strahl does not read: convert it to glTF (.glb)",
        };
        let problem = Problem::new("", Code::OtherFormat, format!("this is {}, {what}", self.name()));
        Some(Problem { line: Some(1), ..problem })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_content() {
        for (bytes, format) in [
            (&b"\xef\xbb\xbf\n {}"[..], Recognised::Json),
            (b"{\"version\": 1, \"asset\": 3}", Recognised::Json),
            (b"", Recognised::Unknown),
            (b"nff\nversion 2", Recognised::Unknown),
            (b"[1", Recognised::Json),
            (b"\x1f\x8b\x08", Recognised::Nff),
            (b"v\nfrom 0 0 1", Recognised::Nff),
            (b"# v 1 2 3\nb 0 0 0", Recognised::Nff),
            (b"glTF\x02\0\0\0", Recognised::Glb),
            (b"\n{\"scenes\": [], \"asset\": {\"version\": \"2.0\"}}", Recognised::Gltf),
            (b"# Blender\r\n\r\nmtllib a.mtl\r\nv 1 2 3", Recognised::Obj),
            (b"v 1.0 -2e-3 3 1\nf 1 1 1", Recognised::Obj),
            (b"\x89PNG\r\n\x1a\n", Recognised::Other("a PNG picture")),
            (b"# Blender\nnewmtl red\nKd 1 0 0\n", Recognised::Other(MATERIALS)),
            (b"# a scene\nversion: 1\n", Recognised::Other(YAML)),
            (b"---\nversion: 1\n", Recognised::Other(YAML)),
            (b"solid cube\nfacet normal 0 0 1", Recognised::Stl),
            (b"\xef\xbb\xbf SOLID CUBE\nFACET NORMAL 0 0 1", Recognised::Stl),
            (b"ply\nformat ascii 1.0", Recognised::Ply),
            (b"--x\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n", Recognised::Parts),
        ] {
            assert_eq!(recognise(bytes), format, "{:?}", String::from_utf8_lossy(bytes));
        }
    }
}
