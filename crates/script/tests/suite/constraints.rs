//! Constraints of streets: chains, the standard chain's values, constraints of one's own.

use crate::common::{Folders, draft, headline, rule, shelf};
use geom::{Angle, Polygon, Vec2};
use script::{ConstraintPattern, Fault, Faults, Host, Plan, Source};
use std::sync::Arc;
use streets::growth::{
    Area, Bridge, Chain, Constrain, Constraints, Draft, Duplicate, Extend, Legal, Length, Over, Slope, Step, TurnSearch,
};

/// A city whose minors keep to what a script says, with rules `a`, `b`, … of these texts beside it.
fn plan(constraints: &str, rules: &[&str]) -> Result<Plan, Fault> {
    let text = format!(
        "city(#{{ site: site(#{{ size: [9, 9] }}),\n minors: streets(#{{ pattern: rule(\"streets/grid\"), constraints: {constraints} }}) }});"
    );
    let names: Vec<String> = ('a'..).zip(rules).map(|(name, _)| format!("{name}.rhai")).collect();
    let files: Vec<(&str, &str)> = names.iter().map(String::as_str).zip(rules.iter().copied()).collect();
    let host = Host::new(vec![shelf(&files)]);
    host.plan(&Source { text, path: "city.rhai".into() }, Arc::new(Folders)).map(|evaluated| evaluated.plan)
}

fn chain_of(plan: &Plan) -> Chain {
    let minors = plan.minors.as_ref().expect("minors");
    minors.chain(Chain::new(vec![Step::Crossing]), &Arc::default(), &Arc::default()).expect("a chain")
}

/// The steps of a rule that answers with a list.
fn steps(list: &str) -> Vec<Step> {
    let text = format!("fn constraints(p) {{ {list} }}");
    chain_of(&plan("rule(\"a\")", &[&text]).unwrap_or_else(|fault| panic!("{fault}"))).steps().to_vec()
}

fn turns(step: f64, most: f64) -> TurnSearch {
    TurnSearch { step: Angle::degrees(step), most: Angle::degrees(most) }
}

#[test]
fn every_word_is_a_step() {
    let legal = Legal { prune: 0.5, turns: turns(10.0, 60.0), turns_first: false, bridge: None };
    let bridge = Bridge { longest: 300.0, spacing: 300.0, over: Over::Water, is_first: false };
    let gentle = Slope { most: 0.12, turns: turns(10.0, 60.0), has_hairpins: false, tunnel: 0.0 };
    let corners = [(0.0, 0.0), (90.0, 0.0), (40.0, 70.0)].map(|(x, y)| geom::Point::from_metres(Vec2::new(x, y)));
    let triangle = Area::Polygon(Arc::new(Polygon::new(corners.to_vec(), Vec::new())));
    let cases = [
        ("length(8, 500)", Step::Length(Length { least: 8.0, longest: 500.0 })),
        ("legal()", Step::Legal(legal)),
        (
            "legal(#{ prune: 0.2, turn_step: 3, turn_most: 80, turn_first: true })",
            Step::Legal(Legal { prune: 0.2, turns: turns(3.0, 80.0), turns_first: true, bridge: None }),
        ),
        ("legal(#{ bridge: 300 })", Step::Legal(Legal { bridge: Some(bridge), ..legal })),
        (
            "legal(#{ bridge: 300, bridge_spacing: 70, bridge_over: \"any\", bridge_first: true })",
            Step::Legal(Legal {
                bridge: Some(Bridge { spacing: 70.0, over: Over::Any, is_first: true, ..bridge }),
                ..legal
            }),
        ),
        ("slope(12.pct)", Step::Slope(gentle)),
        (
            "slope(0.12, #{ hairpin: true, tunnel: 400, turn_step: 5 })",
            Step::Slope(Slope { has_hairpins: true, tunnel: 400.0, turns: turns(5.0, 60.0), ..gentle }),
        ),
        ("crossing()", Step::Crossing),
        ("snap(5)", Step::Snap(5.0)),
        ("join(4.5)", Step::Join(4.5)),
        ("extend(1.25, 30)", Step::Extend(Extend { factor: 1.25, most: 30.0 })),
        ("duplicate(6)", Step::Duplicate(Duplicate { within: 6.0, is_whole: false })),
        ("duplicate(6, #{ whole: true })", Step::Duplicate(Duplicate { within: 6.0, is_whole: true })),
        ("angle(25)", Step::Angle(Angle::degrees(25.0))),
        ("arms(4)", Step::Arms(4)),
        ("mask(\"old\")", Step::Mask(Area::Map("old".into()))),
        ("mask([[0, 0], [90, 0], [40, 70]])", Step::Mask(triangle)),
    ];
    for (word, step) in cases {
        assert_eq!(steps(&format!("[{word}]")), [step], "{word}");
    }
    assert_eq!(steps("[snap(5), crossing()]"), [Step::Snap(5.0), Step::Crossing], "in the order they are told");
    assert_eq!(steps("[]"), [], "nothing is kept to but what a graph needs");
}

