//! The scorecard's first table: cases, exact answers, leaks, self-hits, lost exits and the worst errors, of strahl, of
//! naive code for the same questions, and as others have published them.

use super::card::Card;
use super::truth::{Truth, sums};
use crate::common::Random;
use crate::common::bodies::bodies;
use crate::common::distances::{DISTANCES, Found, beyond_decision, errors};
use crate::common::floors::{KINDS, point_errors};
use crate::common::leaving::{Count, NAIVE, table};
use crate::common::numbers::Numbers;
use crate::common::watertight::{shoot, shoot_naively};
use serde_json::{Value, json};
use strahl::scene::description::Precision;

/// One row: strahl in single and double precision, naive code in both, and what others say.
pub struct Line {
    pub what: String,
    pub cells: [String; 4],
    /// Whether strahl did nothing wrong, in single and double precision.
    pub sound: [bool; 2],
    pub published: &'static str,
}

impl Line {
    pub fn json(&self) -> Value {
        let [a, b, c, d] = &self.cells;
        json!({ "what": self.what, "single": a, "double": b, "naive_single": c, "naive_double": d, "published": self.published })
    }
}

/// The table, and what is wrong with it.
pub struct Summary {
    pub lines: Vec<Line>,
    pub wrong: Vec<String>,
}

/// Where the last column comes from. None of it was measured here.
pub const SOURCES: &str = "Published: Embree's tutorials/verify/verify.cpp at 93040c7a; pbrt-v4 at 5f7a6068; Mitsuba 3, \
    pull request 1962; POV-Ray at d3b2ad17; Möller and Trumbore's test and the naive sphere as measured by an earlier, \
    independent program in C, single precision.";

const BOTH: [Precision; 2] = [Precision::Single, Precision::Double];

fn percent(part: usize, whole: usize) -> String {
    if part == 0 { format!("0 of {}", count(whole)) } else { format!("{:.2} %", 100.0 * part as f64 / whole as f64) }
}

/// A number with a comma at each thousand.
fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// Runs the other harnesses with about `rays` rays each.
pub fn summary(card: &Card, rays: usize) -> Summary {
    let mut summary = Summary { lines: Vec::new(), wrong: Vec::new() };
    summary.cases(card);
    summary.leaks(rays);
    summary.leaving(rays);
    summary.errors(rays);
    summary.points(rays);
    summary
}

impl Summary {
    fn add(&mut self, what: impl Into<String>, cells: [String; 4], sound: [bool; 2], published: &'static str) {
        self.lines.push(Line { what: what.into(), cells, sound, published });
    }

    fn check(&mut self, right: bool, what: &str) {
        if !right {
            self.wrong.push(what.to_owned());
        }
    }

    fn cases(&mut self, card: &Card) {
        let of = card.listed.len();
        let [a, b] = BOTH.map(|p| format!("{} of {of}", card.passed(p)));
        let [c, d] = BOTH.map(|p| format!("{} of {of}", card.naively_passed(p)));
        self.add("Hard cases survived", [a, b, c, d], BOTH.map(|p| card.passed(p) == of), "");
        let share = |of: fn(&Truth) -> [super::truth::Count; 2]| {
            sums(&card.truths, of).map(|count| format!("{} of {}", count.right, count.asked))
        };
        let [a, b] = share(|truth| truth.strahl);
        let [c, d] = share(|truth| truth.naive);
        let sound = sums(&card.truths, |truth| truth.strahl).map(|count| count.right == count.asked);
        self.add("Exact answers given, of those with one right answer", [a, b, c, d], sound, "");
    }

    fn leaks(&mut self, rays: usize) {
        let shots = BOTH.map(|p| shoot(p, rays / 2));
        let naive = BOTH.map(|p| shoot_naively(p, 5000));
        for shot in &shots {
            self.wrong.extend(shot.leaks.iter().cloned());
        }
        let sound = shots.each_ref().map(|shot| shot.leaked == 0);
        let [a, b] = shots.each_ref().map(|shot| percent(shot.leaked, 2 * shot.rays));
        let [c, d] = naive.map(|kinds| percent(kinds[0].0 + kinds[1].0, kinds[0].1 + kinds[1].1));
        self.check(naive.iter().all(|kinds| kinds[0].0 > 0 && kinds[1].0 > 0), "naive triangles do not leak");
        let published = "Möller and Trumbore 13.0 % at vertices, 11.2 % at edges; pbrt's Triangle.Watertight test is \
            switched off (#if 0)";
        self.add("Leaks, rays aimed at vertices and edges of closed meshes", [a, b, c, d], sound, published);
        let [a, b] = shots.each_ref().map(|shot| percent(shot.leaked, shot.rays));
        let [c, d] = naive.map(|kinds| percent(kinds[2].0, kinds[2].1));
        self.add("Leaks, random rays", [a, b, c, d], sound, "Embree's test passes up to 2e-5, and has only these");
    }

