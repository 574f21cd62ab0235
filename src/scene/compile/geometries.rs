//! The geometries of a checked description: its objects, placed and grouped, with what is found out about them on the way.

use super::bodies::{Kept, shape, volume};
use super::equal_meshes::EqualMeshes;
use super::known::Known;
use super::materials::{has_colors, material};
use super::occluded::{Occluded, occluded};
use super::shared_eye::is_shared;
use super::{CompileOptions, Source, Sources, contact, extent};
use crate::accel::{Ball, BvhKind, Extent, Geometry, Instance, Item, Motion, Obstacle, Shape};
use crate::camera::Camera;
use crate::control;
use crate::lanes::Real;
use crate::scene::description::{self as d, Appearance, Description, Object, Vec3};
use crate::scene::light_cells::MOST_OBSTACLES;
use crate::scene::pictures::Pictures;
use crate::scene::problem::push_token;
use crate::scene::transform::{affine, is_identity};
use crate::scene::usage::{Pointers, Usage, Used, note};
use crate::shading::material::Material;
use crate::shape::Sides;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// Builds geometries one by one; the last is the scene itself.
pub(super) struct Builder<'a, R> {
    description: &'a Description,
    options: CompileOptions,
    pub(super) known: Option<Known<'a, R>>,
    pub(super) geometries: Vec<Geometry<R>>,
    /// Primitives of each geometry when expanded; may be beyond what 64 bits hold until that is checked.
    pub(super) expanded: Vec<u128>,
    /// The geometry of each definition built so far.
    definitions: Vec<Option<usize>>,
    equal_meshes: EqualMeshes<'a>,
    /// One for each of the description's, and the default material last.
    pub(super) materials: Vec<Material<R>>,
    one_sided: Vec<bool>,
    /// Which materials make sheets of all bodies.
    thin: Vec<bool>,
    pub(super) usage: Usage,
    pub(super) pointers: Pointers,
    camera: Camera<R>,
    /// Whether all camera rays start in the same media.
    pub(super) shared_eye: bool,
    pub(super) occluded: Occluded,
    /// What may be between surfaces and lights, if there are lights with an area.
    pub(super) obstacles: Option<Vec<Obstacle>>,
    pub(super) sources: Sources,
}

impl<'a, R: Real> Builder<'a, R> {
    pub(super) fn new(
        description: &'a Description,
        options: CompileOptions,
        pictures: &Pictures,
        camera: Camera<R>,
        known: Option<Known<'a, R>>,
    ) -> Self {
        let fallback = d::Material::default();
        let all = || description.materials.iter().map(|(_, m)| m).chain([&fallback]);
        let colored = has_colors(description);
        Self {
            description,
            options,
            known,
            geometries: Vec::new(),
            expanded: Vec::new(),
            definitions: vec![None; description.definitions.len()],
            equal_meshes: EqualMeshes::default(),
            materials: all().map(|m| material(m, pictures, description, colored)).collect(),
            one_sided: all().map(|m| m.one_sided).collect(),
            thin: all().map(|m| m.pbr.as_ref().is_some_and(|pbr| pbr.thin)).collect(),
            usage: Usage { materials: vec![Used::default(); all().count()], ..Usage::default() },
            pointers: Pointers::default(),
            camera,
            shared_eye: true,
            occluded: Occluded::default(),
            obstacles: None,
            sources: Sources {
                materials: description.materials.keys().map(|name| push_token("/materials", name)).collect(),
                ..Sources::default()
            },
        }
    }

    pub(super) fn list(&mut self, pointer: String) -> u32 {
        self.sources.lists.push(pointer);
        (self.sources.lists.len() - 1) as u32
    }

