//! What a tip senses of the ground and the people around it.

use super::{Peak, Tip};
use geom::{Angle, Vec2};

/// Directions that a shore is looked for in.
const SHORE_RAYS: u32 = 32;
/// Metres between two looks at the ground.
const SHORE_STEP: f64 = 10.0;
/// Ground less steep than this, rise over run, has no direction of its own: half a metre in a kilometre.
const FLAT: f64 = 5e-4;

impl Tip {
    /// The heading, within `spread` to either side of the tip's own, along which a ray from `near` to `radius` metres
    /// sums up most density (PM01 §3.2.1); of equal ones the straightest, then the left one. Tries `rays` headings to
    /// either side, with 16 samples each. What lies nearer than `near` is not seen: else the end of a highway that leaves
    /// a centre would turn back to it, since samples count by the inverse of their distance.
    pub fn seek_density(&self, (near, radius): (f64, f64), spread: Angle, rays: u32) -> Angle {
        let turn = |k: i64| spread * (k as f64 / f64::from(rays.max(1)));
        let sides = (1..=i64::from(rays)).flat_map(|k| [k, -k]);
        let mut best = (self.heading, f64::NEG_INFINITY);
        for heading in std::iter::once(0).chain(sides).map(|k| self.heading + turn(k)) {
            let sum = self.fields.density_ahead(self.place(), heading.unit(), (near, radius), 16);
            if sum > best.1 {
                best = (heading, sum);
            }
        }
        best.0
    }

    /// Steepness of the ground, rise over run.
    pub fn slope(&self) -> f64 {
        self.fields.elevation.gradient(self.place()).length()
    }

    /// The heading straight up the slope; the tip's own on flat ground.
    pub fn uphill(&self) -> Angle {
        self.uphill_at(self.place()).unwrap_or(self.heading)
    }

    /// The heading nearest to the tip's own that stays on its height for the next `length` metres (PM01 §3.2.2, the San
    /// Francisco rule); the tip's own on flat ground. With a length it is the contour's heading half-way there, so that
    /// a street of straight pieces does not drift off the slope.
    pub fn level(&self, length: f64) -> Angle {
        let at = |place: Vec2, near: Angle| {
            let uphill = self.uphill_at(place)?;
            Some((uphill + Angle::RIGHT).nearest_of_cross(2, near))
        };
        let Some(here) = at(self.place(), self.heading) else { return self.heading };
        let middle = self.place() + here.unit() * (length / 2.0);
        at(middle, here).unwrap_or(here)
    }

    fn uphill_at(&self, place: Vec2) -> Option<Angle> {
        let gradient = self.fields.elevation.gradient(place);
        (gradient.length() >= FLAT).then(|| Angle::of(gradient))
    }

    /// The heading to a place in metres; the tip's own at that very place.
    pub fn towards(&self, place: Vec2) -> Angle {
        let way = place - self.place();
        if way == Vec2::ZERO { self.heading } else { Angle::of(way) }
    }

    /// Metres to a place.
    pub fn distance_to(&self, place: Vec2) -> f64 {
        (place - self.place()).length()
    }

    /// The centre of population of some rank, 0 for the densest. Where there is none of that rank: the last one; and in
    /// evenly settled land the middle of the site.
    pub fn peak(&self, rank: usize) -> Peak {
        let peaks = self.fields.peaks.of(&self.fields.density);
        let found = peaks.get(rank).or(peaks.last()).copied();
        found.unwrap_or_else(|| {
            let at = self.fields.middle();
            Peak { at, density: self.fields.density.at(at) }
        })
    }

    /// The centre of population nearest to the tip; the middle of the site in evenly settled land.
    pub fn nearest_peak(&self) -> Peak {
        let peaks = self.fields.peaks.of(&self.fields.density);
        let nearest = peaks.iter().min_by(|a, b| self.distance_to(a.at).total_cmp(&self.distance_to(b.at)));
        nearest.copied().unwrap_or_else(|| self.peak(0))
    }

