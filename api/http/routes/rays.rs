//! `POST /v1/rays`: finds what each of some rays hits first in a scene.

use crate::http::contract::{example_scene, scene_reference};
use crate::http::extract::body::declares_json;
use crate::http::extract::body_part::BodyPart;
use crate::http::extract::bounded::BoundedList;
use crate::http::extract::json_body;
use crate::http::extract::variation::form_of;
use crate::http::prelude::*;
use crate::http::respond::{Answer, body};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::limits::{ANSWER_GROWTH, MAX_RAYS};
use crate::service::scenes::sent_scene::SentScene;
use crate::service::scheduler::admission::Work;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde_json::json;
use serde_json::value::RawValue;
use strahl::inspect::query::{RayAnswer, RayQuery, answer as follow};
use strahl::render::Cancelled;
use strahl::scene::{Format, Scene};

pub(super) fn routes() -> Vec<Route> {
    let about = "Finds what each of some rays hits first in a scene.";
    let example = json!({ "scene": example_scene(), "rays": [{ "origin": [0, 1, 5], "direction": [0, 0, -1] }] });
    vec![
        Route::post("/v1/rays", rays, ["rays", "render", about])
            .needs(Scope::Render)
            .query(|query| query.settings(Format::Json))
            .body(Body::json::<RayQueries<'_>>("The scene and the rays").example(example))
            .answer(200, "What the rays hit", &[Content::json::<RayAnswers>()])
            .warns(),
    ]
}

/// What the body is.
const ABOUT: &str = r#"the body is {"scene": {...}, "rays": [{"origin": [x, y, z], "direction": [x, y, z]}, ...]}"#;
/// Rays that are followed at a time, before it is seen whether their answers have room.
const PART: usize = 2_048;
/// Bytes that any request may have been larger.
const BESIDE: usize = 1_000;

/// A scene and rays. Both are raw JSON, and each part is parsed on its own, so that errors say where they are.
#[derive(Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RayQueries<'a> {
    /// The scene.
    #[serde(borrow)]
    #[schemars(schema_with = "scene_reference")]
    scene: &'a RawValue,
    /// The rays.
    #[serde(borrow)]
    #[schemars(with = "Vec<RayQuery>", length(max = 100_000))]
    rays: BoundedList<&'a RawValue, MAX_RAYS>,
}

/// What the rays hit, in their order.
#[derive(Debug, JsonSchema)]
#[expect(dead_code, reason = "it is written part by part")]
struct RayAnswers {
    /// One for each ray.
    answers: Vec<RayAnswer>,
}

async fn rays(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |_, headers| declares_json(headers).map(drop), answer).await
}

fn answer(Question { app, work, sent, tenant }: Question<'_>, (): ()) -> Result<Answer, Problem> {
    let RayQueries { scene: text, rays } = json_body::read_or(Kind::InvalidRays, sent.text, ABOUT)?;
    if rays.count > MAX_RAYS {
        let detail = format!("{} rays are too many; one request has at most {MAX_RAYS} (max_rays)", rays.count);
        return Err(Problem::limit(Kind::TooLarge, "max_rays", MAX_RAYS as u64, detail));
    }
    let rays = read_all(sent.text, &rays.kept)?;
    let (form, scene) = form_of(&app.service, tenant, text.get().as_bytes())?;
    let scene = SentScene::new(scene, &form, &sent.overrides);
    let part = BodyPart::of(sent.text, "/scene".into(), text);
    let found = app.service.scenes.find(&work.workers, &scene).map_err(|error| part.error(error))?;
    let mut answer = app.service.memory.empty();
    let most = ANSWER_GROWTH * (sent.text.len() + BESIDE);
    answer.append(b"{\"answers\":[")?;
    for (number, part) in rays.chunks(PART).enumerate() {
        work.control.add_rays(part.len() as u64);
        let texts = work.workers.work(|| follow_all(work, &found.ready.scene, part)).and_then(|texts| texts);
        for (place, text) in texts.map_err(Error::from)?.iter().enumerate() {
            if answer.len() + text.len() > most {
                let detail = format!(
                    "the answer would have more than {most} bytes, {ANSWER_GROWTH} for each that was sent \
                     (answer_growth): send fewer rays, or a scene with shorter names"
                );
                return Err(Problem::limit(Kind::TooLarge, "answer_growth", ANSWER_GROWTH as u64, detail));
            }
            if number + place > 0 {
                answer.append(b",")?;
            }
            answer.append(text)?;
        }
    }
    answer.append(b"]}")?;
    Ok(Answer::new("application/json", body(answer)).warning(&found.ready.scene.warnings))
}

fn read_all(body: &[u8], rays: &[&RawValue]) -> Result<Vec<RayQuery>, Problem> {
    let read = |(i, ray): (usize, &&RawValue)| {
        ray.get().parse().map_err(|problems| {
            let part = BodyPart::of(body, format!("/rays/{i}"), ray);
            Problem::body(Kind::InvalidRays, ABOUT, &part.problems(problems))
        })
    };
    rays.iter().enumerate().map(read).collect()
}

/// The answers to some rays as JSON.
fn follow_all(work: &Work, scene: &Scene, rays: &[RayQuery]) -> Result<Vec<Vec<u8>>, Cancelled> {
    let is_cancelled = || work.control.is_cancelled();
    // RayAnswers are made of what JSON can say.
    let answer = |ray| serde_json::to_vec(&follow(scene, ray)).unwrap_or_default();
    rays.par_iter().map(|ray| if is_cancelled() { Err(Cancelled) } else { Ok(answer(ray)) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_beyond_the_limit_are_counted_but_not_kept() {
        let count = |rays: usize| {
            let body = format!("{{\"scene\": 0, \"rays\": [{}]}}", vec!["0"; rays].join(","));
            let questions: RayQueries<'_> = serde_json::from_str(&body).unwrap();
            (questions.rays.kept.len(), questions.rays.count)
        };
        assert_eq!(count(0), (0, 0));
        assert_eq!(count(MAX_RAYS - 1), (MAX_RAYS - 1, MAX_RAYS - 1));
        assert_eq!(count(MAX_RAYS), (MAX_RAYS, MAX_RAYS));
        assert_eq!(count(MAX_RAYS + 7), (MAX_RAYS, MAX_RAYS + 7));
    }
}
