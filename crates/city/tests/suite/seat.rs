//! What rule writers work with beside the build: `plat check`, `plat rules`, `plat new`.

use crate::common::check;
use crate::common::command::{place, plat, write};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs and asserts the status; what it printed.
fn expect(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = plat(folder, arguments);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {told}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(folder: &Path, arguments: &[&str], status: i32) -> Value {
    serde_json::from_str(&expect(folder, arguments, status)).expect("one JSON value")
}

/// File and place of each fault of a report.
fn spots(report: &Value) -> Vec<String> {
    let faults = report["faults"].as_array().expect("a list").iter();
    faults.map(|f| format!("{} {}:{}:{}", f["severity"], f["file"], f["line"], f["column"]).replace('"', "")).collect()
}

const KINDS: [&str; 7] = ["streets", "goals", "constraints", "constrain", "parcels", "assign", "buildings"];

#[test]
fn new_things_are_sound_and_work() {
    let place = place(&[]);
    expect(place.path(), &["new", "city", "town"], 0);
    for kind in KINDS {
        expect(place.path(), &["new", "rule", kind, &format!("my_{kind}"), "--in", "town"], 0);
    }
    let report = json(place.path(), &["check", "town", "--json"], 0);
    assert_eq!((report["files"].as_u64(), spots(&report).len()), (Some(15), 0), "{report}");
    let tested = json(place.path(), &["test", "town", "--json"], 0);
    assert_eq!(tested["tests"].as_array().map(Vec::len), Some(14), "{tested}");
    // The city as it stands, smaller; then the same with every new rule in its place.
    let script = fs::read_to_string(place.path().join("town/city.rhai")).expect("a script");
    let small = script.replace("[3000, 3000]", "[900, 900]");
    assert_ne!(small, script);
    let own = small
        .replace("streets/grid\", #{ heading: 15, block_length: 160, block_width: 80 }", "streets/my_streets\"")
        .replace("constraints: rule(\"constraints/standard\", #{ snap: 60 }),", "constraints: rule(\"constraints/my_constraints\"),")
        .replace("        width: 14,", "        constraints: [rule(\"constraints/standard\"), rule(\"constraints/my_constrain\")],\n        width: 14,")
        .replace("parcels/recursive", "parcels/my_parcels")
        .replace("buildings/extruded\", #{ high: 12 }", "buildings/my_buildings\"");
    for (name, text, rules) in [("start", &small, 0), ("own", &own, 5)] {
        write(place.path(), "town/city.rhai", text);
        let uses = text.matches("my_").count();
        assert_eq!(uses, rules, "{name}: {text}");
        let built = json(place.path(), &["build", "town", "-o", name, "--json"], 0);
        let count = |what: &str| built["report"]["counts"][what].as_u64().unwrap_or(0);
        assert!(count("streets") > 50 && count("buildings") > 100, "{name}: {}", built["report"]["counts"]);
    }
}

#[test]
fn what_a_rule_asks_of_others_is_checked() {
    let place = place(&[
        ("streets/lib.rhai", "fn twice(x) { 2 * x }\n"),
        (
            "streets/a.rhai",
            "import \"streets/lib\" as lib;\nconst MOST = 3;\nfn propose(tip, p) {\n    tip.ahead(lib::twice(30, 4));\n    \
             tip.branch_left(lib::twise(global::MOTS));\n    if tip.age > global::MOST { import \"streets/none\" as n; \
             tip.ahead(n::f()); }\n    tip.branch_right(lib::twice(9));\n}\n",
        ),
        ("streets/b.rhai", "fn propose(tip, p) { tip.ahead(80); }\nfn test_two(trial, n) { assert(true); }\n"),
    ]);
    let report = json(place.path(), &["check", ".", "--json"], 1);
    let wanted = ["a.rhai:4:20", "a.rhai:5:26", "a.rhai:5:40", "a.rhai:6:40", "b.rhai:2:4"];
    assert_eq!(spots(&report), wanted.map(|place| format!("error ./streets/{place}")), "{report}");
    assert!(report["faults"].as_array().expect("a list").iter().all(|fault| fault["hint"].is_string()), "{report}");
}

#[test]
fn a_word_that_is_not_there_has_one_like_it() {
    let place = place(&[]);
    assert!(expect(place.path(), &["words", "ahead"], 0).contains("tip.ahead(80)"));
    check(&plat(place.path(), &["words", "ahaed"]), 2, &["did you mean `ahead`?"]);
    check(&plat(place.path(), &["words", "zzzzzz"]), 2, &["plat words lists all"]);
}

#[test]
fn one_mistake_hides_no_other_in_the_same_file() {
    let place = place(&[]);
    let rule = "params(#{ most: number(3).range(1, 9).about(\"Most\") });\n\
                fn propose(tip, p) {\n    tip.ahaed(80);\n    let a = hypot(1);\n    let b = tip.headng;\n    \
                tip.ahead(a + b + p.most);\n}\n";
    write(place.path(), "own/streets/one.rhai", rule);
    let told = |status| spots(&json(place.path(), &["check", "own", "--json"], status)).join(" ");
    let all = ["one.rhai:3:", "one.rhai:4:", "one.rhai:5:"];
    assert!(all.iter().all(|at| told(1).contains(at)), "{}", told(1));
    // Neither a parameter that cannot be declared nor a variable that nobody knows hides what is below.
    for broken in [rule.replace("number(3)", "number(33)"), rule.replace("a + b", "a + b + c")] {
        write(place.path(), "own/streets/one.rhai", &broken);
        assert!(all.iter().all(|at| told(1).contains(at)), "{}", told(1));
        let first = if broken.contains("number(33)") { "one.rhai:1:" } else { "one.rhai:6:" };
        assert!(told(1).contains(first), "{first}: {}", told(1));
    }
}

#[test]
fn what_cannot_be_read_hides_nothing_else() {
    let place = place(&[]);
    write(place.path(), "all/streets/one.rhai", "fn propose(tip, p) { tip.ahaed(80); }\n");
    write(place.path(), "all/streets/two.rhai", "fn propose(tip, p) {\n    tip.ahead(80;\n}\n");
    fs::write(place.path().join("all/streets/bytes.rhai"), [0xff, 0xfe, 0x00]).expect("a file");
    #[cfg(unix)]
    std::os::unix::fs::symlink("nowhere.rhai", place.path().join("all/streets/link.rhai")).expect("a link");
    let report = json(place.path(), &["check", "all", "--json"], 1);
    let told = spots(&report).join(" ");
    for file in ["one.rhai:1:", "two.rhai:2:", "bytes.rhai:0:", "link.rhai:0:"] {
        assert!(told.contains(file) || (cfg!(not(unix)) && file.starts_with("link")), "{file}: {told}");
    }
    let hints = report.to_string();
    assert!(hints.contains("UTF-8 text") && hints.contains("link to a file that is not there"), "{hints}");
}

#[test]
fn new_never_writes_over_and_takes_plain_names_only() {
    let place = place(&[]);
    expect(place.path(), &["new", "rule", "streets", "mine"], 0);
    write(place.path(), "streets/mine.rhai", "// changed");
    expect(place.path(), &["new", "rule", "streets", "mine"], 2);
    assert_eq!(fs::read_to_string(place.path().join("streets/mine.rhai")).expect("a rule"), "// changed");
    for bad in ["../out", "a/b", "", ".hidden", "a b", "x\"y"] {
        expect(place.path(), &["new", "rule", "parcels", bad], 2);
        expect(place.path(), &["new", "city", bad], 2);
    }
    expect(place.path(), &["new", "rule", "roads", "mine"], 2);
    assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 1, "only streets/ was made");
}

