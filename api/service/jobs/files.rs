//! The files of jobs: texts of scenes and pictures, which jobs share, and tiles of the jobs that are rendered.

use super::Jobs;
use super::job::{Job, locked};
use super::record::{Record, sha256};
use super::registry::Registry;
use super::upgrade;
use crate::service::farm::Farm;
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::scenes::ids::is_image_name;
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::blobs::Blobs;
use crate::service::storage::disk;
use crate::service::storage::folder::FolderKind;
use crate::service::storage::shared_blobs::SharedBlobs;
use std::io;
use std::path::{Path, PathBuf};
use uuid::Uuid;

/// What the name of a small picture ends with, after that of the picture.
const PREVIEW: &str = ".preview";

/// The files. All of them are durable before the record that needs them.
#[derive(Debug)]
pub(super) struct Files {
    /// Texts of scenes by their SHA-256.
    pub(super) scenes: Box<dyn Blobs>,
    /// Pictures by the names of their images, or else of their jobs, and small ones beside them.
    pub(super) pictures: Box<dyn Blobs>,
    /// Whether other fronts have the scenes and pictures, too.
    pub(super) shared: bool,
    /// Of finished tiles, by job.
    tiles: PathBuf,
}

impl Files {
    /// Opens the folders in a folder, or makes them; whether what is put there outlives a power cut, and whether an old version
    /// may have written what is there.
    pub(super) fn open(folder: &Path, durable: bool, is_old: bool) -> io::Result<Self> {
        let scenes = BlobStore::open(&folder.join("scenes"), u64::MAX, BlobKind { is_name: is_hash, durable })?;
        let pictures = BlobStore::open(&folder.join("pictures"), u64::MAX, BlobKind { is_name: is_picture, durable })?;
        if is_old {
            scenes.upgrade(|name, text| sha256(text) == name)?;
        }
        let tiles = tiles_in(folder)?;
        Ok(Self { scenes: Box::new(scenes), pictures: Box::new(pictures), shared: false, tiles })
    }

    /// Those that other fronts have, too; only tiles that are rendered here are in a folder.
    pub(super) fn shared(farm: &Farm, folder: &Path) -> io::Result<Self> {
        let shelf = |name, by_digest| SharedBlobs::new(farm.objects.clone(), farm.runtime.clone(), name, by_digest);
        let (scenes, pictures) = (shelf("scenes", true), shelf("pictures", false));
        let tiles = tiles_in(folder)?;
        Ok(Self { scenes: Box::new(scenes), pictures: Box::new(pictures), shared: true, tiles })
    }

    /// Whether there is any.
    pub(super) fn is_empty(&self) -> bool {
        self.bytes() == 0 && self.jobs_with_tiles().is_empty()
    }

    /// Bytes of scenes and of finished pictures.
    pub(super) fn bytes(&self) -> u64 {
        self.scenes.bytes() + self.pictures.bytes()
    }

    /// Bytes of a text of a scene, or of a picture with its small one.
    pub(super) fn size(&self, name: &str) -> u64 {
        let pictures = [name, &(name.to_owned() + PREVIEW)].map(|name| self.pictures.size(name));
        pictures.into_iter().chain([self.scenes.size(name)]).flatten().sum()
    }

    /// Takes note of what other fronts keep for a job.
    pub(super) fn learn(&self, record: &Record) {
        if record.needs_scene() {
            self.scenes.learn(&record.spec.scene, record.text_bytes);
        }
        if record.has_picture() {
            self.pictures.learn(&record.picture_name(), record.stats.picture_bytes);
        }
    }

    /// What is known about it.
    pub(super) fn meta(&self, record: &Record) -> Option<PictureMeta> {
        PictureMeta::stored(&self.pictures.head(&record.picture_name())?)
    }

    /// The last preview, a PNG.
    pub(super) fn preview(&self, record: &Record) -> Option<Vec<u8>> {
        Some(self.pictures.get(&preview_name(record))?.body)
    }

    /// Puts a picture on disk.
    pub(super) fn put_picture(&self, record: &Record, made: &PictureFile) -> io::Result<()> {
        self.pictures.put(&record.picture_name(), &made.head(), &made.bytes)
    }

    /// Puts a small picture beside it.
    pub(super) fn put_preview(&self, record: &Record, png: &[u8]) -> io::Result<()> {
        self.pictures.put(&preview_name(record), b"", png)
    }

