//! Bodies of size about 1 with their exact surfaces, and how naive code meets them.

use super::Random;
use super::naive;
use super::numbers::Numbers;
use super::wide::{Wide, Wide3};
use glam::DVec3;
use serde_json::{Value, json};

/// The function that is 0 on a surface, of a point relative to the centre and the normal there, and its gradient.
type Surface = Box<dyn Fn(Wide3, DVec3) -> (Wide, DVec3)>;

/// The naive first hit.
type Naive = Box<dyn Fn(&Numbers, DVec3, DVec3) -> Option<f64>>;

/// A body whose numbers are the same in both precisions.
pub struct Body {
    pub name: &'static str,
    /// Largest error of a distance, in u D / cos.
    pub bound: f64,
    pub object: Value,
    pub center: DVec3,
    pub surface: Surface,
    /// What textbooks do, where that differs from what strahl does.
    pub naive: Option<Naive>,
}

/// Cylinders and frustums: axis from the centre to the top, radii below and above.
struct Turned {
    axis: DVec3,
    radii: [f64; 2],
}

impl Turned {
    /// |q - b|^2 - h^2 - (r0 + k h)^2 times |a|^2 squared, where h = (q - b).a / |a|; or the plane of the cap.
    fn surface(&self) -> Surface {
        let (b, a, [r0, r1]) = (-self.axis, self.axis * 2.0, self.radii);
        Box::new(move |q, normal| {
            let along = normal.dot(a.normalize());
            if along.abs() > 0.99 {
                let end = if along > 0.0 { b + a } else { b };
                return ((q - Wide3::of(end)).dot(Wide3::of(a)), a);
            }
            let q = q - Wide3::of(b);
            let a3 = Wide3::of(a);
            let (aa, qa) = (a3.dot(a3), q.dot(a3));
            let r = Wide::of(r0) * aa + (Wide::of(r1) - Wide::of(r0)) * qa;
            let value = (q.dot(q) * aa - qa * qa) * aa - r * r;
            let (aa, qa, r) = (aa.value(), qa.value(), r.value());
            let gradient = (q.value() * aa - a * qa) * (2.0 * aa) - a * (2.0 * r * (r1 - r0));
            (value, gradient)
        })
    }

    fn body(self, name: &'static str, c: DVec3, closed: bool) -> Body {
        let (base, top, [r0, r1]) = (c - self.axis, c + self.axis, self.radii);
        let object = if r0 == r1 {
            json!({ "cylinder": { "base": base.to_array(), "top": top.to_array(), "radius": r0, "capped": closed, "material": "m" } })
        } else {
            json!({ "cone": { "base": base.to_array(), "base_radius": r0, "top": top.to_array(), "top_radius": r1,
                "capped": closed, "material": "m" } })
        };
        let ends = [(base, r0), (top, r1)];
        let naive: Naive = Box::new(move |lab, o, d| naive::frustum(lab, o, d, ends, closed, 0.0));
        Body { name, bound: 8.0, object, center: c, surface: self.surface(), naive: Some(naive) }
    }
}

/// All bodies, around a random centre.
pub fn bodies(random: &mut Random) -> Vec<Body> {
    let c = DVec3::from_array(random.point(10.0)).as_vec3().as_dvec3();
    // To 2^-20, so that a place on an axis with short digits is exact in both precisions.
    let c = (c * 1_048_576.0).round() / 1_048_576.0;
    let axis = DVec3::new(0.5, -0.375, 0.25);
    let turned = |r0: f64, r1: f64| Turned { axis, radii: [r0, r1] };
    let mut bodies = vec![
        turned(0.75, 0.75).body("cylinder, open", c, false),
        turned(0.75, 0.75).body("cylinder, closed", c, true),
        turned(0.875, 0.25).body("frustum, open", c, false),
        turned(0.875, 0.25).body("frustum, closed", c, true),
    ];
    bodies.extend(others(c));
    bodies
}

fn others(c: DVec3) -> Vec<Body> {
    let center = c.to_array();
    let (low, high) = (c - DVec3::new(1.0, 0.75, 0.5), c + DVec3::new(1.0, 0.75, 0.5));
    let body = |name, bound, object, surface, naive| Body { name, bound, object, center: c, surface, naive };
    vec![
        body(
            "sphere",
            6.0,
            json!({ "sphere": { "center": center, "radius": 1, "material": "m" } }),
            Box::new(|q, _| (q.dot(q) - Wide::of(1.0), q.value() * 2.0)),
            Some(Box::new(move |lab, o, d| naive::sphere(lab, o, d, c, 1.0, 0.0))),
        ),
        body(
            "plane",
            8.0,
            json!({ "plane": { "point": center, "normal": [0, 1, 0], "material": "m" } }),
            Box::new(|q, _| (q.0[1], DVec3::Y)),
            None,
        ),
        body(
            "disc",
            8.0,
            json!({ "disc": { "center": center, "normal": [0, 0, 1], "radius": 1, "material": "m" } }),
            Box::new(|q, _| (q.0[2], DVec3::Z)),
            None,
        ),
        body(
            "box",
            8.0,
            json!({ "box": { "min": low.to_array(), "max": high.to_array(), "material": "m" } }),
            Box::new(move |q, normal| {
                let face = if normal.element_sum() < 0.0 { low - c } else { high - c };
                let n = Wide3::of(normal);
                ((q - Wide3::of(face)).dot(n), normal)
            }),
            None,
        ),
        body(
            "torus",
            16.0,
            json!({ "torus": { "center": center, "axis": [0, 0, 1], "major_radius": 0.75, "minor_radius": 0.25, "material": "m" } }),
            Box::new(|q, _| {
                let (big, small) = (0.75, 0.25);
                let across = q.0[0] * q.0[0] + q.0[1] * q.0[1];
                let k = q.dot(q) + Wide::of(big * big - small * small);
                let p = q.value();
                let flat = DVec3::new(p.x, p.y, 0.0);
                (k * k - across * Wide::of(4.0 * big * big), p * (4.0 * k.value()) - flat * (8.0 * big * big))
            }),
            Some(Box::new(move |lab, o, d| {
                let swap = |v: DVec3| DVec3::new(v.x, v.z, v.y);
                let o = lab.round3(o - c);
                naive::torus_roots(lab, swap(o), swap(d), (0.75, 0.25), o.length() + 2.0, 0.0).first().copied()
            })),
        ),
    ]
}
