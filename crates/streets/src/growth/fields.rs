//! What a tip can know of its place: the maps of the site, sampled.

use super::peaks::Peaks;
use super::{Distances, Zones};
use crate::districts::{Districts, PerDistrict};
use geom::{Bounds, Raster, Vec2};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A value over the plane: a map, one number everywhere, or one for each district.
#[derive(Clone, Debug)]
pub enum Field {
    /// The same everywhere.
    Constant(f64),
    /// Read from a map, bilinearly.
    Map(Arc<Raster>),
    /// Read from a map, and fitted.
    Fitted(Arc<Raster>, Fit),
    /// Another field in each district.
    District(Arc<PerDistrict<Field>>),
    /// Another field, raised around some places.
    Raised(Box<Field>, Arc<[Rise]>),
}

/// A hill added to a field around a place: what a landmark does to density, so that streets seek it like a centre of
/// population.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rise {
    /// Where it is highest, in metres.
    pub at: Vec2,
    /// How high; not negative.
    pub height: f64,
    /// How far it reaches, in metres; above 0.
    pub reach: f64,
}

impl Rise {
    /// What it adds at a place, and the change of that per metre: `height · (1 - d² / reach²)²`.
    fn of(&self, place: Vec2) -> (f64, Vec2) {
        let from_top = place - self.at;
        let squared = self.reach * self.reach;
        let share = (1.0 - from_top.length_squared() / squared).max(0.0);
        (self.height * share * share, from_top * (-4.0 * self.height * share / squared))
    }
}

/// How a value of a map becomes one in other units: `value × scale + offset`, held between `low` and `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Factor.
    pub scale: f64,
    /// Added after it.
    pub offset: f64,
    /// Least result.
    pub low: f64,
    /// Greatest result.
    pub high: f64,
}

impl Fit {
    /// Leaves every value as it is.
    pub const NONE: Self = Self { scale: 1.0, offset: 0.0, low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// The fitted value.
    pub fn of(&self, value: f64) -> f64 {
        (value * self.scale + self.offset).max(self.low).min(self.high)
    }

    /// This fit, its results then multiplied by `scale` and moved by `offset`.
    #[must_use]
    pub fn scaled(self, scale: f64, offset: f64) -> Self {
        // Nothing times endless is no number: without a factor all results are the offset.
        let end = |end: f64| if scale == 0.0 { offset } else { end * scale + offset };
        let (a, b) = (end(self.low), end(self.high));
        Self { scale: self.scale * scale, offset: self.offset * scale + offset, low: a.min(b), high: a.max(b) }
    }

    /// This fit, its results then held between two values.
    #[must_use]
    pub fn held(self, low: f64, high: f64) -> Self {
        let hold = |end: f64| end.max(low).min(high);
        Self { low: hold(self.low), high: hold(self.high), ..self }
    }
}

impl From<f64> for Field {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl Field {
    /// The value at a place in metres.
    pub fn at(&self, place: Vec2) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Map(raster) => raster.bilinear(place),
            Self::Fitted(raster, fit) => fit.of(raster.bilinear(place)),
            Self::District(fields) => fields.at(place).at(place),
            Self::Raised(field, rises) => field.at(place) + rises.iter().map(|rise| rise.of(place).0).sum::<f64>(),
        }
    }

    /// The least and the greatest value it has anywhere; of a raised one, bounds for them.
    pub fn range(&self) -> (f64, f64) {
        let over = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        match self {
            Self::Constant(value) => (*value, *value),
            Self::Map(raster) => over(&mut raster.values().iter().map(|&value| f64::from(value))),
            Self::Fitted(raster, fit) => over(&mut raster.values().iter().map(|&value| fit.of(f64::from(value)))),
            Self::District(fields) => over(&mut fields.values().flat_map(|field| [field.range().0, field.range().1])),
            Self::Raised(field, rises) => {
                let (low, high) = field.range();
                (low, high + rises.iter().map(|rise| rise.height).sum::<f64>())
            }
        }
    }

