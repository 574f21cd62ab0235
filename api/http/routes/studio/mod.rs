//! `/studio`: a page to edit scenes and to see what they cost. The program contains all of it, so that it works without a
//! network; `web/README.md` says how it is made.

mod files;

use crate::http::extract::accept::takes_gzip;
use crate::http::extract::conditions::{self, Verdict};
use crate::http::prelude::*;
use crate::http::settings::Studio;
use axum::http::Method;
use files::{EXAMPLES, SITE, Served};

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::get(
            "/studio",
            page,
            ["studio", "service", "The studio: edit a scene and see its picture and its cost."],
        )
        .answer(200, "The page", &[Content::text("text/html")])
        .answer(304, "The page has not changed", &[]),
        Route::get("/studio/{hash}/{*file}", file, ["studioFile", "service", "A file of the studio."])
            .path("hash", "The hash of all files, as the page names it")
            .path("file", "Its path")
            .answer(
                200,
                "The file",
                &[
                    Content::text("text/javascript"),
                    Content::text("text/css"),
                    Content::text("image/svg+xml"),
                    Content::text("text/plain"),
                ],
            ),
        Route::get("/v1/examples", examples, ["examples", "service", "Scenes to begin with."]).answer(
            200,
            "Their names",
            &[Content::json::<Examples>()],
        ),
        Route::get("/v1/examples/{group}/{name}", example, ["example", "service", "A scene to begin with."])
            .path("group", "The first part of its id")
            .path("name", "The second")
            .answer(200, "The scene", &[Content::of("application/json", |_| serde_json::json!({ "type": "object" }))]),
    ]
}

/// The page may run its own scripts, ask its own service, and show pictures that it has made. It holds keys, so nothing else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; \
                      trusted-types 'none'";
/// A file never changes, since the hash is in its path.
const FOR_EVER: &str = "public, max-age=31536000, immutable";
/// The folder of files that are read from disk.
const CHANGING: &str = "files";

async fn page(State(app): State<App>, method: Method, headers: HeaderMap) -> Result<Response, Problem> {
    let (etag, answer) = match &app.studio {
        Studio::Off => return Err(absent()),
        Studio::Folder(folder) => {
            let template = files::from_disk(folder, "index.html").ok_or_else(absent)?;
            let page = files::page(&String::from_utf8_lossy(&template), CHANGING);
            (format!("\"{CHANGING}\""), page.into_response())
        }
        Studio::Embedded => {
            let etag = format!("\"{}\"", SITE.hash);
            if conditions::weigh(&method, &headers, Some(&etag)) == Verdict::NotModified {
                return Ok((StatusCode::NOT_MODIFIED, about_page(&etag)).into_response());
            }
            (etag, answer(SITE.page(takes_gzip(&headers))))
        }
    };
    let type_of = [(header::CONTENT_TYPE, "text/html; charset=utf-8")];
    Ok((about_page(&etag), type_of, answer).into_response())
}

/// Headers of the page and of the answer that it has not changed. Browsers take the policy of the latter for the page that they
/// have kept.
fn about_page(etag: &str) -> [(header::HeaderName, String); 4] {
    [
        (header::CONTENT_SECURITY_POLICY, POLICY.to_owned()),
        // Weak, since the compressed form has it, too.
        (header::ETAG, format!("W/{etag}")),
        (header::CACHE_CONTROL, "no-cache".to_owned()),
        (header::VARY, "Accept-Encoding".to_owned()),
    ]
}

async fn file(
    State(app): State<App>,
    Path((hash, path)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (lasts, answer) = match &app.studio {
        Studio::Folder(folder) if hash == CHANGING => {
            ("no-store", files::from_disk(folder, &path).ok_or_else(absent)?.into_response())
        }
        // A file of another version is never answered with one of this version, nor with the page.
        Studio::Embedded if hash == SITE.hash => {
            (FOR_EVER, answer(SITE.file(&path, takes_gzip(&headers)).ok_or_else(absent)?))
        }
        _ => return Err(absent()),
    };
    let about = [(header::CONTENT_TYPE, media_type(&path)), (header::CACHE_CONTROL, lasts)];
    Ok((about, [(header::VARY, "Accept-Encoding")], answer).into_response())
}

fn absent() -> Problem {
    Problem::new(Kind::NotFound, "there is no such file of the studio in this version of the service; reload the page")
}

fn answer(served: Served) -> Response {
    let mut answer = served.bytes.into_response();
    if served.is_packed {
        answer.headers_mut().insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    answer
}

fn media_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

/// Scenes to begin with.
#[derive(Debug, Serialize, JsonSchema)]
struct Examples {
    examples: Vec<ExampleEntry>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct ExampleEntry {
    /// Its id, two words.
    id: &'static str,
    title: &'static str,
    /// What it shows, in a sentence.
    about: &'static str,
    /// Where its text is.
    href: String,
}

async fn examples() -> Json<Examples> {
    let listed = EXAMPLES.iter().map(|of| ExampleEntry {
        id: of.id,
        title: of.title,
        about: of.about,
        href: format!("/v1/examples/{}", of.id),
    });
    Json(Examples { examples: listed.collect() })
}

async fn example(Path((group, name)): Path<(String, String)>) -> Result<impl IntoResponse, Problem> {
    let id = format!("{group}/{name}");
    let of = EXAMPLES
        .iter()
        .find(|of| of.id == id)
        .ok_or_else(|| Problem::new(Kind::NotFound, format!("there is no example {id}; /v1/examples lists them")))?;
    Ok(([(header::CONTENT_TYPE, "application/json")], of.text))
}
