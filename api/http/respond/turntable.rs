//! `POST /v1/render?turntable=36`: pictures from all around in one answer, as an animation or a contact sheet. It is a job of frames
//! that is waited for, so what takes longer goes on as one.

use super::job::until_final;
use super::sequence;
use super::submission::{Claimed, accepted, claim, claim_in_turn, hash_of, submitted, wishes_of};
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::extract::prefer::Prefer;
use crate::http::extract::query::Query;
use crate::http::extract::scene_request::{self, SceneRequest};
use crate::http::problem::{Kind, Problem};
use crate::http::state::App;
use crate::service::jobs::Job;
use crate::service::jobs::record::State;
use crate::service::requests::jobs::WantedJob;
use crate::service::scenes::sent_scene::Form;
use crate::service::scheduler::task::PRIORITY;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, Uri};
use axum::response::Response;
use std::sync::Arc;
use std::time::{Duration, Instant};
use strahl::film::FileFormat;
use strahl::film::animation::AnimationFormat;
use strahl::sequence::Sequence;
use tokio::runtime::Handle;

/// Frames of one answer: one for each degree.
pub(crate) const FRAMES: u32 = 360;

/// Most frames of an animation in a second.
const RATE: u32 = 100;

/// Whether a request asks for one.
pub(crate) fn is_asked(uri: &Uri) -> bool {
    let names = uri.query().unwrap_or_default().split('&').map(|pair| pair.split('=').next().unwrap_or_default());
    names.into_iter().any(|name| name == "turntable")
}

/// What is asked of one: its frames, how many of a contact sheet are side by side, and the format of an animation.
#[derive(Debug)]
pub(crate) struct Asked {
    count: u32,
    across: Option<u32>,
    format: AnimationFormat,
    /// Frames a second, if it says so.
    rate: Option<u32>,
}

/// Reads `turntable`, `sheet`, `rate` and `format`.
pub(crate) fn asked(query: &mut Query, headers: &HeaderMap) -> Result<Asked, Problem> {
    let (count, sheet, rate) = parameters(query);
    query.refuse("bits", "a turntable has none, its pictures are of 8 bits: leave it out");
    query.refuse("quality", "a turntable has none, it loses nothing: leave it out");
    query.refuse("layers", "a turntable has none: ask for them without it, with format=exr");
    let count = count.unwrap_or(1);
    let named = query.animation_format();
    if sheet.is_some() && named.is_some_and(|named| named != AnimationFormat::Apng) {
        query.wrong(
            "format",
            "unsupported",
            "a contact sheet is a PNG: leave it out, or leave sheet out for an animation".into(),
        );
    }
    let format = match (named, sheet) {
        (Some(format), _) => format,
        (None, Some(_)) => AnimationFormat::Apng,
        (None, None) => sequence::best_animation(headers, &AnimationFormat::ALL)?,
    };
    if let Some([columns, rows]) = sheet
        && columns.saturating_mul(rows) < count
    {
        query.wrong("sheet", "out-of-range", format!("{columns}x{rows} has no room for {count} pictures"));
    }
    Ok(Asked { count, across: sheet.map(|[columns, _]| columns), format, rate })
}

/// The parameters that only turntables have.
pub(crate) fn parameters(query: &mut Query) -> (Option<u32>, Option<[u32; 2]>, Option<u32>) {
    let about = "So many pictures from all around, in one answer: an animated PNG, WebP or GIF, or a contact sheet.";
    let count = query.count("turntable", about, FRAMES);
    let about = "A contact sheet of a turntable instead, as COLUMNSxROWS.";
    let sheet = query.sheet("sheet", about);
    let about = "Frames of a turntable's animation in a second. Default: 24.";
    (count, sheet, query.count("rate", about, RATE))
}

/// Refuses what belongs to a turntable, where none is asked for.
pub(crate) fn refuse_without(query: &mut Query) {
    query.refuse("turntable", "it is a job of frames, which POST /v1/render alone starts");
    for name in ["sheet", "rate"] {
        query.refuse(name, "it belongs to a turntable: add turntable=COUNT");
    }
}

