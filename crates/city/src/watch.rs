//! Hearing of changes to the files that a city is made from.

use crate::Cancel;
use crate::export::is_own;
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Programs save a file in several steps: changes count as over when none has come for so long.
const QUIET: Duration = Duration::from_millis(40);

/// After so many quiet spells that did not come, changes count all the same: something may write all the time.
const MOST_WAITS: u32 = 25;

/// After so many builds in a row that gave way to changes, one is finished.
const MOST_GIVING_WAY: u32 = 4;

/// Why changes cannot be heard of.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be watched for changes: {cause}", path.display())]
pub struct WatchError {
    /// The folder; `files` where none can be watched at all.
    pub path: PathBuf,
    /// What the system says.
    pub cause: notify::Error,
}

/// Hears of changes in folders, below them too.
pub struct Watch {
    watcher: RecommendedWatcher,
    watched: BTreeSet<PathBuf>,
    news: Receiver<News>,
    shared: Arc<Shared>,
}

enum News {
    Changed(PathBuf),
    Stop,
}

struct Shared {
    news: Mutex<Sender<News>>,
    /// The build under way, where it is to give way to changes.
    building: Mutex<Option<Cancel>>,
    /// The folders that count, whether or not they are there.
    folders: Mutex<BTreeSet<PathBuf>>,
    /// Folders of results, as they were named and as they are.
    results: Vec<PathBuf>,
    given_way: Mutex<u32>,
}

impl Watch {
    /// Hears of nothing yet. What changes in folders of `results` does not count; where such a folder holds what a city is made
    /// from, only the files that exports write do not.
    ///
    /// # Errors
    /// When the system has no means for it.
    pub fn new(results: &[PathBuf]) -> Result<Self, WatchError> {
        let (sender, news) = channel();
        let lexical = results.iter().filter_map(|path| std::path::absolute(path).ok());
        let shared = Arc::new(Shared {
            news: Mutex::new(sender),
            building: Mutex::default(),
            folders: Mutex::default(),
            results: results.iter().map(|path| absolute(path)).chain(lexical).collect(),
            given_way: Mutex::default(),
        });
        let own = shared.clone();
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            let paths = match event {
                Ok(event) if matches!(event.kind, EventKind::Access(_)) => return,
                Ok(event) => event.paths,
                Err(error) => error.paths,
            };
            // What cannot be told may have been anything.
            if paths.is_empty() {
                own.tell(PathBuf::from("…"));
            }
            paths.into_iter().for_each(|path| own.changed(path));
        });
        let watcher = watcher.map_err(|cause| WatchError { path: PathBuf::from("files"), cause })?;
        Ok(Self { watcher, watched: BTreeSet::new(), news, shared })
    }

    /// Hears of changes in these folders from now on, and in no others: of one that is not there as soon as it is. To be
    /// called before each reading: a folder may have been replaced by another one of its name.
    ///
    /// # Errors
    /// When one of them cannot be watched.
    pub fn follow(&mut self, folders: &[PathBuf]) -> Result<(), WatchError> {
        let wanted: BTreeSet<PathBuf> = folders.iter().map(|path| absolute(path)).collect();
        *lock(&self.shared.folders) = wanted.clone();
        // What lies in another one is heard of there.
        let is_outer = |path: &&PathBuf| !path.ancestors().skip(1).any(|above| wanted.contains(above));
        let mut watched = BTreeSet::new();
        for folder in wanted.iter().filter(is_outer) {
            let there = folder.ancestors().find(|path| path.is_dir()).unwrap_or(folder);
            let mode = if there == folder { RecursiveMode::Recursive } else { RecursiveMode::NonRecursive };
            let watch = self.watcher.watch(there, mode);
            watch.map_err(|cause| WatchError { path: there.to_owned(), cause })?;
            watched.insert(there.to_owned());
        }
        for gone in self.watched.difference(&watched) {
            // One that was removed is no longer watched anyway.
            let _ = self.watcher.unwatch(gone);
        }
        self.watched = watched;
        Ok(())
    }

    /// Waits for changes until they are over, and tells which files they are in; `None` once it was stopped.
    pub fn wait(&self) -> Option<BTreeSet<PathBuf>> {
        let mut changed = BTreeSet::new();
        match self.news.recv() {
            Ok(News::Changed(path)) => changed.insert(path),
            Ok(News::Stop) | Err(_) => return None,
        };
        for _ in 0..MOST_WAITS {
            match self.news.recv_timeout(QUIET) {
                Ok(News::Changed(path)) => changed.insert(path),
                Err(RecvTimeoutError::Timeout) => break,
                Ok(News::Stop) | Err(RecvTimeoutError::Disconnected) => return None,
            };
            while let Ok(news) = self.news.try_recv() {
                match news {
                    News::Changed(path) => changed.insert(path),
                    News::Stop => return None,
                };
            }
        }
        Some(changed)
    }

    /// Does some work that gives way to changes: `cancel` asks it to stop as soon as there is one, unless the last few had
    /// to stop, too.
    pub fn during<T>(&self, cancel: &Cancel, work: impl FnOnce() -> T) -> T {
        let gives_way = *lock(&self.shared.given_way) < MOST_GIVING_WAY;
        *lock(&self.shared.building) = gives_way.then(|| cancel.clone());
        let result = work();
        *lock(&self.shared.building) = None;
        let mut given_way = lock(&self.shared.given_way);
        *given_way = if cancel.is_cancelled() { *given_way + 1 } else { 0 };
        result
    }

    /// What stops it from elsewhere: [`Watch::wait`] then tells nothing more.
    pub fn stopper(&self) -> impl Fn() + Send + use<> {
        let shared = self.shared.clone();
        move || drop(lock(&shared.news).send(News::Stop))
    }
}

