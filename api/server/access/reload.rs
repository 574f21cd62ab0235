//! The key file is read again whenever it changes, so that keys come and go without a restart.

use super::keys::Keys;
use crate::server::App;
use std::fs;
use std::path::Path;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, SystemTime};
use tokio::time::interval;

/// How often it is looked at.
const PERIOD: Duration = Duration::from_secs(1);

/// Looks at the key file until the service ends. A file with mistakes changes nothing but the log.
pub(in crate::server) async fn watch(service: App) {
    let Some((path, keys)) = &service.access.keys else { return };
    let mut seen = state(path);
    let mut ticks = interval(PERIOD);
    loop {
        ticks.tick().await;
        let now = state(path);
        if now != seen {
            seen = now;
            read(path, keys);
        }
    }
}

/// When it was written, and how long it is.
fn state(path: &Path) -> Option<(SystemTime, u64)> {
    let about = fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}

fn read(path: &Path, keys: &RwLock<Arc<Keys>>) {
    let before = Arc::clone(&keys.read().unwrap_or_else(PoisonError::into_inner));
    let text = fs::read_to_string(path).map_err(|error| error.to_string());
    match text.and_then(|text| Keys::read(&text, Some(&before))) {
        Ok(new) => {
            *keys.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(new);
            tracing::info!(file = %path.display(), "the keys were read again");
        }
        Err(error) => tracing::error!(file = %path.display(), error, "the keys stay as they were"),
    }
}
