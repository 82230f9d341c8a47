use super::*;
use crate::{
    BlockContext, BuildingPattern, Faults, Host, Library, ParcelPattern, Rule, RuleKind, ShapeContext, StreetPattern,
};
use geom::{Bounds, Point, Seed};
use proptest::prelude::*;
use std::sync::Arc;
use streets::Classes;
use streets::growth::{Field, Fields, GrowthRules, Tip};

/// One file that others import.
#[derive(Debug)]
struct Shelf(&'static str, &'static str);

impl Library for Shelf {
    fn read(&self, name: &str) -> Option<Result<Source, String>> {
        (name == self.0).then(|| Ok(Source { text: self.1.into(), path: format!("shelf/{}", self.0) }))
    }

    fn place(&self) -> String {
        "a shelf".into()
    }

    fn names(&self) -> Vec<String> {
        vec![self.0.into()]
    }
}

fn rule(text: &str) -> Rule {
    let shelf = Shelf("common.rhai", "fn twice(x, shape) {\n    let area = shape.area;\n    2 * x\n}\n");
    let source = Source { text: text.into(), path: "mine.rhai".into() };
    Host::new(vec![Arc::new(shelf)]).rule_of("mine", &source).expect("loads")
}

/// What a building rule tells of a parcel of 400 m², a step a line.
fn told(text: &str) -> String {
    let (telling, account) = rule(text).telling();
    BuildingPattern::new(telling, Arc::default()).choose(ShapeContext::bare(400.0, Seed(1)));
    let line = |step: &Step| {
        let file = if &*step.file == "mine.rhai" { String::new() } else { format!("{} ", step.file) };
        format!("{file}{} {step}\n", step.line)
    };
    account.take().steps().map(line).collect()
}

#[test]
fn every_form_of_a_step_is_told_with_its_line_and_value() {
    let text = r#"
import "common" as c;
params(#{ least: metres(12), words: choice("a", ["a", "b"]) });
fn of(shape, p) { // shape.width }
    if shape.width > p.least /* wide */ { return "wide"; } else if shape.is_corner { return "corner" }
    "narrow"
}
fn build(shape, p) {
    let kind = of(shape, p);
    let sum = 0;
    let list = [shape.area, 2, shape.depth];
    for part in list { sum += part; }
    while sum > 400 { sum /= 2 }
    sum = c::twice(sum, shape);
    let words = `${shape.tags.len()} of ${kind}, ${p.words}`;
    print(words); mark(3, 4.5);
    let most = list.filter(|x| x > list_least()).len();
    let floors = if shape.area < 100 { 1 } else { switch kind { "wide" => shape.chance(1, 2, 5), _ => 2 } };
    if list[0] > 1 && !shape.has_tag("x") { shape.extrude(round(floors) * 3, #{ front: p.least / 4 }); }
    return shape.area;
}
fn list_least() { 1 }
"#;
    insta::assert_snapshot!(told(text));
}

#[test]
fn what_is_left_over_is_counted_and_the_next_call_starts_anew() {
    let text = "fn build(shape, p) {\n    for i in 0..400 { shape.chance(i); }\n}";
    let (telling, account) = rule(text).telling();
    let pattern = BuildingPattern::new(telling, Arc::default());
    for _ in 0..2 {
        pattern.choose(ShapeContext::bare(400.0, Seed(1)));
        let told = account.take();
        assert_eq!((told.first.len(), told.last.len()), (FIRST_STEPS, LAST_STEPS));
        assert_eq!(told.left_out, 800 - FIRST_STEPS - LAST_STEPS);
        assert!(told.last.back().is_some_and(|step| step.text == "shape.chance(i)"));
    }
    assert_eq!(account.take(), Telling::default());
}

#[test]
fn numbers_keep_six_digits() {
    let said = [0.0, 1.0 / 3.0, 1234.5678, 9_876_543.2, -0.000_012_345_678, f64::INFINITY, f64::NAN].map(number_says);
    assert_eq!(said, ["0.0", "0.333333", "1234.57", "9876543.2", "-0.0000123457", "endless", "not a number"]);
}

/// The rules of the library of a kind.
fn shipped(kind: RuleKind) -> Vec<Rule> {
    let host = Host::new(Vec::new());
    let rules = host.names().into_iter().map(|name| host.rule(&name).expect("a shipped rule loads"));
    rules.filter(|rule| rule.kinds().contains(&kind)).collect()
}

/// Asks a rule and the same that tells, and compares what they decide.
fn compare<D: PartialEq + fmt::Debug>(rule: &Rule, ask: impl Fn(Rule, Arc<Faults>) -> D) -> Result<(), TestCaseError> {
    let (telling, account) = rule.telling();
    let faults = [Arc::new(Faults::default()), Arc::new(Faults::default())];
    let decided = [ask(rule.clone(), faults[0].clone()), ask(telling, faults[1].clone())];
    prop_assert_eq!(&decided[0], &decided[1], "{}", rule.name());
    let messages = faults.map(|faults| faults.sorted().into_iter().map(|fault| fault.message).collect::<Vec<_>>());
    prop_assert_eq!(&messages[0], &messages[1]);
    prop_assert!(!account.take().first.is_empty(), "{} tells nothing", rule.name());
    Ok(())
}

#[test]
fn telling_takes_nothing_of_what_a_rule_may_do() {
    // 99,000 operations and more, most of which would be told.
    let text =
        "fn build(shape, p) {\n    let n = 0;\n    while shape.area > n { n += 0.04; }\n    shape.extrude(n);\n}";
    let choose = |rule: Rule| {
        let faults = Arc::new(Faults::default());
        let choice = BuildingPattern::new(rule, faults.clone()).choose(ShapeContext::bare(300.0, Seed(1)));
        (choice, faults.sorted().len())
    };
    let decided = choose(rule(text));
    assert_eq!((decided.1, choose(rule(text).telling().0)), (0, decided));
    // One without an end ends all the same.
    let endless = rule("fn build(shape, p) {\n    while shape.area > 1 { }\n}");
    assert_eq!([choose(endless.telling().0).1, choose(endless).1], [1, 1]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn a_rule_that_tells_decides_the_same(
        area in 1.0..40_000.0f64, density in 0.0..50_000.0f64, seed in any::<u64>(), age in 0..9u32, is_seed in any::<bool>()
    ) {
        for rule in shipped(RuleKind::Buildings) {
            let shape = ShapeContext { density, ..ShapeContext::bare(area, Seed(seed)) };
            compare(&rule, |rule, faults| BuildingPattern::new(rule, faults).choose(shape.clone()))?;
        }
        for rule in shipped(RuleKind::Parcels) {
            let block = BlockContext { density, ..BlockContext::bare(area, Seed(seed)) };
            compare(&rule, |rule, faults| ParcelPattern::new(rule, faults).choose(block.clone()))?;
        }
        let bounds = Bounds::between(Point::new(0, 0), Point::new(1 << 20, 1 << 20));
        let fields = Arc::new(Fields { density: Field::Constant(density), ..Fields::plain(bounds) });
        for rule in shipped(RuleKind::Streets) {
            let tip = Tip { age, is_seed, ..Tip::new(Classes::MINOR, Seed(seed), fields.clone()) };
            compare(&rule, |rule, faults| {
                let mut tip = tip.clone();
                StreetPattern::new(rule, 0, Arc::new(Classes::default()), faults).propose(&mut tip);
                format!("{:?}", tip.slots)
            })?;
        }
    }
}
