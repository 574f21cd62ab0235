//! A: rays that start on surfaces, and shadows that must be whole.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ball, direction, from_front, square};
use super::solids::{Mesh, cube_mesh};
use super::textbook::{Object, Shape, Tracer};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};

pub const CASES: &[Case] = &[
    ("A01", secondary),
    ("A02", refracted),
    ("A03", corner),
    ("A04", closed_room),
    ("A05", grazing_shadows),
    ("A06", shared_edge),
    ("A07", decal),
];

/// A convex body about a point, by size.
type Body = fn(DVec3, f64, &str) -> Value;

fn sphere(center: DVec3, size: f64, material: &str) -> Value {
    ball(center.to_array(), size, material)
}

fn cuboid(center: DVec3, size: f64, material: &str) -> Value {
    let half = DVec3::splat(size * 0.5);
    json!({ "box": { "min": (center - half).to_array(), "max": (center + half).to_array(), "material": material } })
}

fn cylinder(center: DVec3, size: f64, material: &str) -> Value {
    let half = DVec3::new(0.2, 0.9, 0.1) * size;
    json!({ "cylinder": { "base": (center - half).to_array(), "top": (center + half).to_array(), "radius": size * 0.4, "material": material } })
}

fn cone(center: DVec3, size: f64, material: &str) -> Value {
    let half = DVec3::new(0.2, 0.7, 0.4) * size;
    json!({ "cone": { "base": (center - half).to_array(), "top": (center + half).to_array(), "base_radius": size * 0.6, "material": material } })
}

fn secondary(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pictures of mirrors met twice or bodies not left");
    let bodies: [(&str, Body); 4] = [("sphere", sphere), ("box", cuboid), ("cylinder", cylinder), ("cone", cone)];
    for (name, body) in bodies {
        for size in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
            for away in [0.0, 100.0, 1e4] {
                let center = lab.round3(DVec3::new(0.6, -0.4, 0.7) * away * size);
                let view = |depth: u32| {
                    json!({
                        "camera": { "pinhole": { "eye": (center + DVec3::new(0.7, 1.1, 3.0) * size).to_array(), "look_at": center.to_array() } },
                        "image": square(28), "background": 1, "render": { "max_depth": depth }
                    })
                };
                let film = lab.picture(json!([body(center, size, "mirror")]), view(2)).film;
                let dark = film.pixels.iter().filter(|p| **p != [1.0; 3]).count();
                e.check(dark == 0, || format!("{name} of {size:e} at {away}: {dark} mirrored rays met it again"));
                let rays = lab.picture(json!([body(center, size, "nothing")]), view(4)).rays;
                let left = rays.transmitted == 2 * rays.camera_hits && rays.camera_hits > 50;
                e.check(left, || format!("{name} of {size:e} at {away}: {rays:?}"));
            }
        }
    }
    let mut random = Random::new(60);
    for size in [1e-6, lab.pick(1e3, 1e12)] {
        for _ in 0..500 {
            let n = direction(&mut random);
            let w = direction(&mut random);
            let p = lab.round3(n * size);
            let out = lab.round3(if w.dot(n) < 0.0 { -w } else { w });
            e.twin(naive::sphere(lab, p, out, DVec3::ZERO, size, 1e-4).is_some());
            e.twin(naive::sphere(lab, p, -out, DVec3::ZERO, size, 1e-4).is_none());
        }
    }
    e
}

fn refracted(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("refracted rays");
    let mut random = Random::new(61);
    for size in [1e-6, 1.0, 1e6] {
        for _ in 0..40 {
            let d = direction(&mut random);
            let eye = lab.round3(-d * 3.0 * size + DVec3::from_array(random.point(0.3)) * size);
            let tree = lab.tree(eye, d, json!([ball([0.0; 3], size, "glass")]), json!({}));
            e.check(tree.rays.len() == 3, || format!("size {size:e}: {} rays", tree.rays.len()));
            for pair in tree.rays.windows(2) {
                let at = pair[0].hit.as_ref().unwrap();
                let n = DVec3::from_array(at.normal);
                let moved = DVec3::from_array(pair[1].origin) - DVec3::from_array(at.point);
                let side = n.dot(DVec3::from_array(pair[1].direction));
                e.check(moved.dot(n) * side > 0.0, || format!("size {size:e}: moved by {moved} to the wrong side"));
            }
            // Moved to the side the light came from, the ray meets the face it has just passed.
            let entry = tree.rays[0].hit.as_ref().unwrap();
            let p = DVec3::from_array(entry.point) + DVec3::from_array(entry.normal) * 1e-3 * size;
            let t = naive::sphere(lab, p, DVec3::from_array(tree.rays[1].direction), DVec3::ZERO, size, 0.0);
            e.twin(t.is_some_and(|t| t < 0.1 * size));
        }
    }
    e
}

