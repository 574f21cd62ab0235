//! The parameters of a path.

use crate::http::problem::{Kind, Problem};
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

/// The parameters of a path, in their order.
#[derive(Debug)]
pub(crate) struct Path<T>(pub(crate) T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for Path<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let read = axum::extract::Path::from_request_parts(parts, state).await;
        let detail = "there is nothing at this path: what should be a number in it is none, or %xx in it are not UTF-8";
        let not_text = |_| Problem::new(Kind::NotFound, detail);
        read.map(|axum::extract::Path(parameters)| Self(parameters)).map_err(not_text)
    }
}
