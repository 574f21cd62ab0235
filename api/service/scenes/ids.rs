//! Ids of scenes and pictures. They are hashes of the contents, so that a scene has the same id everywhere, and a picture's id
//! is known before a ray is traced.
//!
//! - The **canonical text** of a scene is its description as JSON: defaults filled in, keys in the order of the alphabet,
//!   without white space and `$schema`. It does not depend on how the scene was written, nor on its format.
//! - Its **scene id** is a hash of that text, in which the bytes of numbers stand for their digits, and hashes for objects and
//!   definitions, so that a variation of a large scene is not hashed as a whole.
//! - An **image id** names the scene, the renderer and the zoom. It changes with everything that may change a pixel, and
//!   with nothing else: pictures depend on neither threads nor machines. It can be parsed, so the service keeps no table.

use data_encoding::BASE32_NOPAD;
use serde::ser::{Error, Serialize};
use serde_json::Value;
use serde_json::ser::{Formatter, Serializer};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufWriter, Write};
use std::sync::LazyLock;
use strahl::control::{Cancelled, checkpoint};
use strahl::render::RENDER_EPOCH;
use strahl::scene::Description;
use strahl::scene::description::{Accuracy, Material, Object, RenderSettings};
use strahl::scene::read::read_json;

/// Largest zoom: a scene may be opened as 2^16 times its size.
pub(crate) const MAX_ZOOM: u32 = 16;

/// Begins what is hashed; another one whenever that is written in another way.
const ID_VERSION: &str = "scene 3\n";
/// The same where objects and definitions were hashed with all else.
const ID_VERSION_AS_A_WHOLE: &str = "scene 2\n";
/// Letters of a scene id: 160 bits of a hash.
const SCENE_LETTERS: usize = 32;
/// Letters of a hash that name a version of the renderer.
const RENDERER_LETTERS: usize = 6;

/// Whether the same settings give the same picture on any machine. A time limit does not.
pub(crate) fn is_reproducible(settings: &RenderSettings) -> bool {
    !matches!(settings.accuracy(), Accuracy::Time(_))
}

/// The hash of the objects and definitions of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(crate) struct BodiesDigest([u8; 32]);

impl BodiesDigest {
    /// Hashes them.
    pub(crate) fn of(description: &Description) -> Self {
        Self(hashed("", |to| definitions_and_objects(description).serialize(to)))
    }
}

/// Id of a scene: `s_` and 32 letters of `a-z2-7`. Clears `$schema` of the description and fills in render settings.
pub(crate) fn scene_id(description: &mut Description, bodies: BodiesDigest) -> String {
    let around = hashed(ID_VERSION, |to| write_around_bodies(description, to));
    named(&Sha256::new_with_prefix(around).chain_update(bodies.0).finalize())
}

/// Whether an id names the scene of a canonical text. Older versions hashed the text as it is, or the scene as a whole, and
/// their ids stay valid.
pub(crate) fn is_id_of_text(id: &str, text: &[u8]) -> bool {
    let is_id_of = |mut scene: Description| {
        let bodies = BodiesDigest::of(&scene);
        id == scene_id(&mut scene, bodies)
            || id == named(&hashed(ID_VERSION_AS_A_WHOLE, |to| write_canonical(&mut scene, to)))
    };
    id == named(&Sha256::digest(text)) || read_json(text).is_ok_and(is_id_of)
}

/// The hash of what is written, begun with a prefix.
fn hashed<T>(
    prefix: &str,
    write: impl FnOnce(&mut Serializer<&mut BufWriter<Hash>, BinaryNumbers>) -> serde_json::Result<T>,
) -> [u8; 32] {
    let mut hash = BufWriter::with_capacity(1 << 16, Hash(Sha256::new_with_prefix(prefix)));
    // Writing to a hash cannot fail, and all values of a description can be written as JSON. A cancelled hash is not used.
    let _ = write(&mut Serializer::with_formatter(&mut hash, BinaryNumbers));
    let _ = hash.flush();
    hash.get_ref().0.clone().finalize().into()
}

fn named(hash: &[u8]) -> String {
    format!("s_{}", letters(&hash[..SCENE_LETTERS * 5 / 8]))
}

