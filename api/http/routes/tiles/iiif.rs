//! IIIF Image API 3.0, level 2: images, and the way from an image's address to its description.

use super::iiif_parse::{ImageRequest, understand};
use super::{everywhere, open, place, show};
use crate::http::auth::capability::Capability;
use crate::http::auth::client::Client;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::bodies::Picture;
use crate::http::problem::Problem;
use crate::http::respond::put;
use crate::http::{App, Service};
use axum::extract::{Path, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Leads to the image's description.
#[utoipa::path(
    get, path = "/iiif/3/{image}", operation_id = "iiif", tag = "tiles",
    params(("image" = String, Path, description = "The image's id.")),
    responses((status = 303, description = "The description is at info.json")),
)]
pub(crate) async fn iiif(State(service): State<App>, Path(id): Path<String>, parts: Parts) -> Response {
    let to = format!("{}/info.json", address(&service, &parts, &id));
    let mut response = (StatusCode::SEE_OTHER, [(header::LOCATION, to)]).into_response();
    everywhere(&mut response);
    response
}

/// Any rectangle of an image in any size, mirrored and turned, in color or without.
#[utoipa::path(
    get, path = "/iiif/3/{image}/{region}/{size}/{rotation}/{file}", operation_id = "iiifImage", tag = "tiles",
    params(
        ("image" = String, Path, description = "The image's id."),
        ("region" = String, Path, description = "`full`, `square`, `x,y,w,h` or `pct:x,y,w,h`."),
        ("size" = String, Path, description = "`max`, `w,h`, `w,`, `,h`, `pct:n` or `!w,h`; with `^` before it more detail than the image has."),
        ("rotation" = String, Path, description = "`0`, `90`, `180` or `270`; with `!` before it mirrored."),
        ("file" = String, Path, description = "`default`, `color`, `gray` or `bitonal`, and `.jpg`, `.png` or `.webp`."),
    ),
    responses((status = 200, response = Picture)),
)]
pub(crate) async fn iiif_image(
    State(service): State<App>,
    Path((id, region, size, rotation, file)): Path<(String, String, String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let tenant = Tenant::of(&parts.extensions);
    let _place = place(&service, Client::of(&parts.extensions))?;
    let opened = open(&service, &tenant, &id).await?;
    let max_area = service.limits.max_area(&opened.ready.scene);
    let asked = ImageRequest { region: &region, size: &size, rotation: &rotation, file: &file };
    let understood = understand(asked, opened.size, max_area)?;
    let canonical = format!("{}/{}", address(&service, &parts, &id), understood.canonical);
    let mut response = show(&service, &tenant, &parts, opened.image, understood.spec).await?;
    let links = format!("<{canonical}>;rel=\"canonical\", <http://iiif.io/api/image/3/level2.json>;rel=\"profile\"");
    put(response.headers_mut(), header::LINK, &links);
    Ok(response)
}

/// The address of an image as its client sees it.
pub(crate) fn address(service: &Service, parts: &Parts, id: &str) -> String {
    let base = service.public_url.clone().unwrap_or_else(|| {
        let host = parts.headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or("localhost");
        format!("http://{host}")
    });
    // With a capability in its path a client has to keep it there.
    let before = parts.extensions.get::<Capability>().map_or_else(String::new, Capability::prefix);
    format!("{base}{before}/iiif/3/{id}")
}
