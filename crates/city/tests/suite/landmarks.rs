//! Landmarks, from the script to the finished city.

use crate::common::build::faultless;
use crate::common::build::try_build as try_folder;
use city::export::{geojson, layout_file, map};
use city::{Built, Cache, City, LoadError, Until, validate};
use geom::predicates::meets;
use geom::{Point, Polygon, Vec2};
use layout::Use;
use std::fs;
use std::path::Path;
use streets::Classes;

/// One quarter of 1100 m × 900 m filled with a grid, and landmarks.
fn quarter(landmarks: &str) -> String {
    format!(
        r##"city(#{{
    site: site(#{{ size: [1300, 1100] }}),
    landmarks: {landmarks},
    given: [line([[100, 100], [1200, 100], [1200, 1000], [100, 1000], [100, 100]])],
    minors: streets(#{{ pattern: rule("streets/grid", #{{ heading: 0, block_length: 180, block_width: 90 }}) }}),
    parcels: rule("parcels/recursive"),
    buildings: rule("mine"),
}});"##
    )
}

/// Raises everything by its name.
const BUILDING: &str = r##"
fn build(shape, p) { shape.extrude(if shape.landmark == "" { 9 } else { 30 + shape.landmark.len() }); }
"##;

fn place(script: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("city.rhai"), script).expect("a script");
    fs::write(folder.path().join("mine.rhai"), BUILDING).expect("a rule");
    folder
}

fn try_build(script: &str) -> Result<Built, LoadError> {
    try_folder(place(script).path(), Until::Buildings)
}

fn built(script: &str) -> Built {
    faultless(try_build(script))
}

fn city_of(script: &str) -> City {
    (*built(script).city).clone()
}

/// The layout as text, which breaks nothing of the contract.
fn layout(city: &City) -> String {
    let mut bytes = Vec::new();
    geojson::write_layout(city, &mut bytes).expect("written");
    let file = layout_file::parse_layout(&bytes, Path::new("layout.geojson")).expect("a layout");
    let found = validate::check(&file, Until::Buildings);
    assert!(found.violations.is_empty(), "{:?}", found.violations);
    String::from_utf8(bytes).expect("text")
}

fn crosses(city: &City, ground: &Polygon) -> bool {
    let mut lines = city.graph.segments_unsorted().map(|(key, _)| city.graph.line(key.forward()));
    let meets_ground = |(a, b): (Point, Point)| ground.contains(a) || ground.edges().any(|(c, d)| meets(a, b, c, d));
    lines.any(meets_ground)
}

