//! Cameras, long chains of rays, and Phong's power.

use super::optics::{hit_of, tree};
use super::*;
use strahl::camera::Basis;
use strahl::lanes::{Lanes, Mask, Real, V3};
use strahl::scene::compile::camera_of;
use strahl::scene::description;
use strahl::shading::phong::{highlight_cosine, power};

pub fn fisheye(query: &Query<'_>) -> Check {
    match query.precision {
        Precision::Single => fisheye_with::<f32>(query),
        Precision::Double => fisheye_with::<f64>(query),
    }
}

/// Whether the circle's border passes between points that only double tells apart.
pub fn between_numbers(query: &Query<'_>) -> bool {
    let input = &query.data["in"];
    let [Some(x), Some(y)] = ["ndc_x", "ndc_y"].map(|key| input[key].as_f64()) else { return false };
    let rounded = [0.5 + 0.5 * x, 0.5 - 0.5 * y].iter().any(|x| f64::from(*x as f32) != *x);
    x * x + y * y > 1.0 - 1e-6 && rounded
}

fn fisheye_with<L: Lanes<Simd = ()>>(query: &Query<'_>) -> Check {
    let input = &query.data["in"];
    // One pixel wide, so that the circle's radius is one half.
    let (x, y) = (0.5 + 0.5 * number(&input["ndc_x"]), 0.5 - 0.5 * number(&input["ndc_y"]));
    let narrow = |x: f64| L::Real::from_f64(x);
    if query.precision == Precision::Single && between_numbers(query) {
        return Ok(());
    }
    for fov in ["fov180", "fov360"] {
        let degrees: f64 = fov[3..].parse().unwrap();
        for kind in ["fisheye", "omnimax"] {
            let camera: description::Camera = serde_json::from_value(
                json!({ kind: { "eye": [0, 0, 0], "look_at": [0, 0, -1], "fov_deg": degrees } }),
            )
            .unwrap();
            let basis = Basis::new(&camera.view()).unwrap();
            let camera = camera_of::<L::Real>(&camera, &basis, 1, 1);
            let primary = camera.primary::<L>((), L::splat((), narrow(x)), L::splat((), narrow(y)));
            let inside = query.data["expect"]["inside_image_circle"] == true;
            if primary.seen.any() != inside {
                return Err(format!("{kind} {fov}: inside the circle: {}", primary.seen.any()));
            }
            if !inside {
                continue;
            }
            let d = DVec3::from_array(primary.dir.lane(0).map(Real::to_f64));
            let theta = degrees.to_radians() / 2.0;
            let expected = vector(&query.data["expect"]["unit_direction_right_up_forward"][fov]);
            near_vector(&format!("{kind} {fov}"), DVec3::new(d.x, d.y, -d.z), expected, 4.0 * query.u * (1.0 + theta))?;
            unit("the direction", query, d.to_array())?;
        }
    }
    Ok(())
}

pub fn corridor(query: &Query<'_>) -> Check {
    let (o, d) = (vector(&query.data["ray"]["o"]), vector(&query.data["ray"]["d"]));
    let mirrors = json!([
        { "plane": { "point": [0, 0, 0], "normal": [1, 0, 0], "material": "mirror" } },
        { "plane": { "point": [1, 0, 0], "normal": [-1, 0, 0], "material": "mirror" } }
    ]);
    let materials = json!({ "mirror": { "diffuse": 0, "reflection": 0.999 } });
    let rays = tree(query, o, d, mirrors, materials, json!({ "max_depth": 10_000, "min_weight": 0 }));
    if rays.len() != 10_000 {
        return Err(format!("{} rays", rays.len()));
    }
    let mut total = 0.0;
    let mut walk = rays.iter();
    let mut seen = 0;
    for expected in query.data["expect"]["hits"].as_array().unwrap() {
        let k = number(&expected["k"]);
        let mut last = None;
        while (seen as f64) < k {
            let node = walk.next().ok_or("the chain ends")?;
            total += node.hit.as_ref().ok_or(format!("ray {seen} leaves the corridor"))?.t;
            seen += 1;
            last = Some(node);
        }
        let Some(node) = last else { continue };
        let relative = 8.0 * k * query.u;
        near(&format!("way {k}"), total / number(&expected["dist_total"]), 1.0, relative)?;
        let (point, exact) = (hit_of(node)?, vector(&expected["hit_point"]));
        near(&format!("x of hit {k}"), point.x, exact.x, 4.0 * query.u)?;
        near_vector(&format!("hit {k}"), point, exact, relative * exact.length().max(1.0))?;
        let weight = number(&expected["weight_if_reflectance_0.999"]);
        near(&format!("weight {k}"), node.weight[0] * 0.999 / weight, 1.0, 2.0 * k * query.u)?;
    }
    Ok(())
}

pub fn phong(query: &Query<'_>) -> Check {
    match query.precision {
        Precision::Single => phong_with::<f32>(query),
        Precision::Double => phong_with::<f64>(query),
    }
}

/// Looking straight down onto a surface lit from straight above, along a vector whose length makes up the cosine.
fn phong_with<L: Lanes<Simd = ()>>(query: &Query<'_>) -> Check {
    let (cosine, exponent) = (number(&query.data["in"]["r_dot_v"]), number(&query.data["in"]["exponent"]));
    let narrow = |v: [f64; 3]| V3::<L>::splat((), v.map(L::Real::from_f64));
    let up = narrow([0.0, 1.0, 0.0]);
    let base = highlight_cosine((), up, up, narrow([0.0, cosine, 0.0]));
    let exponents = L::lit((), exponent);
    let value = power((), base, exponents, L::mask((), 1)).lane(0).to_f64();
    let expected = number(&query.data["expect"]["value"]);
    let relative = number(&query.data["tol"]["rel_f32"]) * query.u / (f64::from(f32::EPSILON) / 2.0);
    let smallest = if query.precision == Precision::Single { f64::from(f32::MIN_POSITIVE) } else { 0.0 };
    near("the power", value, expected, relative * expected + 2.0 * query.u * smallest)?;
    if (0.0..=1.0).contains(&value) { Ok(()) } else { Err(format!("{value} is beyond [0, 1]")) }
}
