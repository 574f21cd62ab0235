//! A picture file and what is said about it, whoever asks for it and when. Both are kept as one file: a line of JSON, and
//! the picture.

use super::report::Report;
use super::warnings;
use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, header};
use data_encoding::BASE64;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::io::{self, BufRead};
use strahl::scene::Scene;

/// A picture file and what is said about it.
#[derive(Debug)]
pub(crate) struct PictureFile {
    /// The file.
    pub(crate) file: Bytes,
    /// What every answer with it says: length, digest, what making it took, how exact it is.
    pub(crate) headers: HeaderMap,
    /// The rest.
    pub(crate) about: PictureMeta,
}

/// What is said about a picture.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PictureMeta {
    /// The image it is of, if it has a name.
    pub(crate) image: Option<String>,
    /// Headers: which rays were traced, which effects are in it, how exact it is.
    pub(crate) headers: Vec<(String, String)>,
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
        let mut headers = vec![
            ("render-error".to_owned(), report.error.header()),
            ("render-rays".to_owned(), kinds),
            ("render-plan".to_owned(), on.join(", ")),
        ];
        headers.extend(warnings::header(&scene.warnings).map(|value| ("render-warnings".to_owned(), value)));
        // Reports are made of what JSON can say.
        let report = is_whole.then(|| serde_json::value::to_raw_value(report).ok()).flatten();
        Self { image, headers, report }
    }
}

impl PictureFile {
    /// A new file.
    pub(crate) fn new(file: Vec<u8>, about: PictureMeta) -> Self {
        // RFC 9530.
        let digest = format!("sha-256=:{}:", BASE64.encode(&Sha256::digest(&file)));
        let header = |(name, value): (&str, &str)| Some((name.parse().ok()?, HeaderValue::from_str(value).ok()?));
        let named = about.headers.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let mut headers: HeaderMap = named.chain([("repr-digest", digest.as_str())]).filter_map(header).collect();
        headers.insert(header::CONTENT_LENGTH, file.len().into());
        Self { file: file.into(), headers, about }
    }

    /// Bytes that it takes, about.
    pub(crate) fn bytes(&self) -> u64 {
        let report = self.about.report.as_ref().map_or(0, |report| report.get().len());
        (self.file.len() + report + 1_024) as u64
    }

    /// What is kept of it.
    pub(crate) fn to_blob(&self) -> Vec<u8> {
        let mut blob = serde_json::to_vec(&self.about).unwrap_or_default();
        blob.push(b'\n');
        blob.extend_from_slice(&self.file);
        blob
    }

    /// What was kept.
    pub(crate) fn read(from: &mut impl BufRead) -> io::Result<Self> {
        let about = PictureMeta::read(from)?;
        let mut file = Vec::new();
        from.read_to_end(&mut file)?;
        Ok(Self::new(file, about))
    }
}

impl PictureMeta {
    /// The beginning of what was kept.
    pub(crate) fn read(from: &mut impl BufRead) -> io::Result<Self> {
        let mut line = Vec::new();
        from.read_until(b'\n', &mut line)?;
        Ok(serde_json::from_slice(&line)?)
    }
}
