//! `GET /v1/images/{image}`: the picture that an id stands for, for ever.

use crate::http::App;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::bodies::Picture;
use crate::http::contract::queries;
use crate::http::extract::query::Parameters;
use crate::http::problem::{Kind, Problem};
use crate::http::respond;
use crate::http::respond::{Freshness, ResponseContext, Source};
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::ids::ImageId;
use crate::service::scheduler::task::Class;
use axum::extract::{Path, Request, State};
use axum::response::Response;
use strahl::film::{DEFAULT_QUALITY, FileFormat, PictureFormat};

/// The picture of an image id, in the format of its ending. It is rendered again if need be, as long as its scene is known.
#[utoipa::path(
    get, path = "/v1/images/{image}", operation_id = "image", tag = "pictures",
    params(
        ("image" = String, Path, description = "The image's id and an ending: `.png`, `.jpg`, `.webp`, `.exr` or `.pfm`."),
        queries::Details,
    ),
    responses((status = 200, response = Picture), (status = 304, description = "The client has it")),
)]
pub(crate) async fn image(
    State(service): State<App>,
    Path(file): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let (image, format) = file_name(&file)?;
    let mut parameters = Parameters::of(request.uri())?;
    let spec = PictureSpec::plain(None, parameters.format_with_details(format));
    parameters.finish()?;
    let tenant = Tenant::of(request.extensions());
    let context = ResponseContext {
        method: request.method(),
        headers: request.headers(),
        tenant: &tenant,
        freshness: Freshness::Immutable,
        negotiated: false,
    };
    answer(&service, &context, Class::Renders, image, spec).await
}

/// The answer that an excerpt of a known image makes.
pub(crate) async fn answer(
    service: &App,
    context: &ResponseContext<'_>,
    class: Class,
    image: ImageId,
    spec: PictureSpec,
) -> Result<Response, Problem> {
    let name = spec.name(&image);
    if let Some(answer) = respond::precondition_response(context, Some(&respond::tag(&name))) {
        return answer;
    }
    let shown = match respond::kept(service, &image, &spec).await {
        Some(made) => respond::cached(made),
        None => respond::make(service, context.tenant, class, Source::Known(image), spec).await?,
    };
    respond::deliver(service, context, &shown, &spec)
}

/// Where an image stays in a format, as long as its scene is known.
pub(crate) fn place_of(image: &str, format: FileFormat) -> String {
    let parameters = match format {
        FileFormat::Png16 => "?bits=16".into(),
        FileFormat::Jpeg(quality) if quality != DEFAULT_QUALITY => format!("?quality={quality}"),
        _ => String::new(),
    };
    format!("/v1/images/{image}.{}{parameters}", format.names().0)
}

/// The image and the format that a file's name says.
fn file_name(file: &str) -> Result<(ImageId, PictureFormat), Problem> {
    let (id, ending) = file.rsplit_once('.').unwrap_or((file, ""));
    let format = PictureFormat::by_name(ending).ok_or_else(|| {
        let endings = PictureFormat::ALL.map(|format| format!(".{}", format.names().0));
        Problem::new(Kind::NotFound, format!("{file} has none of the endings {}", endings.join(", ")))
    })?;
    Ok((image_id(id)?, format))
}

/// The image that a path names.
pub(crate) fn image_id(text: &str) -> Result<ImageId, Problem> {
    ImageId::read(text).ok_or_else(|| {
        let detail = format!(
            "{text} is no image of this version of the renderer: POST /v1/render and POST /v1/scenes say a scene's image_id"
        );
        Problem::new(Kind::NotFound, detail)
    })
}
