//! Key files: each is understood or refused.

use crate::http::auth::keys::Keys;

pub(super) fn file(text: &[u8]) {
    let Ok(text) = std::str::from_utf8(text) else { return };
    match Keys::read(text, None) {
        // Read again while it is in use.
        Ok(keys) => assert!(Keys::read(text, Some(&keys)).is_ok()),
        Err(error) => assert!(!error.is_empty()),
    }
}
