//! How far distances are from the exact ones, in u D / cos: strahl's, and those of naive code for the same rays.

use super::Random;
use super::bodies::Body;
use super::numbers::Numbers;
use super::wide::{Wide, Wide3};
use glam::DVec3;
use serde_json::json;
use strahl::inspect::first_hits::first_hits;
use strahl::inspect::query::RayQuery;
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};

/// D / r, from close by to where single precision barely sees the body.
pub const DISTANCES: [f64; 8] = [1.5, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

/// What the rays from one distance found.
#[derive(Default, Clone, Copy)]
pub struct Found {
    /// Largest error of a distance.
    pub worst: f64,
    /// How many hits were judged.
    pub judged: usize,
    /// Hits of lines that pass the body by, as far as rounding can tell.
    pub undecided: usize,
    /// Largest error of a naive distance.
    pub naive: f64,
    /// Hits that naive code does not see at all.
    pub naive_lost: usize,
}

impl Found {
    /// Both together.
    pub fn with(self, other: Self) -> Self {
        Self {
            worst: self.worst.max(other.worst),
            judged: self.judged + other.judged,
            undecided: self.undecided + other.undecided,
            naive: self.naive.max(other.naive),
            naive_lost: self.naive_lost + other.naive_lost,
        }
    }
}

/// Whether an error within the bound is larger than the body, so that hitting or missing says nothing.
pub fn beyond_decision(body: &Body, distance: f64, u: f64) -> bool {
    body.bound * u * distance > 1.0 / 16.0
}

fn scene_of(body: &Body, precision: Precision) -> Scene {
    let text = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "materials": { "m": { "diffuse": 0.5 } },
        "objects": [body.object]
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}

/// A root by Newton's method: where it is, its last step, and the cosine of incidence there.
fn newton(body: &Body, f: Wide3, d: DVec3, normal: DVec3, start: f64, steps: usize) -> (Wide, f64, f64) {
    let (mut t, mut step, mut cosine) = (Wide::of(start), f64::INFINITY, 0.0);
    for _ in 0..steps {
        let (value, gradient) = (body.surface)(f + Wide3::of(d).times(t), normal);
        let slope = gradient.dot(d);
        cosine = slope.abs() / (gradient.length() * d.length());
        step = value.value() / slope;
        t = t - Wide::of(step);
    }
    (t, step, cosine)
}

/// Rays onto a body from one distance.
pub fn errors(body: &Body, distance: f64, precision: Precision, count: usize, random: &mut Random) -> Found {
    let lab = Numbers::new(precision);
    let scene = scene_of(body, precision);
    let far = beyond_decision(body, distance, lab.u);
    let rays: Vec<RayQuery> = (0..count)
        .map(|_| {
            let origin = lab.round3(body.center + DVec3::from_array(random.point(1.0)).normalize() * distance);
            let target = body.center + DVec3::from_array(random.point(0.6));
            let direction = lab.round3((target - origin).normalize());
            RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None }
        })
        .collect();
    let mut found = Found::default();
    for (ray, hit) in rays.iter().zip(first_hits(&scene, &rays)) {
        let Some(hit) = hit else { continue };
        let (o, d) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
        let f = Wide3::of(o) - Wide3::of(body.center);
        let normal = DVec3::from_array(hit.normal);
        let reach = f.value().length();
        let settled = |step: f64| step.abs() <= 1e-3 * lab.u * reach;
        let (t, cosine) = if far {
            // The kernel's answer may be anywhere in the body, so the exact roots are sought from all over it, and the
            // one nearest to the answer counts. From before and behind a quadric Newton's method goes straight to the
            // first and the last.
            let middle = -f.value().dot(d) / d.length_squared();
            let starts = if body.bound > 8.0 { -8..=8 } else { -1..=1 };
            let last = f64::from(*starts.end());
            let roots = starts.map(|k| newton(body, f, d, normal, middle + 1.5 * f64::from(k) / last, 40));
            let root = roots.filter(|(_, step, cosine)| settled(*step) && step.abs() < 1e-9 && *cosine > 0.0);
            let off = |t: Wide| (t - Wide::of(hit.t)).value().abs();
            let nearest = root.min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
            // Tori and cones have parts that the exact line may pass by within its own rounding, so that its roots are
            // elsewhere: hitting such a part is no error of distance.
            let (value, gradient) = (body.surface)(f + Wide3::of(d).times(Wide::of(hit.t)), normal);
            let band = 8.0 * lab.u * reach;
            let passes_by = value.value().abs() <= band * gradient.length();
            let Some((t, _, cosine)) = nearest.filter(|(t, _, cosine)| !passes_by || off(*t) * cosine <= band) else {
                found.undecided += 1;
                continue;
            };
            (t, cosine)
        } else {
            // From the kernel's answer; where it does not settle, the ray grazes.
            let (t, step, cosine) = newton(body, f, d, normal, hit.t, 12);
            if !settled(step) || cosine * cosine < 64.0 * lab.u * reach {
                continue;
            }
            (t, cosine)
        };
        let error = |found: f64| (t - Wide::of(found)).value().abs() * d.length() * cosine / (lab.u * reach);
        found.judged += 1;
        found.worst = found.worst.max(error(hit.t));
        if let Some(naive) = &body.naive {
            match naive(&lab, o, d) {
                Some(t) => found.naive = found.naive.max(error(t)),
                None => found.naive_lost += 1,
            }
        }
    }
    found
}
