//! Cryptomatte (Friedman and Jones, "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH 2015;
//! specification 1.2): the ids of what a pixel shows, ranked by their shares of it. An id is the hash of a name.

use super::layers::Channel;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// How many ids a pixel has at most; of more, those with the least shares are left out.
pub const RANKS: usize = 6;

/// The ids of a pixel with their shares, the largest first; shares of 0 fill up.
pub type Ranks = [(u32, f32); RANKS];

/// Names as ids of each pixel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cryptomatte {
    /// What it is called: `crypto_object`.
    pub name: &'static str,
    /// Row by row.
    pub pixels: Vec<Ranks>,
    /// The names in the picture, with their ids.
    pub manifest: BTreeMap<String, u32>,
}

/// The id of a name: its hash, with one bit turned where the hash is no ordinary number as a float.
pub fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let is_ordinary = !matches!(hash >> 23 & 255, 0 | 255);
    if is_ordinary { hash } else { hash ^ 1 << 23 }
}

/// MurmurHash3_x86_32 with seed 0 (Appleby 2011, public domain).
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, rest) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0u32, |hash, block| {
        (hash ^ mixed(u32::from_le_bytes(*block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= mixed(u32::from_le_bytes(last)) ^ bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

impl Cryptomatte {
    /// Its channels: two ranks in each of `crypto_object00`, `crypto_object01` and `crypto_object02`.
    pub(super) fn channels(&self) -> impl Iterator<Item = Channel> {
        (0..2 * RANKS).map(|channel| {
            let (rank, is_share) = (channel / 2, channel % 2 == 1);
            let letter = ["R", "G", "B", "A"][channel % 4];
            let value = |ranks: &Ranks| if is_share { ranks[rank].1 } else { f32::from_bits(ranks[rank].0) };
            Channel {
                name: format!("{}{:02}.{letter}", self.name, channel / 4),
                values: self.pixels.iter().map(value).collect(),
            }
        })
    }

    /// What a file says about it, for programs to find names by their ids.
    pub(super) fn attributes(&self) -> [(String, String); 4] {
        let key = &format!("{:08x}", murmur3(self.name.as_bytes()))[..7];
        let of = |what: &str, value: &str| (format!("cryptomatte/{key}/{what}"), value.to_owned());
        [
            of("name", self.name),
            of("hash", "MurmurHash3_32"),
            of("conversion", "uint32_to_float32"),
            of("manifest", &ascii(&self.listed(|id| format!("{id:08x}")))),
        ]
    }

    /// The manifest as JSON, with what stands for each id.
    pub(super) fn listed(&self, shown: impl Fn(u32) -> String) -> String {
        let names = self.manifest.iter().map(|(name, id)| (name.clone(), Value::String(shown(*id))));
        Value::Object(names.collect::<Map<_, _>>()).to_string()
    }
}

/// JSON in ASCII: attributes of files are read in any encoding.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            c if c.is_ascii() => text.push(c),
            c => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| text += &format!("\\u{unit:04x}")),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of the hash's author and of public test vectors, and the examples of the reference implementation's own tests.
    #[test]
    fn ids_are_those_that_are_published() {
        for (name, hash) in [
            ("", 0),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(name.as_bytes()), hash, "{name}");
        }
        for (name, number) in
            [("hello", 6.070_563e-17), ("cube", -4.084_619e15), ("sphere", 2.790_186e15), ("plane", 3.665_576e-11)]
        {
            let found = f32::from_bits(id(name));
            assert!((found / number - 1.0).abs() < 1e-6, "{name}: {found:e}");
        }
    }

    #[test]
    fn ids_are_ordinary_numbers() {
        assert!((0..200_000).all(|i| f32::from_bits(id(&format!("/objects/{i}"))).is_normal()));
        // Without the bit this one would be no number, and that of the empty name 0.
        let is_odd = |i: &u32| matches!(murmur3(format!("{i}").as_bytes()) >> 23 & 255, 0 | 255);
        let odd = (0..).find(is_odd).unwrap().to_string();
        assert_eq!(id(&odd) ^ murmur3(odd.as_bytes()), 1 << 23);
    }

    #[test]
    fn manifests_are_ascii() {
        assert_eq!(ascii("{\"/materials/gl\u{e4}s\u{1f52e}\":\"1\"}"), r#"{"/materials/gl\u00e4s\ud83d\udd2e":"1"}"#);
    }
}
