//! `POST /v1/map`: what is proved of each pixel, or the rays, time or depth of each, as a picture.

use crate::http::prelude::*;
use crate::http::respond::{Answer, body};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::pictures::map::{self, COARSEST, MapFormat};
use crate::service::pictures::render;
use strahl::film::{PictureFormat, Region};
use strahl::inspect::maps::MapKind;

pub(super) fn routes() -> Vec<Route> {
    let about = "A map of the picture, which takes about as long as the picture. `step=8` shows in about a tenth of the \
                 time what the whole map will look like.";
    let contents = [PictureFormat::Png, PictureFormat::Pfm, PictureFormat::Exr].map(|of| Content::file(of.names().1));
    vec![Route::post("/v1/map", map, ["map", "render", about]).query(asked).about_scene().answer(
        200,
        "The map: in colors with a scale below, or the numbers as floats",
        &contents,
    )]
}

/// What is asked of a map.
struct Asked {
    kind: MapKind,
    format: MapFormat,
    step: u32,
}

async fn map(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(asked(query)), answer).await
}

fn asked(query: &mut Query) -> Asked {
    let of = "What is proved of each pixel, in 8-bit codes; the rays of each; nanoseconds of each; rays in the \
              longest chain of each. Default `proved`.";
    let format = "PNG with a scale, or the numbers. Default `png`.";
    let step = "A coarse map: one pixel is traced for each block of so many across and down, up to 64. Default 1.";
    Asked {
        kind: query.word("of", of).unwrap_or_default(),
        format: query.word("format", format).unwrap_or_default(),
        step: query.count("step", step, COARSEST).unwrap_or(1),
    }
}

fn answer(Question { app, work, sent }: Question<'_>, Asked { kind, format, step }: Asked) -> Result<Answer, Problem> {
    let limits = &app.service.settings.answers;
    let ready = app.service.scenes.find_if(&work.workers, sent, |scene| limits.check_unbuilt(scene, None))?.ready;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    limits.check(region, ready.scene.samples)?;
    let is_plain = kind == MapKind::Proved && step == 1;
    let each = if is_plain { render::PIXEL_BYTES } else { render::MEASURED_PIXEL_BYTES };
    let share = app.service.room_for_picture(&ready, region.pixels(), each)?;
    let bytes = map::draw(&ready.scene, step, kind, format, &work.workers, &work.control).map_err(Error::from)?;
    let format = match format {
        MapFormat::Png => PictureFormat::Png,
        MapFormat::Pfm => PictureFormat::Pfm,
        MapFormat::Exr => PictureFormat::Exr,
    };
    drop(share);
    Ok((format.names().1, body(app.service.memory.metered(bytes)?)))
}
