//! Presets: laid on a city, a class, a district and a quarter, from scripts and from the command line.

use crate::common::build::{faultless, try_build};
use crate::common::check;
use crate::common::command::plat;
use city::{Loaded, PresetError, Until, load};
use geom::Vec2;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use streets::growth::Chain;
use tempfile::TempDir;

const PRESET: &str = "//! Mine.\n//!\n//! Wide blocks.\npreset(#{\n    pattern: rule(\"streets/grid\", #{ heading: 45, block_length: 90, block_width: 70 }),\n    \
    constraints: rule(\"constraints/standard\", #{ snap: 9 }),\n    width: 9,\n    parcels: rule(\"parcels/recursive\", #{ most_area: 500 }),\n    \
    buildings: rule(\"buildings/extruded\", #{ low: 7, high: 7, spread: 0 }),\n});\n";

/// Two quarters in two districts.
const RING: &str =
    "given: [line([[20, 20], [780, 20], [780, 380], [20, 380], [20, 20]]), line([[400, 20], [400, 380]])]";

fn place(city: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::create_dir_all(folder.path().join("presets")).expect("made");
    fs::write(folder.path().join("presets/mine.rhai"), PRESET).expect("written");
    write_city(folder.path(), city);
    folder
}

fn write_city(folder: &Path, parts: &str) {
    let site = "site(#{ size: [800, 400], districts: |x, y| if x < 400 { \"west\" } else { \"east\" } })";
    fs::write(folder.join("city.rhai"), format!("city(#{{ site: {site}, {RING}, {parts} }});\n")).expect("written");
}

/// How many buildings of seven floors stand west and east of the middle, and how many others.
fn tall(folder: &Path, lay: &[&str]) -> BTreeMap<(&'static str, bool), usize> {
    let mut loaded = load(folder, None).unwrap_or_else(|error| panic!("{error}"));
    lay.iter().for_each(|preset| loaded.lay(preset).unwrap_or_else(|error| panic!("{error}")));
    let sources = loaded.read().unwrap_or_else(|error| panic!("{error}"));
    let built =
        city::build(&sources, city::Settings::default(), &city::Silent, &city::Cancel::default()).expect("a city");
    assert!(!built.report.has_faults(), "{:?}", built.report.faults);
    let mut counts = BTreeMap::new();
    for building in built.city.buildings.iter() {
        let side = if building.footprint.centroid().x < 400.0 { "west" } else { "east" };
        *counts.entry((side, (building.height - 22.4).abs() < 0.01)).or_default() += 1;
    }
    counts
}

const PLAIN: &str = "minors: streets(#{ pattern: rule(\"streets/grid\", #{ heading: 0, block_length: 120 }), constraints: rule(\"constraints/standard\") }), \
    parcels: rule(\"parcels/recursive\"), buildings: rule(\"buildings/extruded\", #{ low: 2, high: 2, spread: 0 })";

#[test]
fn a_preset_fills_what_a_script_does_not_say() {
    let place = place("preset: preset(\"mine\")");
    assert!(tall(place.path(), &[]).keys().all(|(_, is_tall)| *is_tall));
    write_city(
        place.path(),
        "preset: preset(\"mine\"), buildings: rule(\"buildings/extruded\", #{ low: 2, high: 2, spread: 0 })",
    );
    assert!(tall(place.path(), &[]).keys().all(|(_, is_tall)| !*is_tall));
    write_city(place.path(), "minors: streets(#{ preset: preset(\"presets/mine\"), width: 12 })");
    let built = faultless(try_build(place.path(), Until::Streets));
    let minors = built.city.runs.iter().filter(|run| run.class == streets::Classes::MINOR);
    assert!(minors.clone().count() > 10 && minors.clone().all(|run| run.half_width == 6 * 1024));
}

