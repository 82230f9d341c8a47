use super::samples::{holed, scribble, shift, shifted, shifted_ring, star, star_ring};
use super::*;
use crate::boolean::union;
use crate::predicates::{crosses_properly, meets};
use crate::triangulate;
use proptest::prelude::*;

fn ring(points: &[(i32, i32)]) -> Vec<Point> {
    points.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

fn square(from: i32, to: i32) -> Vec<Point> {
    ring(&[(from, from), (to, from), (to, to), (from, to)])
}

#[test]
fn measures_of_a_holed_square() {
    let metres = |m: i32| m * 1024;
    let polygon = Polygon::new(square(0, metres(10)), vec![square(metres(2), metres(4))]);
    assert_eq!(polygon.doubled_area(), 2 * 96 * 1024 * 1024);
    assert_eq!((polygon.area(), polygon.perimeter()), (96.0, 48.0));
    assert_eq!(polygon.centroid(), (Vec2::splat(5.0) * 100.0 - Vec2::splat(3.0) * 4.0) / 96.0);
    assert_eq!(polygon.distance_to_rim(Vec2::new(5.0, 3.0)), 1.0);
    assert_eq!(polygon.distance_to_rim(Vec2::new(-3.0, -4.0)), 5.0);
    assert_eq!(polygon.bounds().unwrap().size(), Vec2::splat(10.0));
}

#[test]
fn new_turns_rings_and_keeps_their_start() {
    let clockwise = ring(&[(0, 0), (0, 9), (9, 9), (9, 0)]);
    let polygon = Polygon::new(clockwise.clone(), vec![square(2, 4)]);
    assert_eq!(polygon.outer, square(0, 9));
    assert_eq!(polygon.holes[0], ring(&[(2, 2), (2, 4), (4, 4), (4, 2)]));
    assert_eq!(Polygon::new(square(0, 9), vec![polygon.holes[0].clone()]), polygon);
}

#[test]
fn nothing_is_measured_without_panic() {
    let none = Polygon::default();
    assert_eq!((none.doubled_area(), none.perimeter(), none.bounds()), (0, 0.0, None));
    assert_eq!((none.centroid(), none.pole(1.0)), (Vec2::ZERO, Point::default()));
    assert_eq!(none.distance_to_rim(Vec2::ZERO), f64::INFINITY);
    assert_eq!(none.locate(Point::default()), Location::Outside);
    assert!(!none.is_simple() && !none.is_valid());
    let flat = Polygon::new(ring(&[(0, 0), (1024, 0), (2048, 0)]), Vec::new());
    assert_eq!((flat.centroid(), flat.area()), (Vec2::new(1.0, 0.0), 0.0));
    assert_eq!(flat.locate(flat.pole(1.0)), Location::OnRim);
}

#[test]
fn collinear_points_and_spikes_go() {
    let messy = ring(&[(5, 0), (9, 0), (9, 0), (9, 4), (9, 9), (9, 14), (9, 9), (0, 9), (0, 0), (-3, 0), (2, 0)]);
    assert_eq!(without_collinear(&messy), ring(&[(9, 0), (9, 9), (0, 9), (0, 0)]));
    assert!(without_collinear(&ring(&[(0, 0), (4, 0), (8, 0), (2, 0)])).is_empty());
    assert!(without_collinear(&ring(&[(0, 0), (4, 3), (0, 0)])).is_empty());
    assert!(without_collinear(&[]).is_empty());
}

#[test]
fn validity_of_touching_rings() {
    let valid = |outer: &[(i32, i32)], holes: &[&[(i32, i32)]]| {
        Polygon::new(ring(outer), holes.iter().map(|hole| ring(hole)).collect()).is_valid()
    };
    let outer = [(0, 0), (12, 0), (12, 12), (0, 12)];
    assert!(valid(&outer, &[&[(0, 6), (4, 4), (4, 8)]]), "a hole may touch the rim");
    assert!(!valid(&outer, &[&[(0, 6), (6, 0), (6, 6)]]), "two touches cut the interior");
    assert!(!valid(&outer, &[&[(0, 6), (4, 4), (6, 6)], &[(6, 6), (12, 6), (9, 9)]]), "a chain of holes cuts it too");
    assert!(valid(&outer, &[&[(1, 6), (4, 4), (6, 6)], &[(6, 6), (12, 6), (9, 9)]]), "but not one that ends inside");
    assert!(!valid(&outer, &[&[(3, 3), (9, 3), (9, 9)], &[(5, 4), (6, 4), (6, 5)]]), "a hole in a hole");
    assert!(!valid(&outer, &[&[(13, 3), (15, 3), (15, 9)]]), "a hole outside");
    assert!(!valid(&outer, &[&[(12, 3), (15, 3), (15, 9)]]), "a hole outside that touches");
    assert!(!valid(&outer, &[&[(0, 3), (0, 6), (4, 4)]]), "a hole along the rim");
    assert!(!valid(&outer, &[&[(4, 4), (4, 8), (14, 6)]]), "a hole across the rim");
    assert!(!Polygon { outer: ring(&[(0, 0), (0, 9), (9, 9)]), holes: Vec::new() }.is_valid(), "clockwise");
}

/// All pairs of edges, by the book.
fn is_simple_by_brute_force(ring: &[Point]) -> bool {
    let edges: Vec<_> = ring_edges(ring).collect();
    let n = edges.len();
    let fine = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (edges[i], edges[j]);
        match (j + n - i) % n {
            1 => b == c && a != b && c != d && !on_segment(a, b, d) && !on_segment(c, d, a),
            apart if apart == n - 1 => true,
            _ => !meets(a, b, c, d),
        }
    };
    n >= 3 && ring_doubled_area(ring) != 0 && (0..n).all(|i| (0..n).all(|j| i == j || fine(i, j)))
}

