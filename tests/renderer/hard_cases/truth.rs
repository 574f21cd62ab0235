//! The questions with exact answers, for strahl and for naive code: how many have one right answer, and who gives it.

use super::energy::naive_corridor;
use super::lab::Lab;
use super::textbook::{Object, Shape, Tracer, cameras};
use crate::common::naive;
use crate::common::questions::shapes::{matrix, turn};
use crate::common::questions::{self, FILES, Query, number, vector};
use glam::DVec3;
use serde_json::{Value, json};
use strahl::math::pow;
use strahl::scene::description::Precision;

/// How many questions were asked and answered rightly.
#[derive(Default, Clone, Copy)]
pub struct Count {
    pub asked: usize,
    pub right: usize,
}

impl Count {
    fn add(&mut self, right: bool) {
        self.asked += 1;
        self.right += usize::from(right);
    }

    fn json(self) -> Value {
        json!({ "asked": self.asked, "right": self.right })
    }
}

/// One file of questions; of each pair the first is single precision.
pub struct Truth {
    pub file: &'static str,
    pub queries: usize,
    pub strahl: [Count; 2],
    pub naive: [Count; 2],
    /// What strahl answered wrongly, also where either answer is right but nonsense is not.
    pub wrong: Vec<String>,
}

impl Truth {
    pub fn json(&self) -> Value {
        let both = |counts: [Count; 2]| json!({ "single": counts[0].json(), "double": counts[1].json() });
        json!({ "file": self.file, "queries": self.queries, "strahl": both(self.strahl), "naive": both(self.naive) })
    }
}

/// All files, in both precisions.
pub fn all() -> Vec<Truth> {
    FILES.iter().map(|file| of(file)).collect()
}

/// Sums over all files.
pub fn sums(truths: &[Truth], of: fn(&Truth) -> [Count; 2]) -> [Count; 2] {
    truths.iter().map(of).fold([Count::default(); 2], |sum, counts| {
        [0, 1].map(|i| Count { asked: sum[i].asked + counts[i].asked, right: sum[i].right + counts[i].right })
    })
}

