//! `plat test`: tests of rules as their writers run them.

use crate::common::command::{place, plat, write};
use serde_json::Value;
use std::fs;
use std::path::Path;

const RULE: &str = "//! Mine.\nparams(#{ length: metres(80).range(20, 200).about(\"Piece\") });\n\
    fn propose(tip, p) {\n    if tip.age > 900 { tip.ahead(1); }\n    tip.steer(cross(0));\n    tip.fork(p.length, p.length);\n}\n";

/// Runs `plat test` and asserts the status; all that it told.
fn told(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = plat(folder, &[&["test"], arguments].concat());
    let told = String::from_utf8_lossy(&output.stdout).into_owned() + &*String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {told}");
    told
}

fn json(folder: &Path, arguments: &[&str], status: i32) -> Value {
    let output = plat(folder, &[&["test", "--json"], arguments].concat());
    assert_eq!(output.status.code(), Some(status), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON value")
}

#[test]
fn a_failed_claim_names_rule_line_and_measure() {
    let tests = "fn test_order() {\n    let town = grow(rule());\n    assert(town.order > 1.5);\n}\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    let told = told(place.path(), &["."], 1);
    for word in
        ["FAILED streets/mine: order", "mine.test.rhai:3:5", "this does not hold; order was ", "1 of 1 test failed"]
    {
        assert!(told.contains(word), "`{word}` is missing from: {told}");
    }
    let report = json(place.path(), &["streets/mine.rhai"], 1);
    let ran = &report["tests"][0];
    assert_eq!((ran["passed"].as_bool(), ran["fault"]["line"].as_u64()), (Some(false), Some(3)), "{ran}");
}

#[test]
fn snapshots_are_new_then_accepted_then_differ() {
    let tests = "fn test_town() { snapshot(grow(rule())); }\nfn test_params() { snapshot(rule()); }\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    let snap = |name: &str| place.path().join(format!("streets/snapshots/mine.{name}"));
    assert!(told(place.path(), &["."], 1).contains("is new: --accept takes it over"));
    assert!(!snap("town.snap").exists(), "nothing is written unasked");
    assert!(told(place.path(), &[".", "--accept"], 0).contains("2 snapshots accepted"));
    assert!(snap("town.svg").exists() && !snap("params.svg").exists());
    told(place.path(), &["."], 0);
    write(place.path(), "streets/mine.rhai", &RULE.replace("metres(80)", "metres(90)"));
    let told_now = told(place.path(), &["."], 1);
    for word in ["- length = 80 m, 20 to 200: Piece", "+ length = 90 m, 20 to 200: Piece", "- km ", "+ km "] {
        assert!(told_now.contains(word), "`{word}` is missing from: {told_now}");
    }
    // What no test takes any more is told, and goes when accepted.
    fs::write(place.path().join("streets/mine.test.rhai"), "fn test_params() { snapshot(rule()); }\n")
        .expect("written");
    assert!(told(place.path(), &["."], 1).contains("mine.town.snap (--accept removes it)"));
    told(place.path(), &[".", "--accept"], 0);
    assert!(!snap("town.snap").exists() && !snap("town.svg").exists() && snap("params.snap").exists());
}

#[test]
fn a_test_that_fails_keeps_its_snapshots() {
    let tests = "fn test_town() { snapshot(rule()); }\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    told(place.path(), &[".", "--accept"], 0);
    for broken in ["fn test_town() { assert(false); snapshot(rule()); }\n", "fn test_town() { snapshot(rlue()); }\n"] {
        write(place.path(), "streets/mine.test.rhai", broken);
        let told = told(place.path(), &[".", "--accept"], 1);
        assert!(!told.contains("removes"), "{told}");
        assert!(place.path().join("streets/snapshots/mine.town.snap").exists());
    }
    write(place.path(), "streets/mine.test.rhai", tests);
    write(place.path(), "streets/mine.rhai", "fn propose(tip, p) { tip.ahaed(3); }");
    told(place.path(), &[".", "--accept"], 1);
    assert!(place.path().join("streets/snapshots/mine.town.snap").exists());
}

#[test]
fn the_simplest_trial_is_told_and_can_be_run_alone() {
    let tests = "fn test_wide(trial) {\n    let width = trial.draw(1, 10, 100);\n    assert(width < 30);\n}\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    let all = told(place.path(), &["."], 1);
    let trial = all.split("--trial \"").nth(1).and_then(|rest| rest.split('"').next()).expect("a trial");
    assert!(trial.starts_with("size=200 seed=") && !trial.contains("with="), "{trial}");
    told(place.path(), &[".", "--only", "wide", "--trial", trial], 1);
    told(place.path(), &[".", "--trial", "size=200 seed=0 1=12"], 0);
    told(place.path(), &[".", "--trial", "moon=1"], 2);
}

#[test]
fn tests_may_stand_in_the_rule_and_are_no_part_of_it() {
    let own = "fn test_one() {\n    let least = 79;\n    let tips = [rule().propose(#{})].filter(|tip| tip.ahead.length > least);\n    assert_eq!(1, 1);\n}\n";
    let own = own.replace("assert_eq!(1, 1)", "assert_eq(tips.len(), 1)");
    let city = "city(#{ site: site(#{ size: [400, 400] }), minors: streets(#{ pattern: rule(\"streets/mine\") }) });\n";
    let place = place(&[("streets/mine.rhai", &format!("{RULE}{own}")), ("city.rhai", city)]);
    told(place.path(), &["streets/mine.rhai"], 0);
    assert_eq!(plat(place.path(), &["check", "."]).status.code(), Some(0));
    assert_eq!(plat(place.path(), &["build", ".", "--until", "streets", "--quiet"]).status.code(), Some(0));
}

#[test]
fn coverage_names_branches_that_no_test_reaches() {
    let tests = "fn test_one() { assert(rule().propose(#{ age: 2 }).ahead != ()); }\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    let told = told(place.path(), &[".", "--coverage"], 0);
    assert!(told.contains("2 of 3 branches reached") && told.contains("mine.rhai:4:22: if is never run"), "{told}");
    let report = json(place.path(), &[".", "--coverage"], 0);
    assert_eq!(report["coverage"][0]["branches"].as_array().map(Vec::len), Some(3));
}

#[test]
fn faults_of_rules_are_told_where_they_are() {
    let failing = RULE.replace("tip.steer(cross(0));", "print(\"at \" + tip.age);\n    tip.steer(cross(1 / 0));");
    let tests = "fn test_asked() { rule().propose(#{ age: 7 }); }\nfn test_grown() { grow(rule()); }\nfn test_other() { assert(true); }\n";
    let place = place(&[("streets/mine.rhai", &failing), ("streets/mine.test.rhai", tests)]);
    let told = told(place.path(), &["."], 1);
    assert_eq!(told.matches("division by zero: 1 / 0").count(), 2, "{told}");
    assert!(told.contains("mine.rhai:6:") && told.contains("at 7") && told.contains("2 of 3 tests failed"), "{told}");
}

#[test]
fn the_element_of_which_a_claim_does_not_hold_is_told() {
    let tests = "fn test_all() {\n    let most = 2;\n    assert_all([1, 2], |n| n <= most);\n    assert_all([1, 3, 4], |n| n <= most);\n}\n";
    let place = place(&[("streets/mine.rhai", RULE), ("streets/mine.test.rhai", tests)]);
    let told = told(place.path(), &["."], 1);
    assert!(told.contains("this does not hold of 3") && told.contains("mine.test.rhai:4:5"), "{told}");
}

#[test]
fn nothing_to_run_is_told() {
    let place = place(&[("streets/mine.rhai", RULE), ("streets/other.test.rhai", "fn helper() { }\n")]);
    assert!(told(place.path(), &["streets/mine.rhai"], 2).contains("there are no tests"));
    assert!(told(place.path(), &["streets/other.test.rhai"], 1).contains("there is no test in this file"));
    assert!(told(place.path(), &["nowhere"], 2).contains("nowhere"));
    told(place.path(), &[], 2);
    told(place.path(), &[".", "--trials", "0"], 2);
    let missing = "fn test_x() { rule(); }\n";
    write(place.path(), "streets/other.test.rhai", missing);
    assert!(told(place.path(), &["streets/other.test.rhai"], 1).contains("there is no rule of that name"));
    assert!(told(place.path(), &[".", "--only", "zzz"], 2).contains("no test is called `zzz`"));
}
