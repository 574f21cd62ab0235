//! glTF 2.0 (ISO/IEC 12113), binary or JSON with parts.

mod accessors;
mod animation;
mod buffers;
mod check;
mod draco;
mod extensions;
pub(crate) mod glb;
mod images;
mod json;
mod json_data;
mod json_materials;
mod json_read;
mod materials;
mod meshes;
mod nodes;
mod ranges;
mod skins;

pub(crate) use images::media_type;
pub(crate) use json_read::{ELEMENTS, LIST};
pub(crate) use nodes::{NODE_LEVELS, NODES};

use super::fault::{Fault, Faults, Kind, Subject, warn};
use super::geometry::Geometry;
use super::model::{Lamp, LampKind, Model, ModelCamera, Placement, Projection};
use super::name::{NAME_BYTES, shortened};
use super::{Choice, Parts, counted};
use buffers::Buffers;
use glam::{DMat4, DQuat, DVec3};
use json::{Document, Light, Primitive};
use materials::Materials;
use nodes::Local;
use std::collections::HashMap;

/// What a morph target that is looked at takes, roughly.
const MORPH_BYTES: usize = 64;
/// What an instance takes in a scene that is built, roughly; its accessor may have no bytes at all.
const INSTANCE_BYTES: usize = 2_048;

/// The JSON of a file, in which pointers and offsets of faults are.
pub fn json_of(bytes: &[u8]) -> &[u8] {
    glb::chunks(bytes).map_or(&[], |chunks| chunks.json)
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], parts: &Parts<'_>, choice: Choice) -> Result<Model, Faults> {
    let chunks = glb::chunks(bytes)?;
    let mut document = json_read::read(chunks.json)?;
    extensions::check(&document, choice.strict)?;
    check::check(&document)?;
    let warnings = ranges::mend(&mut document);
    let buffers = Buffers::read(&document, chunks.bin, parts)?;
    let mut builder = Builder {
        document: &document,
        buffers: &buffers,
        parts,
        choice,
        variant: None,
        model: Model { has_parts: buffers.has_parts, warnings, ..Model::default() },
        faults: Faults::default(),
        geometries: HashMap::new(),
        primitives: HashMap::new(),
        placements: HashMap::new(),
        materials: HashMap::new(),
    };
    if let Err(fault) = builder.build() {
        builder.faults.push(fault);
    }
    let Builder { mut model, mut faults, .. } = builder;
    extensions::note_unknown(&mut model.warnings, &document);
    if faults.0.is_empty() && model.triangles() == 0 {
        // The file is refused: its author learns of all that is wrong with it.
        check::check_unseen(&document, &buffers, &mut faults);
        images::check_all(&document, &buffers, parts, &mut faults);
    }
    faults.none_or_err()?;
    Ok(model)
}

/// What triangles are made of: accessors, and weights of morph targets.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Ingredients {
    attributes: Vec<(String, usize)>,
    indices: Option<usize>,
    mode: u32,
    morphs: Vec<(Vec<(String, usize)>, u64)>,
}

impl Ingredients {
    fn of(primitive: &Primitive, weights: &[f64]) -> Self {
        let list = |attributes: &std::collections::BTreeMap<String, usize>| {
            attributes.iter().map(|(name, index)| (name.clone(), *index)).collect::<Vec<_>>()
        };
        let morphs = primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        Self {
            attributes: list(&primitive.attributes),
            indices: primitive.indices,
            mode: primitive.mode,
            morphs: morphs.map(|(target, weight)| (list(target), weight.to_bits())).collect(),
        }
    }
}

/// What a primitive is at each node that says nothing else.
#[derive(Debug, Clone, Copy)]
struct Shown {
    /// The geometry with the weights of its mesh, once asked for: none if it has no triangles.
    at_rest: Option<Option<usize>>,
    material: Option<usize>,
}

/// Largest number in the matrix of a node: squares of what it moves are finite.
const FARTHEST: f64 = 1e100;

/// A name that each node which has a camera or a mesh repeats.
fn kept(name: &str) -> String {
    shortened(name, NAME_BYTES)
}

/// The model as it is built.
struct Builder<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    parts: &'a Parts<'a>,
    choice: Choice,
    /// Index of the variant of the materials.
    variant: Option<usize>,
    model: Model,
    faults: Faults,
    geometries: HashMap<Ingredients, Option<usize>>,
    /// What primitives of meshes are, whose nodes are many, and each of them has targets and variants.
    primitives: HashMap<(usize, usize), Shown>,
    /// Index of the placement of a geometry with a material.
    placements: HashMap<(usize, Option<usize>), usize>,
    /// Index of a material in the model, by that in the file.
    materials: HashMap<usize, Option<usize>>,
}

