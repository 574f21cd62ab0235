//! The files of jobs: texts of scenes and pictures, which jobs share, and tiles of the jobs that are rendered.

use super::Jobs;
use super::finish::JobFiles;
use super::job::Job;
use super::record::{Record, is_job_id};
use super::registry::Registry;
use super::upgrade;
use crate::service::assets;
use crate::service::farm::Farm;
use crate::service::hash::sha256;
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::scenes::ids::is_image_name;
use crate::service::storage::blob_store::{BlobKind, BlobStore};
use crate::service::storage::blobs::Blobs;
use crate::service::storage::disk;
use crate::service::storage::folder::FolderKind;
use crate::service::storage::shared_blobs::SharedBlobs;
use std::io;
use std::path::{Path, PathBuf};
use strahl::scene::hashes::is_hash;

/// What the name of a small picture ends with, after that of the picture.
const PREVIEW: &str = ".preview";
/// What is between a job and the number of a frame in the name of the frame.
const FRAME: char = '_';

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

    /// Whether the folders are there.
    pub(super) fn are_there(&self) -> bool {
        self.scenes.is_there() && self.pictures.is_there() && self.tiles.is_dir()
    }

    /// Whether anything can be put into the folders now.
    pub(super) fn are_writable(&self) -> bool {
        self.scenes.is_writable() && self.pictures.is_writable() && disk::takes_files(&self.tiles)
    }

    /// Whether there is any.
    pub(super) fn is_empty(&self) -> bool {
        self.bytes() == 0 && self.all_tiles().is_empty()
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
            let names = record.picture_names();
            let bytes = record.stats.picture_bytes / names.len().max(1) as u64;
            names.iter().for_each(|name| self.pictures.learn(name, bytes));
        }
    }

    /// What is known about it.
    pub(super) fn meta(&self, record: &Record) -> Option<PictureMeta> {
        PictureMeta::stored(&self.pictures.head(&record.picture_name()).ok()??)
    }

    /// The last preview, a PNG.
    pub(super) fn preview(&self, record: &Record) -> Option<Vec<u8>> {
        Some(self.pictures.get(&preview_name(record)).ok()??.body)
    }

    /// Puts a picture on disk.
    pub(super) fn put_picture(&self, record: &Record, made: &PictureFile) -> io::Result<()> {
        self.pictures.put(&record.picture_name(), &made.head(), &made.bytes)
    }

    /// Puts a small picture beside it.
    pub(super) fn put_preview(&self, record: &Record, png: &[u8]) -> io::Result<()> {
        self.pictures.put(&preview_name(record), b"", png)
    }

    /// What is known about a frame.
    pub(super) fn frame_meta(&self, id: &str, number: u32) -> io::Result<Option<PictureMeta>> {
        let head = self.pictures.head(&frame_name(id, number))?;
        Ok(head.and_then(|head| PictureMeta::stored(&head)))
    }

    /// The small picture of a frame, a PNG.
    pub(super) fn small_frame(&self, id: &str, number: u32) -> io::Result<Option<Vec<u8>>> {
        Ok(self.pictures.get(&(frame_name(id, number) + PREVIEW))?.map(|blob| blob.body))
    }

    /// Puts a frame on disk: first its small picture, since the frame is finished when it is there itself.
    pub(super) fn put_frame(&self, id: &str, number: u32, JobFiles { made, preview }: &JobFiles) -> io::Result<()> {
        let name = frame_name(id, number);
        self.pictures.put(&(name.clone() + PREVIEW), b"", preview)?;
        self.pictures.put(&name, &made.head(), &made.bytes)
    }

    /// What a job has written: it grows while the job gets on. A finished frame counts more than all tiles of the next one.
    pub(super) fn written(&self, record: &Record) -> u64 {
        let of_job = self.all_tiles().into_iter().filter(|name| job_of(name) == record.id);
        let tiles: u64 = of_job.filter_map(|name| Some(std::fs::metadata(self.tiles(&name)).ok()?.len())).sum();
        let has = |number: &u32| self.pictures.size(&frame_name(&record.id, *number)).is_some();
        let frames = record.frames.map_or(0, |frames| (0..frames.count).filter(has).count());
        tiles.min(u64::from(u32::MAX)) + ((frames as u64) << 32)
    }

    /// Removes a picture and the small one beside it.
    pub(super) fn remove_picture(&self, name: &str) {
        self.pictures.remove(name);
        self.pictures.remove(&(name.to_owned() + PREVIEW));
    }

    /// Where the tiles of a job's picture, or of a frame, are.
    pub(super) fn tiles(&self, name: &str) -> PathBuf {
        self.tiles.join(name)
    }

    /// Removes them.
    pub(super) fn remove_tiles(&self, name: &str) {
        if let Err(error) = disk::remove(&self.tiles(name))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(name, %error, "tiles cannot be removed");
        }
    }

    /// Removes all tiles of some jobs.
    pub(super) fn remove_tiles_of(&self, ids: &[String]) {
        let names = self.all_tiles().into_iter().filter(|name| ids.iter().any(|id| id == job_of(name)));
        names.for_each(|name| self.remove_tiles(&name));
    }

    /// The names of all pictures and frames that there are tiles of.
    pub(super) fn all_tiles(&self) -> Vec<String> {
        let files = std::fs::read_dir(&self.tiles).into_iter().flatten().flatten();
        files.filter_map(|file| file.file_name().into_string().ok()).filter(|name| is_work(name)).collect()
    }
}

