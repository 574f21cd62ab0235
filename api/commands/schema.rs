//! `strahl schema`: the JSON Schema of scenes.

use super::output;
use crate::failure::Failure;

/// Prints it.
pub(super) fn run() -> Result<(), Failure> {
    output::print(strahl::scene::schema::schema_text().as_bytes())
}
