//! Where minors grow: in a polygon, in chosen quarters, in a rim outside all of them.

use crate::common::build::faultless;
use crate::common::build::try_build as try_folder;
use city::{Built, City, LoadError, Until};
use geom::Vec2;
use std::fs;
use streets::Classes;

/// Three quarters of 500 m × 1 km side by side, on a site with land all around; districts come from a file.
fn script(option: &str) -> String {
    format!(
        r##"
let lines = [line([[1050, 1050], [2550, 1050], [2550, 2050], [1050, 2050], [1050, 1050]])];
for x in [1550, 2050] {{ lines.push(line([[x, 1050], [x, 2050]])); }}
city(#{{
    site: site(#{{ size: [3600, 3100] }}),
    districts: districts_from("districts.geojson"),
    given: lines,
    minors: streets(#{{ pattern: rule("streets/grid", #{{ heading: 0, block_length: 160, block_width: 80 }}), {option} }}),
    parcels: rule("parcels/recursive"),
}});"##
    )
}

const DISTRICTS: &str = r##"{ "type": "FeatureCollection", "plat": { "units": "m" }, "features": [
  { "type": "Feature", "properties": { "name": "harbour" }, "geometry": { "type": "Polygon", "coordinates":
    [[[1700, 1000], [3500, 1000], [3500, 2100], [1700, 2100], [1700, 1000]]] } },
  { "type": "Feature", "properties": { "name": "moor" }, "geometry": { "type": "Polygon", "coordinates":
    [[[0, 0], [100, 0], [100, 100], [0, 0]]] } }
] }"##;

fn try_build(option: &str) -> Result<Built, LoadError> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("city.rhai"), script(option)).expect("a script");
    fs::write(folder.path().join("districts.geojson"), DISTRICTS).expect("districts");
    try_folder(folder.path(), Until::Parcels)
}

fn built(option: &str) -> Built {
    faultless(try_build(option))
}

#[test]
fn a_quarter_that_is_not_there_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = script("rim: 100")
        .replace("city(#{", "city(#{ quarters: #{ \"0123456789abcdef0123456789abcdef\": #{ seed: 1 } },");
    fs::write(folder.path().join("city.rhai"), text).expect("a script");
    fs::write(folder.path().join("districts.geojson"), DISTRICTS).expect("districts");
    let built = faultless(try_folder(folder.path(), Until::Streets));
    let told = "`quarters` names quarter 0123456789abcdef0123456789abcdef, which is not there";
    assert!(built.report.warnings.iter().any(|warning| warning == told), "{:?}", built.report.warnings);
}

fn city_of(option: &str) -> City {
    (*built(option).city).clone()
}

/// Both ends of all minors, in metres.
fn minors(city: &City) -> Vec<[Vec2; 2]> {
    let segments = city.graph.segments_unsorted().filter(|(_, segment)| segment.class() == Classes::MINOR);
    segments.map(|(key, _)| city.graph.line(key.forward())).map(|(a, b)| [a.metres(), b.metres()]).collect()
}

/// Metres of minors in the western, middle and eastern quarter, and outside.
fn metres(city: &City) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for [a, b] in minors(city) {
        let middle = (a + b) / 2.0;
        let is_inside = middle.cmpgt(Vec2::splat(1050.0)).all() && middle.cmplt(Vec2::new(2550.0, 2050.0)).all();
        let part = if is_inside { ((middle.x - 1050.0) / 500.0) as usize } else { 3 };
        sums[part] += a.distance(b);
    }
    sums
}

/// What lies in a part of the plane, as text: parcels, and minors with their ids.
fn things(city: &City, from: f64, to: f64) -> Vec<String> {
    let is_in = |at: Vec2| at.x > from && at.x < to && at.y > 1060.0 && at.y < 2040.0;
    let mut all: Vec<String> = city
        .parcels
        .iter()
        .filter(|parcel| parcel.polygon.outer.iter().all(|corner| is_in(corner.metres())))
        .map(|parcel| format!("{parcel:?}"))
        .collect();
    for run in city.runs.iter().filter(|run| run.class == Classes::MINOR) {
        let points: Vec<Vec2> = run.nodes.iter().map(|&node| city.graph.at(node).metres()).collect();
        if points.iter().all(|&point| is_in(point)) {
            all.push(format!("{} {points:?}", run.id));
        }
    }
    all.sort();
    all
}

