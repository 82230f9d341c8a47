//! The rim around the outermost streets that close quarters, where streets outside all quarters may grow (SCH10 §4.2.5).
//!
//! There a bulged convex hull closes the quarters at the city's boundary. A hull knows no bays and makes long thin
//! cities fat; so here the boundary keeps a distance from those streets, and the bulges are differences of that distance.

use super::Fields;
use crate::StreetGraph;
use geom::{Raster, Seed, Vec2};

/// Cells of the mask across the rim's width.
const CELLS: f64 = 48.0;
/// Finest and coarsest cell of the mask, metres.
const CELL: (f64, f64) = (2.0, 20.0);
/// Most cells of the mask along a side of the site.
const MOST_CELLS: f64 = 6000.0;
/// Distance between two bulges, as a multiple of the rim's width.
const BULGE_SPACING: f64 = 1.5;

/// Marks what lies within `width` metres of a street that closes quarters, on the ground; less in places, by up to the
/// share `bulge` of the width. `None` where there is no such street.
pub fn rim_mask(graph: &StreetGraph, fields: &Fields, width: f64, bulge: f64, seed: Seed) -> Option<Raster> {
    let (origin, size) = (fields.bounds.min.metres(), fields.bounds.size());
    let cell = (width / CELLS).clamp(CELL.0, CELL.1).max(size.max_element() / MOST_CELLS);
    let [columns, rows] = [size.x, size.y].map(|length| ((length / cell).ceil() as usize).max(1));
    let mut marked = vec![0.0; columns * rows];
    for place in places(graph, cell / 2.0) {
        let at = (place - origin) / cell;
        let (column, row) = (at.x.floor(), rows as f64 - 1.0 - at.y.floor());
        if column >= 0.0 && row >= 0.0 && (column as usize) < columns && (row as usize) < rows {
            marked[row as usize * columns + column as usize] = 1.0;
        }
    }
    let distances = Raster::new(columns, rows, cell, origin, marked).ok()?.distances()?;
    let place = |i: usize| Vec2::new((i % columns) as f64 + 0.5, (rows - i / columns) as f64 - 0.5) * cell;
    // Streets and places may be off the middles of their cells: two cells make sure.
    let most = (width - 2.0 * cell).max(cell);
    let reach = |i: usize| most * (1.0 - bulge * noise(place(i) / (width * BULGE_SPACING).max(cell), seed));
    let values = distances.values().iter().enumerate();
    let values = values.map(|(i, &distance)| f32::from(f64::from(distance) <= reach(i))).collect();
    Raster::new(columns, rows, cell, origin, values).ok()
}

/// Places along all streets on the ground that close quarters, at most `step` metres apart.
fn places(graph: &StreetGraph, step: f64) -> impl Iterator<Item = Vec2> {
    let closes = |class| graph.classes().info(class).closes_quarters;
    let lines = graph.segments_unsorted().filter(move |(_, segment)| segment.level == 0 && closes(segment.class()));
    lines.flat_map(move |(key, _)| {
        let (from, to) = graph.line(key.forward());
        let parts = (from.distance(to) / step).ceil().max(1.0) as u32;
        (0..=parts).map(move |i| from.metres().lerp(to.metres(), f64::from(i) / f64::from(parts)))
    })
}

/// A smooth field of numbers from 0 to 1, by chance on whole places and eased between them.
fn noise(at: Vec2, seed: Seed) -> f64 {
    let low = at.floor();
    let ease = |share: f64| share * share * (3.0 - 2.0 * share);
    let (x, y) = (ease(at.x - low.x), ease(at.y - low.y));
    let corner = |dx: i64, dy: i64| seed.child((low.x as i64 + dx) as u64).unit((low.y as i64 + dy) as u64);
    let row = |dy: i64| corner(0, dy) + (corner(1, dy) - corner(0, dy)) * x;
    row(0) + (row(1) - row(0)) * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Crowding, NewSegment};
    use crate::{Claim, Class, Classes, NodeId, StreetId};
    use geom::{Bounds, Id, Point};

    /// 2 km² with one street of a class from west to east.
    fn street(class: Class) -> (StreetGraph, Fields) {
        let mut graph = StreetGraph::new(Classes::default());
        let claim = Claim { street: StreetId(Id(1)), class, half_width: 1024, origin: 0, forward: true };
        let at = |x: f64| Point::from_metres(Vec2::new(x, 500.0));
        let ids = (NodeId(Id(2)), NodeId(Id(3)));
        let new = NewSegment { from: at(700.0), to: at(1300.0), from_id: ids.0, to_id: ids.1, claim, level: 0 };
        graph.insert(&new, Crowding::Refuse).unwrap();
        let size = Point::from_metres(Vec2::new(2000.0, 1000.0));
        (graph, Fields::plain(Bounds::between(Point::new(0, 0), size)))
    }

    #[test]
    fn a_rim_keeps_its_distance() {
        let (graph, fields) = street(Classes::MAJOR);
        let mask = rim_mask(&graph, &fields, 150.0, 0.0, Seed(1)).unwrap();
        for (x, y, inside) in [
            (1000.0, 360.0, true),
            (1000.0, 340.0, false),
            (1440.0, 500.0, true),
            (560.0, 500.0, true),
            (540.0, 500.0, false),
            (1420.0, 620.0, false),
            (1000.0, 640.0, true),
        ] {
            assert_eq!(mask.mask(Vec2::new(x, y)), inside, "{x} {y}");
        }
    }

    #[test]
    fn bulges_take_from_the_rim_by_chance() {
        let (graph, fields) = street(Classes::MAJOR);
        let area = |bulge: f64, seed: u64| {
            let mask = rim_mask(&graph, &fields, 150.0, bulge, Seed(seed)).unwrap();
            assert!(mask.mask(Vec2::new(1000.0, 500.0 - 135.0 * (1.0 - bulge))), "no less than the share");
            mask.values().iter().map(|&value| f64::from(value)).sum::<f64>()
        };
        let (plain, bulged, other) = (area(0.0, 1), area(0.6, 1), area(0.6, 2));
        assert!(bulged < 0.9 * plain && bulged > 0.4 * plain && bulged != other, "{plain} {bulged} {other}");
        assert_eq!(bulged, area(0.6, 1));
    }

    #[test]
    fn without_streets_that_close_quarters_there_is_no_rim() {
        let (graph, fields) = street(Classes::MINOR);
        assert_eq!(rim_mask(&graph, &fields, 150.0, 0.0, Seed(1)), None);
    }
}
