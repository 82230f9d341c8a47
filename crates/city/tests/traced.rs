//! What a rule writer sees while looking at single things: `--trace`, `mark(x, y)`; and the library that a city keeps to.

#[path = "common/command.rs"]
mod common;

use common::{place, plat};
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
fn a_library_is_chosen_first_and_must_be_there() {
    for (text, words) in [
        ("library(9);\n", "this program has no version 9 of the library"),
        ("let r = rule(\"streets/grid\");\nlibrary(1);\n", "stands before the first rule(…)"),
    ] {
        let city = format!("{text}{}", CITY.replace("library(1);\n", ""));
        let place = place(&[("city.rhai", &city), ("mine.rhai", RULE)]);
        let output = plat(place.path(), &["check", "."]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && told.contains(words), "{told}");
    }
}
