//! Measures the settings that somebody would choose from, as requests for the picture asked for.

use super::Part;
use super::level::{Level, pixels};
use super::stage::Stage;
use crate::service::clock::milliseconds;
use std::time::Instant;
use strahl::film::FileFormat;
use strahl::film::encode::encode;
use strahl::render::Cancelled;
use strahl::tradeoff::choices::{Choice, Choices, Measurement, settings};
use strahl::tradeoff::sweep::{Settings, Times};

/// Measures them in the time of the stage; loading the scene has taken `load_ms`.
pub(super) fn measure(stage: &mut Stage<'_>, asked: Settings, load_ms: f64) -> Result<Choices, Cancelled> {
    let asked_size = [stage.single.width, stage.single.height];
    let named = settings(asked, stage.proved_depth());
    let all: Vec<Settings> = named.iter().map(|(_, settings)| *settings).collect();
    let part = Part {
        asked,
        asked_size,
        most_pixels: 1_048_576.0,
        positions: vec![asked.positions()],
        rounds: 3,
        comparisons: 1.0,
    };
    let level = Level::largest(stage, &all, &part)?;
    // The shortest is the one that other work has disturbed least.
    let times: Vec<Option<f64>> =
        level.shots.iter().map(|shot| Times::of(&shot.as_ref()?.times).map(|times| times.min_ms)).collect();

    let larger = pixels(asked_size) / pixels(level.size);
    let slower = slowdown(stage, &all, &times, (asked_size, &level))?;
    let mut encode_ms = 0.0;
    if let Some(film) = &level.film {
        let begun = Instant::now();
        stage.workers.work(|| encode(film, FileFormat::Png8))?;
        encode_ms = milliseconds(begun) * larger;
    }
    let mut choices = Vec::new();
    for (index, ((name, settings), shot)) in named.into_iter().zip(&level.shots).enumerate() {
        let reference = level.reference(asked.positions());
        let factor = slower * level.more_rays(index, larger);
        choices.push(Choice {
            name,
            settings,
            request_ms: times[index].map(|ms| load_ms + factor * ms + encode_ms),
            rays: shot.as_ref().map(|shot| shot.rays),
            difference: shot.as_ref().and_then(|shot| stage.compare(reference?, &shot.codes)),
            proved_codes: shot.as_ref().and_then(|shot| shot.proved_codes),
            picture: shot.as_ref().map(|shot| shot.codes.clone()),
        });
    }
    stage.resize(asked_size);
    let measured = Measurement {
        size: level.size,
        asked_size,
        load_ms,
        encode_ms,
        reference: level.references.as_ref().map(|references| references.report()),
        proved_depth: stage.proved_depth(),
        why_proved: stage.why().to_owned(),
        left_out: stage.left_out,
    };
    Ok(Choices::among(choices, measured))
}

/// How many times as long a ray takes in the picture asked for. If there is time, one picture is rendered to see it.
fn slowdown(
    stage: &mut Stage<'_>,
    all: &[Settings],
    times: &[Option<f64>],
    (asked_size, level): ([u32; 2], &Level),
) -> Result<f64, Cancelled> {
    let known = times.iter().enumerate().filter_map(|(index, ms)| Some((index, (*ms)?)));
    let Some((index, ms)) = known.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| level.size != asked_size) else {
        return Ok(1.0);
    };
    let factor = level.more_rays(index, pixels(asked_size) / pixels(level.size));
    if 1.5 * factor * ms / 1e3 > stage.left(1.0) {
        return Ok(1.0);
    }
    stage.resize(asked_size);
    Ok(stage.shoot(all[index], 1.0)?.map_or(1.0, |picture| picture.trace_ms / (factor * ms)))
}
