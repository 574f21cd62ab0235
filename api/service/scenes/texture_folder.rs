//! The folder of textures that scenes may name. Nothing outside of it can be read.

use crate::service::hash::sha256;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use strahl::scene::Files;
use strahl::scene::hashes::hash_of;
use strahl::scene::limits::PICTURE_BYTES;

/// A folder and everything below it. Links are followed only inside of it.
#[derive(Debug)]
pub(crate) struct TextureFolder(PathBuf);

impl TextureFolder {
    /// A folder that exists.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let path = path.canonicalize()?;
        if path.is_dir() { Ok(Self(path)) } else { Err(io::ErrorKind::NotADirectory.into()) }
    }
}

impl Files for TextureFolder {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let hash = hash_of(name);
        let name = hash.unwrap_or(name);
        let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        if name.is_empty() || !Path::new(name).components().all(plain) {
            return Err("is no file's name: write it relative to the folder of pictures, without \"..\"".into());
        }
        let cannot = |error: io::Error| format!("cannot be read: {error}");
        let path = self.0.join(name).canonicalize().map_err(cannot)?;
        if !path.starts_with(&self.0) {
            return Err("leads out of the folder of pictures".into());
        }
        // Opening a pipe would wait for a writer.
        if !path.is_file() {
            return Err("is no file".into());
        }
        let mut bytes = Vec::new();
        File::open(path).map_err(cannot)?.take(PICTURE_BYTES.max + 1).read_to_end(&mut bytes).map_err(cannot)?;
        match hash {
            Some(hash) if sha256(&bytes) != hash => Err("is in a file with other bytes than its name says".into()),
            _ => Ok(bytes),
        }
    }

    /// An asset is a file that has its digits as a name.
    fn has_asset(&self, hash: &str) -> bool {
        self.0.join(hash).is_file()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_outside_is_read() {
        let root = std::env::temp_dir().join(format!("strahl-folder-{}", std::process::id()));
        let inside = root.join("inside");
        std::fs::create_dir_all(inside.join("deep")).unwrap();
        std::fs::write(root.join("secret"), b"no").unwrap();
        std::fs::write(inside.join("deep/a.png"), b"yes").unwrap();
        let folder = TextureFolder::open(&inside).unwrap();
        assert_eq!(folder.read("deep/a.png").unwrap(), b"yes");
        assert_eq!(folder.read("./deep/a.png").unwrap(), b"yes");
        let absolute = root.join("secret");
        for name in
            ["", "../secret", "deep/../../secret", "deep/../deep/a.png", "deep", "none", absolute.to_str().unwrap()]
        {
            assert!(folder.read(name).is_err(), "{name}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&absolute, inside.join("link")).unwrap();
            assert!(folder.read("link").unwrap_err().contains("leads out"));
        }
        std::fs::remove_dir_all(root).unwrap();
    }
}
