//! The JSON Schema of scenes: `strahl schema` and `GET /schema/scene.json`.

use serde_json::Value;
use strahl::scene::Description;

/// The schema.
pub(crate) fn scene_schema() -> Value {
    schemars::schema_for!(Description).to_value()
}
