//! A limit on the memory of all request bodies and answers together.

use crate::service::pictures::file::PictureFile;
use axum::body::{Body, Bytes};
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Bytes that one permit stands for. Semaphores count up to 2^61 on 64-bit machines, but give at most 2^32 permits at a time.
const UNIT: u64 = 4_096;

/// The budget.
#[derive(Debug, Clone)]
pub(crate) struct MemoryBudget(Arc<Semaphore>);

/// Bytes together with their share of the budget.
#[derive(Debug, Default)]
pub(crate) struct MeteredBytes {
    bytes: Vec<u8>,
    share: Option<OwnedSemaphorePermit>,
}

impl MemoryBudget {
    /// A budget of a number of bytes.
    pub(crate) fn new(bytes: u64) -> Self {
        Self(Arc::new(Semaphore::new(units(bytes).min(Semaphore::MAX_PERMITS))))
    }

    /// Adds bytes to others. False if there is no memory for them.
    pub(crate) fn append(&self, to: &mut MeteredBytes, more: &[u8]) -> bool {
        let have = to.share.as_ref().map_or(0, OwnedSemaphorePermit::num_permits);
        let missing = units((to.bytes.len() + more.len()) as u64).saturating_sub(have);
        let missing = u32::try_from(missing).unwrap_or(u32::MAX);
        let Ok(more_share) = Arc::clone(&self.0).try_acquire_many_owned(missing) else { return false };
        match &mut to.share {
            Some(share) => share.merge(more_share),
            None => to.share = Some(more_share),
        }
        to.bytes.extend_from_slice(more);
        true
    }

    /// The body of an answer. Its bytes exist already, so it is sent even if there is no share left.
    pub(crate) fn body(&self, bytes: Vec<u8>) -> Body {
        let share = self.share(bytes.len());
        Body::from(Bytes::from_owner(MeteredBytes { bytes, share }))
    }

    /// The body of an answer with a picture, which several answers may share. Each takes a share of its own.
    pub(crate) fn picture(&self, file: &Arc<PictureFile>) -> Body {
        struct Shared(
            Arc<PictureFile>,
            #[expect(dead_code, reason = "held until it is dropped")] Option<OwnedSemaphorePermit>,
        );
        impl AsRef<[u8]> for Shared {
            fn as_ref(&self) -> &[u8] {
                &self.0.bytes
            }
        }
        Body::from(Bytes::from_owner(Shared(Arc::clone(file), self.share(file.bytes.len()))))
    }

    fn share(&self, bytes: usize) -> Option<OwnedSemaphorePermit> {
        let wanted = u32::try_from(units(bytes as u64)).unwrap_or(u32::MAX);
        Arc::clone(&self.0).try_acquire_many_owned(wanted).ok()
    }
}

impl AsRef<[u8]> for MeteredBytes {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

fn units(bytes: u64) -> usize {
    usize::try_from(bytes.div_ceil(UNIT)).unwrap_or(usize::MAX)
}
