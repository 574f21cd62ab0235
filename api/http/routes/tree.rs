//! `POST /v1/tree`: every ray of one pixel, as data, as a drawing, or drawn into the picture.

use crate::http::prelude::*;
use crate::http::respond::{Answer, body};
use crate::http::scene_job::{Question, ask, ask_image};
use crate::http::state::AppState;
use crate::service::error::Error;
use crate::service::memory_budget::Share;
use crate::service::pictures::overlay::{self, OverlaySpec};
use crate::service::pictures::render;
use crate::service::pictures::spec::outside;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::SentScene;
use crate::service::scheduler::admission::Work;
use axum::body::Body as AxumBody;
use futures_util::stream;
use std::convert::Infallible;
use std::sync::Arc;
use strahl::film::Region;
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::{TREE_BYTES, Tree, trace_pixel_while};
use strahl::scene::{Description, Overrides};

/// Bytes of a text that is sent as a whole.
const AT_ONCE: usize = 1 << 20;
/// Media type of Graphviz.
const GRAPHVIZ: &str = "text/vnd.graphviz";
/// Media type of drawings.
const SVG: &str = "image/svg+xml";

pub(super) fn routes() -> Vec<Route> {
    let contents = [Content::json::<Tree>(), Content::text(GRAPHVIZ), Content::text(SVG)];
    let about = "Every ray of one pixel.\n\n`overlay` draws them into the picture, from the scene's camera or from another one.";
    let about_image = "Every ray of one pixel of a known image, in the pixels of its zoom.";
    vec![
        Route::post("/v1/tree", tree, ["tree", "render", about])
            .query(parameters)
            .about_scene()
            .answer(200, "The tree of rays", &contents)
            .warns(),
        Route::get("/v1/images/{image}/tree", of_image, ["imageTree", "pictures", about_image])
            .needs(Scope::Read)
            .path("image", "An image id.")
            .query(parameters_of_image)
            .answer(200, "The tree of rays", &contents)
            .warns(),
    ]
}

async fn of_image(State(app): State<App>, Path(image): Path<String>, request: Request) -> Result<Response, Problem> {
    let answer = |app: &AppState, work: &Work, ready: &Arc<PreparedScene>, (pixel, format, all): ([u32; 2], _, _)| {
        Ok(written(app, traced(app, work, ready, pixel)?, format, all)?.warning(&ready.scene.warnings))
    };
    ask_image(app, image, request, parameters_of_image, answer).await
}

fn parameters_of_image(query: &mut Query) -> ([u32; 2], TreeFormat, bool) {
    let (pixel, format, OverlaySpec { seen_from, all_samples, .. }) = parameters(query);
    if format == TreeFormat::Overlay || seen_from.is_some() {
        query.wrong("format", "unsupported", "overlays are of scenes: POST /v1/tree".into());
    }
    (pixel, format, all_samples)
}

async fn tree(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(parameters(query)), answer).await
}

fn parameters(query: &mut Query) -> ([u32; 2], TreeFormat, OverlaySpec) {
    let pixel = query.pixel();
    let format = query.word("format", "How the tree is written.").unwrap_or_default();
    let seen_from = query.viewpoint();
    let picture = query.flag("picture", "Whether an overlay has the rendered picture. Default true.");
    let all = "Whether drawings show the rays of all samples, not of the first one alone. Default false.";
    let all_samples = query.flag("all_samples", all).unwrap_or(false);
    if format != TreeFormat::Overlay {
        for (name, is_given) in [("from", seen_from.is_some()), ("picture", picture.is_some())] {
            if is_given {
                query.wrong(name, "unsupported", "it is for format=overlay".into());
            }
        }
    }
    (pixel, format, OverlaySpec { seen_from, picture: picture.unwrap_or(true), all_samples })
}

