//! Links of the contract: which answers contain ids for other operations. Clients and tests follow them.

use serde_json::{Map, Value, json};

/// An operation, a status, the key of an id in the answer, and the operations that take it.
const SOURCES: [(&str, &str, &str, &[Target]); 5] = [
    ("submitJob", "202", "id", &JOB),
    ("addScene", "201", "scene_id", &SCENE),
    ("addScene", "200", "scene_id", &SCENE),
    ("addScene", "201", "image_id", &IMAGE),
    ("addScene", "200", "image_id", &IMAGE),
];

/// An operation, the parameter that takes the id, and the text after the id in it.
type Target = (&'static str, &'static str, &'static str);

const JOB: [Target; 12] = [
    ("job", "id", ""),
    ("jobImage", "id", ""),
    ("jobPreview", "id", ""),
    ("jobTile", "id", ""),
    ("jobFrames", "id", ""),
    ("jobAnimation", "id", ""),
    ("jobSheet", "id", ""),
    ("lookAtJob", "id", ""),
    ("jobEvents", "id", ""),
    ("changeJob", "id", ""),
    ("cancelJob", "id", ""),
    ("forgetJob", "id", ""),
];
const SCENE: [Target; 2] = [("scene", "scene_id", ""), ("removeScene", "scene_id", "")];
const IMAGE: [Target; 8] = [
    ("image", "image", ".png"),
    ("iiif", "image", ""),
    ("iiifInfo", "image", ""),
    ("iiifImage", "image", ""),
    ("dzi", "image", ".dzi"),
    ("dziTile", "folder", "_files"),
    ("xyz", "image", ".json"),
    ("xyzTile", "image", ""),
];

/// The links of an answer, if it has any.
pub(crate) fn of(operation: &str, status: &str) -> Map<String, Value> {
    let of_this = SOURCES.iter().filter(|source| (source.0, source.1) == (operation, status));
    let links = of_this.flat_map(|(.., key, targets)| targets.iter().map(move |target| (key, target)));
    links
        .map(|(key, (target, parameter, after))| {
            let value = match *after {
                "" => format!("$response.body#/{key}"),
                after => format!("{{$response.body#/{key}}}{after}"),
            };
            ((*target).to_owned(), json!({ "operationId": target, "parameters": { *parameter: value } }))
        })
        .collect()
}
