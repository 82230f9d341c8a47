//! What a rule writer sees while looking at single things: `--trace`, `mark(x, y)`; and the library that a city keeps to.

use crate::common::command::{place, plat};
use city::export::map::Colouring;
use city::{Cancel, Settings, Silent, build, load};
use serde_json::Value;
use std::fs;
use std::path::Path;

const CITY: &str = "library(1);\ncity(#{ site: site(#{ size: [500, 500] }), minors: streets(#{ pattern: rule(\"mine\") }), \
                    parcels: rule(\"parcels/recursive\") });\n";
const RULE: &str = "//! Mine.\nfn propose(tip, p) {\n    if tip.age == 1 { mark(tip.x, tip.y); }\n    if tip.age == 2 { mark(tip.peak()); }\n    \
                    tip.steer(cross(10));\n    tip.fork(90, 90);\n}\n";

fn read(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(name)).expect("a file")).expect("JSON")
}

#[test]
fn a_thing_is_traced_by_its_id() {
    let place = place(&[("city.rhai", CITY), ("mine.rhai", RULE)]);
    assert!(plat(place.path(), &["build", ".", "--quiet"]).status.success());
    let layout = read(place.path(), "out/layout.geojson");
    let features = layout["features"].as_array().expect("features");
    for (kind, words) in [("street", "It grew"), ("parcel", "parcels/recursive"), ("block", "By these rules")] {
        let of_kind = features.iter().find(|feature| feature["properties"]["kind"] == kind).expect("one of each");
        let id = of_kind["properties"]["id"].as_str().expect("an id");
        let output = plat(place.path(), &["build", ".", "--quiet", "--trace", id]);
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && told.starts_with(&format!("{kind} {id}")) && told.contains(words), "{told}");
    }
    let output = plat(place.path(), &["build", ".", "--quiet", "--trace", "zz"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}

#[test]
fn marks_of_rules_stand_in_the_report_and_on_the_map() {
    let place = place(&[("city.rhai", CITY), ("mine.rhai", RULE)]);
    assert!(plat(place.path(), &["build", ".", "--quiet", "--threads", "1"]).status.success());
    let report = read(place.path(), "out/report.json");
    let marks = report["marks"].as_array().expect("marks");
    assert!(
        marks.len() > 3
            && marks.iter().all(|mark| mark["rule"].as_str().is_some_and(|rule| rule.ends_with("mine.rhai")))
    );
    // Without people the middle of the site is their centre.
    assert!(marks.iter().any(|mark| mark["place"] == serde_json::json!([250.0, 250.0])), "{report}");
    let map = fs::read_to_string(place.path().join("out/map.svg")).expect("a map");
    assert!(map.matches(">mine<").count() >= marks.len(), "each is drawn with its rule's name");
    assert!(plat(place.path(), &["build", ".", "--quiet", "--threads", "2", "-o", "two"]).status.success());
    assert_eq!(read(place.path(), "two/report.json")["marks"], report["marks"]);
}

#[test]
fn of_very_many_marks_the_map_shows_some_of_everywhere() {
    let rule = RULE.replace("if tip.age == 1 { mark(tip.x, tip.y); }", "for i in 0..40 { mark(tip.x + i, tip.y); }");
    let place = place(&[("city.rhai", CITY), ("mine.rhai", &rule)]);
    let output = plat(place.path(), &["build", ".", "--no-cache"]);
    let report = read(place.path(), "out/report.json");
    let (count, told) = (report["marks"].as_array().expect("marks").len(), String::from_utf8_lossy(&output.stderr));
    assert!(
        count > 400 && told.contains(&format!("{count} places, in report.json and on the map; the map shows 200")),
        "{told}"
    );
    let map = fs::read_to_string(place.path().join("out/map.svg")).expect("a map");
    let labels: Vec<f64> = map
        .match_indices(">mine<")
        .filter_map(|(at, _)| map[..at].rsplit("x=\"").next()?.split('"').next()?.parse().ok())
        .collect();
    let (low, high) = labels.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    assert!(labels.len() >= 200 && high - low > 500.0, "{labels:?}");
}

#[test]
fn a_library_is_chosen_first_and_must_be_there() {
    for (text, words) in [
        ("library(9);\n", "this program has no version 9 of the library"),
        ("let r = rule(\"streets/grid\");\nlibrary(1);\n", "stands before the first rule(…)"),
        ("library(1);\nlibrary(1);\n", "library(…) is called twice"),
    ] {
        let city = format!("{text}{}", CITY.replace("library(1);\n", ""));
        let place = place(&[("city.rhai", &city), ("mine.rhai", RULE)]);
        let output = plat(place.path(), &["check", "."]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && told.contains(words), "{told}");
    }
}

#[test]
fn a_part_of_a_city_is_what_the_whole_has_there() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/lattice");
    let sources = load(&folder, None).unwrap().read().unwrap();
    let built = |settings| build(&sources, settings, &Silent, &Cancel::default()).unwrap().city;
    let whole = built(Settings::default());
    let middle = whole.blocks[whole.blocks.len() / 2].polygon.bounds().unwrap();
    let within = middle.grown(400 * 1024);
    let part = built(Settings { within: Some(within), ..Settings::default() });
    assert_eq!(part.graph.digest(), whole.graph.digest(), "all streets are there");
    assert!(part.buildings.len() > 20 && part.buildings.len() * 2 < whole.buildings.len(), "{}", part.buildings.len());
    // Nothing is there that the whole has not, and nothing is missing that reaches into it.
    let reaches = |polygon: &geom::Polygon| polygon.bounds().is_some_and(|bounds| bounds.overlaps(&within));
    let blocks: Vec<_> = whole.blocks.iter().filter(|block| reaches(&block.polygon)).collect();
    assert_eq!(part.blocks.iter().collect::<Vec<_>>(), blocks);
    let is_there = |parcel: &&layout::Parcel| blocks.iter().any(|block| block.id == parcel.block);
    let parcels: Vec<_> = whole.parcels.iter().filter(is_there).collect();
    assert_eq!(part.parcels.iter().collect::<Vec<_>>(), parcels);
    let stands = |building: &&buildings::Building| parcels.iter().any(|parcel| parcel.id == building.parcel);
    assert_eq!(part.buildings.iter().collect::<Vec<_>>(), whole.buildings.iter().filter(stands).collect::<Vec<_>>());
}

#[test]
fn streets_are_coloured_by_the_step_in_which_they_grew() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/lattice");
    let sources = load(&folder, None).unwrap().read().unwrap();
    let settings = Settings { traces: true, ..Settings::default() };
    let built = build(&sources, settings, &Silent, &Cancel::default()).unwrap();
    let (city, trace) = (&built.city, built.trace.as_ref().unwrap());
    let colouring = Colouring::of_growth(city, trace);
    let given = trace.given().streets();
    let last = colouring.entries.len() - 1;
    assert_eq!(colouring.entries[last].name, "given");
    // The last step of an entry: `steps 1 – 5`.
    let until = |entry: usize| -> u32 { colouring.entries[entry].name.rsplit(' ').next().unwrap().parse().unwrap() };
    let grown: Vec<_> = (0..last).map(|entry| trace.after(until(entry)).streets()).collect();
    let mut used = std::collections::BTreeSet::new();
    for (run, stretches) in city.runs.iter().zip(&colouring.stretches) {
        let entry = stretches[0].entry;
        used.insert(entry);
        assert_eq!(entry == last, given.contains(&run.street), "{run:?}");
        assert!(entry == last || grown[entry].contains(&run.street), "not there by step {}", until(entry));
    }
    assert!(used.len() > 3, "{used:?}");
}