#[test]
fn check_finds_everything_in_all_files_at_once() {
    let place = place(&[]);
    write(
        place.path(),
        "city.rhai",
        "let land = site(#{ size: [900, 900] });\n\
         city(#{\n    site: land,\n    majors: streets(#{ pattern: rule(\"streets/first\") }),\n    \
         minors: streets(#{ pattern: rule(\"streets/second\") }),\n    parcels: rule(\"parcels/thrid\"),\n    \
         buildings: rule(\"buildings/fourth\"),\n});\n",
    );
    write(place.path(), "streets/first.rhai", "fn propose(tip, p) {\n    tip.branch_lft(80);\n    tip.ahed(80);\n}\n");
    write(place.path(), "streets/second.rhai", "fn propose(tip, p) {\n    tip.ahead(80;\n}\n");
    write(place.path(), "parcels/third.rhai", "fn subdivide(block, p) { block.open(); }\n");
    let fourth = "params(#{ most: whole(3), least: whole(1), spare: whole(2) });\n\
                  fn build(shape, p) {\n    shape.extrude(p.most * 3, 1, 2);\n    shape.extrude(p.lest);\n    max(1);\n}\n";
    write(place.path(), "buildings/fourth.rhai", fourth);
    let tests = "fn test_names() {\n    let a = rule(\"parcels/thrid\");\n    let b = rule(#{ leest: 1 });\n    \
                 let c = rule(\"streets/grid\", #{ heading: 3, block_lenght: 90 });\n    assert(true);\n}\n";
    write(place.path(), "parcels/third.test.rhai", tests);
    let more =
        "fn test_all(trial, n) {\n    assert(true);\n}\nfn test_one() {\n    rule().subdivide(#{ aera: 1 });\n}\n";
    write(place.path(), "parcels/other.rhai", "fn subdivide(shape, p) {\n    shape.area = 3;\n    shape.open();\n}\n");
    write(place.path(), "parcels/other.test.rhai", more);
    // A file that others import decides nothing, and need not.
    write(place.path(), "streets/lib/lengths.rhai", "fn of(tip) {\n    tip.age * 80\n}\n");
    let report = json(place.path(), &["check", ".", "--json"], 1);
    let mut found = spots(&report);
    // What stopped the script comes first; the rest by file and place.
    assert_eq!(found[0], "error ./streets/first.rhai:2:9");
    found.sort();
    let wanted = [
        "error ./buildings/fourth.rhai:3:11",
        "error ./buildings/fourth.rhai:4:21",
        "error ./buildings/fourth.rhai:5:5",
        "error ./city.rhai:6:14",
        "error ./parcels/other.rhai:2:11",
        "error ./parcels/other.test.rhai:1:4",
        "error ./parcels/third.test.rhai:2:13",
        "error ./parcels/third.test.rhai:3:21",
        "error ./parcels/third.test.rhai:4:49",
        "error ./streets/first.rhai:2:9",
        "error ./streets/first.rhai:3:9",
        "error ./streets/second.rhai:2:17",
        "warning ./buildings/fourth.rhai:1:27",
        "warning ./buildings/fourth.rhai:1:44",
        "warning ./parcels/other.rhai:1:14",
    ];
    assert_eq!(found, wanted, "{report}");
    assert_eq!(report["files"], 9);
    for fault in report["faults"].as_array().expect("a list") {
        assert!(fault["hint"].is_string() && fault["length"].as_u64() > Some(0), "{fault}");
    }
    // A build tells the same errors, and writes nothing.
    let built = json(place.path(), &["build", ".", "-o", "out", "--json"], 3);
    let errors: Vec<Value> = built["error"]["faults"].as_array().expect("a list").clone();
    assert_eq!(errors.iter().filter(|fault| fault["severity"] == "error").count(), 7, "{built}");
    assert_eq!(fs::read_dir(place.path().join("out")).map_or(0, Iterator::count), 0);
}

