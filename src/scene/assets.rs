//! Assets: files that a scene names by the SHA-256 of their bytes, as `sha256:` and 64 hexadecimal digits. Such a name never means
//! other bytes, so a scene that names its files like this is as whole as one that contains them.

pub use super::hashes::{SCHEME, hash_of, is_hash, named_in};

use super::description::{Description, Object};
use super::pictures::{sources, sources_of};
use super::problem::{Code, Problem, Problems};
use super::{Files, problem};
use std::collections::HashSet;

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

/// The assets of the models in a list, and the pictures of what replaces their materials.
fn list<'a>(pointer: &str, objects: &'a [Object], into: &mut Vec<(&'a str, String)>) {
    for (index, object) in objects.iter().enumerate() {
        match object {
            Object::Model(model) => {
                let at = format!("{pointer}/{index}/model");
                into.push((&model.asset, format!("{at}/asset")));
                for (name, material) in &model.materials {
                    into.extend(sources_of(material, &problem::push_token(&format!("{at}/materials"), name)));
                }
            }
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
