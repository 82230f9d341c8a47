//! Changes that are not saved yet, kept where they outlive the program: what is lost with it can be taken up again.

use crate::worker::whole;
use city::Changes;
use geom::Id;
use std::fs;
use std::path::{Path, PathBuf};

/// Where they are kept, and what was found there.
#[derive(Debug, Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    /// Changes of the open city that were not saved when programs ended, the newest last. People are asked about one after
    /// the other.
    pub found: Vec<Changes>,
}

impl Recovery {
    /// Keeps them beside the file of preferences; without one, nothing is kept.
    pub fn beside(preferences: Option<&Path>) -> Self {
        Self { folder: preferences.and_then(Path::parent).map(|folder| folder.join("unsaved")), found: Vec::new() }
    }

    /// The file for a city, where so many others wait for an answer.
    fn file(&self, city: &Path, waiting: usize) -> Option<PathBuf> {
        let name = Id::of_text("unsaved", &whole(city).to_string_lossy());
        let number = if waiting == 0 { String::new() } else { format!(".{waiting}") };
        Some(self.folder.as_ref()?.join(format!("{name}{number}.changes")))
    }

    /// Keeps the changes of a city that are not saved; takes what was kept away when all are. What was found here and waits for
    /// an answer stays.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn keep(&self, city: &Path, unsaved: Option<&Changes>) -> Result<(), String> {
        if let Some(changes) = unsaved {
            self.write(city, self.found.len(), changes)?;
        }
        // What was answered is gone.
        self.remove_from(city, self.found.len() + usize::from(unsaved.is_some()))
    }

    fn write(&self, city: &Path, waiting: usize, changes: &Changes) -> Result<(), String> {
        let (Some(folder), Some(file)) = (&self.folder, self.file(city, waiting)) else { return Ok(()) };
        fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        let text = changes.plain();
        city::export::write_atomically(&file, |out| out.write_all(text.as_bytes())).map_err(|error| error.to_string())
    }

    /// The files that are there, from a number on: none is left out between them.
    fn files(&self, city: &Path, first: usize) -> impl Iterator<Item = PathBuf> {
        (first..).map_while(move |waiting| self.file(city, waiting).filter(|file| file.exists()))
    }

    fn remove_from(&self, city: &Path, first: usize) -> Result<(), String> {
        self.files(city, first).try_for_each(|file| fs::remove_file(&file).map_err(|error| error.to_string()))
    }

    /// Looks for changes of a city that was opened; those that are the saved ones are none.
    pub fn find(&mut self, city: &Path, saved: &Changes) {
        let files: Vec<PathBuf> = self.files(city, 0).collect();
        let read = files.iter().filter_map(|file| Changes::read(file).ok().flatten());
        let mut found: Vec<Changes> = read.filter(|changes| changes != saved).collect();
        found.dedup();
        // They lie in the files of their numbers. Those of full disks are asked about again at the next start.
        if found.len() < files.len()
            && found.iter().enumerate().all(|(number, changes)| self.write(city, number, changes).is_ok())
        {
            let _ = self.remove_from(city, found.len());
        }
        self.found = found;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes(seed: u64) -> Changes {
        let mut changes = Changes::default();
        changes.seed = Some(seed);
        changes
    }

    #[test]
    fn what_comes_while_nobody_has_answered_is_kept_too() {
        let folder = tempfile::tempdir().unwrap();
        let city = folder.path().join("town");
        let saved = Changes::default();
        let start = || {
            let mut recovery = Recovery::beside(Some(&folder.path().join("viewer.json")));
            recovery.find(&city, &saved);
            recovery
        };
        start().keep(&city, Some(&changes(1))).unwrap();
        let second = start();
        assert_eq!(second.found, [changes(1)]);
        second.keep(&city, Some(&changes(2))).unwrap();
        second.keep(&city, Some(&changes(3))).unwrap();
        let mut third = start();
        assert_eq!(third.found, [changes(1), changes(3)], "the last that each of them had");
        third.found.pop();
        third.keep(&city, Some(&changes(3))).unwrap();
        assert_eq!(start().found, [changes(1), changes(3)], "taken up, but not saved");
        third.found.pop();
        third.keep(&city, Some(&changes(3))).unwrap();
        assert_eq!(start().found, [changes(3)]);
        start().keep(&city, None).unwrap();
        assert_eq!(start().found, [changes(3)], "it waits for an answer");
        third.keep(&city, None).unwrap();
        assert_eq!(start().found, []);
        start().keep(&city, Some(&saved)).unwrap();
        let mut fourth = start();
        assert_eq!(fourth.found, [], "what is saved meanwhile needs no answer");
        fourth.found = vec![changes(4), saved.clone(), changes(5)];
        for (number, of) in fourth.found.iter().enumerate() {
            fourth.write(&city, number, of).unwrap();
        }
        let fifth = start();
        fifth.keep(&city, Some(&changes(6))).unwrap();
        assert_eq!(start().found, [changes(4), changes(5), changes(6)]);
        fs::write(fifth.file(&city, 0).unwrap(), "what nobody can read").unwrap();
        let sixth = start();
        sixth.keep(&city, Some(&changes(7))).unwrap();
        assert_eq!(start().found, [changes(5), changes(6), changes(7)]);
    }
}
