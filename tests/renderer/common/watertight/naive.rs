//! The triangle tests that most programs use, for the same aims.

use super::target::{Shape, Target, random_point};
use crate::common::Random;
use crate::common::meshes::Closed;
use glam::DVec3;
use strahl::scene::description::Precision;

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
pub fn shares(radius: f64, kind: usize, count: usize) -> [f64; 3] {
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

/// How many of the rays that strahl gets of a kind pass through every face of a target in a naive test of each.
pub fn leaks(target: &Target, kind: usize, inside: bool, count: usize, random: &mut Random) -> usize {
    let corners: Vec<_> = target.mesh.faces.iter().map(|face| face.map(|i| target.mesh.vertices[i])).collect();
    let narrow: Vec<_> = corners.iter().map(|face| face.map(|v| v.as_vec3())).collect();
    let rays = std::iter::from_fn(|| Some(target.ray(kind, inside, random))).flatten().take(count);
    let leaks = rays.filter(|ray| {
        let (o, d) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
        match target.precision {
            Precision::Single => !narrow.iter().any(|face| naive_single(o.as_vec3(), d.as_vec3(), *face, 0.0)),
            Precision::Double => !corners.iter().any(|face| naive_double(o, d, *face, 0.0)),
        }
    });
    leaks.count()
}
