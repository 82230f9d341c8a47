//! The plainest building: a parcel's outline, set back, raised to a height (PM01 §3.5 starts from the same box).

use crate::{Building, StartShape};
use geom::polygon::{ring_edges, without_collinear};
use geom::strip::{Reach, strip, wedge};
use geom::{Id, Point, Polygon, boolean, point::units};

/// Least height of a building in metres.
pub const LEAST_HEIGHT: f64 = 2.5;

/// Least area of a footprint in m².
pub const LEAST_FOOTPRINT: f64 = 20.0;

/// Least width of a footprint in metres, measured as that of the strip with its area and perimeter.
const LEAST_WIDTH: f64 = 2.0;

/// The building that fills a parcel but for `setback` metres along its border, `height` metres high (at least
/// [`LEAST_HEIGHT`]). Where the setback leaves no useful footprint, half of it is tried, then none; a parcel that is
/// useless even so, or a height that is not finite, gives no building. Of a footprint in several parts the largest is
/// built. The footprint lies in the outline exactly (V22).
pub fn extrude(shape: &StartShape, height: f64, setback: f64) -> Option<Building> {
    let setback = if setback.is_finite() { setback.max(0.0) } else { 0.0 };
    let footprint = [setback, setback / 2.0, 0.0].into_iter().find_map(|setback| footprint(&shape.outline, setback))?;
    height.is_finite().then(|| Building {
        id: shape.parcel.with(&[Id::root("building", &[]).0]),
        parcel: shape.parcel,
        footprint,
        height: height.max(LEAST_HEIGHT),
        ground: shape.ground,
        origin: 0,
    })
}

/// The largest useful part of an outline that is at least `setback` metres from its border.
fn footprint(outline: &Polygon, setback: f64) -> Option<Polygon> {
    let parts = match units(setback) {
        0 => vec![simplified(outline)],
        setback => inset(outline, setback),
    };
    let useful = parts.into_iter().filter(is_useful);
    useful.max_by_key(Polygon::doubled_area)
}

/// Large and wide enough to be built, and in one piece with itself.
fn is_useful(footprint: &Polygon) -> bool {
    let (area, perimeter) = (footprint.area(), footprint.perimeter());
    area >= LEAST_FOOTPRINT && 2.0 * area >= LEAST_WIDTH * perimeter && footprint.is_simple()
}

/// The outline without the corners that only its neighbours need.
fn simplified(outline: &Polygon) -> Polygon {
    let holes = outline.holes.iter().map(|hole| without_collinear(hole)).filter(|hole| !hole.is_empty());
    Polygon { outer: without_collinear(&outline.outer), holes: holes.collect() }
}

/// What lies farther than `setback` LSB from the border: the outline minus a strip along each edge, mitred at the
/// corners that turn away from it.
fn inset(outline: &Polygon, setback: i32) -> Vec<Polygon> {
    let outline = simplified(outline);
    let strips: Vec<Polygon> = outline.rings().flat_map(|ring| strips(ring, setback)).collect();
    boolean::difference(std::slice::from_ref(&outline), &strips)
}

fn strips(ring: &[Point], setback: i32) -> Vec<Polygon> {
    let reach = Reach { left: setback, ..Reach::default() };
    let edges: Vec<(Point, Point)> = ring_edges(ring).collect();
    let mut strips = Vec::with_capacity(2 * edges.len());
    for (i, &(from, to)) in edges.iter().enumerate() {
        let after = edges[(i + 1) % edges.len()].1;
        let turns_away = geom::predicates::orient(from, to, after) < 0;
        let corner = turns_away.then(|| wedge(from, to, after, setback, setback)).flatten();
        strips.extend(strip(from, to, reach).map(|ring| Polygon::new(ring.into(), Vec::new())));
        strips.extend(corner.map(|ring| Polygon::new(ring, Vec::new())));
    }
    strips
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shape(outline: Polygon) -> StartShape {
        StartShape { parcel: Id::root("parcel", &[7]), outline, density: 1000.0, ground: (3.0, 4.5) }
    }

    fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(units(x), units(y))).collect()
    }

    fn rectangle(width: f64, height: f64) -> Polygon {
        Polygon::new(ring(&[(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]), vec![])
    }

    #[test]
    fn a_rectangle_is_set_back_on_all_sides() {
        let building = extrude(&shape(rectangle(20.0, 30.0)), 9.0, 3.0).unwrap();
        // Strips are drawn out by two units, inwards too.
        let (low, east, north) = (3 * 1024 + 2, 17 * 1024 - 2, 27 * 1024 - 2);
        let corners = [(low, low), (east, low), (east, north), (low, north)].map(|(x, y)| Point::new(x, y));
        assert_eq!(building.footprint.outer, corners);
        assert_eq!((building.height, building.ground, building.origin), (9.0, (3.0, 4.5), 0));
        assert_eq!(building.id, extrude(&shape(rectangle(50.0, 50.0)), 20.0, 0.0).unwrap().id);
    }

    #[test]
    fn a_setback_that_leaves_nothing_is_halved_and_then_dropped() {
        let halved = extrude(&shape(rectangle(12.0, 12.0)), 9.0, 5.0).unwrap();
        assert!((halved.footprint.area() - 49.0).abs() < 0.1);
        let dropped = extrude(&shape(rectangle(6.0, 6.0)), 9.0, 5.0).unwrap();
        assert_eq!(dropped.footprint, rectangle(6.0, 6.0));
        assert_eq!(extrude(&shape(rectangle(4.0, 4.0)), 9.0, 0.0), None);
        assert_eq!(extrude(&shape(rectangle(100.0, 1.0)), 9.0, 0.0), None);
    }

    #[test]
    fn odd_numbers_do_no_harm() {
        let ground = shape(rectangle(20.0, 20.0));
        assert_eq!(extrude(&ground, f64::NAN, 1.0), None);
        assert_eq!(extrude(&ground, -5.0, -1.0).unwrap().height, LEAST_HEIGHT);
        assert_eq!(extrude(&ground, 5.0, f64::INFINITY).unwrap().footprint.area(), 400.0);
        assert_eq!(extrude(&shape(Polygon::default()), 5.0, 1.0), None);
    }

    fn outlines() -> impl Strategy<Value = Polygon> {
        prop::collection::vec(3.0..40.0f64, 3..10).prop_map(|radii| {
            let n = radii.len() as f64;
            let corner = |(i, r): (usize, f64)| {
                let unit = geom::Angle::radians(std::f64::consts::TAU * i as f64 / n + 0.1).unit();
                (r * unit.x, r * unit.y)
            };
            Polygon::new(ring(&radii.into_iter().enumerate().map(corner).collect::<Vec<_>>()), vec![])
        })
    }

    proptest! {
        #[test]
        fn footprints_lie_in_their_parcel(outline in outlines(), setback in 0.0..8.0f64) {
            let Some(building) = extrude(&shape(outline.clone()), 10.0, setback) else { return Ok(()) };
            let parcel = std::slice::from_ref(&outline);
            let outside = boolean::difference(std::slice::from_ref(&building.footprint), parcel);
            prop_assert!(outside.is_empty(), "{outside:?}");
            prop_assert!(building.footprint.is_simple() && building.footprint.area() >= LEAST_FOOTPRINT);
        }

        #[test]
        fn a_footprint_keeps_its_setback(outline in outlines(), setback in 0.5..4.0f64) {
            let inner = inset(&outline, units(setback));
            for p in inner.iter().flat_map(|part| &part.outer) {
                prop_assert!(outline.distance_to_rim(p.metres()) >= setback - 0.001);
            }
        }
    }
}
