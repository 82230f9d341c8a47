//! A map as its picture has it: whole grey steps, so that what is counted or differentiated loses nothing to rounding.

use super::error::SourceError;
use super::maps::{Picture, map_names};
use super::sidecar::Sidecar;
use super::suggest;
use geom::Raster;
use std::path::Path;

/// Grey steps above this one are inside a mask.
const MIDDLE_GREY: u16 = 127;

/// A map's picture with what its sidecar says. Local frame of the site: x east, y north, metres, (0, 0) south-west.
#[derive(Clone, Debug)]
pub struct PixelMap {
    width: usize,
    height: usize,
    /// Row by row from the north.
    pixels: Vec<u16>,
    pixel_size: f64,
    scale: f64,
    offset: f64,
}

impl PixelMap {
    /// Reads the map of that name from a folder.
    ///
    /// # Errors
    /// [`SourceError`] when the folder has no such map, or its picture or sidecar is missing or wrong.
    pub fn read(folder: &Path, name: &str) -> Result<Self, SourceError> {
        let present = map_names(folder)?;
        if !present.iter().any(|other| other == name) {
            let hint = suggest::hint_for(name, &present);
            return Err(SourceError::MissingMap { path: folder.to_owned(), name: name.to_owned(), hint });
        }
        let path = folder.join(format!("{name}.png"));
        let sidecar_path = path.with_extension("json");
        let Some(sidecar) = Sidecar::read(&sidecar_path)? else {
            return Err(super::maps::no_sidecar(&path, &sidecar_path));
        };
        sidecar.check_value(&sidecar_path)?;
        let picture = Picture::open(&path)?;
        let placement = sidecar.placement(&sidecar_path, picture.width, picture.height)?;
        Ok(Self {
            width: picture.width as usize,
            height: picture.height as usize,
            pixels: picture.greys(),
            pixel_size: sidecar.pixel_size_m.unwrap_or(placement.pixel_size),
            scale: sidecar.value.scale,
            offset: sidecar.value.offset,
        })
    }

    /// A map in memory, in as many grey steps as a picture has at most.
    pub fn of_raster(raster: &Raster) -> Self {
        let values = raster.values().iter().map(|&value| f64::from(value));
        let (low, high) = values.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let scale = ((high - low) / f64::from(u16::MAX)).max(f64::MIN_POSITIVE);
        let pixels = values.map(|value| ((value - low) / scale).round() as u16).collect();
        let (width, height) = raster.size();
        Self { width, height, pixels, pixel_size: raster.pixel_size(), scale, offset: low }
    }

    /// A mask in memory: what is more than one half is inside.
    pub fn of_mask(raster: &Raster) -> Self {
        let pixels = raster.values().iter().map(|&value| if value > 0.5 { 255 } else { 0 }).collect();
        let (width, height) = raster.size();
        Self { width, height, pixels, pixel_size: raster.pixel_size(), scale: 1.0, offset: 0.0 }
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Metres per pixel.
    pub fn pixel_size(&self) -> f64 {
        self.pixel_size
    }

    /// The grey step of a pixel; row 0 is the northernmost.
    pub fn grey(&self, column: usize, row: usize) -> u16 {
        self.pixels[row * self.width + column]
    }

    /// Whether the pixel at a place is inside the mask; nothing is beyond the map.
    pub fn is_inside(&self, [x, y]: [f64; 2]) -> bool {
        let column = floor_of(x, self.pixel_size);
        let row = self.height as f64 - 1.0 - floor_of(y, self.pixel_size);
        let is_on_map = column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
        is_on_map && self.is_set(column as usize, row as usize)
    }

    /// Whether a pixel is inside the mask.
    pub fn is_set(&self, column: usize, row: usize) -> bool {
        self.grey(column, row) > MIDDLE_GREY
    }

    /// The middle of a pixel in metres.
    pub fn middle(&self, column: usize, row: usize) -> [f64; 2] {
        [(column as f64 + 0.5) * self.pixel_size, (self.height as f64 - 0.5 - row as f64) * self.pixel_size]
    }

    /// The value at a place, linear between the middles of pixels; beyond them as at the rim.
    pub fn bilinear(&self, [x, y]: [f64; 2]) -> f64 {
        let along = |at: f64, count: usize| {
            let low = at.floor().min(count as f64 - 2.0).max(0.0);
            (low as usize, (low as usize + 1).min(count - 1), (at - low).clamp(0.0, 1.0))
        };
        let (west, east, u) = along(x / self.pixel_size - 0.5, self.width);
        let (north, south, v) = along(self.height as f64 - 0.5 - y / self.pixel_size, self.height);
        let grey = |column, row| f64::from(self.grey(column, row));
        let upper = grey(west, north) * (1.0 - u) + grey(east, north) * u;
        let lower = grey(west, south) * (1.0 - u) + grey(east, south) * u;
        (upper * (1.0 - v) + lower * v) * self.scale + self.offset
    }

    /// Rise per metre to the east and to the north, over `reach` metres each way.
    pub fn gradient(&self, [x, y]: [f64; 2], reach: f64) -> [f64; 2] {
        let east = self.bilinear([x + reach, y]) - self.bilinear([x - reach, y]);
        let north = self.bilinear([x, y + reach]) - self.bilinear([x, y - reach]);
        [east / (2.0 * reach), north / (2.0 * reach)]
    }
}

/// How many whole `size`s lie below `value`: exact, where a division would round up just below a border.
pub(crate) fn floor_of(value: f64, size: f64) -> f64 {
    ((value - value.rem_euclid(size)) / size).round()
}
