//! Districts from a picture in which each has a colour.

use super::error::SourceError;
use super::maps::open_colours;
use super::sidecar::{Placement, Sidecar};
use geom::{Cells, Vec2};
use image::RgbaImage;
use script::NO_DISTRICT;
use std::collections::BTreeMap;
use std::path::Path;
use streets::Districts;

/// Colours of districts by name; [`NO_DISTRICT`] names that of other ground.
pub type Legend = BTreeMap<String, [u8; 3]>;

/// A colour map of districts: which picture, and what its colours mean.
#[derive(Clone, Debug, PartialEq)]
pub struct DistrictMap {
    /// The map's name.
    pub map: String,
    /// The legend; that of the sidecar when empty.
    pub legend: Legend,
}

/// How many colours an error tells.
const MOST_TOLD: usize = 8;

impl DistrictMap {
    /// Reads the districts of a picture. Every pixel must have a colour of the legend, or be transparent; every colour of
    /// the legend must be there. `blamed` is the file that says how large the picture is.
    pub(super) fn read(
        &self,
        path: &Path,
        sidecar: &Sidecar,
        blamed: &Path,
    ) -> Result<(Districts, Placement), SourceError> {
        let legend = self.legend(path, sidecar, blamed)?;
        let picture = open_colours(path)?;
        let (width, height) = picture.dimensions();
        let placement = sidecar.placement(blamed, width, height)?;
        check_colours(path, &picture, &legend)?;
        let names: Vec<String> = legend.keys().filter(|name| *name != NO_DISTRICT).cloned().collect();
        let named = names.iter().enumerate().filter_map(|(at, name)| Some((*legend.get(name)?, at as u16)));
        let numbers: BTreeMap<[u8; 3], u16> = named.collect();
        let label = |column: usize, row: usize| {
            let colour = colour_of(picture.get_pixel(column as u32, row as u32))?;
            numbers.get(&colour).copied()
        };
        let cells = Cells::new(width as usize, height as usize, placement.pixel_size, Vec2::ZERO, label);
        let too_fine = || SourceError::picture(path, "has pixels finer than 1 mm", "scale the picture down");
        Ok((Districts::of_cells(names, cells.ok_or_else(too_fine)?), placement))
    }

    /// The legend given, else that of the sidecar.
    fn legend(&self, path: &Path, sidecar: &Sidecar, blamed: &Path) -> Result<Legend, SourceError> {
        if !self.legend.is_empty() {
            return Ok(self.legend.clone());
        }
        let hint = "say which colour is which district: site.districts(\"districts\", #{ harbour: \"#2980b9\" }), or \
                    \"legend\": {\"harbour\": \"#2980b9\"} in the sidecar";
        let none = || SourceError::picture(path, "has no legend", hint);
        let told = sidecar.legend.as_ref().filter(|legend| !legend.is_empty()).ok_or_else(none)?;
        let mut legend = Legend::new();
        for (name, text) in told {
            let what = format!("legend.{name}");
            let rule = "a colour is written #rrggbb, such as #2980b9";
            let colour = parse_colour(text).ok_or_else(|| SourceError::value(blamed, &what, text, rule))?;
            if let Some((other, _)) = legend.iter().find(|(_, known)| **known == colour) {
                let rule = format!("`{other}` has the same colour, and each district needs its own");
                return Err(SourceError::value(blamed, &what, text, &rule));
            }
            legend.insert(name.clone(), colour);
        }
        Ok(legend)
    }
}

/// The colour of a pixel; none where it is transparent.
fn colour_of(pixel: &image::Rgba<u8>) -> Option<[u8; 3]> {
    let [red, green, blue, alpha] = pixel.0;
    (alpha > 0).then_some([red, green, blue])
}

/// Refuses a picture with colours that the legend does not name, and a legend with colours that the picture has not.
fn check_colours(path: &Path, picture: &RgbaImage, legend: &Legend) -> Result<(), SourceError> {
    let mut counts: BTreeMap<[u8; 3], usize> = BTreeMap::new();
    let mut last = ([0; 3], 0usize);
    for colour in picture.pixels().filter_map(colour_of) {
        // Neighbours are mostly alike.
        if colour == last.0 {
            last.1 += 1;
        } else {
            *counts.entry(last.0).or_default() += last.1;
            last = (colour, 1);
        }
    }
    *counts.entry(last.0).or_default() += last.1;
    counts.retain(|_, count| *count > 0);
    let pixels = picture.pixels().len();
    let unnamed: BTreeMap<_, _> =
        counts.iter().filter(|(colour, _)| !legend.values().any(|named| named == *colour)).collect();
    if !unnamed.is_empty() {
        let message = format!("has colours that the legend does not name: {}", told(&unnamed, pixels));
        let hint = format!(
            "name them in the legend, as `{NO_DISTRICT}` where no district is meant; smoothed borders make many colours: \
             draw without anti-aliasing"
        );
        return Err(SourceError::picture(path, message, hint));
    }
    let absent = legend.iter().find(|(_, colour)| !counts.contains_key(*colour));
    absent.map_or(Ok(()), |(name, colour)| {
        let message = format!("has no pixel of `{name}`, {}", text_of(*colour));
        let found = told(&counts.iter().collect(), pixels);
        Err(SourceError::picture(path, message, format!("its colours are {found}: correct the legend or the picture")))
    })
}

/// Colours with their share of all pixels, the largest first.
fn told(counts: &BTreeMap<&[u8; 3], &usize>, pixels: usize) -> String {
    let mut sorted: Vec<(usize, [u8; 3])> = counts.iter().map(|(colour, count)| (**count, **colour)).collect();
    sorted.sort_by(|(a, x), (b, y)| b.cmp(a).then(x.cmp(y)));
    let share = |count: usize| 100.0 * count as f64 / pixels as f64;
    let told =
        sorted.iter().take(MOST_TOLD).map(|(count, colour)| format!("{} ({:.2} %)", text_of(*colour), share(*count)));
    let rest = sorted.len().saturating_sub(MOST_TOLD);
    let more = (rest > 0).then(|| format!("{rest} more"));
    told.chain(more).collect::<Vec<_>>().join(", ")
}

/// `#rrggbb`.
fn parse_colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let part = |i: usize| u8::from_str_radix(digits.get(i..i + 2)?, 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}

fn text_of([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests;
