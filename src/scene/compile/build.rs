//! A checked description in the kernel's format.

use super::paint::paint;
use super::transform::affine;
use super::{CompileOptions, Source, Sources, contact, extent};
use crate::accel::{Ball, Blockers, Bounds, Extent, Geometry, Instance, Item, Mesh, Shape};
use crate::camera::{Basis, Camera};
use crate::lanes::Real;
use crate::math::{self, Rgb};
use crate::plan::effects::Called;
use crate::scene::description::{self as d, Description, Look, Object, Shadows, Vec3};
use crate::scene::ear_clipping::triangulate;
use crate::scene::pictures::{Meaning, Pictures};
use crate::scene::problem::push_token;
use crate::scene::world::{Rules, World};
use crate::shading::environment::Environment;
use crate::shading::light::{Falloff, Light, Source as LightSource};
use crate::shading::material::Material;
use crate::shape::{Cuboid, Disc, Frame, Frustum, Plane, Sides, Sphere, Torus};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// What building finds out besides the world.
pub(super) struct Built {
    pub(super) sources: Sources,
    pub(super) expanded: u128,
}

/// Builds the world of a checked description.
pub(super) fn build<R: Real>(
    description: &Description,
    options: CompileOptions,
    pictures: &Pictures<'_>,
) -> (World<R>, Built) {
    let mut builder = Builder::<R>::new(description, options, pictures);
    let list = builder.list("/objects".to_owned());
    let root = builder.geometry(&description.objects, list);
    contact::mark_placed(&mut builder.geometries);
    let expanded = builder.expanded[root];
    let bounds = builder.geometries[root].extent.bounds;
    let size = if bounds == Bounds::EMPTY { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
    let render = &description.render;
    let basis = Basis::new(&description.camera.view()).unwrap_or_else(|| unreachable!("the camera has been checked"));
    let transmits = builder.geometries.iter().any(|geometry| geometry.items.iter().any(Item::lets_light_through));
    let (background, environment) = surroundings(description, pictures);
    let called = called(&builder, environment.is_some());
    let world = World {
        geometries: builder.geometries,
        root,
        size: R::from_f64(size),
        transmits,
        called,
        materials: builder.materials,
        lights: description.lights.iter().map(light).collect(),
        ambient: narrow_rgb(description.ambient.0),
        background: narrow_rgb(background),
        environment,
        camera: Camera::new(&description.camera, &basis, description.image.width, description.image.height),
        rules: Rules {
            max_depth: render.max_depth,
            min_weight: R::from_f64(render.min_weight),
            shadows: match render.shadows {
                Shadows::Transmissive if transmits => Some(Blockers::Transmissive),
                // Where no body transmits light, the first one on the way decides.
                Shadows::Opaque | Shadows::Transmissive => Some(Blockers::Opaque),
                Shadows::None => None,
            },
            spd_counts: options.spd_counts,
        },
    };
    (world, Built { sources: builder.sources, expanded })
}

/// What rays see that hit nothing: a colour, or a picture if it has more than one.
fn surroundings(description: &Description, pictures: &Pictures<'_>) -> (Rgb, Option<Environment>) {
    let Some(d::Environment { image, rotate_deg, intensity }) = &description.environment else {
        return (description.background.0, None);
    };
    let pyramid = pictures.get(image, Meaning::Color);
    // Around the circles of domes there are no rays, which would see them: only the background.
    let circle = matches!(description.camera, d::Camera::Fisheye(_) | d::Camera::Omnimax(_));
    let uniform = if *intensity == 0.0 { Some([0.0; 3]) } else { pyramid.uniform() };
    match uniform {
        Some(color) if !circle => (Rgb::from_array(color) * *intensity, None),
        _ => {
            let environment = Environment { pyramid, turn: rotate_deg / 360.0, intensity: *intensity };
            (description.background.0, Some(environment))
        }
    }
}

/// The effects that the scene calls for: of materials, those that a body has.
fn called<R: Real>(builder: &Builder<'_, R>, environment: bool) -> Called {
    let bodies = builder.geometries.iter().flat_map(|geometry| &geometry.items);
    let mut materials = bodies
        .filter(|item| !matches!(item.shape, Shape::Instance(_)))
        .map(|item| &builder.materials[item.material as usize]);
    Called { environment, paint: materials.any(|material| material.paint.is_some()), ..Called::default() }
}

struct Builder<'a, R> {
    description: &'a Description,
    options: CompileOptions,
    geometries: Vec<Geometry<R>>,
    /// Primitives of each geometry when expanded; may be beyond what 64 bits hold until that is checked.
    expanded: Vec<u128>,
    /// The geometry of each definition built so far.
    definitions: Vec<Option<usize>>,
    /// One for each of the description's, and the default material last.
    materials: Vec<Material<R>>,
    one_sided: Vec<bool>,
    sources: Sources,
}

