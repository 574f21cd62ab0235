//! A checked description in the kernel's format.

use super::bodies::{Kept, shape, volume};
use super::camera::camera_of;
use super::ceiling::ceiling;
use super::effects::{disperses, hides_nothing, settle};
use super::emitters::emitters;
use super::hidden::{Hidden, hidden};
use super::known::Known;
use super::lights::light;
use super::pbr;
use super::shared_eye::is_shared;
use super::textures::textures;
use super::{CompileOptions, Source, Sources, contact, extent, unseen};
use crate::accel::{Ball, Blockers, Bounds, BvhKind, Extent, Geometry, Instance, Item, Motion, Obstacle, Shape};
use crate::bound::ceiling::Ceiling;
use crate::camera::{Basis, Camera};
use crate::control;
use crate::film::Display;
use crate::lanes::Real;
use crate::math::{self, Rgb};
use crate::scene::description::{self as d, Description, Look, Object, Shadows, Vec3};
use crate::scene::effects::{Effect, SceneEffects};
use crate::scene::light_cells::{LightCells, MOST_OBSTACLES};
use crate::scene::pictures::{Meaning, Pictures};
use crate::scene::problem::push_token;
use crate::scene::transform::affine;
use crate::scene::usage::{Pointers, Usage, Used, note};
use crate::scene::world::{Pruning, Rules, World, shows};
use crate::shading::bright_directions::BrightDirections;
use crate::shading::fog::{Fog, Height};
use crate::shading::light::Light;
use crate::shading::material::{Fresnel, Material};
use crate::shading::spectrum::Spectrum;
use crate::shading::surroundings::Surroundings;
use crate::shading::texture::environment::{Environment, clear_sky};
use crate::shading::texture::studio::studio;
use crate::shape::Sides;
use glam::{DAffine3, DVec3};
use parking_lot::Mutex;
use std::sync::Arc;

/// What building finds out besides the world.
pub(super) struct Built {
    pub(super) sources: Sources,
    pub(super) pointers: Pointers,
    pub(super) expanded: u128,
}

