//! Models in scenes: each becomes a definition with its meshes, with materials of its own, and an instance of that. Models that
//! say the same are one definition.

use super::bodies;
use super::copy_budget::CopyBudget;
use super::{ModelOptions, materials, read_upright};
use crate::control;
use crate::enum_names::list;
use crate::models::Warning;
use crate::models::parts::exact_or_plain;
use crate::scene::Files;
use crate::scene::assets;
use crate::scene::description::{
    Description, Fidelity, Instance, Material, ModelBodies, ModelPlace, Object, PictureNames, PlacedModel, ReadModels,
    Transform,
};
use crate::scene::named::Named;
use crate::scene::problem::{Code, Problem, Problems, did_you_mean, push_token, quoted, unless_cancelled};
use crate::scene::recognise::model_format;
use std::collections::HashMap;
use std::sync::Arc;

/// Models of one scene. Each is a file that is read.
const MODELS: usize = 1_000;

/// Reads the models of a scene that has any.
pub(in crate::scene) fn read_models(description: &mut Description, files: &dyn Files) -> Result<(), Problems> {
    if !description.lacks_models() {
        return Ok(());
    }
    let mut reader = Reader {
        files,
        prefix: free_prefix(description),
        known: Vec::new(),
        definitions: Named::default(),
        materials: Named::default(),
        places: HashMap::new(),
        replaceable: HashMap::new(),
        warnings: Vec::new(),
        problems: Vec::new(),
        pictures: PictureNames::default(),
        from_files: false,
        copied: CopyBudget::default(),
    };
    let objects = reader.list(&description.objects, "/objects");
    let mut definitions = Named::default();
    for (name, objects) in description.definitions.iter() {
        definitions.insert(name.clone(), reader.list(objects, &push_token("/definitions", name)));
    }
    unless_cancelled()?;
    if !reader.problems.is_empty() {
        return Err(Problems(reader.problems));
    }
    let Reader { definitions: own, materials, places, replaceable, warnings, pictures, from_files, .. } = reader;
    definitions.extend(own);
    let (objects, definitions) = (Arc::new(objects), Arc::new(definitions));
    description.models = ReadModels::new(ModelBodies {
        objects,
        definitions,
        materials,
        places,
        replaceable,
        warnings,
        pictures,
        from_files,
    });
    Ok(())
}

/// What no name of the scene begins with.
fn free_prefix(description: &Description) -> String {
    let names = || description.definitions.keys().chain(description.materials.keys());
    let mut prefix = "model".to_owned();
    while names().any(|name| name.starts_with(&prefix)) {
        prefix.push('_');
    }
    prefix
}

struct Reader<'a> {
    files: &'a dyn Files,
    prefix: String,
    /// What has been read, and the definition that it is.
    known: Vec<(PlacedModel, String)>,
    definitions: Named<Vec<Object>>,
    materials: Named<Material>,
    places: HashMap<String, ModelPlace>,
    replaceable: HashMap<String, String>,
    warnings: Vec<(Problem, Option<Fidelity>)>,
    problems: Vec<Problem>,
    pictures: PictureNames,
    from_files: bool,
    copied: CopyBudget,
}