impl<'a, R: Real> Builder<'a, R> {
    fn new(description: &'a Description, options: CompileOptions, pictures: &Pictures<'_>) -> Self {
        let fallback = d::Material::default();
        let all = || description.materials.iter().map(|(_, m)| m).chain([&fallback]);
        Self {
            description,
            options,
            geometries: Vec::new(),
            expanded: Vec::new(),
            definitions: vec![None; description.definitions.len()],
            materials: all().map(|m| material(m, pictures)).collect(),
            one_sided: all().map(|m| m.one_sided).collect(),
            sources: Sources::default(),
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
                instance.ball = extent.as_ref().map(Ball::new);
            }
        }
        contact::mark_siblings(&mut items, &extents);
        let geometry = Geometry::new(items, &extents, self.options.bvh);
        self.geometries.push(geometry);
        self.expanded.push(expanded);
        self.geometries.len() - 1
    }

    fn collect(&mut self, objects: &'a [Object], list: u32, into: &mut Collected<R>) {
        into.items.reserve(objects.len());
        into.extents.reserve(objects.len());
        self.sources.entries.reserve(objects.len());
        for (index, object) in objects.iter().enumerate() {
            let source = self.sources.entries.len() as u32;
            let entry = |name: Option<&str>| Source { list, index: index as u32, name: name.map(Into::into) };
            match object {
                Object::Group(group) => {
                    self.sources.entries.push(entry(group.name.as_deref()));
                    let inner = self.list(format!("{}/{index}/group/objects", self.sources.lists[list as usize]));
                    if group.transform == d::Transform::default() {
                        self.collect(&group.objects, inner, into);
                    } else {
                        let geometry = self.geometry(&group.objects, inner);
                        into.push(self.instance(geometry, &group.transform, source), None, self.expanded[geometry]);
                    }
                }
                Object::Instance(instance) => {
                    self.sources.entries.push(entry(instance.name.as_deref()));
                    let geometry = self.definition(&instance.of);
                    into.push(self.instance(geometry, &instance.transform, source), None, self.expanded[geometry]);
                }
                _ => {
                    let needs_uvs = matches!(object, Object::Mesh(mesh) if self.needs_uvs(mesh));
                    let (shape, look) = shape(object, needs_uvs);
                    self.sources.entries.push(entry(look.name));
                    let count = if let Shape::Mesh(mesh) = &shape { mesh.faces.len() as u128 } else { 1 };
                    let item = self.item(object, shape, look, source);
                    into.push(item, extent::of_object::<R>(object), count);
                }
            }
        }
    }

    fn needs_uvs(&self, mesh: &d::Mesh) -> bool {
        let material = mesh.material.as_ref().and_then(|name| self.description.materials.get(name));
        material.is_some_and(d::Material::needs_uvs)
    }

    fn definition(&mut self, name: &str) -> usize {
        let description = self.description;
        let position = description.definitions.position(name).unwrap_or_else(|| unreachable!("checked reference"));
        if let Some(geometry) = self.definitions[position] {
            return geometry;
        }
        let (name, objects) = description.definitions.at(position);
        let list = self.list(push_token("/definitions", name));
        let geometry = self.geometry(objects, list);
        self.definitions[position] = Some(geometry);
        geometry
    }

    fn instance(&self, geometry: usize, transform: &d::Transform, source: u32) -> Item<R> {
        let map = affine(transform).unwrap_or(DAffine3::IDENTITY);
        let instance = Instance::new(geometry as u32, map);
        Item {
            shape: Shape::Instance(Box::new(instance)),
            material: 0,
            sides: Sides::Both,
            hollow: false,
            closed: false,
            may_touch: false,
            volume: 0.0,
            transmission: [R::from_f64(0.0); 3],
            source,
            offset: 0,
            expanded: 0,
        }
    }

    fn item(&self, object: &Object, shape: Shape<R>, look: Look<'_>, source: u32) -> Item<R> {
        let default = self.materials.len() - 1;
        let material = look.material.and_then(|name| self.description.materials.position(name)).unwrap_or(default);
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
        };
        Item {
            shape,
            material: material as u32,
            sides,
            hollow: look.hollow,
            closed,
            may_touch: false,
            volume: if closed { volume(object) } else { 0.0 },
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

/// What a closed body encloses.
fn volume(object: &Object) -> f64 {
    let distance = |a: Vec3, b: Vec3| DVec3::from_array(a).distance(DVec3::from_array(b));
    match object {
        Object::Sphere(o) => 4.0 / 3.0 * PI * o.radius.powi(3),
        Object::Box(o) => (DVec3::from_array(o.max) - DVec3::from_array(o.min)).element_product(),
        Object::Cylinder(o) => PI * o.radius * o.radius * distance(o.base, o.top),
        Object::Cone(o) => {
            let (r, q) = (o.base_radius, o.top_radius);
            PI / 3.0 * distance(o.base, o.top) * (r * r + r * q + q * q)
        }
        Object::Torus(o) => 2.0 * PI * PI * o.major_radius * o.minor_radius * o.minor_radius,
        Object::Mesh(o) => {
            // Sum of the signed volumes of the tetrahedra below the faces, seen from a point near the mesh.
            let corner = |i: u32| DVec3::from_array(o.vertices[i as usize]);
            let apex = corner(o.faces[0][0]);
            let six = |f: &[u32; 3]| (corner(f[0]) - apex).dot((corner(f[1]) - apex).cross(corner(f[2]) - apex));
            o.faces.iter().map(six).sum::<f64>().abs() / 6.0
        }
        _ => f64::INFINITY,
    }
}

/// Whether a face has two corners in one place.
pub(crate) fn is_collapsed<T: PartialEq>(vertices: &[T], face: &[u32; 3]) -> bool {
    let [a, b, c] = face.map(|i| &vertices[i as usize]);
    a == b || b == c || c == a
}

/// `needs_uvs`: whether its material looks at texture coordinates.
fn shape<R: Real>(object: &Object, needs_uvs: bool) -> (Shape<R>, Look<'_>) {
    let number = R::from_f64;
    let point = |p: Vec3| p.map(R::from_f64);
    let vector = DVec3::from_array;
    let plane =
        |at: Vec3, normal: Vec3| Plane { point: point(at), normal: point(vector(normal).normalize().to_array()) };
    match object {
        Object::Sphere(o) => (Shape::Sphere(Sphere { center: point(o.center), radius: number(o.radius) }), o.look()),
        Object::Plane(o) => (Shape::Plane(plane(o.point, o.normal)), o.look()),
        Object::Disc(o) => (Shape::Disc(Disc { plane: plane(o.center, o.normal), radius: number(o.radius) }), o.look()),
        Object::Triangle(o) => (Shape::Mesh(mesh(&o.vertices, &[[0, 1, 2]], None, None)), o.look()),
        Object::Quad(o) => (Shape::Mesh(mesh(&o.vertices, &[[0, 1, 2], [0, 2, 3]], None, None)), o.look()),
        Object::Box(o) => (Shape::Cuboid(Cuboid { min: point(o.min), max: point(o.max) }), o.look()),
        Object::Cylinder(o) => {
            (Shape::Frustum(frustum(vector(o.base), vector(o.top), o.radius, o.radius, o.capped)), o.look())
        }
        Object::Cone(o) => {
            (Shape::Frustum(frustum(vector(o.base), vector(o.top), o.base_radius, o.top_radius, o.capped)), o.look())
        }
        Object::Torus(o) => {
            let torus = Torus {
                frame: Frame::new(vector(o.center), vector(o.axis).normalize()),
                major_radius: number(o.major_radius),
                minor_radius: number(o.minor_radius),
            };
            (Shape::Torus(Box::new(torus)), o.look())
        }
        Object::Mesh(o) => (
            Shape::Mesh(mesh(&o.vertices, &o.faces, o.normals.as_deref(), o.uvs.as_deref().filter(|_| needs_uvs))),
            o.look(),
        ),
        Object::Polygon(o) => {
            let faces = triangulate(&o.vertices).unwrap_or_default();
            (Shape::Mesh(mesh(&o.vertices, &faces, None, None)), o.look())
        }
        Object::Group(_) | Object::Instance(_) => unreachable!("groups and instances are no shapes"),
    }
}

fn frustum<R: Real>(base: DVec3, top: DVec3, base_radius: f64, top_radius: f64, capped: bool) -> Box<Frustum<R>> {
    let height = base.distance(top);
    Box::new(Frustum {
        frame: Frame::new(base, (top - base) / height),
        height: R::from_f64(height),
        base_radius: R::from_f64(base_radius),
        top_radius: R::from_f64(top_radius),
        slope: R::from_f64((top_radius - base_radius) / height),
        capped,
    })
}

/// A mesh without the faces that rounding has collapsed to lines; slivers stay, since neighbours rely on their edges.
fn mesh<R: Real>(vertices: &[Vec3], faces: &[[u32; 3]], normals: Option<&[Vec3]>, uvs: Option<&[[f64; 2]]>) -> Mesh<R> {
    let vertices: Vec<[R; 3]> = vertices.iter().map(|v| v.map(R::from_f64)).collect();
    // Not collected one by one, which would reserve up to twice the memory.
    let mut faces = faces.to_vec();
    faces.retain(|face| !is_collapsed(&vertices, face));
    let unit = |n: &Vec3| DVec3::from_array(*n).normalize_or_zero().to_array().map(R::from_f64);
    let uvs = uvs.unwrap_or_default().iter().map(|uv| uv.map(R::from_f64)).collect();
    Mesh { faces, normals: normals.unwrap_or_default().iter().map(unit).collect(), vertices, uvs }
}

pub(super) fn narrow_rgb<R: Real>(color: Rgb) -> [R; 3] {
    color.to_array().map(R::from_f64)
}

/// 1/x for powers of two, whose reciprocals are exact.
pub(super) fn exact_inverse<R: Real>(x: f64) -> Option<R> {
    (math::scale_by_power(1.0, math::exponent(x)) == x).then(|| R::from_f64(1.0 / x))
}

fn material<R: Real>(material: &d::Material, pictures: &Pictures<'_>) -> Material<R> {
    let (ambient, diffuse, paint) = paint(material, pictures);
    Material {
        ambient,
        diffuse,
        specular: narrow_rgb(material.specular.0),
        shininess: R::from_f64(material.shininess),
        reflection: narrow_rgb(material.reflection.0),
        transmission: narrow_rgb(material.transmission.0),
        ior: R::from_f64(material.ior),
        paint,
    }
}

fn light<R: Real>(light: &d::Light) -> Light<R> {
    let point = |p: Vec3| p.map(R::from_f64);
    let unit = |v: Vec3| DVec3::from_array(v).normalize();
    let fall = |falloff: d::Falloff| match falloff {
        d::Falloff::None => Falloff::None,
        d::Falloff::Linear(linear) => Falloff::Linear { reach: R::from_f64(linear.reach) },
        d::Falloff::InverseSquare => Falloff::InverseSquare,
    };
    let (source, color, intensity, falloff) = match light {
        d::Light::Point(l) => {
            (LightSource::Point { position: point(l.position) }, l.color, l.intensity, fall(l.falloff))
        }
        d::Light::Directional(l) => {
            let to_light = (-unit(l.direction)).to_array().map(R::from_f64);
            (LightSource::Directional { to_light }, l.color, l.intensity, Falloff::None)
        }
        d::Light::Spot(l) => {
            // 1 - cos(a) = 2 sin^2(a/2).
            let versine = |degrees: f64| R::from_f64(2.0 * math::sin_cos(degrees.to_radians() * 0.5).0.powi(2));
            let source = LightSource::Spot {
                position: point(l.position),
                axis: unit(l.direction).to_array().map(R::from_f64),
                inner: versine(l.inner_deg),
                outer: versine(l.outer_deg),
            };
            (source, l.color, l.intensity, fall(l.falloff))
        }
    };
    Light { source, color: narrow_rgb(color.0 * intensity), falloff }
}
