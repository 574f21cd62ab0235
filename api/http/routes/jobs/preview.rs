//! `GET /v1/jobs/{id}/preview`: a small picture of what has been rendered so far.

use super::ID;
use crate::http::extract::conditions::is_known;
use crate::http::extract::named_job::NamedJob;
use crate::http::extract::prefer::Prefer;
use crate::http::prelude::*;
use crate::http::respond::blocking;
use crate::http::respond::body;
use crate::http::respond::forward::forward_to_owner;
use crate::http::respond::job::{encode_png, no_picture, patiently, render_again, waiting_permit};
use crate::http::respond::sequence::sheet;
use crate::service::jobs::record::State as JobState;
use crate::service::jobs::{Job, PREVIEW_SIDE};
use crate::service::pictures::spec::{Grid, PictureSpec};
use axum::http::HeaderName;
use std::time::Duration;
use strahl::film::{FileFormat, Region};

/// Longest wait for another preview, in seconds.
const PATIENCE: u32 = 30;

pub(super) fn routes() -> Vec<Route> {
    let about = "The newest preview, at most 1,024 pixels wide and high, as a PNG. The first one is a coarse picture of it all; \
                 until then the answer waits, up to 30 seconds. Of a sequence it is the frame that is rendered, and at the end \
                 the contact sheet.";
    let prefer = "`wait=10` waits up to 10 seconds for another preview than that of If-None-Match.";
    vec![
        Route::get("/v1/jobs/{id}/preview", preview, ["jobPreview", "jobs", about])
            .needs(Scope::Read)
            .path("id", ID)
            .header("If-None-Match", "The ETag of the preview that the client has.")
            .header("Prefer", prefer)
            .query(after_and_wait)
            .answer(200, "The preview. `Preview-Revision` is its number, for `after`", &[Content::file("image/png")])
            .answer(304, "There is no other yet", &[]),
    ]
}

fn after_and_wait(query: &mut Query) -> (Option<u64>, Option<u32>) {
    query.whole("rev", "Any number: another one is another URL, for pages that look again.");
    let after = query.whole("after", "Waits for a later revision than this.");
    (
        after,
        query.count_or_0("wait", "How many seconds at most, 30 if it is not given; 0 for an answer at once.", PATIENCE),
    )
}

pub(super) async fn preview(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let (after, wait) = Query::read(request.uri(), after_and_wait)?;
    if let Some(answer) = forward_to_owner(&app, &job, &tenant, "preview", &request).await {
        return Ok(answer);
    }
    let headers = request.headers().clone();
    let is_known = |tag: &str| is_known(&headers, tag);
    let asked = wait
        .or(after.map(|_| PATIENCE))
        .map(|seconds| Duration::from_secs(u64::from(seconds)))
        .or(Prefer::of(&headers).wait);
    let is_new = |job: &Job| {
        let revision = job.revision();
        let succeeded = job.record().state == JobState::Succeeded;
        let is_there = job.has_preview() || succeeded;
        let is_other = after.is_none_or(|after| revision > after || succeeded) && !is_known(&tag(revision, succeeded));
        // Who does not ask for another waits for the first.
        is_there && (is_other || asked.is_none())
    };
    let patience = asked.unwrap_or(Duration::from_secs(u64::from(PATIENCE)));
    let waits = !patience.is_zero() && !is_new(&job) && !job.record().state.is_final();
    let _permit = waits.then(|| waiting_permit(&app, &tenant)).transpose()?;
    let _watcher = job.watch();
    let mut bell = job.events.bell();
    let news = async { while !is_new(&job) && !job.record().state.is_final() && bell.changed().await.is_ok() {} };
    // The newest preview is returned in either case.
    patiently(&app, patience, news).await;
    let succeeded = job.record().state == JobState::Succeeded;
    let headers_of = |revision: u64| {
        [
            (header::ETAG, tag(revision, succeeded)),
            (header::CACHE_CONTROL, "no-cache".to_owned()),
            (HeaderName::from_static("preview-revision"), revision.to_string()),
        ]
    };
    if succeeded && job.record().frames.is_some() {
        let headers = headers_of(job.revision());
        if is_known(&tag(job.revision(), true)) {
            return Ok((StatusCode::NOT_MODIFIED, headers).into_response());
        }
        let mut answer = sheet(&app, &tenant, &job, None).await?;
        answer
            .headers_mut()
            .extend(headers.map(|(name, value)| (name, HeaderValue::from_str(&value).expect("digits"))));
        return Ok(answer);
    }
    let (png, revision) = if succeeded {
        let (jobs, kept) = (Arc::clone(&app.service.jobs), Arc::clone(&job));
        let png = match blocking(move || jobs.last_preview(&kept)).await?? {
            Some(png) => png,
            None => render_again(&app, &tenant, &job, small(&job)).await?,
        };
        (png, job.revision())
    } else {
        let (film, revision) = job.preview().ok_or_else(|| no_picture(&job))?;
        if is_known(&tag(revision, false)) {
            (Vec::new(), revision)
        } else {
            (encode_png(&app, &tenant, film).await?, revision)
        }
    };
    let headers = headers_of(revision);
    if is_known(&tag(revision, succeeded)) {
        return Ok((StatusCode::NOT_MODIFIED, headers).into_response());
    }
    Ok((headers, [(header::CONTENT_TYPE, "image/png")], body(app.service.memory.metered(png)?)).into_response())
}

/// The whole picture in the size of a preview.
fn small(job: &Job) -> PictureSpec {
    let record = job.record();
    let level = record.width.max(record.height).div_ceil(PREVIEW_SIDE).next_power_of_two().ilog2();
    // A picture that is small itself is asked for as a part, or its file would say what is proved, as previews do not.
    let part = (level == 0).then(|| Region::whole(record.width, record.height));
    PictureSpec { grid: Grid::Level(level as i32), ..PictureSpec::plain(part, FileFormat::Png8) }
}

fn tag(revision: u64, is_last: bool) -> String {
    if is_last { "\"last\"".to_owned() } else { format!("\"r{revision}\"") }
}