/// The canonical text of a scene.
pub(crate) fn canonical(description: &mut Description) -> Vec<u8> {
    let mut text = Vec::new();
    // As above, this cannot fail.
    let _ = write_canonical(description, &mut Serializer::new(&mut text));
    text
}

/// Id of the picture of a scene opened as 2^zoom times its size, as this version renders it: `i_<scene>_<renderer>_<zoom>`, all
/// of `a-z2-7`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ImageId {
    /// The scene's id.
    pub(crate) scene: String,
    /// 0 to [`MAX_ZOOM`].
    pub(crate) zoom: u32,
}

impl ImageId {
    /// Parses an id of this version of the renderer.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let (scene, rest) = text.strip_prefix("i_")?.split_at_checked(SCENE_LETTERS)?;
        let zoom = match rest.strip_prefix('_')?.strip_prefix(renderer())?.strip_prefix('_')?.as_bytes() {
            [letter @ b'a'..=b'z'] => u32::from(letter - b'a'),
            _ => return None,
        };
        let id = Self { scene: format!("s_{scene}"), zoom };
        (zoom <= MAX_ZOOM && is_scene_id(&id.scene)).then_some(id)
    }
}

impl fmt::Display for ImageId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scene = self.scene.strip_prefix("s_").unwrap_or(&self.scene);
        // Zooms go to 16, letters to 25.
        write!(f, "i_{scene}_{}_{}", renderer(), char::from(b'a' + self.zoom.min(25) as u8))
    }
}

/// Whether a text looks like a scene id.
pub(crate) fn is_scene_id(text: &str) -> bool {
    let letters =
        |rest: &str| rest.len() == SCENE_LETTERS && rest.bytes().all(|b| matches!(b, b'a'..=b'z' | b'2'..=b'7'));
    text.strip_prefix("s_").is_some_and(letters)
}

/// Whether a file's name begins with an image id, of whatever version of the renderer.
pub(crate) fn is_image_name(name: &str) -> bool {
    let plain = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'.' | b'-');
    let is_id = |id: &str| {
        let mut parts = id.split('_');
        let mut letters = |count| parts.next().is_some_and(|part| part.len() == count);
        letters(1) && letters(SCENE_LETTERS) && letters(RENDERER_LETTERS) && letters(1)
    };
    let id = name.split('.').next().unwrap_or_default();
    name.len() <= 200 && name.bytes().all(plain) && id.starts_with("i_") && is_id(id)
}

/// Letters that stand for this version of the renderer.
pub(crate) fn renderer() -> &'static str {
    static RENDERER: LazyLock<String> = LazyLock::new(|| {
        let hash = Sha256::digest(format!("strahl {} {RENDER_EPOCH}", env!("CARGO_PKG_VERSION")));
        letters(&hash[..4])[..RENDERER_LETTERS].to_owned()
    });
    &RENDERER
}

fn letters(bytes: &[u8]) -> String {
    BASE32_NOPAD.encode(bytes).to_ascii_lowercase()
}

/// A part of the canonical text. Objects and definitions, which may be large, go out as they are; the rest goes through maps,
/// which sort its keys.
#[derive(serde::Serialize)]
#[serde(untagged)]
enum Part<'a> {
    Settings(&'a Value),
    Objects(&'a [Object]),
    Definitions(BTreeMap<&'a String, &'a Vec<Object>>),
    Materials(BTreeMap<&'a String, Sorted<'a>>),
}

/// A material whose keys are sorted when it is written: as a map it takes kilobytes.
struct Sorted<'a>(&'a Material);

impl Serialize for Sorted<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serde_json::to_value(self.0).map_err(S::Error::custom)?.serialize(serializer)
    }
}

/// The canonical text, but with the bytes of numbers in place of their digits: printing those of a large mesh takes longer than
/// hashing it. Each number begins with a byte that no JSON has, so no two scenes are written alike.
struct BinaryNumbers;

impl Formatter for BinaryNumbers {
    fn write_f64<W: Write + ?Sized>(&mut self, to: &mut W, value: f64) -> io::Result<()> {
        let mut bytes = [0xff; 9];
        bytes[1..].copy_from_slice(&value.to_le_bytes());
        to.write_all(&bytes)
    }

