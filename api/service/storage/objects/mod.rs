//! Blobs by name in an object store that several machines share: a folder, or a bucket of S3 and what speaks its protocol.
//!
//! A blob is there completely or not at all. Names are paths of plain letters. Where the last part of a name is a SHA-256 in
//! hexadecimal, with or without an ending, what is read is checked against it: a damaged blob is an error and never a picture.

use super::disk;
use crate::service::error::StartError;
use crate::service::tls;
use futures_util::StreamExt;
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::local::LocalFileSystem;
use object_store::path::Path as Name;
use object_store::{ClientConfigKey, ObjectStore, ObjectStoreExt, PutMode, PutOptions};
use sha2::{Digest, Sha256};
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A blob of ours that every store has. Who can write it may write the others.
const MARKER: &str = "strahl-store.json";
/// What is in it: the version of the names.
const MARKER_TEXT: &[u8] = b"{\"v\":1}\n";
/// How long a store may take to answer, beside the time of the bytes.
const ANSWER: Duration = Duration::from_secs(10);
/// Bytes that a store takes or gives in a second at least.
const SLOWEST: u64 = 256 << 10;
/// How long a store may take to answer at the start.
const START: Duration = Duration::from_secs(30);
/// Bytes of a name; S3 takes 1,024 with the prefix.
const NAME_BYTES: usize = 512;

/// A folder or a bucket. Clones are the same one.
#[derive(Debug, Clone)]
pub(crate) struct Objects {
    store: Arc<dyn ObjectStore>,
    /// Every name begins with it.
    prefix: Name,
    /// The URL of the prefix, without a slash at its end.
    url: String,
    /// Whether it is a bucket.
    is_bucket: bool,
}

/// Why a blob is not read or written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ObjectError {
    /// The name is none.
    Name(String),
    /// The blob has more bytes than the reader takes.
    TooLarge {
        /// Its bytes.
        bytes: u64,
        /// Those that the reader takes.
        max: u64,
    },
    /// The blob is not what its name says.
    Damaged(String),
    /// The store refuses, or does not answer: another time it may.
    Store(String),
}

impl fmt::Display for ObjectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => {
                write!(f, "{name:?} is no name for a blob: write parts of A-Z a-z 0-9 . _ - between slashes")
            }
            Self::TooLarge { bytes, max } => write!(f, "the blob has {bytes} bytes, more than {max}"),
            Self::Damaged(name) => write!(f, "the blob {name} is damaged: its SHA-256 is not the one of its name"),
            Self::Store(why) => f.write_str(why),
        }
    }
}

impl From<object_store::Error> for ObjectError {
    fn from(error: object_store::Error) -> Self {
        Self::Store(one_line(&error))
    }
}

impl Objects {
    /// Opens a folder, or `s3://BUCKET/PREFIX` with endpoint, region and keys from `AWS_*` of the environment, and tries to
    /// write there.
    pub(crate) async fn open(place: &str) -> Result<Self, StartError> {
        Self::open_in(place, std::env::vars()).await
    }

    /// Refuses what names neither a folder nor a bucket, without looking there.
    pub(crate) fn check_place(place: &str) -> Result<(), StartError> {
        in_bucket(place).map(drop)
    }

    async fn open_in(place: &str, environment: impl Iterator<Item = (String, String)>) -> Result<Self, StartError> {
        let objects = match in_bucket(place)? {
            None => Self::folder(place)?,
            Some((bucket, prefix)) => Self::bucket(place, bucket, prefix, environment)?,
        };
        let silent = || StartError::Machine(format!("--store {place}: nothing answered within {} s", START.as_secs()));
        tokio::time::timeout(START, objects.try_out()).await.map_err(|_| silent())?.map_err(|(error, advice)| {
            StartError::Machine(format!("--store {place}: {}.\n\n{advice}", error.trim_end_matches('.')))
        })?;
        Ok(objects)
    }

    fn folder(place: &str) -> Result<Self, StartError> {
        let path = Path::new(place);
        let wrong = |error: &dyn fmt::Display| {
            let advice = "Fronts and nodes write into this folder: name another with --store DIR.";
            StartError::Machine(format!("--store {place}: {error}.\n\n{advice}"))
        };
        disk::create_folders(path).map_err(|error| wrong(&error))?;
        let absolute = path.canonicalize().map_err(|error| wrong(&error))?;
        // A blob that a front was told of outlives a power cut.
        let store = LocalFileSystem::new_with_prefix(&absolute).map_err(|error| wrong(&error))?.with_fsync(true);
        let url = format!("file://{}", absolute.display());
        Ok(Self { store: Arc::new(store), prefix: Name::default(), url, is_bucket: false })
    }

