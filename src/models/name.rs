//! Names, which files may have of any length, and which everything that uses the named thing repeats.

/// Bytes of a name that are kept.
pub(crate) const NAME_BYTES: usize = 256;

/// A text, cut where it has more than so many bytes.
pub(crate) fn shortened(text: &str, bytes: usize) -> String {
    let mut end = text.len().min(bytes);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    text[..end].to_owned()
}
