//! A route: its path, its handler, and its place in the contract.

use super::WARNINGS;
use super::links;
use super::schemas::{Schemas, bytes};
use crate::http::auth::tenant::Scope;
use crate::http::extract::parameter::Parameter;
use crate::http::extract::query::Query;
use crate::http::extract::scene_types::SCENE_TYPES;
use crate::http::extract::variation::{self, Variation};
use crate::http::state::App;
use axum::handler::Handler;
use axum::routing::{MethodFilter, MethodRouter, on};
use schemars::JsonSchema;
use serde_json::{Map, Value, json};
use strahl::scene::Format;

/// A route.
#[derive(Debug)]
pub(crate) struct Route {
    /// The path, with parameters in braces.
    pub(crate) path: &'static str,
    /// The method in lower case.
    pub(crate) method: &'static str,
    /// The scope that a key needs. None: open to all.
    pub(crate) scope: Option<Scope>,
    /// Whether it costs no unit of the rate limit.
    pub(crate) is_free: bool,
    /// The handler.
    pub(crate) handler: MethodRouter<App>,
    name: &'static str,
    tag: &'static str,
    about: &'static str,
    /// Parameters in the path and the headers, with their descriptions.
    parameters: Vec<(&'static str, Place, &'static str)>,
    query: Vec<Parameter>,
    body: Option<Body>,
    answers: Vec<(u16, &'static str, Vec<Content>)>,
    /// Headers of the answers.
    headers: Vec<(&'static str, &'static str)>,
    /// The component that describes its answer 200, if that is a picture.
    picture: Option<&'static str>,
}

/// Where a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Path,
    /// In the path, as a whole number.
    Number,
    Header,
}

/// A media type and its schema.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Content {
    media_type: &'static str,
    schema: fn(&mut Schemas) -> Value,
}

impl Content {
    /// JSON that is written from a type.
    pub(crate) fn json<T: JsonSchema>() -> Self {
        Self { media_type: "application/json", schema: Schemas::answer::<T> }
    }

    /// The same as another media type.
    pub(crate) fn json_as<T: JsonSchema>(media_type: &'static str) -> Self {
        Self { media_type, ..Self::json::<T>() }
    }

    /// Text of a media type.
    pub(crate) const fn text(media_type: &'static str) -> Self {
        Self { media_type, schema: |_| json!({ "type": "string" }) }
    }

    /// A file of a media type.
    pub(crate) const fn file(media_type: &'static str) -> Self {
        Self { media_type, schema: |_| bytes() }
    }

    /// Contents with a schema.
    pub(crate) const fn of(media_type: &'static str, schema: fn(&mut Schemas) -> Value) -> Self {
        Self { media_type, schema }
    }
}

/// Body of a request.
#[derive(Debug)]
pub(crate) struct Body {
    about: &'static str,
    contents: Vec<Content>,
    /// An example for the first of them.
    example: Option<Value>,
}

/// A scene for examples.
pub(crate) fn example_scene() -> Value {
    json!({
        "version": 1,
        "image": { "width": 48, "height": 32 },
        "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
        "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1 } }],
    })
}

/// The same in Neutral File Format.
const EXAMPLE_NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nl 3 3 3\n\
                           f 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";

/// Scenes in other formats than JSON.
fn files() -> impl Iterator<Item = Content> {
    let files = SCENE_TYPES.iter().filter(|it| it.format != Format::Json);
    files.map(|it| if it.is_text { Content::text(it.name) } else { Content::file(it.name) })
}

impl Body {
    /// The same or a file of any other format of scenes.
    pub(crate) fn or_files(mut self) -> Self {
        self.contents.extend(files());
        self
    }