#[test]
fn a_preset_laid_from_outside_stands_over_the_script() {
    let place = place(PLAIN);
    assert!(tall(place.path(), &[]).keys().all(|(_, is_tall)| !*is_tall));
    assert!(tall(place.path(), &["mine"]).keys().all(|(_, is_tall)| *is_tall));
    let minors = tall(place.path(), &["minors=mine"]);
    assert!(minors.keys().all(|(_, is_tall)| !*is_tall), "only streets change");
    assert_ne!(minors, tall(place.path(), &[]));
}

#[test]
fn a_district_and_a_quarter_have_presets_of_their_own() {
    let place = place(PLAIN);
    let by_district = tall(place.path(), &["district:west=mine"]);
    assert!(by_district[&("west", true)] > 30 && by_district[&("east", false)] > 20, "{by_district:?}");
    assert!(!by_district.contains_key(&("east", true)), "{by_district:?}");
    // The same said in the script.
    write_city(place.path(), &format!("{PLAIN}, preset: by_district(#{{ west: preset(\"mine\") }})"));
    assert_eq!(tall(place.path(), &[]), by_district);
    write_city(place.path(), PLAIN);
    let quarters = faultless(try_build(place.path(), Until::Streets)).city.quarters.clone();
    let east = quarters.iter().find(|quarter| quarter.polygon.centroid().x > 400.0).expect("a quarter").id;
    let in_quarter = tall(place.path(), &[&format!("quarter:{east}=mine")]);
    assert!(in_quarter[&("east", true)] > 30 && !in_quarter.contains_key(&("west", true)), "{in_quarter:?}");
    write_city(place.path(), &format!("{PLAIN}, quarters: #{{ \"{east}\": #{{ preset: preset(\"mine\") }} }}"));
    assert_eq!(tall(place.path(), &[]), in_quarter);
    // What is set for the quarter stands over its preset.
    write_city(
        place.path(),
        &format!(
            "{PLAIN}, quarters: #{{ \"{east}\": #{{ preset: preset(\"mine\"), \"buildings.low\": 3, \"buildings.high\": 3 }} }}"
        ),
    );
    assert!(!tall(place.path(), &[]).contains_key(&("east", true)));
}

#[test]
fn presets_of_minors_are_laid_on_districts_together() {
    let place = place(PLAIN);
    let names = script::Host::new(vec![]).preset_names();
    let mut laid = 0;
    for name in &names {
        let mut loaded = load(place.path(), None).expect("a city");
        let preset = loaded.host.preset(name).expect("sound");
        if preset.class() != "minors" || name.ends_with("mountain_road") {
            continue;
        }
        // Over another one, whose values then hold elsewhere.
        for assignment in ["city=waterfront".to_owned(), format!("district:west={name}")] {
            loaded.lay(&assignment).unwrap_or_else(|error| panic!("{assignment}: {error}"));
        }
        let sources = loaded.read().unwrap_or_else(|error| panic!("{name}: {error}"));
        let chain_of = |plan: &script::StreetPlan| {
            plan.chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default())
                .unwrap_or_else(|fault| panic!("{fault}"))
        };
        let there = chain_of(sources.plan.minors.as_ref().expect("minors")).at(Vec2::new(100.0, 200.0));
        // What the preset alone keeps to, it keeps to in its district.
        let mut alone = load(place.path(), None).expect("a city");
        alone.lay(&format!("city={name}")).expect("laid");
        let alone = chain_of(alone.read().expect("read").plan.minors.as_ref().expect("minors"));
        if let (Some(there), Some(_)) = (there, preset.streets().filter(|streets| !streets.constraints.is_empty())) {
            assert_eq!(there.steps(), alone.steps(), "{name}");
            laid += 1;
        }
    }
    assert!(laid >= 8, "{laid}");
}

fn refused(loaded: &mut Loaded, assignment: &str) -> String {
    loaded.lay(assignment).expect_err("nonsense").to_string()
}

