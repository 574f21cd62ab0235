//! `strahl schema`: the JSON Schema of scenes.

use super::failure::Failure;
use super::output;

/// Prints it.
pub(super) fn run() -> Result<(), Failure> {
    output::print(strahl::scene::schema::schema_text().as_bytes())
}