impl Shared {
    fn changed(&self, path: PathBuf) {
        let counts = {
            let folders = lock(&self.folders);
            let is_inside = folders.iter().any(|folder| path.starts_with(folder) || folder.starts_with(&path));
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            let is_result = self.results.iter().any(|results| {
                let holds_input = folders.iter().any(|folder| folder.starts_with(results));
                let is_below = path.starts_with(results);
                if holds_input { path.parent() == Some(results) && is_own(name) } else { is_below }
            });
            is_inside && !is_result
        };
        if counts {
            self.tell(path);
        }
    }

    fn tell(&self, path: PathBuf) {
        if let Some(building) = &*lock(&self.building) {
            building.cancel();
        }
        // Nobody hears it where the watch is gone.
        let _ = lock(&self.news).send(News::Changed(path));
    }
}

/// As events tell paths: where it lies, of one that is not there as far as there is something.
fn absolute(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let known = path.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    known.map_or(path.clone(), |(above, known)| {
        path.strip_prefix(above)
            .ok()
            .filter(|rest| !rest.as_os_str().is_empty())
            .map_or(known.clone(), |rest| known.join(rest))
    })
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// Names of files that changed.
    fn names(changed: &BTreeSet<PathBuf>) -> BTreeSet<String> {
        changed.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect()
    }

    fn watching(folder: &Path, ignored: &[PathBuf]) -> Watch {
        let mut watch = Watch::new(ignored).unwrap();
        watch.follow(&[folder.to_owned(), folder.join("not/there")]).unwrap();
        watch
    }

    #[test]
    fn saved_renamed_and_new_files_are_heard_of_below_too() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("streets")).unwrap();
        let watch = watching(folder.path(), &[]);
        fs::write(folder.path().join("streets/a.rhai"), "1").unwrap();
        assert!(names(&watch.wait().unwrap()).contains("a.rhai"));
        // As editors do: beside it, then over it.
        fs::write(folder.path().join("streets/.a.tmp"), "2").unwrap();
        fs::rename(folder.path().join("streets/.a.tmp"), folder.path().join("streets/a.rhai")).unwrap();
        assert!(names(&watch.wait().unwrap()).contains("a.rhai"));
        fs::create_dir(folder.path().join("parcels")).unwrap();
        watch.wait().unwrap();
        fs::write(folder.path().join("parcels/b.rhai"), "1").unwrap();
        assert!(names(&watch.wait().unwrap()).contains("b.rhai"));
    }

    #[test]
    fn to_read_is_no_change_and_results_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("city.rhai"), "1").unwrap();
        let watch = watching(folder.path(), &[folder.path().join("out")]);
        fs::create_dir(folder.path().join("out")).unwrap();
        fs::write(folder.path().join("out/map.png"), "1").unwrap();
        fs::read(folder.path().join("city.rhai")).unwrap();
        fs::write(folder.path().join("last.rhai"), "1").unwrap();
        assert_eq!(names(&watch.wait().unwrap()), ["last.rhai".to_owned()].into());
    }

    #[test]
    fn a_build_gives_way_to_changes_but_not_for_ever() {
        let folder = tempfile::tempdir().unwrap();
        let watch = watching(folder.path(), &[]);
        let mut cancelled = Vec::new();
        for round in 0..=MOST_GIVING_WAY {
            let cancel = Cancel::default();
            watch.during(&cancel, || {
                fs::write(folder.path().join("city.rhai"), round.to_string()).unwrap();
                watch.wait().unwrap();
            });
            cancelled.push(cancel.is_cancelled());
        }
        let all_but_one = std::iter::repeat_n(true, MOST_GIVING_WAY as usize).chain([false]);
        assert_eq!(cancelled, all_but_one.collect::<Vec<_>>());
    }

    #[test]
    fn it_can_be_stopped_while_it_waits() {
        let folder = tempfile::tempdir().unwrap();
        let watch = watching(folder.path(), &[]);
        let stop = watch.stopper();
        std::thread::spawn(stop);
        assert_eq!(watch.wait(), None);
    }
}
