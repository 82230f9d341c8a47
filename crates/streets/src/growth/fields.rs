//! What a tip can know of its place: the maps of the site, sampled.

use geom::{Bounds, Raster, Vec2};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A value over the plane: a map, or one number everywhere.
#[derive(Clone, Debug)]
pub enum Field {
    /// The same everywhere.
    Constant(f64),
    /// Read from a map, bilinearly.
    Map(Arc<Raster>),
}

impl Field {
    /// The value at a place in metres.
    pub fn at(&self, place: Vec2) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Map(raster) => raster.bilinear(place),
        }
    }
}

/// The maps that growth reads. Shared by all tips of a city.
#[derive(Clone, Debug)]
pub struct Fields {
    /// The site.
    pub bounds: Bounds,
    /// Masks that must all hold where a street may lie: land, the area to build.
    pub legal: Vec<Arc<Raster>>,
    /// Masks where no street may lie: parks.
    pub barred: Vec<Arc<Raster>>,
    /// People per km².
    pub density: Field,
    /// Metres above sea level.
    pub elevation: Field,
    /// Any map a script asks for, by name.
    pub maps: BTreeMap<String, Field>,
}

impl Fields {
    /// Flat, dry, evenly settled land.
    pub fn plain(bounds: Bounds) -> Self {
        Self {
            bounds,
            legal: Vec::new(),
            barred: Vec::new(),
            density: Field::Constant(1.0),
            elevation: Field::Constant(0.0),
            maps: BTreeMap::new(),
        }
    }

    /// Whether a street may lie at a place in metres.
    pub fn is_legal(&self, place: Vec2) -> bool {
        let (low, high) = (self.bounds.min.metres(), self.bounds.max.metres());
        place.cmpge(low).all()
            && place.cmple(high).all()
            && self.legal.iter().all(|mask| mask.mask(place))
            && !self.barred.iter().any(|mask| mask.mask(place))
    }

    /// Density along a ray, each of `samples` samples weighted with the inverse of its distance: what a highway's end
    /// sums up to find the next centre of population (PM01 §3.2.1). `radius` in metres.
    pub fn density_ahead(&self, place: Vec2, direction: Vec2, radius: f64, samples: u32) -> f64 {
        let sample = |i: u32| {
            let distance = radius * f64::from(i) / f64::from(samples);
            self.density.at(place + direction * distance) / distance
        };
        (1..=samples).map(sample).sum()
    }
}
