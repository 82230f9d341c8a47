//! The look of the map: muted ground, light streets, buildings darker the higher they are.

use super::canvas::Colour;
use streets::{Class, Classes};

/// What a map was told to mark.
pub const MARK: Colour = Colour(0xc2, 0x18, 0x5b);
/// The page around the map.
pub const PAPER: Colour = Colour(0xfb, 0xfa, 0xf7);
/// Words and frame.
pub const INK: Colour = Colour(0x3a, 0x39, 0x36);
/// Lesser words.
pub const FAINT_INK: Colour = Colour(0x7c, 0x79, 0x72);
/// Water.
pub const WATER: Colour = Colour(0xbf, 0xd4, 0xdf);
/// Shores.
pub const SHORE: Colour = Colour(0x95, 0xb4, 0xc5);
/// Land outside blocks.
pub const LAND: Colour = Colour(0xf1, 0xee, 0xe7);
/// Parks and other green.
pub const PARK: Colour = Colour(0xcd, 0xdd, 0xb9);
/// Open land of the city.
pub const OPEN: Colour = Colour(0xde, 0xe3, 0xcb);
/// Plazas.
pub const PLAZA: Colour = Colour(0xea, 0xdc, 0xcd);
/// Blocks.
pub const BLOCK: Colour = Colour(0xea, 0xe5, 0xda);
/// Borders of parcels.
pub const PARCEL_LINE: Colour = Colour(0xd5, 0xcd, 0xbe);
/// Lines of equal height.
pub const HEIGHT_LINE: Colour = Colour(0xdc, 0xd2, 0xbf);
/// The lowest buildings.
pub const LOW_BUILDING: Colour = Colour(0xd3, 0xc5, 0xb1);
/// The highest buildings.
pub const HIGH_BUILDING: Colour = Colour(0x7a, 0x5a, 0x4b);

/// Landmarks and their names.
pub const LANDMARK: Colour = Colour(0x8a, 0x2f, 0x24);

/// Heights in metres that part the tones of buildings.
pub const TONES: [f64; 5] = [10.0, 20.0, 40.0, 80.0, 150.0];

/// The tone of a building of a height in metres: 0 for the lowest, `TONES.len()` for the highest.
pub fn tone(height: f64) -> usize {
    TONES.iter().filter(|&&least| height >= least).count()
}

/// The colour of a tone.
pub fn tone_colour(tone: usize) -> Colour {
    LOW_BUILDING.towards(HIGH_BUILDING, tone as f32 / TONES.len() as f32)
}

/// How the streets of a class are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreetStyle {
    /// Between the casings.
    pub fill: Colour,
    /// Both sides.
    pub casing: Colour,
    /// Least width on a page of 3000 pixels, casings included.
    pub least: f32,
}

/// The style of a class: by its name where it is a usual one, else by whether it closes quarters.
pub fn street_style(classes: &Classes, class: Class) -> StreetStyle {
    let info = classes.info(class);
    match info.name.as_str() {
        "highway" => HIGHWAY,
        "major" => MAJOR,
        _ if info.closes_quarters && class == Classes::HIGHWAY => HIGHWAY,
        _ if info.closes_quarters => MAJOR,
        _ => MINOR,
    }
}

/// Both sides of a street of a colour.
pub fn rim(colour: Colour) -> Colour {
    colour.towards(INK, 0.45)
}

/// Least width of a coloured street on a page of 3000 pixels: wide enough for its colour to be told.
pub fn least_coloured(classes: &Classes, class: Class) -> f32 {
    street_style(classes, class).least.max(1.8) + 1.0
}

const HIGHWAY: StreetStyle =
    StreetStyle { fill: Colour(0xf4, 0xc2, 0x7e), casing: Colour(0xbf, 0x8c, 0x45), least: 5.0 };
const MAJOR: StreetStyle = StreetStyle { fill: Colour(0xfd, 0xf0, 0xc9), casing: Colour(0xd0, 0xb9, 0x81), least: 3.4 };
const MINOR: StreetStyle = StreetStyle { fill: Colour(0xff, 0xff, 0xff), casing: Colour(0xcf, 0xc7, 0xb8), least: 1.4 };
