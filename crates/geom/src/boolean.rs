//! Union, difference and intersection on the lattice.
//!
//! Done by i_overlay's integer engine. Its float front end must never be used: it takes its scale and offset from the
//! bounding box of the input, so that something far away would change the rounding here.
//!
//! Results are canonical: rings start at their lexicographically least corner, have no collinear corners, the outer one
//! runs counter-clockwise and holes clockwise; holes are sorted by their first corner, polygons by theirs. Polygons are
//! OGC-valid: where a shape touches itself in a point, it becomes a touching hole or falls into separate polygons. Only
//! points where edges cut are rounded (by about 1 LSB, in rare crowded places somewhat more); translating all input
//! translates the output exactly.

mod assemble;

use crate::polygon::ring_doubled_area;
use crate::{Point, Polygon};
use assemble::assemble;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::{Precision, Solver, Strategy};
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::i_shape::flat::buffer::FlatContoursBuffer;

/// One thread: callers are parallel by themselves.
const SOLVER: Solver = Solver { strategy: Strategy::Auto, precision: Precision::HIGH, multithreading: None };

/// What lies in any of the polygons.
pub fn union(polygons: &[Polygon]) -> Vec<Polygon> {
    overlay(polygons, &[], OverlayRule::Subject)
}

/// What lies in any of `polygons` and in none of `removed`.
pub fn difference(polygons: &[Polygon], removed: &[Polygon]) -> Vec<Polygon> {
    overlay(polygons, removed, OverlayRule::Difference)
}

/// What lies in any of `polygons` and in any of `others`.
pub fn intersection(polygons: &[Polygon], others: &[Polygon]) -> Vec<Polygon> {
    overlay(polygons, others, OverlayRule::Intersect)
}

/// What the rings enclose by the non-zero rule: rings may cross themselves and each other, and those of opposite
/// orientation cancel where they overlap.
pub fn union_of_rings(rings: &[Vec<Point>]) -> Vec<Polygon> {
    let mut engine = engine(rings.iter().map(Vec::len).sum());
    for ring in rings {
        add_ring(&mut engine, ring, false, ShapeType::Subject);
    }
    extract(engine, OverlayRule::Subject)
}

fn overlay(subject: &[Polygon], clip: &[Polygon], rule: OverlayRule) -> Vec<Polygon> {
    let corners = subject.iter().chain(clip).flat_map(Polygon::rings).map(<[Point]>::len).sum();
    let mut engine = engine(corners);
    for (polygons, role) in [(subject, ShapeType::Subject), (clip, ShapeType::Clip)] {
        polygons.iter().for_each(|polygon| add_polygon(&mut engine, polygon, role));
    }
    extract(engine, rule)
}

fn engine(corners: usize) -> Overlay<i32> {
    // Corners that stay collinear show where rings touch.
    Overlay::new_custom(corners, IntOverlayOptions::keep_output_points(), SOLVER)
}

/// Adds the rings so that inside counts 1 and holes 0, whichever way they are turned: the fields are public.
fn add_polygon(engine: &mut Overlay<i32>, polygon: &Polygon, role: ShapeType) {
    add_ring(engine, &polygon.outer, ring_doubled_area(&polygon.outer) < 0, role);
    for hole in &polygon.holes {
        add_ring(engine, hole, ring_doubled_area(hole) > 0, role);
    }
}

fn add_ring(engine: &mut Overlay<i32>, ring: &[Point], reversed: bool, role: ShapeType) {
    let points = ring.iter().map(|p| IntPoint::new(p.x, p.y));
    if reversed {
        engine.add_path_iter(points.rev(), role);
    } else {
        engine.add_path_iter(points, role);
    }
}