impl Builder<'_> {
    fn build(&mut self) -> Result<(), Fault> {
        let document = self.document;
        let scene = self.scene()?;
        self.model.name = scene.and_then(|scene| document.scenes[scene].name.clone());
        if let Some(variant) = self.choice.variant {
            let names = document.variants.iter().map(|variant| variant.name.as_deref());
            self.variant = Some(variant.find("variant", "/extensions/KHR_materials_variants", names)?);
        }
        let mut locals: Vec<Local> = document.nodes.iter().map(Local::of).collect();
        if let Some(animation) = self.choice.animation {
            let names = document.animations.iter().map(|animation| animation.name.as_deref());
            let index = animation.find("animation", "/animations", names)?;
            let warnings = &mut self.model.warnings;
            animation::pose(document, self.buffers, index, self.choice.seconds, &mut locals, warnings)?;
        }
        let parents = nodes::parents(document);
        let worlds = nodes::worlds(document, &locals, &parents);
        for node in nodes::visible(document, scene, &parents) {
            if let Err(fault) = self.node(node, &locals[node], &worlds)
                && !self.faults.push(fault)
            {
                break;
            }
        }
        Ok(())
    }

    fn scene(&self) -> Result<Option<usize>, Fault> {
        let count = self.document.scenes.len();
        match self.choice.scene.map(|scene| scene as usize) {
            Some(scene) if scene >= count => {
                let detail = format!("there is no scene {scene}: the file has {}", counted(count));
                Err(Fault::new("/scenes", Kind::UnknownReference, detail))
            }
            Some(scene) => Ok(Some(scene)),
            None => Ok(self.document.scene.or((count > 0).then_some(0))),
        }
    }

    fn node(&mut self, index: usize, local: &Local, worlds: &[DMat4]) -> Result<(), Fault> {
        let node = &self.document.nodes[index];
        if !worlds[index].to_cols_array().iter().all(|number| number.abs() <= FARTHEST) {
            let detail = format!("with the nodes above, the node is moved or scaled by more than {FARTHEST:e}");
            return Err(Fault::new(format!("/nodes/{index}"), Kind::OutOfRange, detail));
        }
        if let Some(camera) = node.camera {
            self.camera(camera, worlds[index]);
        }
        if let Some(light) = &node.extensions.light {
            self.lamp(light.light, worlds[index]);
        }
        let Some(mesh) = node.mesh else { return Ok(()) };
        let joints = match node.skin {
            Some(skin) => Some(skins::matrices(self.document, self.buffers, skin, worlds)?),
            None => None,
        };
        let transforms = match &node.extensions.instancing {
            // Skinned vertices are where their joints are, whatever their node says.
            instancing if joints.is_some() => {
                if instancing.is_some() {
                    let pointer = format!("/nodes/{index}/extensions/EXT_mesh_gpu_instancing");
                    let detail = "instances of what follows joints are left out, but for one";
                    warn(&mut self.model.warnings, Subject::Skipped, "instances", pointer, detail);
                }
                vec![DMat4::IDENTITY]
            }
            Some(_) => self.instances(index, worlds[index])?,
            None => vec![worlds[index]],
        };
        for k in 0..self.document.meshes[mesh].primitives.len() {
            let placed = self.primitive((mesh, k), local.weights.as_deref(), joints.as_deref(), index, &transforms);
            if let Err(fault) = placed
                && !self.faults.push(fault)
            {
                break;
            }
        }
        Ok(())
    }

    /// Where the instances of a node are.
    fn instances(&self, index: usize, world: DMat4) -> Result<Vec<DMat4>, Fault> {
        let Some(instancing) = &self.document.nodes[index].extensions.instancing else { return Ok(vec![world]) };
        let of = |name: &str| instancing.attributes.get(name).copied();
        let moved = of("TRANSLATION").map(|it| self.buffers.elements::<3>(self.document, it, &["VEC3"])).transpose()?;
        let turned = of("ROTATION").map(|it| self.buffers.elements::<4>(self.document, it, &["VEC4"])).transpose()?;
        let scaled = of("SCALE").map(|it| self.buffers.elements::<3>(self.document, it, &["VEC3"])).transpose()?;
        let counts = [moved.as_ref().map(Vec::len), turned.as_ref().map(Vec::len), scaled.as_ref().map(Vec::len)];
        let Some(count) = counts.into_iter().flatten().next() else { return Ok(vec![world]) };
        if counts.into_iter().flatten().any(|other| other != count) {
            let pointer = format!("/nodes/{index}/extensions/EXT_mesh_gpu_instancing/attributes");
            return Err(Fault::new(pointer, Kind::OutOfRange, "the lists of instances are not equally long"));
        }
        self.buffers.budget.take(count as u64, INSTANCE_BYTES)?;
        let one = |i: usize| {
            let translation = moved.as_ref().map_or(DVec3::ZERO, |list| DVec3::from_array(list[i]));
            let rotation = turned.as_ref().map_or(DQuat::IDENTITY, |list| nodes::unit(list[i]));
            let scale = scaled.as_ref().map_or(DVec3::ONE, |list| DVec3::from_array(list[i]));
            world * DMat4::from_scale_rotation_translation(scale, rotation, translation)
        };
        Ok((0..count).map(one).collect())
    }

    /// Places a primitive of a mesh. `weights` are those of its node, in place of its mesh's.
    fn primitive(
        &mut self,
        (mesh, k): (usize, usize),
        weights: Option<&[f64]>,
        joints: Option<&[DMat4]>,
        node: usize,
        transforms: &[DMat4],
    ) -> Result<(), Fault> {
        // A few nodes and a few primitives may be very many pairs of them, also of such as show nothing.
        self.buffers.budget.take(transforms.len() as u64, size_of::<DMat4>())?;
        let document = self.document;
        let primitive = &document.meshes[mesh].primitives[k];
        let pointer = format!("/meshes/{mesh}/primitives/{k}");
        if primitive.mode < 4 {
            let what = if primitive.mode == 0 { "points" } else { "lines" };
            let pointer = format!("{pointer}/mode");
            warn(&mut self.model.warnings, Subject::Skipped, what, pointer, "they have no surface and are left out");
            return Ok(());
        }
        let shown = match self.primitives.get(&(mesh, k)) {
            Some(known) => *known,
            None => Shown { at_rest: None, material: self.material_of(primitive) },
        };
        let of_mesh = || document.meshes[mesh].weights.as_deref().unwrap_or_default();
        let (geometry, at_rest) = match (joints, weights, shown.at_rest) {
            (Some(joints), ..) => {
                let still = self.geometry(primitive, &pointer, weights.unwrap_or_else(of_mesh))?;
                let warnings = &mut self.model.warnings;
                let moved = skins::skinned(document, self.buffers, primitive, &pointer, still, joints, warnings)?;
                (self.add(moved, &pointer), shown.at_rest)
            }
            (None, None, Some(known)) => (known, shown.at_rest),
            (None, None, None) => {
                let geometry = self.morphed(primitive, &pointer, of_mesh())?;
                (geometry, Some(geometry))
            }
            (None, Some(weights), _) => (self.morphed(primitive, &pointer, weights)?, shown.at_rest),
        };
        self.primitives.insert((mesh, k), Shown { at_rest, ..shown });
        let Some(geometry) = geometry else { return Ok(()) };
        let material = match shown.material {
            Some(material) => self.material(material)?,
            None => None,
        };
        let name = || document.nodes[node].name.as_deref().or(document.meshes[mesh].name.as_deref()).map(kept);
        let placements = &mut self.model.placements;
        let index = *self.placements.entry((geometry, material)).or_insert_with(|| {
            placements.push(Placement { geometry, material, name: name(), transforms: Vec::new() });
            placements.len() - 1
        });
        placements[index].transforms.extend_from_slice(transforms);
        Ok(())
    }

    /// The index of a geometry with weights of morph targets; none if it has no triangles.
    fn morphed(&mut self, primitive: &Primitive, pointer: &str, weights: &[f64]) -> Result<Option<usize>, Fault> {
        self.buffers.budget.take(primitive.targets.len().min(weights.len()) as u64, MORPH_BYTES)?;
        let ingredients = Ingredients::of(primitive, weights);
        if let Some(known) = self.geometries.get(&ingredients) {
            return Ok(*known);
        }
        let geometry = self.geometry(primitive, pointer, weights)?;
        let index = self.add(geometry, pointer);
        self.geometries.insert(ingredients, index);
        Ok(index)
    }

    fn geometry(&mut self, primitive: &Primitive, pointer: &str, weights: &[f64]) -> Result<Geometry, Fault> {
        let moves = |name: &String| name.starts_with("COLOR_") || name.starts_with("TEXCOORD_");
        if primitive.targets.iter().zip(weights).any(|(target, weight)| *weight != 0.0 && target.keys().any(moves)) {
            let (pointer, detail) =
                (format!("{pointer}/targets"), "morph targets of colors and texture coordinates are left out");
            warn(&mut self.model.warnings, Subject::Skipped, "morph-targets", pointer, detail);
        }
        let mut geometry = meshes::points(self.document, self.buffers, primitive, pointer, weights)?;
        let points = geometry.positions.len();
        let triangles = meshes::triangles(self.document, self.buffers, primitive, pointer, points)?;
        geometry.triangles = triangles.unwrap_or_default();
        Ok(geometry)
    }

    /// Adds a geometry, unless it has no triangles.
    fn add(&mut self, mut geometry: Geometry, pointer: &str) -> Option<usize> {
        if geometry.triangles.is_empty() {
            return None;
        }
        geometry.drop_unused();
        if geometry.mend_normals() > 0 {
            let pointer = format!("{pointer}/attributes/NORMAL");
            let detail = "normals of length 0 are replaced by those of the faces";
            warn(&mut self.model.warnings, Subject::Assumed, "normals", pointer, detail);
        }
        self.model.geometries.push(geometry);
        Some(self.model.geometries.len() - 1)
    }

    /// The material of a primitive in the chosen variant.
    fn material_of(&self, primitive: &Primitive) -> Option<usize> {
        let variant = self.variant;
        let mappings = primitive.extensions.variants.iter().flat_map(|variants| &variants.mappings);
        let mapped =
            variant.and_then(|variant| mappings.into_iter().find(|mapping| mapping.variants.contains(&variant)));
        mapped.map(|mapping| mapping.material).or(primitive.material)
    }

    fn material(&mut self, index: usize) -> Result<Option<usize>, Fault> {
        if let Some(known) = self.materials.get(&index) {
            return Ok(*known);
        }
        // Its mistakes are reported once.
        self.materials.insert(index, None);
        let read = Materials { document: self.document, warnings: &mut self.model.warnings }.read(index)?;
        for texture in read.textures() {
            let picture = texture.picture;
            if self.model.pictures.len() < self.document.images.len() {
                self.model.pictures.resize_with(self.document.images.len(), Default::default);
            }
            if self.model.pictures[picture].bytes.is_empty() {
                match images::read(self.document, self.buffers, self.parts, picture) {
                    Ok((read, is_part)) => {
                        self.model.has_parts |= is_part;
                        self.model.pictures[picture] = read;
                    }
                    Err(fault) => drop(self.faults.push(fault)),
                }
            }
        }
        self.model.materials.push(read);
        let place = Some(self.model.materials.len() - 1);
        self.materials.insert(index, place);
        Ok(place)
    }

    fn camera(&mut self, index: usize, placed: DMat4) {
        let camera = &self.document.cameras[index];
        let (projection, aspect) = match (&camera.perspective, &camera.orthographic) {
            (Some(camera), _) => (Projection::Perspective { vertical: camera.yfov }, camera.aspect_ratio),
            (None, Some(camera)) => {
                let aspect = camera.xmag.map(|wide| (wide / camera.ymag).abs());
                (Projection::Orthographic { height: 2.0 * camera.ymag.abs() }, aspect)
            }
            (None, None) => {
                let detail = "a camera that is neither perspective nor orthographic is left out";
                warn(&mut self.model.warnings, Subject::Skipped, "cameras", format!("/cameras/{index}"), detail);
                return;
            }
        };
        let aspect = aspect.filter(|aspect| *aspect > 0.0 && aspect.is_finite());
        let name = camera.name.as_deref().map(kept);
        self.model.cameras.push(ModelCamera { number: index, name, placed, projection, aspect });
    }

    fn lamp(&mut self, index: usize, placed: DMat4) {
        let light = &self.document.lights[index];
        let kind = match light.kind.as_str() {
            "directional" => LampKind::Directional,
            "point" => LampKind::Point,
            "spot" => LampKind::Spot { inner: light.spot.inner_cone_angle, outer: light.spot.outer_cone_angle },
            _ => {
                let pointer = format!("/extensions/KHR_lights_punctual/lights/{index}/type");
                let detail = "a light of an unknown kind is left out";
                warn(&mut self.model.warnings, Subject::Skipped, "lights", pointer, detail);
                return;
            }
        };
        let Light { color, intensity, range, .. } = *light;
        self.model.lamps.push(Lamp { placed, color, intensity, range, kind });
    }
}
