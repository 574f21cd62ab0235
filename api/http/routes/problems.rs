//! `/problems/{slug}`: what each kind of problem means, as text, or as a page for a browser.

use crate::http::extract::accept;
use crate::http::prelude::*;
use std::fmt::Write;

pub(super) fn routes() -> Vec<Route> {
    let forms = [Content::text("text/plain"), Content::text("text/html")];
    vec![
        Route::get("/problems", list, ["problems", "service", "All kinds of problems."])
            .answer(200, "The list", &forms),
        Route::get(
            "/problems/{slug}",
            page,
            ["problem", "service", "What a kind of problem means, and what to do about it."],
        )
        .path("slug", "The last part of a problem's `type`.")
        .answer(200, "The page", &forms),
    ]
}

/// Form of a page.
#[derive(Debug, Clone, Copy)]
enum Form {
    Text,
    Html,
}

const FORMS: [(&str, Form); 2] = [("text/plain", Form::Text), ("text/html", Form::Html)];

async fn list(headers: HeaderMap) -> Result<Response, Problem> {
    let mut text = String::new();
    let form = accept::best(&headers, &FORMS)?;
    for (slug, status, title, _) in Kind::ALL.iter().map(|kind| kind.page()) {
        let status = status.as_u16();
        // Writing to a String cannot fail.
        let _ = match form {
            Form::Text => writeln!(text, "{status} /problems/{slug} {title}"),
            Form::Html => writeln!(text, "<li>{status} <a href=\"/problems/{slug}\">{title}</a></li>"),
        };
    }
    Ok(match form {
        Form::Text => answer(form, text),
        Form::Html => answer(form, html("Problems", &format!("<ul>\n{text}</ul>"))),
    })
}

async fn page(Path(slug): Path<String>, headers: HeaderMap) -> Result<Response, Problem> {
    let page = Kind::ALL.iter().map(|kind| kind.page()).find(|(known, ..)| *known == slug);
    let unknown = || Problem::new(Kind::NotFound, "there is no problem of that name; /problems lists those there are");
    let (_, status, title, advice) = page.ok_or_else(unknown)?;
    let form = accept::best(&headers, &FORMS)?;
    let status = status.as_u16();
    Ok(match form {
        Form::Text => answer(form, format!("{title} ({status})\n\n{advice}\n")),
        Form::Html => {
            let advice = advice.replace('&', "&amp;").replace('<', "&lt;");
            let body =
                format!("<p>Status {status}.</p>\n<p>{advice}</p>\n<p><a href=\"/problems\">All problems</a></p>");
            answer(form, html(title, &body))
        }
    })
}

fn html(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>body {{ font: 1rem/1.5 sans-serif; max-width: 40rem; margin: 2rem auto; padding: 0 1rem }}</style>\n\
         <h1>{title}</h1>\n{body}\n</html>\n"
    )
}

fn answer(form: Form, text: String) -> Response {
    let media_type = match form {
        Form::Text => "text/plain; charset=utf-8",
        Form::Html => "text/html; charset=utf-8",
    };
    let mut response = text.into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    response
}