    /// Metres to the nearest place where no street may lie (water, parks, the site's rim), to 10 m; `most` where there is
    /// none that near.
    pub fn shore(&self, most: f64) -> f64 {
        let looks = (most.max(0.0) / SHORE_STEP).floor() as u32;
        let ray = |k: u32| Angle::degrees(360.0 * f64::from(k) / f64::from(SHORE_RAYS)).unit();
        let rays: Vec<Vec2> = (0..SHORE_RAYS).map(ray).collect();
        let is_shore = |look: u32| {
            let reach = f64::from(look) * SHORE_STEP;
            rays.iter().any(|&ray| !self.fields.is_legal(self.place() + ray * reach))
        };
        (1..=looks).find(|&look| is_shore(look)).map_or(most, |look| f64::from(look) * SHORE_STEP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Classes;
    use crate::growth::{Field, Fields};
    use geom::{Bounds, Point, Raster, Seed};
    use std::sync::Arc;

    /// A square kilometre whose ground is told by a function.
    fn tip(height: impl Fn(Vec2) -> f64, at: Vec2, heading: f64) -> Tip {
        let value = |i: usize| height(Vec2::new((i % 100) as f64 + 0.5, 99.5 - (i / 100) as f64) * 10.0) as f32;
        let raster = Raster::new(100, 100, 10.0, Vec2::ZERO, (0..10_000).map(value).collect()).unwrap();
        let bounds = Bounds::between(Point::new(0, 0), Point::from_metres(Vec2::splat(1000.0)));
        let fields = Fields { elevation: Field::Map(Arc::new(raster)), ..Fields::plain(bounds) };
        let mut tip = Tip::new(Classes::MINOR, Seed(1), Arc::new(fields));
        (tip.at, tip.heading) = (Point::from_metres(at), Angle::degrees(heading));
        tip
    }

    fn degrees(angle: Angle) -> f64 {
        angle.wrapped().to_degrees().round()
    }

    #[test]
    fn slopes_are_sensed() {
        let at = Vec2::new(500.0, 400.0);
        let slope = tip(|p| 0.1 * p.y, at, 20.0);
        assert!((slope.slope() - 0.1).abs() < 1e-6);
        assert_eq!((degrees(slope.uphill()), degrees(slope.level(0.0))), (90.0, 0.0));
        assert_eq!(degrees(tip(|p| 0.1 * p.y, at, 160.0).level(50.0)), 180.0);
        let flat = tip(|_| 3.0, at, 20.0);
        assert_eq!((flat.slope(), degrees(flat.uphill()), degrees(flat.level(80.0))), (0.0, 20.0, 20.0));
    }

    #[test]
    fn contours_are_kept_round_a_hill() {
        let top = Vec2::splat(500.0);
        let mut tip = tip(|p| 200.0 - 0.2 * (p - top).length(), Vec2::new(800.0, 500.0), 90.0);
        for _ in 0..30 {
            tip.heading = tip.level(60.0);
            tip.at = Point::from_metres(tip.place() + tip.heading.unit() * 60.0);
            let radius = (tip.place() - top).length();
            assert!((radius - 300.0).abs() < 12.0, "{radius}");
        }
    }

    #[test]
    fn places_and_shores_are_found() {
        let tip = tip(|_| 0.0, Vec2::new(100.0, 500.0), 0.0);
        assert_eq!(degrees(tip.towards(Vec2::new(100.0, 900.0))), 90.0);
        assert_eq!(degrees(tip.towards(tip.place())), 0.0);
        assert_eq!(tip.distance_to(Vec2::new(400.0, 900.0)), 500.0);
        assert_eq!((tip.shore(300.0), tip.shore(60.0)), (110.0, 60.0));
        assert_eq!(tip.peak(0).at, Vec2::splat(500.0));
        assert_eq!(tip.nearest_peak().at, Vec2::splat(500.0));
    }
}
