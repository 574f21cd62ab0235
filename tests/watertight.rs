//! No ray passes through a closed mesh: aimed exactly at vertices, exactly at edges and at random, from both sides.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail loudly and say what it measured")]

mod common;

use common::Random;
use common::meshes::Closed;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};
use strahl::trace::packets::{FirstHit, first_hits};
use strahl::trace::query::RayQuery;

/// What rays are aimed at.
const KINDS: [&str; 3] = ["vertices", "edges", "random"];

/// An edge, or a vertex twice, and the normals of the faces around it.
struct Aim {
    ends: [DVec3; 2],
    normals: Vec<DVec3>,
}

/// A closed mesh where its rays meet it, and the scene that holds it.
struct Target {
    scene: Scene,
    precision: Precision,
    /// The mesh in the coordinates of the rays, in the numbers the kernel has where it is not instanced.
    mesh: Closed,
    /// The middle of a convex mesh, from inside of which the first surface is always one of leaving.
    middle: Option<DVec3>,
    /// Vertices, as edges from themselves to themselves, and edges.
    aims: [Vec<Aim>; 2],
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
        Self { scene, precision, aims, depth: shape.depth * size, middle, mesh }
    }

    /// The mesh alone, scaled and moved.
    fn plain(shape: &Shape, scale: f64, position: DVec3, precision: Precision) -> Self {
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
        Self::new(scene, mesh, shape, (scale * 0.7 * 1.3, map.translation), precision)
    }

    /// A ray of a kind, from inside or outside, that must hit; `None` if this try found none.
    fn ray(&self, kind: usize, inside: bool, random: &mut Random) -> Option<RayQuery> {
        let aims = &self.aims[usize::from(kind != 0)];
        let Aim { ends: [a, b], normals } = &aims[random.below(aims.len())];
        // Not the ends of edges: far away, rounding moves points there beyond the outline.
        let mut target = narrow(self.precision, *a + (*b - *a) * random.between(0.05, 0.95));
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
        // Seen from there, no face around the target is near its outline, nor is the target where rounding has moved it.
        let side = if inside { -1.0 } else { 1.0 };
        if !normals.iter().all(|normal| normal.dot(back) * side > 0.3) {
            return None;
        }
        if kind == 2 {
            target = if inside { origin + random_point(random) } else { self.random_front(origin, random)? };
        }
        let direction = target - origin;
        let power = direction.abs().max_element().log2().floor();
        let direction = narrow(self.precision, direction * (-power).exp2());
        Some(RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None })
    }

    /// A random point on a random face that is seen from `origin`, away from its border.
    fn random_front(&self, origin: DVec3, random: &mut Random) -> Option<DVec3> {
        let [a, b, c] = self.mesh.faces[random.below(self.mesh.faces.len())].map(|i| self.mesh.vertices[i]);
        let point = a + (b - a) * random.between(0.05, 0.45) + (c - a) * random.between(0.05, 0.45);
        let normal = (b - a).cross(c - a).try_normalize()?;
        (normal.dot((origin - point).normalize()) > 0.01).then_some(point)
    }

    /// How many of `count` rays leak.
    fn leaks(&self, kind: usize, inside: bool, count: usize, random: &mut Random) -> usize {
        let mut rays = Vec::with_capacity(count.min(1 << 12));
        let (mut left, mut leaks) = (count, 0);
        while left > 0 {
            rays.clear();
            while rays.len() < left.min(1 << 12) {
                rays.extend(self.ray(kind, inside, random));
            }
            left -= rays.len();
            let answers = first_hits(&self.scene, &rays);
            let leaked = |(ray, hit): &(&RayQuery, Option<FirstHit>)| self.leaked(ray, hit.as_ref(), inside);
            leaks += rays.iter().zip(answers).filter(leaked).count();
        }
        leaks
    }

    fn leaked(&self, ray: &RayQuery, hit: Option<&FirstHit>, inside: bool) -> bool {
        let Some(hit) = hit else { return true };
        let along = DVec3::from_array(ray.direction).dot(DVec3::from_array(hit.normal));
        // Only seen from inside a concave mesh may the nearest face be one that is grazed.
        self.middle.is_some() && (along > 0.0) != inside
    }
}

