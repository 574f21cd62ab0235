//! How many jobs need each of the files that jobs share: texts of scenes, and pictures.

use std::collections::HashMap;

/// The numbers, by name of the file.
#[derive(Debug, Default)]
pub(super) struct References(HashMap<String, usize>);

impl References {
    /// One more job needs a file: nobody removes it from now on.
    pub(super) fn add(&mut self, name: &str) {
        *self.0.entry(name.to_owned()).or_default() += 1;
    }

    /// A job needs a file no more; whether that was the last one.
    pub(super) fn remove(&mut self, name: &str) -> bool {
        let Some(count) = self.0.get_mut(name) else { return false };
        *count -= 1;
        let is_last = *count == 0;
        if is_last {
            self.0.remove(name);
        }
        is_last
    }

    /// Whether a job needs it.
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }
}
