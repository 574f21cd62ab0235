//! Closed meshes as targets, and rays aimed at their vertices and edges that must hit.

use super::exact::meets_inside;
use crate::common::Random;
use crate::common::meshes::Closed;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use strahl::inspect::first_hits::{FirstHit, first_hits};
use strahl::inspect::query::RayQuery;
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};

/// What rays are aimed at.
pub const KINDS: [&str; 3] = ["vertices", "edges", "random"];

/// An edge, or a vertex twice, and the normals of the faces around it.
pub struct Aim {
    pub ends: [DVec3; 2],
    normals: Vec<DVec3>,
}

/// A closed mesh where its rays meet it, and the scene that holds it.
pub struct Target {
    scene: Scene,
    pub precision: Precision,
    /// The mesh in the coordinates of the rays, in the numbers the kernel has where it is not instanced.
    pub mesh: Closed,
    /// The middle of a convex mesh, from inside of which the first surface is always one of leaving.
    middle: Option<DVec3>,
    /// Vertices, as edges from themselves to themselves, and edges.
    pub aims: [Vec<Aim>; 2],
    /// Whether `mesh` is what the kernel holds, to the bit.
    exact: bool,
    /// A length that is short inside the mesh: no point that far below a vertex, or beside the middle, is outside.
    depth: f64,
}

fn narrow(precision: Precision, v: DVec3) -> DVec3 {
    match precision {
        Precision::Single => v.as_vec3().as_dvec3(),
        Precision::Double => v,
    }
}

fn scene_of(objects: Value, definitions: Value, precision: Precision) -> Scene {
    let text = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "materials": { "m": { "diffuse": 0.5 } },
        "definitions": definitions,
        "objects": objects
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}

fn aims(mesh: &Closed, list: &[[usize; 2]]) -> Vec<Aim> {
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (index, face) in mesh.faces.iter().enumerate() {
        face.iter().for_each(|&vertex| around[vertex].push(index));
    }
    let normal = |face: &usize| {
        let [a, b, c] = mesh.faces[*face].map(|i| mesh.vertices[i]);
        (b - a).cross(c - a).try_normalize()
    };
    let aim = |&[a, b]: &[usize; 2]| Aim {
        ends: [a, b].map(|i| mesh.vertices[i]),
        normals: around[a].iter().filter(|face| around[b].contains(face)).filter_map(normal).collect(),
    };
    list.iter().map(aim).collect()
}

impl Target {
    fn new(scene: Scene, mesh: Closed, shape: &Shape, (size, middle): (f64, DVec3), precision: Precision) -> Self {
        let middle = shape.convex.then_some(middle);
        let vertices: Vec<_> = (0..mesh.vertices.len()).map(|i| [i, i]).collect();
        let aims = [vertices, mesh.edges()].map(|list| aims(&mesh, &list));
        Self { scene, precision, aims, depth: shape.depth * size, middle, mesh, exact: true }
    }

    /// The mesh alone, scaled and moved.
    pub fn plain(shape: &Shape, scale: f64, position: DVec3, precision: Precision) -> Self {
        let mut mesh = shape.mesh.placed(scale, position);
        let scene = scene_of(json!([mesh.json("m")]), json!({}), precision);
        for vertex in &mut mesh.vertices {
            *vertex = narrow(precision, *vertex);
        }
        Self::new(scene, mesh, shape, (scale, position), precision)
    }

    /// The mesh in three placements, one inside the other.
    fn nested(shape: &Shape, scale: f64, precision: Precision) -> Self {
        let turns = [(37.0, [1.0, 2.0, 3.0]), (-71.0, [-2.0, 1.0, 0.5]), (123.0, [0.3, -1.0, 2.0])];
        let moves = [[3.0, -1.0, 2.0], [0.5, 0.25, -7.0], [-1.0, 4.0, 0.125]];
        let mut object = json!({ "instance": { "of": "body" } });
        let mut map = DAffine3::IDENTITY;
        for (i, ((angle, axis), shift)) in turns.into_iter().zip(moves).enumerate() {
            let factor = if i == 0 { scale } else { [0.7, -1.3][i - 1] };
            let translate = shift.map(|x: f64| x * scale);
            let placed =
                json!({ "scale": factor, "rotate_deg": { "axis": axis, "angle": angle }, "translate": translate });
            if i == 0 {
                object["instance"]["transform"] = placed;
            } else {
                object = json!({ "group": { "transform": placed, "objects": [object] } });
            }
            let turn = DQuat::from_axis_angle(DVec3::from_array(axis).normalize(), f64::to_radians(angle));
            let linear = DMat3::from_quat(turn) * factor;
            map = DAffine3 { matrix3: linear, translation: DVec3::from_array(translate) } * map;
        }
        let definitions = json!({ "body": [shape.mesh.json("m")] });
        let scene = scene_of(json!([object]), definitions, precision);
        let mut mesh = shape.mesh.clone();
        for vertex in &mut mesh.vertices {
            *vertex = map.transform_point3(*vertex);
        }
        if map.matrix3.determinant() < 0.0 {
            for face in &mut mesh.faces {
                face.swap(1, 2);
            }
        }
        Self { exact: false, ..Self::new(scene, mesh, shape, (scale * 0.7 * 1.3, map.translation), precision) }
    }

