//! The questions with exact answers and what makes an answer right; `ground_truth.rs` and `hard_cases/` ask them.

mod optics;
pub mod shapes;
mod views;

use glam::DVec3;
use serde_json::{Value, json};
use std::cell::Cell;
use strahl::inspect::query::{RayHit, RayQuery};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};

thread_local! {
    /// Largest error since it was last taken, as a share of what was allowed.
    static WORST: Cell<f64> = const { Cell::new(0.0) };
}

/// One question.
pub struct Query<'a> {
    pub data: &'a Value,
    pub precision: Precision,
    /// Largest relative error of one rounding.
    pub u: f64,
}

/// Why an answer is wrong.
pub type Check = Result<(), String>;

/// What became of one question.
pub struct Outcome {
    /// The question's name in its file.
    pub name: String,
    /// Right, or why not.
    pub check: Check,
    /// Largest error of a right answer, as a share of what is allowed.
    pub worst: f64,
    /// Whether there is one right answer, and numbers of this format for it.
    pub forced: bool,
}

/// The queries of a file.
pub fn queries(file: &str) -> Vec<Value> {
    let path = format!("{}/tests/ground_truth/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let mut contents: Value = serde_json::from_str(&text).unwrap();
    match contents["queries"].take() {
        Value::Array(queries) => queries,
        other => panic!("{path}: {other}"),
    }
}

/// Asks all queries of a file in one precision.
pub fn ask(file: &str, precision: Precision) -> Vec<Outcome> {
    let u = if precision == Precision::Single { f64::from(f32::EPSILON) / 2.0 } else { f64::EPSILON / 2.0 };
    let check = check_of(file);
    let ask = |data: &Value| {
        WORST.set(0.0);
        let query = Query { data, precision, u };
        let check = check(&query);
        Outcome { name: data["name"].as_str().unwrap().to_owned(), check, worst: WORST.get(), forced: query.forced() }
    };
    queries(file).iter().map(ask).collect()
}

/// All files.
pub const FILES: [&str; 23] = [
    "sphere_far",
    "sphere_grazing",
    "sphere_origin_on_surface",
    "camera_far",
    "plane_far",
    "plane_grazing",
    "disc_rim",
    "torus_quartic",
    "cylinder_parallel_axis",
    "aabb_slab_nan",
    "normalize_extreme",
    "tri_degenerate",
    "tri_shared_edge",
    "tri_vertex_fan",
    "tri_tiny",
    "instance_normals",
    "glass_sphere_deviation",
    "refract_slab",
    "refract_critical",
    "fermat_plane",
    "fisheye_directions",
    "mirror_corridor",
    "phong_exponent",
];

fn check_of(file: &str) -> fn(&Query<'_>) -> Check {
    match file {
        "sphere_far" | "sphere_grazing" | "sphere_origin_on_surface" | "camera_far" => shapes::sphere,
        "plane_far" | "plane_grazing" => shapes::plane,
        "disc_rim" => shapes::disc,
        "torus_quartic" => shapes::torus,
        "cylinder_parallel_axis" => shapes::cylinder,
        "aabb_slab_nan" => shapes::cuboid,
        "normalize_extreme" => shapes::normalised,
        "tri_degenerate" => shapes::degenerate,
        "tri_shared_edge" | "tri_vertex_fan" | "tri_tiny" => shapes::triangles,
        "instance_normals" => shapes::instance,
        "glass_sphere_deviation" => optics::glass_sphere,
        "refract_slab" => optics::slab,
        "refract_critical" => optics::critical,
        "fermat_plane" => optics::fermat,
        "fisheye_directions" => views::fisheye,
        "mirror_corridor" => views::corridor,
        "phong_exponent" => views::phong,
        other => panic!("nobody asks {other}"),
    }
}

/// The question's scene: objects of one material `m`, without lights. `more` replaces keys.
fn scene(query: &Query<'_>, objects: Value, more: Value) -> Scene {
    let mut description = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "objects": objects
    });
    for (key, value) in more.as_object().unwrap() {
        description[key] = value.clone();
    }
    let overrides = Overrides { precision: Some(query.precision), ..Overrides::default() };
    load(description.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}

fn bare(query: &Query<'_>, object: Value) -> Scene {
    scene(query, json!([object]), json!({}))
}

