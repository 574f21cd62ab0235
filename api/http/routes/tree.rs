//! `POST /v1/tree`: every ray of one pixel.

use crate::http::prelude::*;
use crate::http::respond::{Answer, body};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::pictures::spec::outside;
use axum::body::Body as AxumBody;
use futures_util::stream;
use std::convert::Infallible;
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::{TREE_BYTES, Tree, trace_pixel_while};

/// Bytes of a text that is sent as a whole.
const AT_ONCE: usize = 1 << 20;
/// Media type of Graphviz.
const GRAPHVIZ: &str = "text/vnd.graphviz";
/// Media type of drawings.
const SVG: &str = "image/svg+xml";

pub(super) fn routes() -> Vec<Route> {
    let contents = [Content::json::<Tree>(), Content::text(GRAPHVIZ), Content::text(SVG)];
    vec![
        Route::post("/v1/tree", tree, ["tree", "render", "Every ray of one pixel."])
            .query(pixel_and_format)
            .about_scene()
            .answer(200, "The tree of rays", &contents),
    ]
}

async fn tree(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(pixel_and_format(query)), answer).await
}

fn pixel_and_format(query: &mut Query) -> ([u32; 2], TreeFormat) {
    (query.pixel(), query.word("format", "How the tree is written.").unwrap_or_default())
}

fn answer(
    Question { app, work, sent }: Question<'_>,
    ([x, y], format): ([u32; 2], TreeFormat),
) -> Result<Answer, Problem> {
    let ready = app.service.scenes.find(&work.workers, sent)?.ready;
    let scene = &ready.scene;
    if x >= scene.width || y >= scene.height {
        return Err(outside(&format!("the pixel x={x}, y={y}"), scene.width, scene.height).into());
    }
    let mut share = app.service.memory.share(ready.bytes());
    share.grow(TREE_BYTES as u64)?;
    let traced = work.workers.work(|| trace_pixel_while(scene, x, y, &work.control));
    let tree = traced.and_then(|tree| tree).map_err(Error::from)?;
    let media_type = match format {
        TreeFormat::Json => "application/json",
        TreeFormat::Dot => GRAPHVIZ,
        TreeFormat::Svg => SVG,
    };
    share.shrink(tree.bytes() as u64);
    let mut parts = tree.parts(format);
    let (mut begin, mut ended) = (String::new(), false);
    while !ended && begin.len() < AT_ONCE {
        let part = parts.next();
        ended = part.is_none();
        begin += &part.unwrap_or_default();
    }
    if ended {
        return Ok((media_type, body(app.service.memory.metered(begin.into_bytes())?)));
    }
    // Written as the client reads it: the text of a tree may be any number of times as long as that of its scene.
    let rest = std::iter::once(begin).chain(parts).map(move |part| {
        let _ = &share;
        Ok::<_, Infallible>(part)
    });
    Ok((media_type, AxumBody::from_stream(stream::iter(rest))))
}
