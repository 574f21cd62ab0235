//! The plan as a readable table, at most 100 columns wide.

use super::Plan;
use super::explain::{Row, State};
use crate::bound::GIVEN_UP;
use std::fmt::Write;

const WIDTH: usize = 100;
/// Column in which reasons begin.
const REASON: usize = 52;

/// Primitives around one point that are worth a line.
const DENSE: f64 = 10_000.0;

impl Plan {
    /// The effects with their reasons, below them depth, estimates and warnings, and actual numbers if there are any.
    pub fn to_table(&self) -> String {
        let mut table = format!("{:<22}{:<8}{:>11}{:>9}  reason\n", "effect", "state", "est. rays", "ms");
        let (off, others): (Vec<&Row>, Vec<&Row>) =
            self.explanation.effects.iter().partition(|row| row.state == State::Off);
        for effect in others {
            let est = effect.est.filter(|est| est.rays > 0);
            let rays = est.map_or_else(String::new, |est| grouped(est.rays));
            let ms = est.and_then(|est| est.ms).map_or_else(String::new, |ms| format!("{ms:.1}"));
            let head = format!("{:<22}{:<8}{rays:>11}{ms:>9}  ", effect.effect, state(effect));
            let place = effect.because.first().map_or_else(String::new, |pointer| format!(" ({pointer})"));
            wrap(&mut table, &head, REASON, &format!("{}{place}", effect.reason));
        }
        let off: Vec<&str> = off.iter().map(|row| row.effect).collect();
        wrap(&mut table, &format!("{:<22}", "off"), 22, &off.join(", "));
        table.push('\n');
        self.add_whole(&mut table);
        self.add_actual(&mut table);
        table
    }

    fn add_whole(&self, table: &mut String) {
        let line = |table: &mut String, name: &str, text: &str| wrap(table, &format!("{name:<16}"), 16, text);
        line(
            table,
            "kernel",
            &format!("{} in {:?} precision", self.kernel.kernel, self.kernel.precision).to_lowercase(),
        );
        let depth = &self.depth;
        let requested = depth.requested.map_or_else(|| "none requested".to_owned(), |n| format!("{n} requested"));
        let known = match (depth.proved_sufficient, depth.reached) {
            (Some(n), _) => format!("{n} suffices: {}", depth.why),
            (None, Some(n)) => format!("{n} reached by the picture's rays"),
            (None, None) => depth.why.to_owned(),
        };
        line(table, "depth", &format!("{requested}, {known}"));
        if self.overlap > DENSE {
            line(table, "overlap", &format!("as many as {} primitives may lie around one point", self.overlap));
        }
        if let Some(est) = &self.estimate {
            let [low, high] = est.rays_ci.map(grouped);
            let at_least = if est.at_least { "at least " } else { "" };
            let (rays, ms, threads) = (grouped(est.rays), est.ms, est.threads);
            let text = format!("{at_least}{rays} rays ({low} to {high}), {ms:.1} ms on {threads} threads");
            line(table, "estimate", &text);
            let share = 100.0 * est.pilot_pixels as f64 / est.pixels as f64;
            let refined = if est.refined_pixels > 0 {
                format!("; antialiasing refines {}", grouped(est.refined_pixels))
            } else {
                String::new()
            };
            let text =
                format!("from {} of {} pixels ({share:.1} %){refined}", grouped(est.pilot_pixels), grouped(est.pixels));
            line(table, "", &text);
            let shared = "rays count for each effect that they serve: those of antialiasing are among all, of total \
                          reflection among the reflected ones";
            line(table, "", shared);
            if est.unproved_pixels > 0 {
                let pixels = grouped(est.unproved_pixels);
                line(table, "proof", &format!("given up in about {pixels} pixels: {GIVEN_UP}"));
            }
        }
        line(table, "explained in", &format!("{:.1} ms", self.explain_ms));
        for warning in &self.warnings {
            line(table, "warning", &warning.to_string());
        }
        line(table, "not simulated", &self.explanation.not_simulated.join(", "));
    }

    fn add_actual(&self, table: &mut String) {
        let measured = |effect: &&Row| {
            let counted = effect.act.is_some_and(|act| act.rays > 0 || act.saves_ms.is_some());
            counted || effect.est.is_some_and(|est| est.rays > 0)
        };
        let mut effects = self.explanation.effects.iter().filter(measured).peekable();
        if self.explanation.effects.iter().all(|effect| effect.act.is_none()) || effects.peek().is_none() {
            return;
        }
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "\n{:<21}{:>11}{:>25}{:>7}{:>12}{:>8}{:>8}{:>8}",
            "effect", "est. rays", "95 %", "ms", "actual rays", "off by", "share", "saves"
        );
        for effect in effects {
            let (Some(est), Some(act)) = (effect.est, effect.act) else { continue };
            let [low, high] = est.rays_ci.map(grouped);
            let saves = act.saves_ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.1}"));
            let off = match act.rays {
                0 => "-".to_owned(),
                rays => format!("{:.1} %", 100.0 * (est.rays as f64 / rays as f64 - 1.0)),
            };
            let _ = writeln!(
                table,
                "{:<21}{:>11}{:>25}{:>7.1}{:>12}{off:>8}{:>8.1}{saves:>8}",
                effect.effect,
                grouped(est.rays),
                format!("{low} to {high}"),
                est.ms.unwrap_or_default(),
                grouped(act.rays),
                act.share_ms.unwrap_or_default()
            );
        }
        table.push_str("share: ms that its own rays took; saves: ms that the picture would save without it\n");
    }
}

fn state(effect: &Row) -> &'static str {
    match effect.state {
        State::On => "on",
        State::Removed => "removed",
        State::Off => "off",
    }
}

/// Adds text in lines of at most [`WIDTH`] columns, the first after `head`, the others indented.
fn wrap(table: &mut String, head: &str, indent: usize, text: &str) {
    let mut line = head.to_owned();
    let mut fresh = true;
    for word in text.split(' ') {
        if !fresh && line.chars().count() + 1 + word.chars().count() > WIDTH {
            table.push_str(line.trim_end());
            table.push('\n');
            line = " ".repeat(indent);
            fresh = true;
        }
        if !fresh {
            line.push(' ');
        }
        line.push_str(word);
        fresh = false;
    }
    table.push_str(line.trim_end());
    table.push('\n');
}

/// A number with commas between thousands.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
