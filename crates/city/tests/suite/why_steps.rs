//! What `plat why` and `plat build --trace` tell step by step holds for every element of a town, and reads well.

use crate::common::check;
use crate::common::command::{place, plat};
use city::export::geojson::write_layout;
use city::export::layout_file::{LayoutFile, parse_layout};
use city::why::{Answer, DecisionSays, Kind, PieceSays, explain, find};
use city::{Built, Cancel, Settings, Silent, Sources, build, load};
use geom::{Id, Vec2};
use layout::Use;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A town with parks, water, a lowest and a highest height, quarters of its own and parcels that are told what they are for.
const CITY: &str = r#"
let site = site(#{
    size: [1200, 1000], density: |x, y| 20 * x, max_height: |x, y| if y < 300 { 1 } else { 9 + x / 100 },
    parks: |x, y| x > 900 && y > 700, land: |x, y| x < 1100,
});
city(#{
    site: site, seed: 3, barred: [],
    given: [line([[100, 100], [1100, 100]]), line([[1100, 100], [1100, 900]]), line([[1100, 900], [100, 900]]),
            line([[100, 900], [100, 100]], #{ name: "West Street" }), line([[600, 100], [600, 900]])],
    minors: streets(#{ pattern: rule("streets/comb") * 0.7 + rule("streets/grid") * 0.3 }),
    parcels: rule("lots"), buildings: rule("houses"),
});
"#;

const COMB: &str = "//! A comb.\nparams(#{ step: metres(110).range(20, 300) });\n\n\
    fn propose(tip, p) {\n    tip.ahead(p.step);\n    if tip.age > 1 || tip.is_seed { tip.branch_right(p.step); }\n    \
    tip.branch_left(p.step, #{ turn: 4, delay: 2 });\n}\n";

/// Its helper stands in another file.
const LOTS: &str = r#"//! Lots.
import "common" as common;
params(#{ most: number(900).range(60, 9000) });

fn subdivide(block, p) {
    if block.chance(1) < 0.1 { return block.open(); }
    if block.area < common::least() { return block.whole(); }
    block.recursive(#{ most_area: p.most, spread: 0.4, irregularity: 0.2, least_area: 140 });
}

fn assign(parcel, p) {
    if parcel.is_corner { parcel.tag("shop"); }
    if parcel.chance(2) < 0.1 { parcel.plaza(); print(`plaza of ${round(parcel.area)}`); }
}
"#;

const COMMON: &str = "//! What lots share.\nfn least() { 300 }\n";

const HOUSES: &str = r#"//! Houses.
params(#{ floor: metres(3.2).range(2, 6) });

fn build(shape, p) {
    if shape.chance(3) < 0.08 { return; }
    if shape.chance(4) < 0.15 { throw "no room for a house"; }
    let floors = 2 + round(shape.chance(1, 0, 5));
    if shape.has_tag("shop") { mark(shape.area, 1); }
    shape.extrude(floors * p.floor, #{ front: 2, side: 1, rear: 4, coverage: 0.4 });
}
"#;

const FILES: [(&str, &str); 5] = [
    ("town/city.rhai", CITY),
    ("town/streets/comb.rhai", COMB),
    ("town/lots.rhai", LOTS),
    ("town/common.rhai", COMMON),
    ("town/houses.rhai", HOUSES),
];

/// A town, grown with a trace, that can be asked.
struct Town {
    sources: Sources,
    built: Built,
    layout: LayoutFile,
}

impl Town {
    fn of(folder: &Path) -> Self {
        let sources = load(folder, None).and_then(|loaded| loaded.read()).unwrap_or_else(|error| panic!("{error}"));
        let settings = Settings { traces: true, ..Settings::default() };
        let built = build(&sources, settings, &Silent, &Cancel::default()).expect("a city");
        let mut bytes = Vec::new();
        write_layout(&built.city, &mut bytes).expect("written");
        let layout = parse_layout(&bytes, Path::new("layout.geojson")).expect("a layout");
        Self { sources, built, layout }
    }

    fn ask(&self, id: impl ToString) -> Answer {
        let found = find(&self.layout, &id.to_string()).unwrap_or_else(|error| panic!("{error}"));
        let answer = explain(&found, &self.layout, &self.sources, &self.built);
        assert!(answer.differs.is_empty(), "{:?}", answer.differs);
        answer
    }
}

fn outcome(decision: &DecisionSays) -> String {
    decision.outcome.join("\n")
}

/// Counts what was so.
fn see(seen: &mut BTreeMap<&'static str, usize>, what: &'static str, is: bool) {
    *seen.entry(what).or_default() += usize::from(is);
}

/// A place in a footprint, as one is told.
fn inside(footprint: &geom::Polygon) -> String {
    let at = footprint.pole(0.5).metres();
    format!("{},{}", at.x, at.y)
}

/// The number right before some words.
fn number_before(text: &str, words: &str) -> Option<f64> {
    text[..text.find(words)?].rsplit([' ', '\n']).next()?.parse().ok()
}

#[test]
fn the_steps_of_every_element_lead_to_what_is_there() {
    let folder = place(&FILES);
    let town = Town::of(&folder.path().join("town"));
    let city = &town.built.city;
    let mut seen: BTreeMap<&'static str, usize> = BTreeMap::new();
    let prints = |decision: &DecisionSays| decision.steps.iter().filter(|step| step.kind == "print").count();
    let mut printed = 0;
    let on: BTreeMap<_, _> = city.buildings.iter().map(|building| (building.parcel, building)).collect();
    // Each answer compares the whole layout, which takes its time: some, and more of those that are rare.
    let rare = city.parcels.iter().filter(|parcel| parcel.usage != Use::Built).take(30);
    for parcel in city.parcels.iter().step_by(8).chain(rare) {
        let answer = town.ask(parcel.id);
        let by = |function: &str| answer.decisions.iter().find(|decision| decision.function.starts_with(function));
        let (lots, assign, houses) = (by("subdivide"), by("assign"), by("build"));
        printed += assign.map_or(0, prints);
        // What it was divided from, and what it is for.
        let Some(lots) = lots else {
            assert!(answer.to_string().contains("so no rule is asked"), "{answer}");
            see(&mut seen, "covered", true);
            continue;
        };
        let told = outcome(lots);
        let is_open = told.contains("open: ") || told.contains("one parcel that stays open");
        assert_eq!(assign.is_none(), is_open, "{answer}");
        assert!(!is_open || parcel.usage == Use::Open, "{answer}");
        see(&mut seen, "open", is_open);
        if told.contains("kept as it is") {
            let kept = number_before(&told, " m², at most").expect("an area");
            let taken: f64 = lots.outcome.iter().filter_map(|line| number_before(line, " m², too small")).sum();
            assert!((kept + taken - parcel.polygon.area()).abs() < 3.0, "{answer}");
            see(&mut seen, "cut", told.contains("cut "));
            see(&mut seen, "joined", taken > 0.0);
        }
        if let Some(assign) = assign {
            let told = outcome(assign);
            assert_eq!(told.contains("it is plaza"), parcel.usage == Use::Plaza, "{answer}");
            assert_eq!(told.contains("with the tags shop"), !parcel.tags.is_empty(), "{answer}");
            see(&mut seen, "tagged", !parcel.tags.is_empty());
        }
        // What is built on it.
        assert_eq!(houses.is_some(), parcel.usage == Use::Built, "{answer}");
        let (Some(houses), building) = (houses, on.get(&parcel.id)) else { continue };
        let told = outcome(houses);
        assert_eq!(told.contains("nothing is built"), building.is_none(), "{answer}");
        let Some(building) = building else {
            see(&mut seen, "too low", told.contains("`max_height` allows 1 m"));
            see(&mut seen, "none", true);
            continue;
        };
        if seen.get("none").is_none_or(|count| *count < 3) {
            assert_eq!(
                &town.ask(building.id).decisions[..],
                std::slice::from_ref(houses),
                "the building tells the same"
            );
            // At a place of it all that was asked there is told.
            assert_eq!(town.ask(inside(&building.footprint)).decisions, answer.decisions);
        }
        let asked = number_before(&told, " m of height").or(number_before(&told, " m stands in"));
        let cut = told.split("cuts that to ").nth(1);
        let cut = cut.and_then(|cut| cut.split(' ').next()?.parse::<f64>().ok());
        assert!((cut.or(asked).expect("a height") - building.height).abs() < 0.01, "{answer}");
        let left = told.split("takes that down to ").nth(1).or(told.split("leave ").nth(1)).expect("an area");
        let left: f64 = left.split(' ').next().expect("a word").parse().expect("a number");
        assert!((left - building.footprint.area()).abs() < 0.6, "{answer}");
        see(&mut seen, "lowered", cut.is_some());
        see(&mut seen, "failed", told.contains("the rule failed") && told.contains("houses.rhai:6:"));
    }
    assert!(printed > 0 && city.parcels.iter().filter(|parcel| parcel.usage == Use::Plaza).count() >= printed);
    let wanted = ["covered", "open", "cut", "joined", "tagged", "too low", "none", "lowered", "failed"];
    assert!(wanted.iter().all(|what| seen.get(what).is_some_and(|count| *count > 0)), "{seen:?}");
    for block in city.blocks.iter().step_by(4) {
        let answer = town.ask(block.id);
        let divided: usize =
            answer.decisions.iter().filter_map(|d| number_before(&outcome(d), " parcels,")).sum::<f64>() as usize;
        let count = city.parcels.iter().filter(|parcel| parcel.block == block.id).count();
        let whole = answer.decisions.iter().filter(|decision| outcome(decision).starts_with("one parcel")).count();
        let covered = answer.facts.iter().filter(|fact| fact.text.contains("so no rule is asked")).count();
        assert_eq!(divided + whole + covered, count, "{answer}");
    }
}

/// How many pieces that were laid as proposed from where a decision was made are as long as it says: all of them.
fn laid_as(decision: &DecisionSays, answer: &Answer) -> usize {
    let lengths: Vec<f64> = decision.outcome.iter().filter_map(|line| number_before(line, " m ")).collect();
    let is_here = |from: [f64; 2]| decision.about.ends_with(&format!("({:.1}, {:.1})", from[0], from[1]));
    let here = answer.pieces.iter().filter(|piece| is_here(piece.from) && piece.outcome == "as proposed");
    let length = |piece: &PieceSays| Vec2::from_array(piece.from).distance(Vec2::from_array(piece.to));
    let laid: Vec<f64> = here.map(length).collect();
    let is_told = |laid: &f64| lengths.iter().any(|length| (laid - length).abs() < 0.05);
    assert!(laid.iter().all(is_told), "{laid:?} of {answer}");
    laid.len()
}

#[test]
fn street_ends_tell_what_was_proposed() {
    let folder = place(&FILES);
    let town = Town::of(&folder.path().join("town"));
    let grown: Vec<_> = town.built.city.runs.iter().filter(|run| run.class == streets::Classes::MINOR).collect();
    assert!(grown.len() > 30);
    let (mut slots, mut together) = (BTreeSet::new(), 0);
    for run in grown.iter().step_by(2) {
        let answer = town.ask(run.id);
        // Both patterns of the blend were asked at each end, and then what they propose together.
        let ends: BTreeSet<_> = answer.decisions.iter().map(|decision| decision.about.split(", for").next()).collect();
        assert!(!ends.is_empty() && answer.decisions.len() == 3 * ends.len(), "{answer}");
        for decision in &answer.decisions {
            if decision.rule == "the blend of comb, grid" {
                together += laid_as(decision, &answer);
                continue;
            }
            let share = if decision.rule == "streets/comb" { "for 70 % of a blend" } else { "for 30 % of a blend" };
            assert!(decision.about.ends_with(share) && !decision.steps.is_empty(), "{answer}");
            if decision.rule == "streets/comb" {
                let step = decision.steps.iter().find(|step| step.text == "p.step").expect("it is read");
                assert_eq!((step.line, step.value.as_deref()), (5, Some("110.0")));
                assert_eq!(decision.outcome[0], "110 m ahead");
                assert_eq!(decision.outcome[1], "110 m to the left, turned by 4°, after 2 further steps");
                slots.insert(decision.outcome.len());
            }
        }
    }
    assert!(together > 10, "{together} pieces were laid as the blend proposes");
    assert_eq!(slots, BTreeSet::from([2, 3]), "with a branch to the right, and without");
}

#[test]
fn people_read_it_a_step_a_line() {
    let folder = place(&FILES);
    let build = plat(folder.path(), &["build", "town", "-o", "out", "--quiet"]);
    check(&build, 1, &["no room for a house"]);
    let town = Town::of(&folder.path().join("town"));
    // One whose rule did not fail, below the greatest height.
    let is_high = |parcel: Id| town.built.city.buildings.iter().any(|on| on.parcel == parcel && on.height > 8.0);
    let mut corners = town.built.city.parcels.iter().filter(|parcel| !parcel.tags.is_empty());
    let corner = corners.find(|parcel| is_high(parcel.id));
    let id = corner.expect("a corner with a building").id.to_string();
    let why = plat(folder.path(), &["why", "out/layout.geojson", &id]);
    check(&why, 0, &[]);
    let why = String::from_utf8(why.stdout).expect("text");
    let home = folder.path().canonicalize().expect("it is there").display().to_string();
    insta::assert_snapshot!(why.replace(&home, "…"));
    // A build tells the same, and what is asked again prints and marks nothing.
    let traced = plat(folder.path(), &["build", "town", "-o", "again", "--quiet", "--trace", &id]);
    check(&traced, 1, &[]);
    let told = String::from_utf8(traced.stdout).expect("text");
    assert_eq!(
        told.replace(&home, "…").replace("town/town", "town"),
        why.replace(&home, "…").replace("town/town", "town")
    );
    let report = |folder_name: &str| {
        std::fs::read_to_string(folder.path().join(folder_name).join("report.json")).expect("a report")
    };
    assert_eq!(report("again"), report("out"));
}

/// Every third proposal is turned, cut, refused or fails; where a street ends in the west the rule marks the place.
const KEEP: &str = "//! Keep.\nfn constrain(segment, p) {\n    let n = segment.chance(1);\n    \
    if n < 0.1 { segment.turn(7); } else if n < 0.2 { segment.cut_to(60); }\n    \
    if n > 0.9 { return segment.refuse(\"unlucky\"); }\n    if n > 0.85 { throw \"no way\"; }\n}\n";

const ENDS: &str = "//! Ends.\nfn propose(tip, p) {\n    for i in 0..400 { if tip.chance(i) < 0 { } if i == 250 { print(\"half way\"); } }\n    \
    if tip.x < 350 && !tip.is_seed { print(\"west\"); mark(tip.x, tip.y); return; }\n    tip.fork(90, 90);\n}\n";

const KEPT: &str = r#"
city(#{
    site: site(#{ size: [900, 900] }), seed: 5,
    minors: streets(#{ pattern: rule("streets/ends"), constraints: [rule("constraints/standard"), rule("constraints/keep")] }),
    parcels: rule("parcels/recursive"), buildings: rule("buildings/extruded", #{ setback: 45 }),
});
"#;

#[test]
fn what_rules_refuse_change_and_do_not_propose_is_told_where_it_was_asked() {
    let folder =
        place(&[("town/city.rhai", KEPT), ("town/streets/ends.rhai", ENDS), ("town/constraints/keep.rhai", KEEP)]);
    let town = Town::of(&folder.path().join("town"));
    let (mut turned, mut cut, mut refused, mut failed, mut by_rules) = (0, 0, 0, 0, 0);
    for run in &town.built.city.runs {
        let answer = town.ask(run.id);
        let kept: Vec<&DecisionSays> =
            answer.decisions.iter().filter(|d| d.function.starts_with("constrain")).collect();
        assert!(!kept.is_empty(), "{answer}");
        for decision in &kept {
            let told = outcome(decision);
            turned += usize::from(told.contains("turned by 7°"));
            cut += usize::from(told.contains(", 60 m long"));
            refused += usize::from(told.contains("refused: constraints/keep: unlucky"));
            failed += usize::from(told.contains("the rule failed") && told.contains("keep.rhai:6:"));
        }
        for piece in &answer.pieces {
            // Nothing else is in the way here but the site's rim.
            let changed = kept.iter().any(|decision| outcome(decision).contains("it is to end at"));
            let by_rule = piece.outcome.ends_with("by constraints/keep");
            assert!(!by_rule || changed, "{answer}");
            by_rules += usize::from(by_rule);
        }
    }
    let seen = [turned, cut, refused, failed, by_rules];
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    // Where a rule marked, printed and proposed nothing.
    let mark = town.built.report.marks.first().expect("the west is marked").place;
    let answer = town.ask(format!("{},{}", mark[0], mark[1]));
    let here = format!("the street end at ({:.1}, {:.1})", mark[0], mark[1]);
    let decision = answer.decisions.iter().find(|decision| decision.about == here).expect("it was asked here");
    assert!(outcome(decision).contains("nothing is proposed: the street ends"), "{answer}");
    // Of many steps the first and the last are told.
    let left_out = decision.left_out.expect("there are too many");
    assert!(left_out.count > 400 && left_out.behind == 200, "{left_out:?}");
    assert_eq!(decision.steps[200].value.as_deref(), Some("half way"), "what is printed between is told");
    assert_eq!(decision.steps.last().map(|step| &step.text[..]), Some("mark(tip.x, tip.y)"));
    assert!(answer.to_string().contains(&format!("…         {} further steps, without", left_out.count)), "{answer}");
    // Where nothing lies, and nothing was asked.
    let mut places = (1..90).flat_map(|x| (1..90).map(move |y| format!("{},{}", 10 * x, 10 * y)));
    let is_bare = |place: &String| find(&town.layout, place).is_ok_and(|found| found.kind == Kind::Place);
    let answer = town.ask(places.find(is_bare).expect("land without streets in the west"));
    assert!(answer.decisions.is_empty() && answer.to_string().contains("nothing lies here"), "{answer}");
    // A distance that leaves no room.
    let building = town.built.city.buildings.first().expect("one").id;
    assert!(outcome(&town.ask(building).decisions[0]).contains("45 m from its rim leave no room: it keeps"));
}

#[test]
fn what_a_layout_says_otherwise_is_told_of_every_kind() {
    let folder = place(&FILES);
    let mut town = Town::of(&folder.path().join("town"));
    let tagged = town.built.city.parcels.iter().find(|parcel| !parcel.tags.is_empty() && parcel.usage == Use::Built);
    let (parcel, block) = tagged.map(|parcel| (parcel.id.to_string(), parcel.block.to_string())).expect("one");
    let change = |town: &mut Town, file: &str, from: &str, to: &str| {
        let path = folder.path().join("town").join(file);
        let text = std::fs::read_to_string(&path).expect("a rule");
        assert!(text.contains(from));
        std::fs::write(&path, text.replace(from, to)).expect("written");
        let now = Town::of(&folder.path().join("town"));
        (town.sources, town.built) = (now.sources, now.built);
    };
    let differs = |town: &Town, id: &str| {
        let found = find(&town.layout, id).unwrap_or_else(|error| panic!("{error}"));
        explain(&found, &town.layout, &town.sources, &town.built).differs.join("; ")
    };
    change(&mut town, "lots.rhai", "parcel.tag(\"shop\")", "parcel.tag(\"cafe\")");
    assert_eq!(differs(&town, &parcel), "the parcel carries other tags now");
    change(&mut town, "lots.rhai", "parcel.tag(\"cafe\")", "parcel.park()");
    assert!(differs(&town, &parcel).contains("the parcel was built in the layout and is park now"));
    change(&mut town, "lots.rhai", "most_area: p.most", "most_area: p.most * 3");
    assert!(differs(&town, &block).contains("parcels in the layout and has others now"));
    town.sources.plan.seed = 99;
    assert!(differs(&town, &block).contains("the layout has the seed 3, what is told the seed 99"));
}

#[test]
fn heights_widths_and_rules_that_changed_are_told() {
    let folder = place(&FILES);
    let path = folder.path().join("town");
    let town = Town::of(&path);
    let id_of = |kind: &str, class: Option<&str>| {
        let said = town.layout.features.iter().map(|feature| &feature.properties);
        let mut such = said.filter(|said| said.kind.as_deref() == Some(kind) && said.class.as_deref() == class);
        such.next().and_then(|said| said.id.clone()).expect("one")
    };
    let (building, street) = (id_of("building", None), id_of("street", Some("minor")));
    for (file, text) in [
        ("city.rhai", CITY.replace("* 0.3", "* 0.3, width: 11.5").replace("\"houses\"", "\"homes\"")),
        ("homes.rhai", HOUSES.replace("floors * p.floor", "5")),
    ] {
        std::fs::write(path.join(file), text).expect("written");
    }
    let now = Town::of(&path);
    let differs = |id: &str| {
        let found = find(&town.layout, id).unwrap_or_else(|error| panic!("{error}"));
        explain(&found, &town.layout, &now.sources, &now.built).differs
    };
    let told = differs(&street);
    assert!(
        told.iter().any(|line| line.starts_with("the street had the width ") && line.ends_with(" and has 11.5 m now")),
        "{told:?}"
    );
    let told = differs(&building).join("; ");
    assert!(
        told.contains("and has 5 m now") && told.contains("had the rule houses in the layout and has homes now"),
        "{told}"
    );
}

#[test]
fn a_quarter_where_all_is_refused_says_so_and_the_rule_is_no_mistake() {
    let city = r#"
city(#{
    site: site(#{ size: [1000, 600] }), seed: 2,
    given: [line([[50, 50], [950, 50], [950, 550], [50, 550], [50, 50]]), line([[500, 50], [500, 550]])],
    minors: streets(#{ pattern: rule("streets/grid", #{ block_length: 120, block_width: 80 }),
                       constraints: [rule("constraints/standard"), rule("constraints/east")] }),
});
"#;
    let east = "//! East.\nfn constrain(segment, p) {\n    if segment.from_x < 490 { print(\"west\"); segment.refuse(\"west\"); }\n}\n";
    let folder = place(&[("town/city.rhai", city), ("town/constraints/east.rhai", east)]);
    let town = Town::of(&folder.path().join("town"));
    assert!(town.built.report.faults.is_empty(), "{:?}", town.built.report.faults);
    let quarter = town.built.city.quarters.iter().find(|quarter| quarter.polygon.centroid().x < 500.0).expect("one");
    let answer = town.ask(quarter.id);
    let told = answer.to_string();
    assert!(
        told.contains("× constraints/east: west") && told.contains("then      refused: constraints/east: west"),
        "{told}"
    );
    assert!(answer.decisions.iter().any(|decision| decision.function.starts_with("propose")), "{told}");
    // The place of the print shows the call, though nothing was laid there.
    let at = town
        .built
        .report
        .prints
        .iter()
        .find(|print| print.text == "west")
        .and_then(|print| print.place)
        .expect("a place");
    let told = town.ask(format!("{},{}", at[0], at[1])).to_string();
    assert!(told.contains("line 3    print: west"), "{told}");
}
