//! Models in scenes: each becomes a definition with its meshes, with materials of its own, and an instance of that. Models that
//! say the same are one definition.

use super::bodies;
use super::copy_budget::CopyBudget;
use super::{ModelOptions, materials, origin, read_upright};
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
use crate::scene::transform::affine;
use glam::{DAffine3, DMat4, DVec3};
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
    let Reader { definitions: own, materials, places, replaceable, warnings, pictures, from_files, prefix, .. } =
        reader;
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
        prefix,
    });
    Ok(())
}

/// What names of models begin with.
const PREFIX: &str = "placed model";

/// What no name in the scene begins with: [`PREFIX`], with a number if there are such names.
fn free_prefix(description: &Description) -> String {
    let mut names: Vec<&str> =
        description.definitions.keys().chain(description.materials.keys()).map(String::as_str).collect();
    referenced_names(&description.objects, &mut names);
    description.definitions.values().for_each(|objects| referenced_names(objects, &mut names));
    // Looked at once: names may be long, and many.
    let number = |rest: &str| {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        rest[..digits].parse().unwrap_or(0_u32)
    };
    match names.iter().filter_map(|name| name.strip_prefix(PREFIX)).map(number).max() {
        None => PREFIX.to_owned(),
        Some(taken) => format!("{PREFIX}{}", u64::from(taken) + 1),
    }
}

/// The names that objects refer to, which need not be there.
fn referenced_names<'a>(objects: &'a [Object], names: &mut Vec<&'a str>) {
    for object in objects {
        match object {
            Object::Group(group) => referenced_names(&group.objects, names),
            Object::Instance(instance) => names.push(&instance.of),
            _ => names.extend(object.appearance().and_then(|appearance| appearance.material)),
        }
    }
}

struct Reader<'a> {
    files: &'a dyn Files,
    prefix: String,
    /// What has been read, the definition that it is, and how far that has been moved to the origin.
    known: Vec<(PlacedModel, String, Option<DVec3>)>,
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
        let known = || self.known.iter().find(|(known, ..)| *known == said).map(|(_, name, by)| (name.clone(), *by));
        // After a problem, or once nobody waits, nothing more is read: there is no scene.
        let is_over = !self.problems.is_empty() || control::step(self.known.len() as u32 / 64 + 1);
        let (of, moved) = match if is_over { Some((String::new(), None)) } else { known() } {
            Some(known) => known,
            None => {
                let name = format!("{} {}", self.prefix, self.known.len());
                let moved = self.read(&said, &name, pointer).unwrap_or_else(|Problems(mut problems)| {
                    self.problems.append(&mut problems);
                    None
                });
                self.known.push((said, name.clone(), moved));
                (name, moved)
            }
        };
        if let Some(object) = pointer.strip_suffix("model") {
            let here = ModelPlace { meant: pointer.to_owned(), in_text: true };
            self.places.insert(format!("{object}instance"), here);
        }
        let transform = moved.map_or(model.transform, |by| moved_back(&model.transform, by));
        let (motion, name) = (model.motion, model.name.clone());
        Object::Instance(Box::new(Instance { of, transform, motion, name }))
    }

    /// Reads a model into a definition of that name. How far it has been moved to the origin.
    fn read(&mut self, said: &PlacedModel, name: &str, pointer: &str) -> Result<Option<DVec3>, Problems> {
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
        let moved = origin::recenter(&mut model);
        materials::add_default(&mut model);
        let named: Vec<String> = model.materials.iter().map(|own| materials::name_of(own).to_owned()).collect();
        let replaced = self.replaced(said, &named, pointer)?;
        for (index, material, _) in &replaced {
            let own = &mut model.materials[*index];
            *own = materials::placeholder(own.name.take(), material);
        }
        let mut warnings = std::mem::take(&mut model.warnings);
        let of_fast = materials::without_rays(&model);
        let indices = replaced.iter().map(|(index, ..)| *index).collect();
        let (mut materials, names, pictures) =
            materials::materials(&mut model, &format!("{name}: "), &indices, &mut warnings);
        let (definitions, objects) = bodies::objects(&mut model, &names, &format!("{name} "));
        self.pictures.append(pictures);
        for (own, named) in names.iter().zip(&named) {
            let at = push_token(&format!("{pointer}/materials"), named);
            self.replaceable.insert(push_token("/materials", own), at);
        }
        for (index, material, at) in replaced {
            materials.insert(names[index].clone(), material.clone());
            self.places.insert(push_token("/materials", &names[index]), ModelPlace { meant: at, in_text: true });
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
        Ok(moved)
    }

    /// The materials of a model that the scene replaces: their indices among those that are so `named`, what replaces them, and
    /// where the scene says so.
    fn replaced<'s>(
        &mut self,
        said: &'s PlacedModel,
        named: &[String],
        pointer: &str,
    ) -> Result<Vec<(usize, &'s Material, String)>, Problems> {
        let (mut replaced, mut indices) = (Vec::new(), HashMap::<&str, Vec<usize>>::new());
        named.iter().enumerate().for_each(|(index, named)| indices.entry(named).or_default().push(index));
        for (of, material) in &said.materials {
            let at = push_token(&format!("{pointer}/materials"), of);
            let bytes = serde_json::to_vec(material).map_or(0, |json| json.len());
            for index in indices.get(of.as_str()).into_iter().flatten() {
                self.copied.take(bytes, &at)?;
                replaced.push((*index, material, at.clone()));
            }
            if !indices.contains_key(of.as_str()) {
                let own: Vec<&str> = named.iter().map(String::as_str).collect();
                let near = did_you_mean(of, own.iter().copied());
                let hint = if near.is_empty() { names_of(&own) } else { near };
                let detail = format!("the model has no material {}{hint}", quoted(of));
                return Err(Problems::one(Problem::new(at, Code::UnknownReference, detail)));
            }
        }
        Ok(replaced)
    }
}

/// The transform of a model whose middle has been moved to the origin, in one step in double precision.
fn moved_back(transform: &Transform, by: DVec3) -> Transform {
    match affine(transform) {
        Ok(map) => {
            let matrix = DMat4::from(map * DAffine3::from_translation(by));
            Transform { matrix: Some(matrix.to_cols_array()), ..Transform::default() }
        }
        // A problem of the scene.
        Err(_) => *transform,
    }
}

/// Names of materials that a problem lists.
const NAMES_SHOWN: usize = 8;

/// What materials there are, at the end of a sentence.
fn names_of(own: &[&str]) -> String {
    let shown = own.iter().take(NAMES_SHOWN).map(|name| quoted(name));
    match own.len() {
        0 => ": it has none".to_owned(),
        1..=NAMES_SHOWN => format!(": it has {}", list(shown, "and")),
        _ => format!(": it has {} and more", shown.collect::<Vec<_>>().join(", ")),
    }
}

/// The problems of a model as those of the scene that names it.
fn inside(Problems(problems): Problems, pointer: &str) -> Problems {
    let one = |problem: Problem| Problem::new(pointer, problem.code, format!("in the model: {problem}"));
    Problems(problems.into_iter().map(one).collect())
}