/// Builds the world of a checked description. `known` is a world of the same objects.
pub(super) fn build<R: Real>(
    description: &Description,
    options: CompileOptions,
    pictures: &Pictures,
    known: Option<&World<R>>,
) -> (World<R>, Built) {
    let basis = Basis::new(&description.camera.view()).unwrap_or_else(|| unreachable!("the camera has been checked"));
    let camera = camera_of(&description.camera, &basis, description.image.width, description.image.height);
    let lit_before = known.and_then(|world| Some((world.environment.as_ref()?, world.surroundings.as_ref()?)));
    let known = known.map(Known::new);
    let mut builder = Builder::<R>::new(description, options, pictures, camera, known);
    let list = builder.list("/objects".to_owned());
    let root = builder.geometry(&description.objects, list);
    contact::mark_placed(&mut builder.geometries);
    let expanded = builder.expanded[root];
    let bounds = builder.geometries[root].extent.bounds;
    let size = if bounds == Bounds::EMPTY { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
    let render = &description.render;
    let fog = description.fog.as_ref().map(fog).filter(|fog| fog.density > R::from_f64(0.0));
    let (background, mut environment) = seen_around(description, pictures);
    let is_uniform = environment.is_none();
    builder.usage.enclosed = builder.hidden.surroundings;
    if builder.usage.enclosed {
        environment = None;
    }
    // Inside of bodies is no fog.
    let in_the_open = builder.materials.iter().all(|m| !m.transmits() && !shows(m.absorption));
    if in_the_open && fog.as_ref().is_some_and(|fog| fog.height.is_none()) {
        environment = None;
    }
    let lights_surfaces = description.environment.as_ref().is_some_and(|e| e.light == d::EnvironmentLight::Fast);
    let faithful = pbr::traces_light(render);
    let catches = builder.materials.iter().any(Material::catches_shadows);
    let without_rays = lights_surfaces && (!faithful || catches);
    let surroundings = environment.as_ref().filter(|_| without_rays).map(|map| surroundings(map, lit_before));
    // Fog would fade the light on its way.
    let looked_for = faithful && fog.is_none();
    let bright = environment.as_ref().filter(|_| looked_for).map(|map| Arc::new(BrightDirections::new(map)));
    let emitters = looked_for.then(|| emitters(description, &builder.materials)).flatten().map(Arc::new);
    // One of one colour is ambient light, which rays bring if light is traced.
    let around = if lights_surfaces && is_uniform && !builder.usage.enclosed { background } else { Rgb::ZERO };
    let ambient = if faithful { Rgb::ZERO } else { description.ambient.0 + around };
    if let Some((materials, moves)) = builder.hidden.usage(&builder.geometries, builder.materials.len()) {
        (builder.usage.materials, builder.usage.moves) = (materials, moves);
    }
    let lights: Vec<Light<R>> = description.lights.iter().map(light).collect();
    let mut world = World {
        geometries: match &builder.known {
            Some(known) => known.share(builder.geometries),
            None => builder.geometries.into(),
        },
        root,
        size: R::from_f64(size),
        usage: builder.usage,
        shared_eye: builder.shared_eye,
        spectrum: None,
        materials: builder.materials,
        lights,
        ambient: narrow_rgb(ambient),
        background: narrow_rgb(background),
        behind: (description.film.background != d::FilmBackground::Scene).then(|| narrow_rgb(Rgb::ZERO)),
        display: display(&description.film),
        environment,
        surroundings,
        bright_directions: bright,
        emitters,
        fog,
        camera,
        rules: Rules {
            max_depth: render.fixed_depth(),
            pruning: Pruning::of(render.accuracy(), render.fixed_weight()),
            shadows: match render.shadows {
                Shadows::Transmissive => Some(Blockers::Transmissive),
                Shadows::Opaque => Some(Blockers::Opaque),
                Shadows::None => None,
            },
            colors_shadows: render.shadows == Shadows::Transmissive,
            color_bleeding: render.color_bleeding && !faithful,
            faithful,
            filter_checkers: render.filter_checkers,
            straight: false,
            spd_counts: options.spd_counts,
        },
        ceiling: Ceiling::unbounded(0, String::new(), Vec::new()),
        transmits: false,
        reflects: false,
        angular: false,
        effects: SceneEffects::default(),
        light_cells: None,
    };
    if render.max_depth != Some(1) && world.has_material(disperses) {
        world.spectrum = Some(Box::new(Spectrum::visible()));
    }
    unseen::remove_ambient_light(&mut world);
    world.ceiling = ceiling(description, &world);
    world.rules.finish(render, &world.ceiling.reach);
    unseen::remove_unlit(&mut world);
    // By the counting rules of the SPD shadow rays are traced, needed or not.
    if !options.spd_counts && (!world.is_lit() || hides_nothing(description, &world).is_some()) {
        world.rules.shadows = None;
    }
    settle(&mut world);
    if world.rules.shadows.is_some() && !options.spd_counts && !world.effects.has(Effect::ColoredShadows) {
        let cells = builder.obstacles.and_then(|obstacles| LightCells::new(obstacles, &world.lights));
        world.light_cells = cells.map(Arc::new);
    }
    (world, Built { sources: builder.sources, pointers: builder.pointers, expanded })
}

/// The light of surroundings: that of the scene that this one is a variation of, or of a studio that stood like this before, if it is
/// the same.
fn surroundings(map: &Environment, before: Option<(&Environment, &Arc<Surroundings>)>) -> Arc<Surroundings> {
    /// Studios that are kept, at 0.4 MB each: views of models have names, so they stand in few ways.
    const STUDIOS: usize = 16;
    static KEPT: Mutex<Vec<(Environment, Arc<Surroundings>)>> = Mutex::new(Vec::new());
    let same = |other: &Environment| {
        Arc::ptr_eq(&other.mipmap, &map.mipmap) && other.turn == map.turn && other.intensity == map.intensity
    };
    if let Some((_, known)) = before.filter(|(other, _)| same(other)) {
        return Arc::clone(known);
    }
    if !Arc::ptr_eq(&map.mipmap, &studio()) {
        return Arc::new(Surroundings::new(map));
    }
    let known = KEPT.lock().iter().find(|(other, _)| same(other)).map(|(_, known)| Arc::clone(known));
    known.unwrap_or_else(|| {
        let made = Arc::new(Surroundings::new(map));
        let mut kept = KEPT.lock();
        if kept.len() == STUDIOS {
            kept.remove(0);
        }
        kept.push((map.clone(), Arc::clone(&made)));
        made
    })
}

/// How light becomes colours.
fn display(film: &d::Film) -> Display {
    let display = Display::new(film.exposure, film.tone);
    match film.background {
        d::FilmBackground::Color(color) => display.over(color.0.to_array()),
        d::FilmBackground::Scene | d::FilmBackground::Transparent => display,
    }
}

/// What rays see that hit nothing: a colour, or a picture if it has more than one.
fn seen_around(description: &Description, pictures: &Pictures) -> (Rgb, Option<Environment>) {
    let Some(d::Environment { image, sky, studio: _, rotate_deg, intensity, light: _ }) = &description.environment
    else {
        return (description.background.0, None);
    };
    let mipmap = match (image, sky) {
        (Some(image), _) => pictures.get(image, Meaning::Radiance),
        (None, Some(sky)) => Arc::new(clear_sky(sky.zenith.0, sky.horizon.0, sky.ground.0)),
        (None, None) => studio(),
    };
    let uniform = if *intensity == 0.0 { Some([0.0; 3]) } else { mipmap.uniform() };
    match uniform {
        Some(color) => (Rgb::from_array(color) * *intensity, None),
        None => {
            let environment = Environment { mipmap, turn: rotate_deg / 360.0, intensity: *intensity };
            (description.background.0, Some(environment))
        }
    }
}

struct Builder<'a, R> {
    description: &'a Description,
    options: CompileOptions,
    known: Option<Known<'a, R>>,
    geometries: Vec<Geometry<R>>,
    /// Primitives of each geometry when expanded; may be beyond what 64 bits hold until that is checked.
    expanded: Vec<u128>,
    /// The geometry of each definition built so far.
    definitions: Vec<Option<usize>>,
    /// One for each of the description's, and the default material last.
    materials: Vec<Material<R>>,
    one_sided: Vec<bool>,
    /// Which materials make sheets of all bodies.
    thin: Vec<bool>,
    usage: Usage,
    pointers: Pointers,
    camera: Camera<R>,
    /// Whether all camera rays start in the same media.
    shared_eye: bool,
    hidden: Hidden,
    /// What may be between surfaces and lights, if there are lights with an area.
    obstacles: Option<Vec<Obstacle>>,
    sources: Sources,
}

