//! How far distances are from the exact ones, in units of u D / cos, from near and far, in both precisions.

use crate::common::Random;
use crate::common::bodies::bodies;
use crate::common::distances::{DISTANCES, Found, beyond_decision, errors};
use crate::common::numbers::Numbers;
use strahl::scene::description::Precision;

fn check(precision: Precision) {
    let mut random = Random::new(5);
    let u = Numbers::new(precision).u;
    let mut wrong = Vec::new();
    let mut sums = vec![[Found::default(); DISTANCES.len()]; bodies(&mut random).len()];
    for _ in 0..4 {
        for (body, sums) in bodies(&mut random).iter().zip(&mut sums) {
            for (distance, sum) in DISTANCES.into_iter().zip(sums) {
                let found = errors(body, distance, precision, 2500, &mut random);
                if found.worst > body.bound {
                    wrong.push(format!("{} from {distance:e}: {:.1} u D / cos", body.name, found.worst));
                }
                *sum = sum.with(found);
            }
        }
    }
    for (body, sums) in bodies(&mut random).iter().zip(&sums) {
        println!("{precision:?}, {}: at most {} u D / cos", body.name, body.bound);
        for (distance, sum) in DISTANCES.into_iter().zip(sums) {
            let far = if beyond_decision(body, distance, u) {
                format!(
                    "; errors within the bound are as large as the body: only hits are judged ({} graze)",
                    sum.undecided
                )
            } else {
                String::new()
            };
            let naive = body
                .naive
                .as_ref()
                .map_or(String::new(), |_| format!("; naive code {:.1e} and {} hits lost", sum.naive, sum.naive_lost));
            println!("    D/r {distance:>6.0e}: {:>4.1} in {:>5} hits{naive}{far}", sum.worst, sum.judged);
            if sum.judged == 0 {
                wrong.push(format!("{} from {distance:e}: no hit was judged", body.name));
            }
            // Naive code loses a digit for each that the distance gains.
            let quadric = ["sphere", "cylinder"].iter().any(|name| body.name.starts_with(name));
            if quadric && distance >= 1e3 && !beyond_decision(body, distance, u) && sum.naive < 30.0 * body.bound {
                wrong.push(format!("{} from {distance:e}: naive code errs by {:.1} only", body.name, sum.naive));
            }
        }
    }
    assert!(wrong.is_empty(), "{precision:?}: {wrong:#?}");
}

#[test]
fn distances_in_single_are_off_by_a_few_roundings() {
    check(Precision::Single);
}

#[test]
fn distances_in_double_are_off_by_a_few_roundings() {
    check(Precision::Double);
}