impl Query<'_> {
    fn shape(&self, key: &str) -> &Value {
        &self.data["shape"][key]
    }

    pub fn tolerance(&self, what: &str) -> f64 {
        let format = if self.precision == Precision::Single { "f32" } else { "f64" };
        let key = format!("{what}_{format}");
        self.data["tol"][&key].as_f64().unwrap_or_else(|| panic!("no tolerance {key}"))
    }

    pub fn has_tolerance(&self) -> bool {
        self.data["tol"].is_object()
    }

    /// Whether hitting (or total reflection, or ...) is forced: the answer, or `None` for either.
    pub fn decision(&self, prefix: &str) -> Option<bool> {
        let format = if self.precision == Precision::Single { "f32" } else { "f64" };
        match &self.data["decision"][format!("{prefix}{format}")] {
            Value::String(word) if word == "either" => None,
            Value::String(word) => Some(word == "must_hit" || word == "true"),
            Value::Bool(yes) => Some(*yes),
            other => panic!("decision {other}"),
        }
    }

    /// Whether there is one right answer, and numbers of this format for it.
    pub fn forced(&self) -> bool {
        let (expect, input) = (&self.data["expect"], &self.data["in"]);
        let single = self.precision == Precision::Single;
        let decided = ["", "TIR_"].iter().all(|prefix| {
            let key = format!("{prefix}{}", if single { "f32" } else { "f64" });
            self.data["decision"][key] != "either"
        });
        // A ray along a face, a wall or a sliver may meet it or not.
        let along = expect["on_boundary_only"] == true
            || ["axis_parallel_on_wall", "pbrt_badcases"].iter().any(|name| self.data["name"] == *name);
        let fits = !single || expect["t"].as_f64().is_none_or(|t| (t as f32).is_finite());
        let directed = !input["v"].is_array() || vector(&input["v"]) != DVec3::ZERO;
        decided && !along && fits && directed && !(single && views::between_numbers(self))
    }

    fn ray(&self) -> RayQuery {
        let ray = &self.data["ray"];
        RayQuery { origin: vector(&ray["o"]).into(), direction: vector(&ray["d"]).into(), t_min: 0.0, t_max: None }
    }

    pub fn length(&self) -> f64 {
        vector(&self.data["ray"]["d"]).length()
    }
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

pub fn vector(value: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| number(&value[i])))
}

/// Whether `actual` is within `tolerance` of `expected`; never for NaN.
fn near(what: &str, actual: f64, expected: f64, tolerance: f64) -> Check {
    let off = (actual - expected).abs();
    if off <= tolerance {
        WORST.with(|worst| worst.set(worst.get().max(if off == 0.0 { 0.0 } else { off / tolerance })));
        return Ok(());
    }
    Err(format!("{what} is {actual:e}, exactly {expected:e}: off by {off:.3e}, allowed {tolerance:.3e}"))
}

fn near_vector(what: &str, actual: DVec3, expected: DVec3, tolerance: f64) -> Check {
    for i in 0..3 {
        near(&format!("{what}[{i}]"), actual[i], expected[i], tolerance)?;
    }
    Ok(())
}

fn unit(what: &str, query: &Query<'_>, v: [f64; 3]) -> Check {
    near(&format!("the length of {what}"), DVec3::from_array(v).length(), 1.0, 4.0 * query.u)
}

fn finite(hit: &RayHit) -> Check {
    let numbers = [hit.t, hit.reflectance].into_iter().chain(hit.point).chain(hit.normal).chain(hit.reflected);
    if numbers.chain(hit.transmitted.into_iter().flatten()).all(f64::is_finite) {
        Ok(())
    } else {
        Err(format!("not finite: {hit:?}"))
    }
}

fn must_hit(hit: Option<RayHit>) -> Result<RayHit, String> {
    let hit = hit.ok_or("missed")?;
    finite(&hit)?;
    Ok(hit)
}

fn must_miss(hit: Option<RayHit>) -> Check {
    hit.map_or(Ok(()), |hit| Err(format!("hit at t = {:e}", hit.t)))
}

fn distance(query: &Query<'_>, hit: &RayHit, tolerance: f64) -> Check {
    near("the distance", hit.t * query.length(), number(&query.data["expect"]["dist"]), tolerance)
}
