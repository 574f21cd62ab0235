//! Assets: files that tenants have sent once, and that scenes name by their SHA-256: models and pictures.
//!
//! The bytes are kept once. They belong to the tenants that have sent them, each of which has a claim: for all others they are
//! missing, since a hash is no permission. Each tenant's claims have a number of bytes together. The one needed longest ago goes
//! first, but none that a kept scene or a job names. In a farm, where others may name them, none goes by itself.
//!
//! A tenant cannot delete what a job of its own needs that has not ended. Another front may accept such a job at the same time:
//! who deletes looks for jobs after the claim is gone, and who accepts a job looks for the claim after the job is written down,
//! so that one of the two sees the other.

mod asset_store;

pub(crate) use asset_store::{in_store, is_in_store, is_name};

use crate::service::error::{Error, StartError};
use crate::service::storage::objects::Objects;
use asset_store::AssetStore;
use lru::LruCache;
use parking_lot::Mutex;
use std::collections::{HashMap, HashSet};
use std::io;
use std::path::Path;
use strahl::scene::assets::is_hash;
use tokio::runtime::Handle;

/// Assets of one tenant: each has two files and some entries in memory, however small it is.
pub(crate) const ASSETS: usize = 100_000;
/// Notes of scenes after which it is looked which of them are still kept.
const NOTES: usize = 1_024;

/// The assets of all tenants.
#[derive(Debug)]
pub(crate) struct Assets {
    store: AssetStore,
    /// Bytes of one tenant's.
    most: u64,
    /// Number of one tenant's.
    most_assets: usize,
    /// Held by who changes what is on the store.
    changes: Mutex<()>,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// Bytes of each tenant's assets. Of a farm those that this process has had to do with.
    claims: HashMap<String, LruCache<String, u64>>,
    /// What kept scenes name, by their ids.
    named: HashMap<String, Vec<String>>,
}

/// An asset that was sent.
#[derive(Debug)]
pub(crate) struct Sent {
    /// Its SHA-256.
    pub(crate) hash: String,
    /// Whether the tenant has not had it.
    pub(crate) is_new: bool,
}

impl Assets {
    /// Those in a folder, and whether they outlive a power cut.
    pub(crate) fn open(path: &Path, most: u64, durable: bool) -> Result<Self, StartError> {
        let wrong = |error: io::Error| StartError::Settings(format!("{}: {error}", path.display()));
        let assets = Self::on(AssetStore::folder(path, durable).map_err(wrong)?, most);
        assets.learn();
        Ok(assets)
    }

    /// Those in the store of a farm.
    pub(crate) fn shared(objects: Objects, runtime: Handle, most: u64) -> Self {
        Self::on(AssetStore::Store(objects, runtime), most)
    }

    fn on(store: AssetStore, most: u64) -> Self {
        Self { store, most, most_assets: ASSETS, changes: Mutex::default(), known: Mutex::default() }
    }

    /// Reads what there is: the claims, the oldest first, and what kept scenes name.
    fn learn(&self) {
        let Some(blobs) = self.store.listed() else { return };
        let mut names = blobs.names();
        names.sort_by_cached_key(|name| std::cmp::Reverse(blobs.age(name)));
        let mut known = self.known.lock();
        for name in names {
            match name.split_once('.') {
                Some((hash, tenant)) => {
                    if let Some(bytes) = self.store.claimed(hash, tenant).filter(|_| blobs.has(hash)) {
                        known.add(tenant, hash, bytes);
                    } else if blobs.head(&name).is_ok() {
                        // It is damaged, or its bytes are gone; what cannot be read now may be whole.
                        blobs.remove(&name);
                    }
                }
                None if is_hash(&name) => {}
                None => {
                    let listed = blobs.head(&name).ok().flatten().unwrap_or_default();
                    let hashes = String::from_utf8_lossy(&listed).split_whitespace().map(str::to_owned).collect();
                    known.named.insert(name, hashes);
                }
            }
        }
        let of_tenants: HashSet<&String> =
            known.claims.values().flat_map(|claims| claims.iter().map(|(hash, _)| hash)).collect();
        let is_left = |name: &String| is_hash(name) && !of_tenants.contains(name);
        // A process ended before it wrote the claim.
        blobs.names().iter().filter(|name| is_left(name)).for_each(|name| _ = blobs.remove(name));
    }

