//! What is measured: streets and blocks inside a mask and a window, with the maps around them.

use super::MeasureError;
use super::area::{place_inside, ring_area};
use crate::Site;
use crate::export::LayoutFile;
use crate::export::layout_file::{Feature, Geometry, Properties};
use crate::sources::{PixelMap, map_names};
use std::path::Path;

/// Shorter pieces of a street (m) have no heading worth counting.
const LEAST_PIECE: f64 = 0.5;

/// Masks that a maps folder may have, the first that is there being the area measured.
const MASKS: [&str; 3] = ["borough", "city", "land"];

/// A rectangle in metres: west, south, east, north; its rim is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window(pub [f64; 4]);

impl Window {
    /// Whether a place lies inside.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let [west, south, east, north] = self.0;
        west <= x && x <= east && south <= y && y <= north
    }

    fn km2(&self) -> f64 {
        let [west, south, east, north] = self.0;
        (east - west) * (north - south) / 1e6
    }
}

/// The maps that measures ask; each may be absent.
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// The mask of what is measured.
    pub area: Option<PixelMap>,
    /// Land, by mask.
    pub land: Option<PixelMap>,
    /// Parks, by mask.
    pub parks: Option<PixelMap>,
    /// People.
    pub density: Option<PixelMap>,
    /// Metres above sea level.
    pub elevation: Option<PixelMap>,
}

impl Maps {
    /// Those that a site has; all of it is measured.
    pub fn of_site(site: &Site) -> Self {
        let map = |name: &str| site.map(name).map(|map| PixelMap::of_raster(map));
        let mask = |name: &str| site.map(name).map(|map| PixelMap::of_mask(map));
        Self {
            area: None,
            land: mask("land"),
            parks: mask("parks"),
            density: map("density"),
            elevation: map("elevation"),
        }
    }

    /// Reads what a folder has of these maps; the area measured is `mask`, else the first of `borough`, `city`, `land`
    /// that is there.
    ///
    /// # Errors
    /// [`MeasureError::Map`] for a missing folder or mask, and for maps that cannot be read.
    pub fn read(folder: &Path, mask: Option<&str>) -> Result<Self, MeasureError> {
        let present = map_names(folder)?;
        let has = |name: &str| present.iter().any(|other| other == name);
        let read = |name: &str| PixelMap::read(folder, name).map_err(MeasureError::from);
        let known = |name: &str| has(name).then(|| read(name)).transpose();
        let mask = mask.or_else(|| MASKS.into_iter().find(|name| has(name)));
        Ok(Self {
            area: mask.map(read).transpose()?,
            land: known("land")?,
            parks: known("parks")?,
            density: known("density")?,
            elevation: known("elevation")?,
        })
    }
}

/// A street between two crossings.
pub(super) struct Street<'a> {
    pub from: &'a str,
    pub to: &'a str,
    /// Metres.
    pub length: f64,
}

/// A straight piece of street.
pub(super) struct Piece {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// Metres.
    pub length: f64,
    /// Whether on a bridge or in a tunnel.
    pub is_raised: bool,
}

/// What is measured.
pub(super) struct Scene<'a> {
    pub maps: &'a Maps,
    window: Option<Window>,
    pub streets: Vec<Street<'a>>,
    pub pieces: Vec<Piece>,
    /// Areas of blocks in hectares.
    pub blocks: Vec<f64>,
    pub km2: f64,
}

impl<'a> Scene<'a> {
    pub fn of(file: &'a LayoutFile, maps: &'a Maps, window: Option<Window>) -> Result<Self, MeasureError> {
        let mut scene = Self { maps, window, streets: Vec::new(), pieces: Vec::new(), blocks: Vec::new(), km2: 0.0 };
        for feature in &file.features {
            match feature.properties.kind.as_deref() {
                Some("street") => scene.take_street(feature)?,
                Some("block") => scene.take_block(feature),
                _ => {}
            }
        }
        scene.km2 = scene.area();
        Ok(scene)
    }

    /// Whether a place lies in the mask and in the window.
    pub fn holds(&self, at: [f64; 2]) -> bool {
        self.window.is_none_or(|window| window.holds(at))
            && self.maps.area.as_ref().is_none_or(|area| area.is_inside(at))
    }

    fn take_street(&mut self, feature: &'a Feature) -> Result<(), MeasureError> {
        let says = &feature.properties;
        let Geometry::LineString(line) = &feature.geometry else {
            return Err(bad(says, format!("is {}, not a LineString", feature.geometry.name())));
        };
        let (Some(from), Some(to)) = (says.from.as_deref(), says.to.as_deref()) else {
            return Err(bad(says, "does not name the crossings `from` and `to` that it joins"));
        };
        let Some(middle) = middle(line) else { return Err(bad(says, "has no points")) };
        if !self.holds(middle) {
            return Ok(());
        }
        let pairs = || line.windows(2).map(|pair| (pair[0], pair[1]));
        self.streets.push(Street { from, to, length: pairs().map(|(a, b)| distance(a, b)).sum() });
        let is_raised = says.bridge || says.tunnel || says.level != 0.0;
        let pieces = pairs().map(|(from, to)| Piece { from, to, length: distance(from, to), is_raised });
        self.pieces.extend(pieces.filter(|piece| piece.length > LEAST_PIECE));
        Ok(())
    }

    fn take_block(&mut self, feature: &Feature) {
        let Geometry::Polygon(rings) = &feature.geometry else { return };
        if place_inside(rings).is_some_and(|place| self.holds(place)) {
            let holes: f64 = rings.iter().skip(1).map(|hole| ring_area(hole)).sum();
            self.blocks.push((rings.first().map_or(0.0, |ring| ring_area(ring)) - holes) / 1e4);
        }
    }

    /// Square kilometres of what is measured.
    fn area(&self) -> f64 {
        match (&self.maps.area, self.window) {
            (Some(mask), window) => masked_km2(mask, window),
            (None, Some(window)) => window.km2(),
            (None, None) => self.box_km2(),
        }
    }

    /// The area of the box around all pieces.
    fn box_km2(&self) -> f64 {
        let span = |axis: usize| {
            let ends = self.pieces.iter().flat_map(|piece| [piece.from[axis], piece.to[axis]]);
            let (low, high) = ends.fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)));
            (high - low).max(0.0)
        };
        span(0) * span(1) / 1e6
    }
}

fn masked_km2(mask: &PixelMap, window: Option<Window>) -> f64 {
    let (width, height) = mask.size();
    let is_in = |column: usize, row: usize| {
        mask.is_set(column, row) && window.is_none_or(|window| window.holds(mask.middle(column, row)))
    };
    let count: usize = (0..height).map(|row| (0..width).filter(|&column| is_in(column, row)).count()).sum();
    count as f64 * (mask.pixel_size() * mask.pixel_size()) / 1e6
}

fn bad(says: &Properties, message: impl Into<String>) -> MeasureError {
    let id = says.id.clone().unwrap_or_else(|| "without id".into());
    MeasureError::Street { id, message: message.into() }
}

/// Half way along a line.
fn middle(line: &[[f64; 2]]) -> Option<[f64; 2]> {
    let pairs = || line.windows(2).map(|pair| (pair[0], pair[1], distance(pair[0], pair[1])));
    let mut left = pairs().map(|(.., length)| length).sum::<f64>() / 2.0;
    for (a, b, length) in pairs() {
        if left <= length && length > 0.0 {
            let at = |axis: usize| a[axis] + (b[axis] - a[axis]) * left / length;
            return Some([at(0), at(1)]);
        }
        left -= length;
    }
    line.first().copied()
}

pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    (x * x + y * y).sqrt()
}