    fn write_u32<W: Write + ?Sized>(&mut self, to: &mut W, value: u32) -> io::Result<()> {
        let mut bytes = [0xfe; 5];
        bytes[1..].copy_from_slice(&value.to_le_bytes());
        to.write_all(&bytes)
    }
}

fn write_canonical<S: serde::Serializer>(description: &mut Description, to: S) -> Result<S::Ok, S::Error> {
    let settings = settings(description);
    let mut parts = around_bodies(description, &settings);
    parts.append(&mut definitions_and_objects(description));
    parts.serialize(to)
}

fn write_around_bodies<S: serde::Serializer>(description: &mut Description, to: S) -> Result<S::Ok, S::Error> {
    let settings = settings(description);
    around_bodies(description, &settings).serialize(to)
}

/// The settings of a description, which is made canonical.
fn settings(description: &mut Description) -> Value {
    description.schema = None;
    description.render = description.render.resolved();
    description.settings()
}

/// All parts but objects and definitions.
fn around_bodies<'a>(description: &'a Description, settings: &'a Value) -> BTreeMap<&'a str, Part<'a>> {
    let settings = settings.as_object().into_iter().flatten();
    let mut parts: BTreeMap<&str, Part<'_>> =
        settings.map(|(key, value)| (key.as_str(), Part::Settings(value))).collect();
    let materials = description.materials.iter().map(|(name, material)| (name, Sorted(material)));
    parts.insert("materials", Part::Materials(materials.collect()));
    parts
}

fn definitions_and_objects(description: &Description) -> BTreeMap<&str, Part<'_>> {
    let definitions = Part::Definitions(description.definitions.iter().collect());
    BTreeMap::from([("definitions", definitions), ("objects", Part::Objects(&description.objects))])
}

/// A hash as a writer.
struct Hash(Sha256);

impl Write for Hash {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        checkpoint(bytes.len() as u32 / 16).map_err(|Cancelled| io::Error::other("cancelled"))?;
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::{Format, Overrides, load};

