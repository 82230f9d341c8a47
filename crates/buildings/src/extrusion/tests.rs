use super::*;
use proptest::prelude::*;

fn shape(outline: Polygon) -> StartShape {
    let fronts = vec![false; outline.outer.len()];
    StartShape { parcel: Id::root("parcel", &[7]), outline, fronts, density: 1000.0, ground: (3.0, 4.5) }
}

fn extrude(shape: &StartShape, height: f64, setback: f64) -> Option<Building> {
    super::extrude(shape, &Envelope { height, setbacks: Setbacks::Even(setback), coverage: 1.0 })
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

fn convex_outlines() -> impl Strategy<Value = Polygon> {
    let corners = prop::collection::vec((-30_000i32..30_000, -30_000i32..30_000), 3..9);
    corners.prop_map(|corners| {
        let points: Vec<Point> = corners.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        Polygon::new(geom::polygon::convex_hull(&points), vec![])
    })
}

proptest! {
    /// The oracle: strips along the edges, taken away by the boolean.
    #[test]
    fn convex_outlines_are_set_back_as_any_others(outline in convex_outlines(), setback in 1..12_000i32) {
        prop_assume!(outline.outer.len() >= 3);
        let Some(quick) = convex::within(&outline.outer, |_| setback) else { return Ok(()) };
        let strips = strips(&simplified(&outline).outer, |_| setback);
        let slow = boolean::difference(std::slice::from_ref(&outline), &strips);
        let quick: Vec<Polygon> = quick.into_iter().collect();
        let apart = boolean::difference(&quick, &slow).into_iter().chain(boolean::difference(&slow, &quick));
        // Both round corners, at acute ones over some length.
        let (apart, around) = (apart.map(|part| part.area()).sum::<f64>(), outline.perimeter());
        prop_assert!(apart <= around * 4.0 / 1024.0, "{apart} m² of {around} m");
    }

    #[test]
    fn party_walls_stay_inside_and_other_sides_keep_off(outline in convex_outlines(), distances in prop::collection::vec(0..3i32, 9)) {
        prop_assume!(outline.outer.len() >= 3);
        let of = |i: usize| distances[i % distances.len()] * 2000;
        let Some(Some(part)) = convex::within(&outline.outer, of) else { return Ok(()) };
        prop_assert!(part.is_simple());
        for (i, (a, b)) in ring_edges(&outline.outer).enumerate() {
            for &p in &part.outer {
                prop_assert!(geom::predicates::orient(a, b, p) >= 0);
                let (from, along) = (a.metres(), (b.metres() - a.metres()).normalize());
                let depth = along.perp_dot(p.metres() - from) * 1024.0;
                prop_assert!(depth >= f64::from(of(i)) - 1e-3, "{depth} {}", of(i));
            }
        }
    }
}

proptest! {
    /// Corners that rounding put a unit inside the border, or on it.
    #[test]
    fn dents_do_not_part_with_the_setback(
        outline in convex_outlines(), shares in prop::collection::vec((0usize..9, 0.1..0.9f64), 1..4), setback in 1..8_000i32,
    ) {
        prop_assume!(outline.outer.len() >= 3);
        let mut ring = outline.outer.clone();
        for (edge, share) in shares {
            let (a, b) = (ring[edge % ring.len()], ring[(edge + 1) % ring.len()]);
            let at = a.metres().lerp(b.metres(), share);
            ring.insert(edge % ring.len() + 1, Point::from_metres(at));
        }
        let dented = Polygon::new(ring, vec![]);
        prop_assume!(dented.is_simple());
        let Some(Some(part)) = convex::within(&dented.outer, |_| setback) else { return Ok(()) };
        for &p in &part.outer {
            prop_assert!(dented.distance_to_rim(p.metres()) * 1024.0 >= f64::from(setback) - 1e-3);
            prop_assert!(dented.contains(p));
        }
    }
}

#[test]
fn rings_that_are_not_convex_are_left_to_the_boolean() {
    let bay = ring(&[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (10.0, 5.0), (0.0, 20.0)]);
    assert_eq!(convex::within(&bay, |_| 100), None);
    let star: Vec<Point> = (0..5)
        .map(|i| {
            let unit = geom::Angle::radians(std::f64::consts::TAU * 2.0 * f64::from(i) / 5.0).unit() * 20.0;
            Point::from_metres(unit)
        })
        .collect();
    assert_eq!(convex::within(&star, |_| 100), None, "it goes round twice");
    assert_eq!(convex::within(&rectangle(4.0, 4.0).outer, |_| 3000), Some(None), "nothing is left");
}

/// A parcel with its first edge on a street.
fn fronting(outline: Polygon) -> StartShape {
    let mut shape = shape(outline);
    shape.fronts[0] = true;
    shape
}

fn by_side(front: f64, side: f64, rear: f64, coverage: f64) -> Envelope {
    Envelope { height: 9.0, setbacks: Setbacks::Sides { front, side, rear }, coverage }
}

#[test]
fn each_side_keeps_its_own_distance() {
    let building = super::extrude(&fronting(rectangle(20.0, 40.0)), &by_side(3.0, 2.0, 10.0, 1.0)).unwrap();
    let bounds = building.footprint.bounds().unwrap();
    let near = |unit: i32, metres: f64| (f64::from(unit) / 1024.0 - metres).abs() < 0.01;
    assert!(near(bounds.min.y, 3.0) && near(bounds.max.y, 30.0), "{bounds:?}");
    assert!(near(bounds.min.x, 2.0) && near(bounds.max.x, 18.0), "{bounds:?}");
    let flush = super::extrude(&fronting(rectangle(20.0, 40.0)), &by_side(0.0, 0.0, 10.0, 1.0)).unwrap();
    assert_eq!(flush.footprint.bounds().unwrap().min, Point::new(0, 0), "party walls stand on the border");
}

#[test]
fn setbacks_by_side_do_not_yield() {
    assert_eq!(super::extrude(&fronting(rectangle(8.0, 12.0)), &by_side(6.0, 1.0, 5.0, 1.0)), None);
}

#[test]
fn what_coverage_forbids_is_taken_off_the_rear() {
    let building = super::extrude(&fronting(rectangle(20.0, 40.0)), &by_side(0.0, 0.0, 0.0, 0.4)).unwrap();
    assert!((building.footprint.area() - 320.0).abs() < 2.0, "{}", building.footprint.area());
    let bounds = building.footprint.bounds().unwrap();
    assert_eq!((bounds.min.y, bounds.max.x), (0, units(20.0)));
    assert_eq!(super::extrude(&fronting(rectangle(20.0, 40.0)), &by_side(0.0, 0.0, 0.0, 0.0)), None);
}

proptest! {
    #[test]
    fn envelopes_are_kept(
        outline in outlines(), fronts in prop::collection::vec(any::<bool>(), 10),
        (front, side, rear) in (0.0..5.0f64, 0.0..3.0f64, 0.0..6.0f64), coverage in 0.1..1.0f64,
    ) {
        let n = outline.outer.len();
        let shape = StartShape { fronts: fronts[..n].to_vec(), ..shape(outline.clone()) };
        let Some(building) = super::extrude(&shape, &by_side(front, side, rear, coverage)) else { return Ok(()) };
        prop_assert!(building.footprint.area() <= coverage * outline.area() + 1e-9);
        prop_assert!(building.footprint.is_simple() && building.footprint.area() >= LEAST_FOOTPRINT);
        let outside = boolean::difference(std::slice::from_ref(&building.footprint), std::slice::from_ref(&outline));
        prop_assert!(outside.is_empty(), "{outside:?}");
        let kinds = sides(&outline.outer, &shape.fronts);
        for ((a, b), kind) in ring_edges(&outline.outer).zip(kinds) {
            let setback = match kind { Side::Front => front, Side::Side => side, Side::Rear => rear };
            let (from, along) = (a.metres(), b.metres() - a.metres());
            let near = |p: &Point| {
                let share = ((p.metres() - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                p.metres().distance(from + along * share)
            };
            let nearest = building.footprint.outer.iter().map(near).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest >= setback - 0.002, "{kind:?} {nearest} < {setback}");
        }
    }
}
