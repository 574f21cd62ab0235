//! Variations of a known scene: `{"base": "<scene id>", "patch": {...}}` in the place of a scene.

use super::json_body;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::problem::Problem;
use crate::service::requests::Service;
use crate::service::scenes::sent_scene::Form;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::value::RawValue;

/// The media type of a variation.
pub(crate) const MEDIA_TYPE: &str = "application/vnd.strahl.variation+json";

/// A variation of a known scene.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variation<'a> {
    /// The id of a scene that you have posted to `/v1/scenes`.
    base: String,
    /// What is different: a merge patch (RFC 7396) on the canonical text of that scene, with at most 4 MiB. Null removes a
    /// key, and lists are replaced as a whole.
    #[serde(borrow)]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    patch: &'a RawValue,
}

/// Whether JSON is a variation: its first key is one that no scene has.
pub(crate) fn is_variation(json: &[u8]) -> bool {
    json_body::begins_with(json, ["base", "patch"])
}

/// What the JSON of a scene is, and its text: itself, or the patch of a variation that a tenant may make.
pub(crate) fn form_of<'a>(service: &Service, tenant: &Tenant, json: &'a [u8]) -> Result<(Form, &'a [u8]), Problem> {
    if is_variation(json) { read(service, tenant, json) } else { Ok((Form::JSON, json)) }
}

/// A variation that a tenant may make, and its patch.
pub(crate) fn read<'a>(service: &Service, tenant: &Tenant, json: &'a [u8]) -> Result<(Form, &'a [u8]), Problem> {
    let Variation { base, patch } = json_body::read(json, r#"a variation is {"base": "<scene id>", "patch": {...}}"#)?;
    // Operators may read the scenes of all.
    let owner = (!tenant.may(Scope::Admin)).then_some(&*tenant.name);
    Ok((service.variation_of(&base, owner)?, patch.get().as_bytes()))
}
