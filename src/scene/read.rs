//! JSON text to [`Description`], reporting every problem of its shape at once.
use super::{Description, Problems};

/// Reads scene JSON.
pub fn read_json(_text: &[u8]) -> Result<Description, Problems> {
    Err(Problems(Vec::new()))
}