/// Pixels that are not black.
fn bright(lab: &Lab, objects: Value, more: Value) -> usize {
    lab.picture(objects, more).film.pixels.iter().filter(|p| **p != [0.0; 3]).count()
}

/// Lights outside a room of half-width `size`.
fn lights(size: f64) -> Value {
    let far = 1.5 * size;
    json!([
        { "point": { "position": [far, far, far] } },
        { "point": { "position": [-far, 1.01 * size, 0.3 * size] } },
        { "directional": { "direction": [1, -1, 1] } }
    ])
}

fn corner(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rooms lit from outside");
    for size in [1e-6, 1.0, 1e6] {
        let wall = |axis: usize, side: f64| {
            let (mut low, mut high) = ([-1.01; 3], [1.01; 3]);
            (low[axis], high[axis]) = if side < 0.0 { (-1.01, -1.0) } else { (1.0, 1.01) };
            json!({ "box": { "min": low.map(|x| x * size), "max": high.map(|x| x * size), "material": "matt" } })
        };
        let walls: Vec<Value> = (0..6).map(|i| wall(i / 2, [-1.0, 1.0][i % 2])).collect();
        for look in [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, -1.0]] {
            let more = json!({
                "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": look.map(|x: f64| x * size), "vfov_deg": 70 } },
                "image": square(64), "lights": lights(size), "background": 1
            });
            let count = bright(lab, json!(walls), more);
            e.check(count == 0, || format!("size {size:e}: {count} pixels shine in the corner"));
        }
        // The same room with rays that start a ten-thousandth above the walls.
        let room: Vec<Object> = (0..6)
            .map(|i| {
                let (axis, (mut low, mut high)) = (i / 2, (DVec3::splat(-1.01), DVec3::splat(1.01)));
                (low[axis], high[axis]) = [(-1.01, -1.0), (1.0, 1.01)][i % 2];
                Object::matt(Shape::Cuboid(lab.round3(low * size), lab.round3(high * size)))
            })
            .collect();
        let mut twin = Tracer::new(lab, room);
        (twin.offset, twin.background) = (1e-4, 1.0);
        twin.lights = [[1.5, 1.5, 1.5], [-1.5, 1.01, 0.3]].map(|p| (DVec3::from_array(p) * size, 1.0)).to_vec();
        let mut random = Random::new(64);
        for _ in 0..200 {
            let d = lab.round3(DVec3::from_array(random.point(0.2)) + DVec3::new(1.0, -1.0, 1.0)).normalize();
            e.twin(twin.radiance(DVec3::ZERO, lab.round3(d), 0) > 0.0);
        }
    }
    e
}

fn closed_room(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("closed rooms");
    for size in [1e-3, 1.0, 1e5] {
        let rooms = [
            Mesh::icosphere(2).placed(lab, size, DVec3::ZERO).json("matt"),
            cube_mesh().placed(lab, size, DVec3::ZERO).json("matt"),
            ball([0.0; 3], size, "matt"),
            cuboid(DVec3::ZERO, size, "matt"),
        ];
        for room in rooms {
            let more = json!({
                "camera": { "fisheye": { "eye": [0, 0, 0], "look_at": [size, 0.5 * size, 0.2 * size], "fov_deg": 360 } },
                "image": square(80), "lights": lights(2.0 * size)
            });
            let mut more = more;
            // Outside the fisheye's circle there is background, so it must be black; what leaks is light.
            more["background"] = json!(0);
            let count = bright(lab, json!([room]), more);
            e.check(count == 0, || format!("size {size:e}: {count} pixels are lit"));
        }
    }
    let room = Mesh::icosphere(3).placed(lab, 1.0, DVec3::ZERO);
    let o = lab.round3(DVec3::new(0.1, -0.2, 0.15));
    for aim in &room.vertices {
        let d = lab.round3(*aim - o);
        let mut ahead = room.triangles().filter(|t| (t[0] - o).dot(d) > 0.0);
        e.twin(!ahead.any(|t| naive::triangle(lab, o, d, t, 0.0).is_some()));
    }
    e
}

