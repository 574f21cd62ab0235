//! Rays that leave a surface: whether they meet it again, lose its far side or meet that somewhere else.

mod exact;
mod objects;
mod textbook;

pub use objects::{PLACES, PRIMITIVES};
pub use textbook::{NAIVE, Naive};

use super::Random;
use super::numbers::Numbers;
use glam::DVec3;
use objects::{object, scene_of};
use strahl::inspect::first_hits::{FirstHit, first_hits};
use strahl::inspect::query::RayQuery;
use strahl::scene::description::Precision;

fn unit(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from_array(random.point(1.0));
        if v.length_squared() <= 1.0 && v.length_squared() > 0.01 {
            return v.normalize();
        }
    }
}

/// A direction on the side of `normal`; one in four is grazing.
fn away(normal: DVec3, random: &mut Random) -> DVec3 {
    let v = unit(random);
    let v = if v.dot(normal) < 0.0 { -v } else { v };
    let flat = v - normal * v.dot(normal);
    let cosine = if random.below(4) == 0 {
        strahl::math::pow(10.0, random.between(-3.0, -1.0))
    } else {
        v.dot(normal).max(1e-3)
    };
    (flat.normalize_or(normal.any_orthonormal_vector()) + normal * cosine).normalize()
}

fn ray(origin: DVec3, direction: DVec3) -> RayQuery {
    RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None }
}

/// What went wrong with rays that leave the surface of one kind of body.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct Count {
    pub rays: usize,
    /// Rays away from a body that met it where they started.
    pub self_hits: usize,
    /// Rays that did not meet the far side they go to.
    pub lost: usize,
    /// Rays into a body that left it somewhere else than where they do.
    pub misplaced: usize,
    /// Largest error of an exit, of the one allowed, where the exact one is known.
    pub worst: f64,
    /// Naive rays off spheres.
    pub naive: [Naive; 3],
}

impl Count {
    pub fn wrong(&self) -> usize {
        self.self_hits + self.lost + self.misplaced
    }

    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.self_hits += other.self_hits;
        self.lost += other.lost;
        self.misplaced += other.misplaced;
        self.worst = self.worst.max(other.worst);
        self.naive.iter_mut().zip(&other.naive).for_each(|(sum, naive)| sum.add(naive));
    }
}

/// Sends `count` rays onto a body of size `r` that far away, and from where each hits one off and one into the body.
fn leave(name: &str, r: f64, place: f64, precision: Precision, count: usize, random: &mut Random) -> Count {
    let lab = Numbers::new(precision);
    let center = lab.round3(unit(random) * (place * r));
    let object = object(name, center, r);
    let scene = scene_of(&object, precision);
    let sheet = ["disc", "triangle", "plane"].contains(&name);

    let onto: Vec<RayQuery> = (0..count)
        .map(|_| {
            let origin = center + unit(random) * (3.0 * r);
            ray(origin, (center + unit(random) * (random.between(0.0, 0.9) * r) - origin).normalize())
        })
        .collect();
    let mut found = Count::default();
    let (mut hits, mut directions) = (Vec::new(), Vec::new());
    for (onto, hit) in onto.iter().zip(first_hits(&scene, &onto)) {
        let Some(hit) = hit else { continue };
        let direction = away(DVec3::from_array(hit.normal), random);
        if name == "sphere" {
            let [o, d] = [onto.origin, onto.direction].map(|v| lab.round3(v.into()));
            let naive = textbook::leave(&lab, (center, lab.round(r)), (o, d), lab.round3(direction));
            found.naive.iter_mut().zip(&naive).for_each(|(sum, naive)| sum.add(naive));
        }
        hits.push(hit);
        directions.push(direction);
    }
    let both = |inward: bool| -> Vec<RayQuery> {
        let start = |hit: &FirstHit| DVec3::from_array(if inward { hit.inside } else { hit.outside });
        hits.iter().zip(&directions).map(|(hit, d)| ray(start(hit), if inward { -*d } else { *d })).collect()
    };

    found.rays = hits.len();
    let outward = both(false);
    for ((hit, ray), again) in hits.iter().zip(&outward).zip(first_hits(&scene, &outward)) {
        let q = DVec3::from_array(hit.point) - center;
        if name == "torus" && !exact::outer(DVec3::from_array(hit.normal), q) {
            across_the_hole(&mut found, (center, r), (lab.u, ray), again.as_ref());
        } else {
            found.self_hits += usize::from(again.is_some());
        }
    }
    let inward = both(true);
    let exits = first_hits(&scene, &inward);
    if sheet {
        found.self_hits += exits.iter().flatten().count();
        return found;
    }
    for (ray, exit) in inward.iter().zip(&exits) {
        let Some(exit) = exit else {
            found.lost += 1;
            continue;
        };
        let (origin, direction) = (DVec3::from_array(ray.origin), lab.round3(ray.direction.into()));
        let cosine = direction.dot(DVec3::from_array(exit.normal));
        let off = (origin + direction * exit.t).distance(DVec3::from_array(exit.point));
        let bound = 128.0 * lab.u * (r + center.length()) / cosine.abs().max(1e-6);
        let mut wrong = cosine < 0.0 || off > bound;
        if let Some(exact) = exact::exit(name, &lab, (center, r), origin, direction) {
            // The numbers of the file are of double precision, whatever the kernel's.
            let written = 4.0 * f64::EPSILON * center.length();
            let allowed = (exact.allowed + written) / cosine.abs().min(exact.cosine).max(1e-6);
            let error = (exit.t - exact.t).abs() * direction.length() / allowed;
            found.worst = found.worst.max(error);
            wrong |= !(error <= 1.0);
        }
        found.misplaced += usize::from(wrong);
    }
    found
}

/// A ray off the inner half of a torus may meet the other side, but only from outside; where it clearly does, it must.
fn across_the_hole(found: &mut Count, (c, r): (DVec3, f64), (u, ray): (f64, &RayQuery), again: Option<&FirstHit>) {
    let (o, d) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
    match again {
        Some(hit) => {
            // A hit that only grazes may have any sign, as far as rounding can tell.
            let leaving = DVec3::from_array(hit.normal).dot(d);
            let grazing = (256.0 * u * (r + c.length()) / r).sqrt();
            let near = hit.t < 1e-3 * r;
            found.self_hits += usize::from(leaving > if near { 0.0 } else { grazing });
        }
        None => {
            let clearly = |k: i32| exact::outside_torus(c, r, o + d * (f64::from(k) * r / 32.0)) < -0.01 * r;
            found.lost += usize::from((0..64).any(clearly));
        }
    }
}

/// What goes wrong with `each` rays for each primitive and place, over sizes from 1e-6 to 1e6.
pub fn table(precision: Precision, each: usize) -> Vec<(&'static str, f64, Count)> {
    let mut random = Random::new(7);
    let mut rows = Vec::new();
    for name in PRIMITIVES {
        for place in PLACES {
            let mut sum = Count::default();
            for exponent in -6..=6 {
                let r = 10f64.powi(exponent) * random.between(0.5, 1.0);
                sum.add(&leave(name, r, place, precision, each, &mut random));
            }
            rows.push((name, place, sum));
        }
    }
    rows
}
