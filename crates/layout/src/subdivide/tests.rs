use super::*;
use crate::samples::{antenna, block, blocks, nasty, rectangle, ring, street};
use geom::{Point, Polygon, boolean, predicates};
use proptest::prelude::*;
use std::collections::BTreeSet;

mod controls;
mod telling;
mod turning;

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64]
}

fn settings() -> impl Strategy<Value = RecursiveSettings> {
    let sizes = (60.0..400.0f64, 1.5..6.0f64, 2.0..14.0f64, 0.0..0.4f64, any::<u64>());
    let squared = prop_oneof![Just(Squared::Best), Just(Squared::Side), Just(Squared::Street)];
    let inner = prop_oneof![Just(Inner::Open), Just(Inner::Built)];
    let controls = (share(), share(), share(), squared, any::<bool>(), inner);
    (sizes, controls).prop_map(|((least_area, ratio, least_frontage, irregularity, seed), controls)| {
        let (spread, forced_access, convexity, squared, join, inner) = controls;
        RecursiveSettings {
            least_area,
            most_area: least_area * ratio,
            spread: spread * 0.9,
            least_frontage,
            irregularity,
            forced_access,
            least_convexity: convexity * 0.99,
            squared,
            join,
            inner,
            seed: Seed(seed),
        }
    })
}

fn polygons(parcels: &[Parcel]) -> Vec<Polygon> {
    parcels.iter().map(|parcel| parcel.polygon.clone()).collect()
}

/// V5: simple, counter-clockwise, no short edge, 1 m² or more.
fn check_shape(parcel: &Parcel) -> Result<(), TestCaseError> {
    let polygon = &parcel.polygon;
    prop_assert!(polygon.is_simple(), "not simple: {polygon:?}");
    prop_assert!(geom::polygon::ring_doubled_area(&polygon.outer) >= LEAST_DOUBLED_AREA);
    for (a, b) in polygon.edges() {
        prop_assert!(a.distance_squared(b) >= 256, "short edge {a:?} {b:?}");
    }
    Ok(())
}

/// V6, V8, V9: parcels cover the region but for what is counted, and neither overlap nor leave it. Areas add up
/// exactly, so any overlap would show as a part outside, and the other way round.
fn check_cover(region: &Polygon, division: &Division) -> Result<(), TestCaseError> {
    let sum: i128 = division.parcels.iter().map(|parcel| parcel.polygon.doubled_area()).sum();
    prop_assert_eq!(sum + division.trimmed, region.doubled_area());
    let outside = boolean::difference(&polygons(&division.parcels), std::slice::from_ref(region));
    let outside: i128 = outside.iter().map(Polygon::doubled_area).sum();
    prop_assert_eq!(outside, 0, "parcels leave their region");
    Ok(())
}

/// V6: exact, pair by pair.
fn check_disjoint(parcels: &[Parcel]) -> Result<(), TestCaseError> {
    for (i, a) in parcels.iter().enumerate() {
        let box_a = a.polygon.bounds().unwrap();
        for b in &parcels[..i] {
            if box_a.overlaps(&b.polygon.bounds().unwrap()) {
                let common = boolean::intersection(std::slice::from_ref(&a.polygon), std::slice::from_ref(&b.polygon));
                prop_assert!(common.is_empty(), "{a:?} and {b:?} overlap");
            }
        }
    }
    Ok(())
}

/// V6: a corner that lies on the border of another parcel is a corner of that one too.
fn check_shared_corners(parcels: &[Parcel]) -> Result<(), TestCaseError> {
    for a in parcels {
        let corners: BTreeSet<Point> = a.polygon.rings().flatten().copied().collect();
        for b in parcels {
            for p in b.polygon.rings().flatten().filter(|p| !corners.contains(p)) {
                let on_border = a.polygon.edges().any(|(c, d)| predicates::on_segment(c, d, *p));
                prop_assert!(!on_border, "T gap at {p:?}");
            }
        }
    }
    Ok(())
}

