//! `POST /v1/rays`: a scene and rays in, what each ray hits first out.

use super::explain::{Answer, ask, to_json};
use super::render::gone;
use crate::http::contract::{bodies, generated, queries};
use crate::http::extract::query::Parameters;
use crate::http::problem::{Kind, Problem};
use crate::http::{App, Service};
use crate::service::limits::MAX_RAYS;
use crate::service::scheduler::admission::Work;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::de::{Deserialize, Deserializer, IgnoredAny, SeqAccess, Visitor};
use serde_json::json;
use serde_json::value::RawValue;
use std::fmt;
use std::sync::atomic::Ordering;
use strahl::inspect::query::{RayAnswer, RayQuery, answer};
use strahl::scene::{Format, Overrides, Problems, Scene, problem};

/// A scene and rays in, what each ray hits first out.
#[utoipa::path(
    post, path = "/v1/rays", operation_id = "rays", tag = "render",
    params(queries::Settings),
    request_body = Questions,
    responses((status = 200, description = "What the rays hit", body = bodies::Answers)),
)]
pub(crate) async fn rays(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    ask(service, request, only_json, |service, job, bytes, _, overrides, ()| answer_all(service, job, bytes, overrides))
        .await
}

fn only_json(_: &mut Parameters, headers: &HeaderMap) -> Result<(), Problem> {
    match crate::http::extract::body::scene_format(headers)? {
        Format::Json => Ok(()),
        Format::Nff => Err(Problem::new(Kind::UnsupportedMediaType, "rays come with their scene, as application/json")),
    }
}

fn answer_all(service: &Service, job: &Work, bytes: &[u8], overrides: &Overrides) -> Result<Answer, Problem> {
    let Questions { scene: text, rays } = serde_json::from_slice(bytes).map_err(|error| shape(&error))?;
    if rays.count > MAX_RAYS {
        let detail = format!("{} rays are too many; one request has at most {MAX_RAYS} (max_rays)", rays.count);
        return Err(Problem::limit(Kind::TooLarge, "max_rays", MAX_RAYS as u64, detail));
    }
    let rays = read_all(&rays.texts)?;
    let found = service.scenes.find(&job.workers, text.get().as_bytes(), Format::Json, overrides);
    let found = found.map_err(|problems| Problem::scene(&inside(bytes, text, problems)))?;
    let answers = job.workers.work(|| follow(job, &found.ready.scene, &rays)).ok().flatten().ok_or_else(gone)?;
    to_json(&json!({ "answers": answers }))
}

/// The body. Its parts stay text: each is read on its own, so that errors say which one it is.
#[derive(Debug, serde::Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
struct Questions<'a> {
    /// The scene the rays are sent into.
    #[serde(borrow)]
    #[schema(value_type = generated::Scene)]
    scene: &'a RawValue,
    /// The rays.
    #[serde(borrow)]
    #[schema(value_type = Vec<bodies::RayQuestion>, max_items = 100_000)]
    rays: Rays<'a>,
}

/// As many rays as are allowed, and how many there are: a reference takes several times the memory of `0,`.
#[derive(Debug)]
struct Rays<'a> {
    texts: Vec<&'a RawValue>,
    count: usize,
}

impl<'de: 'a, 'a> Deserialize<'de> for Rays<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SceneStore;
        impl<'de> Visitor<'de> for SceneStore {
            type Value = Rays<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an array of rays")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Rays<'de>, A::Error> {
                let mut texts = Vec::new();
                while texts.len() < MAX_RAYS
                    && let Some(text) = all.next_element()?
                {
                    texts.push(text);
                }
                let mut count = texts.len();
                // Asking again after the end of a shorter array is an error in serde_json.
                while count >= MAX_RAYS && all.next_element::<IgnoredAny>()?.is_some() {
                    count += 1;
                }
                Ok(Rays { texts, count })
            }
        }
        deserializer.deserialize_seq(SceneStore)
    }
}

fn shape(error: &serde_json::Error) -> Problem {
    let (kind, code) =
        if error.is_data() { (Kind::InvalidRays, "wrong-type") } else { (Kind::InvalidJson, "invalid-json") };
    let detail = error.to_string();
    let entry = json!({
        "pointer": "#", "code": code, "detail": detail, "line": error.line(), "column": error.column()
    });
    Problem::new(kind, detail).with("errors", json!([entry]))
}

fn read_all(rays: &[&RawValue]) -> Result<Vec<RayQuery>, Problem> {
    let read = |(i, ray): (usize, &&RawValue)| {
        ray.get().parse().map_err(|detail| {
            let entry = json!({ "pointer": format!("#/rays/{i}"), "code": "out-of-range", "detail": detail });
            Problem::new(Kind::InvalidRays, format!("/rays/{i}: {detail}")).with("errors", json!([entry]))
        })
    };
    rays.iter().enumerate().map(read).collect()
}

/// None if the job was cancelled.
fn follow(job: &Work, scene: &Scene, rays: &[RayQuery]) -> Option<Vec<RayAnswer>> {
    rays.par_iter().map(|ray| (!job.control.cancelled.load(Ordering::Relaxed)).then(|| answer(scene, ray))).collect()
}

/// The problems of a scene that is a part of a larger text, as places in that text.
fn inside(body: &[u8], scene: &RawValue, problems: Problems) -> Problems {
    let before = scene.get().as_ptr() as usize - body.as_ptr() as usize;
    let before = &body[..before];
    let lines = before.iter().filter(|byte| **byte == b'\n').count() as u32;
    let columns = before.iter().rev().take_while(|byte| **byte != b'\n').count() as u32;
    let place = |problem: problem::Problem| problem::Problem {
        pointer: format!("/scene{}", problem.pointer),
        column: problem.column.map(|column| if problem.line == Some(1) { column + columns } else { column }),
        line: problem.line.map(|line| line + lines),
        ..problem
    };
    Problems(problems.0.into_iter().map(place).collect())
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

    #[test]
    fn rays_beyond_the_limit_are_counted_but_not_kept() {
        let count = |rays: usize| {
            let body = format!("{{\"scene\": 0, \"rays\": [{}]}}", vec!["0"; rays].join(","));
            let questions: Questions<'_> = serde_json::from_str(&body).unwrap();
            (questions.rays.texts.len(), questions.rays.count)
        };
        assert_eq!(count(0), (0, 0));
        assert_eq!(count(MAX_RAYS - 1), (MAX_RAYS - 1, MAX_RAYS - 1));
        assert_eq!(count(MAX_RAYS), (MAX_RAYS, MAX_RAYS));
        assert_eq!(count(MAX_RAYS + 7), (MAX_RAYS, MAX_RAYS + 7));
    }
}
