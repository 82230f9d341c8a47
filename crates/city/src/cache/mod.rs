//! What builds keep for later ones: results of stages by a digest of all that they were made from, in memory and, where a
//! folder is given, on disk. Nothing else caches, and deleting it changes nothing but time.
//!
//! Only results that came without faults, prints and marks are kept, so that those are told each time.

mod store;

use geom::{Digest, Id, Raster};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::any::Any;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use store::Store;

/// Builds after which a result that none of them used is forgotten: one can go back some steps.
const KEPT_BUILDS: u64 = 3;

/// What builds keep (see the module). Shared by threads.
#[derive(Debug, Default)]
pub struct Cache {
    kept: Option<Mutex<Kept>>,
    store: Option<Store>,
}

#[derive(Debug, Default)]
struct Kept {
    results: BTreeMap<Id, Entry>,
    /// The digests of rasters, which are large; each is held, so that no other one comes to lie at its address.
    rasters: Vec<(Arc<Raster>, Id)>,
    /// Builds finished so far.
    builds: u64,
}

#[derive(Debug)]
struct Entry {
    result: Arc<dyn Any + Send + Sync>,
    /// Builds that were finished when it was used last.
    used: u64,
}

impl Cache {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// Keeps results as long as it lives.
    pub fn in_memory() -> Self {
        Self { kept: Some(Mutex::default()), store: None }
    }

    /// Keeps results as long as it lives, and those of whole stages in a folder of at most so many bytes, for later
    /// programs; the folder is made if need be. Nothing in it but what caches put there is ever read or removed.
    ///
    /// # Errors
    /// When the folder cannot be made or written to.
    pub fn on_disk(folder: &Path, most_bytes: u64) -> io::Result<Self> {
        Ok(Self { store: Some(Store::open(folder, most_bytes)?), ..Self::in_memory() })
    }

    /// Whether it keeps anything.
    pub fn is_on(&self) -> bool {
        self.kept.is_some()
    }

    /// What went wrong on disk since this was asked last; builds go on without.
    pub fn problems(&self) -> Vec<String> {
        self.store.as_ref().map(Store::problems).unwrap_or_default()
    }

    /// Waits until all that was kept is on disk.
    pub fn flush(&self) {
        if let Some(store) = &self.store {
            store.flush();
        }
    }

    /// A result that was kept in memory.
    pub(crate) fn get<T: Any + Send + Sync>(&self, key: Id) -> Option<Arc<T>> {
        let mut kept = self.lock()?;
        let builds = kept.builds;
        let entry = kept.results.get_mut(&key)?;
        entry.used = builds;
        entry.result.clone().downcast().ok()
    }

    /// Keeps a result in memory.
    pub(crate) fn keep<T: Any + Send + Sync>(&self, key: Id, result: &Arc<T>) {
        if let Some(mut kept) = self.lock() {
            let used = kept.builds;
            kept.results.insert(key, Entry { result: result.clone(), used });
        }
    }

    /// A result that was kept in memory or on disk.
    pub(crate) fn get_stored<T: Any + Send + Sync + DeserializeOwned>(&self, key: Id) -> Option<Arc<T>> {
        self.get(key).or_else(|| {
            let found: Arc<T> = Arc::new(self.store.as_ref()?.read(key)?);
            self.keep(key, &found);
            Some(found)
        })
    }

    /// Keeps a result in memory and, where there is a folder, on disk.
    pub(crate) fn keep_stored<T: Any + Send + Sync + Serialize>(&self, key: Id, result: &Arc<T>) {
        self.keep(key, result);
        if let Some(store) = &self.store {
            store.write(key, result.clone());
        }
    }

    /// A result that was kept in memory by a key, or a new one.
    pub(crate) fn part<T: Any + Send + Sync>(&self, key: Option<Id>, make: impl FnOnce() -> T) -> Arc<T> {
        let kept = key.and_then(|key| self.get(key));
        kept.unwrap_or_else(|| {
            let result = Arc::new(make());
            if let Some(key) = key {
                self.keep(key, &result);
            }
            result
        })
    }

