//! The place a city stands on: its maps in one local frame.

use crate::Cache;
use geom::{Bounds, Digest, Id, Raster, Vec2};
use script::Places;
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::Districts;
use streets::growth::Field;

/// A place with its maps. Local frame: x east, y north, metres, (0, 0) at the south-west corner.
#[derive(Clone, Debug)]
pub struct Site {
    /// The extent of all maps, from (0, 0).
    pub bounds: Bounds,
    /// Coordinate reference system, e.g. `EPSG:32618`, where known.
    pub crs: Option<String>,
    /// Where (0, 0) lies in `crs`, where known.
    pub origin: Option<Vec2>,
    /// Maps by name (`elevation`, `land`, `parks`, `density`, …), values in the units of their sidecars; masks are 0 or 1.
    pub maps: BTreeMap<String, Arc<Raster>>,
    /// Its named areas.
    pub districts: Arc<Districts>,
}

impl Site {
    /// The map of that name, if there is one.
    pub fn map(&self, name: &str) -> Option<&Arc<Raster>> {
        self.maps.get(name)
    }

    /// The digest of all of it, for caches.
    pub(crate) fn digest(&self, cache: &Cache) -> Id {
        let Self { bounds, crs, origin, maps, districts } = self;
        let mut digest = Digest::new("site");
        digest.value(&(bounds, crs, origin, districts));
        for (name, map) in maps {
            digest.text(name).id(cache.digest_of(map));
        }
        digest.finish()
    }

    /// What values by place are read from.
    pub fn places(&self) -> Places {
        let maps = self.maps.iter().map(|(name, map)| (name.clone(), Field::Map(map.clone()))).collect();
        Places { maps, districts: self.districts.clone() }
    }

    /// Metres above sea level; 0 where there is no elevation map.
    pub fn elevation(&self, place: Vec2) -> f64 {
        self.map("elevation").map_or(0.0, |map| map.bilinear(place))
    }
}