#[test]
fn check_reads_maps_and_says_what_is_missing() {
    let place = place(&[]);
    write(
        place.path(),
        "city.rhai",
        "city(#{ site: site(#{ size: [900, 900] }), imported: [streets_from(\"no.osm\")] });\n",
    );
    let report = json(place.path(), &["check", "city.rhai", "--json"], 1);
    let fault = &report["faults"][0];
    assert!(fault["message"].as_str().is_some_and(|message| message.contains("no.osm")), "{report}");
    expect(place.path(), &["check", "nowhere"], 2);
    expect(place.path(), &["check"], 2);
    fs::create_dir(place.path().join("empty")).expect("made");
    expect(place.path(), &["check", "empty"], 2);
    fs::write(place.path().join("bytes.rhai"), [0xff, 0xfe, 0x00]).expect("written");
    expect(place.path(), &["check", "bytes.rhai"], 3);
}

#[test]
fn check_finds_saved_changes_that_do_not_suit_their_city() {
    let place = place(&[]);
    let script =
        "city(#{ site: site(#{ size: [900, 900] }), minors: streets(#{ pattern: rule(\"streets/grid\") }) });\n";
    write(place.path(), "city.rhai", script);
    write(
        place.path(),
        "city.changes",
        "plat-changes 1\nset minors.pattern.block_width=90\nset minors.pattern.block_wide=90\n",
    );
    let report = json(place.path(), &["check", "city.rhai", "--json"], 1);
    assert_eq!(spots(&report), ["error city.changes:3:1"], "{report}");
}

#[test]
fn a_rule_that_fails_in_a_test_is_shown_however_the_test_is_called() {
    let place = place(&[]);
    fs::create_dir(place.path().join("streets")).expect("made");
    write(place.path(), "streets/mine.rhai", "//! Mine.\nfn propose(tip, p) {\n    let one = [1];\n    one[4];\n}\n");
    write(place.path(), "streets/mine.test.rhai", "fn test_it() {\n    rule().propose(#{});\n}\n");
    for called in ["streets/mine.rhai", "streets/mine.test.rhai", "./streets/mine.rhai", "streets", "."] {
        let output = plat(place.path(), &["test", called]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains("streets/mine.rhai:4:9") && told.contains("one[4];"), "{called}: {told}");
    }
}

