//! A picture file and its meta data. Both are stored as one file: a line of JSON, and the picture.

use super::report::Report;
use super::warnings;
use data_encoding::BASE64;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::io::{self, BufRead};
use strahl::scene::Scene;

/// A picture file and its meta data.
#[derive(Debug)]
pub(crate) struct PictureFile {
    /// The file.
    pub(crate) bytes: Vec<u8>,
    /// SHA-256 of the file, in base 64.
    pub(crate) digest: String,
    /// What is known about it.
    pub(crate) meta: PictureMeta,
}

/// What is known about a picture, independent of who asks for it and when.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PictureMeta {
    /// Id of its image, if it has one.
    pub(crate) image: Option<String>,
    /// Lines by name: which rays were traced, which effects are in it, how exact it is. Answers have them as headers.
    #[serde(rename = "headers")]
    pub(crate) lines: Vec<(String, String)>,
    /// The cost report of a whole picture; parts have none.
    pub(crate) report: Option<Box<RawValue>>,
}

impl PictureMeta {
    /// What a report says about a picture of a scene; `is_whole` if it is all of the picture.
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
        lines.extend(warnings::line(&scene.warnings).map(|value| ("render-warnings".to_owned(), value)));
        // Reports are made of what JSON can say.
        let report = is_whole.then(|| serde_json::value::to_raw_value(report).ok()).flatten();
        Self { image, lines, report }
    }
}

impl PictureFile {
    /// A new file.
    pub(crate) fn new(bytes: Vec<u8>, meta: PictureMeta) -> Self {
        let digest = BASE64.encode(&Sha256::digest(&bytes));
        Self { bytes, digest, meta }
    }

    /// Bytes of memory that it takes, about.
    pub(crate) fn size(&self) -> u64 {
        let report = self.meta.report.as_ref().map_or(0, |report| report.get().len());
        (self.bytes.len() + report + 1_024) as u64
    }

    /// Both as they are stored.
    pub(crate) fn to_blob(&self) -> Vec<u8> {
        let mut blob = serde_json::to_vec(&self.meta).unwrap_or_default();
        blob.push(b'\n');
        blob.extend_from_slice(&self.bytes);
        blob
    }

    /// Reads both as they were stored.
    pub(crate) fn read(from: &mut impl BufRead) -> io::Result<Self> {
        let meta = PictureMeta::read(from)?;
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes)?;
        Ok(Self::new(bytes, meta))
    }
}

impl PictureMeta {
    /// Reads the beginning of what was stored.
    pub(crate) fn read(from: &mut impl BufRead) -> io::Result<Self> {
        let mut line = Vec::new();
        from.read_until(b'\n', &mut line)?;
        Ok(serde_json::from_slice(&line)?)
    }
}
