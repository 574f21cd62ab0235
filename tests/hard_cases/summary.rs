//! The scorecard's first table: cases, exact answers, leaks, self-hits, lost exits and the worst errors, of strahl, of
//! naive code for the same questions, and as others have published them.

use crate::card::Card;
use crate::common::Random;
use crate::common::accuracy::{DISTANCES, Found, errors};
use crate::common::bodies::bodies;
use crate::common::leaving::{Count, NAIVE, table};
use crate::common::watertight::{shoot, shoot_naively};
use crate::truth::{Truth, sums};
use serde_json::{Value, json};
use strahl::scene::description::Precision;

/// One row: strahl in single and double precision, naive code in both, and what others say.
pub struct Line {
    pub what: String,
    pub cells: [String; 4],
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
    summary
}

impl Summary {
    fn add(&mut self, what: impl Into<String>, cells: [String; 4], published: &'static str) {
        self.lines.push(Line { what: what.into(), cells, published });
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
        self.add("Hard cases survived", [a, b, c, d], "");
        let share = |of: fn(&Truth) -> [crate::truth::Count; 2]| {
            sums(&card.truths, of).map(|count| format!("{} of {}", count.right, count.asked))
        };
        let [a, b] = share(|truth| truth.strahl);
        let [c, d] = share(|truth| truth.naive);
        self.add("Exact answers given, of those with one right answer", [a, b, c, d], "");
    }

    fn leaks(&mut self, rays: usize) {
        let shots = BOTH.map(|p| shoot(p, rays / 2));
        let naive = BOTH.map(|p| shoot_naively(p, 5000));
        for shot in &shots {
            self.wrong.extend(shot.leaks.iter().cloned());
        }
        let [a, b] = shots.each_ref().map(|shot| percent(shot.leaked, 2 * shot.rays));
        let [c, d] = naive.map(|kinds| percent(kinds[0].0 + kinds[1].0, kinds[0].1 + kinds[1].1));
        self.check(naive.iter().all(|kinds| kinds[0].0 > 0 && kinds[1].0 > 0), "naive triangles do not leak");
        let published = "Möller and Trumbore 13.0 % at vertices, 11.2 % at edges; pbrt's Triangle.Watertight test is \
            switched off (#if 0)";
        self.add("Leaks, rays aimed at vertices and edges of closed meshes", [a, b, c, d], published);
        let [a, b] = shots.each_ref().map(|shot| percent(shot.leaked, shot.rays));
        let [c, d] = naive.map(|kinds| percent(kinds[2].0, kinds[2].1));
        self.add("Leaks, random rays", [a, b, c, d], "Embree's test passes up to 2e-5, and has only these");
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
            let [a, b] = sums.map(|sum| percent(sum.self_hits, 2 * sum.rays));
            let [c, d] = sums.map(|sum| percent(sum.naive[i].self_hits, sum.naive[i].rays));
            self.add(format!("Self-hits of secondary rays; naive: spheres, {way}"), [a, b, c, d], published);
        }
        for i in [1, 2] {
            let way = NAIVE[i].0;
            let [a, b] = sums.map(|sum| percent(sum.lost + sum.misplaced, 2 * sum.rays));
            let [c, d] = sums.map(|sum| percent(sum.naive[i].lost, sum.naive[i].rays));
            let published = if i == 1 { "pbrt's tests of secondary rays ask for self-hits only" } else { "" };
            self.add(format!("Exits lost or misplaced; naive: spheres, {way}"), [a, b, c, d], published);
        }
    }

    fn errors(&mut self, rays: usize) {
        let mut random = Random::new(9);
        let bodies = bodies(&mut random);
        let each = (rays / (2 * bodies.len() * DISTANCES.len())).max(100);
        let of = |names: &[&str], at: &dyn Fn(f64) -> bool, precision: Precision, random: &mut Random| {
            let mut sum = Found::default();
            for body in bodies.iter().filter(|body| names.iter().any(|name| body.name.starts_with(name))) {
                for distance in DISTANCES.into_iter().filter(|d| at(*d)) {
                    sum = sum.with(errors(body, distance, precision, each, random));
                }
            }
            sum
        };
        let kinds: [(&[&str], f64, &str); 3] = [
            (&["sphere"], 6.0, "naive sphere 8.9e3, and 28 % wrong decisions"),
            (&["cylinder", "frustum", "plane", "disc", "box"], 8.0, ""),
            (&["torus"], 16.0, ""),
        ];
        for (names, bound, published) in kinds {
            let all = BOTH.map(|p| of(names, &|_| true, p, &mut random));
            let naive = BOTH.map(|p| of(names, &|d| d == 1e4, p, &mut random));
            let what = format!(
                "Worst error in u D / cos, {}, D from 1.5 r to 1e7 r, at most {bound}; naive: at 1e4 r",
                names.join(", ")
            );
            self.check(all.iter().all(|found| found.worst <= bound && found.judged > 0), &what);
            self.check(naive.iter().all(|found| found.naive > 30.0 * bound), &format!("naive code is as good: {what}"));
            let [a, b] = all.map(|found| format!("{:.1}", found.worst));
            let [c, d] = naive.map(|found| {
                let lost = 100.0 * found.naive_lost as f64 / found.judged as f64;
                format!(
                    "{:.1e}{}",
                    found.naive,
                    if lost > 0.0 { format!(", {lost:.0} % of hits lost") } else { String::new() }
                )
            });
            self.add(what, [a, b, c, d], published);
        }
    }
}
