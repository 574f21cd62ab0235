//! What decoding may allocate: bytes are taken before they are, so that no file costs more than it may.

use super::fault::{Fault, Kind};
use crate::control;
use std::cell::Cell;

/// Bytes of decoded data that a model may have.
pub(crate) const DECODED_BYTES: u64 = 1 << 30;

/// Bytes that are left.
#[derive(Debug)]
pub struct Budget(Cell<u64>);

impl Default for Budget {
    fn default() -> Self {
        Self(Cell::new(DECODED_BYTES))
    }
}

impl Budget {
    /// Takes room for so many things of a size each, and counts them as work that can be cancelled.
    pub fn take(&self, count: u64, size: usize) -> Result<(), Fault> {
        let left = count.checked_mul(size as u64).and_then(|bytes| self.0.get().checked_sub(bytes));
        let Some(left) = left else {
            let detail = format!("decoded, the model has more bytes than the limit of {DECODED_BYTES} (decoded_bytes)");
            return Err(Fault::new("", Kind::Limit, detail));
        };
        self.0.set(left);
        worked(count)
    }
}

/// Lines of a text after which is looked whether anybody still waits.
pub(super) const LINES: u64 = 256;

/// Counts work on so many elements; fails once nobody waits for it any more.
pub(super) fn worked(count: u64) -> Result<(), Fault> {
    let steps = (count / 64).min(1 << 20) as u32 + 1;
    if control::step(steps) { Err(Fault::cancelled()) } else { Ok(()) }
}