    /// The digest of a raster, found once.
    pub(crate) fn digest_of(&self, raster: &Arc<Raster>) -> Id {
        let find = || Digest::new("raster").raster(raster).finish();
        let Some(mut kept) = self.lock() else { return find() };
        if let Some((_, known)) = kept.rasters.iter().find(|(other, _)| Arc::ptr_eq(other, raster)) {
            return *known;
        }
        let digest = find();
        kept.rasters.push((raster.clone(), digest));
        digest
    }

    /// A build is finished: what the last ones did not use is forgotten.
    pub(crate) fn finish_build(&self) {
        if let Some(mut kept) = self.lock() {
            kept.builds += 1;
            let oldest = kept.builds.saturating_sub(KEPT_BUILDS);
            let forgotten: Vec<Entry> =
                kept.results.extract_if(.., |_, entry| entry.used < oldest).map(|(_, e)| e).collect();
            // To take a whole city apart takes a while, and nobody needs to wait for it.
            let _ = std::thread::Builder::new().name("forget".into()).spawn(move || drop(forgotten));
            kept.rasters.retain(|(raster, _)| Arc::strong_count(raster) > 1);
        }
    }

    fn lock(&self) -> Option<MutexGuard<'_, Kept>> {
        Some(self.kept.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// What a finished city was made from, stage by stage: the parts of its files are kept by these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digests {
    /// Of the site with all its maps.
    pub site: Option<Id>,
    /// Of all that the streets were made from.
    pub streets: Option<Id>,
    /// Of all that blocks and parcels were made from.
    pub land: Option<Id>,
}

/// A value as bytes, to be hashed or stored; nothing where it has no such form.
pub(crate) fn bytes_of(value: &impl Serialize) -> Option<Vec<u8>> {
    postcard::to_stdvec(value).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(n: u128) -> Id {
        Id(n)
    }

    #[test]
    fn no_cache_keeps_nothing() {
        let cache = Cache::none();
        cache.keep(key(1), &Arc::new(5u32));
        assert!(cache.get::<u32>(key(1)).is_none() && !cache.is_on());
    }

    #[test]
    fn what_no_build_uses_is_forgotten() {
        let cache = Cache::in_memory();
        cache.keep(key(1), &Arc::new(5u32));
        cache.keep(key(2), &Arc::new(6u32));
        for _ in 0..KEPT_BUILDS {
            assert_eq!(cache.get::<u32>(key(1)).as_deref(), Some(&5));
            cache.finish_build();
        }
        assert!(cache.get::<u32>(key(2)).is_some(), "used by none of the last builds, but kept before the first");
        (0..=KEPT_BUILDS).for_each(|_| cache.finish_build());
        assert!(cache.get::<u32>(key(1)).is_none() && cache.get::<u32>(key(2)).is_none());
    }

    #[test]
    fn a_result_of_another_kind_is_none() {
        let cache = Cache::in_memory();
        cache.keep(key(1), &Arc::new(5u32));
        assert!(cache.get::<String>(key(1)).is_none());
    }

    #[test]
    fn a_second_program_finds_what_the_first_kept() {
        let folder = tempfile::tempdir().unwrap();
        let first = Cache::on_disk(folder.path(), 1 << 20).unwrap();
        first.keep_stored(key(7), &Arc::new(vec![1u32, 2, 3]));
        first.keep(key(8), &Arc::new(1u32));
        first.flush();
        let second = Cache::on_disk(folder.path(), 1 << 20).unwrap();
        assert_eq!(second.get_stored::<Vec<u32>>(key(7)).as_deref(), Some(&vec![1, 2, 3]));
        assert!(second.get_stored::<u32>(key(8)).is_none());
        assert_eq!(second.problems(), Vec::<String>::new());
    }
}
