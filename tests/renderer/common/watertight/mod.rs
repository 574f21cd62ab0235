//! Rays aimed exactly at the vertices and edges of closed meshes, and at random, from both sides: none may pass.

mod exact;
mod naive;
mod target;

pub use naive::shares as naive_shares;
pub use target::KINDS;

use super::Random;
use strahl::scene::description::Precision;
use target::{Target, targets};

/// What came of some rays.
pub struct Shot {
    /// Rays of each kind.
    pub rays: usize,
    /// Where there were leaks, and how many of how many.
    pub leaks: Vec<String>,
    pub leaked: usize,
    /// Rays of all kinds that passed by the mesh or along its outline, as exact arithmetic confirms: rounding had moved
    /// where they were aimed.
    pub beside: usize,
}

/// Shoots about `count` rays of each kind in a precision; two threads share the targets.
pub fn shoot(precision: Precision, count: usize) -> Shot {
    let targets = targets(precision);
    let each = count.div_ceil(targets.len() * 2);
    let (first, second) = targets.split_at(targets.len() / 2);
    let shoot_at = |part: &[(String, Target)], seed: u64| {
        let mut random = Random::new(seed);
        let (mut found, mut leaked, mut beside) = (Vec::new(), 0, 0);
        for (name, target) in part {
            for (kind, what) in KINDS.iter().enumerate() {
                for (inside, side) in [(true, "inside"), (false, "outside")] {
                    let (leaks, passed_by) = target.leaks(kind, inside, each, &mut random);
                    beside += passed_by;
                    if leaks > 0 {
                        found.push(format!("{name}, {what} from {side}: {leaks} of {each}"));
                        leaked += leaks;
                    }
                }
            }
        }
        (found, leaked, beside)
    };
    let (mut leaks, leaked, beside) = std::thread::scope(|scope| {
        let other = scope.spawn(|| shoot_at(second, 2));
        let (mut found, leaked, beside) = shoot_at(first, 1);
        let (more, also, others) = other.join().unwrap();
        found.extend(more);
        (found, leaked + also, beside + others)
    });
    leaks.sort();
    Shot { rays: each * targets.len() * 2, leaks, leaked, beside }
}

/// How many of about `count` rays of each kind at the same targets leak through naive triangles, and how many there were.
pub fn shoot_naively(precision: Precision, count: usize) -> [(usize, usize); 3] {
    let targets = targets(precision);
    let each = count.div_ceil(targets.len() * 2);
    let mut random = Random::new(4);
    std::array::from_fn(|kind| {
        let mut leaked = 0;
        for (_, target) in &targets {
            leaked +=
                [true, false].map(|inside| naive::leaks(target, kind, inside, each, &mut random)).iter().sum::<usize>();
        }
        (leaked, each * targets.len() * 2)
    })
}
