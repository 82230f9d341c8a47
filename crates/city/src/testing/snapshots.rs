//! Snapshots on disk: `snapshots/grid.raster.snap` beside the file of the test, in the form that insta reads, with a map
//! in `grid.raster.svg` where there is one.

use super::Ran;
use crate::export::make_readable;
use script::testing::Snapshot;
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A snapshot held against its file.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The file, with `.snap`.
    pub path: PathBuf,
    /// What was taken now.
    pub snapshot: Snapshot,
    /// How it stands to the file.
    pub standing: Standing,
    /// The file that the test stands in.
    source: PathBuf,
}

/// How a snapshot stands to its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// As it was accepted.
    Same,
    /// Nothing was accepted yet.
    New,
    /// Something else was accepted.
    Differs {
        /// What was.
        accepted: String,
    },
    /// The file is there, but cannot be read.
    Unreadable {
        /// Why.
        reason: String,
    },
}

/// The folder of the snapshots of a file's tests.
fn folder_of(tests: &Path) -> PathBuf {
    tests.parent().unwrap_or(Path::new("")).join("snapshots")
}

/// What the files of a file's snapshots begin with: `grid.` for `grid.test.rhai`.
fn prefix_of(tests: &Path) -> String {
    let stem = tests.file_stem().unwrap_or_default().to_string_lossy();
    format!("{}.", stem.strip_suffix(".test").unwrap_or(&stem))
}

/// Holds a snapshot of a file's tests against what was accepted.
pub(super) fn compare(tests: &Path, snapshot: Snapshot) -> Compared {
    let path = folder_of(tests).join(format!("{}{}.snap", prefix_of(tests), snapshot.name));
    let standing = match fs::read_to_string(&path) {
        Ok(text) if content(&text) == snapshot.text.trim_end() => Standing::Same,
        Ok(text) => Standing::Differs { accepted: content(&text) },
        Err(error) if error.kind() == io::ErrorKind::NotFound => Standing::New,
        Err(error) => Standing::Unreadable { reason: error.to_string() },
    };
    Compared { path, snapshot, standing, source: tests.to_path_buf() }
}

/// What a file accepts: its text below the head.
fn content(text: &str) -> String {
    let text = text.replace("\r\n", "\n");
    let body = text.strip_prefix("---\n").and_then(|rest| rest.split_once("\n---\n")).map(|(_, body)| body.to_owned());
    body.unwrap_or(text).trim_end().to_owned()
}

/// Accepts a snapshot: writes its file and its map, each whole or not at all.
///
/// # Errors
/// When a file cannot be written.
pub fn accept(compared: &Compared) -> io::Result<()> {
    let folder = compared.path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let source = compared.source.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("---\nsource: {source}\n---\n{}\n", compared.snapshot.text.trim_end());
    write(&compared.path, text.as_bytes())?;
    let drawing = compared.path.with_extension("svg");
    match &compared.snapshot.town {
        Some(town) => write(&drawing, town.drawing().as_bytes()),
        None if drawing.is_file() => fs::remove_file(&drawing),
        None => Ok(()),
    }
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    make_readable(&file)?;
    io::Write::write_all(&mut file, bytes)?;
    file.persist(path).map(|_| ()).map_err(|error| error.error)
}

/// The snapshots of a file that no test of it took.
pub(super) fn stale(tests: &Path, ran: &[Ran]) -> Vec<PathBuf> {
    let prefix = prefix_of(tests);
    let own = ran.iter().filter(|ran| prefix_of(&ran.path) == prefix && folder_of(&ran.path) == folder_of(tests));
    let taken: BTreeSet<&Path> = own.flat_map(|ran| &ran.snapshots).map(|compared| compared.path.as_path()).collect();
    let Ok(entries) = fs::read_dir(folder_of(tests)) else { return Vec::new() };
    let is_own = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with(&prefix) && name.ends_with(".snap") && !taken.contains(path.as_path())
    };
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_own).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_accepted_is_the_same_from_then_on() {
        let folder = tempfile::tempdir().unwrap();
        let tests = folder.path().join("grid.test.rhai");
        let snapshot = |text: &str| Snapshot { name: "raster".into(), text: text.into(), town: None };
        let found = compare(&tests, snapshot("a\nb\n"));
        assert_eq!(found.standing, Standing::New);
        assert!(found.path.ends_with("snapshots/grid.raster.snap"));
        accept(&found).unwrap();
        assert_eq!(compare(&tests, snapshot("a\nb\n")).standing, Standing::Same);
        let other = compare(&tests, snapshot("a\nc\n")).standing;
        assert_eq!(other, Standing::Differs { accepted: "a\nb".into() });
        // The map of what was a town before goes.
        fs::write(found.path.with_extension("svg"), "<svg/>").unwrap();
        accept(&found).unwrap();
        assert!(!found.path.with_extension("svg").exists());
        assert_eq!(stale(&tests, &[]), [found.path]);
    }
}
