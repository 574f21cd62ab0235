//! `POST /v1/tree`: every ray of one pixel.

use crate::http::prelude::*;
use crate::http::respond::{Answer, to_json};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::pictures::spec::outside;
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::{Tree, trace_pixel_while};

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
    let traced = work.workers.work(|| trace_pixel_while(scene, x, y, &work.control));
    let tree = traced.and_then(|tree| tree).map_err(Error::from)?;
    match format {
        TreeFormat::Json => to_json(&tree),
        TreeFormat::Dot => Ok((GRAPHVIZ, tree.to_dot().into_bytes())),
        TreeFormat::Svg => Ok((SVG, tree.to_svg().into_bytes())),
    }
}
