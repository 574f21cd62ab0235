//! Known images as answers: the picture of an id, and parts of it in deep zoom.

use super::picture::{self, Freshness, ResponseContext};
use crate::http::auth::client::Client;
use crate::http::auth::tenant::Tenant;
use crate::http::problem::{Kind, Problem};
use crate::http::state::{App, AppState};
use crate::service::concurrency_limit::Permit;
use crate::service::pictures::spec::PictureSpec;
use crate::service::requests::pictures::Source;
use crate::service::requests::scenes::OpenedImage;
use crate::service::scenes::ids::ImageId;
use crate::service::scheduler::task::{Class, Task};
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};

/// The image that a path names.
pub(crate) fn image_id(text: &str) -> Result<ImageId, Problem> {
    ImageId::read(text).ok_or_else(|| {
        let detail = format!(
            "{text} is no image of this version of the renderer: POST /v1/render and POST /v1/scenes say a scene's image_id"
        );
        Problem::new(Kind::NotFound, detail)
    })
}

/// Opens the image in a path, and builds its scene if it is not in the cache.
pub(crate) async fn open(app: &App, tenant: &Tenant, id: &str) -> Result<OpenedImage, Problem> {
    Ok(app.service.open_image(tenant.task(Class::Tiles), image_id(id)?).await?)
}

/// The answer with a part of a known image.
pub(crate) async fn answer(
    app: &App,
    context: &ResponseContext<'_>,
    task: Task,
    image: ImageId,
    spec: PictureSpec,
) -> Result<Response, Problem> {
    let name = spec.name(&image);
    let place = picture::place_of(context, &image, &spec);
    if let Some(answer) = picture::precondition_response(context, Some(&picture::tag(&name)), place.as_deref()) {
        return answer;
    }
    let made = match app.service.stored_picture(&image, &spec).await {
        Some(file) => picture::stored(file),
        None => app.service.make_picture(task, Source::Known(image), spec).await?,
    };
    picture::deliver(app, context, &made, &spec)
}

/// The answer with a tile.
pub(crate) async fn tile(
    app: &App,
    tenant: &Tenant,
    parts: &Parts,
    image: ImageId,
    spec: PictureSpec,
) -> Result<Response, Problem> {
    let context = ResponseContext {
        method: &parts.method,
        headers: &parts.headers,
        tenant,
        freshness: Freshness::Immutable,
        negotiated: false,
    };
    Ok(everywhere(app, answer(app, &context, tenant.task(Class::Tiles), image, spec).await?))
}

/// Counts a tile of a client until it is rendered.
pub(crate) fn tile_permit(app: &AppState, client: Client) -> Result<Permit<Client>, Problem> {
    let most = app.limits.client_tiles;
    app.tile_clients.enter(client, most).ok_or_else(|| {
        let detail = format!("you are waiting for {most} tiles already (client_tiles)");
        Problem::new(Kind::RateLimited, detail).retry_after(app.service.tiles.retry_after())
    })
}

/// Lets pages of any origin read an answer, since its client has a key and knows the image's id. Not without keys.
pub(crate) fn everywhere(app: &AppState, answer: impl IntoResponse) -> Response {
    let mut response = answer.into_response();
    if app.access.needs_keys() {
        response.headers_mut().insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, HeaderValue::from_static("*"));
    }
    response
}

/// Paths of an image's tiles: IIIF, DZI and XYZ.
pub(crate) fn tiles_of(image: &str) -> [String; 3] {
    [format!("/iiif/3/{image}/info.json"), format!("/dzi/{image}.dzi"), format!("/xyz/{image}.json")]
}
