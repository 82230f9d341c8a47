//! The snippets of `rules/README.md`, and the rules of the library, run.

use crate::common::{self, Folders, city, rule, tip};
use script::{
    AssignPattern, BlockContext, BuildingPattern, ConstraintPattern, Faults, Host, ParcelPattern, Places, Rule,
    RuleKind, ShapeContext, Source, StreetPattern,
};
use std::sync::Arc;
use streets::growth::{Chain, Constrain, Field, GrowthRules};
use streets::{Classes, Districts};

const README: &str = include_str!("../../../../rules/README.md");

/// The code blocks with a given head.
fn snippets(head: &str) -> Vec<String> {
    let blocks = README.split("```").skip(1).step_by(2);
    blocks.filter_map(|block| block.strip_prefix(&format!("{head}\n")).map(str::to_owned)).collect()
}

/// Asks a rule everything it decides, on places of several kinds; nothing may go wrong.
fn ask(rule: &Rule) {
    let faults = Arc::new(Faults::default());
    for kind in rule.kinds() {
        match kind {
            RuleKind::Streets => ask_streets(rule, &faults),
            RuleKind::Parcels => ask_parcels(rule, &faults),
            RuleKind::Buildings => ask_buildings(rule, &faults),
            RuleKind::Goals | RuleKind::Constraints => ask_once(rule, *kind),
            RuleKind::Constrain => ask_segments(rule, &faults),
            RuleKind::Assign => ask_assign(rule, &faults),
        }
    }
    assert!(faults.is_empty(), "{}: {:?}", rule.name(), faults.sorted());
}

fn ask_streets(rule: &Rule, faults: &Arc<Faults>) {
    let pattern = StreetPattern::new(rule.clone(), 0, Arc::new(Classes::default()), faults.clone());
    let mut filled = 0;
    for heading in [0.0, 45.0, 100.0, -170.0] {
        let mut tip = tip(heading);
        pattern.propose(&mut tip);
        filled += usize::from(tip.slots.ahead.is_some());
    }
    assert_eq!(filled, 4, "{} proposes nothing", rule.name());
}

fn ask_parcels(rule: &Rule, faults: &Arc<Faults>) {
    let pattern = ParcelPattern::new(rule.clone(), faults.clone());
    for area in [10.0, 1000.0, 20_000.0] {
        pattern.choose(BlockContext { density: 5000.0, ..BlockContext::bare(area, geom::Seed(area as u64)) });
    }
}

fn ask_assign(rule: &Rule, faults: &Arc<Faults>) {
    let pattern = AssignPattern::new(rule.clone(), faults.clone());
    for area in [10.0, 300.0, 5000.0] {
        pattern.assign(ShapeContext::bare(area, geom::Seed(area as u64)));
    }
}

fn ask_buildings(rule: &Rule, faults: &Arc<Faults>) {
    let pattern = BuildingPattern::new(rule.clone(), faults.clone());
    for area in [10.0, 300.0, 5000.0] {
        pattern.choose(ShapeContext { density: 5000.0, ..ShapeContext::bare(area, geom::Seed(area as u64)) });
    }
}

fn ask_segments(rule: &Rule, faults: &Arc<Faults>) {
    let pattern = ConstraintPattern::new(rule.clone(), Arc::default(), faults.clone());
    for length in [10.0, 60.0, 300.0] {
        pattern.constrain(&mut common::draft(length));
    }
}

/// Goals and constraints are asked when a city script names them.
fn ask_once(rule: &Rule, kind: RuleKind) {
    let role = kind.function();
    let text = format!(
        "city(#{{ site: site(\"maps\"), minors: streets(#{{ pattern: rule(\"streets/grid\"), {role}: rule(\"mine\") }}) }});"
    );
    let library = common::shelf(&[("mine.rhai", &text_of(rule))]);
    let source = Source { text, path: "city.rhai".into() };
    let plan = Host::new(vec![library]).plan(&source, Arc::new(Folders)).expect("a good rule").plan;
    let minors = plan.minors.expect("minors");
    let goal = minors.goal().expect("a goal");
    let chain = minors.chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default()).expect("constraints");
    assert_eq!((goal.is_some(), !chain.steps().is_empty()), (kind == RuleKind::Goals, kind == RuleKind::Constraints));
}

/// The text of a rule: from the readme or the library.
fn text_of(rule: &Rule) -> String {
    let own = |text: &String| text.starts_with(&format!("//! {}", rule.about()));
    let mut texts = snippets("rhai");
    let library: &dyn script::Library = &script::Embedded;
    texts.extend(library.names().iter().filter_map(|name| library.read(name)?.ok()).map(|source| source.text));
    texts.into_iter().find(own).expect("a known rule")
}

#[test]
fn rules_of_the_tour_run() {
    let snippets = snippets("rhai");
    assert_eq!(snippets.len(), 11, "a snippet of the tour is not run");
    for text in snippets {
        let rule = rule(&text).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
        assert!(!rule.about().is_empty());
        ask(&rule);
    }
}

#[test]
fn the_steps_in_the_tour_are_those_of_its_rule() {
    let shown = snippets("text").into_iter().find(|text| text.contains("was asked about")).expect("it is shown");
    let shown: Vec<&str> = shown.lines().filter_map(|line| line.strip_prefix("  line ")).collect();
    let text = snippets("rhai").into_iter().find(|text| text.contains("fn wander(tip)")).expect("the rule before it");
    let (rule, account) = rule(&text).expect("it loads").telling();
    StreetPattern::new(rule, 0, Arc::default(), Arc::default()).propose(&mut tip(20.0));
    let told: Vec<String> = account.take().steps().map(|step| format!("{:<4} {step}", step.line)).collect();
    assert_eq!(shown, told);
}

#[test]
fn cities_of_the_tour_run() {
    let snippets = snippets("rhai city");
    assert_eq!(snippets.len(), 8);
    for text in snippets {
        let mut plan = city(&text).unwrap_or_else(|fault| panic!("{fault}\n{text}")).plan;
        assert!(plan.minors.is_some());
        // On a site with all that it names.
        let names = ["harbour", "market", "old town"].map(str::to_owned).to_vec();
        let maps = plan.param_maps().into_iter().map(|map| (map.name.clone(), Field::Constant(0.5))).collect();
        let places = Places { maps, districts: Arc::new(Districts::of_areas(names, Vec::new())) };
        plan.settle(places).unwrap_or_else(|error| panic!("{error}\n{text}"));
    }
}

#[test]
fn presets_of_the_tour_are_sound() {
    let snippets = snippets("rhai preset");
    assert_eq!(snippets.len(), 1);
    for text in snippets {
        let library = common::shelf(&[("presets/mine.rhai", &text)]);
        let preset = Host::new(vec![library]).preset("mine").unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
        assert_eq!(preset.rules().len(), 4);
    }
}

#[test]
fn rules_of_the_library_run_and_are_documented() {
    let host = Host::new(vec![]);
    for name in host.names() {
        let rule = host.rule(&name).unwrap_or_else(|fault| panic!("{fault}"));
        assert!(!rule.about().is_empty(), "{name} does not say what it is");
        for (param, _) in rule.params().iter() {
            assert!(!param.about.is_empty(), "{name}: {} says nothing", param.name);
        }
        ask(&rule);
    }
}

#[test]
fn the_tour_names_every_kind_and_field() {
    for kind in RuleKind::ALL {
        assert!(README.contains(&format!("fn {}", kind.form())), "{}", kind.form());
    }
}
