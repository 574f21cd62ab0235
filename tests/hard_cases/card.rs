//! The scorecard: printed, as JSON and as a page of its own.

use crate::common::root;
use crate::evidence::Evidence;
use crate::truth::{self, Count, Truth};
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::Write;
use strahl::scene::description::Precision;

/// A case as `cases.json` lists it.
#[derive(Deserialize)]
pub struct Listed {
    pub id: String,
    pub what: String,
    pub naive_failure: String,
    pub expected: String,
}

/// All listed cases.
pub fn listed() -> Vec<Listed> {
    serde_json::from_slice(&std::fs::read(root().join("tests/hard_cases/cases.json")).unwrap()).unwrap()
}

/// One case in one precision.
pub struct Row {
    pub id: &'static str,
    pub precision: Precision,
    /// What it found, or the panic that ended it.
    pub evidence: std::thread::Result<Evidence>,
    /// Why it is known to fail.
    pub gap: Option<&'static str>,
    pub seconds: f64,
}

impl Row {
    fn passes(&self) -> bool {
        self.evidence.as_ref().is_ok_and(Evidence::passes)
    }

    fn precision(&self) -> &'static str {
        if self.precision == Precision::Single { "single" } else { "double" }
    }

    fn verdict(&self) -> &'static str {
        match (self.passes(), self.gap) {
            (true, _) => "pass",
            (false, Some(_)) => "gap",
            (false, None) => "FAIL",
        }
    }

    fn why(&self) -> String {
        match &self.evidence {
            Ok(evidence) => evidence.why().to_owned(),
            Err(panic) => {
                let said = panic.downcast_ref::<String>().cloned();
                said.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or("a panic".to_owned())
            }
        }
    }

    fn figures(&self) -> (f64, f64, String, String) {
        match &self.evidence {
            Ok(e) => (e.figure(), e.bound(), e.unit(), e.twin_words()),
            Err(_) => (f64::INFINITY, 0.0, "panic".to_owned(), String::new()),
        }
    }
}

/// All rows.
pub struct Card {
    pub listed: Vec<Listed>,
    pub rows: Vec<Row>,
    pub truths: Vec<Truth>,
}

impl Card {
    /// What the test must fail for.
    pub fn wrong(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        for row in &self.rows {
            let name = format!("{} in {}", row.id, row.precision());
            match (row.passes(), row.gap) {
                (false, None) => {
                    let (figure, bound, unit, _) = row.figures();
                    wrong.push(format!("{name}: {figure:.4e} against {bound} {unit}; {}", row.why()));
                }
                (true, Some(_)) => wrong.push(format!("{name} passes now: it is no known gap")),
                _ => {}
            }
            if let Some(blind) = row.evidence.as_ref().ok().and_then(Evidence::blind) {
                wrong.push(format!("{name}: {blind}"));
            }
        }
        for truth in &self.truths {
            wrong.extend(truth.wrong.iter().cloned());
        }
        // What naive code in single precision is known to get wrong of these files.
        for (file, least) in [("sphere_far", 8), ("tri_shared_edge", 16), ("tri_vertex_fan", 16)] {
            let count = self.truths.iter().find(|truth| truth.file == file).map(|truth| truth.naive[0]);
            let failed = count.map_or(0, |count| count.asked - count.right);
            if failed < least {
                wrong.push(format!("naive code fails {failed} questions of {file} instead of {least} or more"));
            }
        }
        wrong
    }

    fn passed(&self, precision: Precision) -> usize {
        self.rows.iter().filter(|row| row.precision == precision && row.passes()).count()
    }

    fn twins(&self, precision: Precision) -> usize {
        let fails = |row: &&Row| row.evidence.as_ref().is_ok_and(|e| e.twin_words().starts_with("fails"));
        self.rows.iter().filter(|row| row.precision == precision).filter(fails).count()
    }

    fn summary(&self) -> String {
        let of = self.listed.len();
        let [single, double] = [Precision::Single, Precision::Double].map(|p| (self.passed(p), self.twins(p)));
        format!(
            "{} of {of} cases survived in single and {} in double precision; naive code beside them was run and fails {} and {}",
            single.0, double.0, single.1, double.1
        )
    }

