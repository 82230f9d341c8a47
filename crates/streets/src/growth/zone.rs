//! Areas that growth keeps to whatever its chain says: the ground of landmarks, which stays free, and areas that a
//! stage is held inside.

use geom::{Bounds, Point, Polygon, Raster, Vec2};
use std::sync::Arc;

/// A polygon with its box.
#[derive(Clone, Debug, PartialEq)]
struct Zone {
    bounds: Bounds,
    polygon: Polygon,
}

impl Zone {
    fn of(polygon: &Polygon) -> Option<Self> {
        Some(Self { bounds: polygon.bounds()?, polygon: polygon.clone() })
    }

    fn has(&self, at: Point) -> bool {
        self.bounds.contains(at) && self.polygon.contains(at)
    }
}

/// Where streets of a stage may be, besides what masks say.
#[derive(Clone, Debug, Default)]
pub struct Zones {
    kept: Vec<Zone>,
    /// All of a stage's streets lie in each of these; one without area holds nothing.
    inside: Vec<Option<Zone>>,
    masks: Vec<Arc<Raster>>,
}

impl Zones {
    /// No street shall lie on this ground.
    pub fn keep_free(&mut self, ground: &Polygon) {
        self.kept.extend(Zone::of(ground));
    }

    /// All streets shall lie on this ground.
    pub fn hold_inside(&mut self, ground: &Polygon) {
        self.inside.push(Zone::of(ground));
    }

    /// All streets shall lie where this map says more than one half.
    pub fn hold_inside_mask(&mut self, mask: Arc<Raster>) {
        self.masks.push(mask);
    }

    /// Whether nothing is restricted.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty() && self.inside.is_empty() && self.masks.is_empty()
    }

    /// Whether a place in metres is to stay free of streets.
    pub fn is_kept_free(&self, place: Vec2) -> bool {
        !self.kept.is_empty()
            && Point::try_from_metres(place).is_some_and(|at| self.kept.iter().any(|zone| zone.has(at)))
    }

    /// Whether a street may lie at a place in metres.
    pub fn allow(&self, place: Vec2) -> bool {
        if self.is_empty() {
            return true;
        }
        let Some(at) = Point::try_from_metres(place) else { return false };
        let is_inside = |zone: &Option<Zone>| zone.as_ref().is_some_and(|zone| zone.has(at));
        !self.kept.iter().any(|zone| zone.has(at))
            && self.inside.iter().all(is_inside)
            && self.masks.iter().all(|mask| mask.mask(place))
    }

    /// How finely lines are held against them, in metres, where the corners of a polygon may lie anywhere.
    pub(super) fn cell(&self, finest: f64) -> f64 {
        let has_polygons = !(self.kept.is_empty() && self.inside.is_empty());
        let masks = self.masks.iter().map(|mask| mask.pixel_size());
        masks.chain(has_polygons.then_some(finest)).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Polygon {
        let [low, high] = [low, high].map(|at| Point::from_metres(Vec2::splat(at)));
        Polygon::rectangle(Bounds::between(low, high))
    }

    #[test]
    fn streets_lie_inside_and_off_what_is_kept() {
        let mut zones = Zones::default();
        assert!(zones.is_empty() && zones.allow(Vec2::splat(1e9)));
        zones.hold_inside(&square(0.0, 100.0));
        zones.keep_free(&square(40.0, 60.0));
        for (at, allowed, kept) in [(20.0, true, false), (50.0, false, true), (120.0, false, false)] {
            assert_eq!((zones.allow(Vec2::splat(at)), zones.is_kept_free(Vec2::splat(at))), (allowed, kept), "{at}");
        }
        zones.hold_inside(&Polygon::new(Vec::new(), Vec::new()));
        assert!(!zones.allow(Vec2::splat(20.0)), "an area without ground holds nothing");
    }

    #[test]
    fn masks_hold_too_and_say_how_finely() {
        let mut zones = Zones::default();
        let mask = Raster::new(2, 1, 50.0, Vec2::ZERO, vec![1.0, 0.0]).unwrap();
        zones.hold_inside_mask(Arc::new(mask));
        assert!(zones.allow(Vec2::new(20.0, 20.0)) && !zones.allow(Vec2::new(80.0, 20.0)));
        assert_eq!(zones.cell(1.0), 50.0);
        zones.keep_free(&square(0.0, 10.0));
        assert_eq!(zones.cell(1.0), 1.0);
    }
}
