//! Each control of the recursive division does what it says.

use super::*;

/// Skewed blocks of several depths, one of them with a reflex corner.
fn town() -> Vec<Block> {
    let quad = |a: f64, b: f64| ring(&[(0.0, 0.0), (a, 6.0), (a - 9.0, b), (11.0, b - 14.0)]);
    let bent = ring(&[(0.0, 0.0), (180.0, 0.0), (180.0, 160.0), (90.0, 170.0), (80.0, 70.0), (0.0, 80.0)]);
    let rings = [quad(220.0, 90.0), quad(240.0, 230.0), quad(300.0, 160.0), bent];
    rings.into_iter().map(|ring| block(Polygon::new(ring, Vec::new()), &[8.0, 6.0])).collect()
}

fn parcels(change: impl Fn(&mut RecursiveSettings)) -> Vec<Parcel> {
    let mut settings = RecursiveSettings::default();
    change(&mut settings);
    town().iter().flat_map(|block| subdivide(block, &settings).unwrap().parcels).collect()
}

fn count(parcels: &[Parcel], counts: impl Fn(&Parcel) -> bool) -> usize {
    parcels.iter().filter(|parcel| counts(parcel)).count()
}

fn open_area(parcels: &[Parcel]) -> f64 {
    parcels.iter().filter(|parcel| parcel.usage == Use::Open).map(|parcel| parcel.polygon.area()).sum()
}

fn largest(parcels: &[Parcel]) -> f64 {
    parcels.iter().filter(|p| p.usage == Use::Built).map(|p| p.polygon.area()).fold(0.0, f64::max)
}

#[test]
fn areas_bound_parcels() {
    let (fine, coarse) = (
        parcels(|s| (s.least_area, s.most_area) = (80.0, 300.0)),
        parcels(|s| (s.least_area, s.most_area) = (900.0, 2400.0)),
    );
    assert!(fine.len() > 3 * coarse.len());
    let built = |parcels: &[Parcel], area: f64| {
        parcels.iter().filter(|p| p.usage == Use::Built).all(|p| p.polygon.area() >= area - 1e-6)
    };
    assert!(built(&fine, 80.0) && built(&coarse, 900.0));
    // Of parcels that access does not hold together, none is much larger than asked.
    assert!(largest(&fine) <= 2.0 * 300.0 && largest(&coarse) <= 2.0 * 2400.0);
}

#[test]
fn the_spread_varies_areas() {
    let areas = |spread: f64| {
        let mut areas: Vec<f64> = parcels(|s| (s.spread, s.irregularity) = (spread, 0.0))
            .iter()
            .filter(|parcel| parcel.usage == Use::Built)
            .map(|parcel| parcel.polygon.area())
            .collect();
        areas.sort_by(f64::total_cmp);
        areas
    };
    let width = |areas: &[f64]| areas[areas.len() * 9 / 10] / areas[areas.len() / 10];
    assert!(width(&areas(0.8)) > 1.2 * width(&areas(0.0)), "{} {}", width(&areas(0.8)), width(&areas(0.0)));
}

#[test]
fn frontages_are_as_long_as_asked() {
    for least_frontage in [4.0, 12.0, 20.0] {
        let parcels = parcels(|s| (s.least_frontage, s.most_area) = (least_frontage, 1200.0));
        let longest = |parcel: &Parcel| parcel.access.iter().map(|(_, length)| *length).fold(0.0, f64::max);
        assert!(count(&parcels, |p| p.usage == Use::Built && longest(p) < least_frontage) == 0);
    }
    assert!(parcels(|s| s.least_frontage = 20.0).len() < parcels(|s| s.least_frontage = 4.0).len());
}

#[test]
fn irregular_cuts_differ_by_seed_and_regular_ones_do_not() {
    let outlines = |irregularity: f64, seed: u64| {
        let parcels = parcels(|s| (s.irregularity, s.seed) = (irregularity, Seed(seed)));
        parcels.into_iter().map(|parcel| parcel.polygon).collect::<Vec<_>>()
    };
    assert_eq!(outlines(0.0, 1), outlines(0.0, 2));
    assert_ne!(outlines(0.2, 1), outlines(0.2, 2));
    assert_eq!(outlines(0.2, 1), outlines(0.2, 1));
}