const TWO: &str = r##"[
    landmark(#{ name: "Stadium", at: [520, 480], size: [180, 130], heading: 25 }),
    landmark(#{ name: "Church", outline: [[840, 700], [900, 690], [910, 760], [850, 770]], parcel: "built" }),
]"##;

#[test]
fn ground_stays_free_and_becomes_one_parcel() {
    let city = city_of(&quarter(TWO));
    let plain = city_of(&quarter("[]"));
    assert_eq!(city.landmarks.len(), 2);
    for landmark in &city.landmarks {
        assert!(crosses(&plain, &landmark.ground), "without it there would be streets");
        assert!(!crosses(&city, &landmark.ground), "{}", landmark.name);
        let [parcel] = landmark.parcels.as_slice() else { panic!("{:?}", landmark.parcels) };
        let parcel = city.parcels.iter().find(|other| other.id == *parcel).expect("its parcel");
        assert!((parcel.polygon.area() - landmark.ground.area()).abs() < 1.0, "all of it, {}", parcel.polygon.area());
        let built: Vec<f64> = city
            .buildings
            .iter()
            .filter(|building| building.parcel == parcel.id)
            .map(|building| building.height)
            .collect();
        match landmark.name.as_str() {
            "Church" => assert_eq!((parcel.usage, built), (Use::Built, vec![36.0]), "the rule knows it"),
            _ => assert_eq!((parcel.usage, built), (Use::Plaza, Vec::new())),
        }
    }
    assert!(plain.landmarks.is_empty() && plain.buildings.iter().all(|building| building.height == 9.0));
}

#[test]
fn layouts_and_maps_show_landmarks_by_name() {
    let city = city_of(&quarter(TWO));
    let text = layout(&city);
    let of =
        |kind: &str| text.lines().filter(|line| line.contains(kind) && line.contains("\"name\":\"Stadium\"")).count();
    assert_eq!((of("\"kind\":\"landmark\""), of("\"kind\":\"parcel\"")), (1, 1));
    let svg = |city: &City| {
        let mut out = Vec::new();
        map::write_svg(city, &map::MapOptions::default(), &Cache::none(), &mut out).expect("drawn");
        String::from_utf8(out).expect("text")
    };
    assert!(svg(&city).contains("Stadium") && svg(&city).contains("id=\"landmarks\""));
    assert!(!svg(&city_of(&quarter("[]"))).contains("landmarks"), "nothing where there is none");
}

#[test]
fn ids_hang_on_the_name_alone() {
    let ids = |landmarks: &str| {
        let city = city_of(&quarter(landmarks));
        let of = |landmark: &city::Landmark| (landmark.name.clone(), landmark.id, landmark.parcels.clone());
        city.landmarks.iter().map(of).collect::<Vec<_>>()
    };
    let alone = ids(r##"landmark(#{ name: "Stadium", at: [700, 300], size: 90 })"##);
    assert!(ids(TWO).contains(&alone[0]), "moved, and another beside it: {alone:?}");
}

#[test]
fn a_street_around_it_makes_it_a_block() {
    let city = city_of(&quarter(
        r##"landmark(#{ name: "Square", at: [600, 520], size: [150, 100], heading: 12, around: "minor", parcel: "park" })"##,
    ));
    layout(&city);
    let landmark = &city.landmarks[0];
    let parcel = city.parcels.iter().find(|parcel| parcel.id == landmark.parcels[0]).expect("its parcel");
    assert!(!parcel.access.is_empty() && parcel.usage == Use::Park);
    assert_eq!(city.parcels.iter().filter(|other| other.block == parcel.block).count(), 1, "nothing else in its block");
    assert!((parcel.polygon.area() - 15_000.0).abs() < 5.0, "{}", parcel.polygon.area());
    let side = |key: &streets::NodeKey| {
        let own = |claims: &[streets::Claim]| claims.iter().any(|claim| city.street_names.contains_key(&claim.street));
        city.graph.halves_ccw(*key).iter().filter(|arm| !own(city.graph.segment(arm.segment()).claims())).count()
    };
    let ring = city.runs.iter().filter(|run| city.street_names.get(&run.street).is_some_and(|name| name == "Square"));
    let met: usize = ring.flat_map(|run| run.nodes.iter()).map(side).sum();
    assert!(met >= 4, "streets lead to it: {met}");
}

#[test]
fn streets_that_were_there_are_named_and_cut_the_ground() {
    let script = quarter(TWO).replace(
        "given: [",
        r##"given: [line([[100, 500], [1200, 500]], #{ class: "minor", width: 12, name: "Old Lane" }), "##,
    );
    let built = built(&script);
    let said = |word: &str| built.report.warnings.iter().any(|warning| warning.contains(word));
    assert!(said("`Old Lane` crosses the ground of landmark `Stadium`"), "{:?}", built.report.warnings);
    assert!(said("landmark `Stadium` is cut into 2 parcels"), "{:?}", built.report.warnings);
    layout(&built.city);
}

/// Majors where people live, in the south-west, with a landmark far away.
fn majors(attract: f64) -> City {
    let script = format!(
        r##"
let site = site("maps");
city(#{{
    site: site,
    landmarks: [landmark(#{{ name: "Fort", at: [5200, 5300], size: 200, attract: {attract} }})],
    majors: streets(#{{
        pattern: rule("streets/organic", #{{ length: 400 }}),
        goals: density(site.map("density"), #{{ least: 400 }}),
    }}),
}});"##
    );
    let folder = place(&script);
    let maps = folder.path().join("maps");
    fs::create_dir(&maps).expect("a folder");
    let density = image::GrayImage::from_fn(60, 60, |x, y| image::Luma([if x < 25 && y > 35 { 200 } else { 0 }]));
    density.save(maps.join("density.png")).expect("a picture");
    fs::write(maps.join("density.json"), "{\"pixel_size_m\": 100, \"value\": {\"scale\": 20}}").expect("a sidecar");
    (*faultless(try_folder(folder.path(), Until::Streets)).city).clone()
}

/// How near the streets of a class come to a place, metres.
fn nearest(city: &City, at: Vec2) -> f64 {
    let lines = city.graph.segments_unsorted().filter(|(_, segment)| segment.class() <= Classes::MAJOR);
    let distance = |(a, b): (Point, Point)| {
        let (a, way) = (a.metres(), b.metres() - a.metres());
        let share = ((at - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        at.distance(a + way * share)
    };
    lines.map(|(key, _)| distance(city.graph.line(key.forward()))).fold(f64::INFINITY, f64::min)
}

#[test]
fn majors_reach_what_attracts_them() {
    let at = Vec2::new(5200.0, 5300.0);
    let (drawn, ignored) = (nearest(&majors(1.0), at), nearest(&majors(0.0), at));
    assert!((100.0..270.0).contains(&drawn) && ignored > 2000.0, "{drawn} {ignored}");
}

#[test]
fn highways_turn_to_what_attracts_them() {
    let highways = |attract: f64| {
        city_of(&format!(
            r##"city(#{{
    site: site(#{{ size: [9000, 9000] }}),
    landmarks: [landmark(#{{ name: "Port", at: [7800, 6900], size: 300, attract: {attract}, reach: 2500 }})],
    highways: streets(#{{ pattern: rule("streets/highway", #{{ near: 300, radius: 9000, every: 0 }}), seeds: [[1200, 1500]] }}),
    majors: streets(#{{ pattern: rule("streets/grid"), seeds: [[1200, 1500]], reseed: 50000, within: polygon([[0, 0], [10, 0], [0, 10]]) }}),
}});"##
        ))
    };
    let at = Vec2::new(7800.0, 6900.0);
    let (drawn, ignored) = (nearest(&highways(3.0), at), nearest(&highways(0.0), at));
    assert!(drawn < 600.0 && drawn + 500.0 < ignored, "{drawn} {ignored}");
}

#[test]
fn landmarks_off_the_site_are_refused() {
    let script = quarter(r##"landmark(#{ name: "Lighthouse", at: [1290, 500] })"##);
    let error = try_build(&script).expect_err("it reaches over the rim").to_string();
    assert!(error.contains("landmark `Lighthouse` does not lie on the site"), "{error}");
    assert!(error.contains("[1300, 1100]"), "{error}");
}