/// V10: what may be built on has its frontage, which lies on the region's rim, or is an inner parcel where those are
/// wanted; and it is as large and as convex as was asked for.
fn check_access(parcel: &Parcel, settings: &RecursiveSettings) -> Result<(), TestCaseError> {
    if parcel.usage == Use::Built {
        let longest = parcel.access.iter().map(|&(_, length)| length).fold(0.0, f64::max);
        let inner = settings.inner == Inner::Built && parcel.is_inner();
        prop_assert!(longest >= settings.least_frontage && longest > 0.0 || inner);
        prop_assert!(parcel.polygon.area() >= settings.least_area - 1e-6);
        let filled = convexity(parcel.polygon.area(), &parcel.polygon.outer);
        prop_assert!(filled >= settings.least_convexity - 1e-9, "fills {filled} of its hull");
    }
    prop_assert!(parcel.access.windows(2).all(|pair| pair[0].0 < pair[1].0));
    check_sides(parcel)
}

/// Every edge says which street it fronts, and lengths add up to those of the access list.
fn check_sides(parcel: &Parcel) -> Result<(), TestCaseError> {
    prop_assert_eq!(parcel.sides.len(), parcel.polygon.outer.len());
    if !parcel.polygon.holes.is_empty() {
        return Ok(());
    }
    for (i, &(_, length)) in parcel.access.iter().enumerate() {
        let edges = geom::polygon::ring_edges(&parcel.polygon.outer).zip(&parcel.sides);
        let fronting = edges.filter(|(_, side)| **side == Some(i as u16));
        let sum: f64 = fronting.map(|((a, b), _)| a.distance(b)).sum();
        prop_assert!((sum - length).abs() < 1e-6, "{sum} m of {length} m");
    }
    prop_assert!(parcel.sides.iter().flatten().all(|&i| usize::from(i) < parcel.access.len()));
    Ok(())
}

