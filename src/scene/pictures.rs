//! The pictures of a scene's textures and environment, each read and decoded once.

use super::description::{
    AlphaMode, Description, Diffuse, ImageMap, Material, Opacity, PictureNames, Relief, TexelChannel, Textured,
};
use super::files::Files;
use super::hashes::hash_of;
use super::limits::{PICTURE_BYTES, PICTURE_MEMORY};
use super::picture_decoding::{Failure, Mask, Meaning, decode};
use super::problem::{Code, Problem, Problems, push_token, unless_cancelled};
use crate::models::data_uri;
use crate::shading::texture::mipmap::Mipmap;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Pictures that cannot be read, after which no others are looked at.
const BROKEN_PICTURES: usize = 10;

/// The meaning of a picture that has a number in one of its channels.
pub(super) fn number_of(textured: &Textured<f64>) -> Meaning {
    if textured.channel == Some(TexelChannel::A) { Meaning::Alpha } else { Meaning::Data }
}

/// The meaning of the picture of an opacity.
pub(super) fn alpha_of(opacity: &Opacity, textured: &Textured<f64>) -> Meaning {
    match opacity.mode {
        AlphaMode::Blend => number_of(textured),
        AlphaMode::Mask => {
            let channel = textured.channel.unwrap_or_default() as u8;
            // The number that makes alpha, times its factor, as much as is needed.
            let least = (opacity.cutoff / textured.factor) as f32;
            Meaning::Mask(Mask { channel, least: least.to_bits() })
        }
    }
}

/// What a picture is of: its source, and the meaning of its numbers.
type Key<'a> = (&'a str, Meaning);

/// The pictures that a scene was built with, as its description names them.
pub(super) type Decoded<'a> = Vec<(Key<'a>, Arc<Mipmap>)>;

/// Decoded pictures, one for each source and meaning.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    /// As the description names them.
    all: Vec<Arc<Mipmap>>,
    /// By where the source is in memory: it may be a whole picture, and is asked for often.
    places: HashMap<(usize, usize, Meaning), Arc<Mipmap>>,
    /// Whether any came from a file, whose content may change.
    pub(super) from_files: bool,
}

/// Where a source is in memory.
fn place((source, meaning): Key<'_>) -> (usize, usize, Meaning) {
    (source.as_ptr() as usize, source.len(), meaning)
}

impl Pictures {
    /// Reads all pictures of a description that are not `known`.
    pub(super) fn read(description: &Description, files: &dyn Files, known: Decoded<'_>) -> Result<Self, Problems> {
        let mut pictures = Self::default();
        let mut problems = Vec::new();
        let mut left = PICTURE_MEMORY.max;
        let mut counted = HashSet::new();
        let mut decoded: HashMap<Key<'_>, Arc<Mipmap>> = HashMap::new();
        let mut others: Option<HashMap<Key<'_>, Arc<Mipmap>>> = None;
        for (i, (source, meaning, pointer)) in wanted(description).into_iter().enumerate() {
            unless_cancelled()?;
            let key = (source, meaning);
            pictures.from_files |= !is_url(source);
            // Mostly it is in the same place as in the other scene.
            let before = known.get(i).filter(|(other, _)| *other == key).map(|(_, mipmap)| Arc::clone(mipmap));
            let before = before.filter(|_| is_url(source)).or_else(|| {
                let of_others = || known.iter().filter(|((source, _), _)| is_url(source)).cloned().collect();
                let others = if known.is_empty() { None } else { Some(others.get_or_insert_with(of_others)) };
                others.and_then(|others| others.get(&key)).or_else(|| decoded.get(&key)).map(Arc::clone)
            });
            if let Some(mipmap) = before {
                if counted.insert(Arc::as_ptr(&mipmap) as usize) {
                    left = left.saturating_sub(mipmap.bytes() as u64);
                }
                pictures.keep(key, mipmap);
                continue;
            }
            match bytes(source, files).and_then(|bytes| decode(&bytes, meaning, &mut left, files)) {
                Ok(mipmap) => {
                    let mipmap = Arc::new(mipmap);
                    counted.insert(Arc::as_ptr(&mipmap) as usize);
                    decoded.insert(key, Arc::clone(&mipmap));
                    pictures.keep(key, mipmap);
                }
                Err((code, detail)) => problems.push(Problem::new(pointer, code, detail)),
            }
            // Each takes as long as a picture that can be read.
            if problems.len() >= BROKEN_PICTURES {
                break;
            }
        }
        if problems.is_empty() { Ok(pictures) } else { Err(Problems(problems)) }
    }

