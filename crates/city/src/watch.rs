//! Hearing of changes to the files that a city is made from.

use crate::Cancel;
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
    /// The folder, or an empty path for all of them.
    pub path: PathBuf,
    /// What the system says.
    pub cause: notify::Error,
}

/// Hears of changes in folders, below them too.
pub struct Watch {
    watcher: RecommendedWatcher,
    folders: BTreeSet<PathBuf>,
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
    /// Folders in which nothing counts, such as that of the results.
    ignored: Mutex<Vec<PathBuf>>,
    given_way: Mutex<u32>,
}

impl Watch {
    /// Hears of nothing yet. What changes below `ignored` folders does not count: that of the results, above all.
    ///
    /// # Errors
    /// When the system has no means for it.
    pub fn new(ignored: &[PathBuf]) -> Result<Self, WatchError> {
        let (sender, news) = channel();
        let ignored = ignored.iter().map(|path| absolute(path)).collect();
        let shared = Arc::new(Shared {
            news: Mutex::new(sender),
            building: Mutex::default(),
            ignored: Mutex::new(ignored),
            given_way: Mutex::default(),
        });
        let own = shared.clone();
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            // What cannot be told may have been anything.
            let paths = match event {
                Ok(event) if matches!(event.kind, EventKind::Access(_)) => return,
                Ok(event) => event.paths,
                Err(error) => error.paths,
            };
            paths.into_iter().for_each(|path| own.changed(path));
        });
        let watcher = watcher.map_err(|cause| WatchError { path: PathBuf::new(), cause })?;
        Ok(Self { watcher, folders: BTreeSet::new(), news, shared })
    }

    /// Hears of changes in these folders from now on, and in no others. Those that are not there are left out.
    ///
    /// # Errors
    /// When one of them cannot be watched.
    pub fn follow(&mut self, folders: &[PathBuf]) -> Result<(), WatchError> {
        let wanted: BTreeSet<PathBuf> =
            folders.iter().map(|path| absolute(path)).filter(|path| path.is_dir()).collect();
        // What lies in another one is heard of there.
        let is_outer = |path: &&PathBuf| !path.ancestors().skip(1).any(|above| wanted.contains(above));
        let wanted: BTreeSet<PathBuf> = wanted.iter().filter(is_outer).cloned().collect();
        for gone in self.folders.difference(&wanted) {
            // One that was removed is no longer watched anyway.
            let _ = self.watcher.unwatch(gone);
        }
        for new in wanted.difference(&self.folders) {
            self.watcher
                .watch(new, RecursiveMode::Recursive)
                .map_err(|cause| WatchError { path: new.clone(), cause })?;
        }
        self.folders = wanted;
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
        if lock(&self.ignored).iter().any(|ignored| path.starts_with(ignored)) {
            return;
        }
        if let Some(building) = &*lock(&self.building) {
            building.cancel();
        }
        // Nobody hears it where the watch is gone.
        let _ = lock(&self.news).send(News::Changed(path));
    }
}

/// As events tell paths. What is not there yet lies in a folder that is.
fn absolute(path: &Path) -> PathBuf {
    let known = path.canonicalize().ok();
    let by_parent = || {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(parent.canonicalize().ok()?.join(path.file_name()?))
    };
    known.or_else(by_parent).unwrap_or_else(|| path.to_owned())
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
