//! Writing results: `-` is standard output, everything else a file.

use super::failure::Failure;
use crate::service::storage::disk;
use serde::Serialize;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, chown};
use std::path::{Path, PathBuf};
use strahl::scene::{Problem, printable};

/// Writes all of a file, or to standard output for `-`.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if is_standard(path) {
        print(bytes)
    } else {
        replace(path, bytes, false).map_err(|error| Failure::writing(&path.display().to_string(), &error))
    }
}

/// Writes all of a file. A plain file is replaced as a whole, so the one before stays if that fails. What else there may be is written to:
/// pipes and devices, links, files with several names, and private ones, which a new file would not be from the start.
pub(super) fn replace(path: &Path, bytes: &[u8], durable: bool) -> io::Result<()> {
    let there = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return disk::write(path, &[bytes], durable),
        there => there?,
    };
    const READ_BY_ALL: u32 = 0o004;
    if !there.is_file() || there.nlink() > 1 || there.mode() & READ_BY_ALL == 0 {
        return fs::write(path, bytes);
    }
    // Who must not write the file must not replace it.
    OpenOptions::new().write(true).open(path)?;
    match disk::write(path, &[bytes], durable) {
        // The folder takes no other file, or this one is mounted by itself.
        Err(error) if matches!(error.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ResourceBusy) => {
            fs::write(path, bytes)
        }
        Err(error) => Err(error),
        Ok(()) => {
            // Only root can, and only root needs to.
            let _ = chown(path, Some(there.uid()), Some(there.gid()));
            fs::set_permissions(path, there.permissions())
        }
    }
}

/// The file for a result: the one on the command line, else one in the working directory with the name of the scene.
pub(super) fn file_of(named: Option<&Path>, scene: &str, ending: &str) -> PathBuf {
    named.map_or_else(|| format!("{}{ending}", stem(scene)).into(), Path::to_owned)
}

/// The name of a scene's file without folder and endings; `scene` for standard input.
fn stem(scene: &str) -> &str {
    let name = Path::new(scene).file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(name);
    let name = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    if matches!(name, "" | "-") { "scene" } else { name }
}

/// Reports the file of a result that was not named on the command line.
pub(super) fn tell(named: Option<&Path>, path: &Path) {
    if named.is_none() {
        say(&format!("wrote {}", path.display()));
    }
}

/// A line on standard error, which results are not written to.
pub(super) fn say(line: &str) {
    // Results are written even if this is not.
    let _ = writeln!(io::stderr().lock(), "{}", for_terminal(line));
}

/// Text whose lines cannot control a terminal.
pub(super) fn for_terminal(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

/// Writes lines for people to standard output.
pub(super) fn print_text(text: &str) -> Result<(), Failure> {
    print(for_terminal(text).as_bytes())
}

/// Writes the warnings of a scene to standard error. It is rendered all the same.
pub(super) fn warn(scene: &str, warnings: &[Problem]) {
    warnings.iter().for_each(|warning| say(&format!("warning: {scene}: {warning}")));
}

/// Writes to standard output.
pub(super) fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|error| Failure::writing("standard output", &error))
}

/// A value as indented JSON with a line end.
pub(super) fn pretty(value: &impl Serialize) -> Result<Vec<u8>, Failure> {
    let mut json = serde_json::to_vec_pretty(value)
        .map_err(|error| Failure::Input(format!("the result cannot be written as JSON: {error}")))?;
    json.push(b'\n');
    Ok(json)
}

/// Fails if two files cannot both be written: the main one, and one that `flag` names.
pub(super) fn check_both(what: &str, main: &Path, flag: &str, beside: Option<&Path>) -> Result<(), Failure> {
    if is_standard(main) && beside.is_some_and(is_standard) {
        return Err(Failure::Usage(format!("the {what} and {flag} cannot both go to standard output")));
    }
    check_folder(main)?;
    beside.map_or(Ok(()), check_folder)
}

/// Checks before a long render that the folder of its picture exists.
pub(super) fn check_folder(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => Err(Failure::Input(format!(
            "{} cannot be written: there is no folder {}",
            path.display(),
            folder.display()
        ))),
        _ => Ok(()),
    }
}

/// Whether a path means standard output.
pub(super) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_file_that_cannot_be_replaced_stays_and_a_link_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["a.png", "b.png"].map(|name| folder.path().join(name));
        write(&file, b"one").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"two").unwrap();
        assert_eq!((fs::read(&file).unwrap(), link.is_symlink()), (b"two".to_vec(), true));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        for mode in [0o600, 0o755] {
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            write(&file, b"three").unwrap();
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, mode);
        }
        let [other, to_nothing] = ["c.png", "d.png"].map(|name| folder.path().join(name));
        fs::hard_link(&file, &other).unwrap();
        write(&file, b"four").unwrap();
        assert_eq!(fs::read(&other).unwrap(), b"four");
        std::os::unix::fs::symlink("e.png", &to_nothing).unwrap();
        write(&to_nothing, b"five").unwrap();
        assert_eq!(fs::read(folder.path().join("e.png")).unwrap(), b"five");
        write(Path::new("/dev/null"), b"six").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        assert!(write(&file.join("x"), b"").is_err());
    }

    #[test]
    fn lines_do_not_control_a_terminal() {
        assert_eq!(
            for_terminal("a\u{1b}[31m\u{7}\tb\r\nc\u{202e}\u{9b}ä"),
            "a\\u{1b}[31m\\u{7}\tb\\r\nc\\u{202e}\\u{9b}ä"
        );
    }

    #[test]
    fn results_are_named_after_their_scene() {
        for (scene, stem_of_it) in
            [("scenes/whitted/whitted.json", "whitted"), ("a/balls.nff.gz", "balls"), ("ball", "ball"), ("-", "scene")]
        {
            assert_eq!(stem(scene), stem_of_it);
        }
        assert_eq!(file_of(None, "a/ball.json", ".png"), Path::new("ball.png"));
        assert_eq!(file_of(Some(Path::new("b.exr")), "a/ball.json", ".png"), Path::new("b.exr"));
    }
}
