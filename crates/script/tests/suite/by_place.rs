//! Parameters that differ by place: from maps, by district, in quarters.

use crate::common::{self, Folders, headline, shelf, tip};
use geom::{Bounds, Point, Polygon, Raster, Seed, Vec2};
use proptest::prelude::*;
use script::{
    BlockContext, Evaluated, Fault, Faults, Host, ParcelChoice, ParcelPattern, Places, Plan, Rule, Source,
    StreetPattern,
};
use std::sync::Arc;
use streets::growth::{Chain, Field, GrowthRules, Step};
use streets::{Classes, Districts};

/// Streets of `p.width` metres, with `p.count` steps of delay and a turn where `p.style` says so.
const MINE: &str = r#"
params(#{
    width: metres(80).range(20, 500),
    count: whole(3).range(0, 9),
    style: choice("plain", ["plain", "bent"]),
});
fn propose(tip, p) {
    tip.ahead(p.width, #{ delay: p.count, turn: if p.style == "bent" { 10 } else { 0 } });
}
fn subdivide(block, p) { block.recursive(#{ least_area: p.width, most_area: 5000 }); }
"#;

fn city(values: &str, rest: &str) -> Result<Plan, Fault> {
    let text = format!(
        "let site = site(\"maps\");\ncity(#{{ site: site,\n  districts: site.districts(\"districts\", #{{ \"old town\": \"#c0392b\", harbour: \"#2980b9\" }}),\n  minors: streets(#{{ pattern: rule(\"mine\", #{{ {values} }}) }}), {rest} }});"
    );
    let host = Host::new(vec![shelf(&[("mine.rhai", MINE)])]);
    let evaluated = host.plan(&Source { text, path: "city.rhai".into() }, Arc::new(Folders));
    evaluated.map(|Evaluated { plan, .. }| plan)
}

/// A site of 1 km × 1 km: a map `density` that rises from 0 in the west to 1 in the east, the old town in the western
/// half, the harbour in its south-eastern corner.
fn places() -> Places {
    let values = (0..100).map(|column| column as f32 / 99.0).collect();
    let ramp = Raster::new(100, 1, 10.0, Vec2::ZERO, values).expect("a map");
    places_of(ramp)
}

fn places_of(map: Raster) -> Places {
    let corner = |x, y| Point::from_metres(Vec2::new(x, y));
    let area = |a, b| Polygon::rectangle(Bounds::between(a, b));
    let areas =
        vec![(1, area(corner(0.0, 0.0), corner(500.0, 1000.0))), (0, area(corner(800.0, 0.0), corner(1000.0, 200.0)))];
    let districts = Districts::of_areas(vec!["harbour".into(), "old town".into()], areas);
    Places { maps: [("density".to_owned(), Field::Map(Arc::new(map)))].into(), districts: Arc::new(districts) }
}

fn settled(values: &str) -> Plan {
    let mut plan = city(values, "").unwrap_or_else(|fault| panic!("{fault}"));
    plan.settle(places()).unwrap_or_else(|error| panic!("{error}"));
    plan
}

/// Length, delay and turn in degrees that the pattern proposes at a place.
fn proposed(rule: Rule, x: f64, y: f64) -> (f64, i32, i64) {
    let faults = Arc::new(Faults::default());
    let pattern = StreetPattern::new(rule, 0, Arc::new(Classes::default()), faults.clone());
    let mut tip = tip(0.0);
    tip.at = Point::from_metres(Vec2::new(x, y));
    pattern.propose(&mut tip);
    assert!(faults.is_empty(), "{:?}", faults.sorted());
    let slot = tip.slots.ahead.expect("it proposes");
    (slot.length, slot.delay, slot.turn.to_degrees().round() as i64)
}

fn pattern(plan: &Plan) -> Rule {
    plan.rule_of("minors.pattern").expect("a pattern").clone()
}

#[test]
fn a_map_tells_the_value_at_the_place() {
    let rule =
        pattern(&settled("width: site.map(\"density\").between(40, 200), count: site.map(\"density\").scale(8)"));
    let near = |(length, delay, _): (f64, i32, i64)| ((length * 10.0).round() / 10.0, delay);
    assert_eq!(near(proposed(rule.clone(), 0.0, 500.0)), (40.0, 0));
    assert_eq!(near(proposed(rule.clone(), 500.0, 500.0)), (120.0, 4));
    assert_eq!(near(proposed(rule, 1000.0, 500.0)), (200.0, 8));
}

#[test]
fn a_district_has_its_own_value() {
    let values = "width: by_district(#{ \"old town\": 30, harbour: site.map(\"density\").scale(100, 100) }, 90), \
                  count: by_district(#{ harbour: 7 }), style: by_district(#{ \"old town\": \"bent\" }, \"plain\")";
    let rule = pattern(&settled(values));
    assert_eq!(proposed(rule.clone(), 100.0, 900.0), (30.0, 3, 10));
    assert_eq!(proposed(rule.clone(), 600.0, 900.0), (90.0, 3, 0));
    let (length, delay, turn) = proposed(rule, 900.0, 100.0);
    assert!((length - 190.0).abs() < 1.0 && (delay, turn) == (7, 0), "{length} {delay} {turn}");
}

#[test]
fn blocks_are_asked_at_their_place_too() {
    let text = format!("parcels: rule(\"mine\", #{{ width: {} }})", "by_district(#{ \"old town\": 30 }, 90)");
    let mut plan = city("", &text).expect("fine");
    plan.settle(places()).expect("settles");
    let parcels = ParcelPattern::new(plan.rule_of("parcels").expect("a rule").clone(), Arc::default());
    let least_area = |x: f64| {
        let (place, seed, district) = (Vec2::new(x, 500.0), Seed(1), String::new());
        match parcels.choose(BlockContext { place, district, ..BlockContext::bare(9e3, seed) }) {
            ParcelChoice::Recursive(settings) => settings.least_area,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!([least_area(100.0), least_area(700.0)], [30.0, 90.0]);
}

#[test]
fn what_is_set_by_hand_stands_above_values_by_place() {
    let mut plan = settled("width: by_district(#{ \"old town\": 30 }, 90)");
    plan.set("minors.pattern.width=77").expect("in range");
    assert_eq!([100.0, 700.0].map(|x| proposed(pattern(&plan), x, 500.0).0), [77.0, 77.0]);
    let quarters = "quarters: #{ \"0123456789abcdef0123456789abcdef\": #{ width: by_district(#{ harbour: 50 }, 60) } }";
    let mut plan = city("width: by_district(#{ \"old town\": 30 }, 90)", quarters).expect("fine");
    plan.settle(places()).expect("settles");
    let quarter = "0123456789abcdef0123456789abcdef".parse().ok();
    let there = plan.in_quarter(quarter).rule_of("minors.pattern").expect("a pattern").clone();
    assert_eq!([100.0, 900.0].map(|x| proposed(there.clone(), x, 100.0).0), [60.0, 50.0]);
    assert_eq!([100.0, 900.0].map(|x| proposed(pattern(&plan), x, 100.0).0), [30.0, 90.0]);
}

#[test]
fn streets_have_widths_by_place() {
    let plan = |width: &str| {
        let text = format!("majors: streets(#{{ pattern: rule(\"mine\"), width: {width} }})");
        city("", &text).map_err(|fault| headline(&fault))
    };
    assert_eq!(plan("30").expect("fine").majors.expect("majors").constant_width(), Some(30.0));
    let mut settled = plan("by_district(#{ \"old town\": 12 }, site.map(\"density\").between(20, 40))").expect("fine");
    settled.settle(places()).expect("settles");
    let majors = settled.majors.expect("majors");
    let widths = majors.widths.as_ref().expect("widths by place");
    let at = |x: f64| widths.at(Vec2::new(x, 500.0)).round();
    assert_eq!((majors.constant_width(), [at(100.0), at(750.0), at(1000.0)]), (None, [12.0, 35.0, 40.0]));
    let says = |width: &str| plan(width).expect_err("wrong");
    assert!(says("300").ends_with("`width` must be a number from 0.5 to 200 m, not 300"), "{}", says("300"));
    assert!(says("by_district(#{ harbour: 9 })").ends_with("needs a width for all other ground"));
    let error = plan("site.map(\"density\")").expect("reads").settle(places()).expect_err("too narrow");
    assert!(error.message.starts_with("majors: `width` must be a number from 0.5 to 200 m, but"), "{error}");
}

#[test]
fn districts_have_rules_of_their_own() {
    let text = "parcels: by_district(#{ \"old town\": rule(\"mine\"), harbour: rule(\"mine\", #{ width: 40 }) }, rule(\"parcels/recursive\"))";
    let mut plan = city("", text).expect("fine");
    let roles: Vec<String> = plan.roles().into_iter().map(|(role, _)| role).collect();
    assert_eq!(roles, ["minors.pattern", "parcels", "parcels.harbour", "parcels.old town"]);
    plan.set("parcels.harbour.width=55").expect("in range");
    plan.set("parcels.most_area=700").expect("in range");
    assert!(plan.set("parcels.harbour.most_area=700").is_err(), "the harbour's rule has another");
    let width = |role: &str| plan.rule_of(role).and_then(|rule| rule.params().get("width").map(ToString::to_string));
    assert_eq!([width("parcels.harbour"), width("parcels.old town")], [Some("55".into()), Some("80".into())]);
    let says = |text: &str| headline(&city("", text).expect_err("wrong"));
    let unknown = says("buildings: by_district(#{ harbur: rule(\"buildings/extruded\") })");
    assert!(unknown.ends_with("buildings differs in `harbur`, but the city has no district of that name"), "{unknown}");
    assert!(says("parcels: by_district(#{ harbour: 3 })").contains("`parcels` must be rule"));
    assert!(says("parcels: by_district(#{ harbour: rule(\"streets/grid\") })").contains("has no `fn subdivide"));
}

#[test]
fn goals_take_numbers_by_place() {
    let settle = |goals: &str| {
        let text = format!("majors: streets(#{{ pattern: rule(\"mine\"), goals: {goals} }})");
        let mut plan = city("", &text).unwrap_or_else(|fault| panic!("{fault}"));
        plan.settle(places()).map(|()| plan.majors.expect("majors").goal().expect("told").expect("a goal"))
    };
    let least = |goals: &str| {
        let goal = settle(goals).expect("settles");
        [100.0, 700.0].map(|x| places().number(&goal.least).at(Vec2::new(x, 500.0)))
    };
    let by_district = "by_district(#{ \"old town\": 900 }, 50)";
    assert_eq!(least(&format!("density(site.map(\"density\"), #{{ least: {by_district} }})")), [900.0, 50.0]);
    assert_eq!(least(&format!("rule(\"goals/settled\", #{{ least: {by_district} }})")), [900.0, 50.0]);
    assert_eq!(least("density(site.map(\"density\"))"), [0.0, 0.0]);
    let full =
        settle("density(site.map(\"density\"), #{ full: site.map(\"density\").scale(5) })").expect("settles").full;
    assert_eq!(places().number(&full.expect("told")).at(Vec2::new(1000.0, 0.0)), 5.0);
    let error = settle("density(site.map(\"density\"), #{ pace: by_district(#{ moon: 3 }, 1) })").expect_err("no moon");
    assert!(error.message.starts_with("majors.goals: `pace` differs in `moon`"), "{error}");
}

#[test]
fn districts_have_patterns_of_their_own() {
    let pattern = |text: &str| city("", &format!("majors: streets(#{{ pattern: {text} }})"));
    let text = "by_district(#{ \"old town\": rule(\"streets/organic\"), harbour: rule(\"mine\") * 0.5 + rule(\"streets/grid\") }, rule(\"streets/grid\"))";
    let mut plan = pattern(text).unwrap_or_else(|fault| panic!("{fault}"));
    let roles: Vec<String> =
        plan.roles().into_iter().map(|(role, _)| role).filter(|role| role.starts_with("majors")).collect();
    let own = ["grid", "harbour mine", "harbour grid", "old town"];
    assert_eq!(roles, own.map(|name| format!("majors.pattern.{name}")));
    plan.set("majors.pattern.old town.length=77").expect("a parameter of the organic rule");
    plan.settle(places()).expect("settles");
    let weights = |plan: &Plan| -> Vec<String> {
        let majors = plan.majors.as_ref().expect("majors");
        majors.pattern.parts().iter().map(|part| part.weight.districts().join("+")).collect()
    };
    assert_eq!(weights(&plan), ["harbour+old town", "harbour", "harbour", "old town"]);
    let says = |text: &str| headline(&pattern(text).expect_err("wrong"));
    assert!(says("by_district(#{ harbour: rule(\"mine\") })").ends_with("needs a rule for all other ground"));
    assert!(
        says("by_district(#{ moon: rule(\"mine\") }, rule(\"mine\"))").contains("majors.pattern differs in `moon`")
    );
    assert!(says("by_district(#{ harbour: 3 }, rule(\"mine\"))").contains("must be rule"));
}

/// The chain of majors that keep to a rule with these values.
fn chain(rule: &str, values: &str) -> Result<Chain, String> {
    let text =
        format!("majors: streets(#{{ pattern: rule(\"mine\"), constraints: rule(\"{rule}\", #{{ {values} }}) }})");
    let mut plan = city("", &text).map_err(|fault| format!("{} {:?}", headline(&fault), fault.hint))?;
    plan.settle(places()).map_err(|error| format!("{} {:?}", error.message, error.hint))?;
    let majors = plan.majors.expect("majors");
    Ok(majors.chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default()).expect("a chain"))
}

/// The steps that hold for what starts in the old town, and in the middle of the east.
fn steps_at(chain: &Chain) -> [Vec<Step>; 2] {
    [100.0, 750.0].map(|x| chain.at(Vec2::new(x, 500.0)).expect("it differs by place").steps().to_vec())
}

#[test]
fn all_values_of_the_standard_chain_differ_by_district() {
    let both = |low: &str, high: &str| format!("by_district(#{{ \"old town\": {low} }}, {high})");
    for (name, low, high) in [
        ("snap", "3", "9"),
        ("extend", "1", "2"),
        ("extend_most", "10", "50"),
        ("duplicate", "4", "8"),
        ("least_length", "5", "20"),
        ("longest", "100", "500"),
        ("least_angle", "20", "40"),
        ("prune", "0.25", "0.75"),
        ("turn_step", "3", "9"),
        ("turn_most", "30", "90"),
        ("turn_first", "true", "false"),
        ("bridge", "200", "400"),
        ("bridge_spacing", "50", "500"),
        ("bridge_over", "\"water\"", "\"any\""),
        ("bridge_first", "false", "true"),
        ("max_slope", "0.05", "0.5"),
    ] {
        let is_bridge = name.starts_with("bridge_");
        let with = |value: &str| match is_bridge {
            true => format!("bridge: 300, {name}: {value}"),
            false => format!("{name}: {value}"),
        };
        let by_place = chain("constraints/standard", &with(&both(low, high))).unwrap_or_else(|wrong| panic!("{wrong}"));
        let plain = [low, high].map(|value| chain("constraints/standard", &with(value)).expect("plain"));
        assert!(plain.iter().all(|chain| chain.at(Vec2::ZERO).is_none()), "{name}: the same everywhere");
        assert_eq!(steps_at(&by_place), plain.map(|chain| chain.steps().to_vec()), "{name}");
    }
}

#[test]
fn numbers_of_chains_are_read_from_maps_too() {
    let values = "tunnel: site.map(\"density\").between(0, 400), arms: site.map(\"density\").scale(4, 3).clamp(3, 6), \
                  max_slope: by_district(#{ harbour: 0.2 }, site.map(\"density\").between(0.05, 0.25))";
    let chain = chain("constraints/mountain", values).unwrap_or_else(|wrong| panic!("{wrong}"));
    let [west, east] = steps_at(&chain);
    let arms = |steps: &[Step]| steps.iter().find_map(|s| if let Step::Arms(most) = s { Some(*most) } else { None });
    assert_eq!([arms(&west), arms(&east)], [Some(3), Some(6)]);
    let slope = |steps: &[Step]| {
        let found = steps.iter().find_map(|s| if let Step::Slope(slope) = s { Some(*slope) } else { None });
        found.map(|slope| ((slope.most * 100.0).round(), slope.tunnel.round())).expect("a slope")
    };
    assert_eq!([slope(&west), slope(&east)], [(7.0, 38.0), (20.0, 301.0)]);
    let harbour = chain.at(Vec2::new(900.0, 100.0)).expect("differs");
    assert_eq!(slope(harbour.steps()).0, 20.0);
}

#[test]
fn steps_are_the_same_in_all_districts() {
    let file = "params(#{ is_strict: flag(false), reach: metres(5).range(0, 99) });\n\nfn constraints(p) {\n    \
                let chain = [snap(p.reach * 2)];\n    if p.is_strict { chain.push(crossing()); }\n    chain\n}";
    let says = |values: &str| {
        let host = Host::new(vec![shelf(&[("mine.rhai", MINE), ("own.rhai", file)])]);
        let text = format!(
            "let site = site(\"maps\");\ncity(#{{ site: site, districts: site.districts(\"districts\", #{{ \"old town\": \"#c0392b\" }}),\n\
             majors: streets(#{{ pattern: rule(\"mine\"), constraints: rule(\"own\", #{{ {values} }}) }}) }});"
        );
        let mut plan = host
            .plan(&Source { text, path: "city.rhai".into() }, Arc::new(Folders))
            .map_err(|fault| fault.to_string())?
            .plan;
        plan.settle(places()).expect("settles");
        let chain = plan.majors.expect("majors").chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default());
        Ok::<_, String>(chain.expect("a chain"))
    };
    let told = says("is_strict: by_district(#{ \"old town\": true }, false)").expect_err("other steps");
    assert!(told.contains("own.rhai:3:4: constraints(p): this tells other steps in one district"), "{told}");
    // A rule reckons with what holds in a district.
    let [west, east] = steps_at(&says("reach: by_district(#{ \"old town\": 3 }, 4)").expect("a chain"));
    assert_eq!((west, east), (vec![Step::Snap(6.0)], vec![Step::Snap(8.0)]));
}

#[test]
fn a_map_of_values_differs_by_place_too() {
    let host = Host::new(vec![shelf(&[
        ("mine.rhai", MINE),
        (
            "own.rhai",
            "params(#{ reach: metres(5).range(0, 100) });\nfn constraints(p) { #{ snap: p.reach, turn_most: p.reach } }",
        ),
    ])]);
    let text = "let site = site(\"maps\");\ncity(#{ site: site, districts: site.districts(\"districts\", #{ \"old town\": \"#c0392b\", harbour: \"#2980b9\" }),\n\
                majors: streets(#{ pattern: rule(\"mine\"), constraints: rule(\"own\", #{ reach: by_district(#{ \"old town\": 3 }, 7) }) }) });";
    let source = Source { text: text.into(), path: "city.rhai".into() };
    let mut plan = host.plan(&source, Arc::new(Folders)).unwrap_or_else(|fault| panic!("{fault}")).plan;
    plan.settle(places()).expect("settles");
    let chain = plan.majors.expect("majors").chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default());
    let [west, east] = steps_at(&chain.expect("a chain"));
    let reach = |steps: &[Step]| -> Vec<f64> {
        let of = |step: &Step| match step {
            Step::Snap(metres) | Step::Join(metres) => Some(*metres),
            Step::Legal(legal) => Some(legal.turns.most.to_degrees().round()),
            Step::Slope(slope) => Some(slope.turns.most.to_degrees().round()),
            _ => None,
        };
        steps.iter().filter_map(of).collect()
    };
    assert_eq!((reach(&west), reach(&east)), (vec![3.0; 4], vec![7.0; 4]));
}

#[test]
fn constraints_by_place_are_refused_where_they_make_no_sense() {
    let says = |rule: &str, values: &str| chain(rule, values).expect_err("wrong");
    let told = says("constraints/standard", "turn_step: site.map(\"density\").between(1, 20)");
    assert!(told.contains("`turn_step` must be a number") && told.contains("give it one value, no map"), "{told}");
    let told = says("constraints/standard", "turn_first: by_district(#{ harbour: 3 }, false)");
    assert!(told.contains("`turn_first` must be true or false"), "{told}");
    let told = says("constraints/standard", "snap: site.map(\"density\").scale(9000)");
    assert!(told.contains("`snap` must be a number from 0 to 1000 m, but"), "{told}");
    let told = says("constraints/standard", "snap: by_district(#{ moon: 3 }, 5)");
    assert!(told.contains("`snap` differs in `moon`"), "{told}");
}

#[test]
fn values_read_as_people_write_them() {
    let plan =
        settled("width: by_district(#{ \"old town\": 30, harbour: site.map(\"density\").between(40, 200) }, 90)");
    let told: Vec<String> = plan.parameters().into_iter().map(|param| param.value.to_string()).collect();
    assert_eq!(
        told,
        ["map density × 160 + 40 held between 40 and 200 in harbour, 30 in old town, else 90", "3", "plain"]
    );
    assert_ne!(pattern(&plan).fingerprint(), pattern(&settled("width: 90")).fingerprint());
    assert_eq!(plan.param_maps().len(), 1);
}

#[test]
fn mistakes_in_the_script_are_placed() {
    let says = |values: &str| headline(&city(values, "").expect_err("wrong"));
    let at = "city.rhai:4:";
    for (values, wrong) in [
        ("width: by_district(#{ harbour: 7 }, 90)", "`width` must be a number from 20 to 500 m, not 7 (in `harbour`)"),
        (
            "width: by_district(#{ harbour: 30 }, \"x\")",
            "`width` must be a number from 20 to 500 m, not a text (in `all else`)",
        ),
        ("width: by_district(#{})", "by_district names no district"),
        ("style: site.map(\"density\")", "`style` must be one of `plain`, `bent`, not a map of the site"),
        ("width: site.map(\"density\").between(1, \"b\")", "`high` must be a number, not a text"),
        ("width: site.map(\"density\").clamp(9, 3)", "the range runs from high to low"),
        ("width: site.map(\"density\").blur(9)", "there is no function `blur`"),
    ] {
        let told = says(values);
        assert!(told.starts_with(at) && told.ends_with(wrong), "{values}: {told}");
    }
    let unknown = city("width: by_district(#{ \"old twon\": 30 })", "").expect_err("unknown");
    assert!(
        headline(&unknown)
            .ends_with("minors.pattern: `width` differs in `old twon`, but the city has no district of that name")
    );
    assert_eq!(unknown.hint.as_deref(), Some("did you mean `old town`?"));
}

#[test]
fn values_that_leave_their_range_are_refused_before_building() {
    let wrong = |values: &str| {
        let mut plan = city(values, "").expect("reads");
        plan.settle(places()).expect_err("out of range")
    };
    let error = wrong("width: site.map(\"density\").scale(100)");
    assert_eq!(
        error.message,
        "minors.pattern: `width` must be a number from 20 to 500 m, but `map density × 100 + 0` goes from 0 to 100"
    );
    assert!(error.hint.is_some_and(|hint| hint.contains(".between(low, high)")));
    assert!(
        wrong("count: by_district(#{ harbour: site.map(\"density\").scale(20) })")
            .message
            .contains("goes from 0 to 20")
    );
    assert!(
        wrong("width: site.map(\"parks\")")
            .message
            .contains("is read from a map `parks`, which the site does not have")
    );
    let mut plan = city("width: by_district(#{ harbour: 30 })", "").expect("reads");
    let nowhere = Places { districts: Arc::default(), ..places() };
    let error = plan.settle(nowhere).expect_err("no districts");
    assert!(error.message.contains("`width` differs in `harbour`, but the city has no district"), "{error}");
}

proptest! {
    #[test]
    fn any_map_stays_in_its_range_and_reads_as_the_map_does(
        values in prop::collection::vec(-3.0f32..3.0, 16), x in 0.0..1000.0f64, y in 0.0..1000.0f64,
    ) {
        let map = Raster::new(4, 4, 250.0, Vec2::ZERO, values).expect("a map");
        let mut plan = city("width: site.map(\"density\").between(20, 500), count: site.map(\"density\").scale(3, 1).clamp(0, 9)", "").expect("reads");
        plan.settle(places_of(map.clone())).expect("in range whatever the map");
        let (width, count, _) = proposed(pattern(&plan), x, y);
        let at = Point::from_metres(Vec2::new(x, y)).metres();
        let share = map.bilinear(at);
        prop_assert!((20.0..=500.0).contains(&width));
        prop_assert!((width - (20.0 + 480.0 * share.clamp(0.0, 1.0))).abs() < 1e-6);
        prop_assert_eq!(count, (share * 3.0 + 1.0).clamp(0.0, 9.0).round() as i32);
    }
}

mod set_by_place {
    use super::common;
    use geom::Id;
    use script::Plan;

    const CITY: &str = r#"
    city(#{
        site: site(#{ size: [500, 500] }),
        minors: streets(#{ pattern: rule("streets/grid") }),
        majors: streets(#{ pattern: rule("streets/grid") }),
        parcels: rule("parcels/recursive"),
    });
    "#;
    const QUARTER: &str = "00000000000000000000000000000007";

    fn plan() -> Plan {
        common::city(CITY).expect("a plan").plan
    }

    #[test]
    fn a_value_of_a_quarter_holds_there_alone() {
        let (mut plan, there) = (plan(), Some(Id(7)));
        let before = plan.value("minors.pattern.block_width");
        plan.set(&format!("quarter:{QUARTER}.minors.pattern.block_width=66")).unwrap();
        plan.set(&format!("quarter:{QUARTER}.seed=3")).unwrap();
        assert_eq!(plan.value("minors.pattern.block_width"), before);
        assert_eq!(plan.in_quarter(there).value("minors.pattern.block_width").as_deref(), Some("66"));
        assert_eq!(plan.value(&format!("quarter:{QUARTER}.minors.pattern.block_width")).as_deref(), Some("66"));
        assert_eq!(plan.seed_in(Id(7)), Some(3));
    }

    #[test]
    fn a_value_of_a_district_stands_beside_the_one_elsewhere() {
        let mut plan = plan();
        let other = plan.value("minors.pattern.block_width").unwrap();
        plan.set("district:St. John's.minors.pattern.block_width=66").unwrap();
        plan.set("district:harbour.minors.pattern.block_width=77").unwrap();
        let told = plan.value("minors.pattern.block_width");
        assert_eq!(told, Some(format!("66 in St. John's, 77 in harbour, else {other}")));
    }

    #[test]
    fn what_cannot_hold_there_is_refused_and_changes_nothing() {
        let mut plan = plan();
        let before = format!("{:?}", plan.digests());
        let wrong = [
            (format!("quarter:{QUARTER}.majors.pattern.block_width=66"), "cannot differ in a quarter"),
            (format!("quarter:{QUARTER}.minors.pattern.block_width=6666"), "must be a number from"),
            (format!("quarter:{QUARTER}.minors.pattern.blocks=1"), "there is no parameter"),
            ("quarter:7.seed=1".into(), "names no quarter"),
            ("district:harbour.minors.block=1".into(), "nothing in this city is called"),
            ("district:harbour=1".into(), "names no parameter"),
            ("district:harbour.minors.pattern.block_width=wide".into(), "must be a number from"),
        ];
        for (assignment, told) in wrong {
            let error = plan.set(&assignment).unwrap_err();
            assert!(error.message.contains(told), "{assignment}: {error}");
        }
        assert_eq!(format!("{:?}", plan.digests()), before);
    }
}
