//! Questions about a scene that are answered without a picture: rays, ray trees, the plan, validity.

use super::App;
use super::body;
use super::limits::MAX_RAYS;
use super::parameters::{Parameters, outside};
use super::picture::{gone, load};
use super::problem::{Kind, Problem};
use super::queue::Job;
use crate::rays::read_ray;
use axum::extract::{Request, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use serde_json::json;
use serde_json::value::RawValue;
use std::sync::atomic::Ordering;
use strahl::plan::explain::explain;
use strahl::scene::{Format, Overrides, Problems, Scene, problem};
use strahl::trace::query::{RayAnswer, RayQuery, answer};
use strahl::trace::tree::trace_pixel;

/// `POST /v1/explain`: which effects the scene calls for, and why.
pub(super) async fn explanation(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    ask(
        service,
        request,
        |_| (),
        |job, bytes, format, overrides, ()| {
            let loaded = load(job, bytes, format, overrides)?;
            to_json(&explain(&loaded.description, &loaded.scene))
        },
    )
    .await
}

/// `POST /v1/scenes/validate`: all problems, or none and perhaps warnings.
pub(super) async fn validate(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    ask(
        service,
        request,
        |_| (),
        |job, bytes, format, overrides, ()| {
            let loaded = load(job, bytes, format, overrides)?;
            to_json(&json!({ "valid": true, "warnings": loaded.scene.warnings }))
        },
    )
    .await
}

/// `POST /v1/tree`: every ray of one pixel.
pub(super) async fn tree(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let parameters = |parameters: &mut Parameters| {
        let formats = [("json", TreeFormat::Json), ("dot", TreeFormat::Dot), ("svg", TreeFormat::Svg)];
        (parameters.pixel(), parameters.choice("format", &formats, TreeFormat::Json))
    };
    ask(service, request, parameters, |job, bytes, format, overrides, ([x, y], tree_format)| {
        let scene = load(job, bytes, format, overrides)?.scene;
        if x >= scene.width || y >= scene.height {
            return Err(outside(&format!("the pixel x={x}, y={y}"), scene.width, scene.height));
        }
        let tree = job.workers.work(|| trace_pixel(&scene, x, y));
        match tree_format {
            TreeFormat::Json => to_json(&tree),
            TreeFormat::Dot => Ok(("text/vnd.graphviz", tree.to_dot().into_bytes())),
            TreeFormat::Svg => Ok(("image/svg+xml", tree.to_svg().into_bytes())),
        }
    })
    .await
}

#[derive(Debug, Clone, Copy)]
enum TreeFormat {
    Json,
    Dot,
    Svg,
}

/// `POST /v1/rays`: what each ray hits first.
pub(super) async fn rays(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    if body::scene_format(request.headers())? != Format::Json {
        return Err(Problem::new(Kind::UnsupportedMediaType, "rays come with their scene as application/json"));
    }
    ask(
        service,
        request,
        |_| (),
        |job, bytes, format, overrides, ()| {
            let Questions { scene: scene_text, rays } = serde_json::from_slice(bytes).map_err(|error| shape(&error))?;
            if rays.len() > MAX_RAYS {
                let detail = format!("{} rays are too many; one request has at most {MAX_RAYS} (max_rays)", rays.len());
                return Err(Problem::limit(Kind::TooLarge, "max_rays", MAX_RAYS as u64, detail));
            }
            let rays = checked(&rays)?;
            let loaded = job.workers.work(|| strahl::scene::load(scene_text.get().as_bytes(), format, overrides));
            let scene = loaded.map_err(|problems| Problem::scene(&inside(bytes, scene_text, problems)))?.scene;
            let answers = job.workers.work(|| answers(job, &scene, &rays)).ok_or_else(gone)?;
            to_json(&json!({ "answers": answers }))
        },
    )
    .await
}

/// The body of `POST /v1/rays`. The parts stay text: each is read on its own, so that errors say which one it is.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Questions<'a> {
    #[serde(borrow)]
    scene: &'a RawValue,
    #[serde(borrow)]
    rays: Vec<&'a RawValue>,
}