impl Jobs {
    /// Puts the picture of a job on disk. It is held until [`Self::let_go`], before which the job's record has to say that it
    /// is the job's.
    pub(super) fn keep_picture(&self, record: &Record, made: &PictureFile, preview: &[u8]) -> io::Result<()> {
        self.registry.lock().pictures.add(&record.picture_name());
        let kept = self.files.put_picture(record, made).and_then(|()| self.files.put_preview(record, preview));
        kept.inspect_err(|_| self.let_go(record))
    }

    /// The pictures of a job are not held any more.
    pub(super) fn let_go(&self, record: &Record) {
        self.registry.lock().release_pictures(record, &self.files);
    }

    /// Puts the picture of a job on disk again, unless the job has expired meanwhile.
    pub(crate) fn restore_picture(&self, job: &Job, made: &PictureFile) {
        let record = job.record().clone();
        self.registry.lock().pictures.add(&record.picture_name());
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
        if record.has_pictures() {
            self.release_pictures(record, files);
        }
        if record.needs_scene() {
            self.release_scene(record, files);
        }
    }

    /// A job has its pictures no more.
    pub(super) fn release_pictures(&mut self, record: &Record, files: &Files) {
        for name in record.picture_names() {
            if self.pictures.remove(&name) {
                if files.shared { files.pictures.forget(&name) } else { files.remove_picture(&name) }
            }
        }
    }
}

/// Name of the picture that a file is, or that it is a small one of.
pub(super) fn picture_of(name: &str) -> &str {
    name.strip_suffix(PREVIEW).unwrap_or(name)
}

/// The job that a picture or a frame is of.
pub(super) fn job_of(name: &str) -> &str {
    name.split(FRAME).next().unwrap_or(name)
}

/// Name of the file of a frame.
pub(super) fn frame_name(job: &str, number: u32) -> String {
    format!("{job}{FRAME}{number}")
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
        ["jobs.redb" | "jobs.redb.new" | "scenes" | "pictures" | "tiles" | "assets"] => true,
        ["assets", name] => assets::is_name(name) || disk::is_unfinished(name),
        ["scenes", name] => is_hash(name) || disk::is_unfinished(name),
        ["pictures", name] => is_picture(name) || disk::is_unfinished(name),
        ["tiles", name] => is_work(name),
        _ => upgrade::is_ours(path),
    },
};

/// Whether it is the name of a job or of a frame.
fn is_work(name: &str) -> bool {
    let is_number = |text: &str| text.parse().is_ok_and(|number: u32| number.to_string() == text);
    is_job_id(job_of(name)) && name.split_once(FRAME).is_none_or(|(_, number)| is_number(number))
}

fn is_picture(name: &str) -> bool {
    is_image_name(name) || is_work(picture_of(name))
}
