//! Areas that streets are clipped to (SCH10 §4.2.3, "clip to mask").

use super::{Field, Fields};
use geom::{Point, Polygon, Vec2};
use std::sync::Arc;

/// An area that streets stay inside.
#[derive(Clone, Debug, PartialEq)]
pub enum Area {
    /// A polygon; its rim belongs to it.
    Polygon(Arc<Polygon>),
    /// Where a map of the site, by name, says more than one half. A map that is not there masks nothing.
    Map(Arc<str>),
}

/// The area as one growth knows it.
#[derive(Debug)]
pub(super) enum Cover<'a> {
    Polygon(&'a Polygon),
    Map(&'a Field),
    Everywhere,
}

impl<'a> Cover<'a> {
    pub fn of(area: &'a Area, fields: &'a Fields) -> Self {
        match area {
            Area::Polygon(polygon) => Self::Polygon(polygon),
            Area::Map(name) => fields.maps.get(&**name).map_or(Self::Everywhere, Self::Map),
        }
    }

    /// Whether a place in metres belongs to it.
    pub fn has(&self, place: Vec2) -> bool {
        match self {
            Self::Polygon(polygon) => Point::try_from_metres(place).is_some_and(|place| polygon.contains(place)),
            Self::Map(Field::Map(raster)) => raster.mask(place),
            Self::Map(field) => field.at(place) > 0.5,
            Self::Everywhere => true,
        }
    }
}
