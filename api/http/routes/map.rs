//! `POST /v1/map`: what is proved of each pixel, or what each of them takes, as a picture.

use super::explain::ask;
use super::render::{find, gone};
use crate::http::contract::bodies::Bytes;
use crate::http::contract::generated::Scene;
use crate::http::contract::queries;
use crate::http::extract::query::Parameters;
use crate::http::problem::Problem;
use crate::http::{App, Service};
use crate::service::pictures::map;
use crate::service::pictures::map::MapFormat;
use crate::service::scheduler::admission::Work;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use strahl::film::Region;
use strahl::inspect::maps::MapKind;
use strahl::scene::{Format, Overrides};

/// A map of the picture.
///
/// `rays`, `time` and `depth` trace each pixel alone, which takes several times as long as the picture.
#[utoipa::path(
    post, path = "/v1/map", operation_id = "map", tag = "render",
    params(queries::MapOf, queries::Settings),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((Scene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, description = "The map: in colors with a scale below, or the numbers as floats", content(
        (Bytes = "image/png"), (Bytes = "image/x-portable-floatmap"), (Bytes = "image/x-exr")
    ))),
)]
pub(crate) async fn map(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let answer =
        |service: &Service, job: &Work, bytes: &[u8], format: Format, overrides: &Overrides, (kind, file): (_, _)| {
            let ready = find(service, job, bytes, format, overrides)?.ready;
            let region = Region::whole(ready.scene.width, ready.scene.height);
            service.limits.check(&ready.scene, region)?;
            let bytes = map::draw(&ready.scene, region, kind, file, &job.workers, &job.control).map_err(|_| gone())?;
            let media_type = match file {
                MapFormat::Png => "image/png",
                MapFormat::Pfm => "image/x-portable-floatmap",
                MapFormat::Exr => "image/x-exr",
            };
            Ok((media_type, bytes))
        };
    ask(service, request, kind_and_format, answer).await
}

fn kind_and_format(parameters: &mut Parameters, _: &HeaderMap) -> Result<(MapKind, MapFormat), Problem> {
    Ok((parameters.word("of").unwrap_or_default(), parameters.word("format").unwrap_or_default()))
}