    /// Builds the geometry of a list of objects and returns its index.
    pub(super) fn geometry(&mut self, objects: &'a [Object], list: u32) -> usize {
        let mut collected = Collected { items: Vec::new(), extents: Vec::new(), expanded: 0 };
        self.collect(objects, list, &mut collected);
        let Collected { mut items, mut extents, expanded } = collected;
        for (item, extent) in items.iter_mut().zip(&mut extents) {
            if let Shape::Instance(instance) = &mut item.shape {
                *extent = extent::of_instance(instance, &self.geometries[instance.geometry as usize]);
                if let (Some(motion), Some(extent)) = (&instance.motion, extent.as_mut()) {
                    *extent = motion.swept(extent);
                }
                instance.ball = extent.as_ref().map(Ball::new);
            }
        }
        match &self.known {
            Some(known) => known.mark(&mut items),
            None => contact::mark_siblings(&mut items, &extents),
        }
        // The last geometry that is built is the scene itself.
        self.shared_eye = is_shared(self.description, &self.camera, self.usage.moves, &items, &extents);
        if !self.options.spd_counts {
            self.occluded = occluded(self.description, &self.materials, &self.geometries, &items, &extents);
        }
        // The slow twin has no cells either.
        let has_areas = self.options.bvh != BvhKind::Flat && self.description.lights.iter().any(d::Light::has_area);
        if has_areas && items.len() <= MOST_OBSTACLES {
            let opaque = |item: &Item<R>| !item.has_holes && !self.materials[item.material as usize].transmits();
            let obstacle = |(item, extent)| Obstacle::new(item, extent, opaque(item));
            self.obstacles = items.iter().zip(&extents).map(obstacle).collect();
        }
        let alike = match objects {
            [Object::Mesh(mesh)] => self.alike(mesh),
            _ => None,
        };
        let built = match (&self.known, alike) {
            (Some(known), _) => known.geometry(self.geometries.len(), items),
            (None, Some(alike)) => self.geometries[alike].with_items(items),
            (None, None) => Err(items),
        };
        let geometry = built.unwrap_or_else(|items| Geometry::new(items, &extents, self.options.bvh));
        self.geometries.push(geometry);
        self.expanded.push(expanded);
        let index = self.geometries.len() - 1;
        if let [Object::Mesh(mesh)] = objects {
            self.equal_meshes.note(mesh, self.is_one_sided(mesh), index);
        }
        index
    }

    /// The geometry of an equal mesh in another material.
    fn alike(&self, mesh: &d::Mesh) -> Option<usize> {
        self.equal_meshes.find(mesh, self.is_one_sided(mesh))
    }

    fn is_one_sided(&self, mesh: &d::Mesh) -> bool {
        self.one_sided[self.material_of(mesh.material.as_deref())]
    }

    /// The index of a material, of the default one if none is named.
    fn material_of(&self, name: Option<&str>) -> usize {
        let default = self.materials.len() - 1;
        name.and_then(|name| self.description.materials.get_index_of(name)).unwrap_or(default)
    }

    fn collect(&mut self, objects: &'a [Object], list: u32, into: &mut Collected<R>) {
        into.items.reserve_exact(objects.len());
        into.extents.reserve(objects.len());
        self.sources.entries.reserve(objects.len());
        for (index, object) in objects.iter().enumerate() {
            if control::step(1) {
                return;
            }
            let source = self.sources.entries.len() as u32;
            let entry = |name: Option<&str>| Source { list, index: index as u32, name: name.map(Into::into) };
            self.note_use(object, list, index);
            match object {
                Object::Group(group) => {
                    self.sources.entries.push(entry(group.name.as_deref()));
                    let inner = self.list(format!("{}/{index}/group/objects", self.sources.lists[list as usize]));
                    if is_identity(&group.transform) && !group.motion.is_some_and(|m| m.moves()) {
                        self.collect(&group.objects, inner, into);
                    } else {
                        let geometry = self.geometry(&group.objects, inner);
                        into.push(
                            self.instance(geometry, &group.transform, group.motion, source),
                            None,
                            self.expanded[geometry],
                        );
                    }
                }
                Object::Instance(instance) => {
                    self.sources.entries.push(entry(instance.name.as_deref()));
                    let geometry = self.definition(&instance.of);
                    into.push(
                        self.instance(geometry, &instance.transform, instance.motion, source),
                        None,
                        self.expanded[geometry],
                    );
                }
                _ => {
                    let known = self.known.as_ref().and_then(|known| known.item(source));
                    let (shape, appearance) = self.shape(object, known);
                    self.sources.entries.push(entry(appearance.name));
                    let count = if let Shape::Mesh(mesh) = &shape { mesh.faces.len() as u128 } else { 1 };
                    // A sheet has none, and may be a body now.
                    let volume = known.filter(|item| item.closed).map(|item| item.volume);
                    let item = self.item(object, shape, appearance, volume, source);
                    into.push(item, extent::of_object::<R>(object), count);
                }
            }
        }
    }

    /// Notes what an object has beside its material.
    fn note_use(&mut self, object: &Object, list: u32, index: usize) {
        let pointer = || format!("{}/{index}/{}", self.sources.lists[list as usize], object.kind());
        let (usage, pointers) = (&mut self.usage, &mut self.pointers);
        let (placed, motion) = match object {
            Object::Instance(instance) => (true, instance.motion),
            Object::Group(group) => (!is_identity(&group.transform), group.motion),
            _ => (false, None),
        };
        let moves = motion.is_some_and(|motion| motion.moves());
        let hollow = object.appearance().is_some_and(|appearance| appearance.hollow);
        let smooth = matches!(object, Object::Mesh(mesh) if mesh.normals.is_some());
        let notes = [
            (placed || moves, &mut usage.placed, &mut pointers.placed),
            (moves, &mut usage.moves, &mut pointers.moving),
            (hollow, &mut usage.hollow, &mut pointers.hollow),
            (smooth, &mut usage.smooth, &mut pointers.smooth),
        ];
        for (has, any, list) in notes {
            if has {
                *any = true;
                note(list, pointer);
            }
        }
    }