    /// Keeps bytes for a tenant. If there is no room, those that it needed longest ago go, but for what `named` names, and for
    /// what scenes name of which `has_scene` says that they are kept.
    pub(crate) fn keep(
        &self,
        tenant: &str,
        hash: &str,
        bytes: &[u8],
        named: impl FnOnce() -> HashSet<String>,
        has_scene: impl Fn(&str) -> bool,
    ) -> Result<bool, Error> {
        let _alone = self.changes.lock();
        // Who sends bytes again may know that those on the store are damaged.
        let is_whole = self.store.get(hash).is_some();
        if is_whole && self.owns(tenant, hash) {
            return Ok(false);
        }
        self.known.lock().remove(tenant, hash);
        self.make_room(tenant, bytes.len() as u64, named, has_scene)?;
        let put = || {
            if !is_whole {
                self.store.put(hash, bytes)?;
            }
            self.store.claim(hash, tenant, bytes.len() as u64)?;
            // Another front may have removed them with the last claim before this one.
            if self.store.has(hash) { Ok(()) } else { self.store.put(hash, bytes) }
        };
        put().map_err(|error: io::Error| Error::io("the asset cannot be kept", &error))?;
        self.known.lock().add(tenant, hash, bytes.len() as u64);
        Ok(true)
    }

    fn make_room(
        &self,
        tenant: &str,
        bytes: u64,
        named: impl FnOnce() -> HashSet<String>,
        has_scene: impl Fn(&str) -> bool,
    ) -> Result<(), Error> {
        if bytes > self.most {
            return Err(Error::TooLarge(
                "the asset is larger than all assets of a tenant may be together (asset_bytes)",
            ));
        }
        let full = Error::TooLarge(
            "there is no room for the asset (asset_bytes, assets): delete some with DELETE /v1/assets/{sha256}, or the scenes and jobs that \
             name them",
        );
        let has_room = |left: u64, assets: usize| left + bytes <= self.most && assets < self.most_assets;
        let (mut left, mut assets) = self.known.lock().sum(tenant);
        if has_room(left, assets) {
            return Ok(());
        }
        if self.store.listed().is_none() {
            return Err(full);
        }
        let mut needed = named();
        needed.extend(self.of_scenes(has_scene));
        let (oldest, mut going) = (self.known.lock().oldest(tenant), Vec::new());
        for (hash, size) in oldest.into_iter().filter(|(hash, _)| !needed.contains(hash)) {
            if has_room(left, assets) {
                break;
            }
            (left, assets) = (left - size, assets - 1);
            going.push(hash);
        }
        if !has_room(left, assets) {
            return Err(full);
        }
        for hash in &going {
            let gone = self.unclaim(tenant, hash).and_then(|()| self.store.remove_unclaimed(hash));
            gone.unwrap_or_else(|error| tracing::error!(hash, %error, "an asset cannot be deleted"));
        }
        Ok(())
    }

    /// What kept scenes name. Those that are not kept any more are forgotten.
    fn of_scenes(&self, has_scene: impl Fn(&str) -> bool) -> HashSet<String> {
        let mut known = self.known.lock();
        let gone: Vec<String> = known.named.keys().filter(|id| !has_scene(id)).cloned().collect();
        for id in &gone {
            known.named.remove(id);
            self.store.listed().inspect(|blobs| _ = blobs.remove(id));
        }
        known.named.values().flatten().cloned().collect()
    }

