//! Every parameter of every rule of the library does something: set from outside, in a preset file, and in one district.

use city::testing::side_by_side;
use city::{Cancel, Loaded, Settings, Silent, build, load};
use script::{Domain, Host, Param, Rule, RuleKind};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What a parameter needs to show that it does something, where the usual does not do.
struct Needs {
    param: &'static str,
    /// A value to set it to.
    value: &'static str,
    /// Other parameters of the rule.
    with: &'static str,
    /// The ground.
    ground: &'static str,
}

const FLAT: &str = "density: |x, y| 30000 * exp(-hypot(x - 230, y - 250) / 200)";
const HILL: &str = "elevation: |x, y| 90 * exp(-(pow(x - 230, 2) + pow(y - 240, 2)) / 15000)";
const RIVER: &str = "land: |x, y| abs(x - 120 - 20 * sin(y / 60)) > 14 && abs(x - 390 - 20 * sin(y / 60)) > 14";
const ZONES: &str = "zones: |x, y| 1 + floor(y / 170), density: 3000";
const PARKS: &str = "parks: |x, y| hypot(x - 150, y - 300) < 60 || hypot(x - 350, y - 200) < 60";
const SQUARES: &str = "parks: |x, y| hypot(x % 100 - 50, y % 100 - 50) < 24";
/// A coast in the west, from which the ground rises.
const COAST: &str = "land: |x, y| x > 60, elevation: |x, y| max(0, (x - 60) * 0.08)";
const CENTRES: &str = "density: |x, y| 20000 * exp(-hypot(x - 100, y - 120) / 60) + 15000 * exp(-hypot(x - 420, y - 400) / 60) + 9000 * exp(-hypot(x - 130, y - 410) / 50)";

const fn needs(param: &'static str, value: &'static str, with: &'static str, ground: &'static str) -> Needs {
    Needs { param, value, with, ground }
}

