//! Neutral File Format, version 3.9 (E. Haines, NFF.TXT of the Standard Procedural Databases, SPD), plain or gzip.
//!
//! Where NFF.TXT is not specific:
//! - Lights and ambient light each have the intensity sqrt(n) / 2n for n lights, as the SPD's Readme suggests; a file
//!   without lights has the ambient light of one. A light's color, if given, is multiplied by it too, so that white is
//!   the same as no color.
//! - The object's color tints the diffuse part alone; highlights, mirror rays and transmitted rays have the weights
//!   Ks, Ks and T in all channels.
//! - "angle" is vertical when the picture is not square, and ends in the centres of the edge pixels.
//! - Objects before the first fill are white with Kd 0.8.
//! - A cone's apex may be wider than its base.

mod bodies;
mod camera;
mod entity;
mod faces;
mod reader;
mod scene;
mod text;
mod tokens;

#[cfg(test)]
mod tests;

use crate::scene::problem::{Code, Problem, unless_cancelled};
use crate::scene::recognise::recognise;
use crate::scene::{Description, Format, Problems, limits};
use reader::Reader;
use scene::SceneBuilder;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of an NFF file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct NffOptions {
    /// Whether an NFF file's opaque surfaces were seen from behind, too.
    pub two_sided: bool,
    /// Whether an NFF file was rendered by the SPD's counting rules.
    pub spd_counts: bool,
}

/// Reads an NFF file, plain or gzip.
pub fn read_nff(bytes: &[u8], options: NffOptions) -> Result<Description, Problems> {
    if let Some(problem) = recognise(bytes).refused_as(Format::Nff) {
        return Err(Problems::one(problem));
    }
    let text = text::unpack(bytes).map_err(Problems::one)?;
    text::refuse_sense8(&text).map_err(Problems::one)?;
    let mut reader = Reader::new(&text);
    let mut scene = SceneBuilder::new(options);
    let mut problems: Vec<Problem> = Vec::new();
    loop {
        match reader.entity() {
            Ok(None) => break,
            Ok(Some((place, entity))) => problems.extend(scene.add(place, entity).err()),
            Err(problem) => {
                problems.push(problem);
                if let Some((kind, place)) = reader.recover() {
                    scene.skip(place, kind);
                }
            }
        }
        let is_limit = problems.last().is_some_and(|problem| problem.code == Code::Limit);
        if is_limit || problems.len() >= limits::PROBLEMS_FOUND {
            return Err(Problems(problems));
        }
    }
    unless_cancelled()?;
    let description = scene.finish(reader.place(), &mut problems);
    if let Some(description) = description.filter(|_| problems.is_empty()) {
        return Ok(description);
    }
    problems.sort_by_key(|problem| problem.line);
    Err(Problems(problems))
}