    /// Notes what a scene names that is kept from now on, and now and then forgets those of which `has_scene` says that they are
    /// not kept any more.
    pub(crate) fn note_scene(&self, id: &str, hashes: &[String], has_scene: impl Fn(&str) -> bool) {
        if hashes.is_empty() || self.known.lock().named.contains_key(id) {
            return;
        }
        let Some(blobs) = self.store.listed() else { return };
        if self.known.lock().named.len() % NOTES == NOTES - 1 {
            self.of_scenes(has_scene);
        }
        if let Err(error) = blobs.put(id, hashes.join("\n").as_bytes(), b"") {
            tracing::warn!(id, %error, "it cannot be written down which assets a scene names");
        }
        self.known.lock().named.insert(id.to_owned(), hashes.to_vec());
    }

    /// Whether this process knows that a tenant has sent the bytes of a hash, whether they are there or not. It never waits. This
    /// counts as a use.
    pub(crate) fn knows(&self, tenant: &str, hash: &str) -> bool {
        self.known.lock().claims.get_mut(tenant).is_some_and(|claims| claims.get(hash).is_some())
    }

    /// Whether a tenant has sent the bytes of a hash, and they are there. In a farm it may wait for the store. This counts as a use.
    pub(crate) fn owns(&self, tenant: &str, hash: &str) -> bool {
        if self.store.listed().is_some() {
            return self.knows(tenant, hash) && self.store.has(hash);
        }
        // Another front may have heard of it, or taken it back.
        let claimed = self.store.claimed(hash, tenant).filter(|_| self.store.has(hash));
        let mut known = self.known.lock();
        match claimed {
            Some(bytes) => known.add(tenant, hash, bytes),
            None => known.remove(tenant, hash),
        }
        claimed.is_some()
    }

    /// Whether the bytes of a hash are there, whoever has sent them.
    pub(crate) fn exists(&self, hash: &str) -> bool {
        self.store.has(hash)
    }

    /// Fails if it cannot be known now which assets there are: what is missing may only be out of reach.
    pub(crate) fn check_store(&self) -> Result<(), Error> {
        self.store.check().map_err(|error| Error::io("assets cannot be looked for", &error))
    }

    /// Bytes of an asset of a tenant.
    pub(crate) fn size(&self, tenant: &str, hash: &str) -> Option<u64> {
        self.owns(tenant, hash).then(|| self.known.lock().claims.get(tenant)?.peek(hash).copied()).flatten()
    }

    /// An asset of a tenant.
    pub(crate) fn get(&self, tenant: &str, hash: &str) -> Option<Vec<u8>> {
        self.read(Some(tenant), hash)
    }

    /// The same, or an asset of anybody.
    pub(crate) fn read(&self, tenant: Option<&str>, hash: &str) -> Option<Vec<u8>> {
        tenant.is_none_or(|tenant| self.owns(tenant, hash)).then(|| self.store.get(hash)).flatten()
    }

    /// Takes back a tenant's claim; false if it has none. With the last one the bytes go. `needed_by` names a job that keeps it.
    pub(crate) fn remove(
        &self,
        tenant: &str,
        hash: &str,
        needed_by: impl Fn() -> Result<Option<String>, Error>,
    ) -> Result<bool, Error> {
        let needed = || match needed_by()? {
            Some(job) => Err(Error::InUse(format!("job {job} needs the asset: cancel it, or wait until it has ended"))),
            None => Ok(()),
        };
        let failed = |error: io::Error| Error::io("the asset cannot be deleted", &error);
        let _alone = self.changes.lock();
        let Some(bytes) = self.claim_of(tenant, hash) else { return self.check_store().map(|()| false) };
        needed()?;
        self.unclaim(tenant, hash).map_err(failed)?;
        if let Err(needed) = needed() {
            self.store.claim(hash, tenant, bytes).map_err(failed)?;
            self.known.lock().add(tenant, hash, bytes);
            return Err(needed);
        }
        self.store.remove_unclaimed(hash).map_err(failed)?;
        Ok(true)
    }

    /// Bytes of an asset that a tenant has sent, whether they are there or not.
    fn claim_of(&self, tenant: &str, hash: &str) -> Option<u64> {
        match self.store.listed() {
            Some(_) => self.known.lock().claims.get(tenant)?.peek(hash).copied(),
            None => self.store.claimed(hash, tenant),
        }
    }