    /// A scene.
    pub(crate) fn scene() -> Self {
        let scene = Content::of("application/json", |_| json!({ "$ref": "#/components/schemas/Scene" }));
        let variation = Content { media_type: variation::MEDIA_TYPE, schema: Schemas::body::<Variation<'_>> };
        Self {
            about: "The scene; a model, with its parts as multipart/form-data; NFF plain or gzip; or a variation of a known scene",
            contents: [scene, variation].into_iter().chain(files()).collect(),
            example: Some(example_scene()),
        }
    }

    /// A file of any type.
    pub(crate) fn file(about: &'static str) -> Self {
        Self { about, contents: vec![Content::file("application/octet-stream")], example: None }
    }

    /// JSON that is read into a type.
    pub(crate) fn json<T: JsonSchema>(about: &'static str) -> Self {
        let json = Content { media_type: "application/json", schema: Schemas::body::<T> };
        Self { about, contents: vec![json], example: None }
    }

    /// The same under a further media type.
    pub(crate) fn or(mut self, media_type: &'static str) -> Self {
        self.contents.push(Content { media_type, ..self.contents[0] });
        self
    }

    /// An example.
    pub(crate) fn example(self, example: Value) -> Self {
        Self { example: Some(example), ..self }
    }

    fn document(&self, schemas: &mut Schemas) -> Value {
        let mut contents = contents(&self.contents, schemas);
        if let Some(example) = &self.example {
            contents[self.contents[0].media_type]["examples"] = json!({ "a ball": { "value": example } });
        }
        if let Some(nff) = contents.get_mut("text/x-nff") {
            nff["examples"] = json!({ "a ball": { "value": EXAMPLE_NFF } });
        }
        json!({ "description": self.about, "required": true, "content": contents })
    }
}

impl Route {
    /// A route of a method. `about` is its name, its tag, and what it does: a line, with or without a paragraph after it.
    fn new<H: Handler<T, App>, T: 'static>(
        (method, filter): (&'static str, MethodFilter),
        path: &'static str,
        handler: H,
        [name, tag, about]: [&'static str; 3],
    ) -> Self {
        Self {
            path,
            method,
            scope: None,
            is_free: false,
            handler: on(filter, handler),
            name,
            tag,
            about,
            parameters: Vec::new(),
            query: Vec::new(),
            body: None,
            answers: Vec::new(),
            headers: Vec::new(),
            picture: None,
        }
    }

    /// A GET route, as all below with its name, its tag, and what it does.
    pub(crate) fn get<H: Handler<T, App>, T: 'static>(
        path: &'static str,
        handler: H,
        about: [&'static str; 3],
    ) -> Self {
        Self::new(("get", MethodFilter::GET), path, handler, about)
    }

    /// A POST route.
    pub(crate) fn post<H: Handler<T, App>, T: 'static>(
        path: &'static str,
        handler: H,
        about: [&'static str; 3],
    ) -> Self {
        Self::new(("post", MethodFilter::POST), path, handler, about)
    }

    /// A PUT route.
    pub(crate) fn put<H: Handler<T, App>, T: 'static>(
        path: &'static str,
        handler: H,
        about: [&'static str; 3],
    ) -> Self {
        Self::new(("put", MethodFilter::PUT), path, handler, about)
    }

    /// A PATCH route.
    pub(crate) fn patch<H: Handler<T, App>, T: 'static>(
        path: &'static str,
        handler: H,
        about: [&'static str; 3],
    ) -> Self {
        Self::new(("patch", MethodFilter::PATCH), path, handler, about)
    }

    /// A DELETE route.
    pub(crate) fn delete<H: Handler<T, App>, T: 'static>(
        path: &'static str,
        handler: H,
        about: [&'static str; 3],
    ) -> Self {
        Self::new(("delete", MethodFilter::DELETE), path, handler, about)
    }

    /// Handles all other methods, with the scope of the route.
    pub(crate) fn or_else<H: Handler<T, App>, T: 'static>(mut self, handler: H) -> Self {
        self.handler = self.handler.fallback(handler);
        self
    }

    /// Sets the scope that keys need.
    pub(crate) fn needs(self, scope: Scope) -> Self {
        Self { scope: Some(scope), ..self }
    }

    /// It costs no unit of the rate limit, and is answered also where none is left.
    pub(crate) fn free(self) -> Self {
        Self { is_free: true, ..self }
    }

    /// A parameter in the path.
    pub(crate) fn path(self, name: &'static str, about: &'static str) -> Self {
        self.parameter(name, Place::Path, about)
    }

    /// A whole number in the path.
    pub(crate) fn number(self, name: &'static str, about: &'static str) -> Self {
        self.parameter(name, Place::Number, about)
    }

    /// A header of the request.
    pub(crate) fn header(self, name: &'static str, about: &'static str) -> Self {
        self.parameter(name, Place::Header, about)
    }

    fn parameter(mut self, name: &'static str, place: Place, about: &'static str) -> Self {
        self.parameters.push((name, place, about));
        self
    }