/// The usual ground of a rule, and what single parameters need besides.
fn needs_of(rule: &str) -> (&'static str, Vec<Needs>) {
    match rule {
        "buildings/zoned" => (
            FLAT,
            vec![
                needs(
                    "zones",
                    "other",
                    "",
                    "zones: |x, y| 1 + floor(y / 170), other: |x, y| 1 + floor(x / 170), density: 3000",
                ),
                needs("residential", "2", "", ZONES),
                needs("commercial", "1", "", ZONES),
                needs("skyscraper", "1", "", ZONES),
                needs("crowded", "2000", "", FLAT),
                needs("tower_floors", "30", "crowded: 1, tower_area: 50, slenderness: 20", FLAT),
                needs("tower_area", "9000", "crowded: 1", FLAT),
                needs("main_street", "500", "busy: 1000000, crowded: 1000000", FLAT),
                needs("slenderness", "1", "crowded: 1, tower_area: 50", FLAT),
                needs("least_area", "600", "", FLAT),
                needs("side", "5", "busy: 1000000, crowded: 1000000", FLAT),
                needs("front", "1", "busy: 1000000, crowded: 1000000", FLAT),
                needs("rear", "1", "busy: 1000000, crowded: 1000000", FLAT),
                needs("house_floors", "9", "busy: 1000000, crowded: 1000000", FLAT),
                needs("coverage", "0.2", "busy: 1000000, crowded: 1000000", FLAT),
            ],
        ),
        "buildings/extruded" => (FLAT, vec![needs("least_area", "600", "", FLAT)]),
        "parcels/zoned" => (
            FLAT,
            vec![
                needs(
                    "zones",
                    "other",
                    "",
                    "zones: |x, y| 1 + floor(y / 170), other: |x, y| 1 + floor(x / 170), density: 3000",
                ),
                needs("residential", "2", "", ZONES),
                needs("commercial", "1", "", ZONES),
                needs("skyscraper", "1", "", ZONES),
                needs("crowded", "2000", "", FLAT),
                needs("main_street", "500", "busy: 1000000, crowded: 1000000", FLAT),
                needs("tower", "1500", "crowded: 1", FLAT),
                needs("house", "200", "busy: 30000", FLAT),
                needs("garden", "400", "busy: 1000000, crowded: 1000000", FLAT),
                needs("shop", "500", "busy: 0, crowded: 1000000", FLAT),
            ],
        ),
        "parcels/recursive" => (
            FLAT,
            vec![
                needs("least_area", "500", "", FLAT),
                needs("forced_access", "0", "join: false", FLAT),
                needs("join", "false", "forced_access: 0.2, least_frontage: 30", FLAT),
                needs("inner", "built", "forced_access: 0, join: false, most_area: 300", FLAT),
                needs("least_convexity", "0.98", "irregularity: 0.4, most_area: 2500, squared: \"side\"", RIVER),
                needs("least_frontage", "30", "", FLAT),
                needs("squared", "side", "", FLAT),
            ],
        ),
        "constraints/standard" => (
            FLAT,
            vec![
                needs("prune", "0.05", "", RIVER),
                needs("turn_step", "2", "", RIVER),
                needs("turn_most", "5", "", RIVER),
                needs("turn_first", "true", "", RIVER),
                needs("bridge", "60", "", RIVER),
                needs("bridge_spacing", "20", "bridge: 60", RIVER),
                needs("bridge_over", "any", "bridge: 200, bridge_spacing: 20", SQUARES),
                needs("bridge_first", "true", "bridge: 60, bridge_spacing: 20, turn_first: true", RIVER),
                needs("max_slope", "0.1", "", HILL),
                needs("longest", "40", "", FLAT),
                needs("least_length", "40", "", FLAT),
                needs("extend", "3", "", FLAT),
                needs("extend_most", "0", "", FLAT),
            ],
        ),
        "constraints/mountain" => (
            HILL,
            vec![
                needs("turn_first", "true", "", RIVER),
                needs("bridge", "60", "", RIVER),
                needs("tunnel", "0", "max_slope: 0.06, turn_most: 10, hairpin: false", HILL),
                needs("hairpin", "false", "max_slope: 0.08, tunnel: 0, turn_most: 25, turn_step: 5", HILL),
                needs("duplicate", "30", "", FLAT),
                needs("longest", "30", "", HILL),
                needs("arms", "3", "", FLAT),
                needs("least_length", "40", "", FLAT),
            ],
        ),
        "constraints/clear_of_parks" => (
            PARKS,
            vec![needs(
                "parks",
                "other",
                "",
                "parks: |x, y| hypot(x - 150, y - 300) < 60, other: |x, y| hypot(x - 350, y - 200) < 60 || hypot(x - 120, y - 120) < 40",
            )],
        ),
        "goals/settled" => (
            FLAT,
            vec![
                needs(
                    "map",
                    "other",
                    "",
                    "density: |x, y| 30000 * exp(-hypot(x - 230, y - 250) / 200), other: |x, y| 8 * x",
                ),
                needs("least", "12000", "", FLAT),
                needs("pace", "60", "", FLAT),
                needs("consume", "2000", "", FLAT),
            ],
        ),
        "streets/contour" => (
            HILL,
            vec![
                needs("flat", "0.4", "", HILL),
                needs("most", "40", "least: 30", HILL),
                needs("irregularity", "0.5", "", HILL),
                needs("connector", "9", "", HILL),
                needs("climb", "1", "", HILL),
            ],
        ),
        "streets/corniche" => (
            COAST,
            vec![
                needs("flat", "0.5", "", COAST),
                needs("back", "5", "shore: 200", COAST),
                needs("ease", "12", "shore: 200", COAST),
                needs("turn", "3", "shore: 200", COAST),
            ],
        ),
        "streets/highway" => (
            CENTRES,
            vec![
                needs("length", "60", "hub: 60, near: 20, radius: 600", CENTRES),
                needs("aim", "centres", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("every", "2", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("near", "250", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("radius", "220", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("spread", "20", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("rays", "3", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("turn", "40", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("hub", "150", "length: 40, hub: 60, near: 20, radius: 600", CENTRES),
                needs("patience", "30", "length: 40, hub: 100, near: 20, radius: 600, every: 2", CENTRES),
            ],
        ),
        "streets/radial" => (
            FLAT,
            vec![
                needs("x", "120", "centre: \"given\", y: 200, inner: 40, ring: 60, arc: 70", FLAT),
                needs("y", "120", "centre: \"given\", x: 200, inner: 40, ring: 60, arc: 70", FLAT),
                needs("centre", "quarter", "inner: 40, ring: 60, arc: 70", FLAT),
                needs("rays", "13", "inner: 60, ring: 80, arc: 90", FLAT),
                needs("arc", "40", "inner: 60, ring: 80", FLAT),
            ],
        ),
        "streets/loose_grid" => (FLAT, vec![needs("heading", "20", "", FLAT), needs("block_length", "90", "", FLAT)]),
        "streets/grid" | "streets/quarter_grid" => (
            FLAT,
            vec![
                needs("heading", "20", "", FLAT),
                needs("block_length", "90", "", FLAT),
                needs("x", "33", "", FLAT),
                needs("y", "33", "", FLAT),
                needs("block_width", "40", "block_length: 90", FLAT),
                needs("crossings", "120", "block_length: 90", FLAT),
            ],
        ),
        "streets/organic" => (FLAT, vec![needs("width_deviation", "4", "", FLAT), needs("patience", "30", "", FLAT)]),
        other => panic!("{other} is new: say on which ground it shows what it does"),
    }
}

/// The role of a rule in the city that it is tried in, and what is put for it in a preset.
fn role_of(rule: &Rule) -> (&'static str, &'static str) {
    let has = |kind: RuleKind| rule.kinds().contains(&kind);
    match rule.name() {
        "streets/corniche" | "streets/highway" => ("majors.pattern", "pattern"),
        _ if has(RuleKind::Streets) => ("minors.pattern", "pattern"),
        _ if has(RuleKind::Goals) => ("minors.goals", "goals"),
        _ if has(RuleKind::Constraints) => ("minors.constraints", "constraints"),
        _ if has(RuleKind::Constrain) => ("minors.constraints.2", "constraints"),
        _ if has(RuleKind::Parcels) => ("parcels", "parcels"),
        _ => ("buildings", "buildings"),
    }
}

/// The script of a city in which a rule has its role, called by this expression.
fn script(role: &str, ground: &str, called: &str) -> String {
    let plain = "rule(\"streets/grid\", #{ heading: 0, block_length: 130, block_width: 90 })";
    let winding = "rule(\"streets/organic\")";
    let site = format!(
        "let place = site(#{{ size: [500, 500], {ground}, districts: |x, y| if x < 250 {{ \"west\" }} else {{ \"east\" }} }});"
    );
    let ring = "given: [line([[30, 90], [470, 30], [450, 460], [60, 430], [30, 90]], #{ width: 8 })]";
    let frame = "given: [line([[20, 250], [480, 250]], #{ class: \"major\" })]";
    let parts = match role {
        "majors.pattern" => format!("majors: streets(#{{ pattern: {called}, width: 8 }})"),
        "minors.pattern" => format!("{ring}, minors: streets(#{{ pattern: {called}, width: 8 }})"),
        "minors.goals" => format!("minors: streets(#{{ pattern: {winding}, goals: {called} }})"),
        "minors.constraints" => format!(
            "barred: [{}], minors: streets(#{{ pattern: {winding}, constraints: {called}, width: 8 }})",
            if ground.contains("parks") { "place.map(\"parks\")" } else { "" }
        ),
        "minors.constraints.2" => {
            format!(
                "minors: streets(#{{ pattern: {winding}, constraints: [rule(\"constraints/standard\"), {called}], width: 8 }})"
            )
        }
        "parcels" => format!("{frame}, minors: streets(#{{ pattern: {plain} }}), parcels: {called}"),
        _ => format!(
            "{frame}, minors: streets(#{{ pattern: {plain} }}), parcels: rule(\"parcels/recursive\"), buildings: {called}"
        ),
    };
    format!("{site}\ncity(#{{ site: place, seed: 3, {parts} }});\n")
}

/// All that lies in the city, and what it is called.
fn built(loaded: &Loaded) -> BTreeMap<(String, String), String> {
    let sources = loaded.read().unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings { threads: 1, ..Settings::default() };
    match build(&sources, settings, &Silent, &Cancel::default()) {
        Ok(built) => {
            assert!(built.report.faults.iter().all(|fault| !fault.is_error()), "{:?}", built.report.faults);
            suite::features(&built.city)
        }
        // Nothing grows: that is something, too.
        Err(_) => BTreeMap::new(),
    }
}

fn written(folder: &Path, text: &str) -> Loaded {
    fs::write(folder.join("city.rhai"), text).expect("the folder is ours");
    load(folder, None).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A value as scripts write it.
fn literal(param: &Param, value: &str) -> String {
    match param.domain {
        Domain::Number { .. } | Domain::Whole { .. } | Domain::Flag => value.to_owned(),
        _ => format!("\"{value}\""),
    }
}

/// Another value than the default, where the table tells none: half as much again, or something of little.
fn another(param: &Param) -> String {
    match &param.domain {
        Domain::Number { range: (low, high), .. } => {
            let default: f64 = param.default.to_string().parse().expect("a number");
            let more = if default == 0.0 { 20.0 } else { default.abs() * 1.6 };
            let value = match (more <= *high, default == 0.0) {
                (true, _) => more,
                (false, true) => high / 2.0,
                (false, false) => default / 2.0,
            };
            value.clamp(*low, *high).to_string()
        }
        Domain::Whole { .. } => (param.default.to_string().parse::<i64>().expect("a number") + 3).to_string(),
        Domain::Flag => (param.default.to_string() != "true").to_string(),
        Domain::Choice(words) => {
            words.iter().find(|word| **word != param.default.to_string()).expect("a choice").clone()
        }
        Domain::Map | Domain::Colour => panic!("say another value of `{}`", param.name),
    }
}

/// What holds for the whole city, and is refused by place.
const EVERYWHERE: [(&str, &str); 2] = [("goals/settled", "map"), ("goals/settled", "consume")];

#[test]
fn every_parameter_does_something_wherever_it_is_set() {
    let host = Host::new(vec![]);
    let names = host.names();
    let rules: Vec<Rule> = names.iter().map(|name| host.rule(name).expect("a rule of the library")).collect();
    let all: Vec<(&Rule, &Param)> =
        rules.iter().flat_map(|rule| rule.params().iter().map(move |(param, _)| (rule, param))).collect();
    let tried = side_by_side(0, &all, |(rule, param)| {
        let (usual, table) = needs_of(rule.name());
        let own = table.iter().find(|needs| needs.param == param.name);
        let value = own.map_or_else(|| another(param), |needs| needs.value.to_owned());
        let (ground, with) = own.map_or((usual, ""), |needs| (needs.ground, needs.with));
        let problems = problems(rule, param, &value, ground, with).into_iter();
        problems.map(|problem| format!("{}: {} = {value} {problem}", rule.name(), param.name)).collect::<Vec<_>>()
    });
    let idle: Vec<String> = tried.expect("threads").concat();
    assert!(idle.is_empty(), "{} parameters do nothing:\n{}", idle.len(), idle.join("\n"));
}

/// Where setting a parameter does nothing, or not the same.
fn problems(rule: &Rule, param: &Param, value: &str, ground: &str, with: &str) -> Vec<&'static str> {
    let folder = tempfile::tempdir().expect("a folder");
    let (role, slot) = role_of(rule);
    let name = rule.name();
    let usual = format!("rule(\"{name}\", #{{ {with} }})");
    let mut loaded = written(folder.path(), &script(role, ground, &usual));
    let before = built(&loaded);
    loaded.set(&format!("{role}.{}={value}", param.name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let set = built(&loaded);
    let mut problems = Vec::new();
    if set == before {
        problems.push("does nothing");
    }
    // In a preset file.
    let others: Vec<&str> = with.split(", ").filter(|other| !other.starts_with(&format!("{}:", param.name))).collect();
    let with = others.join(", ");
    let (comma, told) = (if with.is_empty() { "" } else { ", " }, literal(param, value));
    let chosen = format!("rule(\"{name}\", #{{ {with}{comma}{}: {told} }})", param.name);
    let list = if role.ends_with(".2") { format!("[rule(\"constraints/standard\"), {chosen}]") } else { chosen };
    let pattern = if matches!(slot, "goals" | "constraints") { "pattern: rule(\"streets/organic\"), " } else { "" };
    let class = if role.starts_with("majors") { "class: \"majors\", " } else { "" };
    fs::create_dir_all(folder.path().join("presets")).expect("a folder");
    fs::write(
        folder.path().join("presets/mine.rhai"),
        format!("//! Mine.\npreset(#{{ {class}{pattern}{slot}: {list} }});\n"),
    )
    .expect("the folder is ours");
    let mut loaded = written(folder.path(), &script(role, ground, &usual));
    loaded.lay("mine").unwrap_or_else(|error| panic!("{name}: {error}"));
    if built(&loaded) != set {
        problems.push("is not the same in a preset");
    }
    // In one district: there it does something, or is refused.
    let default = literal(param, &param.default.to_string());
    let here =
        format!("rule(\"{name}\", #{{ {with}{comma}{}: by_district(#{{ west: {told} }}, {default}) }})", param.name);
    fs::write(folder.path().join("city.rhai"), script(role, ground, &here)).expect("the folder is ours");
    let placed = load(folder.path(), None).and_then(|loaded| loaded.read().map(|_| loaded));
    match (placed, EVERYWHERE.contains(&(name, &param.name))) {
        (Ok(_), true) => problems.push("is taken by district, but holds everywhere"),
        (Err(_), false) => problems.push("is refused by district"),
        (Ok(loaded), false) if built(&loaded) == before => problems.push("does nothing in a district"),
        _ => {}
    }
    problems
}
