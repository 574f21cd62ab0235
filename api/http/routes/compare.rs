//! `POST /v1/compare`: how far two pictures are from each other.

use crate::http::contract::{example_scene, scene_reference};
use crate::http::extract::body_part::BodyPart;
use crate::http::extract::bounded::SettingsObject;
use crate::http::extract::variation::form_of;
use crate::http::extract::{body, json_body};
use crate::http::prelude::*;
use crate::http::respond::image::image_id;
use crate::http::respond::{body as bytes_of, put_warnings};
use crate::http::state::AppState;
use crate::service::pictures::file::PictureFile;
use crate::service::pictures::spec::PictureSpec;
use crate::service::pictures::warnings;
use crate::service::requests::compare::{Compared, Drawn, size_of};
use crate::service::requests::pictures::{Source, Upload, image_of};
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::sent_scene::Form as SceneForm;
use crate::service::scheduler::task::Class;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::json;
use serde_json::value::RawValue;
use strahl::film::FileFormat;
use strahl::metrics::{CodeErrors, Spread};
use strahl::scene::{Format, Overrides};

/// Largest gain of a drawn difference.
const MOST_GAIN: u32 = 255;
/// Usual gain.
const GAIN: u32 = 16;

pub(super) fn routes() -> Vec<Route> {
    let about = "How far two pictures are from each other.\n\nEach is an image id, or a scene with settings. The answer has \
                 errors in 8-bit codes and as people see them, or it is a picture of the difference: with `format=png` \
                 the codes times `gain`, with `pfm` the light of b less that of a, with `flip` FLIP as a one-channel PFM.";
    let ball = json!({ "scene": example_scene(), "settings": { "antialias": false } });
    let example = json!({ "a": ball, "b": { "scene": example_scene() } });
    vec![
        Route::post("/v1/compare", compare, ["compare", "render", about])
            .needs(Scope::Render)
            .query(drawn)
            .body(Body::json::<CompareRequest<'_>>("The pictures").example(example))
            .answer(
                200,
                "The errors, or a picture of the difference",
                &[
                    Content::json::<Difference>(),
                    Content::file("image/png"),
                    Content::file("image/x-portable-floatmap"),
                ],
            )
            .warns(),
    ]
}

/// Two pictures.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CompareRequest<'a> {
    /// The one that is compared with, as a reference is.
    #[serde(borrow)]
    a: CompareSide<'a>,
    /// The other.
    #[serde(borrow)]
    b: CompareSide<'a>,
}

/// An image id, or a scene with settings.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CompareSide<'a> {
    /// An image id.
    image: Option<String>,
    /// A scene.
    #[serde(borrow, default)]
    #[schemars(schema_with = "scene_reference")]
    scene: Option<&'a RawValue>,
    /// Settings that replace the scene's, by the names of the query parameters of `POST /v1/render`.
    #[serde(default)]
    #[schemars(schema_with = "overrides")]
    settings: SettingsObject,
}

fn overrides(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "$ref": "#/components/schemas/Overrides" })
}

