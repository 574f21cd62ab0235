//! Pictures of one size: the references first, then all settings once. A trade-off begins with very small pictures, and goes on
//! to larger ones as far as there is time for all of them, so what was measured last is complete.

use super::bench::TradeoffBench;
use super::progress::{Found, Off, Progress, Size};
use super::references::{Positions, Reach, References};
use super::{END, Part};
use crate::service::clock::milliseconds;
use std::time::Instant;
use strahl::film::Film;
use strahl::math::{log2, pow};
use strahl::metrics::{CodeErrors, Image8, code_errors};
use strahl::render::{Cancelled, Picture};
use strahl::trace::counts::RayCounts;
use strahl::tradeoff::sweep::Settings;

/// Pixels of the first pictures.
const FIRST_PIXELS: f64 = 576.0;
/// Most times as many pixels as in the pictures before, since time does not grow evenly.
const STEP: f64 = 16.0;
/// Fewer times as many pixels are not worth the time.
const LEAST_STEP: f64 = 1.3;
/// Share of the time left that is planned for.
const PLANNED: f64 = 0.8;
/// Shares of the time at which the first references end: the best, and about the last of those that come into question.
const FIRST_ENDS: [f64; 2] = [0.3, 0.5];
/// Share of the time for each of the first pictures, and at which they end.
const FIRST_PICTURE: f64 = 0.08;
const FIRST_ROUND: f64 = 0.75;
/// Rounds that are planned for.
const PLANNED_ROUNDS: f64 = 1.3;
/// How time grows as long as that was not seen.
const USUAL_GROWTH: f64 = 0.6;
/// A picture that takes this many times as long as planned is given up.
const LATE: f64 = 3.0;
/// Most pixels of pictures whose errors are told at once: comparing larger ones takes time from what is measured.
const TOLD_PIXELS: f64 = 65_536.0;

/// The first picture of a setting, and the times of all.
pub(super) struct MeasuredSetting {
    pub(super) codes: Image8,
    pub(super) rays: RayCounts,
    /// Whether edges had more samples than other pixels.
    refines: bool,
    pub(super) proved_codes: Option<u8>,
    pub(super) times: Vec<f64>,
}

/// What was measured in one size.
pub(super) struct MeasuredSize {
    pub(super) size: [u32; 2],
    pub(super) references: Option<References>,
    /// One for each setting; none for those that the time did not suffice for.
    pub(super) measured: Vec<Option<MeasuredSetting>>,
    /// The last picture.
    pub(super) film: Option<Film>,
    /// Time grows as this power of the number of pixels: below 1 where antialiasing takes most of it, since edges make up less of
    /// a larger picture.
    pub(super) growth: f64,
    /// Milliseconds of comparing two pictures.
    comparison_ms: f64,
    /// The size before, and the rays of the settings in it.
    before: Option<([u32; 2], Vec<Option<u64>>)>,
}

impl MeasuredSize {
    /// The largest that there is time for, with further rounds while there is time.
    pub(super) fn largest(bench: &mut TradeoffBench<'_>, all: &[Settings], part: &Part) -> Result<Self, Cancelled> {
        let mut level = Self::first(bench, all, part)?;
        let mut is_warm = false;
        let mut most = part.most_pixels;
        loop {
            let size = level.next(bench, part, most);
            let is_last = size == part.asked_size && size != level.size;
            if pixels(size) < LEAST_STEP * pixels(level.size) && !is_last {
                break;
            }
            match level.larger(bench, all, size)? {
                Some(larger) => (level, is_warm) = (larger, true),
                None => most = pixels(size) / 4.0,
            }
        }
        bench.resize(level.size);
        level.repeat(bench, all, part)?;
        if !is_warm {
            // The first pictures are the warm-up.
            for setting in level.measured.iter_mut().flatten().filter(|setting| setting.times.len() > 2) {
                setting.times.remove(0);
            }
        }
        Ok(level)
    }

    fn new(size: [u32; 2], references: Option<References>) -> Self {
        Self {
            size,
            references,
            measured: Vec::new(),
            film: None,
            growth: USUAL_GROWTH,
            comparison_ms: 0.0,
            before: None,
        }
    }