fn extract(mut engine: Overlay<i32>, rule: OverlayRule) -> Vec<Polygon> {
    let mut found = FlatContoursBuffer::default();
    engine.overlay_into(rule, FillRule::NonZero, &mut found);
    let points: Vec<Point> = found.points.iter().map(|p| Point::new(p.x, p.y)).collect();
    assemble(found.ranges.iter().map(|range| &points[range.clone()]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::Location;
    use crate::polygon::samples::{grid_rectangles, holed, shift, shifted, shifted_ring, star, star_ring, tangle};
    use crate::predicates::{orient, within};
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn ring(points: &[(i32, i32)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    fn square(x: i32, y: i32, side: i32) -> Polygon {
        Polygon::new(ring(&[(x, y), (x + side, y), (x + side, y + side), (x, y + side)]), Vec::new())
    }

    fn area(polygons: &[Polygon]) -> f64 {
        polygons.iter().map(Polygon::area).sum()
    }

    /// What rounding may change in an area: all edges moved by some units.
    fn slack(polygons: &[Polygon]) -> f64 {
        polygons.iter().map(Polygon::perimeter).sum::<f64>() * 4.0 / 1024.0
    }

    /// How many of the polygons hold a point; `None` on a rim.
    fn times_covered(polygons: &[Polygon], p: Point) -> Option<usize> {
        let places: Vec<_> = polygons.iter().map(|polygon| polygon.locate(p)).collect();
        let inside = places.iter().filter(|&&place| place == Location::Inside).count();
        (!places.contains(&Location::OnRim)).then_some(inside)
    }

    fn is_near_a_rim(polygons: &[Polygon], p: Point) -> bool {
        polygons.iter().flat_map(Polygon::edges).any(|(a, b)| within(a, b, p, 8))
    }

    fn is_canonical(polygons: &[Polygon]) -> bool {
        let well_made = |ring: &[Point]| {
            let n = ring.len();
            let bends = |i: usize| orient(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) != 0;
            ring.iter().min() == ring.first() && (0..n).all(bends)
        };
        polygons.iter().all(|polygon| polygon.is_valid() && polygon.rings().all(well_made) && polygon.holes.is_sorted())
            && polygons.is_sorted_by_key(|polygon| &polygon.outer)
    }

    /// The same shapes in another order, rings starting elsewhere, some turned the wrong way.
    fn disguised(polygons: &[Polygon]) -> Vec<Polygon> {
        let mut other = polygons.to_vec();
        other.reverse();
        for (i, polygon) in other.iter_mut().enumerate() {
            let n = polygon.outer.len();
            polygon.outer.rotate_left(i % n);
            if i % 2 == 0 {
                polygon.outer.reverse();
            }
            polygon.holes.reverse();
        }
        other
    }

    #[test]
    fn squares_that_touch_in_a_corner_stay_apart() {
        let (a, b) = (square(0, 0, 4), square(4, 4, 4));
        assert_eq!(union(&[b.clone(), a.clone()]), [a, b]);
    }

    #[test]
    fn squares_along_a_side_become_one() {
        let whole = ring(&[(0, 0), (8, 0), (8, 4), (0, 4)]);
        assert_eq!(union(&[square(0, 0, 4), square(4, 0, 4)]), [Polygon::new(whole, Vec::new())]);
    }

    #[test]
    fn a_pinch_becomes_a_touching_hole() {
        // A diamond cut out of a square, one corner on the rim.
        let diamond = Polygon::new(ring(&[(0, 4), (2, 2), (4, 4), (2, 6)]), Vec::new());
        let result = difference(&[square(0, 0, 8)], &[diamond]);
        assert_eq!(result.len(), 1);
        assert_eq!(result[0].outer, square(0, 0, 8).outer);
        assert_eq!(result[0].holes, [ring(&[(0, 4), (2, 6), (4, 4), (2, 2)])]);
        assert!(result[0].is_valid());
    }

    #[test]
    fn a_ring_of_squares_that_touch_in_corners_falls_apart() {
        let diamond = [square(4, 0, 4), square(0, 4, 4), square(8, 4, 4), square(4, 8, 4)];
        let result = union(&diamond);
        assert_eq!(result.len(), 4);
        assert!(is_canonical(&result));
    }

    #[test]
    fn rings_of_either_turn_count_as_non_zero() {
        let inner = ring(&[(2, 2), (6, 2), (6, 6), (2, 6)]);
        let outer = square(0, 0, 8).outer;
        assert_eq!(union_of_rings(&[outer.clone(), inner.clone()]), [square(0, 0, 8)]);
        let turned: Vec<Point> = inner.into_iter().rev().collect();
        assert_eq!(union_of_rings(&[outer, turned])[0].doubled_area(), 2 * (64 - 16));
        let bow = ring(&[(0, 0), (8, 8), (8, 0), (0, 8)]);
        assert_eq!(union_of_rings(&[bow]).len(), 2);
    }

    #[test]
    fn nothing_gives_nothing() {
        let flat = Polygon::new(ring(&[(0, 0), (5, 5), (9, 9)]), Vec::new());
        assert!(union(&[]).is_empty() && union(&[Polygon::default(), flat.clone()]).is_empty());
        assert!(difference(&[square(0, 0, 4)], &[square(-1, -1, 9)]).is_empty());
        assert!(intersection(&[square(0, 0, 4)], &[square(4, 0, 4)]).is_empty());
        assert_eq!(difference(&[square(0, 0, 4)], &[flat]), [square(0, 0, 4)]);
    }

    #[test]
    fn works_at_the_rim_of_the_lattice() {
        let limit = Point::LIMIT;
        let whole = square(-limit, -limit, 2 * limit);
        let diamond = Polygon::new(ring(&[(0, -limit), (limit, 0), (0, limit), (-limit, 0)]), Vec::new());
        let corners = difference(std::slice::from_ref(&whole), std::slice::from_ref(&diamond));
        assert_eq!(corners.len(), 4);
        assert_eq!(corners.iter().map(Polygon::doubled_area).sum::<i128>(), whole.doubled_area() / 2);
        assert_eq!(intersection(&[whole], std::slice::from_ref(&diamond))[0].doubled_area(), diamond.doubled_area());
    }

    /// Many thousand edges take another path through the engine than a few; far neighbours must not matter there either.
    #[test]
    fn large_input_is_worked_on_locally() {
        let seed = crate::Seed(7);
        let side = 60;
        let cell = |i: u64| {
            let square = |j: u64| {
                let draw = |k: u64| seed.child(i).range(10 * j + k, 100.0, 9_000.0) as i32;
                let (x, y, dx, dy) = (draw(0), draw(1), draw(2), draw(3));
                let shift = (30_000 * (i % side) as i32, 30_000 * (i / side) as i32);
                shifted(
                    &Polygon::new(
                        ring(&[(x, y), (x + dx, y + dy), (x + dx - dy, y + dx + dy), (x - dy, y + dx)]),
                        Vec::new(),
                    ),
                    shift,
                )
            };
            (0..3).map(square).collect::<Vec<_>>()
        };
        let cells: Vec<Vec<Polygon>> = (0..side * side).map(cell).collect();
        let all: Vec<Polygon> = cells.iter().flatten().cloned().collect();
        let mut expected: Vec<Polygon> = cells.iter().flat_map(|cell| union(cell)).collect();
        expected.sort_by(|a, b| a.outer.cmp(&b.outer));
        assert!(all.len() * 4 > 32_000);
        assert_eq!(union(&all), expected);
    }

    proptest! {
        #[test]
        fn areas_add_up(a in vec(prop_oneof![star(), holed()], 1..4), b in vec(star(), 1..4)) {
            let both: Vec<Polygon> = a.iter().chain(&b).cloned().collect();
            let (a_whole, b_whole) = (area(&union(&a)), area(&union(&b)));
            let common = area(&intersection(&a, &b));
            let slack = slack(&both);
            prop_assert!((area(&union(&both)) + common - a_whole - b_whole).abs() <= slack);
            prop_assert!((area(&difference(&a, &b)) - a_whole + common).abs() <= slack);
        }

        #[test]
        fn points_lie_where_they_should(
            a in vec(star(), 1..4),
            b in vec(star(), 1..4),
            points in vec((-150_000..=150_000, -150_000..=150_000), 60),
        ) {
            let both: Vec<Polygon> = a.iter().chain(&b).cloned().collect();
            let results = [union(&both), difference(&a, &b), intersection(&a, &b)];
            for p in points.into_iter().map(|(x, y)| Point::new(x, y)).filter(|&p| !is_near_a_rim(&both, p)) {
                let [in_a, in_b] = [&a, &b].map(|set| times_covered(set, p).unwrap() > 0);
                let expected = [in_a || in_b, in_a && !in_b, in_a && in_b];
                for (result, expected) in results.iter().zip(expected) {
                    prop_assert_eq!(times_covered(result, p), Some(usize::from(expected)));
                }
            }
        }

        #[test]
        fn grid_cells_are_exact(a in grid_rectangles(2), b in grid_rectangles(2)) {
            let both: Vec<Polygon> = a.iter().chain(&b).cloned().collect();
            let results = [union(&both), difference(&a, &b), intersection(&a, &b)];
            prop_assert!(results.iter().all(|result| is_canonical(result)), "{:?}", results);
            for cell in (0..64).map(|i| Point::new(2 * (i % 8) + 1, 2 * (i / 8) + 1)) {
                let [in_a, in_b] = [&a, &b].map(|set| times_covered(set, cell).unwrap() > 0);
                let expected = [in_a || in_b, in_a && !in_b, in_a && in_b];
                for (result, expected) in results.iter().zip(expected) {
                    prop_assert_eq!(times_covered(result, cell), Some(usize::from(expected)));
                }
            }
        }

        #[test]
        fn moving_the_input_moves_the_output(a in vec(star(), 1..5), b in vec(holed(), 0..2), by in shift()) {
            let moved = |set: &[Polygon]| set.iter().map(|polygon| shifted(polygon, by)).collect::<Vec<_>>();
            prop_assert_eq!(moved(&union(&a)), union(&moved(&a)));
            prop_assert_eq!(moved(&difference(&b, &a)), difference(&moved(&b), &moved(&a)));
            prop_assert_eq!(moved(&intersection(&a, &b)), intersection(&moved(&a), &moved(&b)));
        }

        /// The float front end's fault: something far away changes what happens here.
        #[test]
        fn what_is_far_away_changes_nothing(a in vec(star(), 1..5)) {
            let far = square(400_000_000, 300_000_000, 7);
            let mut more = a.clone();
            more.push(far.clone());
            let mut expected = union(&a);
            expected.push(far);
            prop_assert_eq!(union(&more), expected);
        }

        #[test]
        fn order_of_input_changes_nothing(a in vec(star(), 1..6), b in vec(prop_oneof![star(), holed()], 0..4)) {
            prop_assert_eq!(union(&a), union(&disguised(&a)));
            prop_assert_eq!(difference(&b, &a), difference(&disguised(&b), &disguised(&a)));
            prop_assert_eq!(intersection(&a, &b), intersection(&disguised(&b), &disguised(&a)));
        }

        #[test]
        fn results_are_canonical_and_stay(a in vec(star(), 1..6), b in vec(star(), 0..4)) {
            for result in [union(&a), difference(&a, &b), intersection(&a, &b)] {
                prop_assert!(is_canonical(&result), "{:?}", result);
                prop_assert_eq!(&union(&result), &result);
            }
        }

        #[test]
        fn rings_and_polygons_agree(rings in vec(star_ring(), 1..6), by in shift()) {
            let polygons: Vec<Polygon> = rings.iter().map(|r| Polygon::new(r.clone(), Vec::new())).collect();
            prop_assert_eq!(union_of_rings(&rings), union(&polygons));
            let moved: Vec<_> = rings.iter().map(|r| shifted_ring(r, by)).collect();
            prop_assert_eq!(union_of_rings(&moved).len(), union(&polygons).len());
        }

        /// Self-crossing rings so small that every cut is rounded by a noticeable share.
        #[test]
        fn crowded_cuts_leave_valid_polygons(rings in vec(tangle(), 1..6), by in shift()) {
            let result = union_of_rings(&rings);
            prop_assert!(is_canonical(&result), "{:?}", result);
            let moved: Vec<_> = rings.iter().map(|r| shifted_ring(r, by)).collect();
            let expected: Vec<_> = result.iter().map(|polygon| shifted(polygon, by)).collect();
            prop_assert_eq!(union_of_rings(&moved), expected);
        }
    }
}
