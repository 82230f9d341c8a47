//! The viewer: a city whose rules are live. It owns no data of the city: it shows what `city` builds, and writes changes.

pub mod app;
pub mod command;
pub mod console;
pub mod editor;
pub mod evidence;
pub mod gallery;
pub mod history;
pub mod inspect;
pub mod lost;
pub mod panels;
pub mod pictures;
pub mod preferences;
pub mod preset_file;
pub mod recovery;
pub mod render;
pub mod scene;
pub mod screenshot;
pub mod shown;
pub mod sight;
pub mod state;
pub mod task;
pub mod timeline;
pub mod viewport;
pub mod worker;
