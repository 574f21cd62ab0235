//! Everything that can be hit: bodies, placed once or through groups and instances, searched one after the other.

use super::ray::{Ball, Ray};
use super::shape::{Shape, shape_of};
use super::transform;
use crate::math::Rgb;
use crate::scene::description::{Description, Material, Object, Transform};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The positions that lead to a body: in `objects`, then in the group or definition found there, and so on.
pub(super) type Path = Vec<usize>;

/// A shape with its material.
#[derive(Debug)]
pub(super) struct Body {
    shape: Box<dyn Shape>,
    pub(super) material: Arc<Material>,
    hollow: bool,
}

impl Body {
    /// Index of refraction of the space the shape encloses; none for what is infinitely thin.
    pub(super) fn inner_ior(&self) -> Option<f64> {
        self.shape.volume().map(|_| if self.hollow { 1.0 } else { self.material.ior })
    }

    /// What the space the shape encloses absorbs.
    pub(super) fn inner_absorption(&self) -> Rgb {
        if self.hollow { Rgb::ZERO } else { self.material.absorption.0 }
    }

    /// Whether light passes the surface.
    pub(super) fn transmits(&self) -> bool {
        self.material.transmission.0.max_element() > 0.0
    }
}

#[derive(Debug)]
enum Content {
    Body(Body),
    Placed { to_world: DAffine3, nodes: Arc<[Node]> },
}

#[derive(Debug)]
struct Node {
    /// In the coordinates the node lives in; none if unbounded.
    ball: Option<Ball>,
    content: Content,
}

/// A ray's meeting with a body, in world coordinates where nothing else is said.
#[derive(Debug)]
pub(super) struct Intersection<'a> {
    pub(super) t: f64,
    pub(super) body: &'a Body,
    pub(super) path: Path,
    /// The point in the coordinates the body is written in.
    pub(super) object_point: DVec3,
    /// Unit geometric normal out of the body's material.
    pub(super) ng: DVec3,
    /// Unit shading normal, on either side.
    pub(super) ns: DVec3,
    /// Whether `ns` is interpolated.
    pub(super) smooth: bool,
    /// Vector to the curved surface that interpolated normals suggest, on the side the ray comes from.
    pub(super) lift: DVec3,
    /// Whether the ray passes into the space the shape encloses.
    pub(super) goes_in: bool,
    /// Volume of that space.
    pub(super) volume: f64,
}

/// A body around the eye.
#[derive(Debug)]
pub(super) struct Container {
    pub(super) path: Path,
    pub(super) inner_ior: f64,
    pub(super) absorption: Rgb,
    pub(super) volume: f64,
}

/// The objects of a scene.
#[derive(Debug)]
pub(super) struct World {
    nodes: Vec<Node>,
}

impl World {
    pub(super) fn new(description: &Description) -> Self {
        Self { nodes: Builder::new(description).nodes(&description.objects) }
    }

    /// The first intersection with near < t.
    pub(super) fn closest_hit(&self, ray: &Ray, near: f64) -> Option<Intersection<'_>> {
        let mut closest = None;
        self.each_intersection(ray, near, f64::INFINITY, |intersection| {
            let t = intersection.t;
            closest = Some(intersection);
            t
        });
        closest
    }

    /// Calls `visit` with the intersections of near < t < far, in no order. It returns the new far.
    pub(super) fn each_intersection<'a>(
        &'a self,
        ray: &Ray,
        near: f64,
        far: f64,
        mut visit: impl FnMut(Intersection<'a>) -> f64,
    ) {
        let mut search = Search { near, far, path: Path::new(), visit: &mut visit };
        search.descend(&self.nodes, ray, &DMat3::IDENTITY);
    }

    /// The bodies that contain the ray's origin and transmit or absorb light, in the order of the description.
    pub(super) fn containers(&self, ray: &Ray) -> Vec<Container> {
        let mut found = Vec::new();
        collect_containers(&self.nodes, ray, 1.0, &mut Path::new(), &mut found);
        found
    }
}

struct Search<'a, 'v> {
    near: f64,
    far: f64,
    path: Path,
    visit: &'v mut dyn FnMut(Intersection<'a>) -> f64,
}