/// Parity of crossings with a ray towards a direction that meets no other lattice point of a small grid.
fn locate_by_ray(polygon: &Polygon, p: Point) -> Location {
    if polygon.edges().any(|(a, b)| on_segment(a, b, p)) {
        return Location::OnRim;
    }
    let far = Point::new(p.x + 100_003, p.y + 1_009);
    let crossings = polygon.edges().filter(|&(a, b)| crosses_properly(a, b, p, far)).count();
    if crossings % 2 == 1 { Location::Inside } else { Location::Outside }
}

/// The least area over all hull edges as a fraction with the edge's squared length, from all points.
fn least_area_by_brute_force(points: &[Point]) -> f64 {
    let hull = convex_hull(points);
    let area = |(a, b): (Point, Point)| {
        let along: Vec<i64> = points.iter().map(|&p| dot(a, b, p)).collect();
        let across: Vec<i64> = points.iter().map(|&p| orient(a, b, p)).collect();
        let extent = |v: &[i64]| (v.iter().max().unwrap() - v.iter().min().unwrap()) as f64;
        extent(&along) * extent(&across) / a.distance_squared(b) as f64
    };
    ring_edges(&hull).map(area).fold(f64::INFINITY, f64::min) / (1024.0 * 1024.0)
}

#[test]
fn box_of_degenerate_sets() {
    assert_eq!(min_area_box(&[]).area(), 0.0);
    let p = Point::new(2048, 1024);
    assert_eq!(min_area_box(&[p, p]), OrientedBox { centre: p.metres(), axis: Vec2::X, half: Vec2::ZERO });
    let line = min_area_box(&ring(&[(3072, 4096), (0, 0), (1536, 2048)]));
    assert_eq!(line.half, Vec2::new(2.5, 0.0));
    assert!((line.centre - Vec2::new(1.5, 2.0)).length() < 1e-12);
    assert!((line.axis - Vec2::new(0.6, 0.8)).length() < 1e-15);
}