    fn time_comparison(&mut self, bench: &TradeoffBench<'_>) {
        if let Some(codes) = self.references.as_ref().and_then(References::first) {
            let begun = Instant::now();
            bench.compare(codes, codes);
            self.comparison_ms = milliseconds(begun);
        }
    }

    /// The very small pictures. The references are the best that there is time for.
    fn first(bench: &mut TradeoffBench<'_>, all: &[Settings], part: &Part) -> Result<Self, Cancelled> {
        let size = scaled(part.asked_size, FIRST_PIXELS);
        let mut level = Self::new(size, None);
        bench.resize(size);
        let positions = &part.positions;
        let reaches = Reach::all(part.asked, bench.proved_depth());
        for (i, reach) in reaches.iter().enumerate() {
            let end = FIRST_ENDS[0] + (FIRST_ENDS[1] - FIRST_ENDS[0]) * i as f64 / reaches.len() as f64;
            level.references = References::trace(bench, positions, *reach, f64::INFINITY, end)?;
            if level.references.is_some() {
                (bench.watch)(Progress::Reference(level.shown(bench)));
                break;
            }
        }
        for settings in all {
            let most_ms = 1e3 * FIRST_PICTURE * bench.seconds;
            let picture = bench.render_within(*settings, most_ms, FIRST_ROUND)?;
            level.add(bench, *settings, picture)?;
        }
        level.time_comparison(bench);
        let Some(references) = &level.references else { return Ok(level) };
        let known = references.positions();
        let reach = references.reach.finest(bench, (references.all_ms, level.round_ms()), FIRST_ROUND)?;
        // Only all of them together are better than those that are there.
        if let Some(better) = References::trace(bench, &known, reach, f64::INFINITY, FIRST_ROUND)?
            && better.positions() == known
        {
            level.references = Some(better);
        }
        Ok(level)
    }

    /// The same in a larger size. None if it takes much longer than planned.
    fn larger(
        &self,
        bench: &mut TradeoffBench<'_>,
        all: &[Settings],
        size: [u32; 2],
    ) -> Result<Option<Self>, Cancelled> {
        let times = pixels(size) / pixels(self.size);
        let slack_ms = bench.slack_ms();
        let late = |ms: f64| LATE * times * ms + slack_ms;
        bench.resize(size);
        let references = match &self.references {
            None => None,
            Some(known) => {
                let positions = known.positions();
                let traced = References::trace(bench, &positions, known.reach, late(known.all_ms), END)?;
                let Some(traced) = traced.filter(|traced| traced.positions() == positions) else { return Ok(None) };
                Some(traced)
            }
        };
        let mut level = Self::new(size, references);
        if level.references.is_some() {
            (bench.watch)(Progress::Reference(level.shown(bench)));
        }
        level.time_comparison(bench);
        let rays = self.measured.iter().map(|setting| setting.as_ref().map(|setting| setting.rays.total()));
        level.before = Some((self.size, rays.collect()));
        for (settings, before) in all.iter().zip(&self.measured) {
            let Some(before) = before else {
                level.measured.push(None);
                continue;
            };
            let picture = bench.render_within(*settings, late(before.ms()), END)?;
            if picture.is_none() {
                return Ok(None);
            }
            level.add(bench, *settings, picture)?;
        }
        level.growth = (log2(level.all_ms() / self.all_ms().max(1e-3)) / log2(times)).clamp(0.5, 1.0);
        Ok(Some(level))
    }

    fn add(
        &mut self,
        bench: &TradeoffBench<'_>,
        settings: Settings,
        picture: Option<Picture>,
    ) -> Result<(), Cancelled> {
        let Some(picture) = picture else {
            self.measured.push(None);
            return Ok(());
        };
        let codes = Image8::from(&picture.film);
        let proved_codes = bench.proved_codes(&picture, settings)?;
        let is_quick = pixels(self.size) <= TOLD_PIXELS;
        let error = self.reference(settings.positions()).filter(|_| is_quick).map(|reference| {
            let CodeErrors { error, identical, .. } = code_errors(reference, &codes);
            Off { max_codes: error.max, p999_codes: error.p999, identical }
        });
        (bench.watch)(Progress::Point(Box::new(Found {
            size: self.shown(bench),
            index: self.measured.len(),
            settings,
            time_ms: picture.trace_ms,
            rays: picture.rays.total(),
            proved_codes,
            error,
        })));
        let refines = picture.refined.pixels > 0;
        self.measured.push(Some(MeasuredSetting {
            codes,
            rays: picture.rays,
            refines,
            proved_codes,
            times: vec![picture.trace_ms],
        }));
        self.film = Some(picture.film);
        Ok(())
    }

