//! Where slow encoders write: memory, until the work is cancelled.

use crate::control::{self, Cancelled};
use std::fmt::Debug;
use std::io::{self, Cursor, Seek, SeekFrom, Write};

/// A growing file.
#[derive(Debug, Default)]
pub(super) struct Sink(Cursor<Vec<u8>>);

impl Sink {
    /// The bytes that `encode` writes. It can fail only if the work is cancelled; then they are useless.
    pub(super) fn collect<E: Debug>(encode: impl FnOnce(&mut Self) -> Result<(), E>) -> Vec<u8> {
        let mut sink = Self::default();
        if let Err(error) = encode(&mut sink) {
            assert!(control::is_stopping(), "memory takes any amount of bytes, and a format its pictures: {error:?}");
        }
        sink.0.into_inner()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // A block of an EXR file is compressed for milliseconds, and written at once.
        control::checkpoint(1 + (bytes.len() / 64) as u32).map_err(|Cancelled| io::Error::other("cancelled"))?;
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}
