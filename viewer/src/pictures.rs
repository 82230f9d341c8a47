//! Pictures of cities to choose from: `picture.png` in a city's folder, read on a thread of their own.

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

/// The file of a picture.
const FILE: &str = "picture.png";

/// Longest side of what is shown, in pixels.
const SIDE: u32 = 400;

/// Pictures by folder.
#[derive(Default)]
pub struct Pictures {
    known: BTreeMap<PathBuf, Option<TextureHandle>>,
    thread: Option<Thread>,
}

/// Folders that are asked for, and their pictures.
type Thread = (Sender<PathBuf>, Receiver<(PathBuf, ColorImage)>);

impl Pictures {
    /// The picture of a city, once it is read; none where there is none.
    pub fn of(&mut self, context: &Context, city: &Path) -> Option<TextureHandle> {
        let (wanted, read) = self.thread.get_or_insert_with(|| start(context.clone()));
        for (folder, picture) in read.try_iter() {
            let texture = context.load_texture(folder.to_string_lossy(), picture, TextureOptions::LINEAR);
            self.known.insert(folder, Some(texture));
        }
        if let Some(known) = self.known.get(city) {
            return known.clone();
        }
        // Without the thread there are names alone.
        let _ = wanted.send(city.to_path_buf());
        self.known.insert(city.to_path_buf(), None);
        None
    }
}

fn start(wake: Context) -> Thread {
    let (wanted, folders) = channel::<PathBuf>();
    let (sender, read) = channel();
    let _ = std::thread::Builder::new().name("pictures".into()).spawn(move || {
        for folder in folders {
            let Ok(picture) = image::open(folder.join(FILE)) else { continue };
            let small = picture.thumbnail(SIDE, SIDE).to_rgba8();
            let size = [small.width() as usize, small.height() as usize];
            if sender.send((folder, ColorImage::from_rgba_unmultiplied(size, small.as_raw()))).is_err() {
                return;
            }
            wake.request_repaint();
        }
    });
    (wanted, read)
}
