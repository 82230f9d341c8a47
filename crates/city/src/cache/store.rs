//! Results on disk: a file each, named by its key, with a check sum; the least recently used ones go when there are too
//! many bytes. Written by a thread of its own, so that no build waits for the disk.

use crate::export::{new_file, remove_leftovers};
use geom::{Digest, Id};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::SystemTime;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// The first bytes of a file; the number grows with the format.
const MAGIC: &[u8; 8] = b"platc 1\n";

/// What the names of files end with.
const ENDING: &str = "stage";

/// The file that marks a folder of a cache, so that programs that save or search files leave it out.
const TAG: (&str, &str) = (
    "CACHEDIR.TAG",
    "Signature: 8a477f597d28d172789f06886806bc55\n# Results of plat that can be made again. See https://bford.info/cachedir/\n",
);

/// A folder of results.
#[derive(Debug)]
pub(super) struct Store {
    folder: Arc<Folder>,
    work: Mutex<Option<Sender<Work>>>,
    writer: Mutex<Option<JoinHandle<()>>>,
}

enum Work {
    Write(Id, Box<dyn Bytes>),
    Tell(Sender<()>),
}

/// Something that can be written, whatever its type.
trait Bytes: Send {
    fn bytes(&self) -> Result<Vec<u8>, postcard::Error>;
}

impl<T: Serialize + Send + Sync> Bytes for Arc<T> {
    fn bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(&**self)
    }
}

#[derive(Debug)]
struct Folder {
    path: PathBuf,
    most_bytes: u64,
    /// What the program is: another one may do another thing with the same input.
    program: Id,
    problems: Mutex<Vec<String>>,
}

/// Bytes of a file that are read at once.
const AT_ONCE: usize = 1 << 20;

/// The digest of what is in a file. Programs with what debuggers want are too large to be held whole.
fn digest_of_file(path: &Path) -> io::Result<Id> {
    let mut digest = Xxh3::new();
    io::copy(&mut io::BufReader::with_capacity(AT_ONCE, fs::File::open(path)?), &mut digest)?;
    Ok(Id(digest.digest128()))
}

impl Store {
    pub fn open(path: &Path, most_bytes: u64) -> io::Result<Self> {
        fs::create_dir_all(path)?;
        // Found out before hours of work.
        new_file(path)?;
        let tag = path.join(TAG.0);
        if !tag.exists() {
            fs::write(tag, TAG.1)?;
        }
        let program = digest_of_file(&std::env::current_exe()?)?;
        let folder = Arc::new(Folder { path: path.to_owned(), most_bytes, program, problems: Mutex::default() });
        remove_leftovers(path);
        folder.make_room(0, Path::new(""))?;
        let (sender, receiver) = channel();
        let own = folder.clone();
        let write = move || {
            for work in receiver {
                match work {
                    Work::Write(key, result) => own.write(key, &*result),
                    // Whoever asked may have gone.
                    Work::Tell(done) => drop(done.send(())),
                }
            }
        };
        let writer = std::thread::Builder::new().name("cache".into()).spawn(write)?;
        Ok(Self { folder, work: Mutex::new(Some(sender)), writer: Mutex::new(Some(writer)) })
    }

    pub fn read<T: DeserializeOwned>(&self, key: Id) -> Option<T> {
        self.folder.read(key)
    }

    pub fn write<T: Serialize + Send + Sync + 'static>(&self, key: Id, result: Arc<T>) {
        self.give(Work::Write(key, Box::new(result)));
    }

    /// Waits until all that was given is written.
    pub fn flush(&self) {
        let (sender, receiver) = channel();
        self.give(Work::Tell(sender));
        let _ = receiver.recv();
    }

    pub fn problems(&self) -> Vec<String> {
        std::mem::take(&mut *self.folder.problems.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn give(&self, work: Work) {
        if let Some(sender) = &*self.work.lock().unwrap_or_else(PoisonError::into_inner) {
            // The writer ends with the store only.
            let _ = sender.send(work);
        }
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        self.work.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(writer) = self.writer.lock().unwrap_or_else(PoisonError::into_inner).take() {
            let _ = writer.join();
        }
    }
}

impl Folder {
    /// The file of a result of this program.
    fn file(&self, key: Id) -> PathBuf {
        let name = Digest::new("stored").id(self.program).id(key).finish();
        self.path.join(format!("{name}.{ENDING}"))
    }

    fn read<T: DeserializeOwned>(&self, key: Id) -> Option<T> {
        let path = self.file(key);
        let bytes = fs::read(&path).ok()?;
        let result = content(&bytes).and_then(|content| postcard::from_bytes(content).ok());
        match &result {
            // Used now: the last to go.
            Some(_) => drop(fs::File::options().append(true).open(&path).map(|file| file.set_modified(now()))),
            // Cut short or changed: as if it had never been.
            None => drop(fs::remove_file(&path)),
        }
        result
    }

    fn write(&self, key: Id, result: &dyn Bytes) {
        let outcome = result.bytes().map_err(io::Error::other).and_then(|content| self.put(&self.file(key), &content));
        if let Err(error) = outcome {
            let mut problems = self.problems.lock().unwrap_or_else(PoisonError::into_inner);
            problems.push(format!("the cache in {} could not be written: {error}", self.path.display()));
        }
    }

    fn put(&self, path: &Path, content: &[u8]) -> io::Result<()> {
        let size = (MAGIC.len() + 16 + content.len()) as u64;
        if size > self.most_bytes {
            return Ok(());
        }
        self.make_room(size, path)?;
        let mut file = new_file(&self.path)?;
        file.write_all(MAGIC)?;
        file.write_all(&xxh3_128(content).to_le_bytes())?;
        file.write_all(content)?;
        file.persist(path).map(drop).map_err(|error| error.error)
    }

    /// Removes results, the least recently used first, until there is room for so many bytes.
    fn make_room(&self, bytes: u64, replaced: &Path) -> io::Result<()> {
        let mut files: Vec<(SystemTime, u64, PathBuf)> = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            let path = entry?.path();
            if is_result(&path)
                && path != replaced
                && let Ok(about) = fs::metadata(&path)
            {
                files.push((about.modified().unwrap_or(SystemTime::UNIX_EPOCH), about.len(), path));
            }
        }
        files.sort();
        let mut total: u64 = files.iter().map(|(_, size, _)| size).sum();
        for (_, size, path) in files {
            if total + bytes <= self.most_bytes {
                break;
            }
            // Another program may have been faster.
            let _ = fs::remove_file(path);
            total -= size;
        }
        Ok(())
    }
}