/// The animation or the sheet; or the job, if it is not done in time.
pub(crate) async fn answer(app: App, request: Request) -> Result<Response, Problem> {
    let began = Instant::now();
    Tenant::of(request.extensions()).require(Scope::Jobs, "a turntable (a job of frames)")?;
    let headers = request.headers().clone();
    let query = request.uri().query().unwrap_or_default().to_owned();
    let read = scene_request::read(&app, request, asked).await?;
    let SceneRequest {
        form, mut overrides, extra: Asked { count, across, format, rate }, tenant, method, body, ..
    } = read;
    let is_model = matches!(form, Form::Whole(format) if format.is_model());
    overrides.model.around = is_model.then_some(true);
    let base = if let Form::Variation(base) = &form { base.as_bytes() } else { b"" };
    let beside = [b"turntable\n", of_frames(&query).as_bytes(), b"\n", base].concat();
    let is_named = headers.contains_key("idempotency-key");
    let (claimed, body) = if is_named {
        claim(&app, &tenant, &headers, beside, body).await?
    } else {
        // The same frames again, in whatever form, are those of the first job.
        let (hash, body) = hash_of(beside, body).await?;
        let key = HeaderValue::try_from(format!("turntable-{hash}"))
            .map_err(|_| Problem::new(Kind::Internal, "the request failed"))?;
        (claim_in_turn(&app, &tenant, &key, &hash).await?, body)
    };
    let has_ended = |job: &Job| matches!(job.record().state, State::Failed | State::Canceled | State::Expired);
    let mut frames = Sequence::turntable(count);
    frames.rate = rate.map_or(frames.rate, f64::from);
    let frames = if is_model { frames.of_model() } else { frames };
    let job = match claimed {
        Claimed::Before(job) if !has_ended(&job) && job.waiters.join() => {
            drop(body);
            job
        }
        claimed => {
            let claim = if let Claimed::Now(claim) = claimed { claim } else { None };
            let wanted = WantedJob {
                scene: body,
                form,
                frames: Some(frames),
                overrides,
                output: FileFormat::Png8,
                priority: PRIORITY,
                labels: vec!["turntable".into()],
                wishes: wishes_of(&app, &tenant, None, None)?,
            };
            let job = submitted(&app, &tenant, wanted, claim).await?;
            // With a key of its own the client may ask for it again.
            if !is_named {
                job.waiters.hide();
            }
            job.waiters.join();
            job
        }
    };
    let waiter = Waiter { app: app.clone(), job: Arc::clone(&job) };
    let prefer = Prefer::of(&headers);
    let patience = if prefer.respond_async { Duration::ZERO } else { app.service.settings.answers.timeout };
    // What was done before it was accepted counts, too. The job is accepted, so it is answered in any case.
    let left = prefer.wait.unwrap_or(patience).saturating_sub(began.elapsed());
    _ = until_final(&app, &tenant, &job, left).await;
    job.waiters.tell();
    drop(waiter);
    let is_final = job.record().state.is_final();
    if !is_final {
        return Ok(accepted(&app, &job, false, prefer).await);
    }
    let mut response = match across {
        Some(across) => sequence::sheet(&app, &tenant, &job, Some(across)).await?,
        None => sequence::animation(&app, &tenant, (&method, &headers), &job, Some(format)).await?,
    };
    Prefer { respond_async: false, ..prefer }.add_applied(response.headers_mut());
    Ok(response)
}

/// A request that waits for a job. If it goes away and nobody else knows of the job, that is deleted, so that the next request for
/// the same turntable begins another one.
#[derive(Debug)]
struct Waiter {
    app: App,
    job: Arc<Job>,
}

impl Drop for Waiter {
    fn drop(&mut self) {
        if self.job.waiters.leave()
            && let Ok(runtime) = Handle::try_current()
        {
            let (app, job) = (self.app.clone(), Arc::clone(&self.job));
            runtime.spawn_blocking(move || {
                if let Err(error) = app.service.jobs.forget(&job) {
                    tracing::warn!(%error, "the job of a client that went away goes on");
                }
            });
        }
    }
}

/// The part of a query that says what the frames are, not what is made of them.
fn of_frames(query: &str) -> String {
    let says_more = |pair: &&str| !matches!(pair.split('=').next(), Some("format" | "sheet"));
    query.split('&').filter(says_more).collect::<Vec<_>>().join("&")
}