fn answer(
    Question { app, work, sent, .. }: Question<'_>,
    (pixel, format, spec): ([u32; 2], TreeFormat, OverlaySpec),
) -> Result<Answer, Problem> {
    let ready = app.service.scenes.find(&work.workers, sent)?.ready;
    let (tree, share) = traced(app, work, &ready, pixel)?;
    if format == TreeFormat::Overlay {
        let drawing = overlay(app, work, sent, &ready, tree, spec)?;
        let drawing = body(app.service.memory.metered(drawing.into_bytes())?);
        return Ok(Answer::new(SVG, drawing).warning(&ready.scene.warnings));
    }
    Ok(written(app, (tree, share), format, spec.all_samples)?.warning(&ready.scene.warnings))
}

/// The tree of a pixel, and its memory.
fn traced(app: &AppState, work: &Work, ready: &PreparedScene, [x, y]: [u32; 2]) -> Result<(Tree, Share), Problem> {
    let scene = &ready.scene;
    if x >= scene.width || y >= scene.height {
        return Err(outside(&format!("the pixel x={x}, y={y}"), scene.width, scene.height).into());
    }
    let mut share = app.service.memory.share(ready.bytes());
    share.grow(TREE_BYTES as u64)?;
    let traced = work.workers.work(|| trace_pixel_while(scene, x, y, &work.control));
    Ok((traced.and_then(|tree| tree).map_err(Error::from)?, share))
}

/// A tree as a text.
fn written(
    app: &AppState,
    (tree, mut share): (Tree, Share),
    format: TreeFormat,
    all_samples: bool,
) -> Result<Answer, Problem> {
    let media_type = match format {
        TreeFormat::Json => "application/json",
        TreeFormat::Dot => GRAPHVIZ,
        TreeFormat::Svg | TreeFormat::Overlay => SVG,
    };
    share.shrink(tree.bytes() as u64);
    let mut parts = tree.parts(format, all_samples);
    let (mut begin, mut ended) = (String::new(), false);
    while !ended && begin.len() < AT_ONCE {
        let part = parts.next();
        ended = part.is_none();
        begin += &part.unwrap_or_default();
    }
    if ended {
        return Ok(Answer::new(media_type, body(app.service.memory.metered(begin.into_bytes())?)));
    }
    // Written as the client reads it: the text of a tree may be any number of times as long as that of its scene.
    let rest = std::iter::once(begin).chain(parts).map(move |part| {
        let _ = &share;
        Ok::<_, Infallible>(part)
    });
    Ok(Answer::new(media_type, AxumBody::from_stream(stream::iter(rest))))
}

/// Draws into the picture, which needs as much room as any picture.
fn overlay(
    app: &AppState,
    work: &Work,
    sent: &SentScene<'_>,
    ready: &Arc<PreparedScene>,
    tree: Tree,
    spec: OverlaySpec,
) -> Result<String, Problem> {
    let limits = &app.service.settings.answers;
    let other = match spec.seen_from {
        Some(_) => {
            let overrides = Overrides { seen_from: spec.seen_from, ..sent.overrides };
            let other = SentScene::new(sent.text, sent.form, &overrides);
            let accept = |scene: &Description| limits.check_unbuilt(scene, None);
            Some(app.service.scenes.find_if(&work.workers, &other, &accept)?.ready)
        }
        None => None,
    };
    let seen_by = other.as_ref().unwrap_or(ready);
    let region = Region::whole(seen_by.scene.width, seen_by.scene.height);
    let share = if spec.picture {
        limits.check(region, seen_by.scene.samples)?;
        app.service.room_for_picture(seen_by, region.pixels(), render::PIXEL_BYTES + overlay::PIXEL_BYTES)?
    } else {
        app.service.memory.share(seen_by.bytes())
    };
    let seen_from = other.as_ref().map(|ready| &ready.scene);
    let drawing = overlay::draw(tree, &ready.scene, seen_from, spec, &work.workers, &work.control);
    drop(share);
    Ok(drawing.map_err(Error::from)?)
}
