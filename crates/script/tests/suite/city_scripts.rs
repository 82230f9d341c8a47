//! City scripts: plans, roles, errors.

use crate::common::{Folders, city, headline, shelf};
use geom::{Angle, Id, Vec2};
use script::{Fault, Host, Literal, Plan, Source, Value, WeightPlan};
use std::sync::Arc;
use streets::{Classes, StreetId};

const WHOLE: &str = r#"
let site = site("maps");
let dense = site.map("density.png", #{ pixel_size_m: 10, scale: 2, units: "people/km2" });
print("hello");
city(#{
    site: site, within: site.map("borough"), barred: [site.map("parks")], seed: 1625,
    given: [line([[0, 0], [100.5, 50], [200, 50]], #{ class: "highway", width: 30, name: "Broadway" })],
    imported: streets_from("old/streets.geojson", #{ class: "minor", classes: #{ primary: "major" }, widths: #{ primary: 24 } }),
    majors: streets(#{ pattern: rule("streets/grid", #{ block_length: 400 }), goals: rule("goals/settled", #{ least: 900 }),
                       constraints: rule("constraints/standard", #{ snap: 8, least_angle: 30 }), width: 26 }),
    minors: streets(#{ pattern: rule("streets/grid"), goals: density(dense, #{ least: 500, pace: 4 }) }),
    parcels: rule("parcels/recursive"),
    buildings: rule("buildings/extruded"),
    quarters: #{ "0123456789abcdef0123456789abcdef": #{ seed: 7, block_width: 90, "parcels.least_area": 300 } },
    remove: ["00000000000000000000000000000005"],
});
"#;

fn whole() -> Plan {
    city(WHOLE).unwrap_or_else(|fault| panic!("{fault}")).plan
}

fn number(number: f64) -> Value {
    Literal::Number(number).into()
}

/// A city on flat land with one more option.
fn with(option: &str) -> Result<Plan, Fault> {
    city(&format!("city(#{{\n  site: site(#{{ size: [3000, 2000] }}),\n  {option}\n}});"))
        .map(|evaluated| evaluated.plan)
}

fn says(option: &str) -> String {
    headline(&with(option).err().unwrap_or_else(|| panic!("`{option}` was taken")))
}

#[test]
fn a_whole_script_is_read() {
    let plan = whole();
    assert_eq!(plan.seed, 1625);
    assert_eq!(plan.site.folder.as_deref(), Some("maps"));
    let dense = &plan.site.maps["density"];
    assert_eq!((dense.pixel_size, dense.scale, dense.units.as_deref()), (Some(10.0), Some(2.0), Some("people/km2")));
    assert_eq!(plan.within.as_ref().map(|map| map.name.as_str()), Some("borough"));
    assert_eq!(plan.barred.iter().map(|map| map.name.as_str()).collect::<Vec<_>>(), ["parks"]);
    let line = &plan.given[0];
    assert_eq!(line.points, [Vec2::new(0.0, 0.0), Vec2::new(100.5, 50.0), Vec2::new(200.0, 50.0)]);
    assert_eq!((line.class, line.width, line.name.as_deref()), (Classes::HIGHWAY, Some(30.0), Some("Broadway")));
    let import = &plan.imports[0];
    assert_eq!((import.file.as_str(), import.class), ("old/streets.geojson", Some(Classes::MINOR)));
    assert_eq!((import.classes["primary"], import.widths["primary"]), (Classes::MAJOR, 24.0));
    assert_eq!(plan.removed, [StreetId(Id(5))]);
}

/// What streets keep to; that of majors where the plan says nothing.
fn chain(plan: &script::StreetPlan) -> streets::growth::Chain {
    let standard = streets::growth::Constraints::majors().into();
    plan.chain(standard, &Arc::default(), &Arc::default()).expect("evaluates")
}

#[test]
fn stages_say_where_they_start_and_how_they_end() {
    let grid = r#"pattern: rule("streets/grid")"#;
    let plan = with(&format!(
        "highways: streets(#{{ {grid}, seeds: [[100, 200]], reseed: 2500, smooth: false }}),\n\
         minors: streets(#{{ {grid}, sprout: false, least_dead_end: 40, least_network: 900 }}),"
    ));
    let plan = plan.unwrap_or_else(|fault| panic!("{fault}"));
    let (highways, minors) = (plan.highways.as_ref().expect("highways"), plan.minors.as_ref().expect("minors"));
    assert_eq!((highways.seeds.as_slice(), highways.reseed), ([Vec2::new(100.0, 200.0)].as_slice(), Some(2500.0)));
    assert_eq!((highways.smooth, highways.sprout), (Some(false), true));
    assert_eq!((minors.smooth, minors.sprout), (None, false));
    assert_eq!((minors.least_dead_end, minors.least_network), (40.0, 900.0));
    let roles: Vec<_> = plan.roles().into_iter().map(|(role, _)| role).collect();
    assert_eq!(roles, ["highways.pattern", "minors.pattern"]);
    for (wrong, message) in [
        ("seeds: [7]", "a point is written [x, y] in metres"),
        ("seeds: [[1e9, 0]]", "a point lies more than 500 km away"),
        ("reseed: 1", "`reseed` must lie between 10 and 100000 m"),
        ("smooth: 3", "`smooth` must be true or false, not a whole number"),
        ("least_dead_end: -1", "`least_dead_end` must lie between 0 and 100000 m"),
        ("least_network: 1e6", "`least_network` must lie between 0 and 100000 m"),
    ] {
        let said = says(&format!("highways: streets(#{{ {grid}, {wrong} }}),"));
        assert!(said.contains(message), "{wrong}: {said}");
    }
}

#[test]
fn streets_carry_goals_and_constraints() {
    let plan = whole();
    let (majors, minors) = (plan.majors.expect("majors"), plan.minors.expect("minors"));
    assert_eq!(majors.constant_width(), Some(26.0));
    let goal = majors.goal().expect("evaluates").expect("a goal");
    assert_eq!(
        (goal.map.name.as_str(), goal.least, goal.pace, goal.full),
        ("density", number(900.0), number(0.0), None)
    );
    let told = streets::growth::Constraints {
        snap: 8.0,
        least_angle: Angle::degrees(30.0),
        max_slope: 1.0,
        ..Default::default()
    };
    assert_eq!(chain(&majors), told.into());
    assert_eq!(chain(&minors), streets::growth::Constraints::majors().into(), "what the kernel says");
    assert_eq!(
        minors.goal().expect("evaluates").map(|goal| (goal.least, goal.pace)),
        Some((number(500.0), number(4.0)))
    );
}

#[test]
fn the_standard_constraints_are_the_kernel_s() {
    let plan =
        with("minors: streets(#{ pattern: rule(\"streets/grid\"), constraints: rule(\"constraints/standard\") })");
    let told = plan.expect("fine").minors.expect("minors");
    let kernel = streets::growth::Constraints::default();
    // A parameter has a range, so the library says 100 % where the kernel has no limit.
    assert_eq!(chain(&told), streets::growth::Constraints { max_slope: 1.0, ..kernel }.into());
}

#[test]
fn quarters_differ_in_what_they_say() {
    let mut plan = whole();
    let quarter: Id = "0123456789abcdef0123456789abcdef".parse().expect("an id");
    let number = |rule: Option<script::Rule>, name: &str| {
        rule.and_then(|rule| rule.params().get(name).and_then(|value| value.constant().cloned()))
    };
    plan.set("minors.pattern.block_width=120").expect("in range");
    plan.set("minors.pattern.block_length=300").expect("in range");
    let rule_in = |quarter: Id, role: &str| plan.in_quarter(Some(quarter)).rule_of(role).cloned();
    let here = rule_in(quarter, "minors.pattern");
    assert_eq!(number(here.clone(), "block_width"), Some(Literal::Number(90.0)));
    assert_eq!(number(here, "block_length"), Some(Literal::Number(300.0)));
    assert_eq!(number(rule_in(Id(1), "minors.pattern"), "block_width"), Some(Literal::Number(120.0)));
    assert_eq!(number(rule_in(quarter, "parcels"), "least_area"), Some(Literal::Number(300.0)));
    assert_eq!((plan.seed_in(quarter), plan.seed_in(Id(1))), (Some(7), None));
    assert!(plan.rule_of("majors.roof").is_none());
}

#[test]
fn parameters_are_addressed_by_role() {
    let mut plan = whole();
    let roles: Vec<String> = plan.roles().into_iter().map(|(role, _)| role).collect();
    let wanted = ["majors.goals", "majors.pattern", "majors.constraints", "minors.pattern", "parcels", "buildings"];
    assert_eq!(roles, wanted);
    for parameter in plan.parameters() {
        plan.set(&format!("{}={}", parameter.address, parameter.value)).expect("its own value");
    }
    plan.set("seed=9").expect("a seed");
    plan.set("majors.constraints.snap=12").expect("in range");
    assert_eq!(plan.seed, 9);
    assert_eq!(chain(plan.majors.as_ref().expect("majors")).snap(), 12.0);
}

#[test]
fn wrong_assignments_are_told() {
    let mut plan = whole();
    let mut error = |text: &str| plan.set(text).expect_err("wrong");
    let unknown = error("minors.patern.block_width=90");
    assert_eq!(unknown.message, "nothing in this city is called `minors.patern.block_width`");
    assert_eq!(unknown.hint.as_deref(), Some("did you mean `minors.pattern.block_width`?"));
    assert_eq!(error("minors.pattern.block_widht=90").hint.as_deref(), Some("did you mean `block_width`?"));
    let outside = error("minors.pattern.block_width=1").message;
    assert!(outside.starts_with("`block_width` must be a number from ") && outside.ends_with(" m, not 1"), "{outside}");
    assert_eq!(error("nonsense").message, "`nonsense` sets nothing: it has no `=`");
    assert_eq!(error("seed=-3").message, "`seed` must be a whole number from 0, not `-3`");
    assert!(error("roads=1").hint.expect("a hint").starts_with("the roles of this city are `majors.goals`"));
}

#[test]
fn a_flat_site_needs_no_maps() {
    let plan = with("seed: 1").expect("fine");
    assert_eq!((plan.site.folder, plan.site.size), (None, Some(Vec2::new(3000.0, 2000.0))));
    assert!(plan.majors.is_none() && plan.minors.is_none() && plan.parcels.is_none());
}

#[test]
fn mistakes_are_placed_on_their_keys() {
    let cases = [
        ("sede: 3", "3:3: city has no option `sede`"),
        ("seed: -3", "3:3: `seed` must be a whole number from 0"),
        ("within: \"borough\"", "3:3: `within` must be a map, site.map(\"…\"), not a text"),
        ("minors: rule(\"streets/grid\")", "3:3: `minors` must be streets(…), not a rule"),
        ("minors: streets(#{ })", "3:11: streets needs `pattern: …`"),
        (
            "minors: streets(#{ pattern: rule(\"parcels/recursive\") })",
            "3:22: rule `parcels/recursive` has no `fn propose(tip, p)`",
        ),
        (
            "minors: streets(#{ pattern: rule(\"streets/gird\") })",
            "3:31: rule \"streets/gird\": there is no rule of that name in the built-in library",
        ),
        ("parcels: rule(\"parcels/recursive\", #{ most: 3 })", "3:41: there is no parameter `most`"),
        (
            "parcels: rule(\"parcels/recursive\", #{ most_area: 3 })",
            "3:41: `most_area` must be a number from 20 to 1000000, not 3",
        ),
        (
            "parcels: rule(\"parcels/recursive\", #{ most_area: \"x\" })",
            "3:41: `most_area` must be a number from 20 to 1000000, not a text",
        ),
        ("given: line([[0, 0], [1, 1]])", "3:3: `given` must be a list […], not line(…)"),
        ("given: [line([[0, 0]])]", "3:11: a line needs two different points"),
        ("given: [line([[0, 0], [1]])]", "3:11: a point is written [x, y] in metres"),
        ("given: [line([[0, 0], [1e7, 0]])]", "3:11: a point lies more than 500 km away"),
        ("given: [line([[0, 0], [9, 9]], #{ class: \"mayor\" })]", "3:37: there is no street class `mayor`"),
        ("given: [line([[0, 0], [9, 9]], #{ width: 900 })]", "3:37: `width` must lie between 0.5 and 200 m"),
        ("imported: streets_from(\"../a.osm\")", "3:13: `../a.osm` is not a file below the script's folder"),
        ("imported: streets_from(\"a.shp\")", "3:13: `a.shp` is no file of streets"),
        ("import: 3", "3:3: expecting the name of a property"),
        ("remove: [\"12\"]", "3:3: `12` is no id"),
        ("quarters: #{ a: #{} }", "3:3: `a` is no id"),
        (
            "quarters: #{ \"0123456789abcdef0123456789abcdef\": #{ \"minors.width\": \"wide\" } }",
            "3:3: `width` must be a number from 0.5 to 200 m, not a text",
        ),
    ];
    for (option, wanted) in cases {
        assert_eq!(says(option), format!("city.rhai:{wanted}"), "{option}");
    }
}

#[test]
fn sites_are_asked_for_with_care() {
    let says = |text: &str| headline(&city(text).expect_err("wrong"));
    assert_eq!(says("site(\"../maps\");"), "city.rhai:1:1: `../maps` is not a folder below this one");
    assert_eq!(says("site(\"empty\");"), "city.rhai:1:1: there is no folder `empty`");
    assert_eq!(says("site(\"maps\").map(\"densty\");"), "city.rhai:1:14: the site has no map `densty`");
    assert_eq!(says("site(\"maps\").map(\"land\", #{ scael: 2 });"), "city.rhai:1:29: site.map has no option `scael`");
    assert_eq!(says("site(#{ size: [3, -2] });"), "city.rhai:1:9: a size must be above 0 and below 500 km");
    assert_eq!(says("site(#{ });"), "city.rhai:1:1: a site without maps needs a size");
}

#[test]
fn one_script_one_city() {
    assert_eq!(city("let x = 3;").expect_err("none").message, "the script ends without a city");
    let twice = "let s = site(#{ size: [9, 9] });\ncity(#{ site: s });\ncity(#{ site: s });";
    assert_eq!(headline(&city(twice).expect_err("two")), "city.rhai:3:1: city(…) is called twice");
    assert_eq!(city(WHOLE).expect("fine").printed, ["hello"]);
}

#[test]
fn faults_of_rules_are_told_in_the_rule() {
    let script = |pattern: &str| {
        let text =
            "city(#{ site: site(#{ size: [9, 9] }), minors: streets(#{ pattern: rule(\"mine\") }) });".to_owned();
        let host = Host::new(vec![shelf(&[("mine.rhai", pattern)])]);
        host.plan(&Source { text, path: "city.rhai".into() }, Arc::new(Folders)).map(|evaluated| evaluated.plan)
    };
    let fault = script("fn propose(tip, p) {\n  tip.aheda(3)\n}").expect_err("a typo");
    assert_eq!(headline(&fault), "mine.rhai:2:7: there is no function `aheda`");
    assert!(script("fn propose(tip, p) { }").is_ok());
}

#[test]
fn the_nearest_library_wins() {
    let own = "params(#{ mine: metres(3) });\nfn propose(tip, p) { }";
    let host = Host::new(vec![shelf(&[("streets/grid.rhai", own)]), shelf(&[("streets/grid.rhai", "no")])]);
    let rule = host.rule("streets/grid").expect("the first");
    assert!(rule.params().get("mine").is_some());
    assert_eq!(Host::new(vec![]).rule("streets/grid").expect("built in").path(), "rules/streets/grid.rhai");
    assert!(host.names().contains(&"buildings/extruded".to_owned()));
}

#[test]
fn all_that_is_wrong_behind_presets_is_told() {
    let files = [
        (
            "presets/lanes.rhai",
            "//! Lanes.\npreset(#{ pattern: rule(\"own\"), buildings: rule(\"huts\", #{ hihg: 3 }), parcels: rule(\"none\") });",
        ),
        ("own.rhai", "fn propose(tip, p) { tip.ahaed(50); }"),
        ("huts.rhai", "params(#{ high: number(3) });\nfn build(shape, p) { shape.extrude(p.high; }"),
    ];
    let host = Host::new(vec![shelf(&files)]);
    let text = "city(#{\n  site: site(#{ size: [900, 900] }),\n  preset: preset(\"lanes\"),\n  \
                minors: streets(#{ preset: preset(\"lnaes\") }),\n});";
    let checked = host.check_city(&Source { text: text.into(), path: "city.rhai".into() }, Arc::new(Folders));
    let told: Vec<String> =
        checked.faults.iter().map(|fault| format!("{}:{}:{}", fault.file, fault.line, fault.column)).collect();
    let wanted = ["own.rhai:1:26", "city.rhai:4:30", "huts.rhai:2:42", "presets/lanes.rhai:2:81"];
    assert_eq!(told, wanted, "{:?}", checked.faults);
    assert!(checked.evaluated.is_none() && host.preset("lanes").is_err_and(|faults| faults.len() == 3));
}

#[test]
fn wrong_goals_and_constraints_are_told() {
    let told = |name: &str, text: &str| {
        let city = format!(
            "city(#{{ site: site(#{{ size: [9, 9] }}),\n minors: streets(#{{ pattern: rule(\"streets/grid\"), {name}: rule(\"mine\") }}) }});"
        );
        let host = Host::new(vec![shelf(&[("mine.rhai", text)])]);
        headline(&host.plan(&Source { text: city, path: "city.rhai".into() }, Arc::new(Folders)).expect_err("wrong"))
    };
    let says = told("constraints", "fn constraints(p) { #{ snpa: 3 } }");
    assert_eq!(says, "mine.rhai:1:24: constraints(p): constraints has no option `snpa`");
    let says = told("constraints", "fn constraints(p) { 3 }");
    assert_eq!(says, "mine.rhai:1:4: constraints(p): returns a whole number");
    let says = told("goals", "fn goals(p) { 3 }");
    assert_eq!(says, "mine.rhai:1:4: goals(p): returns a whole number");
    let says = told("goals", "fn goals(p) {\n  p.nothing\n}");
    assert_eq!(says, "mine.rhai:2:5: p has no `nothing`");
}

/// A city with this pattern for its minors.
fn patterned(pattern: &str) -> Result<Plan, Fault> {
    let text =
        format!("let site = site(\"maps\");\ncity(#{{ site: site,\n  minors: streets(#{{ pattern: {pattern} }}) }});");
    city(&text).map(|evaluated| evaluated.plan)
}

#[test]
fn rules_add_and_weigh_like_images() {
    let pattern = "rule(\"streets/organic\") * site.map(\"borough\") + 0.5 * rule(\"streets/grid\", #{ heading: 3 }) * site.map(\"borough\").invert() * site.map(\"parks\") + rule(\"streets/grid\")";
    let mut plan = patterned(pattern).unwrap_or_else(|fault| panic!("{fault}"));
    let map = |name: &str| WeightPlan::Map(script::MapRef { name: name.to_owned() });
    let parts = |plan: &Plan| plan.minors.as_ref().expect("minors").pattern.parts().to_vec();
    let weights: Vec<WeightPlan> = parts(&plan).into_iter().map(|part| part.weight).collect();
    let inverse = WeightPlan::Inverse(Box::new(map("borough")));
    let scaled = WeightPlan::Product(vec![WeightPlan::Number(0.5), inverse]);
    assert_eq!(weights, [map("borough"), WeightPlan::Product(vec![scaled, map("parks")]), WeightPlan::Number(1.0)]);
    assert_eq!(
        plan.weight_maps().iter().map(|map| map.name.as_str()).collect::<Vec<_>>(),
        ["borough", "borough", "parks"]
    );
    let roles: Vec<String> = plan.roles().into_iter().map(|(role, _)| role).collect();
    assert_eq!(roles, ["minors.pattern.organic", "minors.pattern.grid", "minors.pattern.grid2"]);
    plan.set("minors.pattern.grid.block_width=90").expect("in range");
    let widths: Vec<_> =
        parts(&plan).iter().skip(1).map(|part| part.rule.params().get("block_width").cloned()).collect();
    assert_eq!(widths, [Some(Literal::Number(90.0).into()), Some(Literal::Number(80.0).into())]);
    let unknown = plan.set("minors.pattern.block_width=90").expect_err("of which rule");
    assert_eq!(unknown.hint.as_deref(), Some("did you mean `minors.pattern.grid.block_width`?"));
}

#[test]
fn one_rule_keeps_its_address_whatever_it_weighs() {
    for pattern in ["rule(\"streets/grid\")", "rule(\"streets/grid\") * site.map(\"parks\")"] {
        let plan = patterned(pattern).expect("fine");
        assert_eq!(plan.roles()[0].0, "minors.pattern", "{pattern}");
    }
    let weight = "rule(\"streets/grid\") * (site.map(\"parks\") + site.map(\"land\") * 2).invert()";
    assert!(matches!(
        patterned(weight).expect("fine").minors.expect("minors").pattern.parts()[0].weight,
        WeightPlan::Inverse(_)
    ));
}

#[test]
fn quarters_differ_in_one_of_several_patterns() {
    let quarter = |set: &str| {
        let text = format!(
            "let s = site(\"maps\");\ncity(#{{ site: s, minors: streets(#{{ pattern: rule(\"streets/organic\") + rule(\"streets/grid\") + rule(\"streets/grid\") }}),\n quarters: #{{ \"0123456789abcdef0123456789abcdef\": #{{ {set} }} }} }});"
        );
        city(&text).map(|evaluated| evaluated.plan)
    };
    let plan =
        quarter("branching: 0.2, \"minors.pattern.grid2.block_width\": 70").unwrap_or_else(|fault| panic!("{fault}"));
    let id: Id = "0123456789abcdef0123456789abcdef".parse().expect("an id");
    let own = plan.in_quarter(Some(id)).minors.clone().expect("minors").pattern;
    let value = |part: usize, name: &str| own.parts()[part].rule.params().get(name).cloned();
    assert_eq!(value(0, "branching"), Some(Literal::Number(0.2).into()));
    assert_eq!(
        (value(1, "block_width"), value(2, "block_width")),
        (Some(Literal::Number(80.0).into()), Some(Literal::Number(70.0).into()))
    );
    let fault = quarter("block_width: 70").expect_err("of which grid");
    assert_eq!(fault.message, "several patterns of the minors have a parameter `block_width`");
    assert!(fault.hint.expect("a hint").contains("\"minors.pattern.grid2.block_width\""));
}

#[test]
fn nonsense_of_rules_and_maps_is_told() {
    let grid = "rule(\"streets/grid\")";
    let map = "site.map(\"land\")";
    for (pattern, message) in [
        (format!("{grid} + {map}"), "a rule and a map cannot be added"),
        (format!("{grid} + 3"), "a rule and a number cannot be added"),
        (format!("{grid} * {grid}"), "a rule cannot be weighed with a rule"),
        (format!("{grid} * \"land\""), "a rule cannot be weighed with a text"),
        (format!("{grid} * -0.5"), "a weight must lie between 0 and 1000000"),
        (format!("1 - {map}"), "a map cannot be taken from a number"),
        (format!("rule(\"parcels/recursive\") * {map}"), "rule `parcels/recursive` has no `fn propose(tip, p)`"),
        (map.to_owned(), "`pattern` must be rule(\"…\"), not a map of the site"),
    ] {
        let fault = patterned(&pattern).err().unwrap_or_else(|| panic!("`{pattern}` was taken"));
        assert_eq!((fault.message.as_str(), fault.line), (message, 3), "{pattern}");
    }
}
