//! `POST /v1/map`: a number for each pixel: what is proved of it, what it took, or what is seen in it.

use crate::http::prelude::*;
use crate::http::respond::{Answer, body, to_json};
use crate::http::scene_job::{Question, ask, ask_image};
use crate::http::state::AppState;
use crate::service::error::Error;
use crate::service::pictures::map::{self, COARSEST, MapFormat};
use crate::service::pictures::render;
use crate::service::pictures::seen::{Looked, ObjectMap, runs};
use crate::service::pictures::spec::outside;
use crate::service::requests::Service;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::admission::Work;
use strahl::film::{FileFormat, Film, PictureFormat, Region, encode, encode_gray};
use strahl::inspect::maps::MapKind;
use strahl::render::Layers;
use strahl::scene::Description;

pub(super) fn routes() -> Vec<Route> {
    let about = "A map of the picture: a number for each pixel.\n\nMost take about as long as the picture; `step=8` shows in \
                 about a tenth of the time what the whole map will look like. Those of objects and distances take one ray \
                 a pixel.";
    let contents = [PictureFormat::Png, PictureFormat::Pfm, PictureFormat::Exr].map(|of| Content::file(of.names().1));
    let contents = [&contents[..], &[Content::json::<ObjectMap>()]].concat();
    let about_answer = "The map: in colors with a scale below, or the numbers as floats, or who is seen";
    let about_image = "A map of a known image, in the pixels of its zoom.";
    vec![
        Route::post("/v1/map", map, ["map", "render", about])
            .query(asked)
            .about_scene()
            .answer(200, about_answer, &contents)
            .warns(),
        Route::get("/v1/images/{image}/map", of_image, ["imageMap", "pictures", about_image])
            .needs(Scope::Read)
            .path("image", "An image id.")
            .query(asked)
            .answer(200, about_answer, &contents)
            .warns(),
    ]
}

/// What a map shows of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Quantity {
    /// Codes that it is off at most.
    #[default]
    Proved,
    /// Rays of all kinds.
    Rays,
    /// Nanoseconds.
    Time,
    /// Rays in the longest chain.
    Depth,
    /// Samples.
    Samples,
    /// How far away what is seen through its middle is.
    Distance,
    /// Whose surface that is.
    Object,
    /// How much of it comes from an object, also by mirrors and through bodies.
    Share,
}

/// How a map is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Format {
    Png,
    Pfm,
    Exr,
    Json,
}

/// What is asked of a map.
struct Asked {
    of: Quantity,
    format: Format,
    step: u32,
    /// Of maps of what is seen.
    part: Option<Region>,
    /// The object whose share is asked for.
    share: Layers,
}

async fn map(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(asked(query)), answer).await
}

async fn of_image(State(app): State<App>, Path(image): Path<String>, request: Request) -> Result<Response, Problem> {
    let answer = |app: &AppState, work: &Work, ready: &Arc<PreparedScene>, asked| {
        Ok(drawn(app, work, ready, &asked)?.warning(&ready.scene.warnings))
    };
    ask_image(app, image, request, asked, answer).await
}

fn asked(query: &mut Query) -> Asked {
    let of = "What is proved of each pixel, in 8-bit codes; the rays of each; nanoseconds of each; rays in the longest chain of \
              each; the samples of each; how far away what is seen there is; whose surface it is; how much of it comes from \
              the object of `pointer`. Default `proved`.";
    let format = "PNG with a scale, for those that have one; the numbers as one-channel PFM or as EXR; for `of=object` JSON \
                  with pointers. The default is the first of these that there is.";
    let step = "A coarse map: one pixel is traced for each block of so many across and down, up to 64. Default 1.";
    let pointer = "For `of=share`: the object, such as `/objects/3`.";
    let of = query.word("of", of).unwrap_or_default();
    let is_known = !query.is_refused("of");
    let is_seen = matches!(of, Quantity::Distance | Quantity::Object | Quantity::Share);
    let usual = match of {
        Quantity::Object => Format::Json,
        _ if is_seen => Format::Pfm,
        _ => Format::Png,
    };
    let format = query.word("format", format).unwrap_or(usual);
    let formats = match of {
        Quantity::Object => "json, pfm or exr",
        _ if is_seen => "pfm or exr",
        _ => "png, pfm or exr",
    };
    if is_known && ((format == Format::Json && of != Quantity::Object) || (format == Format::Png && is_seen)) {
        query.wrong("format", "out-of-range", format!("expected {formats} for this map"));
    }
    let step = query.count("step", step, COARSEST).unwrap_or(1);
    let part = query.part();
    if part.is_some() && !is_seen {
        query.wrong("x", "out-of-range", "parts are of maps of distance, object and share".into());
    }
    let pointer = query.text("pointer", pointer);
    let share = match (of, pointer) {
        (Quantity::Share, pointer) => format!("share:{}", pointer.unwrap_or_default()).parse().map_err(|_| {
            let detail = "of=share needs an object: pointer=/objects/3 is the fourth of the scene's objects";
            query.wrong("pointer", "out-of-range", detail.into());
        }),
        (_, Some(_)) => {
            query.wrong("pointer", "out-of-range", "it goes with of=share".into());
            Err(())
        }
        (_, None) => Err(()),
    };
    Asked { of, format, step, part, share: share.unwrap_or_default() }
}

