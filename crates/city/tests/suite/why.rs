//! `plat why`: the rule, the values, the lineage and the refusals behind what is in a layout.

use crate::common::check;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Streets that branch at right angles, and would branch back along themselves to the left.
const RULE: &str = "//! A comb.\n\nparams(#{\n    step: metres(100).range(20, 300).about(\"Between teeth\"),\n});\n\n\
    fn propose(tip, p) {\n    tip.ahead(p.step);\n    tip.branch_right(p.step);\n    \
    tip.branch_left(p.step, #{ turn: 80 });\n}\n";

const CITY: &str = r#"
    city(#{ site: site(#{ size: [1000, 1000] }), seed: 3,
            given: [line([[100, 100], [900, 100]]), line([[900, 100], [900, 900]]),
                    line([[900, 900], [100, 900]]), line([[100, 900], [100, 100]], #{ name: "West Street" })],
            minors: streets(#{ pattern: rule("streets/comb") }),
            parcels: rule("parcels/recursive"), buildings: rule("buildings/extruded") });
"#;

/// A city beside what is built from it.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().expect("a temporary folder"));
        fs::create_dir_all(place.path("town/streets")).expect("a folder");
        fs::write(place.path("town/city.rhai"), CITY).expect("a file");
        fs::write(place.path("town/streets/comb.rhai"), RULE).expect("a file");
        place
    }

    fn built(more: &[&str]) -> Self {
        let place = Self::new();
        let (town, out) = (place.path("town"), place.path("out"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
        let output = command.arg("build").arg(town).arg("-o").arg(out).arg("--quiet").args(more).output();
        check(&output.expect("plat runs"), 0, &[]);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn layout(&self) -> PathBuf {
        self.path("out/layout.geojson")
    }

    /// The properties of all features of a kind.
    fn of_kind(&self, kind: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.layout()).expect("a layout");
        let layout: Value = serde_json::from_str(&text).expect("JSON");
        let features =
            layout["features"].as_array().expect("features").iter().map(|feature| feature["properties"].clone());
        features.filter(|properties| properties["kind"] == kind).collect()
    }

    fn why(&self, id: &str, more: &[&str]) -> Output {
        why(&self.layout(), id, more)
    }

    fn answer(&self, id: &str) -> Value {
        let output = self.why(id, &["--json"]);
        check(&output, 0, &[]);
        serde_json::from_slice(&output.stdout).expect("one JSON object")
    }
}

fn why(layout: &Path, id: &str, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    command.arg("why").arg(layout).arg(id).args(more).output().expect("plat runs")
}

fn id(properties: &Value) -> &str {
    properties["id"].as_str().expect("an id")
}

fn facts(answer: &Value) -> String {
    let word = |fact: &Value, key: &str| fact[key].as_str().expect("a text").to_owned();
    let fact = |fact: &Value| format!("{}: {}\n", word(fact, "about"), word(fact, "text"));
    answer["facts"].as_array().expect("facts").iter().map(fact).collect()
}

#[test]
fn a_grown_street_tells_its_rule_lineage_and_refusals() {
    let place = Place::built(&["--until", "streets"]);
    let minors: Vec<Value> = place.of_kind("street").into_iter().filter(|street| street["class"] == "minor").collect();
    assert!(minors.len() > 20);
    let mut refused = 0;
    for street in minors.iter().step_by(7) {
        let answer = place.answer(id(street));
        assert_eq!(answer["rules"][0]["name"], "streets/comb");
        assert_eq!(answer["rules"][0]["line"], 7, "the line of `fn propose`");
        assert!(answer["rules"][0]["file"].as_str().expect("a file").ends_with("town/streets/comb.rhai"));
        assert_eq!(answer["parameters"][0]["address"], "minors.pattern.step");
        assert_eq!(answer["parameters"][0]["value"], "100 m");
        assert!(!answer["pieces"].as_array().expect("pieces").is_empty());
        // Each street of a lineage began before those that branched off it, the first at a seed.
        let lineage = answer["lineage"].as_array().expect("a lineage");
        assert_eq!(lineage[0]["street"], street["street"]);
        let steps: Vec<u64> = lineage.iter().map(|says| says["step"].as_u64().expect("a step")).collect();
        assert!(steps.windows(2).all(|pair| pair[0] > pair[1]), "{steps:?}");
        let how = lineage.last().expect("a root")["how"].as_str().expect("how");
        assert!(how.contains("seed"), "{how}");
        for says in answer["refused"].as_array().expect("refusals") {
            let reason = says["reason"].as_str().expect("a reason");
            refused += usize::from(reason.contains("runs along") || reason.contains("too sharp"));
        }
    }
    assert!(refused > 0, "branches back along the street are refused");
}

#[test]
fn blends_and_refusals_of_rules_are_told_in_their_own_words() {
    let place = Place::new();
    let pattern = "pattern: rule(\"streets/comb\") * 0.25 + rule(\"streets/grid\", #{ heading: 0 }) * 0.75, constraints: \
                   [rule(\"constraints/standard\"), rule(\"streets/shy\")]";
    let shy = "fn constrain(segment, p) { if segment.to_x > 600 { segment.refuse(\"too far east\"); } }";
    fs::write(place.path("town/streets/shy.rhai"), shy).expect("a file");
    let script = CITY.replace("pattern: rule(\"streets/comb\")", pattern);
    fs::write(place.path("town/city.rhai"), script).expect("a file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    let output = command.arg("build").arg(place.path("town")).arg("-o").arg(place.path("out"));
    check(&output.args(["--quiet", "--until", "streets"]).output().expect("plat runs"), 0, &[]);
    let minors: Vec<Value> = place.of_kind("street").into_iter().filter(|street| street["class"] == "minor").collect();
    let mut told = false;
    for street in minors.iter().step_by(5) {
        let answer = place.answer(id(street));
        let patterns = answer["pieces"][0]["patterns"].as_array().expect("patterns").clone();
        let says: Vec<_> = patterns.iter().map(|says| (&says["name"], &says["share"], &says["leads"])).collect();
        let expected = [
            (&Value::from("grid"), &Value::from(0.75), &Value::from(true)),
            (&Value::from("comb"), &Value::from(0.25), &Value::from(false)),
        ];
        assert_eq!(says, expected);
        told |= answer.to_string().contains("refused by a rule (streets/shy: too far east)");
    }
    assert!(told, "the rule's own words are told where it refuses");
    let output = place.why(id(&minors[0]), &[]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("by grid (75 %, leads), comb (25 %)"), "{text}");
}

#[test]
fn people_get_it_part_by_part() {
    let place = Place::built(&["--until", "streets"]);
    let street = place.of_kind("street").into_iter().find(|street| street["class"] == "minor").expect("a minor");
    let output = place.why(id(&street), &[]);
    check(&output, 0, &[]);
    let folder = place.path("town").canonicalize().expect("it is there").display().to_string();
    insta::assert_snapshot!(String::from_utf8_lossy(&output.stdout).replace(&folder, "town"));
}

#[test]
fn every_kind_has_an_answer() {
    let place = Place::built(&[]);
    let first = |kind: &str| id(place.of_kind(kind).first().expect(kind)).to_owned();
    let wanted = [
        ("crossing", "streets meet here", None),
        ("quarter", "closed by", Some("minors.pattern")),
        ("block", "closed by", Some("parcels")),
        ("parcel", "block: ", Some("parcels")),
        ("building", "m high on", Some("buildings")),
    ];
    for (kind, words, role) in wanted {
        let answer = place.answer(&first(kind));
        assert_eq!(answer["kind"], kind);
        assert!(facts(&answer).contains(words), "{kind}: {}", facts(&answer));
        if let Some(role) = role {
            assert_eq!(answer["rules"][0]["role"], role, "{kind}");
        }
    }
    let given =
        place.of_kind("street").into_iter().find(|street| street["name"] == "West Street").expect("it is there");
    let told = facts(&place.answer(given["street"].as_str().expect("a street")));
    assert!(told.contains("line 4 of `given`") && told.contains("West Street"), "{told}");
}

#[test]
fn ids_may_be_cut_and_misspelt() {
    let place = Place::built(&["--until", "streets"]);
    let streets = place.of_kind("street");
    let whole = id(&streets[0]);
    assert_eq!(place.answer(&whole[..12])["id"], whole);
    check(&place.why(&format!("{}zz", &whole[..8]), &[]), 2, &["has the id", "did you mean", whole]);
    // A place will do, too: that of the street's middle, and one that nothing is at.
    let [x, y] = [0, 1].map(|i| place.answer(whole)["place"][i].as_f64().expect("a number"));
    assert_eq!(place.answer(&format!("{}, {}", x + 0.4, y))["id"], whole);
    check(
        &place.why("5000,20", &[]),
        2,
        &["(5000, 20) does not lie on the site", "it reaches from (0, 0) to (1000, 1000)"],
    );
    check(&place.why(" ", &[]), 2, &["has the id ``", "of kind street"]);
    check(&place.why(&whole[..2], &[]), 2, &["is too short for an id", &whole[..2]]);
    check(&place.why("town hall", &[]), 2, &["has the id", "of kind street", "of kind crossing"]);
    let output = place.why("town hall", &["--json"]);
    let error: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(error["error"]["status"], 2);
}

#[test]
fn what_was_set_is_remembered_and_what_differs_is_said() {
    let place = Place::built(&["--until", "streets", "--seed", "9", "--set", "minors.pattern.step=80"]);
    let street = place.of_kind("street").into_iter().find(|street| street["class"] == "minor").expect("a minor");
    assert_eq!(place.answer(id(&street))["parameters"][0]["value"], "80 m");
    check(&place.why(id(&street), &["--set", "minors.pattern.step=60"]), 1, &["not what the city gives now"]);
    check(&place.why(id(&street), &["--set", "minors.pattern.stop=60"]), 2, &["did you mean `step`?"]);
    // A city that was named by where the command was run is found by its name.
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    command.current_dir(place.path("town")).args(["build", ".", "-o", "../here", "--quiet", "--until", "streets"]);
    check(&command.output().expect("plat runs"), 0, &[]);
    let here = place.path("here/layout.geojson");
    check(&why(&here, "600,500", &[]), 0, &["streets/comb"]);
    fs::rename(place.path("town"), place.path("village")).expect("moved");
    check(&why(&here, "600,500", &[]), 3, &["--city"]);
    fs::rename(place.path("village"), place.path("town")).expect("moved back");
    // The folder may move as a whole; alone, a layout does not say where it is from.
    let lonely = place.path("lonely.geojson");
    fs::copy(place.layout(), &lonely).expect("a copy");
    check(&why(&lonely, id(&street), &[]), 2, &["does not say which city", "--city"]);
    let town = place.path("town").display().to_string();
    let more = ["--city", &town, "--set", "minors.pattern.step=80"];
    check(&why(&lonely, id(&street), &more), 0, &["streets/comb"]);
    check(&why(&lonely, id(&street), &["--city", "no/such/town"]), 3, &["no such city", "hint"]);
    check(&why(&place.path("none.geojson"), "1", &[]), 3, &["none.geojson"]);
    fs::write(place.path("town/streets/comb.rhai"), RULE.replace("branch_right(p.step)", "branch_right(50)"))
        .expect("a file");
    check(&place.why(id(&street), &[]), 1, &["not what the city gives now", "streets of the layout are gone or moved"]);
}