    const SCENE: &str = r##"{
      "version": 1,
      "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } },
      "materials": { "red": { "diffuse": [1, 0, 0] }, "blue": { "diffuse": "#0000ff" } },
      "definitions": {
        "b": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } }],
        "a": [{ "sphere": { "center": [2, 0, 0], "radius": 1, "material": "blue" } }]
      },
      "objects": [{ "instance": { "of": "a" } }, { "instance": { "of": "b" } }]
    }"##;

    fn description(json: &str) -> Description {
        load(json.as_bytes(), Format::Json, &Overrides::default()).unwrap_or_else(|e| panic!("{e}")).description
    }

    fn id(description: &mut Description) -> String {
        let bodies = BodiesDigest::of(description);
        scene_id(description, bodies)
    }

    fn id_of(json: &str) -> String {
        id(&mut description(json))
    }

    #[test]
    fn what_a_scene_says_counts_not_how_it_is_written() {
        let id = id_of(SCENE);
        assert!(is_scene_id(&id) && !is_scene_id("s_short"), "{id}");
        for (other, why) in [
            (SCENE.replace(['\n', ' '], ""), "white space"),
            (SCENE.replace(r#""version": 1,"#, r#""version": 1, "$schema": "somewhere","#), "where the schema lies"),
            (
                SCENE.replace(
                    r#""version": 1,"#,
                    r#""render": { "accuracy": { "proved": { "max_codes": 1 } } }, "version": 1,"#,
                ),
                "a default written down",
            ),
            (
                SCENE.replace(
                    r#""eye": [0, 1, 5], "look_at": [0, 0, 0]"#,
                    r#""look_at": [0.0, 0, 0], "eye": [0, 1, 5]"#,
                ),
                "order",
            ),
            (SCENE.replace("\"#0000ff\"", "[0, 0, 1]"), "how a color is written"),
        ] {
            assert_eq!(id_of(&other), id, "{why}");
        }
        assert_ne!(id_of(&SCENE.replace("[2, 0, 0]", "[2, 0, 1]")), id);
        assert_ne!(id_of(&SCENE.replace("[1, 0, 0]", "[1, 0.5, 0]")), id);
    }

    /// Numbers are hashed as they are, texts as JSON: no way to write one is a way to write another.
    #[test]
    fn numbers_count_to_the_last_bit() {
        let id = id_of(SCENE);
        let next = 2.0_f64.next_up().to_string();
        for (was, other) in [("[2, 0, 0]", format!("[{next}, 0, 0]")), ("[2, 0, 0]", "[2, -0.0, 0]".to_owned())] {
            assert_ne!(id_of(&SCENE.replace(was, &other)), id, "{other}");
        }
        let mesh = |faces: &str| {
            let vertices = "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]";
            id_of(&SCENE.replace(
                r#"{ "instance": { "of": "a" } }"#,
                &format!(r#"{{ "mesh": {{ "vertices": {vertices}, "faces": {faces} }} }}"#),
            ))
        };
        assert_eq!(mesh("[[0, 1, 2], [1, 3, 2]]"), mesh("[ [0,1,2], [1,3,2] ]"));
        assert_ne!(mesh("[[0, 1, 2], [1, 3, 2]]"), mesh("[[0, 1, 2], [3, 2, 1]]"));
    }

    #[test]
    fn names_the_scene_chose_have_no_order_and_objects_do() {
        let swapped = SCENE.replace(
            r##""red": { "diffuse": [1, 0, 0] }, "blue": { "diffuse": "#0000ff" }"##,
            r##""blue": { "diffuse": "#0000ff" }, "red": { "diffuse": [1, 0, 0] }"##,
        );
        assert_ne!(swapped, SCENE);
        assert_eq!(id_of(&swapped), id_of(SCENE));
        let (a, b) = (r#""a": [{ "sphere": { "center": [2, 0, 0], "radius": 1, "material": "blue" } }]"#, r#""b": ["#);
        let swapped = SCENE.replace(&format!(",\n        {a}"), "").replace(b, &format!("{a}, {b}"));
        assert_ne!(swapped, SCENE);
        assert_eq!(id_of(&swapped), id_of(SCENE));
        let swapped = SCENE.replace(r#""of": "a""#, r#""of": "c""#).replace(r#""of": "b""#, r#""of": "a""#);
        assert_ne!(id_of(&swapped.replace(r#""of": "c""#, r#""of": "b""#)), id_of(SCENE));
    }

    #[test]
    fn the_canonical_text_is_a_scene_with_the_same_name() {
        let mut first = description(SCENE);
        let text = canonical(&mut first);
        let mut second = description(std::str::from_utf8(&text).unwrap());
        assert_eq!(canonical(&mut second), text);
        assert_eq!(id(&mut second), id(&mut first));
        assert!(is_id_of_text(&id(&mut first), &text));
        let as_a_whole = named(&hashed(ID_VERSION_AS_A_WHOLE, |to| write_canonical(&mut first, to)));
        assert!(is_id_of_text(&as_a_whole, &text), "an older version's");
        assert!(is_id_of_text(&named(&Sha256::digest(&text)), &text), "an older version's");
        assert!(!is_id_of_text(&id(&mut first), SCENE.replace("[2, 0, 0]", "[2, 0, 1]").as_bytes()));
        assert_eq!(first.objects.len(), 2, "the description is whole again");
    }

    #[test]
    fn image_ids_are_read_as_they_are_written() {
        let of = |zoom| ImageId { scene: id_of(SCENE), zoom };
        for zoom in [0, 1, MAX_ZOOM] {
            let text = of(zoom).to_string();
            assert!(text.bytes().all(|b| matches!(b, b'a'..=b'z' | b'2'..=b'7' | b'_')), "{text}");
            assert_eq!(ImageId::read(&text), Some(of(zoom)));
        }
        let text = of(0).to_string();
        let other_renderer = text.replace(renderer(), "aaaaaa");
        for wrong in ["", "i_", "i_ä", &text[..40], &format!("{text}a"), &other_renderer, &of(MAX_ZOOM + 1).to_string()]
        {
            assert_eq!(ImageId::read(wrong), None, "{wrong}");
        }
    }
}
