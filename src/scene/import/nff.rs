//! Neutral File Format (SPD).
use crate::scene::{Description, Problems};

/// How to take an NFF file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NffOptions {
    /// See opaque surfaces from behind, too.
    pub two_sided: bool,
    /// 513 x 513 corner rays and depth 5, as the SPD counts them.
    pub spd_counts: bool,
}

/// Reads an NFF file, plain or gzip.
pub fn read_nff(_bytes: &[u8], _options: NffOptions) -> Result<Description, Problems> {
    Err(Problems(Vec::new()))
}
