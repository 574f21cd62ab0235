//! `GET /v1/images/{image}`: the picture of an image id, which never changes.

use crate::http::prelude::*;
use crate::http::respond::image::{answer, image_id};
use crate::http::respond::picture::{Freshness, ResponseContext};
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::ids::ImageId;
use crate::service::scheduler::task::Class;
use strahl::film::PictureFormat;

pub(super) fn routes() -> Vec<Route> {
    let about = "The picture of an image id, in the format of its ending. It is rendered again if need be, as long as its \
                 scene is known.";
    vec![
        Route::get("/v1/images/{image}", image, ["image", "pictures", about])
            .needs(Scope::Read)
            .path("image", "The image's id and an ending: `.png`, `.jpg`, `.webp`, `.exr` or `.pfm`.")
            .query(Query::details)
            .picture()
            .answer(304, "The client has it", &[]),
    ]
}

async fn image(State(app): State<App>, Path(file): Path<String>, request: Request) -> Result<Response, Problem> {
    let (image, format) = file_name(&file)?;
    let mut query = Query::of(request.uri())?;
    let details = query.details();
    let spec = PictureSpec::plain(None, query.with_details(format, details));
    query.finish()?;
    let tenant = Tenant::of(request.extensions());
    let context = ResponseContext {
        method: request.method(),
        headers: request.headers(),
        tenant: &tenant,
        freshness: Freshness::Immutable,
        negotiated: false,
    };
    answer(&app, &context, tenant.task(Class::Renders), image, spec).await
}

/// The image id and the format in a file's name.
fn file_name(file: &str) -> Result<(ImageId, PictureFormat), Problem> {
    let (id, ending) = file.rsplit_once('.').unwrap_or((file, ""));
    let format = PictureFormat::by_name(ending).ok_or_else(|| {
        let endings = PictureFormat::ALL.map(|format| format!(".{}", format.names().0));
        Problem::new(Kind::NotFound, format!("{file} has none of the endings {}", endings.join(", ")))
    })?;
    Ok((image_id(id)?, format))
}