    /// Removes a picture and the small one beside it.
    pub(super) fn remove_picture(&self, record: &Record) {
        self.pictures.remove(&record.picture_name());
        self.pictures.remove(&preview_name(record));
    }

    /// Where the tiles of a job are.
    pub(super) fn tiles(&self, id: &str) -> PathBuf {
        self.tiles.join(id)
    }

    /// Removes the tiles of a job.
    pub(super) fn remove_tiles(&self, id: &str) {
        if let Err(error) = disk::remove(&self.tiles(id))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(job = id, %error, "a job's tiles cannot be removed");
        }
    }

    /// The jobs that there are tiles of.
    pub(super) fn jobs_with_tiles(&self) -> Vec<String> {
        let files = std::fs::read_dir(&self.tiles).into_iter().flatten().flatten();
        files.filter_map(|file| file.file_name().into_string().ok()).filter(|name| is_job(name)).collect()
    }
}

impl Jobs {
    /// Puts the picture of a job on disk. It is held until [`Self::let_go`], before which the job's record has to say that it
    /// is the job's.
    pub(super) fn keep_picture(&self, record: &Record, made: &PictureFile, preview: &[u8]) -> io::Result<()> {
        locked(&self.registry).pictures.add(&record.picture_name());
        let kept = self.files.put_picture(record, made).and_then(|()| self.files.put_preview(record, preview));
        kept.inspect_err(|_| self.let_go(record))
    }

    /// The picture of a job is not held any more.
    pub(super) fn let_go(&self, record: &Record) {
        locked(&self.registry).release_picture(record, &self.files);
    }

    /// Puts the picture of a job on disk again, unless the job has expired meanwhile.
    pub(crate) fn restore_picture(&self, job: &Job, made: &PictureFile) {
        let record = job.record().clone();
        locked(&self.registry).pictures.add(&record.picture_name());
        if let Err(error) = self.files.put_picture(&record, made) {
            tracing::warn!(job = record.id, %error, "a picture that was rendered again cannot be kept");
        }
        self.let_go(&record);
    }
}

/// Where other fronts have the files, too, they go later: one of those may be about to need them (`leftovers.rs`).
impl Registry {
    /// A job needs the text of its scene no more.
    pub(super) fn release_scene(&mut self, record: &Record, files: &Files) {
        let name = &record.spec.scene;
        if self.scenes.remove(name) {
            if files.shared { files.scenes.forget(name) } else { files.scenes.remove(name) }
        }
    }

    /// A job needs no file any more.
    pub(super) fn release_files(&mut self, record: &Record, files: &Files) {
        if record.has_picture() {
            self.release_picture(record, files);
        }
        if record.needs_scene() {
            self.release_scene(record, files);
        }
    }

    /// A job has its picture no more.
    pub(super) fn release_picture(&mut self, record: &Record, files: &Files) {
        let name = record.picture_name();
        if self.pictures.remove(&name) {
            if files.shared { files.pictures.forget(&name) } else { files.remove_picture(record) }
        }
    }
}

/// Name of the picture that a file is, or that it is a small one of.
pub(super) fn picture_of(name: &str) -> &str {
    name.strip_suffix(PREVIEW).unwrap_or(name)
}

/// The folder of tiles in a folder.
fn tiles_in(folder: &Path) -> io::Result<PathBuf> {
    let tiles = folder.join("tiles");
    disk::create_folder(&tiles)?;
    Ok(tiles)
}

fn preview_name(record: &Record) -> String {
    record.picture_name() + PREVIEW
}

/// The folder of `--data`.
pub(crate) const DATA: FolderKind = FolderKind {
    flag: "--data",
    name: "data",
    is_ours: |path| match path {
        ["jobs.redb" | "jobs.redb.new" | "scenes" | "pictures" | "tiles"] => true,
        ["scenes", name] => is_hash(name) || disk::is_unfinished(name),
        ["pictures", name] => is_picture(name) || disk::is_unfinished(name),
        ["tiles", name] => is_job(name),
        _ => upgrade::is_ours(path, is_job),
    },
};

/// Whether it is a SHA-256 in hexadecimal digits.
fn is_hash(name: &str) -> bool {
    name.len() == 64 && name.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// Whether it is an id of a job.
fn is_job(name: &str) -> bool {
    Uuid::try_parse(name).is_ok_and(|id| id.to_string() == name)
}

fn is_picture(name: &str) -> bool {
    is_image_name(name) || is_job(picture_of(name))
}