/// How far two pictures are from each other.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "PictureDifference")]
struct Difference {
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Whether all codes are the same.
    same: bool,
    /// In 8-bit codes of the worst channel.
    codes: CodeErrors,
    /// Square root of the mean square over all channels, in codes.
    rms_codes: f64,
    /// FLIP, 0 to 1, with `a` as the reference. Null for pictures of more than 4,194,304 pixels.
    flip: Option<Spread>,
    /// CIEDE2000; 1 is just visible. Null likewise.
    ciede2000: Option<Spread>,
    /// The id of `a`, if it has one.
    a: Option<String>,
    /// The id of `b`.
    b: Option<String>,
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Form {
    Json,
    Png,
    Pfm,
    Flip,
}

fn drawn(query: &mut Query) -> Option<Drawn> {
    let form = query.word("format", "Numbers, or a picture of the difference. Default `json`.");
    let gain = query.count("gain", "For `png`: what the codes are multiplied by. Default 16.", MOST_GAIN);
    match form {
        None | Some(Form::Json) => None,
        Some(Form::Png) => Some(Drawn::Codes(gain.unwrap_or(GAIN))),
        Some(Form::Pfm) => Some(Drawn::Light),
        Some(Form::Flip) => Some(Drawn::Flip),
    }
}

async fn compare(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    let checked = app.drain.accepts_work().and_then(|()| {
        let drawn = Query::read(&parts.uri, drawn)?;
        body::declares_json(&parts.headers).map(|declared| (drawn, declared))
    });
    let (drawn, declared) = match checked {
        Ok(checked) => checked,
        Err(problem) => {
            body::discard(&app, &parts.headers, body).await;
            return Err(problem);
        }
    };
    let text = body::read(&app, &tenant, &parts.headers, body).await?;
    body::check_content(declared, text.as_ref())?;
    let (app_of, sender) = (Arc::clone(&app), Arc::clone(&tenant));
    let wanted =
        app.service.storage_threads.run(&tenant.name, move || both_of(&app_of, &sender, text.as_ref())).await??;
    let ([a, b], size) = files(&app, &tenant, wanted, drawn).await?;
    let task = tenant.task(Class::Renders);
    let ids = [&a, &b].map(|file| file.meta.image.clone());
    let mut headers = HeaderMap::new();
    let warnings = warnings::together([&a, &b].into_iter().filter_map(|file| file.meta.warnings()));
    put_warnings(&mut headers, warnings.as_deref());
    if let Some(drawn) = drawn {
        let bytes = app.service.draw_difference(task, [a, b], size, drawn).await?;
        let media_type = if matches!(drawn, Drawn::Codes(_)) { "image/png" } else { "image/x-portable-floatmap" };
        let bytes = bytes_of(app.service.memory.metered(bytes)?);
        return Ok((headers, [(header::CONTENT_TYPE, media_type)], bytes).into_response());
    }
    let Compared { codes, seen } = app.service.compare(task, [a, b], size).await?;
    let rms_codes = codes.psnr.map_or(0.0, |psnr| 255.0 / strahl::math::pow(10.0, psnr / 20.0));
    let (flip, ciede2000) = seen.map_or((None, None), |[flip, ciede2000]| (Some(flip), Some(ciede2000)));
    let ([width, height], [a, b]) = (size, ids);
    let same = codes.error.max == 0.0;
    let difference = Difference { width, height, same, codes, rms_codes, flip, ciede2000, a, b };
    Ok((headers, Json(difference)).into_response())
}

/// The pictures and their size. Nothing is rendered if they cannot be compared.
async fn files(
    app: &App,
    tenant: &Tenant,
    [a, b]: [Wanted; 2],
    drawn: Option<Drawn>,
) -> Result<([Arc<PictureFile>; 2], [u32; 2]), Problem> {
    let spec = PictureSpec::plain(None, drawn.map_or(FileFormat::Png8, Drawn::source));
    let (a, b) = (a.sought(app, tenant, &spec).await?, b.sought(app, tenant, &spec).await?);
    let size = app.service.check_comparison([a.size, b.size], drawn)?;
    Ok(([a.file(app, tenant, spec).await?, b.file(app, tenant, spec).await?], size))
}

/// A picture that is wanted.
struct Wanted {
    source: WantedSource,
    overrides: Overrides,
    /// Where its scene is in the body.
    part: BodyPart,
}

enum WantedSource {
    Image(ImageId),
    Scene(SceneForm, Vec<u8>),
}

/// What the body asks for.
fn both_of(app: &AppState, tenant: &Tenant, body: &[u8]) -> Result<[Wanted; 2], Problem> {
    let side = r#"{"image": "<id>"} or {"scene": {...}, "settings": {...}}"#;
    let CompareRequest { a, b } =
        json_body::read(body, &format!(r#"the body is {{"a": ..., "b": ...}}, each {side}"#))?;
    Ok([wanted(app, tenant, body, "a", a)?, wanted(app, tenant, body, "b", b)?])
}

fn wanted(app: &AppState, tenant: &Tenant, body: &[u8], name: &str, side: CompareSide<'_>) -> Result<Wanted, Problem> {
    let mut query = Query::given(side.settings.0.clone(), format!("/{name}/settings"));
    let overrides = query.settings(Format::Json);
    query.finish()?;
    let (source, part) = match (side.image, side.scene) {
        (Some(image), None) if side.settings.0.is_empty() => {
            (WantedSource::Image(image_id(&image)?), BodyPart::default())
        }
        (None, Some(scene)) => {
            let (form, text) = form_of(&app.service, tenant, scene.get().as_bytes())?;
            let part = BodyPart::of(body, format!("/{name}/scene"), scene);
            (WantedSource::Scene(form, text.to_vec()), part)
        }
        _ => {
            let detail =
                format!("/{name}: write {{\"image\": \"<id>\"}}, or {{\"scene\": {{...}}, \"settings\": {{...}}}}");
            return Err(Problem::new(Kind::InvalidRequest, detail));
        }
    };
    Ok(Wanted { source, overrides, part })
}

/// A picture whose size is known.
struct Sought {
    size: [u32; 2],
    picture: Picture,
}

#[expect(clippy::large_enum_variant, reason = "there are two for each request")]
enum Picture {
    /// It exists.
    There(Arc<PictureFile>),
    /// It may be rendered.
    Renderable(Source, BodyPart),
}

impl Wanted {
    /// The picture, from a cache or as it may be rendered.
    async fn sought(self, app: &App, tenant: &Tenant, spec: &PictureSpec) -> Result<Sought, Problem> {
        let service = &app.service;
        let (source, known) = match self.source {
            WantedSource::Image(image) => (Source::Known(image.clone()), Some(image)),
            WantedSource::Scene(form, text) => {
                let upload = Upload::new(service.memory.metered(text)?, form, self.overrides).await?;
                let ready = service.scenes.cached(Some(&tenant.name), &upload.sent().key);
                (Source::Sent(upload), ready.as_deref().and_then(image_of))
            }
        };
        if let Some(image) = known
            && let Some(file) = service.stored_picture(&image, spec).await
        {
            return Ok(Sought { size: size_of(&file)?, picture: Picture::There(file) });
        }
        let size = service.size_of_picture(tenant.task(Class::Renders), source.clone(), *spec).await;
        let size = size.map_err(|error| self.part.error(error))?;
        Ok(Sought { size, picture: Picture::Renderable(source, self.part) })
    }
}

impl Sought {
    async fn file(self, app: &App, tenant: &Tenant, spec: PictureSpec) -> Result<Arc<PictureFile>, Problem> {
        match self.picture {
            Picture::There(file) => Ok(file),
            Picture::Renderable(source, part) => {
                let made = app.service.make_picture(tenant.task(Class::Renders), source, spec).await;
                Ok(made.map_err(|error| part.error(error))?.file)
            }
        }
    }
}
