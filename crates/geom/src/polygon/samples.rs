//! Random polygons for tests.

use super::{Polygon, ring_is_simple};
use crate::{Angle, Point, Vec2};
use proptest::collection::vec;
use proptest::prelude::*;

/// A simple ring around a centre within ±60 m, 3 to 14 corners, reaching 2 to 80 m; counter-clockwise.
pub fn star_ring() -> impl Strategy<Value = Vec<Point>> {
    let centre = (-60_000..=60_000, -60_000..=60_000);
    let corners = vec((0.05f64..1.0, 2.0f64..80.0), 3..14);
    let ring = (centre, corners).prop_map(|((x, y), corners)| {
        let whole: f64 = corners.iter().map(|(turn, _)| turn).sum();
        let mut turned = 0.0;
        let corner = |(turn, radius): (f64, f64)| {
            turned += turn / whole;
            let at = Angle::degrees(360.0 * turned).unit() * radius;
            Point::from_metres(at + Vec2::new(f64::from(x), f64::from(y)) / Point::UNITS_PER_METRE)
        };
        corners.into_iter().map(corner).collect::<Vec<_>>()
    });
    ring.prop_filter("a gap of half a turn may make edges cross", |ring| {
        ring_is_simple(ring) && super::ring_doubled_area(ring) > 0
    })
}

/// A polygon of one ring (see [`star_ring`]).
pub fn star() -> impl Strategy<Value = Polygon> {
    star_ring().prop_map(|ring| Polygon::new(ring, Vec::new()))
}

/// A large square with up to nine star-shaped holes, which do not touch; valid.
pub fn holed() -> impl Strategy<Value = Polygon> {
    let cells = vec(proptest::option::of(star_ring()), 9);
    cells.prop_map(|cells| {
        let side = 3 * 320_000;
        let outer = vec![Point::new(0, 0), Point::new(side, 0), Point::new(side, side), Point::new(0, side)];
        let place = |(i, ring): (usize, Option<Vec<Point>>)| {
            let shift = (160_000 + 320_000 * (i as i32 % 3), 160_000 + 320_000 * (i as i32 / 3));
            ring.map(|ring| shifted_ring(&ring, shift))
        };
        Polygon::new(outer, cells.into_iter().enumerate().filter_map(place).collect())
    })
}

/// Any ring on a tiny grid: crossings, repeated points, spikes and overlaps are frequent.
pub fn scribble() -> impl Strategy<Value = Vec<Point>> {
    vec((0..6, 0..6).prop_map(|(x, y)| Point::new(x, y)), 3..9)
}

/// A ring that mostly crosses itself, so small that every cut is rounded by a noticeable share.
pub fn tangle() -> impl Strategy<Value = Vec<Point>> {
    vec((0..60, 0..60).prop_map(|(x, y)| Point::new(x, y)), 3..12)
}

/// Rectangles on a grid of 8 × 8 cells, each `unit` LSB wide.
pub fn grid_rectangles(unit: i32) -> impl Strategy<Value = Vec<Polygon>> {
    let rectangle = (0..7, 0..7, 1..4, 1..4).prop_map(move |(x, y, w, h): (i32, i32, i32, i32)| {
        let (from, to) = (Point::new(x * unit, y * unit), Point::new((x + w).min(8) * unit, (y + h).min(8) * unit));
        Polygon::rectangle(crate::Bounds::between(from, to))
    });
    vec(rectangle, 1..10)
}

/// A shift that keeps samples within the lattice.
pub fn shift() -> impl Strategy<Value = (i32, i32)> {
    (-500_000_000..=500_000_000, -500_000_000..=500_000_000)
}

/// The ring moved.
pub fn shifted_ring(ring: &[Point], (dx, dy): (i32, i32)) -> Vec<Point> {
    ring.iter().map(|p| Point::new(p.x + dx, p.y + dy)).collect()
}

/// The polygon moved.
pub fn shifted(polygon: &Polygon, by: (i32, i32)) -> Polygon {
    Polygon {
        outer: shifted_ring(&polygon.outer, by),
        holes: polygon.holes.iter().map(|hole| shifted_ring(hole, by)).collect(),
    }
}
