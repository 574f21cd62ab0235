//! Files that no job needs. A crash may have left them; or the database is older than they are, since somebody has put a
//! copy of it back. So each is kept as long as jobs are, unless there is no room.

use super::Jobs;
use super::files::{job_of, picture_of};
use super::registry::Registry;
use crate::service::storage::disk;
use std::time::Duration;

impl Jobs {
    /// At the start: removes those that are too old, and says how many others there are.
    pub(super) fn check_orphans(&self) {
        let registry = self.registry.lock();
        let is_final = |id: &str| registry.jobs.get(id).is_some_and(|job| job.record().state.is_final());
        self.files
            .all_tiles()
            .iter()
            .filter(|name| is_final(job_of(name)))
            .for_each(|name| self.files.remove_tiles(name));
        let age = self.limits.keep_pictures + self.limits.keep_records;
        let (removed, kept) = self.remove_orphans(&registry, age);
        if removed + kept > 0 {
            tracing::warn!(
                removed,
                kept,
                ?age,
                "files that no job needs: those of this age go, or all when there is no room"
            );
        }
    }

    /// Removes those that are at least so old; how many went and how many stay.
    pub(super) fn remove_orphans(&self, registry: &Registry, age: Duration) -> (usize, usize) {
        // What another version wrote is not for this one to remove.
        if self.has_other_records {
            return (0, 0);
        }
        let (mut removed, mut kept) = (0, 0);
        let mut count = |is_old: bool| if is_old { removed += 1 } else { kept += 1 };
        let (scenes, pictures) = (&self.files.scenes, &self.files.pictures);
        let orphans =
            scenes.own_names().into_iter().filter(|name| !registry.scenes.has(name)).map(|name| (scenes, name));
        let of_pictures = pictures.own_names().into_iter().filter(|name| !registry.pictures.has(picture_of(name)));
        for (store, name) in orphans.chain(of_pictures.map(|name| (pictures, name))) {
            let is_old = store.age(&name) >= age;
            count(is_old);
            if is_old {
                store.remove(&name);
            }
        }
        for name in self.files.all_tiles().iter().filter(|name| !registry.jobs.contains_key(job_of(name))) {
            let is_old = disk::age(&self.files.tiles(name)) >= age;
            count(is_old);
            if is_old {
                self.files.remove_tiles(name);
            }
        }
        (removed, kept)
    }
}