    fn leaving(&mut self, rays: usize) {
        let each = (rays / (2 * 10 * 3 * 13)).max(20);
        let sums = BOTH.map(|p| {
            table(p, each).iter().fold(Count::default(), |mut sum, (.., count)| {
                sum.add(count);
                sum
            })
        });
        for (precision, sum) in BOTH.iter().zip(&sums) {
            self.check(sum.wrong() == 0, &format!("{precision:?}: secondary rays go wrong: {sum:?}"));
            for (i, (way, ..)) in NAIVE.iter().enumerate() {
                self.check(sum.naive[i].lost > 0, &format!("{precision:?}: naive {way} loses no exit"));
            }
        }
        for (i, published) in
            [(1, "Mitsuba's epsilon was 1500 ulp"), (2, "POV-Ray's tolerance is 1e-3, whatever the scale")]
        {
            let way = NAIVE[i].0;
            let [a, b] = sums.map(|sum| percent(sum.self_hits, sum.rays));
            let [c, d] = sums.map(|sum| percent(sum.naive[i].self_hits, sum.naive[i].rays));
            self.add(
                format!("Secondary rays that meet what they leave; naive: spheres, {way}"),
                [a, b, c, d],
                sums.map(|sum| sum.wrong() == 0),
                published,
            );
        }
        for i in [1, 2] {
            let way = NAIVE[i].0;
            let [a, b] = sums.map(|sum| percent(sum.lost + sum.misplaced, sum.rays));
            let [c, d] = sums.map(|sum| percent(sum.naive[i].lost, sum.naive[i].rays));
            let published = if i == 1 { "pbrt's tests of secondary rays ask for self-hits only" } else { "" };
            self.add(
                format!("Secondary rays whose exit is lost or misplaced; naive: spheres, {way}"),
                [a, b, c, d],
                sums.map(|sum| sum.wrong() == 0),
                published,
            );
        }
    }

    fn errors(&mut self, rays: usize) {
        let mut random = Random::new(9);
        let bodies = bodies(&mut random);
        let each = (rays / (2 * bodies.len() * DISTANCES.len())).max(100);
        type Kind<'a> = (&'a str, &'a [&'a str], f64, &'static str);
        let kinds: [Kind<'_>; 3] = [
            ("spheres", &["sphere"], 6.0, "naive spheres from 1e4 r: 8.9e3, and 28 % wrong decisions"),
            ("cylinders, cones, planes, discs, boxes", &["cylinder", "frustum", "plane", "disc", "box"], 8.0, ""),
            ("tori", &["torus"], 16.0, ""),
        ];
        for (kind, names, bound, published) in kinds {
            // All hits; those from where hitting or missing says something; and those from 1e4 r, for naive code.
            let mut sums = [[Found::default(); 3]; 2];
            let mut reach = [0.0f64; 2];
            for body in bodies.iter().filter(|body| names.iter().any(|name| body.name.starts_with(name))) {
                for (i, precision) in BOTH.into_iter().enumerate() {
                    for distance in DISTANCES {
                        let found = errors(body, distance, precision, each, &mut random);
                        sums[i][0] = sums[i][0].with(found);
                        if !beyond_decision(body, distance, Numbers::new(precision).u) {
                            sums[i][1] = sums[i][1].with(found);
                            reach[i] = reach[i].max(distance);
                        }
                        if distance == 1e4 {
                            sums[i][2] = sums[i][2].with(found);
                        }
                    }
                }
            }
            let what = format!(
                "Worst error in u D / cos, {kind} up to {:.0e} r in single, {:.0e} r in double (bound {bound}); naive: from 1e4 r",
                reach[0], reach[1]
            );
            let sound = sums.map(|[all, ..]| all.worst <= bound && all.judged > 0);
            self.check(sound == [true; 2], &what);
            self.check(
                sums.iter().all(|[.., naive]| naive.naive > 30.0 * bound),
                &format!("naive code is as good: {what}"),
            );
            let [a, b] = sums.map(|[_, decided, _]| format!("{:.1}", decided.worst));
            let [c, d] = sums.map(|[.., naive]| {
                let lost = 100.0 * naive.naive_lost as f64 / naive.judged as f64;
                let lost = if lost > 0.0 { format!(", {lost:.0} % of hits lost") } else { String::new() };
                format!("{:.1e}{lost}", naive.naive)
            });
            self.add(what, [a, b, c, d], sound, published);
        }
    }

    fn points(&mut self, rays: usize) {
        let each = (rays / (4 * KINDS.len() * 4)).max(100);
        let [single, double] = BOTH.map(|precision| {
            let mut worst = [0.0f64; 2];
            for (kind, size) in KINDS.iter().flat_map(|kind| [1e5, 1e6].map(|size| (kind, size))) {
                for level in [true, false] {
                    let errors = point_errors(kind, size, level, precision, each);
                    worst = [worst[0].max(errors.worst), worst[1].max(errors.naive)];
                }
            }
            worst
        });
        let what = "Worst error of points on triangles, quads, polygons and meshes of size 1e5 and 1e6, up to 30 away, \
            in u (distance + 1) (bound 4 in single)";
        self.check(single[0] <= 4.0, what);
        self.check(single[1] > 1e3, "naive points on large triangles are as good");
        let cells = [single[0], double[0], single[1], double[1]].map(|error| format!("{error:.1e}"));
        self.add(what, cells, [single[0] <= 4.0, true], "");
    }
}