#[test]
fn only_chosen_quarters_are_filled() {
    let whole = metres(&city_of(""));
    assert!(whole.iter().all(|&length| length > 3000.0), "{whole:?}");
    for (option, filled) in [
        ("within: quarters_at([[1200, 1900], [1300, 1100]])", [true, false, false]),
        ("within: quarters_at([[1200, 1900], [2300, 1900]])", [true, false, true]),
        ("within: quarters_in(\"harbour\")", [false, true, true]),
    ] {
        let found = metres(&city_of(option));
        for (part, is_filled) in filled.into_iter().enumerate() {
            let about = if is_filled { 0.9 * whole[part]..1.1 * whole[part] } else { 0.0..1.0 };
            assert!(about.contains(&found[part]), "{option}: {found:?} of {whole:?}");
        }
        assert_eq!(found[3], 0.0, "{option}: nothing outside");
    }
}

#[test]
fn quarters_that_are_not_chosen_know_nothing_of_those_that_are() {
    let (none, west) =
        (city_of("within: quarters_at([[2300, 1900]])"), city_of("within: quarters_at([[1200, 1900], [2300, 1900]])"));
    let empty = |city: &City| things(city, 1560.0, 2040.0);
    assert_eq!(empty(&none), empty(&west));
    // What grows in the eastern quarter is the same too, and so is what grows there when all are filled: away from the
    // majors, where streets of both sides are led together.
    let east = |city: &City| things(city, 2200.0, 2540.0);
    assert!(east(&none).len() > 50);
    assert_eq!(east(&none), east(&west));
    assert_eq!(east(&none), east(&city_of("within: quarters_in(\"harbour\")")));
}

#[test]
fn a_choice_that_meets_nothing_is_told() {
    let warns = |option: &str, word: &str| {
        let warnings = built(option).report.warnings;
        assert!(warnings.iter().any(|warning| warning.contains(word)), "{warnings:?}");
    };
    warns("within: quarters_at([[1200, 1900], [20, 30]])", "no quarter lies at [20, 30]");
    warns("within: quarters_in([\"harbour\", \"moor\"])", "no quarter has its middle in the district `moor`");
    let error = try_build("within: quarters_in(\"habour\")").expect_err("unknown").to_string();
    assert!(error.contains("minors.within differs in `habour`") && error.contains("harbour"), "{error}");
}

#[test]
fn streets_stay_inside_a_polygon() {
    let corners = [[1200.0, 900.0], [2400.0, 1500.0], [1900.0, 2300.0]].map(Vec2::from_array);
    let list = "[[1200, 900], [2400, 1500], [1900, 2300]]";
    let city = city_of(&format!("within: {list}"));
    assert!(minors(&city).len() > 50);
    let outside = |at: Vec2| {
        let side = |i: usize| (corners[(i + 1) % 3] - corners[i]).normalize().perp_dot(at - corners[i]);
        (0..3).map(side).fold(f64::INFINITY, f64::min)
    };
    let farthest = minors(&city).into_iter().flatten().map(outside).fold(f64::INFINITY, f64::min);
    assert!(farthest > -0.01, "{farthest}");
    let word = city_of(&format!("within: polygon({list})"));
    assert!(minors(&word) == minors(&city));
}

#[test]
fn a_rim_bounds_what_grows_outside() {
    let away = |at: Vec2| {
        let (low, high) = (Vec2::splat(1050.0), Vec2::new(2550.0, 2050.0));
        (low - at).max(at - high).max(Vec2::ZERO).length()
    };
    let farthest = |city: &City| minors(city).into_iter().flatten().map(away).fold(0.0, f64::max);
    let (all, rim, none) = (city_of(""), city_of("rim: 300"), city_of("rim: 0"));
    assert!(farthest(&all) > 900.0 && metres(&none)[3] == 0.0);
    assert!((200.0..=300.0).contains(&farthest(&rim)), "{}", farthest(&rim));
    assert!(metres(&rim)[3] > 3000.0 && metres(&rim)[3] < 0.5 * metres(&all)[3]);
    let inside = |city: &City| metres(city)[..3].to_vec();
    assert_eq!((inside(&all), inside(&none)), (inside(&rim), inside(&rim)), "quarters are filled alike");
    let bulged = city_of("rim: #{ width: 300, bulge: 0.6 }");
    assert!(metres(&bulged)[3] < 0.95 * metres(&rim)[3] && metres(&bulged)[3] > 0.2 * metres(&rim)[3]);
}