impl Reader<'_> {
    /// A list with instances in place of models.
    fn list(&mut self, objects: &[Object], pointer: &str) -> Vec<Object> {
        let one = |(index, object): (usize, &Object)| match object {
            Object::Model(model) => self.instance(model, &format!("{pointer}/{index}/model")),
            Object::Group(group) => {
                let mut group = group.clone();
                group.objects = self.list(&group.objects, &format!("{pointer}/{index}/group/objects"));
                Object::Group(group)
            }
            other => other.clone(),
        };
        objects.iter().enumerate().map(one).collect()
    }

    fn instance(&mut self, model: &PlacedModel, pointer: &str) -> Object {
        // Where it stands and what it is called does not change what it is.
        let said = PlacedModel { transform: Transform::default(), motion: None, name: None, ..model.clone() };
        let known = || self.known.iter().find(|(known, _)| *known == said).map(|(_, name)| name.clone());
        // After a problem, or once nobody waits, nothing more is read: there is no scene.
        let is_over = !self.problems.is_empty() || control::step(self.known.len() as u32 / 64 + 1);
        let of = match if is_over { Some(String::new()) } else { known() } {
            Some(name) => name,
            None => {
                let name = format!("{} {}", self.prefix, self.known.len());
                if let Err(Problems(mut problems)) = self.read(&said, &name, pointer) {
                    self.problems.append(&mut problems);
                }
                self.known.push((said, name.clone()));
                name
            }
        };
        if let Some(object) = pointer.strip_suffix("model") {
            let here = ModelPlace { meant: pointer.to_owned(), in_text: true };
            self.places.insert(format!("{object}instance"), here);
        }
        let (transform, motion, name) = (model.transform, model.motion, model.name.clone());
        Object::Instance(Box::new(Instance { of, transform, motion, name }))
    }

    /// Reads a model into a definition of that name.
    fn read(&mut self, said: &PlacedModel, name: &str, pointer: &str) -> Result<(), Problems> {
        unless_cancelled()?;
        let asset = format!("{pointer}/asset");
        if self.known.len() >= MODELS {
            let detail = format!("a scene has at most {MODELS} models that differ");
            return Err(Problems::one(Problem::new(pointer, Code::Limit, detail)));
        }
        if said.t.is_some_and(|t| !ModelOptions::is_time(t)) {
            let detail = "must be at least 0, where the animation begins";
            return Err(Problems::one(Problem::new(format!("{pointer}/t"), Code::OutOfRange, detail)));
        }
        let by_hash = assets::hash_of(&said.asset);
        self.from_files |= by_hash.is_none();
        let bytes = self.files.read(&said.asset).map_err(|why| {
            let (code, detail) = Problem::unread(&said.asset, &why);
            Problems::one(Problem::new(&asset, code, detail))
        })?;
        let format = model_format(&bytes, by_hash.is_none().then_some(said.asset.as_str())).ok_or_else(|| {
            let detail = "the file is no model: glTF, OBJ, STL and PLY are read";
            Problems::one(Problem::new(&asset, Code::OtherFormat, detail))
        })?;
        // A name inside of a file with a hash could mean anything.
        let part = |part: &str| match by_hash {
            Some(_) => {
                Err("is another file: a model that a scene names by its hash is one file, such as .glb".to_owned())
            }
            None => exact_or_plain(part, |name| self.files.read(name)),
        };
        let options = ModelOptions {
            scene: said.scene,
            animation: said.animation,
            t: said.t,
            variant: said.variant,
            up: said.up,
            ..ModelOptions::NONE
        };
        let mut model = read_upright(format, &bytes, &part, &options).map_err(|problems| inside(problems, &asset))?;
        drop(bytes);
        self.copied.take_model(&model, self.files, pointer)?;
        let mut warnings = std::mem::take(&mut model.warnings);
        let of_fast = materials::without_rays(&model);
        let named: Vec<Option<String>> = model.materials.iter().map(|material| material.name.clone()).collect();
        let (mut materials, names, pictures) = materials::materials(&mut model, &format!("{name}: "), &mut warnings);
        let (definitions, objects) = bodies::objects(&mut model, &names, &format!("{name} "));
        self.pictures.append(pictures);
        for (own, named) in names.iter().zip(&named) {
            if let Some(named) = named {
                let at = push_token(&format!("{pointer}/materials"), named);
                self.replaceable.insert(push_token("/materials", own), at);
            }
        }
        for (of, material) in &said.materials {
            let at = push_token(&format!("{pointer}/materials"), of);
            let mut found = false;
            let bytes = serde_json::to_vec(material).map_or(0, |json| json.len());
            for (own, _) in names.iter().zip(&named).filter(|(_, named)| named.as_deref() == Some(of)) {
                self.copied.take(bytes, &at)?;
                materials.insert(own.clone(), material.clone());
                self.places.insert(push_token("/materials", own), ModelPlace { meant: at.clone(), in_text: true });
                found = true;
            }
            if !found {
                let own: Vec<&str> = named.iter().flatten().map(String::as_str).collect();
                let near = did_you_mean(of, own.iter().copied());
                let hint = if near.is_empty() { names_of(&own) } else { near };
                let detail = format!("the model has no material {}{hint}", quoted(of));
                return Err(Problems::one(Problem::new(at, Code::UnknownReference, detail)));
            }
        }
        for list in ["/definitions", "/materials"] {
            self.places.insert(push_token(list, name), ModelPlace { meant: pointer.to_owned(), in_text: false });
        }
        let at =
            |warning: Warning, fidelity| (Problem::new(pointer, warning.subject.into(), warning.to_string()), fidelity);
        self.warnings.extend(warnings.into_iter().map(|warning| at(warning, None)));
        self.warnings.extend(of_fast.into_iter().map(|warning| at(warning, Some(Fidelity::Fast))));
        self.materials.extend(materials);
        self.definitions.extend(definitions);
        self.definitions.insert(name.to_owned(), objects);
        Ok(())
    }
}

/// Names of materials that a problem lists.
const NAMES_SHOWN: usize = 8;

/// What materials there are, at the end of a sentence.
fn names_of(own: &[&str]) -> String {
    let shown = own.iter().take(NAMES_SHOWN).map(|name| quoted(name));
    match own.len() {
        0 => ": none of its materials has a name".to_owned(),
        1..=NAMES_SHOWN => format!(": it has {}", list(shown, "and")),
        _ => format!(": it has {} and more", shown.collect::<Vec<_>>().join(", ")),
    }
}

/// The problems of a model as those of the scene that names it.
fn inside(Problems(problems): Problems, pointer: &str) -> Problems {
    let one = |problem: Problem| Problem::new(pointer, problem.code, format!("in the model: {problem}"));
    Problems(problems.into_iter().map(one).collect())
}