fn grazing_shadows(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels of sunlit ground");
    for (normal, slope) in [([0.0, 1.0, 0.0], 1e-3), ([0.1, 1.0, -0.05], 1e-2), ([0.1, 1.0, -0.05], 0.3)] {
        let up = DVec3::from_array(normal).normalize();
        let along = up.cross(DVec3::Z).normalize();
        let sun = along - up * slope;
        let more = json!({
            "camera": { "pinhole": { "eye": up.to_array(), "look_at": (up - DVec3::Z - up * 0.01).to_array(), "vfov_deg": 30 } },
            "image": square(96), "background": [0, 0, 1], "lights": [{ "directional": { "direction": sun.to_array() } }]
        });
        let ground = json!([{ "plane": { "point": [0, 0, 0], "normal": normal, "material": "matt" } }]);
        for pixel in lab.picture(ground, more).film.pixels {
            let sky = pixel == [0.0, 0.0, 1.0];
            e.check(sky || pixel[0] > 0.0, || format!("a dark pixel under a sun of slope {slope}"));
        }
    }
    let (mut random, n) = (Random::new(62), lab.round3(DVec3::new(0.1, 1.0, -0.05).normalize()));
    for _ in 0..400 {
        let far = lab.pick(1e5, 1e14);
        let d = DVec3::new(random.between(-1.0, 1.0), -lab.pick(1e-5, 1e-14), -1.0);
        let d = lab.round3(d - n * d.dot(n) - n / far);
        let p = naive::point(lab, n, d, naive::plane(lab, n, d, DVec3::ZERO, n));
        let to_sun = lab.round3(n.cross(DVec3::Z).normalize() + n * 1e-3);
        e.twin(naive::plane(lab, p, to_sun, DVec3::ZERO, n) > 1e-4);
    }
    e
}

fn shared_edge(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("mirrored rays off convex meshes");
    for (size, away) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e3), (1.0, 148_376.0)] {
        let center = DVec3::new(away, 0.25 * away, -away);
        for mesh in [cube_mesh(), Mesh::icosphere(1)] {
            let object = mesh.placed(lab, size, center).json("mirror");
            let more = json!({
                "camera": from_front(center.to_array(), 4.0 * size, 2.0 * size), "image": square(48), "background": 1,
                "render": { "max_depth": 2 }
            });
            for pixel in lab.picture(json!([object]), more).film.pixels {
                e.check(pixel == [1.0; 3], || format!("size {size:e} at {away}: {pixel:?}"));
            }
        }
    }
    // Off one triangle, leaving out that one alone: the neighbour across the edge is met.
    let mesh = Mesh::icosphere(1).placed(lab, lab.pick(1e3, 1e12), DVec3::ZERO);
    let mut random = Random::new(63);
    for (i, corners) in mesh.triangles().enumerate() {
        let p = lab.round3((corners[0] + corners[1]) / 2.0);
        for _ in 0..20 {
            let w = direction(&mut random);
            let d = lab.round3(if w.dot(p) < 0.0 { -w } else { w });
            let mut others = mesh.triangles().enumerate().filter(|(k, _)| *k != i);
            e.twin(others.any(|(_, t)| {
                naive::triangle(lab, p, d, t, 0.0).is_some_and(|[t, ..]| t > 0.0 && t < 1e-2 * p.length())
            }));
        }
    }
    e
}

fn decal(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels of decals");
    let quad = |y: f64, half: f64, material: &str| json!({ "quad": { "vertices": [[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]], "material": material } });
    // Within a few roundings of the way to the eye the order is that of the computed distances.
    for gap in [1e-3, 1e-5, 64.0 * lab.u, 16.0 * lab.u] {
        for order in [0, 1] {
            let mut objects = vec![quad(0.0, 2.0, "red"), quad(gap, 1.75, "green")];
            objects.rotate_left(order);
            let more = json!({
                "camera": { "pinhole": { "eye": [0.1, 1, 0.2], "look_at": [0, 0, 0], "up": [0, 0, -1], "vfov_deg": 60 } }, "image": square(48)
            });
            for pixel in lab.picture(json!(objects), more).film.pixels {
                e.check(pixel == [0.0, 1.0, 0.0], || format!("gap {gap:e}: {pixel:?}"));
            }
        }
        // A depth tolerance of 1e-4 takes both for one: that written first.
        let quad = |y: f64, half: f64| {
            let [a, b, c, d] = [(-half, half), (half, half), (half, -half), (-half, -half)]
                .map(|(x, z)| lab.round3(DVec3::new(x, y, z)));
            [[a, b, c], [a, c, d]].map(|t| Object::seen(Shape::Triangle(t), y))
        };
        let mut twin = Tracer::new(lab, [quad(0.0, 2.0), quad(gap, 1.75)].concat());
        twin.same = 1e-4;
        let mut random = Random::new(65);
        for _ in 0..50 {
            let eye = lab.round3(DVec3::new(0.1, 1.0, 0.2));
            let d = lab.round3(DVec3::from_array(random.point(0.5)).with_y(0.0) - eye);
            e.twin(twin.nearest(eye, d).is_none_or(|(_, i)| i < 2));
        }
    }
    e
}
