//! What a case found: a figure against its bound, and how the naive code beside it did.

/// What one case found in one precision. It passes if nothing was wrong and the worst measurement is within the bound.
#[derive(Default)]
pub struct Evidence {
    tried: u64,
    wrong: u64,
    first: String,
    worst: f64,
    bound: Option<f64>,
    unit: &'static str,
    twin_tried: u64,
    twin_wrong: u64,
    twin_worst: f64,
    excuse: Option<&'static str>,
}

impl Evidence {
    /// Counts what is wrong of what was tried; none may be.
    pub fn counting(unit: &'static str) -> Self {
        Self { unit, ..Self::default() }
    }

    /// Measures; the largest value must not exceed the bound.
    pub fn measuring(bound: f64, unit: &'static str) -> Self {
        Self { bound: Some(bound), unit, ..Self::default() }
    }

    /// One thing that must be so.
    pub fn check(&mut self, right: bool, what: impl FnOnce() -> String) {
        self.tried += 1;
        if !right {
            self.wrong += 1;
            if self.first.is_empty() {
                self.first = what();
            }
        }
    }

    /// One measurement; NaN counts as infinite.
    pub fn measure(&mut self, value: f64) {
        self.tried += 1;
        self.worst = self.worst.max(if value.is_nan() { f64::INFINITY } else { value });
    }

    /// One try of the naive code.
    pub fn twin(&mut self, fails: bool) {
        self.twin_tried += 1;
        self.twin_wrong += u64::from(fails);
    }

    /// One measurement of the naive code.
    pub fn twin_measure(&mut self, value: f64) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        self.twin_worst = self.twin_worst.max(value);
        self.twin(value > self.bound.unwrap_or(0.0));
    }

    /// Why the naive code gets through here; it must.
    pub fn excuse(&mut self, when: bool, why: &'static str) {
        if when {
            self.excuse = Some(why);
        }
    }

    /// Whether strahl passes.
    pub fn passes(&self) -> bool {
        self.tried > 0 && self.wrong == 0 && self.worst <= self.bound.unwrap_or(0.0)
    }

    /// The worst measurement, or how many were wrong.
    pub fn figure(&self) -> f64 {
        if self.bound.is_some() && (self.wrong == 0 || self.worst > self.bound.unwrap_or(0.0)) {
            self.worst
        } else {
            self.wrong as f64
        }
    }

    /// The largest figure that passes.
    pub fn bound(&self) -> f64 {
        self.bound.unwrap_or(0.0)
    }

    /// What the figure counts, and of how many.
    pub fn unit(&self) -> String {
        match self.bound {
            Some(_) => self.unit.to_owned(),
            None => format!("of {} {}", self.tried, self.unit),
        }
    }

    /// The first thing that was wrong.
    pub fn why(&self) -> &str {
        &self.first
    }

    /// What became of the naive code, in words.
    pub fn twin_words(&self) -> String {
        let count = format!("{} of {} wrong", self.twin_wrong, self.twin_tried);
        let worst = if self.twin_worst > 0.0 { format!(", worst {:.3e}", self.twin_worst) } else { String::new() };
        match self.excuse {
            Some(why) => format!("survives: {why}"),
            None => format!("fails: {count}{worst}"),
        }
    }

    /// Whether naive code gets through.
    pub fn naively_passes(&self) -> bool {
        self.twin_tried > 0 && self.twin_wrong == 0
    }

    /// What is wrong with the naive column: the harness is blind, or explains what needs no explanation.
    pub fn blind(&self) -> Option<String> {
        match (self.twin_wrong, self.excuse) {
            (0, None) => Some(format!("the naive code fails in none of {} tries", self.twin_tried)),
            (wrong, Some(why)) if wrong > 0 => Some(format!("the naive code fails ({wrong}), in spite of: {why}")),
            _ => None,
        }
    }
}
