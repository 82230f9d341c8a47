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
    /// Changes of the open city that were not saved when the program ended.
    pub found: Option<Changes>,
}

impl Recovery {
    /// Keeps them beside the file of preferences; without one, nothing is kept.
    pub fn beside(preferences: Option<&Path>) -> Self {
        Self { folder: preferences.and_then(Path::parent).map(|folder| folder.join("unsaved")), found: None }
    }

    /// The file for a city.
    fn file(&self, city: &Path) -> Option<PathBuf> {
        let name = Id::of_text("unsaved", &whole(city).to_string_lossy());
        Some(self.folder.as_ref()?.join(format!("{name}.changes")))
    }

    /// Keeps the changes of a city that are not saved; takes what was kept away when all are. While changes found here wait
    /// for an answer they are not written over.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn keep(&self, city: &Path, unsaved: Option<&Changes>) -> Result<(), String> {
        let Some(file) = self.file(city).filter(|_| self.found.is_none()) else { return Ok(()) };
        let Some(changes) = unsaved else {
            return match fs::remove_file(&file) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error.to_string()),
                _ => Ok(()),
            };
        };
        if let Some(folder) = &self.folder {
            fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        }
        let text = changes.plain();
        city::export::write_atomically(&file, |out| out.write_all(text.as_bytes())).map_err(|error| error.to_string())
    }

    /// Looks for changes of a city that was opened; those that are the saved ones are none.
    pub fn find(&mut self, city: &Path, saved: &Changes) {
        let read = |file: &Path| Changes::read(file).ok().flatten();
        self.found = self.file(city).and_then(|file| read(&file)).filter(|found| found != saved);
    }
}