    /// To the terminal.
    pub fn print(&self) {
        for row in &self.rows {
            let (figure, bound, unit, naive) = row.figures();
            println!(
                "{:4} {:6} {:4} {figure:>11.4e} <= {bound:<6} {unit:44} naive {naive}  [{:.1} s]",
                row.id,
                row.precision(),
                row.verdict(),
                row.seconds
            );
        }
        println!("\nExact answers: right of those asked where the format has one right answer");
        println!(
            "{:26} {:>7} {:>9} {:>9} {:>13} {:>13}",
            "", "queries", "single", "double", "naive single", "naive double"
        );
        for truth in &self.truths {
            let [a, b, c, d] = truth_cells(truth);
            println!("{:26} {:>7} {a:>9} {b:>9} {c:>13} {d:>13}", truth.file, truth.queries);
        }
        println!("\n{}", self.summary());
    }

    /// As `scorecard.json` and `index.html` in `target/hard-cases/`.
    pub fn write(&self) {
        let folder = root().join("target/hard-cases");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("scorecard.json"), format!("{:#}\n", self.json())).unwrap();
        std::fs::write(folder.join("index.html"), self.page()).unwrap();
    }

    fn json(&self) -> Value {
        let rows: Vec<Value> = self
            .rows
            .iter()
            .map(|row| {
                let (figure, bound, unit, naive) = row.figures();
                json!({
                    "case": row.id, "precision": row.precision(), "verdict": row.verdict().to_lowercase(),
                    "figure": figure.is_finite().then_some(figure), "bound": bound, "unit": unit, "naive": naive,
                    "gap": row.gap,
                })
            })
            .collect();
        json!({
            "cases": self.listed.len(),
            "survived": { "single": self.passed(Precision::Single), "double": self.passed(Precision::Double) },
            "naive_fails": { "single": self.twins(Precision::Single), "double": self.twins(Precision::Double) },
            "rows": rows,
            "ground_truth": self.truths.iter().map(Truth::json).collect::<Vec<_>>(),
        })
    }

    fn page(&self) -> String {
        let mut page = format!("{HEAD}<h1>Hard cases</h1><p>{}.</p>{TABLE}", escape(&self.summary()));
        for case in &self.listed {
            let rows: Vec<&Row> = self.rows.iter().filter(|row| row.id == case.id).collect();
            for (i, row) in rows.iter().enumerate() {
                let (figure, bound, unit, naive) = row.figures();
                let about = if i == 0 {
                    format!(
                        "<th rowspan={span}>{}<td rowspan={span}>{}<br><small>expected: {}<br>naive code: {}</small>",
                        case.id,
                        escape(&case.what),
                        escape(&case.expected),
                        escape(&case.naive_failure),
                        span = rows.len()
                    )
                } else {
                    String::new()
                };
                let verdict = row.verdict();
                let (precision, gap) = (row.precision(), escape(row.gap.unwrap_or("")));
                let (unit, naive) = (escape(&unit), escape(&naive));
                writeln!(
                    page,
                    "<tr>{about}<td>{precision}<td class={verdict}>{verdict}<td>{figure:.3e}<td>{bound}<td>{unit}<td>{naive}<td>{gap}"
                )
                .unwrap();
            }
        }
        page + "</table>\n"
    }
}

/// A file's right answers of those asked: single, double, naive single, naive double.
fn truth_cells(truth: &Truth) -> [String; 4] {
    let [a, b] = truth.strahl;
    let [c, d] = truth.naive;
    [a, b, c, d].map(|count| format!("{}/{}", count.right, count.asked))
}

const HEAD: &str = "<!doctype html><html lang=en><meta charset=utf-8><title>Hard cases</title><style>
body{font:14px/1.4 system-ui;margin:2em}table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2em .5em;
vertical-align:top;text-align:left}.pass{background:#cfc}.gap{background:#fe9}.FAIL{background:#f99}small{color:#555}
</style>";
const TABLE: &str =
    "<table><tr><th>case<th>what<th>precision<th>verdict<th>figure<th>bound<th>unit<th>naive code<th>gap\n";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
