//! Parameters: declaration, order, values, errors.

use crate::common::{self, headline, rule};
use script::{Domain, Literal, Rule, Unit};

const TEXT: &str = "params(#{
    zeta: metres(250).range(60, 400).about(\"Length\"),
    alpha: degrees(-29),
    mid: ratio(25.pct),
    count: whole(3).range(1, 9),
    style: choice(\"old\", [\"old\", \"new\"]),
    lit: flag(true),
    where: map(\"density\"),
    paint: colour(\"#c0ffee\"),
    plain: number(4),
});
fn propose(tip, p) { tip.ahead(p.zeta + p.count); }";

fn loaded() -> Rule {
    rule(TEXT).unwrap_or_else(|fault| panic!("{fault}"))
}

#[test]
fn the_order_is_the_author_s() {
    let rule = loaded();
    let names: Vec<&str> = rule.params().iter().map(|(param, _)| param.name.as_str()).collect();
    assert_eq!(names, ["zeta", "alpha", "mid", "count", "style", "lit", "where", "paint", "plain"]);
}

#[test]
fn declarations_are_kept_whole() {
    let rule = loaded();
    let (zeta, value) = rule.params().iter().next().expect("the first");
    assert_eq!(zeta.domain, Domain::Number { unit: Unit::Metres, range: (60.0, 400.0) });
    assert_eq!((&zeta.default, zeta.about.as_str()), (&Literal::Number(250.0), "Length"));
    assert_eq!(value.constant(), Some(&Literal::Number(250.0)));
    assert_eq!(zeta.describe(), "250 m (a number from 60 to 400 m)");
    let all: Vec<String> = rule.params().iter().map(|(_, value)| value.to_string()).collect();
    assert_eq!(all, ["250", "-29", "0.25", "3", "old", "true", "density", "#c0ffee", "4"]);
}

#[test]
fn values_are_read_and_checked() {
    let rule = loaded();
    let set = |name: &str, text: &str| {
        rule.with_text(name, text)
            .map(|rule| rule.params().get(name).expect("declared").constant().expect("one").clone())
    };
    assert_eq!(set("zeta", "90.5"), Ok(Literal::Number(90.5)));
    assert_eq!(set("count", " 4 "), Ok(Literal::Whole(4)));
    assert_eq!(set("style", "new"), Ok(Literal::Choice("new".into())));
    assert_eq!(set("lit", "false"), Ok(Literal::Flag(false)));
    assert_eq!(set("paint", "#010203"), Ok(Literal::Colour([1, 2, 3])));
    let says = |name: &str, text: &str| set(name, text).expect_err("wrong").message;
    assert_eq!(says("zeta", "30"), "`zeta` must be a number from 60 to 400 m, not 30");
    assert_eq!(says("zeta", "wide"), "`zeta` must be a number from 60 to 400 m, not `wide`");
    assert_eq!(says("alpha", "NaN"), "`alpha` must be a finite number, not NaN");
    assert_eq!(says("alpha", "inf"), "`alpha` must be a finite number, not inf");
    assert_eq!(says("count", "2.5"), "`count` must be a whole number from 1 to 9, not `2.5`");
    assert_eq!(says("style", "odl"), "`style` must be one of `old`, `new`, not odl");
    assert_eq!(says("lit", "yes"), "`lit` must be true or false, not `yes`");
    assert_eq!(says("paint", "red"), "`paint` must be a colour such as #c0ffee, not `red`");
    let error = set("zata", "90").expect_err("unknown");
    assert_eq!(
        (error.message.as_str(), error.hint.as_deref()),
        ("there is no parameter `zata`", Some("did you mean `zeta`?"))
    );
    assert_eq!(set("style", "odl").expect_err("unknown").hint.as_deref(), Some("did you mean `old`?"));
}

#[test]
fn a_literal_of_the_wrong_kind_is_refused() {
    let rule = loaded();
    assert!(rule.params().with("zeta", Literal::Flag(true)).is_err());
    assert!(rule.params().with("lit", Literal::Number(1.0)).is_err());
    assert!(rule.params().with("zeta", Literal::Number(f64::NAN)).is_err());
}

#[test]
fn a_rule_with_other_values_leaves_the_first_alone() {
    let rule = loaded();
    let other = rule.with_text("zeta", "100").expect("in range");
    assert_eq!(rule.params().get("zeta").expect("declared").constant(), Some(&Literal::Number(250.0)));
    assert_eq!(other.params().get("zeta").expect("declared").constant(), Some(&Literal::Number(100.0)));
    assert_ne!(rule.fingerprint(), other.fingerprint());
    assert_eq!(other.with_text("zeta", "250").expect("in range").fingerprint(), rule.fingerprint());
}

#[test]
fn fingerprints_hold_imports() {
    let text = "import \"lib\" as lib;\nfn propose(tip, p) { }";
    let of = |lib: &str| common::rule_among(text, &[("lib.rhai", lib)]).expect("loads").fingerprint();
    assert_eq!(of("fn f() { 1 }"), of("fn f() { 1 }"));
    assert_ne!(of("fn f() { 1 }"), of("fn f() { 2 }"));
}

#[test]
fn wrong_declarations_are_placed() {
    let says = |params: &str| {
        let fault = rule(&format!("params(#{{\n  {params}\n}});\nfn propose(tip, p) {{ }}")).expect_err("wrong");
        headline(&fault)
    };
    assert_eq!(says("a: 3"), "mine.rhai:2:3: `a` must be a parameter, not a whole number");
    assert_eq!(
        says("a: metres(3), b: metres(9).range(0, 5)"),
        "mine.rhai:2:17: the default of `b` must be a number from 0 to 5 m, not 9"
    );
    assert_eq!(says("a: metres(3).range(5, 0)"), "mine.rhai:2:16: the range runs from high to low");
    assert_eq!(says("a: flag(true).range(5, 9)"), "mine.rhai:2:17: only numbers have a range");
    assert_eq!(says("a: metres(\"x\")"), "mine.rhai:2:6: the default must be a number, not a text");
    assert_eq!(says("a: ratio(1.5)"), "mine.rhai:2:3: the default of `a` must be a number from 0 to 1, not 1.5");
    assert_eq!(says("a: colour(\"red\")"), "mine.rhai:2:6: the default must be a colour such as #c0ffee, not `red`");
    assert_eq!(
        says("a: choice(\"c\", [\"a\", \"b\"])"),
        "mine.rhai:2:3: the default of `a` must be one of `a`, `b`, not c"
    );
    let twice = rule("params(#{});\nparams(#{});\nfn propose(tip, p) { }").expect_err("twice");
    assert_eq!(headline(&twice), "mine.rhai:2:1: params(…) stands twice in this file");
}