    /// The shape of a body, the known one if that will do.
    fn shape(&self, object: &'a Object, known: Option<&Item<R>>) -> (Shape<R>, Appearance<'a>) {
        let appearance = object.appearance();
        let material = appearance.and_then(|appearance| self.description.materials.get(appearance.material?));
        let kept = Kept::of(object, material);
        let alike = match object {
            Object::Mesh(mesh) if known.is_none() => {
                self.alike(mesh).and_then(|index| self.geometries[index].items.first())
            }
            _ => None,
        };
        match (known.or(alike).map(|item| &item.shape), appearance) {
            (Some(Shape::Mesh(mesh)), Some(appearance)) if Kept::by(mesh) == kept => {
                (Shape::Mesh(Arc::clone(mesh)), appearance)
            }
            _ => shape(object, kept),
        }
    }

    fn definition(&mut self, name: &str) -> usize {
        let description = self.description;
        let (position, name, objects) = description.definitions.get_full(name).expect("checked reference");
        if let Some(geometry) = self.definitions[position] {
            return geometry;
        }
        let list = self.list(push_token("/definitions", name));
        let geometry = self.geometry(objects, list);
        self.definitions[position] = Some(geometry);
        geometry
    }

    fn instance(
        &mut self,
        geometry: usize,
        transform: &d::Transform,
        motion: Option<d::Motion>,
        source: u32,
    ) -> Item<R> {
        let map = affine(transform).unwrap_or(DAffine3::IDENTITY);
        let mut instance = Instance::new(geometry as u32, map);
        if let Some(motion) = motion.filter(d::Motion::moves) {
            instance.motion = Some(Box::new(self::motion(&motion)));
        }
        Item {
            shape: Shape::Instance(Box::new(instance)),
            material: 0,
            sides: Sides::Both,
            hollow: false,
            closed: false,
            may_touch: false,
            has_holes: false,
            volume: 0.0,
            transmission: [R::from_f64(0.0); 3],
            source,
            offset: 0,
            expanded: 0,
        }
    }

    fn item(
        &mut self,
        object: &Object,
        shape: Shape<R>,
        appearance: Appearance<'_>,
        known_volume: Option<f64>,
        source: u32,
    ) -> Item<R> {
        let material = self.material_of(appearance.material);
        let sides = match (self.one_sided[material], appearance.hollow) {
            (false, _) => Sides::Both,
            (true, false) => Sides::Outside,
            (true, true) => Sides::Inside,
        };
        let closed = match object {
            Object::Sphere(_) | Object::Plane(_) | Object::Torus(_) | Object::Mesh(_) => true,
            Object::Cylinder(o) => o.capped,
            Object::Cone(o) => o.capped,
            Object::Box(o) => (0..3).all(|i| R::from_f64(o.min[i]) < R::from_f64(o.max[i])),
            _ => false,
        } && !self.thin[material];
        self.usage.rounded |= matches!(shape, Shape::Mesh(_) | Shape::Frustum(_));
        let used = &mut self.usage.materials[material];
        (used.anywhere, used.filled) = (true, used.filled || (closed && !appearance.hollow));
        Item {
            shape,
            material: material as u32,
            sides,
            hollow: appearance.hollow,
            closed,
            may_touch: false,
            has_holes: self.materials[material].has_holes(),
            volume: if closed { known_volume.unwrap_or_else(|| volume(object)) } else { 0.0 },
            transmission: self.materials[material].transmission,
            source,
            offset: 0,
            expanded: 0,
        }
    }
}

/// Items of one geometry so far, with the extents of those that are neither meshes nor instances.
struct Collected<R> {
    items: Vec<Item<R>>,
    extents: Vec<Option<Extent>>,
    expanded: u128,
}

impl<R> Collected<R> {
    fn push(&mut self, mut item: Item<R>, extent: Option<Extent>, expanded: u128) {
        // Beyond 64 bits the offsets are wrong, and `compile` refuses the scene.
        item.offset = self.expanded as u64;
        item.expanded = expanded as u64;
        self.expanded = self.expanded.saturating_add(expanded);
        self.items.push(item);
        self.extents.push(extent);
    }
}

fn motion<R: Real>(motion: &d::Motion) -> Motion<R> {
    let vector = |v: Option<Vec3>| DVec3::from_array(v.unwrap_or_default());
    let (axis, degrees) = motion
        .rotate_deg
        .map_or((DVec3::Y, 0.0), |rotation| (DVec3::from_array(rotation.axis).normalize(), rotation.angle));
    Motion::new(vector(motion.translate), axis, degrees, vector(motion.center))
}
