//! `strahl explain`: which effects a scene calls for, why, and what they should take; with `--analyze` also what they took.

use super::failure::Failure;
use super::scene_args::{PictureArgs, SceneArgs, SettingsArgs};
use super::session::{Session, region_of};
use super::{output, progress};
use crate::service::pictures::render::{self, RenderSpec};
use crate::service::pictures::report::{Analyzed, Cost, Report, measured};
use crate::service::scenes::prepared::planned;
use clap::{Args, ValueEnum};
use std::fmt::Write;
use strahl::film::FileFormat;
use strahl::plan::table::grouped;

/// `strahl explain`.
#[derive(Debug, Args)]
pub(super) struct ExplainArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// How to show the plan.
    #[arg(long, default_value = "table")]
    format: ExplainFormat,
    /// Render the scene, too, and put the rays actually traced beside the plan.
    #[arg(long)]
    analyze: bool,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

/// Names of plan formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ExplainFormat {
    /// For people.
    Table,
    /// For programs.
    Json,
}

/// Explains.
pub(super) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    if !args.analyze && (args.picture.region.is_some() || args.picture.stats.is_some()) {
        return Err(Failure::Usage("--region and --stats need --analyze: without it nothing is rendered".into()));
    }
    let mut session = Session::start(&args.scene, &args.settings)?;
    session.cancel_on_ctrl_c()?;
    let ready = session.prepare()?;
    let region = region_of(&ready.scene, args.picture.region)?;
    session.file.inputs.check_outputs(args.picture.stats.as_deref())?;
    let (plan, pilot) = planned(&ready, region, &session.workers, &session.control)?;
    if !args.analyze {
        return match args.format {
            ExplainFormat::Table => output::print_text(&plan.to_table()),
            ExplainFormat::Json => output::print(&output::pretty(&plan)?),
        };
    }

    let shot = RenderSpec::of(&ready.scene, region, FileFormat::Png8);
    let make =
        || render::make(session.started, &ready, ready.loading, &shot, &session.workers, &session.control, None, None);
    let mut report = progress::while_showing(&session.control, make)?.report;
    report.plan = measured((plan, pilot), &report.cost, &ready, region, &session.workers, &session.control)?;
    if let Some(path) = &args.picture.stats {
        output::write(path, &output::pretty(&report)?)?;
    }
    match args.format {
        ExplainFormat::Table => output::print_text(&table(&report)),
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