    fn unclaim(&self, tenant: &str, hash: &str) -> io::Result<()> {
        self.store.unclaim(hash, tenant)?;
        self.known.lock().remove(tenant, hash);
        Ok(())
    }

    /// Whether no tenant is known to have any.
    pub(crate) fn is_empty(&self) -> bool {
        self.known.lock().claims.is_empty()
    }

    /// Bytes of a tenant's assets, and the most they may be.
    pub(crate) fn bytes(&self, tenant: &str) -> [u64; 2] {
        [self.known.lock().sum(tenant).0, self.most]
    }
}

impl Known {
    fn add(&mut self, tenant: &str, hash: &str, bytes: u64) {
        self.claims.entry(tenant.to_owned()).or_insert_with(LruCache::unbounded).put(hash.to_owned(), bytes);
    }

    fn remove(&mut self, tenant: &str, hash: &str) {
        if let Some(claims) = self.claims.get_mut(tenant) {
            claims.pop(hash);
        }
    }

    /// Bytes of a tenant's assets, and their number.
    fn sum(&self, tenant: &str) -> (u64, usize) {
        self.claims.get(tenant).map_or((0, 0), |claims| (claims.iter().map(|(_, bytes)| bytes).sum(), claims.len()))
    }

    /// A tenant's assets with their bytes, the one needed longest ago first.
    fn oldest(&self, tenant: &str) -> Vec<(String, u64)> {
        let claims = self.claims.get(tenant).into_iter().flat_map(|claims| claims.iter().rev());
        claims.map(|(hash, bytes)| (hash.clone(), *bytes)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::hash::sha256;

    fn kept(assets: &Assets, tenant: &str, bytes: &[u8], named: &[&str]) -> Result<bool, Error> {
        let named = named.iter().map(|hash| (*hash).to_owned()).collect();
        assets.keep(tenant, &sha256(bytes), bytes, || named, |_| true)
    }

    #[test]
    fn bytes_belong_to_who_has_sent_them_and_are_kept_once() {
        let folder = tempfile::tempdir().unwrap();
        let assets = Assets::open(folder.path(), 100, false).unwrap();
        let hash = sha256(b"duck");
        assert!(kept(&assets, "one", b"duck", &[]).unwrap());
        assert!(!kept(&assets, "one", b"duck", &[]).unwrap());
        assert_eq!(assets.get("one", &hash).as_deref(), Some(&b"duck"[..]));
        let remove = |assets: &Assets, tenant| assets.remove(tenant, &hash, || Ok(None)).unwrap();
        assert!(assets.get("two", &hash).is_none() && !remove(&assets, "two"));
        assert!(kept(&assets, "two", b"duck", &[]).unwrap());
        assert!(remove(&assets, "one"));
        assert_eq!(assets.bytes("one"), [0, 100]);
        // After a restart, too.
        let assets = Assets::open(folder.path(), 100, false).unwrap();
        assert_eq!([assets.size("one", &hash), assets.size("two", &hash)], [None, Some(4)]);
        assert!(remove(&assets, "two"));
        assert!(!assets.store.has(&hash));
    }

    #[test]
    fn what_is_damaged_or_gone_is_missing_until_it_is_sent_again() {
        let folder = tempfile::tempdir().unwrap();
        let assets = Assets::open(folder.path(), 6, false).unwrap();
        let hash = sha256(b"duck");
        let file = folder.path().join(&hash);
        let flipped = || {
            let mut bytes = std::fs::read(&file).unwrap();
            *bytes.last_mut().unwrap() ^= 1;
            std::fs::write(&file, bytes).unwrap();
        };
        assert!(kept(&assets, "one", b"duck", &[]).unwrap());
        for spoil in [&flipped as &dyn Fn(), &|| std::fs::remove_file(&file).unwrap()] {
            spoil();
            assert!(assets.get("one", &hash).is_none() && !assets.owns("one", &hash));
            // It takes its own place.
            assert!(kept(&assets, "one", b"duck", &[]).unwrap());
            assert_eq!(assets.get("one", &hash).as_deref(), Some(&b"duck"[..]));
        }
        // Also if nobody has seen it yet.
        flipped();
        assert!(kept(&assets, "one", b"duck", &[]).unwrap() && !kept(&assets, "one", b"duck", &[]).unwrap());
        assert_eq!(assets.get("one", &hash).as_deref(), Some(&b"duck"[..]));
        flipped();
        assert!(assets.get("one", &hash).is_none());
        assert!(assets.remove("one", &hash, || Ok(None)).unwrap());
        assert_eq!(assets.bytes("one"), [0, 6]);
    }

    #[test]
    fn what_a_job_needs_is_not_deleted() {
        let folder = tempfile::tempdir().unwrap();
        let assets = Assets::open(folder.path(), 100, false).unwrap();
        let hash = sha256(b"duck");
        kept(&assets, "one", b"duck", &[]).unwrap();
        let refused = |assets: &Assets, answers: [Option<&str>; 2]| {
            let answers = std::cell::RefCell::new(answers.into_iter());
            let needed_by = || Ok(answers.borrow_mut().next().flatten().map(str::to_owned));
            matches!(assets.remove("one", &hash, needed_by), Err(Error::InUse(_)))
        };
        // The second one was accepted while the asset was being deleted.
        assert!(refused(&assets, [Some("job"), None]) && refused(&assets, [None, Some("job")]));
        let assets = Assets::open(folder.path(), 100, false).unwrap();
        assert_eq!(assets.get("one", &hash).as_deref(), Some(&b"duck"[..]));
        assert!(!refused(&assets, [None, None]) && assets.get("one", &hash).is_none());
    }

    #[test]
    fn what_was_needed_longest_ago_goes_unless_it_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let assets = Assets::open(folder.path(), 10, false).unwrap();
        let [a, b, c] = [b"aaaa", b"bbbb", b"cccc"];
        kept(&assets, "one", a, &[]).unwrap();
        kept(&assets, "one", b, &[]).unwrap();
        assert!(assets.owns("one", &sha256(a)), "now b was needed longest ago");
        kept(&assets, "one", c, &[]).unwrap();
        assert_eq!([a, b, c].map(|bytes| assets.owns("one", &sha256(bytes))), [true, false, true]);
        // A scene names a, a job c.
        let id = format!("s_{}", "a".repeat(32));
        assets.note_scene(&id, &[sha256(a)], |_| true);
        assert!(matches!(kept(&assets, "one", b, &[&sha256(c)]), Err(Error::TooLarge(_))));
        assert!(kept(&assets, "one", b, &[]).unwrap());
        assert_eq!([a, b, c].map(|bytes| assets.owns("one", &sha256(bytes))), [true, true, false]);
        // A scene that is kept no more names nothing.
        assert!(assets.keep("one", &sha256(c), c, HashSet::new, |_| false).unwrap());
        assert!(matches!(kept(&assets, "one", &[0; 11], &[]), Err(Error::TooLarge(_))));
    }

    #[test]
    fn many_small_assets_and_scenes_that_are_gone_take_no_more_room_than_they_may() {
        let folder = tempfile::tempdir().unwrap();
        let mut assets = Assets::open(folder.path(), 1_000, false).unwrap();
        assets.most_assets = 3;
        for byte in 0..9_u8 {
            kept(&assets, "one", &[byte], &[]).unwrap();
        }
        assert_eq!(assets.bytes("one"), [3, 1_000]);
        assert!(assets.owns("one", &sha256(&[8])) && !assets.owns("one", &sha256(&[5])));
        let scene = |number: usize| format!("s_{number:032x}");
        for number in 0..3 * NOTES {
            assets.note_scene(&scene(number), &[sha256(&[8])], |id| id == scene(0));
        }
        let notes = assets.known.lock().named.len();
        assert!(notes <= NOTES && assets.known.lock().named.contains_key(&scene(0)), "{notes}");
    }
}