fn shape(error: &serde_json::Error) -> Problem {
    let kind = if error.is_data() { Kind::InvalidRays } else { Kind::InvalidJson };
    Problem::new(kind, error.to_string()).with(
        "errors",
        json!([{ "pointer": "#", "code": "invalid-json", "detail": error.to_string(),
            "line": error.line(), "column": error.column() }]),
    )
}

fn checked(rays: &[&RawValue]) -> Result<Vec<RayQuery>, Problem> {
    rays.iter()
        .enumerate()
        .map(|(i, ray)| {
            read_ray(ray.get()).map_err(|detail| {
                let error = json!({ "pointer": format!("#/rays/{i}"), "code": "out-of-range", "detail": detail });
                Problem::new(Kind::InvalidRays, format!("/rays/{i}: {detail}")).with("errors", json!([error]))
            })
        })
        .collect()
}

/// The problems of a scene that is a part of a larger text, as places in that text.
fn inside(body: &[u8], scene: &RawValue, problems: Problems) -> Problems {
    let before = scene.get().as_ptr() as usize - body.as_ptr() as usize;
    let before = &body[..before];
    let lines = before.iter().filter(|byte| **byte == b'\n').count();
    let columns = before.iter().rev().take_while(|byte| **byte != b'\n').count();
    let place = |problem: problem::Problem| problem::Problem {
        pointer: format!("/scene{}", problem.pointer),
        column: problem.column.map(|column| if problem.line == Some(1) { column + columns as u32 } else { column }),
        line: problem.line.map(|line| line + lines as u32),
        ..problem
    };
    Problems(problems.0.into_iter().map(place).collect())
}

/// None if the job was cancelled.
fn answers(job: &Job, scene: &Scene, rays: &[RayQuery]) -> Option<Vec<RayAnswer>> {
    rays.par_iter().map(|ray| (!job.control.cancelled.load(Ordering::Relaxed)).then(|| answer(scene, ray))).collect()
}

/// A media type and bytes of it.
type Answer = (&'static str, Vec<u8>);

fn to_json(value: &impl Serialize) -> Result<Answer, Problem> {
    let json = serde_json::to_vec(value).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        Problem::new(Kind::Internal, "the answer cannot be written")
    })?;
    Ok(("application/json", json))
}

/// What all questions share: parameters, then the body, then a job that answers.
async fn ask<P: Send + 'static>(
    service: App,
    request: Request,
    further: impl FnOnce(&mut Parameters) -> P,
    job: impl FnOnce(&Job, &[u8], Format, &Overrides, P) -> Result<Answer, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let format = body::scene_format(&parts.headers)?;
    let mut parameters = Parameters::of(&parts.uri)?;
    let overrides = parameters.overrides(format);
    let further = further(&mut parameters);
    parameters.finish()?;

    let body = body::read(&service, &parts.headers, body).await?;
    let work = move |current: &Job| job(current, body.as_ref(), format, &overrides, further);
    let (media_type, bytes) = service.queue.run(work).await?.value;
    let body = body::Held::new(bytes, &service.memory).into_body();
    Ok(([(header::CONTENT_TYPE, media_type)], body).into_response())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_of_a_scene_inside_a_body_are_found_in_the_body() {
        let body = "{\"rays\": [],\n \"scene\": {\n  \"version\": 2}}".as_bytes();
        let questions: Questions<'_> = serde_json::from_slice(body).unwrap();
        let at = |line, column| {
            let problem = problem::Problem::new("/version", problem::Code::OutOfRange, "must be 1");
            let problems = Problems::one(problem::Problem { line: Some(line), column: Some(column), ..problem });
            let Problems(found) = inside(body, questions.scene, problems);
            (found[0].pointer.clone(), found[0].line, found[0].column)
        };
        assert_eq!(at(1, 1), ("/scene/version".into(), Some(2), Some(11)));
        assert_eq!(at(2, 14), ("/scene/version".into(), Some(3), Some(14)));
    }
}