#[test]
fn a_map_of_values_is_the_standard_chain() {
    let told = steps("#{ snap: 3, least_angle: 5, max_slope: 0.1, bridge: 90 }");
    let values = Constraints {
        snap: 3.0,
        least_angle: Angle::degrees(5.0),
        max_slope: 0.1,
        bridge: 90.0,
        ..Constraints::default()
    };
    assert_eq!(told, Chain::from(values).steps());
}

#[test]
fn mistakes_are_told_with_what_helps() {
    let cases = [
        ("3", "constraints(p): returns a whole number"),
        ("[3]", "constraints(p): a chain is a list of constraints, and a whole number is none"),
        ("[snap(5), snap(6)]", "constraints(p): `snap` stands twice in the chain"),
        ("[own()]", "constraints(p): own() needs a function of this file"),
        ("[legal(#{ prnue: 0.5 })]", "legal has no option `prnue`"),
        ("[legal(#{ prune: 2 })]", "`prune` must lie between 0 and 1"),
        ("[legal(#{ turn_step: 0 })]", "`turn_step` must lie between 0.1 and 180°"),
        ("[legal(#{ turn_first: 3 })]", "`turn_first` must be true or false, not a whole number"),
        ("[legal(#{ bridge: -1 })]", "`bridge` must lie between 0 and 10000 m"),
        ("[legal(#{ bridge_over: \"parks\" })]", "`bridge_over` must be \"water\" or \"any\", not \"parks\""),
        ("[slope(-1)]", "the steepest slope must lie between 0 and 100"),
        ("[slope(0.1, #{ hairpins: true })]", "slope has no option `hairpins`"),
        ("[slope(0.1, #{ tunnel: \"long\" })]", "`tunnel` must be a number, not a text"),
        ("[length(9, 3)]", "the least length (9 m) is greater than the longest (3 m)"),
        ("[snap(-1)]", "the snapping distance must lie between 0 and 10000 m"),
        ("[join(\"x\")]", "the joining distance must be a number, not a text"),
        ("[extend(0.5, 30)]", "the multiple of the length must lie between 1 and 100"),
        ("[duplicate(1e9)]", "the distance of duplicates must lie between 0 and 10000 m"),
        ("[angle(200)]", "the least angle must lie between 0 and 180°"),
        ("[arms(1)]", "the most streets of a crossing must lie between 2 and 100"),
        ("[mask(3)]", "mask takes a map or a polygon, not a whole number"),
        ("[mask([[0, 0], [1, 1]])]", "a mask needs at least three corners, and its rim must not cross itself"),
        (
            "[mask([[0, 0], [9, 9], [9, 0], [0, 9]])]",
            "a mask needs at least three corners, and its rim must not cross itself",
        ),
        ("[mask([[0, 0], [1e7, 0], [0, 9]])]", "a point lies more than 500 km away"),
        ("#{ snpa: 3 }", "constraints(p): constraints has no option `snpa`"),
    ];
    for (body, message) in cases {
        let text = format!("fn constraints(p) {{ {body} }}");
        let fault = plan("rule(\"a\")", &[&text]).expect_err(body);
        assert_eq!((fault.file.as_str(), fault.line), ("a.rhai", 1), "{body}: {fault}");
        assert!(fault.column > 0, "{body}: {fault}");
        assert!(fault.message.ends_with(message), "{body}: {}", fault.message);
    }
    let fault = plan("rule(\"a\")", &["fn constraints(p) { [snpa(5)] }"]).expect_err("a typo");
    assert_eq!(headline(&fault), "a.rhai:1:22: there is no function `snpa`");
    assert_eq!(fault.hint.as_deref(), Some("did you mean `snap`?"));
    let long = format!("fn constraints(p) {{ [{}] }}", "mask(\"m\"), ".repeat(33));
    let fault = plan("rule(\"a\")", &[&long]).expect_err("too long");
    assert!(fault.message.ends_with("a chain holds at most 32 constraints, not 33"), "{}", fault.message);
}