    fn keep(&mut self, key: Key<'_>, mipmap: Arc<Mipmap>) {
        self.places.insert(place(key), Arc::clone(&mipmap));
        self.all.push(mipmap);
    }

    /// A picture that was read, by the source in the description that it was read for.
    pub(super) fn get(&self, source: &str, meaning: Meaning) -> Arc<Mipmap> {
        let known = self.places.get(&place((source, meaning)));
        Arc::clone(known.unwrap_or_else(|| unreachable!("all pictures have been read")))
    }

    /// All of them, as the description names them.
    pub(super) fn all(&self) -> &[Arc<Mipmap>] {
        &self.all
    }
}

/// Bytes of pictures, each counted once, without those that are among `others`.
pub(super) fn bytes_of(pictures: &[Arc<Mipmap>], others: &[Arc<Mipmap>]) -> usize {
    let place = |mipmap: &Arc<Mipmap>| Arc::as_ptr(mipmap) as usize;
    let mut counted: HashSet<usize> = others.iter().map(place).collect();
    pictures.iter().filter(|mipmap| counted.insert(place(mipmap))).map(|mipmap| mipmap.bytes()).sum()
}

/// The pictures that a scene was built with.
pub(super) fn known<'a>(description: &'a Description, pictures: &[Arc<Mipmap>]) -> Decoded<'a> {
    let keys = wanted(description).into_iter().map(|(source, meaning, _)| (source, meaning));
    keys.zip(pictures.iter().map(Arc::clone)).collect()
}

/// The pictures of a description, with the JSON pointer of each.
fn wanted(description: &Description) -> Vec<(&str, Meaning, String)> {
    let mut wanted = Vec::new();
    if let Some(image) = description.environment.as_ref().and_then(|environment| environment.image.as_ref()) {
        wanted.push((image.as_str(), Meaning::Radiance, "/environment/image".to_owned()));
    }
    for (name, material) in description.materials.iter() {
        wanted_by(material, &push_token("/materials", name), &mut wanted);
    }
    wanted
}

/// The pictures of a material, which has a JSON pointer.
fn wanted_by<'a>(material: &'a Material, pointer: &str, wanted: &mut Vec<(&'a str, Meaning, String)>) {
    let at = |rest: &str| pointer.to_owned() + rest;
    let mut map = |image: &'a ImageMap, meaning, pointer| wanted.push((image.source.as_str(), meaning, pointer));
    if let Some(image) = material.ambient.as_ref().and_then(Diffuse::image) {
        map(image, Meaning::Color, at("/ambient/image/source"));
    }
    if let Some(image) = material.diffuse.image() {
        map(image, Meaning::Color, at("/diffuse/image/source"));
    }
    if let Some(Relief::Image(image)) = material.bump.as_ref().map(|bump| &bump.texture) {
        map(image, Meaning::Height, at("/bump/texture/image/source"));
    }
    if let Some(normals) = &material.normal_map {
        map(&normals.image, Meaning::Normal, at("/normal_map/image/source"));
    }
    if let Some(pbr) = &material.pbr {
        let mut keep = |image: &'a str, meaning, key: &str| wanted.push((image, meaning, at(key)));
        for (key, channel) in pbr.colors() {
            if let Some(textured) = channel.textured() {
                keep(&textured.image, Meaning::Color, &format!("/pbr/{key}/image"));
            }
        }
        let numbers = pbr.numbers().into_iter().filter_map(|(key, channel)| Some((key, channel.textured()?)));
        for (key, textured) in numbers.chain(pbr.occlusion.as_deref().map(|textured| ("occlusion", textured))) {
            keep(&textured.image, number_of(textured), &format!("/pbr/{key}/image"));
        }
        if let Some(opacity) = pbr.opacity.as_deref()
            && let Some(textured) = opacity.alpha.textured()
        {
            keep(&textured.image, alpha_of(opacity, textured), "/pbr/opacity/alpha/image");
        }
        for (key, map) in pbr.normals() {
            if let Some(map) = map {
                keep(&map.image, Meaning::Normal, &format!("/pbr/{key}/image"));
            }
        }
    }
}