#[test]
fn nonsense_is_told_with_what_to_do() {
    let place = place(PLAIN);
    let mut loaded = load(place.path(), None).expect("a city");
    let cases = [
        ("minros=mine", "did you mean `minors`?"),
        ("quarter:12=mine", "names no quarter"),
        ("medeival_core", "did you mean `presets/medieval_core`?"),
        ("majors=presets/nothing", "there is no"),
    ];
    for (assignment, words) in cases {
        let told = refused(&mut loaded, assignment);
        assert!(told.contains(words), "{assignment}: {told}");
    }
    // What is made for majors is no district's and no quarter's.
    for target in ["district:west", "quarter:0123456789abcdef0123456789abcdef"] {
        assert!(refused(&mut loaded, &format!("{target}=avenues")).contains("is made for majors"));
    }
    // Constraints of another rule cannot hold in one district alone.
    assert!(refused(&mut loaded, "district:west=mountain_road").contains("cannot be laid on a district"));
    for (text, words) in [
        ("//! x\npreset(#{ });", "this preset holds nothing"),
        ("//! x\nlet a = 1;", "this file tells no preset"),
        ("//! x\npreset(#{ width: 9 });", "needs `pattern: …`"),
        ("//! x\npreset(#{ patern: rule(\"streets/grid\") });", "did you mean `pattern`?"),
        ("//! x\npreset(#{ parcels: rule(\"streets/grid\") });", "has no `fn subdivide(block, p)`"),
        ("//! x\npreset(#{ pattern: rule(\"streets/grid\", #{ heding: 3 }) });", "did you mean `heading`?"),
        ("//! x\npreset(#{ pattern: rule(\"streets/grid\"), class: \"roads\" });", "`class` must be one of"),
    ] {
        fs::write(place.path().join("presets/mine.rhai"), text).expect("written");
        // Each file is read once: another reading sees the change.
        let mut loaded = load(place.path(), None).expect("a city");
        let error = loaded.lay("mine").expect_err("nonsense");
        assert!(error.to_string().contains(words), "{text}: {error}");
        assert!(matches!(error, PresetError::Preset(_)), "{text}: {error:?}");
    }
}

#[test]
fn the_library_has_presets_that_grow_and_show_what_they_make() {
    let host = script::Host::new(vec![]);
    let names = host.preset_names();
    assert!(names.len() >= 12, "{names:?}");
    for name in names {
        let preset = host.preset(&name).unwrap_or_else(|faults| panic!("{faults:?}"));
        assert!(preset.about().len() > 20, "{name} does not say what it is");
        let drawn = city::testing::picture(&preset).unwrap_or_else(|error| panic!("{name}: {error}"));
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../rules/{name}.png"));
        // `plat rules presets --pictures rules/presets` draws them anew.
        assert!(
            fs::read(&path).is_ok_and(|shipped| shipped == drawn),
            "{} is not what the preset makes",
            path.display()
        );
    }
}

#[test]
fn what_the_command_line_changes_is_its_own_mistake() {
    let place = place(PLAIN);
    let build = |more: &[&str]| plat(place.path(), &[&["build", ".", "-o", "out", "--quiet"], more].concat());
    let wrong = "district:wets=mine";
    check(&build(&["--preset", wrong]), 2, &["--preset district:wets=mine", "did you mean `west`?"]);
    assert!(!place.path().join("out").exists(), "nothing is left behind");
    // What is wrong without it is the script's.
    let script = fs::read_to_string(place.path().join("city.rhai")).expect("a script");
    let broken = script.replace("block_length: 120", "block_length: by_district(#{ wets: 90 }, 120)");
    assert_ne!(script, broken);
    fs::write(place.path().join("city.rhai"), broken).expect("written");
    check(&build(&["--preset", "minors=mine", "--set", "buildings.low=2"]), 0, &[]);
    check(&build(&["--set", "buildings.low=2"]), 3, &["city.rhai", "did you mean `west`?"]);
}