const CHAIN: &str =
    "params(#{ snap: metres(5).range(0, 20).about(\"x\") });\nfn constraints(p) { [crossing(), snap(p.snap)] }";
const OWN: &str = "params(#{ far: metres(9).range(0, 20).about(\"x\") });\nfn constrain(segment, p) { if segment.length > p.far { segment.refuse(\"long\") } }";

/// What kinds of steps there are: `c`rossing, `s`nap, `o`wn.
fn kinds(plan: &Plan) -> String {
    let kind = |step: &Step| match step {
        Step::Crossing => 'c',
        Step::Snap(_) => 's',
        Step::Own(_) => 'o',
        _ => '?',
    };
    chain_of(plan).steps().iter().map(kind).collect()
}

#[test]
fn rules_in_a_list_follow_each_other() {
    let kinds_of = |list: &str, rules: &[&str]| kinds(&plan(list, rules).unwrap_or_else(|fault| panic!("{fault}")));
    assert_eq!(kinds_of("[rule(\"a\"), rule(\"b\")]", &[CHAIN, OWN]), "cso");
    assert_eq!(kinds_of("[rule(\"b\"), rule(\"a\")]", &[CHAIN, OWN]), "ocs");
    assert_eq!(kinds_of("rule(\"a\")", &[OWN]), "co", "behind the standard chain");
    assert_eq!(kinds_of("[]", &[]), "c");
    let both = "fn constraints(p) { [own(), crossing()] }\nfn constrain(segment, p) { }";
    assert_eq!(kinds_of("rule(\"a\")", &[both]), "oc");
    let behind = "fn constraints(p) { [crossing()] }\nfn constrain(segment, p) { }";
    assert_eq!(kinds_of("rule(\"a\")", &[behind]), "co");
}

#[test]
fn wrong_lists_are_told() {
    let says = |list: &str, rules: &[&str]| headline(&plan(list, rules).expect_err(list));
    assert_eq!(
        says("[rule(\"a\"), rule(\"b\")]", &[CHAIN, CHAIN]),
        "city.rhai:2:10: b.rhai: `b` tells a chain, and so does `a`"
    );
    assert_eq!(
        says("[rule(\"a\"), 3]", &[CHAIN]),
        "city.rhai:2:52: `constraints` must be rule(\"…\"), not a whole number"
    );
    assert_eq!(says("rule(\"streets/grid\")", &[]), "city.rhai:2:52: rule `streets/grid` has no `fn constraints(p)`");
    let nine = format!("[{}]", ["rule(\"a\")"; 9].join(", "));
    assert_eq!(says(&nine, &[OWN]), "city.rhai:2:52: `constraints` takes at most 8 rules, not 9");
}

#[test]
fn rules_of_a_list_have_roles_of_their_own() {
    let mut plan = plan("[rule(\"a\"), rule(\"b\")]", &[CHAIN, OWN]).expect("fine");
    let roles: Vec<String> = plan.roles().into_iter().map(|(role, _)| role).collect();
    assert_eq!(roles, ["minors.pattern", "minors.constraints", "minors.constraints.2"]);
    for parameter in plan.parameters() {
        plan.set(&format!("{}={}", parameter.address, parameter.value)).expect("its own value");
    }
    plan.set("minors.constraints.snap=12").expect("in range");
    plan.set("minors.constraints.2.far=3").expect("in range");
    assert_eq!(chain_of(&plan).snap(), 12.0);
    let second = plan.rule_of("minors.constraints.2").expect("a rule");
    assert_eq!(second.params().get("far").map(ToString::to_string), Some("3".to_owned()));
    let error = plan.set("minors.constraints.2.fra=3").expect_err("a typo");
    assert_eq!(error.hint.as_deref(), Some("did you mean `far`?"));
}

/// What a body of `constrain(segment, p)` does to a street of so many metres.
fn constrained(body: &str, length: f64) -> (Draft, Vec<Fault>) {
    let faults = Arc::new(Faults::default());
    let rule = rule(&format!("fn constrain(segment, p) {{ {body} }}")).unwrap_or_else(|fault| panic!("{fault}"));
    let mut draft = draft(length);
    ConstraintPattern::new(rule, Arc::default(), faults.clone()).constrain(&mut draft);
    (draft, faults.sorted())
}

fn refusal(body: &str) -> Option<String> {
    let (draft, faults) = constrained(body, 60.0);
    assert!(faults.is_empty(), "{body}: {faults:?}");
    draft.refused.map(|why| why.to_string())
}

