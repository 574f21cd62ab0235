//! Models of other programs in a scene, and what they are once they have been read.

use super::object::{Motion, Object, Transform};
use super::picture_names::PictureNames;
use super::sameness::{are_same, are_same_definitions};
use super::{Description, Fidelity, Material};
use crate::models::NameOrIndex;
use crate::scene::named::{self, Named};
use crate::scene::problem::Problem;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// A model that another program has written: glTF, OBJ, STL or PLY. Its meshes and materials are in its file; camera, lights and
/// floor are the scene's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacedModel {
    /// The file: `sha256:` and the digits of an asset, or the name of a file. It is whole, without other parts.
    pub asset: String,
    /// Which of its scenes, from 0. Default: the one that it names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<u32>,
    /// Which of its animations is played, by its place from 0 or its name. Default: none, the pose at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub animation: Option<NameOrIndex>,
    /// Seconds since the start of the animation, at least 0, of the first one if none is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub t: Option<f64>,
    /// Which of its variants of materials, by its place from 0 or its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variant: Option<NameOrIndex>,
    /// Which axis of it is up. Default: z for STL, y for all else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Materials in place of its own, by their names in the file.
    #[serde(default, deserialize_with = "named::deserialize", skip_serializing_if = "Named::is_empty")]
    #[schemars(schema_with = "named::schema::<Material>")]
    pub materials: Named<Material>,
    /// Where it is put. Default: as it is in its file.
    #[serde(default)]
    pub transform: Transform,
    /// How it moves while the shutter is open, which blurs it. Default: not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// A name, for people. At most 256 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = 256))]
    pub name: Option<String>,
}

/// An axis that is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum UpAxis {
    Y,
    Z,
}

/// The models of a scene, if they have been read. They follow from what it says, so scenes do not differ by them.
#[derive(Debug, Clone, Default)]
pub struct ReadModels(Option<Arc<ModelBodies>>);

impl PartialEq for ReadModels {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A scene with instances in place of its models.
#[derive(Debug)]
pub(in crate::scene) struct ModelBodies {
    /// Its objects.
    pub(in crate::scene) objects: Arc<Vec<Object>>,
    /// Its definitions, and those of the models.
    pub(in crate::scene) definitions: Arc<Named<Vec<Object>>>,
    /// The materials of the models.
    pub(in crate::scene) materials: Named<Material>,
    /// What pointers mean that are not in the text, by what they begin with.
    pub(in crate::scene) places: HashMap<String, ModelPlace>,
    /// Where the text may replace the named materials of the models, by their pointers in the scene with instances.
    pub(in crate::scene) replaceable: HashMap<String, String>,
    /// What of the models is approximated or left out, and with which fidelity if not with each: models are kept for all.
    pub(in crate::scene) warnings: Vec<(Problem, Option<Fidelity>)>,
    /// What the models call their pictures.
    pub(in crate::scene) pictures: PictureNames,
    /// Whether any was a file whose content may change.
    pub(in crate::scene) from_files: bool,
    /// What the names of their definitions and materials begin with, before a number.
    pub(in crate::scene) prefix: String,
}

/// What is meant by a part of a scene with instances that is not in its text.
#[derive(Debug)]
pub(in crate::scene) struct ModelPlace {
    /// Its pointer in the text.
    pub(in crate::scene) meant: String,
    /// Whether the rest of a pointer is in the text; what is in the file of a model is not.
    pub(in crate::scene) in_text: bool,
}

impl ModelBodies {
    /// What is approximated or left out with a fidelity.
    pub(in crate::scene) fn warnings(&self, fidelity: Fidelity) -> impl Iterator<Item = Problem> {
        let holds = move |(_, of): &&(Problem, Option<Fidelity>)| of.is_none_or(|of| of == fidelity);
        self.warnings.iter().filter(holds).map(|(warning, _)| warning.clone())
    }

