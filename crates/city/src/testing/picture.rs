//! Pictures of presets: what each makes of a small standard site.

use super::laboratory::CityLaboratory;
use crate::Cache;
use crate::export::map::{MapError, MapOptions, png};
use script::Preset;
use std::path::PathBuf;

/// Side of a picture, pixels.
const PIXELS: u32 = 320;

/// Why there is no picture of a preset.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Nothing grows of it.
    #[error("{0}")]
    Town(String),
    /// What grew could not be drawn.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// A map of what a preset makes of the site that its file names, as a PNG file.
///
/// # Errors
/// [`PictureError`] when nothing grows, or it cannot be drawn.
pub fn picture(preset: &Preset) -> Result<Vec<u8>, PictureError> {
    let laboratory = CityLaboratory { folder: PathBuf::new() };
    let built = laboratory.city(preset.shown()).map_err(|error| PictureError::Town(error.message))?;
    let bounds = built.city.site.bounds;
    let options = MapOptions { longest_side: PIXELS, extent: Some(bounds), is_bare: true, ..MapOptions::default() };
    Ok(png(&built.city, &options, &Cache::none())?)
}