#[test]
fn what_a_name_stands_for_elsewhere_is_no_mistake() {
    let place = place(&[]);
    fs::create_dir_all(place.path().join("streets/lib")).expect("made");
    fs::create_dir_all(place.path().join("parcels")).expect("made");
    let rule = "params(#{ a: metres(80) });\n\
                fn most(list) { list.reduce(|most, shape| max(most, shape.width)) }\n\
                fn propose(tip, p) {\n    if tip.x > -1 { let tip = #{ k: 3 }; let z = tip.k; }\n    \
                { let p = #{ zz: 1 }; let z = p.zz; }\n    try { throw #{ k: 1 }; } catch (tip) { let z = tip.k; }\n    \
                for block in [#{ w: 3 }] { let z = block.w; }\n    tip.ahead(p.a);\n}\n";
    write(place.path(), "streets/mine.rhai", rule);
    let rule = "fn subdivide(block, p) {\n    let parts = [3, 4].map(|tip| tip + 1).filter(|p| p > 3);\n    \
                if block.has_map(\"zones\") && block.zone(\"zones\") > 1 { return block.open(); }\n    \
                block.recursive(#{ most_area: 100.0 * parts.len() });\n}\n";
    write(place.path(), "parcels/mine.rhai", rule);
    let city = "city(#{ site: site(#{ size: [300, 300] }), minors: streets(#{ pattern: rule(\"streets/mine\") }), parcels: rule(\"parcels/mine\") });";
    write(place.path(), "city.rhai", city);
    let report = json(place.path(), &["check", ".", "--json"], 0);
    assert_eq!(spots(&report), Vec::<String>::new(), "{report}");
    // Of what a helper is given only its name is known.
    let helper =
        "fn size(tip) {\n    tip.len() + tip.width\n}\nfn propose(tip, p) {\n    tip.ahead(size([1, 2]));\n}\n";
    write(place.path(), "streets/mine.rhai", helper);
    let report = json(place.path(), &["check", ".", "--json"], 0);
    assert_eq!(spots(&report), ["warning ./streets/mine.rhai:2:9"], "{report}");
}

#[test]
fn all_that_is_shipped_is_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let report = json(&root, &["check", "rules", "scripts", "--json"], 0);
    assert_eq!(spots(&report), Vec::<String>::new(), "{report}");
    assert!(report["files"].as_u64() > Some(25), "{report}");
}

#[test]
fn rules_are_listed_with_all_that_can_be_set() {
    let place = place(&[]);
    let all = json(place.path(), &["rules", "--json"], 0);
    let rules = all["rules"].as_array().expect("a list");
    assert!(rules.len() >= 16, "{} rules", rules.len());
    for rule in rules {
        assert!(rule["about"].as_str().is_some_and(|about| !about.is_empty()), "{rule}");
        for param in rule["params"].as_array().expect("a list") {
            assert!(param["about"].as_str().is_some_and(|about| !about.is_empty()), "{rule}: {param}");
            let is_number = ["number", "whole"].contains(&param["kind"].as_str().expect("a kind"));
            assert_eq!(is_number, param["range"].is_array(), "{param}");
        }
    }
    let grid = json(place.path(), &["rules", "streets/grid", "--json"], 0);
    let heading = &grid["rules"][0]["params"][0];
    assert_eq!((heading["name"].as_str(), heading["unit"].as_str()), (Some("heading"), Some("°")));
    assert_eq!((heading["default"].as_str(), &heading["range"]), (Some("-29"), &serde_json::json!([-90.0, 90.0])));
    expect(place.path(), &["rules", "streets/gird"], 2);
    // Rules of one's own are listed too, and a broken one does not hide the others.
    expect(place.path(), &["new", "rule", "parcels", "mine"], 0);
    write(place.path(), "parcels/broken.rhai", "fn subdivide(block, p) { block.opn(); }\n");
    let listed = json(place.path(), &["rules", "parcels/", "--rules", ".", "--json"], 1);
    let names: Vec<&str> =
        listed["rules"].as_array().expect("a list").iter().filter_map(|r| r["name"].as_str()).collect();
    assert_eq!(names, ["parcels/mine", "parcels/recursive", "parcels/zoned"]);
    assert_eq!(spots(&listed), ["error ./parcels/broken.rhai:1:32"]);
}
