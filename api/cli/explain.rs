//! `strahl explain`: which effects a scene calls for, why, and what they should take; with `--analyze` also what they took.

use super::failure::Failure;
use super::scene_file::Source;
use super::workers::{region_of, start_workers};
use super::{ExplainArgs, ExplainFormat};
use super::{interrupt, output, progress};
use crate::service::pictures::render;
use crate::service::pictures::render::Shot;
use crate::service::pictures::report::{Cost, Report};
use crate::service::scenes::prepared::{Analyzed, Ready, planned};
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;
use strahl::film::FileFormat;
use strahl::plan::table::grouped;
use strahl::render::Control;

/// Explains.
pub(super) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    if !args.analyze && (args.picture.region.is_some() || args.picture.stats.is_some()) {
        return Err(Failure::Usage("--region and --stats need --analyze: without it nothing is rendered".into()));
    }
    let control = Arc::new(Control::default());
    let workers = start_workers(args.settings.threads, &control)?;
    interrupt::cancel_on_ctrl_c(&control)?;
    let started = Instant::now();
    let source = Source::read(&args.scene)?;
    let ready = workers.work(|| source.load(&args.settings.overrides()).map(Ready::from))??;
    let region = region_of(&ready.scene, args.picture.region)?;
    let (mut plan, pilot) = planned(&ready, region, &workers, &control)?;
    if !args.analyze {
        return match args.format {
            ExplainFormat::Table => output::print(plan.to_table().as_bytes()),
            ExplainFormat::Json => output::print(&output::pretty(&plan)?),
        };
    }

    let shot = Shot::of(&ready.scene, region, FileFormat::Png8);
    let make = || render::make(started, &ready, ready.loading, &shot, &workers, &control);
    let mut report = progress::while_showing(&control, make)?.report;
    plan.measure(&pilot, &report.cost.rays, &report.cost.refined, report.cost.phases_ms.trace);
    report.plan = plan;
    if let Some(path) = &args.picture.stats {
        output::write(path, &output::pretty(&report)?)?;
    }
    match args.format {
        ExplainFormat::Table => output::print(table(&report).as_bytes()),
        ExplainFormat::Json => output::print(&output::pretty(&Analyzed { plan: &report.plan, actual: &report.cost })?),
    }
}

/// The plan, and below it what was traced.
fn table(report: &Report) -> String {
    let Cost { rays, refined, phases_ms, wall_ms, .. } = &report.cost;
    let mut text = report.plan.to_table();
    text.push_str("\nactual\n");
    let counts = [
        ("camera rays", rays.camera),
        ("  that hit something", rays.camera_hits),
        ("shadow rays", rays.shadow),
        ("reflected rays", rays.reflected),
        ("transmitted rays", rays.transmitted),
        ("gathered rays", rays.gathered),
        ("total internal reflections", rays.total_internal_reflections),
        ("shadow rays that could not matter", rays.shadow_skipped),
        ("rays dropped at a limit", rays.dropped),
        ("pixels refined by antialiasing", refined.pixels),
    ];
    // Writing to a String cannot fail.
    for (name, count) in counts {
        let _ = writeln!(text, "  {name:<33}{:>14}", grouped(count));
    }
    let others = [("all", *wall_ms), ("  of trace, antialiasing", phases_ms.refine)];
    for (name, ms) in phases_ms.list().into_iter().chain(others) {
        let _ = writeln!(text, "  {name:<33}{ms:>14.1} ms");
    }
    text
}