    /// Takes out of a sentence what the names of materials begin with, which the scene's text does not say.
    pub(in crate::scene) fn remove_prefixes(&self, sentence: &mut String) {
        let start = format!("{} ", self.prefix);
        while let Some(at) = sentence.find(&start) {
            let behind = &sentence[at + start.len()..];
            let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
            let colon = if behind[digits..].starts_with(": ") { 2 } else { 0 };
            sentence.replace_range(at..at + start.len() + digits + colon, "");
        }
    }

    /// Turns a pointer into the scene with instances into one into the scene's text; whether it had to.
    pub(in crate::scene) fn place(&self, pointer: &mut String) -> bool {
        // Names of what is in a file begin with that of its model.
        let ends = pointer.bytes().enumerate().filter(|(_, byte)| b"/ :".contains(byte)).map(|(end, _)| end);
        let ends = ends.chain([pointer.len()]).collect::<Vec<_>>().into_iter().rev();
        let meant = ends.into_iter().find_map(|end| {
            let (before, rest) = pointer.split_at(end);
            let ModelPlace { meant, in_text } = self.places.get(before)?;
            match in_text {
                true => (rest.is_empty() || rest.starts_with('/')).then(|| format!("{meant}{rest}")),
                false => Some(meant.clone()),
            }
        });
        let found = meant.is_some();
        if let Some(meant) = meant {
            *pointer = meant;
        }
        found
    }
}

impl ReadModels {
    pub(in crate::scene) fn new(bodies: ModelBodies) -> Self {
        Self(Some(Arc::new(bodies)))
    }

    pub(in crate::scene) fn get(&self) -> Option<&ModelBodies> {
        self.0.as_deref()
    }
}

fn is_or_has_model(object: &Object) -> bool {
    match object {
        Object::Model(_) => true,
        Object::Group(group) => group.objects.iter().any(is_or_has_model),
        _ => false,
    }
}

impl Description {
    /// The scene with instances in place of its models, if they have been read.
    pub fn whole(&self) -> Cow<'_, Self> {
        let Some(bodies) = self.models.get() else { return Cow::Borrowed(self) };
        let mut whole = self.clone();
        whole.materials.extend(bodies.materials.iter().map(|(name, material)| (name.clone(), material.clone())));
        (whole.objects, whole.definitions) = (Arc::clone(&bodies.objects), Arc::clone(&bodies.definitions));
        whole.models = ReadModels::default();
        Cow::Owned(whole)
    }

    /// Whether it places models that have not been read.
    pub fn lacks_models(&self) -> bool {
        let any = |objects: &Vec<Object>| objects.iter().any(is_or_has_model);
        self.models.get().is_none() && (any(&self.objects) || self.definitions.values().any(any))
    }

    /// What of its models is approximated or left out.
    pub(in crate::scene) fn warnings_of_models(&self) -> Vec<Problem> {
        self.models.get().map_or_else(Vec::new, |models| models.warnings(self.render.fidelity).collect())
    }

    /// Whether it places models, and they have been read.
    pub fn has_models(&self) -> bool {
        self.models.get().is_some()
    }

    /// Takes what is known of the models of another scene with the same objects, unless that has the name of a material of this one.
    pub(in crate::scene) fn take_models_of(&mut self, other: &Self) {
        let is_free = |bodies: &ModelBodies| !self.materials.keys().any(|name| bodies.materials.contains_key(name));
        if other.models.get().is_some_and(is_free) {
            self.models = other.models.clone();
        }
    }

    /// Shares the objects of another scene if they are the same, with what is known of their models; whether they are.
    pub(in crate::scene) fn takes_objects_of(&mut self, other: &Self) -> bool {
        let same =
            are_same(&self.objects, &other.objects) && are_same_definitions(&self.definitions, &other.definitions);
        if same {
            (self.objects, self.definitions) = (Arc::clone(&other.objects), Arc::clone(&other.definitions));
            self.take_models_of(other);
        }
        same
    }

    /// Objects and definitions as they are built.
    pub(in crate::scene) fn built(&self) -> (&Arc<Vec<Object>>, &Arc<Named<Vec<Object>>>) {
        match self.models.get() {
            Some(bodies) => (&bodies.objects, &bodies.definitions),
            None => (&self.objects, &self.definitions),
        }
    }
}