fn answer(Question { app, work, sent, .. }: Question<'_>, asked: Asked) -> Result<Answer, Problem> {
    let limits = &app.service.settings.answers;
    let accept = |scene: &Description| limits.check_unbuilt(scene, asked.part);
    let ready = app.service.scenes.find_if(&work.workers, sent, &accept)?.ready;
    Ok(drawn(app, work, &ready, &asked)?.warning(&ready.scene.warnings))
}

/// A map of the picture of a scene.
fn drawn(app: &AppState, work: &Work, ready: &PreparedScene, asked: &Asked) -> Result<Answer, Problem> {
    let kind = match asked.of {
        Quantity::Proved => MapKind::Proved,
        Quantity::Rays => MapKind::Rays,
        Quantity::Time => MapKind::Time,
        Quantity::Depth => MapKind::Depth,
        Quantity::Samples => MapKind::Samples,
        Quantity::Distance | Quantity::Object | Quantity::Share => return seen(&app.service, work, ready, asked),
    };
    let &Asked { format, step, .. } = asked;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    app.service.settings.answers.check(region, ready.scene.samples)?;
    let is_plain = kind == MapKind::Proved && step == 1;
    let each = if is_plain { render::PIXEL_BYTES } else { render::MEASURED_PIXEL_BYTES };
    let share = app.service.room_for_picture(ready, region.pixels(), each)?;
    let (format, written) = match format {
        Format::Exr => (PictureFormat::Exr, MapFormat::Exr),
        Format::Pfm => (PictureFormat::Pfm, MapFormat::Pfm),
        Format::Png | Format::Json => (PictureFormat::Png, MapFormat::Png),
    };
    let bytes = map::draw(&ready.scene, step, kind, written, &work.workers, &work.control).map_err(Error::from)?;
    drop(share);
    Ok(Answer::new(format.names().1, body(app.service.memory.metered(bytes)?)))
}

/// A map of what is seen.
fn seen(service: &Service, work: &Work, ready: &PreparedScene, asked: &Asked) -> Result<Answer, Problem> {
    let scene = &ready.scene;
    let region = asked.part.unwrap_or_else(|| Region::whole(scene.width, scene.height));
    if !region.fits(scene.width, scene.height) {
        let Region { x, y, width, height } = region;
        let what = format!("the part x={x}, y={y}, w={width}, h={height}");
        return Err(outside(&what, scene.width, scene.height).into());
    }
    service.settings.answers.check(region, 1)?;
    asked.share.check(scene).map_err(Error::OutOfRange)?;
    let looked = Looked { region, step: asked.step };
    let [columns, rows] = looked.size();
    let pixels = u64::from(columns) * u64::from(rows);
    let mut room = service.room_for_picture(ready, pixels, render::MEASURED_PIXEL_BYTES)?;
    if asked.of == Quantity::Share {
        // A copy of the items, of which the object's shine.
        room.grow(room.bytes() + ready.bytes())?;
    }
    let (workers, control) = (&work.workers, &work.control);
    let numbers = match asked.of {
        Quantity::Object => {
            let (objects, numbers) = looked.objects(scene, workers, control).map_err(Error::from)?;
            if asked.format == Format::Json {
                let Region { x, y, width: w, height: h } = region;
                let runs = runs(&numbers);
                let map = ObjectMap { x, y, w, h, step: asked.step, columns, rows, objects, runs };
                return to_json(&service.memory, &map);
            }
            numbers.into_iter().map(|number| number as f32).collect()
        }
        Quantity::Share => looked.numbers(scene, asked.share, workers, control).map_err(Error::from)?,
        _ => {
            let distance: Layers = "distance".parse().unwrap_or_default();
            looked.numbers(scene, distance, workers, control).map_err(Error::from)?
        }
    };
    let (format, bytes) = if asked.format == Format::Exr {
        let pixels = numbers.iter().map(|number| [*number; 3]).collect();
        let region = Region::whole(columns, rows);
        let film = Film { region, full_width: columns, full_height: rows, pixels, ..Film::default() };
        (PictureFormat::Exr, encode(&film, FileFormat::Exr))
    } else {
        (PictureFormat::Pfm, encode_gray(columns, rows, &numbers))
    };
    drop(room);
    Ok(Answer::new(format.names().1, body(service.memory.metered(bytes)?)))
}
