//! X: the box as a body.

use super::Case;
use super::evidence::Evidence;
use super::hierarchies::cuboid;
use super::lab::{Lab, direction, finite, hit};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::json;

pub const CASES: &[Case] = &[("X01", corners), ("X02", thin), ("X03", inside)];

fn corners(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at corners, edges and faces");
    let (low, high) = (DVec3::new(-3.0, 1.0, 2.0), DVec3::new(5.0, 1.5, 2.125));
    let scene = lab.scene(json!([cuboid(low, high)]), json!({}));
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let mut random = Random::new(19);
    for _ in 0..6000 {
        // Each coordinate on a side or anywhere between them; one at least on a side.
        let mut k = DVec3::from_array(std::array::from_fn(|_| [-1.0, 1.0, random.between(-1.0, 1.0)][random.below(3)]));
        if k.abs().max_element() < 1.0 {
            k[random.below(3)] = 1.0;
        }
        let aim = lab.round3(middle + half * k);
        let on: Vec<usize> = (0..3).filter(|i| k[*i].abs() == 1.0).collect();
        // From outside towards a point within, through the aim; and from within.
        let within = middle + half * DVec3::from_array(random.point(0.9));
        let way = aim - within;
        for o in [lab.round3(within), lab.round3(aim + way * 2.0)] {
            let d = lab.round3(aim - o);
            let Some(found) = hit(&scene, o, d) else {
                e.check(false, || format!("missed {aim} from {o}"));
                continue;
            };
            let n = DVec3::from_array(found.normal);
            let adjacent = on.iter().any(|i| n[*i] == k[*i] && n.abs().max_element() == 1.0);
            e.check(adjacent && finite(&found), || format!("normal {n} at {aim}, sides {on:?}"));
            let largest = aim.abs().max_position();
            e.twin(!on.contains(&largest));
        }
    }
    e
}

fn thin(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at flat boxes");
    let mut random = Random::new(20);
    for axis in 0..3 {
        let (mut low, mut high) = (DVec3::splat(-1.0), DVec3::splat(1.0));
        (low[axis], high[axis]) = (lab.round(0.1), lab.round(0.1));
        let scene = lab.scene(json!([cuboid(low, high)]), json!({}));
        for _ in 0..400 {
            let mut aim = DVec3::from_array(random.point(0.99));
            aim[axis] = low[axis];
            let o = lab.round3(aim + direction(&mut random) * 3.0);
            let d = lab.round3(aim - o);
            if d[axis].abs() > 0.1 {
                e.check(hit(&scene, o, d).is_some_and(|h| finite(&h)), || format!("missed {aim} from {o}"));
                // With both faces at one t, `near < far` has no room.
                e.twin(naive::cuboid(lab, o, d, low, high, 0.0).is_none());
            }
        }
    }
    e
}

fn inside(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u of the way to the far wall");
    for scale in [1e-6, 1.0, 1e6] {
        let (low, high) = (DVec3::new(-1.0, -2.0, -3.0) * scale, DVec3::new(1.0, 2.0, 3.0) * scale);
        let (low, high) = (lab.round3(low), lab.round3(high));
        let scene = lab.scene(json!([cuboid(low, high)]), json!({}));
        let mut random = Random::new(21);
        for _ in 0..500 {
            let o = lab.round3(DVec3::from_array(random.point(0.99)) * scale);
            let d = lab.round3(direction(&mut random));
            let exits: Vec<f64> = (0..3).map(|i| (if d[i] > 0.0 { high[i] } else { low[i] } - o[i]) / d[i]).collect();
            let t = exits.iter().copied().fold(f64::INFINITY, f64::min);
            let found = hit(&scene, o, d);
            e.measure(found.as_ref().map_or(f64::INFINITY, |h| (h.t / t - 1.0).abs() / lab.u));
            e.check(found.is_some_and(|h| !h.entering), || "the far wall is entered".to_owned());
            let entry = (0..3)
                .map(|i| (if d[i] > 0.0 { low[i] } else { high[i] } - o[i]) / d[i])
                .fold(f64::NEG_INFINITY, f64::max);
            e.twin(entry < 0.0);
        }
    }
    e
}
