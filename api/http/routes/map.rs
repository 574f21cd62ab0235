//! `POST /v1/map`: what is proved of each pixel, or the rays, time or depth of each, as a picture.

use crate::http::prelude::*;
use crate::http::respond::{Answer, body};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::pictures::map::{self, MapFormat};
use crate::service::pictures::render;
use strahl::film::{PictureFormat, Region};
use strahl::inspect::maps::MapKind;

pub(super) fn routes() -> Vec<Route> {
    let about = "A map of the picture.\n\n`rays`, `time` and `depth` trace each pixel alone, which takes several times as \
                 long as the picture.";
    let contents = [PictureFormat::Png, PictureFormat::Pfm, PictureFormat::Exr].map(|of| Content::file(of.names().1));
    vec![Route::post("/v1/map", map, ["map", "render", about]).query(kind_and_format).about_scene().answer(
        200,
        "The map: in colors with a scale below, or the numbers as floats",
        &contents,
    )]
}

async fn map(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(kind_and_format(query)), answer).await
}

fn kind_and_format(query: &mut Query) -> (MapKind, MapFormat) {
    let of = "What is proved of each pixel, in 8-bit codes; the rays of each; nanoseconds of each, traced alone; rays in the \
              longest chain of each. Default `proved`.";
    let format = "PNG with a scale, or the numbers. Default `png`.";
    (query.word("of", of).unwrap_or_default(), query.word("format", format).unwrap_or_default())
}

fn answer(Question { app, work, sent }: Question<'_>, (kind, format): (MapKind, MapFormat)) -> Result<Answer, Problem> {
    let limits = &app.service.settings.answers;
    let ready = app.service.scenes.find_if(&work.workers, sent, |scene| limits.check_unbuilt(scene, None))?.ready;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    limits.check(region, ready.scene.samples)?;
    let each = if kind == MapKind::Proved { render::PIXEL_BYTES } else { render::MEASURED_PIXEL_BYTES };
    let share = app.service.room_for_picture(&ready, region.pixels(), each)?;
    let bytes = map::draw(&ready.scene, region, kind, format, &work.workers, &work.control).map_err(Error::from)?;
    let format = match format {
        MapFormat::Png => PictureFormat::Png,
        MapFormat::Pfm => PictureFormat::Pfm,
        MapFormat::Exr => PictureFormat::Exr,
    };
    drop(share);
    Ok((format.names().1, body(app.service.memory.metered(bytes)?)))
}
