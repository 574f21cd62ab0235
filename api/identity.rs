//! What a scene and its picture are called: names made from what they are, so that the same scene has the same name
//! everywhere, and a picture's name is known before a ray is traced.
//!
//! - The **canonical text** of a scene is its description as JSON: defaults filled in, keys in the order of the alphabet,
//!   without white space and `$schema`. What the scene says counts, not how it was written, nor in which format.
//! - Its **scene id** is a hash of that text.
//! - An **image id** is a hash of the scene id, the zoom and the renderer. It changes with everything that may change a
//!   pixel, and with nothing else: pictures depend on neither threads nor machines.

#![allow(dead_code, reason = "the caches, which use it, come next")]

use data_encoding::BASE32_NOPAD;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::io::{self, Write};
use strahl::render::RENDER_EPOCH;
use strahl::scene::Description;
use strahl::scene::description::{Accuracy, RenderSettings};

/// Largest zoom: a scene may be opened as 2^16 times its size.
pub(crate) const MAX_ZOOM: u32 = 16;

/// Bytes of a hash that become an id: 160 bits, 32 letters.
const ID_BYTES: usize = 20;

/// Whether the same settings give the same picture on any machine. Those that a clock decides do not.
pub(crate) fn is_reproducible(settings: &RenderSettings) -> bool {
    match settings.accuracy {
        Accuracy::Fixed(_) => true,
    }
}

/// Name of a scene: `s_` and 32 letters of `a-z2-7`. The description is the same afterwards, but for `$schema`.
pub(crate) fn scene_id(description: &mut Description) -> String {
    let mut hash = Hash(Sha256::new());
    // A hash takes any amount of bytes, and a description is made of what JSON can say.
    let _ = write_canonical(description, &mut hash);
    id("s_", hash.0)
}

/// The canonical text of a scene.
pub(crate) fn canonical(description: &mut Description) -> Vec<u8> {
    let mut text = Vec::new();
    // As above: neither memory nor serde_json refuses anything here.
    let _ = write_canonical(description, &mut text);
    text
}

/// Name of the picture of a scene, opened as 2^zoom times its size, as this renderer makes it: `i_` and 32 letters.
pub(crate) fn image_id(scene_id: &str, zoom: u32) -> String {
    let renderer = concat!("strahl ", env!("CARGO_PKG_VERSION"));
    id("i_", Sha256::new().chain_update(format!("{renderer} {RENDER_EPOCH} {scene_id} {zoom}")))
}

/// Whether a text looks like a scene id (`s`) or an image id (`i`).
pub(crate) fn is_id(text: &str, letter: char) -> bool {
    text.strip_prefix(letter).and_then(|rest| rest.strip_prefix('_')).is_some_and(|rest| {
        rest.len() == ID_BYTES * 8 / 5 && rest.bytes().all(|b| matches!(b, b'a'..=b'z' | b'2'..=b'7'))
    })
}

fn id(kind: &str, hash: Sha256) -> String {
    format!("{kind}{}", BASE32_NOPAD.encode(&hash.finalize()[..ID_BYTES]).to_ascii_lowercase())
}

/// Objects and definitions, which may be large, go out as they are; the rest goes through a map, which sorts its keys.
fn write_canonical(description: &mut Description, to: &mut impl Write) -> io::Result<()> {
    description.schema = None;
    let objects = std::mem::take(&mut description.objects);
    let definitions = std::mem::take(&mut description.definitions);
    let written = serde_json::to_value(&*description).map_err(io::Error::from).and_then(|rest| {
        let rest = rest.as_object().into_iter().flatten();
        let mut by_name: Vec<_> = definitions.iter().collect();
        by_name.sort_unstable_by_key(|(name, _)| *name);
        write_object(to, rest, |key, to| match key {
            "objects" => Some(write_json(to, &objects)),
            "definitions" => Some(write_object(to, by_name.iter().copied(), |_, _| None)),
            _ => None,
        })
    });
    (description.objects, description.definitions) = (objects, definitions);
    written
}

/// A JSON object; `instead` may write the value of a key.
fn write_object<'a, W: Write, K: AsRef<str> + 'a + ?Sized, V: Serialize + 'a + ?Sized>(
    to: &mut W,
    entries: impl Iterator<Item = (&'a K, &'a V)>,
    instead: impl Fn(&str, &mut W) -> Option<io::Result<()>>,
) -> io::Result<()> {
    to.write_all(b"{")?;
    for (i, (key, value)) in entries.enumerate() {
        if i > 0 {
            to.write_all(b",")?;
        }
        write_json(to, key.as_ref())?;
        to.write_all(b":")?;
        instead(key.as_ref(), to).unwrap_or_else(|| write_json(to, value))?;
    }
    to.write_all(b"}")
}

fn write_json(to: &mut impl Write, value: &(impl Serialize + ?Sized)) -> io::Result<()> {
    serde_json::to_writer(to, value).map_err(io::Error::from)
}

/// A hash as something to write to.
struct Hash(Sha256);

impl Write for Hash {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
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

    fn id_of(json: &str) -> String {
        scene_id(&mut description(json))
    }

    #[test]
    fn what_a_scene_says_counts_not_how_it_is_written() {
        let id = id_of(SCENE);
        assert!(is_id(&id, 's') && !is_id(&id, 'i') && !is_id("s_short", 's'), "{id}");
        for (other, why) in [
            (SCENE.replace(['\n', ' '], ""), "white space"),
            (SCENE.replace(r#""version": 1,"#, r#""version": 1, "$schema": "somewhere","#), "where the schema lies"),
            (
                SCENE.replace(r#""version": 1,"#, r#""render": { "max_depth": 10 }, "version": 1,"#),
                "a default written down",
            ),
            (
                SCENE.replace(
                    r#""eye": [0, 1, 5], "look_at": [0, 0, 0]"#,
                    r#""look_at": [0.0, 0, 0], "eye": [0, 1, 5]"#,
                ),
                "order",
            ),
            (SCENE.replace("\"#0000ff\"", "[0, 0, 1]"), "how a colour is written"),
        ] {
            assert_eq!(id_of(&other), id, "{why}");
        }
        assert_ne!(id_of(&SCENE.replace("[2, 0, 0]", "[2, 0, 1]")), id);
        assert_ne!(id_of(&SCENE.replace("[1, 0, 0]", "[1, 0.5, 0]")), id);
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
        assert_eq!(scene_id(&mut second), scene_id(&mut first));
        assert_eq!(first.objects.len(), 2, "the description is whole again");
    }

    #[test]
    fn zoomed_pictures_have_names_of_their_own() {
        let id = image_id("s_a", 0);
        assert!(is_id(&id, 'i'), "{id}");
        assert_ne!(id, image_id("s_a", 1));
        assert_ne!(id, image_id("s_b", 0));
    }
}
