//! The key file, which is read again whenever it changes, so that keys change without a restart.

use super::Access;
use super::keys::Keys;
use parking_lot::{Mutex, RwLock};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use std::{fs, io};
use tokio::time::interval;

/// Time between two checks of the file.
const PERIOD: Duration = Duration::from_secs(1);

/// When a file was written, and how long it is.
type State = Option<(SystemTime, u64)>;

/// The key file and the keys read from it.
#[derive(Debug)]
pub(crate) struct KeyFile {
    path: PathBuf,
    /// State of the file before it was read, so that no change is missed.
    seen: Mutex<State>,
    keys: RwLock<Arc<Keys>>,
}

impl KeyFile {
    /// Reads it for the first time.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let seen = Mutex::new(state(path));
        let keys = Keys::read(&fs::read_to_string(path)?, None).map_err(io::Error::other)?;
        Ok(Self { path: path.to_owned(), seen, keys: RwLock::new(Arc::new(keys)) })
    }

    /// The keys read last.
    pub(crate) fn keys(&self) -> Arc<Keys> {
        Arc::clone(&self.keys.read())
    }

    /// Reads the file again if it has changed. If it has mistakes, the keys stay as they were and the log says so.
    fn refresh(&self) {
        let now = state(&self.path);
        if std::mem::replace(&mut *self.seen.lock(), now) == now {
            return;
        }
        let text = fs::read_to_string(&self.path).map_err(|error| error.to_string());
        match text.and_then(|text| Keys::read(&text, Some(&self.keys()))) {
            Ok(new) => {
                let file = self.path.display();
                if new.is_empty() {
                    tracing::error!(%file, "there are no keys any more: nobody is let in");
                } else {
                    tracing::info!(%file, "the keys were read again");
                }
                *self.keys.write() = Arc::new(new);
            }
            Err(error) => tracing::error!(file = %self.path.display(), error, "the keys stay as they were"),
        }
    }
}

/// Reads the key file again whenever it changes, until the service ends.
pub(crate) async fn watch(access: Arc<Access>) {
    let Some(file) = &access.keys else { return };
    let mut ticks = interval(PERIOD);
    loop {
        ticks.tick().await;
        file.refresh();
    }
}

fn state(path: &Path) -> State {
    let about = fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}
