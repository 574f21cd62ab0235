//! Rays that leave a surface neither meet it again nor miss its far side, whatever its size and place; naive rays do.
#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN must count as wrong")]

use crate::common::leaving::{Count, NAIVE, PLACES, PRIMITIVES, table};
use strahl::scene::description::Precision;

fn check(precision: Precision, each: usize) {
    let rows = table(precision, each);
    let mut sum = Count::default();
    for (name, place, count) in &rows {
        let Count { rays, self_hits, lost, misplaced, worst, .. } = count;
        let exits = if *worst > 0.0 { format!(", exits {worst:.2} of the error allowed") } else { String::new() };
        println!(
            "{precision:?}, {name} at {place} r: {rays} rays, {self_hits} self-hits, {lost} lost, {misplaced} misplaced{exits}"
        );
        sum.add(count);
    }
    let wrong: Vec<_> = rows.iter().filter(|(_, _, count)| count.wrong() > 0).collect();
    assert!(wrong.is_empty(), "{precision:?}: {wrong:#?}");

    for ((way, ..), naive) in NAIVE.into_iter().zip(sum.naive) {
        let [self_hits, lost] = [naive.self_hits, naive.lost].map(|n| n as f64 / naive.rays as f64);
        println!(
            "{precision:?}, naive {way}: {:.1} % of {} rays off spheres meet them, {:.1} % of exits are lost or misplaced",
            100.0 * self_hits,
            naive.rays,
            100.0 * lost
        );
        // A fixed length hides the noise of double precision, and loses what is smaller.
        let fails = match precision {
            Precision::Single => self_hits > 0.1 && lost > 0.3,
            Precision::Double => lost > 0.1 && (self_hits > 0.1 || way != "t > 0"),
        };
        assert!(fails, "naive {way} does not fail, so this harness is blind");
    }
}

#[test]
fn in_double_no_ray_meets_what_it_leaves_and_none_loses_its_exit() {
    check(Precision::Double, 3000);
}

#[test]
fn in_single_no_ray_meets_what_it_leaves_and_none_loses_its_exit() {
    check(Precision::Single, 3000);
}

#[test]
#[ignore = "10^8 rays take minutes"]
fn none_of_a_hundred_million_rays_meets_what_it_leaves() {
    let rays: usize = std::env::var("STRAHL_RAYS").map_or(100_000_000, |n| n.parse().unwrap());
    let each = rays / (2 * PRIMITIVES.len() * PLACES.len() * 13);
    check(Precision::Double, each);
    check(Precision::Single, each);
}
