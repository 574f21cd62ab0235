//! What every file of routes uses.

pub(crate) use super::auth::tenant::{Scope, Tenant};
pub(crate) use super::contract::{Body, Content, Route};
pub(crate) use super::extract::path::Path;
pub(crate) use super::extract::query::Query;
pub(crate) use super::problem::{Kind, Problem};
pub(crate) use super::state::App;
pub(crate) use axum::Json;
pub(crate) use axum::extract::{Request, State};
pub(crate) use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
pub(crate) use axum::response::{IntoResponse, Response};
pub(crate) use schemars::JsonSchema;
pub(crate) use serde::{Deserialize, Serialize};
pub(crate) use std::sync::Arc;
