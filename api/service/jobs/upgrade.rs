//! Folders of versions that had no marker: scenes had another digest, and pictures had none and lay in a folder for each job.
//! Their tiles are rendered again.

use super::files::Files;
use super::record::{Record, State, is_job_id};
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::storage::disk;
use std::fs;
use std::io;
use std::path::Path;

/// Where the folders of jobs were.
const JOBS: &str = "jobs";

/// Whether there are any.
pub(super) fn has_files(folder: &Path) -> bool {
    fs::read_dir(folder.join(JOBS)).is_ok_and(|mut jobs| jobs.next().is_some())
}

/// Brings the pictures of jobs to where they are now. Nothing could be checked in pictures; they are taken as they are.
pub(super) fn upgrade(folder: &Path, files: &Files, records: &[Record]) -> io::Result<()> {
    for record in records {
        let folder = folder.join(JOBS).join(&record.id);
        if record.state == State::Succeeded {
            if let Some(made) = fs::read(folder.join("picture")).ok().and_then(picture) {
                files.put_picture(record, &made)?;
            }
            if let Ok(png) = fs::read(folder.join("preview")) {
                files.put_preview(record, &png)?;
            }
        }
        for file in ["tiles", "picture", "picture~", "preview", "preview~"] {
            let _ = disk::remove(&folder.join(file));
        }
        // It stays if there is more in it.
        let _ = fs::remove_dir(folder);
    }
    let _ = fs::remove_dir(folder.join(JOBS));
    Ok(())
}

/// A line of JSON, and the picture.
fn picture(bytes: Vec<u8>) -> Option<PictureFile> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    Some(PictureFile::new(bytes[end + 1..].to_vec(), PictureMeta::stored(&bytes[..end])?))
}

/// Whether the path is one of theirs.
pub(super) fn is_ours(path: &[&str]) -> bool {
    match path {
        [JOBS] => true,
        [JOBS, job] => is_job_id(job),
        [JOBS, job, "tiles" | "picture" | "picture~" | "preview" | "preview~"] => is_job_id(job),
        _ => false,
    }
}
