//! Answers about the frames of a job: one by one, as an animation, or on a contact sheet.

use super::job::no_picture;
use super::picture::{Freshness, ResponseContext, deliver, precondition_response, stored};
use super::{blocking, body, put, put_warnings};
use crate::http::auth::tenant::Tenant;
use crate::http::extract::accept::best;
use crate::http::problem::{Kind, Problem};
use crate::http::state::App;
use crate::service::error::Error;
use crate::service::jobs::Job;
use crate::service::jobs::record::State as JobState;
use crate::service::pictures::spec::PictureSpec;
use crate::service::pictures::warnings;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use crate::service::sequences::Frames;
use crate::service::sequences::shown::animations;
use axum::http::{HeaderMap, HeaderValue, Method, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use strahl::film::FileFormat;
use strahl::film::animation::AnimationFormat;

/// The frames of a job, or the problem that it has none.
pub(crate) fn frames_of(job: &Job) -> Result<Frames, Problem> {
    let record = job.record();
    record.frames.ok_or_else(|| {
        let detail = format!("job {} is a single picture: /v1/jobs/{}/image", record.id, record.id);
        Problem::new(Kind::NotFound, detail)
    })
}

/// The problem of asking a sequence for what only a single picture has.
pub(crate) fn refuse_sequence(job: &Job) -> Result<(), Problem> {
    let record = job.record();
    if record.frames.is_none() {
        return Ok(());
    }
    let detail = format!("job {} is a sequence: its frames are /v1/jobs/{}/frames/0 and so on", record.id, record.id);
    Err(Problem::new(Kind::NotFound, detail))
}

/// The answer with a frame, as soon as it is finished.
pub(crate) async fn frame(
    app: &App,
    tenant: &Tenant,
    (method, headers): (&Method, &HeaderMap),
    job: &Arc<Job>,
    number: u32,
) -> Result<Response, Problem> {
    let frames = frames_of(job)?;
    if number >= frames.count {
        let detail = format!("the job has frames 0 to {}", frames.count - 1);
        return Err(Problem::new(Kind::NotFound, detail));
    }
    let file = {
        let (app, job) = (Arc::clone(app), Arc::clone(job));
        blocking(move || app.service.jobs.frame(&job, number)).await??
    };
    let (state, output) = {
        let record = job.record();
        (record.state, record.spec.output)
    };
    let file = match file {
        Some(file) => Arc::new(file),
        None if state == JobState::Succeeded => {
            let detail = format!("the file of frame {number} is damaged; submit the job again");
            return Err(Problem::new(Kind::Gone, detail));
        }
        None => return Err(no_picture(job)),
    };
    let context = ResponseContext { method, headers, tenant, freshness: Freshness::Once, negotiated: false };
    let mut answer = deliver(app, &context, &stored(file), &PictureSpec::plain(None, output))?;
    // Nobody has sent the scene of a frame, so its picture has no other address.
    answer.headers_mut().remove(header::CONTENT_LOCATION);
    Ok(answer)
}

/// The header with the warnings of a job's finished frames, after one of what is made of them.
async fn warnings_of(app: &App, job: &Arc<Job>, own: Option<String>) -> Result<HeaderMap, Problem> {
    let (service, record) = (Arc::clone(&app.service), job.record().clone());
    let of_frames = blocking(move || service.jobs.frame_warnings(&record)).await?;
    let lines = [warnings::line(&[], own.as_deref()), of_frames];
    let mut headers = HeaderMap::new();
    put_warnings(&mut headers, warnings::together(lines.iter().flatten().map(String::as_str)).as_deref());
    Ok(headers)
}

/// The answer with all frames of a job that has succeeded, in the format that is named or accepted.
pub(crate) async fn animation(
    app: &App,
    tenant: &Tenant,
    (method, headers): (&Method, &HeaderMap),
    job: &Arc<Job>,
    named: Option<AnimationFormat>,
) -> Result<Response, Problem> {
    frames_of(job)?;
    let (id, state, output) = {
        let record = job.record();
        (record.id.clone(), record.state, record.spec.output)
    };
    if state != JobState::Succeeded {
        return Err(no_picture(job));
    }
    let formats = animations(output);
    let format = match named {
        Some(format) if formats.contains(&format) => format,
        None if !formats.is_empty() => best_animation(headers, formats)?,
        _ => {
            let name = if output == FileFormat::Png16 { "png of 16 bits" } else { output.names().0 };
            let detail =
                format!("frames in {name} make no such animation; ask a job for output png, of 8 bits, or webp");
            return Err(Problem::new(Kind::NotAcceptable, detail));
        }
    };
    let (ending, media_type) = format.names();
    let etag = format!("\"{id}.{ending}\"");
    let context = ResponseContext { method, headers, tenant, freshness: Freshness::Once, negotiated: named.is_none() };
    if let Some(answer) = precondition_response(&context, Some(&etag), None) {
        return answer;
    }
    let made = {
        let (app, job) = (Arc::clone(app), Arc::clone(job));
        let work = {
            let app = Arc::clone(&app);
            move |work: &Work| -> Result<_, Error> { work.workers.work(|| app.service.animation(&job, format))? }
        };
        app.service.run(tenant.task(Class::Renders), work).await?.value
    };
    let made = made.ok_or_else(damaged)?;
    let mut answer = warnings_of(app, job, made.warning()).await?;
    let bytes = made.file;
    answer.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    answer.insert(header::CONTENT_LENGTH, bytes.len().into());
    answer.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    if named.is_none() {
        answer.insert(header::VARY, HeaderValue::from_static("Accept"));
    }
    put(&mut answer, header::ETAG, &etag);
    put(&mut answer, header::CONTENT_DISPOSITION, &format!("inline; filename=\"{id}.{ending}\""));
    Ok((answer, body(app.service.memory.metered(bytes)?)).into_response())
}

/// The format of animations that a client accepts.
pub(crate) fn best_animation(headers: &HeaderMap, formats: &[AnimationFormat]) -> Result<AnimationFormat, Problem> {
    best(headers, &accepted(formats))
}

/// Media types of animations. APNG is PNG to those who know no better.
fn accepted(formats: &[AnimationFormat]) -> Vec<(&'static str, AnimationFormat)> {
    let all = [
        ("image/apng", AnimationFormat::Apng),
        ("image/png", AnimationFormat::Apng),
        ("image/webp", AnimationFormat::Webp),
        ("image/gif", AnimationFormat::Gif),
    ];
    let of = |format: &AnimationFormat| all.into_iter().filter(|(_, other)| other == format).collect::<Vec<_>>();
    formats.iter().flat_map(of).collect()
}

/// The answer with all frames that are finished, small and side by side.
pub(crate) async fn sheet(
    app: &App,
    tenant: &Tenant,
    job: &Arc<Job>,
    columns: Option<u32>,
) -> Result<Response, Problem> {
    frames_of(job)?;
    let (service, sequence) = (Arc::clone(&app.service), Arc::clone(job));
    let work = move |work: &Work| -> Result<_, Error> { work.workers.work(|| service.sheet(&sequence, columns))? };
    let made = app.service.run(tenant.task(Class::Renders), work).await?.value;
    let is_over = job.record().state == JobState::Succeeded;
    let png = made.ok_or_else(|| if is_over { damaged() } else { no_picture(job) })?;
    let warnings = warnings_of(app, job, None).await?;
    let headers = [(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, "no-cache")];
    Ok((headers, warnings, body(app.service.memory.metered(png)?)).into_response())
}

fn damaged() -> Problem {
    Problem::new(Kind::Gone, "the file of a frame is damaged; submit the job again")
}
