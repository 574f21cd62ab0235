//! The frames of a sequence: their list, each of them, an animation and a contact sheet.

use super::ID;
use crate::http::extract::named_job::{NamedJob, find};
use crate::http::prelude::*;
use crate::http::respond::blocking;
use crate::http::respond::sequence::{self, frames_of};
use crate::service::sequences::report::{FrameReport, SequenceReport};
use strahl::film::animation::AnimationFormat;
use strahl::sequence::FRAMES;

/// What is said of the warnings of all frames.
const WARNINGS: &str = "Warnings about the frames, each once, up to twelve.";

pub(super) fn routes() -> Vec<Route> {
    let about_list = "The finished frames of a sequence: what each cost, and how far it may be from the exact picture.";
    let about_frame = "A frame of a sequence, as soon as it is finished: the picture that its scene gives alone.";
    let about_animation = "All frames of a sequence that has succeeded, as animated PNG, animated lossless WebP or GIF.\n\n\
                           Each frame has the codes of its own picture; GIF has 256 colors a frame, and `Render-Warnings` \
                           says how far they are off. The format is that of `format`, else the one that \
                           `Accept` asks for. Frames in EXR, PFM and JPEG make no animations.";
    let about_sheet = "A contact sheet: the finished frames of a sequence, small and side by side, as a PNG.";
    let formats = AnimationFormat::ALL.map(|format| Content::file(format.names().1));
    vec![
        Route::get("/v1/jobs/{id}/frames", list, ["jobFrames", "jobs", about_list])
            .needs(Scope::Read)
            .path("id", ID)
            .answer(200, "The frames, in their order", &[Content::json::<FrameList>()]),
        Route::get("/v1/jobs/{id}/frames/{number}", frame, ["jobFrame", "jobs", about_frame])
            .needs(Scope::Read)
            .path("id", ID)
            .number("number", "Its number, from 0.")
            .picture(),
        Route::get("/v1/jobs/{id}/animation", animation, ["jobAnimation", "jobs", about_animation])
            .needs(Scope::Read)
            .path("id", ID)
            .query(Query::animation_format)
            .answer(200, "The animation", &formats)
            .answer_header("Render-Warnings", WARNINGS),
        Route::get("/v1/jobs/{id}/sheet", sheet, ["jobSheet", "jobs", about_sheet])
            .needs(Scope::Read)
            .path("id", ID)
            .query(columns)
            .answer(200, "The contact sheet", &[Content::file("image/png")])
            .answer_header("Render-Warnings", WARNINGS),
    ]
}

/// Frames of a sequence.
#[derive(Debug, Serialize, JsonSchema)]
struct FrameList {
    /// Those that are finished.
    frames: Vec<FrameReport>,
    /// Their sums, and the worst of their bounds.
    sequence: SequenceReport,
}

async fn list(State(app): State<App>, NamedJob { job, .. }: NamedJob) -> Result<Response, Problem> {
    frames_of(&job)?;
    let (frames, warnings) = {
        let (app, record) = (Arc::clone(&app), job.record().clone());
        blocking(move || app.service.jobs.frame_reports(&record)).await??
    };
    let (rays, ms) = {
        let record = job.record();
        (record.estimate_rays, record.estimate_ms)
    };
    let sequence = SequenceReport::of(&frames, warnings, rays, ms);
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(FrameList { frames, sequence })).into_response())
}

async fn frame(
    State(app): State<App>,
    Path((id, number)): Path<(String, u32)>,
    request: Request,
) -> Result<Response, Problem> {
    let tenant = Tenant::of(request.extensions());
    let job = find(&app, &tenant, &id).await?;
    sequence::frame(&app, &tenant, (request.method(), request.headers()), &job, number).await
}

async fn animation(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let named = Query::read(request.uri(), Query::animation_format)?;
    sequence::animation(&app, &tenant, (request.method(), request.headers()), &job, named).await
}

fn columns(query: &mut Query) -> Option<u32> {
    let about = "How many are side by side; without it the sheet is about as wide as high.";
    query.count("columns", about, FRAMES.max as u32)
}

async fn sheet(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let columns = Query::read(request.uri(), columns)?;
    sequence::sheet(&app, &tenant, &job, columns).await
}
