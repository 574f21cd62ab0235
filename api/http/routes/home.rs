//! `GET /`: what this service is, and where to begin.

use crate::http::extract::accept;
use crate::http::prelude::*;
use crate::http::settings::Studio;
use axum::http::request::Parts;

pub(super) fn routes() -> Vec<Route> {
    let forms = [Content::text("text/plain"), Content::text("text/html")];
    let about = "What this service is, and where to begin.";
    vec![Route::get("/", home, ["home", "service", about]).answer(200, "The page", &forms).answer(
        303,
        "The studio, for browsers",
        &[],
    )]
}

/// Media types of the page, and whether each is for browsers.
const FORMS: [(&str, bool); 2] = [("text/plain", false), ("text/html", true)];

/// Paths to begin with.
const PLACES: [(&str, &str); 7] = [
    ("/studio", "edit a scene and see its picture, in a browser"),
    ("/docs", "every request and its answers, to read and to try"),
    ("/openapi.json", "the same for programs (OpenAPI 3.1)"),
    ("/schema/scene.json", "the JSON Schema of scenes"),
    ("/v1/limits", "how large scenes and pictures may be"),
    ("/problems", "what errors mean, and what to do about them"),
    ("/readyz", "whether the service takes work"),
];

async fn home(State(app): State<App>, parts: Parts) -> Result<Response, Problem> {
    let for_browsers = accept::best(&parts.headers, &FORMS)?;
    if for_browsers && app.studio != Studio::Off {
        let about = [(header::LOCATION, "/studio"), (header::VARY, "Accept")];
        return Ok((StatusCode::SEE_OTHER, about).into_response());
    }
    let curl = app.first_request(&app.base_url(&parts.extensions));
    let intro = "strahl: POST a JSON scene, get a ray-traced picture and what it cost.";
    // The first place is the studio.
    let places = PLACES.iter().skip(usize::from(app.studio == Studio::Off));
    let (media_type, text) = if for_browsers {
        let item = |(path, about): &(_, _)| format!("<li><a href=\"{path}\">{path}</a>: {about}</li>\n");
        let places: String = places.map(item).collect();
        let page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>strahl</title>\n\
             <style>body {{ font: 1rem/1.5 sans-serif; max-width: 44rem; margin: 2rem auto; padding: 0 1rem }}</style>\n\
             <h1>strahl</h1>\n<p>{intro}</p>\n<pre>{curl}</pre>\n<ul>\n{places}</ul>\n</html>\n"
        );
        ("text/html; charset=utf-8", page)
    } else {
        let places: String = places.map(|(path, about)| format!("  {path:<20}{about}\n")).collect();
        ("text/plain; charset=utf-8", format!("{intro}\n\n  {curl}\n\n{places}"))
    };
    Ok(([(header::CONTENT_TYPE, media_type), (header::VARY, "Accept")], text).into_response())
}
