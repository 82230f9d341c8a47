//! Pictures of presets, drawn by the program itself, one after the other on a thread of their own.

use city::testing::picture;
use script::{Host, Preset};
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// A preset with its picture.
pub struct Card {
    /// The preset.
    pub preset: Preset,
    /// Its picture, once it is drawn: size and pixels (sRGB, opaque).
    pub picture: Option<image::RgbaImage>,
    /// The picture as the window holds it.
    pub texture: Option<eframe::egui::TextureHandle>,
}

/// All presets of a city, in alphabetical order; those that cannot be read are left out.
#[derive(Default)]
pub struct Gallery {
    /// Cards by the presets' names.
    pub cards: BTreeMap<String, Card>,
    drawn: Option<Receiver<(String, image::RgbaImage)>>,
    wanted: Option<Sender<Preset>>,
}

impl Gallery {
    /// Takes in the presets that a host knows now.
    pub fn follow(&mut self, host: &Host) {
        let presets = host.preset_names().into_iter().filter_map(|name| host.preset(&name).ok());
        let mut before = std::mem::take(&mut self.cards);
        for preset in presets {
            let kept =
                before.remove(preset.name()).filter(|card| format!("{:?}", card.preset) == format!("{preset:?}"));
            let card = kept.unwrap_or(Card { preset, picture: None, texture: None });
            self.cards.insert(card.preset.name().to_owned(), card);
        }
    }

    /// Draws what has no picture yet; to be called while they are shown.
    pub fn draw(&mut self, wake: &eframe::egui::Context) {
        let wanted = self.wanted.get_or_insert_with(|| {
            let (wanted, presets) = channel::<Preset>();
            let (sender, drawn) = channel();
            let wake = wake.clone();
            self.drawn = Some(drawn);
            // Without the thread there are no pictures, and names still say what there is.
            let _ = thread::Builder::new().name("gallery".into()).spawn(move || {
                for preset in presets {
                    let decoded = picture(&preset).ok().and_then(|png| image::load_from_memory(&png).ok());
                    let sent = decoded.map(|decoded| {
                        let small = decoded.thumbnail(240, 240).to_rgba8();
                        sender.send((preset.name().to_owned(), small))
                    });
                    wake.request_repaint();
                    if sent.is_some_and(|sent| sent.is_err()) {
                        return;
                    }
                }
            });
            self.cards.values().for_each(|card| drop(wanted.send(card.preset.clone())));
            wanted
        });
        let _ = wanted;
        let drawn: Vec<_> = self.drawn.iter().flat_map(Receiver::try_iter).collect();
        for (name, picture) in drawn {
            if let Some(card) = self.cards.get_mut(&name) {
                let size = [picture.width() as usize, picture.height() as usize];
                let image = eframe::egui::ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
                card.texture = Some(wake.load_texture(&name, image, eframe::egui::TextureOptions::LINEAR));
                card.picture = Some(picture);
            }
        }
    }
}
