//! Measures the settings that somebody would choose from, as requests for the picture asked for.

use super::Part;
use super::bench::TradeoffBench;
use super::level::{MeasuredSize, pixels};
use crate::service::clock::milliseconds;
use std::time::Instant;
use strahl::film::FileFormat;
use strahl::film::encode::encode;
use strahl::render::Cancelled;
use strahl::tradeoff::choices::{Choice, Choices, Measurement, settings};
use strahl::tradeoff::sweep::{Settings, Times};

/// Measures them in the time of the bench; loading the scene has taken `load_ms`.
pub(super) fn measure(bench: &mut TradeoffBench<'_>, asked: Settings, load_ms: f64) -> Result<Choices, Cancelled> {
    let asked_size = [bench.single.width, bench.single.height];
    let named = settings(asked, bench.proved_depth());
    let all: Vec<Settings> = named.iter().map(|(_, settings)| *settings).collect();
    let part = Part {
        asked,
        asked_size,
        most_pixels: 1_048_576.0,
        positions: vec![asked.positions()],
        rounds: 3,
        comparisons: 1.0,
    };
    let level = MeasuredSize::largest(bench, &all, &part)?;
    // The shortest is the one that other work has disturbed least.
    let times: Vec<Option<f64>> =
        level.measured.iter().map(|setting| Times::of(&setting.as_ref()?.times).map(|times| times.min_ms)).collect();

    let larger = pixels(asked_size) / pixels(level.size);
    let slower = slowdown(bench, &all, &times, (asked_size, &level))?;
    let mut encode_ms = 0.0;
    if let Some(film) = &level.film {
        let begun = Instant::now();
        bench.workers.work(|| encode(film, FileFormat::Png8))?;
        encode_ms = milliseconds(begun) * larger;
    }
    let mut choices = Vec::new();
    for (index, ((name, settings), setting)) in named.into_iter().zip(&level.measured).enumerate() {
        let reference = level.reference(asked.positions());
        let factor = slower * level.more_rays(index, larger);
        choices.push(Choice {
            name,
            settings,
            request_ms: times[index].map(|ms| load_ms + factor * ms + encode_ms),
            rays: setting.as_ref().map(|setting| setting.rays),
            difference: setting.as_ref().and_then(|setting| bench.compare(reference?, &setting.codes)),
            proved_codes: setting.as_ref().and_then(|setting| setting.proved_codes),
            picture: setting.as_ref().map(|setting| setting.codes.clone()),
        });
    }
    bench.resize(asked_size);
    let measured = Measurement {
        size: level.size,
        asked_size,
        load_ms,
        encode_ms,
        reference: level.references.as_ref().map(|references| references.report()),
        proved_depth: bench.proved_depth(),
        why_proved: bench.why().to_owned(),
        left_out: bench.left_out,
    };
    Ok(Choices::among(choices, measured))
}

/// How many times as long a ray takes in the picture asked for. If there is time, one picture is rendered to see it.
fn slowdown(
    bench: &mut TradeoffBench<'_>,
    all: &[Settings],
    times: &[Option<f64>],
    (asked_size, level): ([u32; 2], &MeasuredSize),
) -> Result<f64, Cancelled> {
    let known = times.iter().enumerate().filter_map(|(index, ms)| Some((index, (*ms)?)));
    let Some((index, ms)) = known.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| level.size != asked_size) else {
        return Ok(1.0);
    };
    let factor = level.more_rays(index, pixels(asked_size) / pixels(level.size));
    if 1.5 * factor * ms / 1e3 > bench.seconds_left(1.0) {
        return Ok(1.0);
    }
    bench.resize(asked_size);
    Ok(bench.render_picture(all[index], 1.0)?.map_or(1.0, |picture| picture.trace_ms / (factor * ms)))
}