    fn bucket(
        place: &str,
        bucket: &str,
        prefix: Name,
        environment: impl Iterator<Item = (String, String)>,
    ) -> Result<Self, StartError> {
        let wrong = |why: &dyn fmt::Display| StartError::Settings(format!("--store {place}: {why}"));
        let timeout = AmazonS3ConfigKey::Client(ClientConfigKey::Timeout);
        // The time of one request with its bytes: of the crate's 30 s a scene of some 100 MB has not enough. `within` ends others.
        let mut builder = AmazonS3Builder::new().with_config(timeout, "300 seconds");
        for (key, value) in environment.filter(|(key, _)| key.starts_with("AWS_")) {
            if let Ok(key) = key.to_ascii_lowercase().parse() {
                builder = builder.with_config(key, value);
            }
        }
        let setting = |key| builder.get_config_value(&key);
        let endpoint = setting(AmazonS3ConfigKey::S3Endpoint).or_else(|| setting(AmazonS3ConfigKey::Endpoint));
        let plain_http = setting(AmazonS3ConfigKey::Client(ClientConfigKey::AllowHttp)).is_some_and(|on| on == "true");
        if let Some(endpoint) = endpoint.filter(|endpoint| endpoint.starts_with("http://") && !plain_http) {
            return Err(wrong(&format_args!(
                "the endpoint {endpoint} is not encrypted: use https://, or set AWS_ALLOW_HTTP=true in a network of your own"
            )));
        }
        tls::install_provider();
        let store = builder.with_bucket_name(bucket).build().map_err(|error| wrong(&one_line(&error)))?;
        let url = place.trim_end_matches('/').to_owned();
        Ok(Self { store: Arc::new(store), prefix, url, is_bucket: true })
    }

    /// Writes the marker, and once more: a store that lets the second one through would let a late result replace a first.
    async fn try_out(&self) -> Result<(), (String, &'static str)> {
        let explain = |error: object_store::Error| {
            let advice = match &error {
                object_store::Error::NotFound { .. } => "There is no such bucket: make it, or name another.",
                object_store::Error::PermissionDenied { .. } | object_store::Error::Unauthenticated { .. } => {
                    "The keys in AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY must be allowed to get, put and delete there."
                }
                _ if self.is_bucket => {
                    "Look at AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, and whether the \
                     store can be reached from here."
                }
                _ => "Fronts and nodes write into this folder: name another with --store DIR.",
            };
            (one_line(&error), advice)
        };
        let marker = self.prefix.clone().join(MARKER);
        self.create(&marker, MARKER_TEXT.to_vec()).await.map_err(explain)?;
        if self.create(&marker, MARKER_TEXT.to_vec()).await.map_err(explain)? {
            let why = "the store overwrites what it was told to keep (If-None-Match)".to_owned();
            return Err((why, "Use a store that keeps the first of two blobs: AWS, MinIO, Ceph and R2 do."));
        }
        let found = self.store.get(&marker).await.map_err(explain)?.bytes().await.map_err(explain)?;
        if found != MARKER_TEXT {
            let why = format!("{MARKER} there is of another version of strahl");
            return Err((why, "Name another folder or prefix, or use the version that made this one."));
        }
        Ok(())
    }

    /// Looks for the marker. Without it the store itself is gone, such as a folder that is not mounted any more, and nothing is known
    /// of what is in it.
    pub(crate) async fn check(&self) -> Result<(), ObjectError> {
        match within(0, self.store.head(&self.prefix.clone().join(MARKER))).await? {
            Err(object_store::Error::NotFound { .. }) => {
                Err(ObjectError::Store(format!("{} is gone: it has no {MARKER} any more", self.url)))
            }
            found => Ok(found.map(|_| ())?),
        }
    }

    /// [`Self::check`] before something is written: a folder would be made anew, where it was mounted.
    async fn check_folder(&self) -> Result<(), ObjectError> {
        if self.is_bucket { Ok(()) } else { self.check().await }
    }

    /// Puts a blob, instead of the one of that name if there is one.
    pub(crate) async fn put(&self, name: &str, bytes: Vec<u8>) -> Result<(), ObjectError> {
        self.check_folder().await?;
        let size = bytes.len() as u64;
        within(size, self.store.put(&self.name(name)?, bytes.into())).await??;
        Ok(())
    }

    /// Puts a blob unless there is one of that name; whether it was put.
    pub(crate) async fn put_if_absent(&self, name: &str, bytes: Vec<u8>) -> Result<bool, ObjectError> {
        self.check_folder().await?;
        Ok(within(bytes.len() as u64, self.create(&self.name(name)?, bytes)).await??)
    }

