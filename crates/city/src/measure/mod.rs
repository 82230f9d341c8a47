//! Street statistics of a layout: what one says of real cities in numbers, so that a grown one can be held against them.
//!
//! A measure is a function of what the layout file says, of maps in its frame and of a mask: the same for cities that
//! were grown, imported or drawn elsewhere. [`MEASURES`] lists them with their units; lengths are along centre lines.

mod area;
mod bearing;
mod error;
mod ground;
mod judge;
mod network;
mod scene;
mod spread;

pub(crate) use area::{holds, place_inside, ring_area};
pub use error::MeasureError;
pub use judge::{Judged, Range, Ranges, Verdict};
pub use scene::{Maps, Window};

use crate::export::LayoutFile;
use scene::Scene;
use serde_json::Value;

/// A measure: its name in files, its unit, and what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measure {
    /// Name in files and tables.
    pub name: &'static str,
    /// Unit; empty for shares and other plain numbers.
    pub unit: &'static str,
    /// What it says.
    pub about: &'static str,
}

const fn measure_of(name: &'static str, unit: &'static str, about: &'static str) -> Measure {
    Measure { name, unit, about }
}

/// All measures, in the order they are told.
pub const MEASURES: [Measure; 21] = [
    measure_of("km2", "km²", "area measured: of the mask, of the window, or of the box around the streets"),
    measure_of("segment_median", "m", "median length between crossings (nodes of degree other than 2)"),
    measure_of("segment_cv", "", "standard deviation of these lengths over their mean"),
    measure_of("crossings_km2", "per km²", "crossings where three or more streets meet"),
    measure_of("km_per_km2", "km per km²", "length of streets"),
    measure_of("x_share", "", "share of four-way crossings among nodes of degree other than 2"),
    measure_of("t_share", "", "share of three-way crossings"),
    measure_of("dead_end_share", "", "share of dead ends"),
    measure_of("order", "", "orientation order by length, 36 bins: 1 one grid, 0 every heading alike (Boeing 2019)"),
    measure_of("headings", "°", "the two strongest headings, counter-clockwise from east, modulo 180"),
    measure_of("largest_component", "", "share of length in the largest connected network"),
    measure_of("bridge_share", "", "share of length on bridges or in tunnels"),
    measure_of("block_median_ha", "ha", "median area of blocks"),
    measure_of("block_spread", "", "90th over 10th percentile of their areas"),
    measure_of("water_share", "", "share of length on water, bridges apart (map `land`)"),
    measure_of("park_share", "", "share of length in parks (map `parks`)"),
    measure_of("density_rank", "", "rank correlation of street length and density over 300 m cells (map `density`)"),
    measure_of("grade_p95", "%", "95th percentile of the grade of 10 m pieces (map `elevation`)"),
    measure_of("contour_share", "", "steeper than 10 %: share of length within 30° of the contour"),
    measure_of("fall_share", "", "steeper than 10 %: share of length within 30° of the fall line"),
    measure_of("steep_km", "km", "length where the ground is steeper than 10 %"),
];

/// What a measure came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Figure {
    /// One number.
    Number(f64),
    /// Two headings in degrees, the stronger first.
    Headings([f64; 2]),
}

impl Figure {
    /// The figure as JSON: a number, or a list of two.
    pub fn to_json(self) -> Value {
        match self {
            Self::Number(number) => number.into(),
            Self::Headings(headings) => headings.to_vec().into(),
        }
    }
}

/// The figures of a layout, in the order of [`MEASURES`]; what could not be measured is absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures(Vec<(&'static Measure, Figure)>);

impl Figures {
    /// The figure of that name.
    pub fn get(&self, name: &str) -> Option<Figure> {
        self.iter().find(|(measure, _)| measure.name == name).map(|(_, figure)| figure)
    }

    /// Measures with their figures.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Measure, Figure)> {
        self.0.iter().copied()
    }

    /// Whether nothing could be measured: no street lies inside.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One JSON object, names to figures.
    pub fn to_json(&self) -> serde_json::Map<String, Value> {
        self.iter().map(|(measure, figure)| (measure.name.to_owned(), figure.to_json())).collect()
    }
}

/// Measures the streets and blocks of a layout whose middle lies inside the mask and the window.
///
/// # Errors
/// [`MeasureError::Street`] for a street that does not say where it lies or what it joins.
pub fn measure(file: &LayoutFile, maps: &Maps, window: Option<Window>) -> Result<Figures, MeasureError> {
    let scene = Scene::of(file, maps, window)?;
    if scene.streets.is_empty() {
        return Ok(Figures::default());
    }
    let walk = ground::Walk::of(&scene);
    let number = |value: Option<f64>| value.filter(|value| value.is_finite()).map(Figure::Number);
    let figure = |measure: &'static Measure| {
        let figure = match measure.name {
            "km2" => number(Some(scene.km2)),
            "segment_median" => number(network::segment_median(&scene)),
            "segment_cv" => number(network::segment_cv(&scene)),
            "crossings_km2" => number(Some(network::crossings_km2(&scene))),
            "km_per_km2" => number(Some(network::km_per_km2(&scene))),
            "x_share" => number(network::degree_share(&scene, 4)),
            "t_share" => number(network::degree_share(&scene, 3)),
            "dead_end_share" => number(network::degree_share(&scene, 1)),
            "order" => number(bearing::order(&scene)),
            "headings" => bearing::headings(&scene).map(Figure::Headings),
            "largest_component" => number(network::largest_component(&scene)),
            "bridge_share" => number(network::bridge_share(&scene)),
            "block_median_ha" => number(area::block_median_ha(&scene)),
            "block_spread" => number(area::block_spread(&scene)),
            "water_share" => number(walk.water_share()),
            "park_share" => number(walk.park_share()),
            "density_rank" => number(walk.density_rank(&scene)),
            "grade_p95" => number(walk.grade_p95()),
            "contour_share" => number(walk.contour_share()),
            "fall_share" => number(walk.fall_share()),
            _ => number(walk.steep_km()),
        };
        figure.map(|figure| (measure, figure))
    };
    Ok(Figures(MEASURES.iter().filter_map(figure).collect()))
}

#[cfg(test)]
mod tests;
