//! A picture file and its meta data. Both are stored as one file: JSON as its head, and the picture.

use super::report::{Phases, Report};
use super::warnings;
use crate::service::error::Error;
use crate::service::memory_budget::{MemoryBudget, Share};
use crate::service::storage::blob_store::Blob;
use crate::service::storage::blobs::Blobs;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use strahl::scene::Scene;

/// A picture file and its metadata.
#[derive(Debug)]
pub(crate) struct PictureFile {
    /// The file.
    pub(crate) bytes: Vec<u8>,
    /// SHA-256 of the file.
    pub(crate) digest: [u8; 32],
    /// Its metadata.
    pub(crate) meta: PictureMeta,
    /// Its part of the memory.
    share: Option<Share>,
}

/// Metadata of a picture, the same for all requests.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PictureMeta {
    /// Id of its image, if it has one.
    pub(crate) image: Option<String>,
    /// Header fields of answers: which rays were traced, which effects are in it, how exact it is.
    #[serde(rename = "headers")]
    pub(crate) lines: Vec<(String, String)>,
    /// What it took when it was made.
    #[serde(default)]
    pub(crate) phases: Phases,
    /// The cost report of a whole picture; parts have none.
    pub(crate) report: Option<Box<RawValue>>,
}

impl PictureMeta {
    /// Metadata from a report. `is_whole` if it is not a part of the picture.
    pub(crate) fn new(image: Option<String>, report: &Report, scene: &Scene, is_whole: bool) -> Self {
        let rays = report.cost.rays;
        let mut kinds = format!(
            "camera={}, shadow={}, reflected={}, transmitted={}",
            rays.camera, rays.shadow, rays.reflected, rays.transmitted
        );
        if rays.gathered > 0 {
            kinds += &format!(", gathered={}", rays.gathered);
        }
        let on: Vec<_> = report.plan.explanation.names_on().collect();
        let mut lines = vec![
            ("render-error".to_owned(), report.error.line()),
            ("render-rays".to_owned(), kinds),
            ("render-plan".to_owned(), on.join(", ")),
        ];
        lines.extend(
            warnings::line(&scene.warnings, report.error.proved.shortfall.as_deref())
                .map(|value| (warnings::NAME.to_owned(), value)),
        );
        let phases = report.cost.phases_ms;
        // All values of a report can be written as JSON.
        let report = is_whole.then(|| serde_json::value::to_raw_value(report).ok()).flatten();
        Self { image, lines, phases, report }
    }
}

impl PictureFile {
    /// A new file.
    pub(crate) fn new(bytes: Vec<u8>, meta: PictureMeta) -> Self {
        let digest = Sha256::digest(&bytes).into();
        Self { bytes, digest, meta, share: None }
    }

    /// The same with its part of the memory, which was that of making it.
    pub(crate) fn with(mut self, mut share: Share) -> Self {
        share.shrink(self.size());
        self.share = Some(share);
        self
    }

    /// Approximate bytes of memory.
    pub(crate) fn size(&self) -> u64 {
        let report = self.meta.report.as_ref().map_or(0, |report| report.get().len());
        (self.bytes.len() + report + 1_024) as u64
    }

    /// What is known about it, as it is stored before the file itself.
    pub(crate) fn head(&self) -> Vec<u8> {
        serde_json::to_vec(&self.meta).unwrap_or_default()
    }

    /// A file as it was stored, once there is memory for it; none if another version of the program has stored it.
    pub(crate) fn read(store: &dyn Blobs, name: &str, budget: &MemoryBudget) -> Result<Option<Self>, Error> {
        let mut share = budget.share(0);
        share.grow(store.size(name).unwrap_or(0))?;
        let read = |Blob { head, body, digest }: Blob| {
            Some(Self { bytes: body, digest, meta: PictureMeta::stored(&head)?, share: None }.with(share))
        };
        let found = store.get(name).map_err(|error| Error::io("the file with the picture cannot be read", &error))?;
        Ok(found.and_then(read))
    }
}

impl PictureMeta {
    /// The line with its warnings, if there are any.
    pub(crate) fn warnings(&self) -> Option<&str> {
        self.lines.iter().find(|(name, _)| name == warnings::NAME).map(|(_, line)| line.as_str())
    }

    /// What was stored before the file itself.
    pub(crate) fn stored(head: &[u8]) -> Option<Self> {
        serde_json::from_slice(head).ok()
    }
}