fn check_all(block: &Block, settings: &RecursiveSettings) -> Result<(), TestCaseError> {
    let mut ids = BTreeSet::new();
    for region in &buildable(block).regions {
        let division = recursive(region, settings).unwrap();
        check_cover(&region.polygon, &division)?;
        check_disjoint(&division.parcels)?;
        check_shared_corners(&division.parcels)?;
        for parcel in &division.parcels {
            check_shape(parcel)?;
            check_access(parcel, settings)?;
            prop_assert!(ids.insert(parcel.id), "an id twice");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn parcels_keep_the_contract(block in blocks(), settings in settings()) {
        check_all(&block, &settings)?;
    }

    #[test]
    fn nothing_panics_or_breaks_on_nasty_blocks(block in nasty(), settings in settings()) {
        let small = RecursiveSettings { least_area: 1.0, most_area: 6.0, least_frontage: 0.5, ..settings };
        check_all(&block, &small)?;
    }

    #[test]
    fn same_block_same_parcels(block in blocks(), settings in settings()) {
        prop_assert_eq!(subdivide(&block, &settings), subdivide(&block, &settings));
    }

    #[test]
    fn a_block_moved_has_its_parcels_moved(
        block in blocks(), settings in settings(), by in (-300_000_000i32..300_000_000, -300_000_000i32..300_000_000),
    ) {
        let shift = |p: Point| Point::new(p.x + by.0, p.y + by.1);
        let mut moved = block.clone();
        moved.polygon.outer.iter_mut().for_each(|p| *p = shift(*p));
        moved.polygon.holes.iter_mut().flatten().for_each(|p| *p = shift(*p));
        moved.bodies.iter_mut().for_each(|body| (body.from, body.to) = (shift(body.from), shift(body.to)));
        let mut there = subdivide(&block, &settings).unwrap();
        there.parcels.iter_mut().flat_map(|parcel| parcel.polygon.outer.iter_mut()).for_each(|p| *p = shift(*p));
        prop_assert_eq!(there, subdivide(&moved, &settings).unwrap());
    }
}

#[test]
fn a_manhattan_block_has_two_rows_of_like_lots() {
    let block = block(rectangle(274.0, 80.0), &[9.0, 15.0]);
    let division = subdivide(&block, &RecursiveSettings { irregularity: 0.0, ..RecursiveSettings::default() }).unwrap();
    // 244 m × 62 m: halved along its length four times and once across makes 32 lots of 15.25 m × 31 m.
    assert_eq!(division.parcels.len(), 32);
    assert_eq!(division.trimmed, 0);
    for parcel in &division.parcels {
        assert_eq!(parcel.usage, Use::Built);
        assert!((parcel.polygon.area() - 472.75).abs() < 1.0, "{}", parcel.polygon.area());
    }
}

#[test]
fn a_deep_block_leaves_open_courts_only_inside() {
    let block = block(rectangle(260.0, 260.0), &[8.0]);
    let division = subdivide(&block, &RecursiveSettings::default()).unwrap();
    let open: Vec<_> = division.parcels.iter().filter(|parcel| parcel.usage == Use::Open).collect();
    let built: f64 = division.parcels.iter().filter(|p| p.usage == Use::Built).map(|p| p.polygon.area()).sum();
    assert!(open.iter().all(|parcel| parcel.access.is_empty()));
    assert!(built > 0.6 * 244.0 * 244.0, "{built}");
}

#[test]
fn a_block_with_an_island_has_parcels_without_holes() {
    let hole = ring(&[(60.0, 60.0), (60.0, 90.0), (90.0, 90.0), (90.0, 60.0)]);
    let polygon = Polygon::new(ring(&[(0.0, 0.0), (150.0, 0.0), (150.0, 150.0), (0.0, 150.0)]), vec![hole]);
    let division = subdivide(&block(polygon, &[5.0]), &RecursiveSettings::default()).unwrap();
    assert!(division.parcels.len() > 15);
    assert!(division.parcels.iter().all(|parcel| parcel.polygon.holes.is_empty()));
}

#[test]
fn a_dead_end_gives_access_to_the_middle() {
    let mut with = block(rectangle(160.0, 160.0), &[6.0]);
    let settings = RecursiveSettings::default();
    let open = |block: &Block| {
        let parcels = subdivide(block, &settings).unwrap().parcels;
        parcels.iter().filter(|p| p.usage == Use::Open).map(|p| p.polygon.area()).sum::<f64>()
    };
    let without = open(&with);
    with.bodies.push(antenna((80.0, 0.0), (80.0, 90.0), 4.0));
    let parcels = subdivide(&with, &settings).unwrap().parcels;
    assert!(parcels.iter().any(|parcel| parcel.access.iter().any(|(id, _)| *id == street(1000))));
    assert!(open(&with) <= without);
}

#[test]
fn senseless_settings_are_refused() {
    let wrong = |settings: RecursiveSettings| settings.check().unwrap_err().to_string();
    let base = RecursiveSettings::default();
    assert_eq!(
        wrong(RecursiveSettings { least_area: 500.0, most_area: 300.0, ..base }),
        "least_area (500 m²) is greater than most_area (300 m²)"
    );
    assert!(wrong(RecursiveSettings { irregularity: f64::NAN, ..base }).starts_with("irregularity is NaN"));
    assert!(wrong(RecursiveSettings { most_area: 0.0, ..base }).contains("between 4 and"));
    assert!(wrong(RecursiveSettings { spread: 1.0, ..base }).starts_with("spread is 1"));
    assert!(wrong(RecursiveSettings { forced_access: -0.1, ..base }).contains("between 0 and 1"));
    assert!(wrong(RecursiveSettings { least_convexity: 1.0, ..base }).contains("of the convex hull"));
}