impl<'a> Search<'a, '_> {
    /// `ray` is in the coordinates of the nodes, to which `to_object` leads from the world.
    fn descend(&mut self, nodes: &'a [Node], ray: &Ray, to_object: &DMat3) {
        for (i, node) in nodes.iter().enumerate() {
            if node.ball.is_some_and(|ball| !ball.may_meet(ray, self.near, self.far)) {
                continue;
            }
            self.path.push(i);
            match &node.content {
                Content::Body(body) => self.intersect(body, ray, to_object),
                Content::Placed { to_world, nodes } => {
                    let inward = to_world.inverse();
                    self.descend(nodes, &ray.transformed(&inward), &(inward.matrix3 * *to_object));
                }
            }
            self.path.pop();
        }
    }

    fn intersect(&mut self, body: &'a Body, ray: &Ray, to_object: &DMat3) {
        let orientation = if body.hollow { -1.0 } else { 1.0 };
        for crossing in body.shape.crossings(ray) {
            // The sign of d.n is the same in object and world coordinates, as normals go by the inverse transpose.
            let outward = ray.dir.dot(crossing.normal);
            let from_behind = outward * orientation > 0.0;
            let in_range = self.near < crossing.t && crossing.t < self.far;
            if !in_range || (body.material.one_sided && from_behind) {
                continue;
            }
            let to_world = |n: DVec3| (to_object.transpose() * n).normalize_or_zero();
            let ng = to_world(crossing.normal) * orientation;
            let ns = crossing.shading.map(to_world).filter(|&n| n != DVec3::ZERO).unwrap_or(ng);
            self.far = (self.visit)(Intersection {
                t: crossing.t,
                body,
                path: self.path.clone(),
                object_point: crossing.point,
                ng,
                ns,
                smooth: crossing.shading.is_some(),
                lift: to_object.inverse() * crossing.lift,
                goes_in: outward < 0.0,
                volume: body.shape.volume().unwrap_or(f64::INFINITY) / to_object.determinant().abs(),
            });
        }
    }
}

/// `scale` is the factor on volumes from the nodes to the world.
fn collect_containers(nodes: &[Node], ray: &Ray, scale: f64, path: &mut Path, found: &mut Vec<Container>) {
    for (i, node) in nodes.iter().enumerate() {
        if node.ball.is_some_and(|ball| !ball.may_contain(ray.origin)) {
            continue;
        }
        path.push(i);
        match &node.content {
            Content::Placed { to_world, nodes } => {
                let scale = scale * to_world.matrix3.determinant().abs();
                collect_containers(nodes, &ray.transformed(&to_world.inverse()), scale, path, found);
            }
            Content::Body(body) => {
                let matters = body.transmits() || body.inner_absorption().max_element() > 0.0;
                let inner_ior = body.inner_ior().filter(|_| matters && body.shape.contains(ray.origin));
                if let Some(inner_ior) = inner_ior {
                    let volume = body.shape.volume().unwrap_or(f64::INFINITY) * scale;
                    let absorption = body.inner_absorption();
                    found.push(Container { path: path.clone(), inner_ior, absorption, volume });
                }
            }
        }
        path.pop();
    }
}

struct Builder<'a> {
    description: &'a Description,
    materials: HashMap<&'a str, Arc<Material>>,
    default_material: Arc<Material>,
    definitions: HashMap<&'a str, Arc<[Node]>>,
}

impl<'a> Builder<'a> {
    fn new(description: &'a Description) -> Self {
        let materials = description.materials.iter();
        Self {
            description,
            materials: materials.map(|(name, material)| (name.as_str(), Arc::new(material.clone()))).collect(),
            default_material: Arc::default(),
            definitions: HashMap::new(),
        }
    }

    fn nodes(&mut self, objects: &'a [Object]) -> Vec<Node> {
        objects.iter().map(|object| self.node(object)).collect()
    }

    fn node(&mut self, object: &'a Object) -> Node {
        match object {
            Object::Group(group) => {
                let nodes = self.nodes(&group.objects).into();
                placed(&group.transform, nodes)
            }
            Object::Instance(instance) => placed(&instance.transform, self.definition(&instance.of)),
            _ => self.body(object),
        }
    }

    fn body(&self, object: &Object) -> Node {
        let (shape, appearance) = shape_of(object).expect("groups and instances are no bodies");
        let material = appearance.material.and_then(|name| self.materials.get(name)).unwrap_or(&self.default_material);
        let body = Body { shape, material: Arc::clone(material), hollow: appearance.hollow };
        Node { ball: body.shape.ball(), content: Content::Body(body) }
    }

    /// Each definition is built once, however many instances it has.
    fn definition(&mut self, name: &'a str) -> Arc<[Node]> {
        if let Some(nodes) = self.definitions.get(name) {
            return Arc::clone(nodes);
        }
        let objects = self.description.definitions.get(name).map_or(&[][..], Vec::as_slice);
        let nodes: Arc<[Node]> = self.nodes(objects).into();
        self.definitions.insert(name, Arc::clone(&nodes));
        nodes
    }
}

fn placed(transform: &Transform, nodes: Arc<[Node]>) -> Node {
    let to_world = transform::to_parent(transform);
    let balls: Option<Vec<Ball>> = nodes.iter().map(|node| node.ball).collect();
    let ball = balls.map(|balls| Ball::around_balls(balls.into_iter().map(|ball| ball.transformed(&to_world))));
    Node { ball, content: Content::Placed { to_world, nodes } }
}
