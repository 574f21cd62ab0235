//! Writing results: `-` is standard output, everything else a file.

use super::failure::Failure;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// Writes all of a file, or to standard output for `-`.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if is_standard(path) {
        print(bytes)
    } else {
        std::fs::write(path, bytes).map_err(|error| Failure::writing(&path.display().to_string(), &error))
    }
}

/// Writes to standard output.
pub(super) fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|error| Failure::writing("standard output", &error))
}

/// A value as indented JSON with a line end.
pub(super) fn pretty(value: &impl Serialize) -> Result<Vec<u8>, Failure> {
    let mut json = serde_json::to_vec_pretty(value)
        .map_err(|error| Failure::Input(format!("the result cannot be written as JSON: {error}")))?;
    json.push(b'\n');
    Ok(json)
}

/// Finds out before a long render, not after it, that its folder does not exist.
pub(super) fn check_folder(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => Err(Failure::Input(format!(
            "{} cannot be written: there is no folder {}",
            path.display(),
            folder.display()
        ))),
        _ => Ok(()),
    }
}

/// Whether a path means standard output.
pub(super) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}