    /// Declares the parameters that `read` takes from the query.
    pub(crate) fn query<T>(mut self, read: impl FnOnce(&mut Query) -> T) -> Self {
        self.query.extend(Query::describe(read));
        self
    }

    /// Declares a scene as the body, and settings in the query.
    pub(crate) fn about_scene(self) -> Self {
        self.needs(Scope::Render).query(|query| query.settings(Format::Json)).body(Body::scene())
    }

    /// Declares the body.
    pub(crate) fn body(self, body: Body) -> Self {
        Self { body: Some(body), ..self }
    }

    /// Declares an answer.
    pub(crate) fn answer(mut self, status: u16, about: &'static str, contents: &[Content]) -> Self {
        self.answers.push((status, about, contents.to_vec()));
        self
    }

    /// Declares a header of the answers.
    pub(crate) fn answer_header(mut self, name: &'static str, about: &'static str) -> Self {
        self.headers.push((name, about));
        self
    }

    /// Declares the header with the warnings of the scene.
    pub(crate) fn warns(self) -> Self {
        self.answer_header("Render-Warnings", WARNINGS)
    }

    /// Declares a picture as the answer 200.
    pub(crate) fn picture(self) -> Self {
        Self { picture: Some("Picture"), ..self }
    }

    /// Declares a picture, whole, in parts or from all around, as the answer 200.
    pub(crate) fn picture_or_parts(self) -> Self {
        Self { picture: Some("PictureOrParts"), ..self }
    }

    /// Declares a picture or an animation as the answer 200.
    pub(crate) fn picture_or_animation(self) -> Self {
        Self { picture: Some("PictureOrAnimation"), ..self }
    }

    /// The operation object of the contract.
    pub(super) fn operation(&self, schemas: &mut Schemas) -> Value {
        let (summary, description) = self.about.split_once("\n\n").unwrap_or((self.about, ""));
        let mut operation = json!({
            "operationId": self.name,
            "tags": [self.tag],
            "summary": summary,
            "responses": self.responses(schemas),
        });
        if !description.is_empty() {
            operation["description"] = description.into();
        }
        let parameters = self.all_parameters();
        if !parameters.is_empty() {
            operation["parameters"] = parameters.into();
        }
        if let Some(body) = &self.body {
            operation["requestBody"] = body.document(schemas);
        }
        if self.scope.is_none() {
            operation["security"] = json!([{}]);
        }
        operation
    }

    fn all_parameters(&self) -> Vec<Value> {
        let mut all = Vec::new();
        for (name, place, about) in &self.parameters {
            let (place, schema) = match place {
                Place::Path => ("path", json!({ "type": "string" })),
                Place::Number => ("path", json!({ "type": "integer", "format": "int32", "minimum": 0 })),
                Place::Header => ("header", json!({ "type": ["string", "null"] })),
            };
            let required = place == "path";
            all.push(
                json!({ "name": name, "in": place, "required": required, "description": about, "schema": schema }),
            );
        }
        for parameter in &self.query {
            all.push(json!({
                "name": parameter.name,
                "in": "query",
                "required": parameter.required,
                "description": parameter.about,
                "schema": parameter.schema(),
            }));
        }
        all
    }

    fn responses(&self, schemas: &mut Schemas) -> Map<String, Value> {
        let mut responses = Map::new();
        if let Some(picture) = self.picture {
            responses.insert("200".into(), json!({ "$ref": format!("#/components/responses/{picture}") }));
        }
        for (status, about, of) in &self.answers {
            let mut response = json!({ "description": about });
            if !of.is_empty() {
                response["content"] = contents(of, schemas).into();
            }
            for (name, about) in &self.headers {
                response["headers"][name] = json!({ "description": about, "schema": { "type": "string" } });
            }
            let links = links::of(self.name, &status.to_string());
            if !links.is_empty() {
                response["links"] = links.into();
            }
            responses.insert(status.to_string(), response);
        }
        for status in ["4XX", "5XX"] {
            responses.insert(status.into(), json!({ "$ref": "#/components/responses/Problem" }));
        }
        responses
    }
}

fn contents(of: &[Content], schemas: &mut Schemas) -> Map<String, Value> {
    let content = |content: &Content| (content.media_type.to_owned(), json!({ "schema": (content.schema)(schemas) }));
    of.iter().map(content).collect()
}