    /// Its size, for those who look on.
    fn shown(&self, bench: &TradeoffBench<'_>) -> Size {
        let [width, height] = self.size;
        Size { part: bench.part, width, height }
    }

    /// The size that there is time for.
    fn next(&self, bench: &TradeoffBench<'_>, part: &Part, most: f64) -> [u32; 2] {
        let references = self.references.as_ref().map_or(0.0, |references| references.all_ms);
        let planned = references + PLANNED_ROUNDS * self.round_ms() + self.comparisons_ms(part);
        let times = (PLANNED * 1e3 * bench.seconds_left(END) / planned.max(1e-6)).max(0.0);
        // Growth was measured on other pictures, so it is only half believed.
        let times = pow(times, 2.0 / (1.0 + self.growth)).min(STEP);
        scaled(part.asked_size, (times * pixels(self.size)).min(most))
    }

    /// Milliseconds of all comparisons.
    fn comparisons_ms(&self, part: &Part) -> f64 {
        let count = self.measured.iter().flatten().count() + part.positions.len();
        count as f64 * part.comparisons * self.comparison_ms
    }

    /// Renders the settings again, round by round, as long as it leaves time for the comparisons.
    fn repeat(&mut self, bench: &mut TradeoffBench<'_>, all: &[Settings], part: &Part) -> Result<(), Cancelled> {
        let kept_ms = self.comparisons_ms(part);
        for _ in 1..part.rounds {
            for (settings, setting) in all.iter().zip(&mut self.measured) {
                let Some(setting) = setting else { continue };
                let longest = setting.times.iter().copied().fold(0.0, f64::max);
                if 1e3 * bench.seconds_left(END) < kept_ms + 1.2 * longest {
                    continue;
                }
                if let Some(picture) = bench.render_picture(*settings, END)? {
                    setting.times.push(picture.trace_ms);
                }
            }
        }
        Ok(())
    }

    /// Milliseconds of one round.
    fn round_ms(&self) -> f64 {
        self.measured.iter().flatten().map(MeasuredSetting::ms).sum()
    }

    /// Milliseconds of one round and of the references.
    fn all_ms(&self) -> f64 {
        self.round_ms() + self.references.as_ref().map_or(0.0, |references| references.all_ms)
    }

    /// How many times as many rays a setting takes in a larger picture, judged by the smaller one, or else by the share of edges.
    pub(super) fn more_rays(&self, index: usize, larger: f64) -> f64 {
        let growth = self.before.as_ref().and_then(|(size, rays)| {
            let (before, now) = (rays[index]?, self.measured[index].as_ref()?.rays.total());
            Some(log2(now as f64 / before as f64) / log2(pixels(self.size) / pixels(*size)))
        });
        let refines = self.measured[index].as_ref().is_some_and(|setting| setting.refines);
        pow(larger, growth.unwrap_or(if refines { self.growth } else { 1.0 }).clamp(0.5, 1.0))
    }

    /// The reference of some samples.
    pub(super) fn reference(&self, positions: Positions) -> Option<&Image8> {
        self.references.as_ref().and_then(|references| references.of(positions))
    }
}

impl MeasuredSetting {
    /// Milliseconds of the first picture.
    fn ms(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }
}

pub(super) fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

/// A size of the same shape with about `most` pixels, but no larger than it was.
fn scaled([width, height]: [u32; 2], most: f64) -> [u32; 2] {
    let factor = (most / pixels([width, height])).sqrt().min(1.0);
    [width, height].map(|side| ((f64::from(side) * factor).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_shape_and_never_grow() {
        assert_eq!(scaled([640, 400], 64_000.0), [320, 200]);
        assert_eq!(scaled([40, 30], 1e6), [40, 30]);
        assert_eq!(scaled([16_384, 1], 100.0), [1280, 1]);
    }
}