/// The sources of the pictures of a description, with the JSON pointer of each.
pub(super) fn sources(description: &Description) -> impl Iterator<Item = (&str, String)> {
    wanted(description).into_iter().map(|(source, _, pointer)| (source, pointer))
}

/// The same of a material, which has a JSON pointer.
pub(super) fn sources_of<'a>(material: &'a Material, pointer: &str) -> impl Iterator<Item = (&'a str, String)> {
    let mut wanted = Vec::new();
    wanted_by(material, pointer, &mut wanted);
    wanted.into_iter().map(|(source, _, pointer)| (source, pointer))
}

/// Problems with pictures of models, with what their files call them: in place of the pointers, or of models that a scene places
/// in the sentences.
pub(super) fn named(description: &Description, names: &PictureNames, problems: Problems, is_placed: bool) -> Problems {
    if names.is_empty() {
        return problems;
    }
    let sources: HashMap<String, &str> = sources(description).map(|(source, pointer)| (pointer, source)).collect();
    let one = |problem: Problem| {
        let name = sources.get(&problem.pointer).and_then(|source| names.get(source));
        let Some(name) = name else { return problem };
        let detail = &problem.detail;
        match (is_placed, name.starts_with('/')) {
            (true, _) => Problem { detail: format!("in the model: {name}: {detail}"), ..problem },
            (false, true) => Problem { pointer: name.to_owned(), ..problem },
            (false, false) => Problem { pointer: String::new(), detail: format!("{name}: {detail}"), ..problem },
        }
    };
    // A picture with two meanings is one picture of the model.
    Problems(problems.0.into_iter().map(one).collect()).each_once()
}

/// Bytes of the names and contents of pictures in a description.
pub(super) fn source_bytes(description: &Description) -> u64 {
    wanted(description).iter().map(|(source, ..)| source.len() as u64).sum()
}

/// Whether a source is a URL, not the name of a file. (`C:` is a drive.)
fn is_url(source: &str) -> bool {
    let scheme = source.split(':').next().unwrap_or_default();
    scheme.len() > 1
        && scheme.len() < source.len()
        && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
}

/// The bytes of a picture file.
fn bytes(source: &str, files: &dyn Files) -> Result<Vec<u8>, Failure> {
    let bytes = if let Some(bytes) = data_uri::decoded(source) {
        bytes.map_err(|why| (Code::Degenerate, why))?
    } else if is_url(source) && hash_of(source).is_none() {
        let detail = "pictures are never fetched: name a file, or write \"data:image/png;base64,...\"";
        return Err((Code::Unsupported, detail.into()));
    } else {
        files.read(source).map_err(|why| Problem::unread(source, &why))?
    };
    if bytes.len() as u64 > PICTURE_BYTES.max {
        let detail =
            format!("the picture has more bytes than the limit of {} ({})", PICTURE_BYTES.max, PICTURE_BYTES.name);
        return Err((Code::Limit, detail));
    }
    Ok(bytes)
}
