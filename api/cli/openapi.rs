//! `strahl openapi`: the contract of the service as OpenAPI 3.1.

use super::failure::Failure;
use super::output;
use crate::http::openapi_text;

/// Prints it.
pub(super) fn run() -> Result<(), Failure> {
    output::print(openapi_text().as_bytes())
}
