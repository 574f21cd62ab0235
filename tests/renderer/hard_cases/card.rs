//! The scorecard: printed, as JSON and as a page of its own.

use super::evidence::Evidence;
use super::page::page;
use super::summary::{Line, SOURCES, Summary};
use super::truth::Truth;
use crate::common::root;
use serde::Deserialize;
use serde_json::{Value, json};
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
    serde_json::from_slice(&std::fs::read(root().join("tests/renderer/hard_cases/cases.json")).unwrap()).unwrap()
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

    pub fn precision(&self) -> &'static str {
        if self.precision == Precision::Single { "single" } else { "double" }
    }

    pub fn verdict(&self) -> &'static str {
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

    pub fn figures(&self) -> (f64, f64, String, String) {
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

    pub fn passed(&self, precision: Precision) -> usize {
        self.rows.iter().filter(|row| row.precision == precision && row.passes()).count()
    }

    /// How many cases naive code gets through without a wrong answer.
    pub fn naively_passed(&self, precision: Precision) -> usize {
        let passes = |row: &&Row| row.evidence.as_ref().is_ok_and(Evidence::naively_passes);
        self.rows.iter().filter(|row| row.precision == precision).filter(passes).count()
    }

    /// To the terminal.
    pub fn print(&self, summary: &Summary) {
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
        println!("\n{:92} {:>17} {:>17} {:>24} {:>24}", "", "single", "double", "naive single", "naive double");
        for line in &summary.lines {
            let [a, b, c, d] = &line.cells;
            println!("{:92} {a:>17} {b:>17} {c:>24} {d:>24}  {}", line.what, line.published);
        }
        println!("{SOURCES}");
    }

    /// As `scorecard.json` and `index.html` in `target/hard-cases/`.
    pub fn write(&self, summary: &Summary) {
        let folder = root().join("target/hard-cases");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("scorecard.json"), format!("{:#}\n", self.json(summary))).unwrap();
        std::fs::write(folder.join("index.html"), page(self, summary)).unwrap();
    }

    fn json(&self, summary: &Summary) -> Value {
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
            "naively_survived": {
                "single": self.naively_passed(Precision::Single), "double": self.naively_passed(Precision::Double)
            },
            "summary": summary.lines.iter().map(Line::json).collect::<Vec<_>>(),
            "sources": SOURCES,
            "rows": rows,
            "ground_truth": self.truths.iter().map(Truth::json).collect::<Vec<_>>(),
        })
    }
}

/// A file's right answers of those asked: single, double, naive single, naive double.
pub fn truth_cells(truth: &Truth) -> [String; 4] {
    let [a, b] = truth.strahl;
    let [c, d] = truth.naive;
    [a, b, c, d].map(|count| format!("{}/{}", count.right, count.asked))
}