    async fn create(&self, name: &Name, bytes: Vec<u8>) -> object_store::Result<bool> {
        let options = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        match self.store.put_opts(name, bytes.into(), options).await {
            Ok(_) => Ok(true),
            Err(object_store::Error::AlreadyExists { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// The bytes of a blob, if it is there. If its name is a SHA-256, they have that.
    pub(crate) async fn get(&self, name: &str, max: u64) -> Result<Option<Vec<u8>>, ObjectError> {
        let found = match within(0, self.store.get(&self.name(name)?)).await? {
            Err(object_store::Error::NotFound { .. }) => return self.check().await.map(|()| None),
            found => found?,
        };
        if found.meta.size > max {
            return Err(ObjectError::TooLarge { bytes: found.meta.size, max });
        }
        let bytes = Vec::from(within(found.meta.size, found.bytes()).await??);
        match digest_of(name) {
            Some(digest) if Sha256::digest(&bytes)[..] != digest => Err(ObjectError::Damaged(name.to_owned())),
            _ => Ok(Some(bytes)),
        }
    }

    /// Whether there is a blob of that name.
    pub(crate) async fn exists(&self, name: &str) -> Result<bool, ObjectError> {
        match within(0, self.store.head(&self.name(name)?)).await? {
            Err(object_store::Error::NotFound { .. }) => self.check().await.map(|()| false),
            found => Ok(found.map(|_| true)?),
        }
    }

    /// Whether there is any blob below a name.
    pub(crate) async fn has_any(&self, folder: &str) -> Result<bool, ObjectError> {
        let folder = self.name(folder)?;
        Ok(within(0, self.store.list(Some(&folder)).next()).await?.transpose()?.is_some())
    }

    /// Gives a blob another name, if there is one of the first.
    pub(crate) async fn rename(&self, from: &str, to: &str) -> Result<(), ObjectError> {
        match within(0, self.store.rename(&self.name(from)?, &self.name(to)?)).await? {
            Err(object_store::Error::NotFound { .. }) => Ok(()),
            renamed => Ok(renamed?),
        }
    }

    /// Deletes a blob, if there is one of that name.
    pub(crate) async fn delete(&self, name: &str) -> Result<(), ObjectError> {
        match within(0, self.store.delete(&self.name(name)?)).await? {
            Err(object_store::Error::NotFound { .. }) => Ok(()),
            deleted => Ok(deleted?),
        }
    }

    /// Deletes all blobs below a name.
    pub(crate) async fn delete_all(&self, folder: &str) -> Result<(), ObjectError> {
        let folder = self.name(folder)?;
        while let Some(blob) = within(0, self.store.list(Some(&folder)).next()).await?.transpose()? {
            match within(0, self.store.delete(&blob.location)).await? {
                Err(object_store::Error::NotFound { .. }) => {}
                deleted => deleted?,
            }
        }
        Ok(())
    }

    /// The URL of a blob: `s3://BUCKET/PREFIX/NAME` or `file:///FOLDER/NAME`.
    pub(crate) fn url(&self, name: &str) -> String {
        format!("{}/{name}", self.url)
    }

    fn name(&self, name: &str) -> Result<Name, ObjectError> {
        let name = plain(name)?;
        Ok(if self.prefix.as_ref().is_empty() { name } else { self.prefix.parts().chain(name.parts()).collect() })
    }
}

/// What a store answers, unless it takes too long for so many bytes: one that is silent holds up neither requests nor jobs.
async fn within<T>(bytes: u64, answer: impl Future<Output = T>) -> Result<T, ObjectError> {
    let limit = ANSWER + Duration::from_secs(bytes / SLOWEST);
    let silent = |_| ObjectError::Store(format!("the store has not answered within {} s", limit.as_secs()));
    tokio::time::timeout(limit, answer).await.map_err(silent)
}

/// The bucket that a place names and the prefix in it; none if it is a folder.
fn in_bucket(place: &str) -> Result<Option<(&str, Name)>, StartError> {
    let wrong = |why: &dyn fmt::Display| StartError::Settings(format!("--store {place}: {why}"));
    let Some((scheme, rest)) = place.split_once("://") else { return Ok(None) };
    if scheme != "s3" {
        return Err(wrong(&format_args!("{scheme}:// is not known: name a folder or s3://BUCKET/PREFIX")));
    }
    let rest = rest.trim_end_matches('/');
    let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
    if bucket.is_empty() {
        return Err(wrong(&"there is no bucket: write s3://BUCKET or s3://BUCKET/PREFIX"));
    }
    let prefix = if prefix.is_empty() { Name::default() } else { plain(prefix).map_err(|error| wrong(&error))? };
    Ok(Some((bucket, prefix)))
}

/// A name of plain parts: nothing that a file system or a URL reads in another way.
fn plain(name: &str) -> Result<Name, ObjectError> {
    let is_plain = |part: &str| {
        let letters = part.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-'));
        letters && !matches!(part, "" | "." | "..")
    };
    let wrong = || ObjectError::Name(name.chars().take(NAME_BYTES).collect());
    if name.len() > NAME_BYTES || !name.split('/').all(is_plain) {
        return Err(wrong());
    }
    Name::parse(name).map_err(|_| wrong())
}

/// The digest that a name consists of.
fn digest_of(name: &str) -> Option<Vec<u8>> {
    let last = name.rsplit('/').next()?;
    let stem = last.split('.').next()?;
    (stem.len() == 64).then(|| data_encoding::HEXLOWER.decode(stem.as_bytes()).ok()).flatten()
}

/// An error of the store, for a log or a terminal: its answers are XML of many lines.
fn one_line(error: &object_store::Error) -> String {
    let text = error.to_string();
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").chars().take(500).collect()
}

#[cfg(test)]
mod tests;
