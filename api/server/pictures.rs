//! Pictures that were made lately, as files: in memory, and in a folder if there is one.
//!
//! A picture's name says what it shows and how ([`excerpt`](super::excerpt)), so what is kept never becomes wrong.

use super::cost::Cost;
use super::flights::Flights;
use super::problem::Problem;
use super::show::put;
use super::tally::Tally;
use crate::blobs::Blobs;
use crate::recent::Recent;
use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use data_encoding::BASE64;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// What a kept picture takes beside its file, about.
const OVERHEAD: u64 = 1_024;

/// A picture file and what is said about it, whoever asks for it.
#[derive(Debug)]
pub(super) struct Made {
    /// The file.
    pub(super) file: Bytes,
    /// What every answer with it says: length, digest, what making it took, how exact it is.
    pub(super) headers: HeaderMap,
    /// The image it is of, if it has a name.
    pub(super) image: Option<String>,
}

/// A picture and what it took this time.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    /// The picture.
    pub(super) made: Arc<Made>,
    /// `Server-Timing`.
    pub(super) timing: Arc<str>,
    /// What it cost, for whoever had it made.
    pub(super) cost: Option<Cost>,
}

/// What is written before the file of a kept picture.
#[derive(Debug, Serialize, Deserialize)]
struct About {
    image: Option<String>,
    headers: Vec<(String, String)>,
}

impl Made {
    /// A new file of an image.
    pub(super) fn new(file: Vec<u8>, mut headers: HeaderMap, image: Option<String>) -> Self {
        headers.insert(header::CONTENT_LENGTH, file.len().into());
        // RFC 9530.
        let digest = format!("sha-256=:{}:", BASE64.encode(&Sha256::digest(&file)));
        put(&mut headers, HeaderName::from_static("repr-digest"), &digest);
        Self { file: file.into(), headers, image }
    }

    /// A line of JSON, and the file.
    fn to_blob(&self) -> Vec<u8> {
        let text =
            |(name, value): (&HeaderName, &HeaderValue)| Some((name.to_string(), value.to_str().ok()?.to_owned()));
        let about = About { image: self.image.clone(), headers: self.headers.iter().filter_map(text).collect() };
        let mut blob = serde_json::to_vec(&about).unwrap_or_default();
        blob.push(b'\n');
        blob.extend_from_slice(&self.file);
        blob
    }

    fn from_blob(blob: &[u8]) -> Option<Self> {
        let end = blob.iter().position(|&byte| byte == b'\n')?;
        let About { image, headers } = serde_json::from_slice(&blob[..end]).ok()?;
        let header = |(name, value): (String, String)| Some((name.parse().ok()?, HeaderValue::from_str(&value).ok()?));
        Some(Self::new(blob[end + 1..].to_vec(), headers.into_iter().filter_map(header).collect(), image))
    }
}

/// The pictures.
#[derive(Debug)]
pub(super) struct Pictures {
    memory: Recent<String, Arc<Made>>,
    disk: Option<Arc<Blobs>>,
    /// How often a picture was in memory, and how often in the folder.
    tallies: [Tally; 2],
    /// Those that are being made.
    pub(super) flights: Flights<Shown>,
}

impl Pictures {
    /// No pictures in memory yet, and those of the folder.
    pub(super) fn new(budget: u64, disk: Option<Blobs>) -> Self {
        Self {
            memory: Recent::new(budget),
            disk: disk.map(Arc::new),
            tallies: Default::default(),
            flights: Flights::default(),
        }
    }

    /// A picture that is in memory.
    pub(super) fn at_hand(&self, name: &str) -> Option<Arc<Made>> {
        self.memory.get(name).inspect(|_| self.tallies[0].hit())
    }

    /// A picture, from memory or from the folder.
    pub(super) async fn get(&self, name: &str) -> Option<Arc<Made>> {
        if let Some(made) = self.at_hand(name) {
            return Some(made);
        }
        let (disk, name) = (Arc::clone(self.disk.as_ref()?), name.to_owned());
        let read = {
            let name = name.clone();
            tokio::task::spawn_blocking(move || disk.get(&name).and_then(|blob| Made::from_blob(&blob)))
        };
        let made = Arc::new(read.await.ok().flatten()?);
        self.tallies[1].hit();
        self.remember(name, &made);
        Some(made)
    }

    /// Keeps a picture. Writing it into the folder takes place on this thread.
    pub(super) fn put(&self, name: &str, made: &Arc<Made>) {
        self.remember(name.to_owned(), made);
        let Some(disk) = &self.disk else { return };
        self.tallies[1].miss();
        if let Err(error) = disk.put(name, &made.to_blob()) {
            tracing::warn!(name, %error, "a picture cannot be kept in the folder");
        }
    }

    /// What is kept where: a name, the bytes there, and how often they were of use.
    pub(super) fn tallies(&self) -> impl Iterator<Item = (&'static str, u64, &Tally)> {
        let [memory, disk] = &self.tallies;
        let folder = self.disk.as_ref().map(|blobs| ("picture_folder", blobs.bytes(), disk));
        [("pictures", self.memory.bytes(), memory)].into_iter().chain(folder)
    }

    /// The picture of a name, made by `work` unless it is there or on its way.
    pub(super) async fn share<F>(&self, name: String, work: impl FnOnce() -> F) -> Result<Shown, Problem>
    where
        F: Future<Output = Result<Shown, Problem>> + Send + 'static,
    {
        self.flights.share(name, work).await
    }

    /// Forgets every picture whose name begins so.
    pub(super) fn forget(&self, prefix: &str) {
        for name in self.memory.keys().into_iter().filter(|name| name.starts_with(prefix)) {
            self.memory.remove(&name);
        }
        if let Some(disk) = &self.disk {
            for name in disk.names().into_iter().filter(|name| name.starts_with(prefix)) {
                disk.remove(&name);
            }
        }
    }

    fn remember(&self, name: String, made: &Arc<Made>) {
        self.tallies[0].miss();
        let bytes = made.file.len() as u64 + OVERHEAD;
        self.memory.put(name, Arc::clone(made), bytes);
    }
}