fn of(file: &'static str) -> Truth {
    let rows = questions::queries(file);
    let (mut strahl, mut naive, mut wrong) = ([Count::default(); 2], [Count::default(); 2], Vec::new());
    for (i, precision) in [Precision::Single, Precision::Double].into_iter().enumerate() {
        let lab = Lab::new(precision);
        for (row, outcome) in rows.iter().zip(questions::ask(file, precision)) {
            if let Err(why) = &outcome.check {
                wrong.push(format!("{file}, {} in {}: {why}", outcome.name, lab.name()));
            }
            if outcome.forced {
                strahl[i].add(outcome.check.is_ok());
                let query = Query { data: row, precision, u: lab.u };
                naive[i].add(naively(file, &lab, &query));
            }
        }
    }
    Truth { file, queries: rows.len(), strahl, naive, wrong }
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// Whether naive code answers a question rightly, by the bounds that hold for strahl.
fn naively(file: &str, lab: &Lab, query: &Query<'_>) -> bool {
    let (row, expect) = (query.data, &query.data["expect"]);
    let (shape, input) = (&row["shape"], &row["in"]);
    let at = |value: &Value| if value.is_null() { DVec3::ZERO } else { vector(value) };
    let (o, d) = (at(&row["ray"]["o"]), at(&row["ray"]["d"]));
    // Decision and distance.
    let distance = |found: Option<f64>, tolerance: &dyn Fn() -> f64| match (found, expect["dist"].as_f64()) {
        (Some(t), Some(dist)) => expect["hit"] != false && near(t * d.length(), dist, tolerance()),
        (None, _) => expect["hit"] == false,
        (Some(_), None) => expect["hit"] != false,
    };
    match file {
        "sphere_far" | "sphere_grazing" | "sphere_origin_on_surface" | "camera_far" => {
            let (center, radius) = (vector(&shape["center"]), number(&shape["radius"]));
            // Seen from far away with a scene moved as a whole, the form that multiplies everything out is the usual one.
            let found = if file == "camera_far" {
                Some(naive::sphere_expanded(lab, o, d, center, radius)).filter(|t| *t > 0.0)
            } else {
                naive::sphere(lab, o, d, center, radius, 0.0)
            };
            if query.decision("") == Some(false) || found.is_none() {
                return found.is_some() == (query.decision("") == Some(true));
            }
            let off = found.map_or(f64::NAN, |t| (naive::point(lab, o, d, t) - center).length());
            distance(found, &|| query.tolerance("dist_abs"))
                && near(off, radius, query.tolerance("surface_residual_abs"))
        }
        "plane_far" | "plane_grazing" => {
            let normal = naive::normalize(lab, vector(&shape["normal_unnormalised"]));
            // A first `if t < 0 { miss }` lets through what is no number.
            let t = naive::plane(lab, o, d, vector(&shape["point"]), normal);
            distance((!(t < 0.0)).then_some(t), &|| query.tolerance("dist_abs"))
        }
        "disc_rim" => {
            let (center, normal) = (vector(&shape["center"]), vector(&shape["normal"]));
            let found = naive::disc(lab, o, d, center, normal, number(&shape["radius"]));
            match query.decision("") {
                Some(true) => found == expect["t"].as_f64(),
                _ => found.is_none(),
            }
        }
        "torus_quartic" => {
            let [o, d] = [o, d].map(|v| DVec3::new(v.x, v.z, v.y));
            let size = (number(&shape["major_R"]), number(&shape["minor_r"]));
            let reach = 2.0 * (o.length() + size.0 + size.1) / d.length();
            let found = naive::torus_roots(lab, o, d, size, reach, 0.0).first().copied();
            distance(found, &|| query.tolerance("dist_abs"))
        }
        "cylinder_parallel_axis" => {
            let radius = number(&shape["radius"]);
            let ends = ["zmin", "zmax"].map(|key| (DVec3::Z * number(&shape[key]), radius));
            let found = naive::frustum(lab, o, d, ends, shape["capped"] == true, 0.0);
            distance(found, &|| {
                let p = vector(&expect["point"]);
                let outward = if expect["part"] == "side" { p.with_z(0.0).normalize() } else { DVec3::Z };
                let size = number(&expect["dist"]) + o.length() + radius;
                8.0 * lab.u * size / outward.dot(d.normalize()).abs()
            })
        }
        "aabb_slab_nan" => {
            let (low, high) = (vector(&shape["lo"]), vector(&shape["hi"]));
            let met = naive::slab(lab, o, d, low, high, false);
            let enter = naive::cuboid(lab, o, d, low, high, f64::NEG_INFINITY);
            met == (expect["hit_closed_box"] == true) && (!met || enter == expect["t_enter"].as_f64())
        }
        "normalize_extreme" => {
            let off = naive::normalize(lab, vector(&input["v"])) - vector(&expect["unit"]);
            !off.is_nan() && off.abs().max_element() <= 3.0 * lab.u
        }
        "tri_degenerate" => triangles(lab, shape, o, d).is_none(),
        "tri_shared_edge" | "tri_vertex_fan" | "tri_tiny" => {
            distance(triangles(lab, shape, o, d), &|| query.tolerance("dist_abs"))
        }
        "instance_normals" => {
            let (matrix, normal) = (matrix(query), vector(&expect["normal_outward"]));
            let inverse = matrix.inverse();
            let local = inverse * (vector(&expect["point"]) - vector(&shape["translation"]));
            (naive::normalize(lab, matrix * local) - normal).abs().max_element() <= turn(query, inverse)
        }
        "glass_sphere_deviation" => {
            let ball = Shape::Sphere(vector(&shape["center"]), number(&shape["radius"]));
            let steps = Tracer::new(lab, vec![Object::glass(ball, number(&shape["n_inside"]))]).through(o, d, 9);
            let out = steps.last().map_or(DVec3::NAN, |last| last.direction - vector(&expect["exit_unit"]));
            steps.len() == 3 && out.abs().max_element() <= query.tolerance("exit_direction_abs")
        }
        "refract_slab" => {
            let low = DVec3::new(-256.0, -number(&input["thickness"]), -256.0);
            let plate = Object::glass(Shape::Cuboid(low, DVec3::new(256.0, 0.0, 256.0)), number(&input["n_slab"]));
            let d = vector(&input["d"]);
            let steps = Tracer::new(lab, vec![plate]).through(-d, d, 9);
            let expected = vector(&expect["exit_direction_unit_equals_entry"]);
            let out = steps.last().map_or(DVec3::NAN, |last| last.direction - expected);
            steps.len() == 3 && out.abs().max_element() <= query.tolerance("exit_direction_abs")
        }
        "refract_critical" => critical(lab, query),
        "fermat_plane" => fermat(lab, query),
        "fisheye_directions" => ["fov180", "fov360"].iter().all(|fov| {
            let (x, y) = (number(&input["ndc_x"]), number(&input["ndc_y"]));
            let degrees: f64 = fov[3..].parse().unwrap();
            let inside = lab.round(lab.round(x * x) + lab.round(y * y)) <= 1.0;
            if expect["inside_image_circle"] != true || !inside {
                return inside == (expect["inside_image_circle"] == true);
            }
            let d = cameras::fisheye(lab, degrees, x, y) * DVec3::new(1.0, 1.0, -1.0);
            let off = d - vector(&expect["unit_direction_right_up_forward"][fov]);
            !off.is_nan() && off.abs().max_element() <= 4.0 * lab.u * (1.0 + degrees.to_radians() / 2.0)
        }),
        "mirror_corridor" => naive_corridor(lab, row).into_iter().all(|(k, off)| off <= 8.0 * k * lab.u),
        "phong_exponent" => {
            let value = lab.round(pow(number(&input["r_dot_v"]), number(&input["exponent"])));
            let expected = number(&expect["value"]);
            let relative = number(&row["tol"]["rel_f32"]) * lab.u / (f64::from(f32::EPSILON) / 2.0);
            let least = 2.0 * lab.u * lab.pick(f64::from(f32::MIN_POSITIVE), 0.0);
            near(value, expected, relative * expected + least) && (0.0..=1.0).contains(&value)
        }
        other => panic!("nobody asks {other}"),
    }
}

fn triangles(lab: &Lab, shape: &Value, o: DVec3, d: DVec3) -> Option<f64> {
    let corners = |t: &Value| std::array::from_fn(|i| vector(&t[i]));
    let found = shape["tris"].as_array().unwrap().iter().filter_map(|t| naive::triangle(lab, o, d, corners(t), 0.0));
    found.map(|[t, ..]| t).min_by(f64::total_cmp)
}

fn critical(lab: &Lab, query: &Query<'_>) -> bool {
    let (input, expect) = (&query.data["in"], &query.data["expect"]);
    let d = vector(&input["d"]);
    let eta = lab.round(number(&input["n1_incident"]) / number(&input["n2_transmitted"]));
    let bent = naive::refract(lab, d, DVec3::Y, eta);
    let total = bent.is_nan();
    let (direction, reflectance) = if query.has_tolerance() {
        (query.tolerance("direction_abs"), query.tolerance("R_abs"))
    } else {
        (8.0 * lab.u, 8.0 * lab.u)
    };
    let share = if total { 1.0 } else { naive::reflectance(lab, d, DVec3::Y, eta) };
    let aside = |expected: &Value| (bent - vector(expected)).abs().max_element();
    query.decision("TIR_").is_none_or(|forced| forced == total)
        && (total || expect["refracted_unit"].is_null() || aside(&expect["refracted_unit"]) <= direction)
        && near(share, number(&expect["R_unpolarised"]), reflectance)
}

fn fermat(lab: &Lab, query: &Query<'_>) -> bool {
    let (input, expect) = (&query.data["in"], &query.data["expect"]);
    let (a, d) = (vector(&input["A"]), vector(&input["d"]));
    let (n1, n2) = (number(&input["n1"]), number(&input["n2"]));
    let point = naive::point(lab, a, d, naive::plane(lab, a, d, DVec3::ZERO, DVec3::Y));
    let bent = naive::refract(lab, d, DVec3::Y, lab.round(n1 / n2));
    let size = a.distance(vector(&expect["interface_point"])) * d.length() / d.y.abs();
    let t = naive::plane(lab, point, bent, DVec3::Y * number(&input["receiver_plane_y"]), DVec3::Y);
    let receiver = naive::point(lab, point, bent, t);
    let off = (receiver - vector(&expect["receiver_point"])).abs().max_element();
    off <= 64.0 * lab.u * (size + receiver.distance(point) / bent.y.abs())
}