#[test]
fn segments_are_known() {
    let seed = draft(60.0).seed;
    let truths = [
        "segment.from_x == 1000.0 && segment.from_y == 1000.0",
        "segment.to_x == 1060.0 && segment.to_y == 1000.0",
        "segment.length == 60.0 && segment.heading == 0.0",
        "segment.class == \"minor\" && segment.level == 0 && !segment.meets_street",
        "segment.slope == 0.0 && segment.density == 900.0",
        "segment.map(\"parks\") == 0.0 && segment.map(\"parks\", 0.5) == 0.0",
        "segment.distance_to(\"parks\") > 37.0 && segment.distance_to(\"parks\") < 43.0",
        &format!("segment.chance(4) == {}", seed.unit(4)),
    ];
    for truth in truths {
        assert_eq!(refusal(&format!("if !({truth}) {{ segment.refuse(\"no\") }}")), None, "{truth}");
    }
    assert_eq!(refusal("segment.refuse(\"no\")").as_deref(), Some("mine: no"), "it works");
}

#[test]
fn segments_are_told() {
    let end = |body: &str| {
        let (draft, faults) = constrained(body, 60.0);
        assert!(faults.is_empty(), "{body}: {faults:?}");
        (draft.to - draft.from, draft.heading.to_degrees().round())
    };
    assert_eq!(end(""), (Vec2::new(60.0, 0.0), 0.0));
    assert_eq!(end("segment.shorten(20)"), (Vec2::new(40.0, 0.0), 0.0));
    assert_eq!(end("segment.cut_to(20)"), (Vec2::new(20.0, 0.0), 0.0));
    assert_eq!(end("segment.end_at(1030, 1030)"), (Vec2::new(30.0, 30.0), 45.0));
    let (to, heading) = end("segment.turn(90)");
    assert!((to - Vec2::new(0.0, 60.0)).length() < 1e-9 && heading == 90.0, "{to} {heading}");
    assert_eq!(end("segment.shorten(20); segment.shorten(20);").0, Vec2::new(20.0, 0.0));
}

#[test]
fn a_failing_constraint_refuses() {
    let cases = [
        ("segment.turn(200);", "the turn must lie between -180 and 180°"),
        ("segment.shorten(60);", "a segment is shortened by at least nothing and less than its length"),
        ("segment.cut_to(61);", "a segment is cut to a length above 0 and at most its own"),
        ("segment.end_at(1e9, 0);", "a segment cannot end more than 500 km away"),
        ("segment.map(\"prks\");", "the site has no map `prks`"),
        ("segment.map(\"parks\", 2);", "the share must lie between 0 and 1"),
        ("segment.distance_to(3);", "a map is asked for by its name"),
        ("segment.refuse(3);", "say why in a text: segment.refuse(\"too close to a park\")"),
        ("loop { }", "stopped after 100000 operations"),
        ("throw \"no\";", "no"),
    ];
    for (body, message) in cases {
        let (draft, faults) = constrained(body, 60.0);
        assert_eq!(draft.refused.as_deref(), Some("mine: the rule failed"), "{body}");
        assert_eq!(draft.to, Vec2::new(1060.0, 1000.0), "{body}");
        assert_eq!((faults[0].message.as_str(), faults[0].place), (message, Some(Vec2::splat(1000.0))), "{body}");
    }
}

#[test]
fn the_library_keeps_clear_of_parks() {
    let faults = Arc::new(Faults::default());
    let rule = Host::new(vec![]).rule("constraints/clear_of_parks").expect("in the library");
    let pattern = ConstraintPattern::new(rule, Arc::default(), faults.clone());
    let ask = |length: f64, meets_street: bool| {
        let mut draft = Draft { meets_street, ..draft(length) };
        pattern.constrain(&mut draft);
        (draft.heading.to_degrees().round(), draft.refused.map(|why| why.to_string()))
    };
    let why = Some("constraints/clear_of_parks: too close to a park".to_owned());
    assert_eq!(ask(60.0, false), (0.0, None), "40 m away");
    // 80 · cos 30° = 69.3: 31 m away.
    assert_eq!(ask(75.0, false), (30.0, None), "turned");
    assert_eq!(ask(75.0, true), (0.0, why.clone()), "what meets a street is left or refused");
    assert_eq!(ask(300.0, false).1, why, "nothing helps");
    assert!(faults.is_empty(), "{:?}", faults.sorted());
}
