//! The problems found so far, and checks of single numbers.

use super::path::Path;
use crate::control;
use crate::scene::description::{Color, Vec3};
use crate::scene::limits::{self, Limit};
use crate::scene::problem::{Code, Problem, did_you_mean, name_too_long};
use std::fmt::Display;

/// Collects problems.
#[derive(Debug, Default)]
pub(super) struct Findings {
    pub(super) problems: Vec<Problem>,
    suggestions: usize,
}

/// Unknown names for which suggestions are looked for: each costs up to 10 ms.
const SUGGESTIONS: usize = 10;

impl Findings {
    pub(super) fn add(&mut self, at: Path<'_>, code: Code, detail: impl Into<String>) {
        if !self.full() {
            self.problems.push(Problem::new(at.pointer(), code, detail));
        }
    }

    /// Whether there is no use in looking for more.
    pub(super) fn full(&self) -> bool {
        self.problems.len() >= limits::PROBLEMS_FOUND || control::step(1)
    }

    /// Whether a name is not too long.
    pub(super) fn name(&mut self, at: Path<'_>, name: &str) -> bool {
        let too_long = name_too_long(name);
        let is_sound = too_long.is_none();
        too_long.into_iter().for_each(|detail| self.add(at, Code::Limit, detail));
        is_sound
    }

    /// What else a name that is not known may have been, for the first few of them.
    pub(super) fn suggestion<'n>(&mut self, name: &str, known: impl Iterator<Item = &'n String>) -> String {
        self.suggestions += 1;
        if self.suggestions > SUGGESTIONS { String::new() } else { did_you_mean(name, known.map(String::as_str)) }
    }

    /// Checks a number: `ok` is whether it lies in the range, and `range` says the range in words, for the problem.
    pub(super) fn number(&mut self, at: Path<'_>, x: f64, range: impl Display, ok: bool) {
        if !x.is_finite() {
            self.add(at, Code::OutOfRange, format!("must be a finite number, is {x}"));
        } else if !ok {
            self.add(at, Code::OutOfRange, format!("must be {range}, is {}", shown(x)));
        }
    }

    /// Checks a length: positive, and neither too small nor too large for single precision.
    pub(super) fn length(&mut self, at: Path<'_>, x: f64) {
        let (min, max) = (limits::SMALLEST_LENGTH, limits::MAGNITUDE);
        self.number(at, x, format_args!("a length between {min:e} and {max:e}"), (min..=max).contains(&x));
    }

    pub(super) fn point(&mut self, at: Path<'_>, p: &Vec3) -> bool {
        let before = self.problems.len();
        for (i, x) in p.iter().enumerate() {
            let max = limits::MAGNITUDE;
            self.number(at.index(i), *x, format_args!("between -{max:e} and {max:e}"), x.abs() <= max);
        }
        self.problems.len() == before
    }

    pub(super) fn direction(&mut self, at: Path<'_>, d: &Vec3) {
        if self.point(at, d) && d.iter().all(|x| x.abs() < limits::SMALLEST_LENGTH) {
            self.add(at, Code::Degenerate, "must not be the zero vector");
        }
    }

    pub(super) fn count(&mut self, at: Path<'_>, what: &str, count: u64, limit: Limit) {
        if count > limit.max {
            let detail = format!("{count} {what} are over the limit of {} ({})", limit.max, limit.name);
            self.add(at, Code::Limit, detail);
        }
    }

    /// Checks a color of light.
    pub(super) fn color(&mut self, at: Path<'_>, color: Color) {
        self.channels(at, color, limits::MAGNITUDE);
    }

    /// Checks a coefficient of a material.
    pub(super) fn coefficient(&mut self, at: Path<'_>, color: Color) {
        self.channels(at, color, limits::COEFFICIENT);
    }

    /// Checks a color of at most `max` in each channel.
    pub(super) fn color_to(&mut self, at: Path<'_>, color: Color, max: f64) {
        self.channels(at, color, max);
    }

    fn channels(&mut self, at: Path<'_>, color: Color, max: f64) {
        let words = format!("in each channel between 0 and {max:e}");
        if let Some(x) = color.0.to_array().into_iter().find(|x| !(0.0..=max).contains(x)) {
            self.number(at, x, &words, false);
        }
    }

    /// Checks color and intensity of a light, and their product.
    pub(super) fn light(&mut self, at: Path<'_>, color: Color, intensity: f64) {
        self.color(at.key("color"), color);
        let brightest = intensity * color.0.max_element().max(1.0);
        let words = format!("at least 0, and at most {:e} after multiplication with the color", limits::MAGNITUDE);
        self.number(at.key("intensity"), intensity, &words, (0.0..=limits::MAGNITUDE).contains(&brightest));
    }
}

/// A number in a message; huge and tiny ones have an exponent.
fn shown(x: f64) -> String {
    if x != 0.0 && !(1e-4..1e16).contains(&x.abs()) { format!("{x:e}") } else { x.to_string() }
}
