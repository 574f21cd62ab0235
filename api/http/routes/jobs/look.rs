//! The picture of a job, and parts of it, which are rendered next if they are not finished.

use super::ID;
use crate::http::extract::named_job::NamedJob;
use crate::http::prelude::*;
use crate::http::respond::body;
use crate::http::respond::forward::forward_to_owner;
use crate::http::respond::job::{encode_png, no_picture, patiently, picture_of};
use crate::http::respond::sequence::{animation, refuse_sequence};
use crate::service::jobs::Job;
use crate::service::jobs::record::State as JobState;
use crate::service::limits::PART_PIXELS;
use crate::service::pictures::spec::outside;
use crate::service::scheduler::task::Class;
use std::time::Duration;
use strahl::film::Region;

/// Longest wait for an unfinished part. Viewers give up after 30 seconds.
const PART_PATIENCE: Duration = Duration::from_secs(25);

pub(super) fn routes() -> Vec<Route> {
    let about_tile = "A part of the picture as a PNG: at once if it is finished, else as soon as it is. The request makes it the \
                      next part to be rendered.";
    let region = |query: &mut Query| {
        query.region();
    };
    vec![
        Route::get(
            "/v1/jobs/{id}/image",
            image,
            ["jobImage", "jobs", "The picture of a job that has succeeded; of a sequence, its animation."],
        )
        .needs(Scope::Read)
        .path("id", ID)
        .picture_or_animation(),
        Route::get("/v1/jobs/{id}/tile", tile, ["jobTile", "jobs", about_tile])
            .needs(Scope::Read)
            .path("id", ID)
            .query(region)
            .answer(200, "The part, as it will be in the picture", &[Content::file("image/png")]),
        Route::post(
            "/v1/jobs/{id}/look",
            look,
            ["lookAtJob", "jobs", "Asks for a part of the picture to be rendered next."],
        )
        .needs(Scope::Read)
        .path("id", ID)
        .query(region)
        .answer(204, "It is next", &[]),
    ]
}

async fn image(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let (method, headers) = (request.method(), request.headers());
    if job.record().frames.is_some() {
        return animation(&app, &tenant, (method, headers), &job, None).await;
    }
    picture_of(&app, &tenant, method, headers, &job).await
}

pub(super) async fn tile(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let region = region_of(&job, &request)?;
    if let Some(answer) = forward_to_owner(&app, &job, &tenant, "tile", &request).await {
        return Ok(answer);
    }
    let mut bell = job.events.bell();
    let watcher = job.watch();
    job.look(region);
    let finished = async {
        loop {
            if let Some(film) = job.finished_part(region) {
                return Some(film);
            }
            if job.record().state.is_final() || bell.changed().await.is_err() {
                return None;
            }
        }
    };
    let film = patiently(&app, PART_PATIENCE, finished).await.flatten();
    drop(watcher);
    let png = match film {
        Some(film) => encode_png(&app, &tenant, film).await?,
        None if job.record().state == JobState::Succeeded => {
            let part = app.service.part_of_job(tenant.task(Class::Tiles), &job, region).await?;
            part.ok_or_else(|| Problem::new(Kind::Gone, "the job's scene is gone"))?
        }
        None => return Err(no_picture(&job)),
    };
    let headers = [(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, "private, max-age=3600")];
    Ok((headers, body(app.service.memory.metered(png)?)).into_response())
}

pub(super) async fn look(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let region = region_of(&job, &request)?;
    if let Some(answer) = forward_to_owner(&app, &job, &tenant, "look", &request).await {
        return Ok(answer);
    }
    job.look(region);
    Ok(StatusCode::NO_CONTENT.into_response())
}

fn region_of(job: &Job, request: &Request) -> Result<Region, Problem> {
    refuse_sequence(job)?;
    let region = Query::read(request.uri(), Query::region)?;
    let record = job.record();
    if !region.fits(record.width, record.height) {
        return Err(outside("the region", record.width, record.height).into());
    }
    if region.pixels() > PART_PIXELS {
        let detail = format!("a part has at most {PART_PIXELS} pixels (part_pixels)");
        return Err(Problem::limit(Kind::CostLimit, "part_pixels", PART_PIXELS, detail));
    }
    Ok(region)
}