impl<'a, R: Real> Builder<'a, R> {
    fn new(
        description: &'a Description,
        options: CompileOptions,
        pictures: &Pictures,
        camera: Camera<R>,
        known: Option<Known<'a, R>>,
    ) -> Self {
        let fallback = d::Material::default();
        let all = || description.materials.iter().map(|(_, m)| m).chain([&fallback]);
        Self {
            description,
            options,
            known,
            geometries: Vec::new(),
            expanded: Vec::new(),
            definitions: vec![None; description.definitions.len()],
            materials: all().map(|m| material(m, pictures, description)).collect(),
            one_sided: all().map(|m| m.one_sided).collect(),
            thin: all().map(|m| m.pbr.as_ref().is_some_and(|pbr| pbr.thin)).collect(),
            usage: Usage { materials: vec![Used::default(); all().count()], ..Usage::default() },
            pointers: Pointers::default(),
            camera,
            shared_eye: true,
            hidden: Hidden::default(),
            obstacles: None,
            sources: Sources {
                materials: description.materials.keys().map(|name| push_token("/materials", name)).collect(),
                ..Sources::default()
            },
        }
    }

    fn list(&mut self, pointer: String) -> u32 {
        self.sources.lists.push(pointer);
        (self.sources.lists.len() - 1) as u32
    }