    /// A ray of a kind, from inside or outside, that must hit; `None` if this try found none.
    pub fn ray(&self, kind: usize, inside: bool, random: &mut Random) -> Option<RayQuery> {
        let aims = &self.aims[usize::from(kind != 0)];
        let Aim { ends: [a, b], normals } = &aims[random.below(aims.len())];
        // Not the ends of edges of placed meshes: far away, rounding moves points there beyond the outline.
        let margin = if self.exact { 0.0 } else { 0.05 };
        let mut target = narrow(self.precision, *a + (*b - *a) * random.between(margin, 1.0 - margin));
        let outward = normals.iter().sum::<DVec3>().try_normalize()?;

        let length =
            if inside { -self.depth * random.between(0.2, 1.0) } else { self.depth * random.between(0.2, 30.0) };
        let turn = DVec3::from_array(random.point(if inside { 0.3 } else { 0.8 }));
        let origin = match self.middle {
            Some(middle) if inside => middle + random_point(random) * self.depth,
            _ => target + (outward + turn).normalize() * length,
        };
        let origin = narrow(self.precision, origin);
        let back = (origin - target).normalize();
        // Seen from there, no face around the target is edge-on, nor of placed meshes near the outline at all.
        let side = if inside { -1.0 } else { 1.0 };
        let least = if self.exact { 0.05 } else { 0.3 };
        if !normals.iter().all(|normal| normal.dot(back) * side > least) {
            return None;
        }
        if kind == 2 {
            target = if inside { origin + random_point(random) } else { self.random_front(origin, random)? };
        }
        let direction = target - origin;
        let power = f64::from(strahl::math::exponent(direction.abs().max_element()));
        let direction = narrow(self.precision, direction * strahl::math::pow(2.0, -power));
        Some(RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None })
    }

    /// A random point on a random face that is seen from `origin`, away from its border.
    fn random_front(&self, origin: DVec3, random: &mut Random) -> Option<DVec3> {
        let [a, b, c] = self.mesh.faces[random.below(self.mesh.faces.len())].map(|i| self.mesh.vertices[i]);
        let point = a + (b - a) * random.between(0.05, 0.45) + (c - a) * random.between(0.05, 0.45);
        let normal = (b - a).cross(c - a).try_normalize()?;
        (normal.dot((origin - point).normalize()) > 0.01).then_some(point)
    }

    /// How many of `count` rays leak, and how many pass by the mesh.
    pub fn leaks(&self, kind: usize, inside: bool, count: usize, random: &mut Random) -> (usize, usize) {
        let mut rays = Vec::with_capacity(count.min(1 << 12));
        let (mut left, mut leaks, mut beside) = (count, 0, 0);
        while left > 0 {
            rays.clear();
            while rays.len() < left.min(1 << 12) {
                rays.extend(self.ray(kind, inside, random));
            }
            left -= rays.len();
            let answers = first_hits(&self.scene, &rays);
            let leaked = |(ray, hit): &(&RayQuery, Option<FirstHit>)| self.leaked(ray, hit.as_ref(), inside);
            for (ray, _) in rays.iter().zip(answers).filter(leaked) {
                if self.exact && !meets_inside(&self.mesh, ray, self.rounding(ray)) {
                    beside += 1;
                } else {
                    leaks += 1;
                }
            }
        }
        (leaks, beside)
    }

    /// How far rounding may move the mesh as the ray sees it: roundings of the way to its far end.
    fn rounding(&self, ray: &RayQuery) -> f64 {
        let u = if self.precision == Precision::Single { f32::EPSILON.into() } else { f64::EPSILON };
        let ends = self.mesh.vertices.iter().map(|v| v.distance(ray.origin.into()));
        8.0 * u * ends.fold(0.0, f64::max)
    }

    fn leaked(&self, ray: &RayQuery, hit: Option<&FirstHit>, inside: bool) -> bool {
        let Some(hit) = hit else { return true };
        let along = DVec3::from_array(ray.direction).dot(DVec3::from_array(hit.normal));
        // Only seen from inside a concave mesh may the nearest face be one that is grazed.
        self.middle.is_some() && (along > 0.0) != inside
    }
}

/// A mesh to shoot at.
pub struct Shape {
    pub mesh: Closed,
    pub depth: f64,
    pub convex: bool,
    /// Its scale where Embree tests, so that its edges stay longer than the grid of single precision there.
    pub far_scale: f64,
}

fn shapes() -> [Shape; 3] {
    [
        Shape { mesh: Closed::icosphere(3), depth: 0.5, convex: true, far_scale: 2.0 },
        Shape { mesh: Closed::knot(), depth: 0.2, convex: false, far_scale: 200.0 },
        Shape { mesh: Closed::cube(), depth: 0.5, convex: true, far_scale: 2.0 },
    ]
}

/// Where Embree's own test of watertightness places its meshes.
const EMBREE: DVec3 = DVec3::new(148_376.0, 1234.0, -223_423.0);

/// All shapes at all scales and places.
pub fn targets(precision: Precision) -> Vec<(String, Target)> {
    let mut targets = Vec::new();
    for (name, shape) in ["icosphere", "knot", "cube"].into_iter().zip(&shapes()) {
        for scale in [1e-6, 1e-3, 1.0, 1e2, 1e4, 1e6] {
            targets.push((format!("{name} at {scale:e}"), Target::plain(shape, scale, DVec3::ZERO, precision)));
        }
        targets.push((format!("{name}, far away"), Target::plain(shape, shape.far_scale, EMBREE, precision)));
        for scale in [1e-3, 1.0] {
            targets.push((format!("{name}, nested at {scale:e}"), Target::nested(shape, scale, precision)));
        }
    }
    targets
}

/// A point of the cube [-1, 1]^3.
pub fn random_point(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.point(1.0))
}