#[test]
fn without_forced_access_land_behind_is_left_over() {
    let landlocked = |share: f64| {
        let parcels = parcels(|s| s.forced_access = share);
        parcels.iter().filter(|p| p.access.is_empty()).map(|p| p.polygon.area()).sum::<f64>()
    };
    let (forced, some, free) = (landlocked(1.0), landlocked(0.5), landlocked(0.0));
    assert!(forced < some && some < free, "{forced} {some} {free}");
}

#[test]
fn inner_parcels_are_built_or_open() {
    let of = |inner: Inner| parcels(|s| (s.inner, s.forced_access) = (inner, 0.0));
    let (open, built) = (of(Inner::Open), of(Inner::Built));
    assert_eq!(count(&open, Parcel::is_inner), 0);
    assert!(count(&built, Parcel::is_inner) > 20);
    assert!(open_area(&open) > 10.0 * open_area(&built));
    let total = |parcels: &[Parcel]| parcels.iter().map(|p| p.polygon.area()).sum::<f64>();
    assert!((total(&open) - total(&built)).abs() < 0.1, "nothing is dropped");
}

#[test]
fn concave_parcels_are_avoided() {
    let fills = |parcel: &Parcel| convexity(parcel.polygon.area(), &parcel.polygon.outer);
    let of = |least: f64| parcels(|s| s.least_convexity = least);
    let concave = |parcels: &[Parcel]| count(parcels, |p| p.usage == Use::Built && fills(p) < 0.95);
    let (any, convex) = (of(0.0), of(0.95));
    assert!(concave(&any) > 0);
    assert_eq!(concave(&convex), 0);
    // Cuts and joins keep to it first: little land is given up.
    let total: f64 = convex.iter().map(|p| p.polygon.area()).sum();
    assert!(open_area(&convex) - open_area(&any) < 0.1 * total, "{} {}", open_area(&convex), open_area(&any));
}

/// A parallelogram with streets along some of its sides: below, right, above, left.
fn slanted(streets: [bool; 4]) -> Region {
    let ring = ring(&[(0.0, 0.0), (200.0, 0.0), (260.0, 90.0), (60.0, 90.0)]);
    let frontage = streets.iter().enumerate().map(|(i, has)| has.then(|| street(i as u64))).collect();
    let polygon = Polygon::new(ring, Vec::new());
    Region { block: geom::Id::root("slanted", &[]), ordinal: 0, polygon, frontage: vec![frontage] }
}

/// The direction of the one cut that halves a slanted region.
fn only_cut(squared: Squared, streets: [bool; 4]) -> geom::Vec2 {
    let settings =
        RecursiveSettings { squared, irregularity: 0.0, most_area: 12_000.0, ..RecursiveSettings::default() };
    let parcels = recursive(&slanted(streets), &settings).unwrap().parcels;
    assert_eq!(parcels.len(), 2);
    let ends: Vec<Point> =
        parcels[0].polygon.outer.iter().copied().filter(|p| parcels[1].polygon.outer.contains(p)).collect();
    (ends[1].metres() - ends[0].metres()).normalize()
}

#[test]
fn cuts_are_squared_as_asked() {
    let (all, ends) = ([true; 4], [false, true, false, true]);
    let along_end = geom::Vec2::new(60.0, 90.0).normalize();
    assert!(only_cut(Squared::Side, all).x.abs() < 1e-3, "square to the long side");
    assert!(only_cut(Squared::Side, ends).x.abs() < 1e-3, "wherever streets are");
    assert!(only_cut(Squared::Street, all).x.abs() < 1e-3, "square to the longest front");
    let cut = only_cut(Squared::Street, ends);
    assert!(cut.dot(along_end).abs() < 1e-2 || cut.perp_dot(along_end).abs() < 1e-2, "with the slanted ends: {cut}");
}

#[test]
fn what_is_too_small_joins_a_neighbour_or_stays_open() {
    let of = |join: bool| parcels(|s| (s.join, s.least_frontage) = (join, 14.0));
    let (joined, left) = (of(true), of(false));
    assert!(open_area(&joined) < open_area(&left));
}