    /// Builds the geometry of a list of objects and returns its index.
    fn geometry(&mut self, objects: &'a [Object], list: u32) -> usize {
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
            self.hidden = hidden(self.description, &self.materials, &items, &extents);
        }
        // The slow twin has no cells either.
        let has_areas = self.options.bvh != BvhKind::Flat && self.description.lights.iter().any(d::Light::has_area);
        if has_areas && items.len() <= MOST_OBSTACLES {
            let opaque = |item: &Item<R>| !item.has_holes && !self.materials[item.material as usize].transmits();
            let obstacle = |(item, extent)| Obstacle::new(item, extent, opaque(item));
            self.obstacles = items.iter().zip(&extents).map(obstacle).collect();
        }
        let built = match &self.known {
            Some(known) => known.geometry(self.geometries.len(), items),
            None => Err(items),
        };
        let geometry = built.unwrap_or_else(|items| Geometry::new(items, &extents, self.options.bvh));
        self.geometries.push(geometry);
        self.expanded.push(expanded);
        self.geometries.len() - 1
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
                    if group.transform == d::Transform::default() && !group.motion.is_some_and(|m| m.moves()) {
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
                    let (shape, look) = self.shape(object, known);
                    self.sources.entries.push(entry(look.name));
                    let count = if let Shape::Mesh(mesh) = &shape { mesh.faces.len() as u128 } else { 1 };
                    let volume = known.map(|item| item.volume);
                    let item = self.item(object, shape, look, volume, source);
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
            Object::Group(group) => (group.transform != d::Transform::default(), group.motion),
            _ => (false, None),
        };
        let moves = motion.is_some_and(|motion| motion.moves());
        let hollow = object.look().is_some_and(|look| look.hollow);
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
    fn shape(&self, object: &'a Object, known: Option<&Item<R>>) -> (Shape<R>, Look<'a>) {
        let look = object.look();
        let material = look.and_then(|look| self.description.materials.get(look.material?));
        let kept = Kept::of(object, material);
        match (known.map(|item| &item.shape), look) {
            (Some(Shape::Mesh(mesh)), Some(look)) if Kept::by(mesh) == kept => (Shape::Mesh(Arc::clone(mesh)), look),
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
        look: Look<'_>,
        known_volume: Option<f64>,
        source: u32,
    ) -> Item<R> {
        let default = self.materials.len() - 1;
        let material = look.material.and_then(|name| self.description.materials.get_index_of(name)).unwrap_or(default);
        let sides = match (self.one_sided[material], look.hollow) {
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
        let used = &mut self.usage.materials[material];
        (used.anywhere, used.filled) = (true, used.filled || (closed && !look.hollow));
        Item {
            shape,
            material: material as u32,
            sides,
            hollow: look.hollow,
            closed,
            may_touch: false,
            has_holes: self.materials[material].has_holes(),
            volume: known_volume.unwrap_or_else(|| if closed { volume(object) } else { 0.0 }),
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

pub(super) fn narrow_rgb<R: Real>(color: Rgb) -> [R; 3] {
    color.to_array().map(R::from_f64)
}

/// 1/x for powers of two, whose reciprocals are exact.
pub(super) fn exact_inverse<R: Real>(x: f64) -> Option<R> {
    (math::scale_by_power(1.0, math::exponent(x)) == x).then(|| R::from_f64(1.0 / x))
}

fn material<R: Real>(material: &d::Material, pictures: &Pictures, scene: &Description) -> Material<R> {
    if let Some(described) = &material.pbr {
        let mut material = pbr::material(described, pictures, pbr::traces_light(&scene.render));
        pbr::show_unlit(&mut material, &scene.film);
        return material;
    }
    let (ambient, diffuse, textures) = textures(material, pictures);
    Material {
        ambient,
        diffuse,
        specular: narrow_rgb(material.specular.0),
        shininess: R::from_f64(material.shininess),
        reflection: narrow_rgb(material.reflection.0),
        transmission: narrow_rgb(material.transmission.0),
        ior: R::from_f64(material.ior),
        absorption: narrow_rgb(material.absorption.0),
        emission: narrow_rgb(material.emission.0),
        fresnel: match material.fresnel {
            d::Fresnel::None => Fresnel::None,
            d::Fresnel::Dielectric => Fresnel::Dielectric,
            d::Fresnel::Conductor => Fresnel::Conductor,
        },
        alpha: R::from_f64(material.roughness * material.roughness),
        dispersion: R::from_f64(material.dispersion),
        textures,
        pbr: None,
    }
}

fn motion<R: Real>(motion: &d::Motion) -> Motion<R> {
    let vector = |v: Option<Vec3>| DVec3::from_array(v.unwrap_or_default());
    let (axis, degrees) = motion
        .rotate_deg
        .map_or((DVec3::Y, 0.0), |rotation| (DVec3::from_array(rotation.axis).normalize(), rotation.angle));
    Motion::new(vector(motion.translate), axis, degrees, vector(motion.center))
}

fn fog<R: Real>(fog: &d::Fog) -> Fog<R> {
    let height = |height: d::FogHeight| Height { base: R::from_f64(height.base), falloff: R::from_f64(height.falloff) };
    Fog { color: narrow_rgb(fog.color.0), density: R::from_f64(fog.density), height: fog.height.map(height) }
}
