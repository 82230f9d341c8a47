//! Pictures of presets, drawn by the program itself, one after the other on a thread of their own.

use city::testing::picture;
use geom::Id;
use script::Preset;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// A preset with its picture.
pub struct Card {
    /// The preset.
    pub preset: Preset,
    /// The digest of all that it says.
    digest: Id,
    /// Its picture, once it is drawn.
    pub texture: Option<eframe::egui::TextureHandle>,
}

/// All presets of a city, in alphabetical order; those that cannot be read are left out.
#[derive(Default)]
pub struct Gallery {
    /// Cards by the presets' names.
    pub cards: BTreeMap<String, Card>,
    /// Where pictures are kept from one start to the next.
    folder: Option<PathBuf>,
    drawn: Option<Receiver<(Id, image::RgbaImage)>>,
    wanted: Option<Sender<(Preset, Id)>>,
}

impl Gallery {
    /// No presets yet; pictures are kept in a folder, where there is one.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self { folder, ..Self::default() }
    }

    /// Takes in the presets that there are now; those that say something else than before are drawn again.
    pub fn follow(&mut self, presets: &[(Preset, Id)]) {
        let mut before = std::mem::take(&mut self.cards);
        for (preset, digest) in presets {
            let kept = before.remove(preset.name()).filter(|card| card.digest == *digest);
            let card = kept.unwrap_or_else(|| {
                if let Some(wanted) = &self.wanted {
                    // Without the thread there are no pictures.
                    let _ = wanted.send((preset.clone(), *digest));
                }
                Card { preset: preset.clone(), digest: *digest, texture: None }
            });
            self.cards.insert(preset.name().to_owned(), card);
        }
    }

    /// Draws what has no picture yet; to be called while they are shown.
    pub fn draw(&mut self, wake: &eframe::egui::Context) {
        if self.wanted.is_none() {
            let (wanted, presets) = channel::<(Preset, Id)>();
            let (sender, drawn) = channel();
            let (wake, folder) = (wake.clone(), self.folder.clone());
            self.drawn = Some(drawn);
            // Without the thread there are no pictures, and names still say what there is.
            let _ = thread::Builder::new().name("gallery".into()).spawn(move || {
                for (preset, digest) in presets {
                    let Some(small) = kept(folder.as_deref(), digest, &preset) else { continue };
                    if sender.send((digest, small)).is_err() {
                        return;
                    }
                    wake.request_repaint();
                }
            });
            for card in self.cards.values() {
                let _ = wanted.send((card.preset.clone(), card.digest));
            }
            self.wanted = Some(wanted);
        }
        let drawn: Vec<_> = self.drawn.iter().flat_map(Receiver::try_iter).collect();
        for (digest, picture) in drawn {
            for (name, card) in self.cards.iter_mut().filter(|(_, card)| card.digest == digest) {
                let size = [picture.width() as usize, picture.height() as usize];
                let image = eframe::egui::ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
                card.texture = Some(wake.load_texture(name, image, eframe::egui::TextureOptions::LINEAR));
            }
        }
    }
}

/// The picture of a preset as it was drawn at an earlier start, or drawn now.
fn kept(folder: Option<&Path>, digest: Id, preset: &Preset) -> Option<image::RgbaImage> {
    let file = folder.map(|folder| folder.join(format!("{digest}.png")));
    if let Some(known) = file.as_ref().and_then(|file| image::open(file).ok()) {
        return Some(known.to_rgba8());
    }
    let decoded = image::load_from_memory(&picture(preset).ok()?).ok()?;
    let small = decoded.thumbnail(240, 240).to_rgba8();
    if let Some(file) = file {
        // Where it cannot be kept it is drawn again next time.
        let _ = file.parent().map(std::fs::create_dir_all);
        let _ = crate::screenshot::save(&small, &file);
    }
    Some(small)
}
