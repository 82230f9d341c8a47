//! What the viewer remembers from one start to the next.

use crate::render::{MapCamera, OrbitCamera};
use crate::shown::Layers;
use crate::worker::whole;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most cities that are remembered.
const MOST_RECENT: usize = 12;

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// As the system says.
    #[default]
    System,
    /// Light.
    Light,
    /// Dark.
    Dark,
}

impl Theme {
    /// All, in the order of the menu.
    pub const ALL: [Self; 3] = [Self::System, Self::Light, Self::Dark];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "As the system",
            Self::Light => "Light",
            Self::Dark => "Dark",
        }
    }
}

/// What people chose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Light or dark.
    pub theme: Theme,
    /// How large everything is; 1 is usual.
    pub scale: f32,
    /// Cities that were open, the last one first.
    pub recent: Vec<PathBuf>,
    /// What is switched on.
    pub layers: Layers,
    /// Views that were kept, by city.
    pub bookmarks: BTreeMap<PathBuf, Vec<Bookmark>>,
    /// What opens a place in a script: see [`crate::editor::open`].
    pub editor: String,
    /// How panels are laid out, as [`crate::panels::written`] writes it; the usual way when none.
    pub docks: Option<serde_json::Value>,
}

/// Where one looked from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    /// What people call it.
    pub name: String,
    /// On the map.
    pub map: MapCamera,
    /// In the model.
    pub model: OrbitCamera,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            scale: 1.0,
            recent: Vec::new(),
            layers: Layers::default(),
            bookmarks: BTreeMap::new(),
            editor: crate::editor::USUAL.into(),
            docks: None,
        }
    }
}

impl Preferences {
    /// Their file; none where the user has no folder for such things.
    pub fn file() -> Option<PathBuf> {
        Some(dirs::config_dir()?.join("plat").join("viewer.json"))
    }

    /// Those in a file; the usual ones where there is none that can be read.
    pub fn read(file: &Path) -> Self {
        let read = || serde_json::from_slice(&std::fs::read(file).ok()?).ok();
        let mut known: Self = read().unwrap_or_default();
        known.scale = if known.scale.is_finite() { known.scale.clamp(0.5, 4.0) } else { 1.0 };
        known
    }

    /// Writes them, whole or not at all.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), String> {
        let told = |error: &dyn std::fmt::Display| error.to_string();
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|error| told(&error))?;
        }
        let json = serde_json::to_vec_pretty(self).map_err(|error| told(&error))?;
        city::export::write_atomically(file, |out| out.write_all(&json)).map_err(|error| told(&error))
    }

    /// A city was opened.
    pub fn opened(&mut self, city: &Path) {
        let city = whole(city);
        self.recent.retain(|other| *other != city);
        self.recent.insert(0, city);
        self.recent.truncate(MOST_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_read_as_they_were_written_and_broken_ones_are_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/viewer.json");
        let mut known = Preferences { theme: Theme::Dark, scale: 1.5, ..Preferences::default() };
        known.opened(Path::new("/cities/a"));
        known.write(&file).unwrap();
        assert_eq!(Preferences::read(&file), known);
        std::fs::write(&file, "{ \"theme\": \"Pink\"").unwrap();
        assert_eq!(Preferences::read(&file), Preferences::default());
        std::fs::write(&file, "{ \"scale\": 900, \"unknown\": 1 }").unwrap();
        assert_eq!(Preferences::read(&file).scale, 4.0);
    }

    #[test]
    fn the_last_city_comes_first_and_once() {
        let mut known = Preferences::default();
        for city in ["/a", "/b", "/a"] {
            known.opened(Path::new(city));
        }
        assert_eq!(known.recent, [PathBuf::from("/a"), PathBuf::from("/b")]);
    }
}
