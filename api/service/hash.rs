//! SHA-256, by which texts, assets and requests are named.

use sha2::{Digest, Sha256};

/// The SHA-256 of bytes in hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    sha256_of_parts([bytes])
}

/// The SHA-256 of the parts one after the other in hexadecimal digits.
pub(crate) fn sha256_of_parts<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    parts.into_iter().for_each(|part| hash.update(part));
    data_encoding::HEXLOWER.encode(&hash.finalize())
}
