//! Assets: files that a scene names by the SHA-256 of their bytes, as `sha256:` and 64 hexadecimal digits. Such a name never means
//! other bytes, so a scene that names its files like this is as whole as one that contains them.

use super::description::{Description, Object};
use super::pictures::sources;
use super::problem::{Code, Problem, Problems};
use super::{Files, problem};
use std::collections::HashSet;

/// What the name of an asset begins with.
pub const SCHEME: &str = "sha256:";
/// Hexadecimal digits of a SHA-256.
const DIGITS: usize = 64;

/// Whether a text is a SHA-256 in hexadecimal digits, small letters.
pub fn is_hash(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// The hash in the name of an asset.
pub fn hash_of(name: &str) -> Option<&str> {
    name.strip_prefix(SCHEME).filter(|hash| is_hash(hash))
}

/// The hashes in a text that may name assets, each once.
pub fn named_in(text: &[u8]) -> Vec<String> {
    let mut named = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.windows(SCHEME.len()).position(|window| window == SCHEME.as_bytes()) {
        rest = &rest[at + SCHEME.len()..];
        if let Some(hash) =
            rest.get(..DIGITS).and_then(|hash| std::str::from_utf8(hash).ok()).filter(|hash| is_hash(hash))
            && !named.iter().any(|known| known == hash)
        {
            named.push(hash.to_owned());
        }
    }
    named
}

/// The names of all assets of a scene, each with its JSON pointer.
fn names(description: &Description) -> Vec<(&str, String)> {
    let mut names: Vec<(&str, String)> =
        sources(description).filter(|(source, _)| source.starts_with(SCHEME)).collect();
    let mut models = Vec::new();
    list("/objects", &description.objects, &mut models);
    for (name, objects) in description.definitions.iter() {
        list(&problem::push_token("/definitions", name), objects, &mut models);
    }
    names.extend(models.into_iter().filter(|(asset, _)| asset.starts_with(SCHEME)));
    names
}

/// The assets of the models in a list.
fn list<'a>(pointer: &str, objects: &'a [Object], into: &mut Vec<(&'a str, String)>) {
    for (index, object) in objects.iter().enumerate() {
        match object {
            Object::Model(model) => into.push((&model.asset, format!("{pointer}/{index}/model/asset"))),
            Object::Group(group) => list(&format!("{pointer}/{index}/group/objects"), &group.objects, into),
            _ => {}
        }
    }
}

/// The hashes of all assets that a scene names, each once. All that are not there are reported at once.
pub(super) fn found(description: &Description, files: &dyn Files) -> Result<Vec<String>, Problems> {
    let (mut found, mut known, mut problems) = (Vec::new(), HashSet::new(), Vec::new());
    for (name, pointer) in names(description) {
        let Some(hash) = hash_of(name) else {
            let detail = "is no name of an asset: write sha256: and 64 hexadecimal digits, small letters";
            problems.push(Problem::new(pointer, Code::Degenerate, detail));
            continue;
        };
        if known.contains(hash) {
            continue;
        }
        known.insert(hash);
        if files.has_asset(hash) {
            found.push(hash.to_owned());
        } else {
            problems.push(Problem::missing_asset(pointer, hash));
        }
    }
    if problems.is_empty() { Ok(found) } else { Err(Problems(problems)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assets_are_found_in_texts() {
        let [one, two] = ["a", "0"].map(|digit| digit.repeat(DIGITS));
        let text = format!(r#"{{"a": "sha256:{one}", "b": ["sha256:{two}", "sha256:{one}", "sha256:{}"]}}"#, &one[1..]);
        assert_eq!(named_in(text.as_bytes()), [one.clone(), two]);
        assert_eq!(hash_of(&format!("sha256:{one}")), Some(one.as_str()));
        assert!(hash_of(&one).is_none() && hash_of(&format!("sha256:{}", one.to_uppercase())).is_none());
    }
}