    /// Change per metre towards east and north; none where districts or nothing but a number tell it.
    pub fn gradient(&self, place: Vec2) -> Vec2 {
        match self {
            Self::Constant(_) => Vec2::ZERO,
            Self::Map(raster) => raster.gradient(place),
            Self::Fitted(raster, fit) => raster.gradient(place) * fit.scale,
            Self::District(fields) => fields.at(place).gradient(place),
            Self::Raised(field, rises) => {
                rises.iter().fold(field.gradient(place), |gradient, rise| gradient + rise.of(place).1)
            }
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
    /// The mask of dry land, where there is one: what lies off it is water, which bridges lead over.
    pub land: Option<Arc<Raster>>,
    /// Masks where no street may lie: parks.
    pub barred: Vec<Arc<Raster>>,
    /// People per km².
    pub density: Field,
    /// Metres above sea level.
    pub elevation: Field,
    /// Any map a script asks for, by name.
    pub maps: BTreeMap<String, Field>,
    /// Named areas of the site.
    pub districts: Arc<Districts>,
    /// Where the density peaks; found when it is first asked for.
    pub peaks: Peaks,
    /// How far it is to what these maps mark.
    pub distances: Distances,
    /// The ground of landmarks, and what else streets keep to.
    pub zones: Zones,
}

impl Fields {
    /// Flat, dry, evenly settled land.
    pub fn plain(bounds: Bounds) -> Self {
        Self {
            bounds,
            legal: Vec::new(),
            land: None,
            barred: Vec::new(),
            density: Field::Constant(1.0),
            elevation: Field::Constant(0.0),
            maps: BTreeMap::new(),
            districts: Arc::default(),
            distances: Distances::default(),
            peaks: Peaks::default(),
            zones: Zones::default(),
        }
    }

    /// The middle of the site, in metres.
    pub fn middle(&self) -> Vec2 {
        (self.bounds.min.metres() + self.bounds.max.metres()) / 2.0
    }

    /// Whether a place in metres lies in the site.
    pub fn is_in_site(&self, place: Vec2) -> bool {
        let (low, high) = (self.bounds.min.metres(), self.bounds.max.metres());
        place.cmpge(low).all() && place.cmple(high).all()
    }

    /// Whether there is water at a place in metres. Where no map tells land from water, what no street may lie on is
    /// water, but for what is barred.
    pub fn is_water(&self, place: Vec2) -> bool {
        let is_off_land = match &self.land {
            Some(land) => !land.mask(place),
            None => !self.legal.iter().all(|mask| mask.mask(place)),
        };
        is_off_land && self.is_in_site(place)
    }

    /// Whether a street may lie at a place in metres.
    pub fn is_legal(&self, place: Vec2) -> bool {
        self.is_in_site(place)
            && self.legal.iter().all(|mask| mask.mask(place))
            && !self.barred.iter().any(|mask| mask.mask(place))
            && self.zones.allow(place)
    }

    /// Density along a ray, each of `samples` samples weighted with the inverse of its distance: what a highway's end
    /// sums up to find the next centre of population (PM01 §3.2.1). It runs from `near` to `radius` metres.
    pub fn density_ahead(&self, place: Vec2, direction: Vec2, (near, radius): (f64, f64), samples: u32) -> f64 {
        let sample = |i: u32| {
            let distance = near + (radius - near) * f64::from(i) / f64::from(samples);
            self.density.at(place + direction * distance) / distance
        };
        (1..=samples).map(sample).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn fits_follow_each_other(
            steps in prop::collection::vec((-3.0..3.0f64, -50.0..50.0f64, any::<bool>()), 0..6), value in -100.0..100.0f64,
        ) {
            let (mut fit, mut wanted) = (Fit::NONE, value);
            for (a, b, holds) in steps {
                let (low, high) = (a.min(b), a.max(b));
                fit = if holds { fit.held(low, high) } else { fit.scaled(a, b) };
                wanted = if holds { wanted.clamp(low, high) } else { wanted * a + b };
            }
            prop_assert!((fit.of(value) - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{fit:?}");
        }

        #[test]
        fn no_value_lies_outside_the_range(
            values in prop::collection::vec(-9.0f32..9.0, 12), x in -5.0..50.0f64, y in -5.0..50.0f64, scale in -2.0..2.0f64,
        ) {
            let raster = Arc::new(Raster::new(4, 3, 10.0, Vec2::ZERO, values).unwrap());
            let fitted = Field::Fitted(raster.clone(), Fit::NONE.scaled(scale, 1.0).held(-5.0, 7.0));
            let rise = Rise { at: Vec2::new(15.0, 15.0), height: 4.0, reach: 20.0 };
            let raised = Field::Raised(Box::new(Field::Map(raster.clone())), [rise, rise].into());
            for field in [Field::Map(raster), fitted, raised] {
                let ((low, high), value) = (field.range(), field.at(Vec2::new(x, y)));
                prop_assert!(low - 1e-9 <= value && value <= high + 1e-9);
            }
        }
    }

    #[test]
    fn a_rise_is_a_smooth_hill() {
        let rise = Rise { at: Vec2::new(100.0, 50.0), height: 8.0, reach: 40.0 };
        let field = Field::Raised(Box::new(Field::Constant(1.0)), [rise].into());
        assert_eq!((field.at(rise.at), field.at(Vec2::new(140.0, 50.0)), field.at(Vec2::ZERO)), (9.0, 1.0, 1.0));
        let (place, step) = (Vec2::new(112.0, 37.0), 1e-4);
        let along = |axis: Vec2| (field.at(place + axis * step) - field.at(place - axis * step)) / (2.0 * step);
        let gradient = field.gradient(place);
        assert!((gradient - Vec2::new(along(Vec2::X), along(Vec2::Y))).length() < 1e-6, "{gradient}");
    }
}