/// A mesh to shoot at.
struct Shape {
    mesh: Closed,
    depth: f64,
    convex: bool,
    /// Its scale where Embree tests, so that its edges stay longer than the grid of single precision there.
    far_scale: f64,
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

fn targets(precision: Precision) -> Vec<(String, Target)> {
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

/// Shoots about `count` rays of each kind in a precision; two threads share the targets.
fn shoot(precision: Precision, count: usize) {
    let targets = targets(precision);
    let each = count.div_ceil(targets.len() * 2);
    let start = std::time::Instant::now();
    let (first, second) = targets.split_at(targets.len() / 2);
    let shoot_at = |part: &[(String, Target)], seed: u64| {
        let mut random = Random::new(seed);
        let mut found = Vec::new();
        for (name, target) in part {
            for (kind, what) in KINDS.iter().enumerate() {
                for (inside, side) in [(true, "inside"), (false, "outside")] {
                    let leaks = target.leaks(kind, inside, each, &mut random);
                    if leaks > 0 {
                        found.push(format!("{name}, {what} from {side}: {leaks} of {each}"));
                    }
                }
            }
        }
        found
    };
    let mut found = std::thread::scope(|scope| {
        let other = scope.spawn(|| shoot_at(second, 2));
        let mut found = shoot_at(first, 1);
        found.extend(other.join().unwrap());
        found
    });
    found.sort();
    let rays = each * targets.len() * 2;
    println!(
        "{precision:?}: {rays} rays of each kind in {:.1} s, {} leaks",
        start.elapsed().as_secs_f64(),
        found.len()
    );
    assert!(found.is_empty(), "leaks in {precision:?}:\n{}", found.join("\n"));
}

#[test]
fn no_ray_passes_through_a_closed_mesh() {
    shoot(Precision::Single, 500_000);
    shoot(Precision::Double, 500_000);
}

#[test]
#[ignore = "10^8 rays of each kind take minutes"]
fn none_of_a_hundred_million_rays_passes_through_a_closed_mesh() {
    let count = std::env::var("STRAHL_RAYS").map_or(100_000_000, |n| n.parse().unwrap());
    shoot(Precision::Single, count / 2);
    shoot(Precision::Double, count / 2);
}

/// The triangle test most programs use (Möller and Trumbore 1997), with a bound on the determinant.
macro_rules! moeller_trumbore {
    ($name:ident, $real:ident, $vector:ident) => {
        fn $name(o: glam::$vector, d: glam::$vector, [a, b, c]: [glam::$vector; 3], smallest: $real) -> bool {
            let (e1, e2) = (b - a, c - a);
            let p = d.cross(e2);
            let det = e1.dot(p);
            if det == 0.0 || det.abs() < smallest {
                return false;
            }
            let f = o - a;
            let u = f.dot(p) / det;
            let q = f.cross(e1);
            let v = d.dot(q) / det;
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(q) / det > 0.0
        }
    };
}

moeller_trumbore!(naive_single, f32, Vec3);
moeller_trumbore!(naive_double, f64, DVec3);

/// Shares of rays that the naive tests let out of an icosphere: f32, f32 with |det| > 1e-7, f64.
fn naive_leaks(radius: f64, kind: usize, count: usize) -> [f64; 3] {
    let shape = Shape { mesh: Closed::icosphere(2), depth: 0.5, convex: true, far_scale: 1.0 };
    let target = Target::plain(&shape, radius, DVec3::ZERO, Precision::Single);
    let corners: Vec<_> = target.mesh.faces.iter().map(|face| face.map(|i| target.mesh.vertices[i])).collect();
    let narrow: Vec<_> = corners.iter().map(|face| face.map(|v| v.as_vec3())).collect();
    let mut random = Random::new(3);
    let mut leaks = [0; 3];
    for _ in 0..count {
        let aim = &target.aims[kind][random.below(target.aims[kind].len())];
        let [a, b] = aim.ends.map(|v| v.as_vec3());
        let point = a + (b - a) * random.between(0.0, 1.0) as f32;
        let o = (random_point(&mut random) * 0.3 * radius).as_vec3();
        let d = point - o;
        let hit = |smallest: f32| narrow.iter().any(|&face| naive_single(o, d, face, smallest));
        leaks[0] += usize::from(!hit(0.0));
        leaks[1] += usize::from(!hit(1e-7));
        let hit = corners.iter().any(|&face| naive_double(o.as_dvec3(), d.as_dvec3(), face, 0.0));
        leaks[2] += usize::from(!hit);
    }
    leaks.map(|n| n as f64 / count as f64)
}

fn random_point(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.point(1.0))
}

#[test]
fn the_usual_triangle_tests_leak_so_this_harness_can_see_leaks() {
    for radius in [1.0, 1e-3] {
        let [vertices, edges] = [0, 1].map(|kind| naive_leaks(radius, kind, 40_000));
        println!("radius {radius}: f32, f32 with |det| > 1e-7, f64: vertices {vertices:.4?}, edges {edges:.4?}");
        assert!(vertices[0] > 0.05 && edges[0] > 0.05, "f32 leaks at vertices and edges");
        assert!(vertices[2] > 3e-4, "f64 leaks at vertices too: {}", vertices[2]);
        if radius < 1.0 {
            assert!(vertices[1] == 1.0 && edges[1] == 1.0, "small meshes vanish");
        }
    }
}