/// Whether a cache put a file there: 32 hexadecimal digits and the ending.
fn is_result(path: &Path) -> bool {
    let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
    let is_key = name.len() == 32 && name.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    is_key && path.extension().is_some_and(|ending| ending == ENDING)
}

/// What a file holds, where it is whole.
fn content(bytes: &[u8]) -> Option<&[u8]> {
    let (sum, content) = bytes.strip_prefix(MAGIC)?.split_first_chunk::<16>()?;
    (xxh3_128(content).to_le_bytes() == *sum).then_some(content)
}

#[expect(clippy::disallowed_methods, reason = "which file was used last is no part of any result")]
fn now() -> SystemTime {
    SystemTime::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.retain(|path| is_result(path));
        paths.sort();
        paths
    }

    fn store(folder: &Path, most_bytes: u64) -> Store {
        Store::open(folder, most_bytes).unwrap()
    }

    #[test]
    fn a_damaged_file_is_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let of = || store(folder.path(), 1 << 20);
        let damages: [fn(&mut Vec<u8>); 5] = [
            |bytes| bytes.truncate(10),
            |bytes| bytes.clear(),
            |bytes| *bytes.last_mut().unwrap() ^= 1,
            |bytes| bytes[0] ^= 1,
            |bytes| bytes.push(0),
        ];
        for damage in damages {
            let store = of();
            store.write(Id(1), Arc::new("result".to_owned()));
            store.flush();
            assert_eq!(store.read::<String>(Id(1)).as_deref(), Some("result"));
            let [path] = &files(folder.path())[..] else { panic!("one file") };
            let mut bytes = fs::read(path).unwrap();
            damage(&mut bytes);
            fs::write(path, bytes).unwrap();
            assert_eq!(store.read::<String>(Id(1)), None);
            assert!(files(folder.path()).is_empty(), "it is removed");
            assert_eq!(store.problems(), Vec::<String>::new());
        }
    }

    #[test]
    fn a_result_of_another_type_is_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path(), 1 << 20);
        store.write(Id(1), Arc::new(vec![200u8; 3]));
        store.flush();
        assert_eq!(store.read::<String>(Id(1)), None);
    }

    #[test]
    fn the_least_recently_used_go_first_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("mine.stage"), vec![0; 5000]).unwrap();
        fs::write(folder.path().join("notes.txt"), vec![0; 5000]).unwrap();
        let store = store(folder.path(), 2500);
        let put = |key: u128| {
            store.write(Id(key), Arc::new(vec![1u8; 1000]));
            store.flush();
        };
        put(1);
        put(2);
        let old = now() - std::time::Duration::from_secs(60);
        for path in files(folder.path()) {
            fs::File::options().append(true).open(path).unwrap().set_modified(old).unwrap();
        }
        assert!(store.read::<Vec<u8>>(Id(1)).is_some(), "used after the other");
        put(3);
        let there = [1, 2, 3].map(|key| store.read::<Vec<u8>>(Id(key)).is_some());
        assert_eq!(there, [true, false, true]);
        store.write(Id(4), Arc::new(vec![1u8; 4000]));
        store.flush();
        assert_eq!(files(folder.path()).len(), 2, "what is larger than all there may be is not kept");
        assert!(folder.path().join("mine.stage").exists() && folder.path().join("notes.txt").exists());
    }

    #[test]
    fn a_folder_is_within_its_limit_from_the_start() {
        let folder = tempfile::tempdir().unwrap();
        let large = store(folder.path(), 1 << 20);
        (0..5).for_each(|key| large.write(Id(key), Arc::new(vec![1u8; 1000])));
        large.flush();
        assert_eq!(files(folder.path()).len(), 5);
        drop(store(folder.path(), 2500));
        assert_eq!(files(folder.path()).len(), 2);
    }

    #[test]
    fn what_cannot_be_written_is_told_and_stops_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gone");
        let store = store(&path, 1 << 20);
        fs::remove_dir_all(&path).unwrap();
        store.write(Id(1), Arc::new(1u8));
        store.flush();
        assert_eq!(store.problems().len(), 1);
        assert_eq!(store.read::<u8>(Id(1)), None);
    }
}