#[test]
fn box_lies_along_the_longer_side() {
    let upright = min_area_box(&ring(&[(0, 0), (1024, 0), (1024, 4096), (0, 4096)]));
    assert_eq!((upright.axis, upright.half, upright.centre), (Vec2::Y, Vec2::new(2.0, 0.5), Vec2::new(0.5, 2.0)));
}

#[test]
fn pole_of_a_letter_l_lies_in_its_corner() {
    let metres = |points: &[(i32, i32)]| ring(&points.iter().map(|&(x, y)| (x * 1024, y * 1024)).collect::<Vec<_>>());
    let l = Polygon::new(metres(&[(0, 0), (30, 0), (30, 10), (10, 10), (10, 30), (0, 30)]), Vec::new());
    let pole = l.pole(0.01);
    // The circle that touches both outer sides and the inner corner: r = 10 (2 - √2).
    assert!((l.distance_to_rim(pole.metres()) - 10.0 * (2.0 - 2f64.sqrt())).abs() < 0.011);
}

#[test]
fn pole_of_a_sliver_ends() {
    let sliver = Polygon::new(ring(&[(0, 0), (2_000_000, 1), (4_000_000, 0)]), Vec::new());
    assert!(sliver.contains(sliver.pole(0.001)));
}

proptest! {
    #[test]
    fn reduced_rings_enclose_the_same(points in scribble()) {
        let reduced = without_collinear(&points);
        prop_assert_eq!(ring_doubled_area(&reduced), ring_doubled_area(&points));
        prop_assert_eq!(&without_collinear(&reduced), &reduced);
        let n = reduced.len();
        for i in 0..n {
            prop_assert_ne!(orient(reduced[i], reduced[(i + 1) % n], reduced[(i + 2) % n]), 0);
        }
    }

    #[test]
    fn simple_agrees_with_brute_force(points in scribble()) {
        prop_assert_eq!(ring_is_simple(&points), is_simple_by_brute_force(&points));
    }

    #[test]
    fn simple_agrees_with_brute_force_on_larger_rings(points in star_ring(), swap in (0usize..14, 0usize..14)) {
        let mut changed = points;
        let n = changed.len();
        changed.swap(swap.0 % n, swap.1 % n);
        prop_assert_eq!(ring_is_simple(&changed), is_simple_by_brute_force(&changed));
    }

    /// What is valid comes out of a union as it went in; what is not, cannot, since results are valid.
    #[test]
    fn valid_polygons_are_what_a_union_keeps(outer in scribble(), holes in prop::collection::vec(scribble(), 0..3)) {
        let holes = holes.iter().map(|hole| without_collinear(hole)).filter(|hole| !hole.is_empty()).collect();
        let polygon = Polygon::new(without_collinear(&outer), holes);
        let result = union(std::slice::from_ref(&polygon));
        prop_assert!(result.iter().all(Polygon::is_valid));
        let same = result.len() == 1 && sorted_corners(&result[0]) == sorted_corners(&polygon);
        prop_assert_eq!(polygon.is_valid(), same, "{:?}", result);
    }

    #[test]
    fn locate_agrees_with_a_ray(outer in scribble(), hole in scribble(), x in -1..7, y in -1..7) {
        let polygon = Polygon { outer, holes: vec![hole] };
        let p = Point::new(x, y);
        prop_assert_eq!(polygon.locate(p), locate_by_ray(&polygon, p));
    }

    #[test]
    fn centroid_is_that_of_the_triangles(polygon in prop_oneof![star(), holed()]) {
        let parts = triangulate(&polygon).unwrap();
        let mut sum = Vec2::ZERO;
        for &t in &parts.triangles {
            let [a, b, c] = parts.corners(t);
            sum += (a.metres() + b.metres() + c.metres()) / 3.0 * orient(a, b, c) as f64;
        }
        prop_assert!((sum / polygon.doubled_area() as f64 - polygon.centroid()).length() < 1e-6);
    }

    #[test]
    fn measures_move_along(polygon in prop_oneof![star(), holed()], by in shift()) {
        let moved = shifted(&polygon, by);
        prop_assert_eq!(moved.doubled_area(), polygon.doubled_area());
        prop_assert_eq!(moved.perimeter(), polygon.perimeter());
        prop_assert_eq!(moved.is_simple(), polygon.is_simple());
        let (a, b) = (min_area_box(&moved.outer), min_area_box(&polygon.outer));
        prop_assert_eq!(a.half, b.half);
        prop_assert_eq!(a.axis, b.axis);
    }

    #[test]
    fn pole_is_far_inside(polygon in prop_oneof![star(), holed()]) {
        let pole = polygon.pole(0.1);
        prop_assert_eq!(polygon.locate(pole), Location::Inside);
        let radius = polygon.distance_to_rim(pole.metres());
        let bounds = polygon.bounds().unwrap();
        for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let at = bounds.min.metres() + bounds.size() * Vec2::new(f64::from(i), f64::from(j)) / 20.0;
            if polygon.locate(Point::from_metres(at)) == Location::Inside {
                prop_assert!(polygon.distance_to_rim(at) <= radius + 0.102);
            }
        }
    }

    #[test]
    fn box_is_least_and_holds_all(points in prop_oneof![star_ring(), scribble()]) {
        let found = min_area_box(&points);
        prop_assume!(convex_hull(&points).len() > 2);
        let least = least_area_by_brute_force(&points);
        prop_assert!((found.area() - least).abs() <= 1e-9 * least.max(1e-6), "{} {}", found.area(), least);
        prop_assert!(found.half.x >= found.half.y * (1.0 - 1e-12));
        for p in &points {
            let from = p.metres() - found.centre;
            let (x, y) = (from.dot(found.axis), from.dot(found.axis.perp()));
            prop_assert!(x.abs() <= found.half.x + 1e-6 && y.abs() <= found.half.y + 1e-6);
        }
    }

    #[test]
    fn box_does_not_depend_on_order(points in scribble(), turn in 0usize..9, by in shift()) {
        let mut other = shifted_ring(&points, by);
        other.reverse();
        other.rotate_left(turn % points.len());
        let (a, b) = (min_area_box(&points), min_area_box(&other));
        prop_assert_eq!((a.axis, a.half), (b.axis, b.half));
    }

    #[test]
    fn hull_is_convex_and_holds_all(points in prop_oneof![star_ring(), scribble()]) {
        let hull = convex_hull(&points);
        prop_assume!(hull.len() > 2);
        for (a, b) in ring_edges(&hull) {
            prop_assert!(points.iter().all(|&p| orient(a, b, p) >= 0));
            prop_assert!(hull.iter().all(|&p| p == a || p == b || orient(a, b, p) > 0));
        }
        prop_assert_eq!(hull[0], *points.iter().min().unwrap());
    }
}

/// Every ring turned to start at its least corner, holes sorted.
fn sorted_corners(polygon: &Polygon) -> Vec<Vec<Point>> {
    let mut rings: Vec<Vec<Point>> = polygon.rings().map(<[Point]>::to_vec).collect();
    for ring in &mut rings {
        let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
        ring.rotate_left(least);
    }
    rings.get_mut(1..).unwrap_or_default().sort();
    rings
}

#[test]
fn large_rings_are_checked_quickly() {
    // A comb of 40,000 teeth: long edges beside each other, which a sweep along the wrong axis would compare pairwise.
    let mut comb = ring(&[(0, -10)]);
    for tooth in 0..40_000 {
        comb.push(Point::new(4 * tooth, 100_000_000));
        comb.push(Point::new(4 * tooth + 2, 0));
    }
    comb.push(Point::new(160_000, -10));
    assert!(ring_is_simple(&comb));
    comb.push(Point::new(2, 1));
    assert!(!ring_is_simple(&comb));
}
