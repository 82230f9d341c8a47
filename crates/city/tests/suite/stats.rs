//! `plat stats`: the figures agree with those of an independent script, kept in `stats/expected.txt`.

use crate::common::check;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stats").join(name)
}

fn plat(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    command.current_dir(here("")).arg("stats").args(arguments).output().expect("plat runs")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

fn agree(ours: &Value, theirs: &Value) -> bool {
    match (ours, theirs) {
        (Value::Array(ours), Value::Array(theirs)) => {
            ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(ours, theirs)| agree(ours, theirs))
        }
        _ => match (ours.as_f64(), theirs.as_f64()) {
            (Some(ours), Some(theirs)) => (ours - theirs).abs() <= 1e-6 * theirs.abs(),
            _ => false,
        },
    }
}

#[test]
fn figures_agree_with_an_independent_script() {
    let expected = fs::read_to_string(here("expected.txt")).expect("the figures");
    let mut cases = 0;
    for line in expected.lines().filter(|line| !line.starts_with('#')) {
        let (asked, figures) = line.split_at(line.find('{').expect("figures"));
        let words: Vec<&str> = asked.split_whitespace().collect();
        let layout = format!("{}.geojson", words[0]);
        let maps = words[1..2].iter().filter(|maps| **maps != "-");
        let arguments: Vec<&str> =
            [&layout[..], "--json"].into_iter().chain(maps.copied()).chain(words[2..].iter().copied()).collect();
        let output = plat(&arguments);
        check(&output, 0, &[]);
        let (ours, theirs) = (json(&output), serde_json::from_str::<Value>(figures).expect("figures"));
        let (ours, theirs) = (ours.as_object().expect("an object"), theirs.as_object().expect("an object"));
        assert_eq!(ours.keys().collect::<Vec<_>>(), theirs.keys().collect::<Vec<_>>(), "{asked}");
        for (name, figure) in theirs {
            assert!(agree(&ours[name], figure), "{asked}: {name} is {}, not {figure}", ours[name]);
        }
        cases += 1;
    }
    assert!(cases >= 6);
}

/// A file of ranges for the town of the tests.
fn ranges(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ranges.json");
    fs::write(&path, text).expect("a file");
    let path = path.display().to_string();
    (folder, path)
}

#[test]
fn figures_are_held_against_ranges() {
    let good = r#"{"town": {"whole": {"order": [0.1, 1], "headings": [17, 107]},
                   "windows": {"centre": {"window": [300, 300, 1000, 1100], "x_share": [0, 1]}}}}"#;
    let (_folder, path) = ranges(good);
    let output = plat(&["hills.geojson", "maps", "--place", "town", "--ranges", &path]);
    check(&output, 0, &["town: 3 of 3 measures in the real range", "centre", "ok  order"]);
    let (_folder, path) = ranges(&good.replace("[0.1, 1]", "[0.99, 1]"));
    let output = plat(&["hills.geojson", "maps", "--place", "town", "--ranges", &path, "--json"]);
    check(&output, 1, &[]);
    let verdict = &json(&output)["place"];
    assert_eq!((verdict["good"].as_u64(), verdict["asked"].as_u64()), (Some(2), Some(3)));
    assert_eq!(verdict["judged"][0]["ok"], Value::Bool(false));
    // What cannot be measured is not in its range.
    let (_folder, path) = ranges(r#"{"town": {"whole": {"grade_p95": [0, 99]}}}"#);
    check(&plat(&["hills.geojson", "--place", "town", "--ranges", &path]), 1, &["OFF", "not measured"]);
}

#[test]
fn people_get_a_table_with_units() {
    let output = plat(&["drawn.geojson"]);
    check(&output, 0, &[]);
    insta::assert_snapshot!(String::from_utf8_lossy(&output.stdout));
}

#[test]
fn errors_name_what_to_do() {
    check(&plat(&["none.geojson"]), 3, &["none.geojson", "No such file"]);
    check(&plat(&["drawn.geojson", "no_maps"]), 3, &["no_maps", "hint"]);
    check(&plat(&["drawn.geojson", "maps", "--mask", "boro"]), 3, &["no map `boro`", "did you mean `borough`?"]);
    check(&plat(&["drawn.geojson", "--place", "town"]), 2, &["--ranges"]);
    check(&plat(&["drawn.geojson", "--mask", "land"]), 2, &["MAPS"]);
    check(&plat(&["drawn.geojson", "--window", "5,5,1,1"]), 2, &["north-east"]);
    check(&plat(&["drawn.geojson", "--window", "-9,-9,-8,-8"]), 1, &["nothing was measured"]);
    let (_folder, path) = ranges(r#"{"town": {"whole": {"order": [0.1, 1]}}}"#);
    check(&plat(&["drawn.geojson", "--place", "twon", "--ranges", &path]), 3, &["did you mean `town`?"]);
    check(&plat(&["drawn.geojson", "--place", "town", "--ranges", "none.json"]), 3, &["none.json", "hint"]);
}

#[test]
fn programs_get_errors_as_json_too() {
    let output = plat(&["drawn.geojson", "maps", "--mask", "boro", "--json"]);
    let error = &json(&output)["error"];
    assert_eq!(error["status"], 3);
    assert_eq!(error["hint"], "did you mean `borough`?");
    let output = plat(&["drawn.geojson", "--frobnicate", "--json"]);
    assert_eq!(json(&output)["error"]["status"], 2);
    for verb in ["build", "validate"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
        let output = command.args([verb, "no/such/thing", "--json"]).output().expect("plat runs");
        let error = &json(&output)["error"];
        assert_eq!(error["status"].as_i64(), output.status.code().map(i64::from), "{verb}");
        assert!(error["message"].as_str().expect("a message").contains("no/such/thing"), "{verb}");
    }
}
