//! The part of a city that is in sight: made first when something changes.

use city::export::glb::TileKey;
use geom::{Bounds, Vec2};

/// Tiles from one to another, both within.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sight {
    low: TileKey,
    high: TileKey,
}

/// Share of a city from which it is not worth while to make what is in sight first.
const MOST: f64 = 0.4;

impl Sight {
    /// The tiles around some ground; none where that is most of a city anyway.
    pub fn of(low: Vec2, high: Vec2, city: Bounds) -> Option<Self> {
        let (from, to) = (low.max(city.min.metres()), high.min(city.max.metres()));
        let (seen, all) = ((to - from).max(Vec2::ZERO), city.size());
        let sight = Self { low: TileKey::of(from), high: TileKey::of(to) };
        (seen.x * seen.y < MOST * all.x * all.y && seen.min_element() > 0.0).then_some(sight)
    }

    /// Whether a tile is in sight.
    pub fn contains(&self, tile: TileKey) -> bool {
        (self.low.column..=self.high.column).contains(&tile.column)
            && (self.low.row..=self.high.row).contains(&tile.row)
    }

    /// Their ground.
    pub fn bounds(&self) -> Bounds {
        let beyond = TileKey { column: self.high.column + 1, row: self.high.row + 1 };
        Bounds::between(geom::Point::from_metres(self.low.origin()), geom::Point::from_metres(beyond.origin()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::Point;

    #[test]
    fn what_is_near_is_in_sight_and_a_whole_city_is_no_part() {
        let city = Bounds { min: Point::from_metres(Vec2::ZERO), max: Point::from_metres(Vec2::splat(10_000.0)) };
        let sight = Sight::of(Vec2::new(2500.0, 3500.0), Vec2::new(3200.0, 3900.0), city).unwrap();
        assert!(sight.contains(TileKey::of(Vec2::new(2100.0, 3100.0))));
        assert!(!sight.contains(TileKey::of(Vec2::new(4100.0, 3100.0))));
        assert!(sight.bounds().contains(Point::from_metres(Vec2::new(3999.0, 3001.0))));
        assert_eq!(Sight::of(Vec2::splat(-500.0), Vec2::splat(9000.0), city), None);
        assert_eq!(Sight::of(Vec2::splat(-500.0), Vec2::splat(-100.0), city), None);
    }
}
