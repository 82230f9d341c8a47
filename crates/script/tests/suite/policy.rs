//! The policy of the rule language: what scripts cannot do, and how they are told.

use crate::common::{city, headline, rule, rule_among, shelf, source, tip};
use geom::{Point, Vec2};
use proptest::prelude::*;
use script::{Fault, Faults, Note, Rule, StreetPattern};
use std::sync::Arc;
use streets::Classes;
use streets::growth::{GrowthRules, Slots, Tip};

fn pattern(rule: Rule) -> (StreetPattern, Arc<Faults>) {
    let faults = Arc::new(Faults::default());
    (StreetPattern::new(rule, 4, Arc::new(Classes::default()), faults.clone()), faults)
}

fn proposed(rule: Rule, heading: f64) -> (Tip, Vec<Fault>) {
    let (pattern, faults) = pattern(rule);
    let mut tip = tip(heading);
    pattern.propose(&mut tip);
    (tip, faults.sorted())
}

/// The fault of a file that cannot be loaded.
fn refused(text: &str) -> Fault {
    rule(text).err().unwrap_or_else(|| panic!("`{text}` was loaded"))
}

/// The fault of a body of `propose`; the tip ends.
fn failing(body: &str) -> Fault {
    let rule = rule(&format!("fn propose(tip, p) {{\n{body}\n}}")).unwrap_or_else(|fault| panic!("{fault}"));
    let (tip, mut faults) = proposed(rule, 10.0);
    assert_eq!(tip.slots, Slots::default(), "a failing tip ends");
    assert_eq!(faults.len(), 1, "{body}: {faults:?}");
    assert_eq!(faults[0].place, Some(tip.place()));
    faults.remove(0)
}

/// What a failing body says, with its position.
fn says(body: &str) -> String {
    let fault = Fault { place: None, ..failing(body) };
    headline(&fault)
}

#[test]
fn endless_loops_end_where_they_loop() {
    let fault = failing("tip.ahead(10);\n    loop { }");
    assert_eq!((fault.line, fault.column), (3, 10));
    assert_eq!(fault.message, "stopped after 100000 operations");
    assert_eq!(fault.hint.as_deref(), Some("is there an endless loop?"));
    assert_eq!(city("\nwhile true { }").expect_err("endless").message, "stopped after 1000000 operations");
}

#[test]
fn the_operation_limit_counts_one_call_only() {
    let rule = rule("fn propose(tip, p) { for i in 0..3000 { } tip.ahead(10) }").expect("fine");
    let (pattern, faults) = pattern(rule);
    (0..100).for_each(|_| pattern.propose(&mut tip(0.0)));
    assert!(faults.is_empty(), "{:?}", faults.sorted());
}

#[test]
fn endless_recursion_ends() {
    let rule = rule("fn f(x) {\n  f(x + 1)\n}\nfn propose(tip, p) {\n  f(1)\n}").expect("loads");
    // As small a stack as any thread gets.
    let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(|| proposed(rule, 0.0)).expect("a thread");
    let fault = &thread.join().expect("no overflow").1[0];
    assert_eq!((fault.line, fault.message.as_str()), (5, "calls are nested too deeply"));
}

#[test]
fn deep_expressions_are_refused_when_read() {
    let deep = format!("fn propose(tip, p) {{ tip.ahead({}1{}) }}", "(1 + ".repeat(200), ")".repeat(200));
    assert_eq!(refused(&deep).message, "this expression is too deep or too long");
}

#[test]
fn huge_values_are_refused() {
    assert_eq!(says("let a = []; loop { a.push(1) }"), "mine.rhai:2:22: a list grew too large");
    assert_eq!(says("let a = []; a.pad(1000000000, 1);"), "mine.rhai:2:15: a list grew too large");
    assert_eq!(says("let a = \"ab\"; loop { a += a; }"), "mine.rhai:2:24: a text grew too large");
    assert_eq!(says("let a = \"a\"; a.pad(1000000000, \"b\");"), "mine.rhai:2:16: a text grew too large");
    let map = "let m = #{}; let i = 0; loop { m.set(i.to_string(), 1); i += 1; }";
    assert!(says(map).ends_with("a map grew too large"), "{}", says(map));
}

#[test]
fn unknown_words_are_told_before_anything_runs() {
    let fault = refused("fn propose(tip, p) {\n    if tip.age > 99 { tip.aheda(3) }\n}");
    assert_eq!(headline(&fault), "mine.rhai:2:27: there is no function `aheda`");
    assert_eq!(fault.hint.as_deref(), Some("did you mean `ahead`?"));
    let fault = refused("fn propose(tip, p) {\n    let lenght = 3;\n    tip.ahead(length);\n}");
    assert_eq!(headline(&fault), "mine.rhai:3:15: there is no variable `length` here");
    assert_eq!(fault.hint.as_deref(), Some("did you mean `lenght`?"));
}

#[test]
fn wrong_types_and_values_are_told_in_words() {
    let cases = [
        ("tip.ahead(\"x\");", "2:5: the length of a street must be a number, not a text"),
        ("tip.ahead(0);", "2:5: the length of a street must be above 0 and at most 10 km"),
        ("tip.ahead(10001);", "2:5: the length of a street must be above 0 and at most 10 km"),
        ("tip.ahead(1.0 / 0.0);", "2:5: the length of a street must be a finite number"),
        ("tip.branch_left(9, #{ width: 5,\n  delya: 2 });", "3:3: a street has no option `delya`"),
        ("tip.branch_left(9, #{ turn: 181 });", "2:23: `turn` must lie between -180 and 180°"),
        ("tip.steer(3);", "2:5: tip.steer takes cross(…), raster(…) or rings(…), not a whole number"),
        ("raster(0, 0, 5);", "2:1: the length of a block must lie between 1 and 10000 m"),
        ("raster(0, 5);", "2:1: `raster` does not take (a whole number, a whole number)"),
        ("let x = tip.headng;", "2:13: tip has no `headng`"),
        ("let x = p.nothing;", "2:11: p has no `nothing`"),
        ("tip.x = 3;", "2:5: tip cannot be given `x`"),
        ("tip.map(\"zones\");", "2:5: the site has no map `zones`"),
        ("let m = #{ a: 1 };\nlet x = m.b;", "3:11: there is no `b` in this map"),
        ("let x = 1 / 0;", "2:11: division by zero: 1 / 0"),
        ("throw \"enough\";", "2:1: enough"),
        ("params(#{});", "2:1: params(…) belongs at the top of the file, outside of functions"),
    ];
    for (body, wanted) in cases {
        assert_eq!(says(body), format!("mine.rhai:{wanted}"), "{body}");
    }
}

#[test]
fn what_is_switched_off_is_not_there() {
    assert_eq!(refused("fn propose(tip, p) { eval(\"1\") }").message, "there is no `eval`");
    assert_eq!(refused("fn propose(tip, p) { 2 ** 3 }").message, "there is no operator `**`");
    for word in ["timestamp", "sleep", "rand", "exit", "read_file", "parse_json", "blob", "get_fn_metadata_list"] {
        let fault = refused(&format!("fn propose(tip, p) {{ {word}(1) }}"));
        assert_eq!(fault.message, format!("there is no function `{word}`"));
    }
}

#[test]
fn numbers_come_from_libm_and_take_whole_numbers() {
    let texts = ["sin(1)", "exp(2)", "pow(3, 0.3)", "hypot(3, 4)", "atan(1, 2)", "ln(7)", "12.pct", "max(1, 2.5)"];
    let values =
        [libm::sin(1.0), libm::exp(2.0), libm::pow(3.0, 0.3), 5.0, libm::atan2(1.0, 2.0), libm::log(7.0), 0.12, 2.5];
    for (text, value) in texts.iter().zip(values) {
        let (tip, faults) = proposed(rule(&format!("fn propose(tip, p) {{ tip.ahead({text}) }}")).expect("loads"), 0.0);
        assert!(faults.is_empty(), "{text}: {faults:?}");
        assert_eq!(tip.slots.ahead.expect("ahead").length, value, "{text}");
    }
}

#[test]
fn imports_stay_inside() {
    for path in ["../secret", "/etc/passwd", "a/../../b", "./x", "C:/x", ""] {
        let text = format!("import \"{path}\" as x;\nfn propose(tip, p) {{ }}");
        let fault = refused(&text);
        assert!(fault.message.contains("names nothing inside a rule library"), "{fault}");
        assert_eq!(fault.line, 1);
    }
    // Also when asked for while running.
    assert!(says("import \"../x\" as x;").contains("names nothing inside a rule library"));
}

#[test]
fn imports_work_with_functions_and_constants() {
    let lib = "export const STEP = 7;\nfn twice(x) { x * 2 + global::OWN }\nconst OWN = 1;";
    let text = "import \"lib/one\" as one;\nconst K = 3;\nfn mine(x) { one::twice(x) + global::K }\n\
                fn propose(tip, p) { tip.ahead(mine(one::STEP)) }";
    let (tip, faults) = proposed(rule_among(text, &[("lib/one.rhai", lib)]).expect("loads"), 0.0);
    assert_eq!((tip.slots.ahead.map(|slot| slot.length), faults), (Some(18.0), vec![]));
}

#[test]
fn faults_in_imports_name_their_own_file() {
    let text = "import \"one\" as one;\nfn propose(tip, p) {\n  one::f(tip)\n}";
    let lib = "fn g(t) {\n\n  t.ahead(-1)\n}\nfn f(t) { g(t) }";
    let (_, faults) = proposed(rule_among(text, &[("one.rhai", lib)]).expect("loads"), 0.0);
    assert_eq!((faults[0].file.as_str(), faults[0].line, faults[0].column), ("one.rhai", 3, 5));
    let fault = rule_among(text, &[("one.rhai", "fn f(t) {\n  let = 3;\n}")]).expect_err("no name");
    assert_eq!((fault.file.as_str(), fault.line), ("one.rhai", 2));
}

#[test]
fn circles_of_imports_are_told() {
    let files = [("a.rhai", "import \"b\" as b;"), ("b.rhai", "import \"c\" as c;"), ("c.rhai", "import \"a\" as a;")];
    let fault = rule_among("import \"a\" as a;\nfn propose(tip, p) { }", &files).expect_err("a circle");
    assert_eq!(fault.message, "imports go in a circle: a → b → c → a");
    assert_eq!((fault.file.as_str(), fault.line, fault.column), ("c.rhai", 1, 8));
    // Nothing of it is left behind.
    assert!(rule_among("import \"d\" as d;\nfn propose(tip, p) { }", &[("d.rhai", "fn f() { }")]).is_ok());
}

#[test]
fn an_import_takes_the_same_of_the_limit_whoever_came_first() {
    let wait = "let i = 0;\nwhile i < 10_000 { i += 1; }\n";
    let host = script::Host::new(vec![shelf(&[("long.rhai", wait)])]);
    let load = |text: &str| host.rule_of("mine", &source(&format!("{text}fn propose(tip, p) {{ }}")));
    let both = format!("import \"long\" as l;\n{wait}");
    let first = load(&both).expect_err("too long");
    assert_eq!(first.message, "stopped after 100000 operations");
    assert!(load(wait).is_ok() && load("import \"long\" as l;\n").is_ok(), "each alone is within the limit");
    assert_eq!(load(&both).expect_err("too long"), first);
}

#[test]
fn a_rule_may_use_another_without_its_parameters() {
    let other = "params(#{ a: metres(3) });\nfn propose(tip, p) { tip.ahead(5) }";
    let text = "import \"other\" as other;\nparams(#{ b: metres(4) });\nfn propose(tip, p) { other::propose(tip, p); }";
    let rule = rule_among(text, &[("other.rhai", other)]).expect("loads");
    assert_eq!(rule.params().iter().map(|(param, _)| param.name.as_str()).collect::<Vec<_>>(), ["b"]);
    assert_eq!(proposed(rule, 0.0).0.slots.ahead.map(|slot| slot.length), Some(5.0));
}

#[test]
fn a_file_that_decides_nothing_is_told_what_it_may_decide() {
    assert_eq!(refused("fn propos(tip, p) { }").hint.as_deref(), Some("did you mean `fn propose(tip, p)`?"));
    assert_eq!(refused("fn build(p) { }").hint.as_deref(), Some("write `fn build(shape, p)`"));
    let help = Some("it is an argument: write `fn propose(tip, p)`");
    assert_eq!(refused("fn propose() { tip.ahead(5); }").hint.as_deref(), help);
    assert_ne!(refused("fn f() { tip.x }\nfn propose(tip, p) { f(); }").hint.as_deref(), help);
    assert!(refused("").hint.expect("a hint").starts_with("a rule has one of the functions propose(tip, p), "));
}

#[test]
fn a_value_kept_from_an_earlier_call_is_refused() {
    let text = "const KEPT = [];\nfn propose(tip, p) { global::KEPT.push(tip); tip.ahead(global::KEPT.len() + 1); }";
    let (pattern, _) = pattern(rule(text).expect("loads"));
    let lengths: Vec<_> = (0..3)
        .map(|_| {
            let mut tip = tip(0.0);
            pattern.propose(&mut tip);
            tip.slots.ahead.map(|slot| slot.length)
        })
        .collect();
    assert!(lengths.windows(2).all(|pair| pair[0] == pair[1]), "a call left something behind: {lengths:?}");
}

#[test]
fn equal_faults_are_one_with_a_count() {
    let (pattern, faults) = pattern(rule("fn propose(tip, p) {\n  tip.ahead(tip.chance(1) - 2);\n}").expect("loads"));
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let pattern = &pattern;
            scope.spawn(move || {
                for i in 0..50 {
                    let mut tip = tip(0.0);
                    tip.seed = geom::Seed(thread * 50 + i);
                    pattern.propose(&mut tip);
                }
            });
        }
    });
    let sorted = faults.sorted();
    assert_eq!((sorted.len(), sorted[0].count), (1, 200));
}

#[test]
fn what_rules_print_is_kept_with_counts() {
    let rule = rule("fn propose(tip, p) { print(\"here \" + tip.age); }").expect("loads");
    let (pattern, _) = pattern(rule.clone());
    let places = [3.0, 1.0, 2.0].map(|x| Vec2::new(x, 5.0 - x));
    for place in places {
        pattern.propose(&mut Tip { at: Point::from_metres(place), ..tip(0.0) });
    }
    assert_eq!(rule.notes(), [Note { text: "here 3".into(), count: 3, place: Some(places[1]) }]);
}

#[test]
fn chance_is_keyed() {
    let text = "fn propose(tip, p) { tip.ahead(1 + tip.chance(1)); tip.branch_left(1 + tip.chance(2)); \
                tip.branch_right(tip.chance(1, 5, 6)); }";
    let (tip, faults) = proposed(rule(text).expect("loads"), 0.0);
    assert!(faults.is_empty(), "{faults:?}");
    let lengths = [tip.slots.ahead, tip.slots.left, tip.slots.right].map(|slot| slot.expect("filled").length);
    let seed = tip.seed;
    assert_eq!(lengths, [1.0 + seed.unit(1), 1.0 + seed.unit(2), seed.range(1, 5.0, 6.0)]);
    let reordered =
        "fn propose(tip, p) { tip.chance(9); tip.branch_left(1 + tip.chance(2)); tip.ahead(1 + tip.chance(1)); }";
    let (other, _) = proposed(rule(reordered).expect("loads"), 0.0);
    assert_eq!((other.slots.ahead, other.slots.left), (tip.slots.ahead, tip.slots.left));
}

#[test]
fn files_are_read_through_libraries_only() {
    // A shelf asserts that it is never asked for a name that leaves it.
    let host = script::Host::new(vec![shelf(&[])]);
    for name in ["../streets/grid", "/streets/grid", "streets//grid", "streets/../streets/grid"] {
        assert!(host.rule(name).expect_err("outside").message.contains("names nothing inside"), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any number of threads proposes the same.
    #[test]
    fn threads_agree(headings in prop::collection::vec(-180.0..180.0f64, 8)) {
        let text = "params(#{ a: metres(40) });\nconst K = 5;\nfn turn(t) { t.chance(2, -9, 9) + global::K }\n\
                    fn propose(tip, p) { tip.steer(cross(p.a)); tip.ahead(p.a + tip.chance(1), #{ turn: turn(tip) }); }";
        let (pattern, faults) = pattern(rule(text).expect("loads"));
        let ask = |heading: f64| { let mut tip = tip(heading); pattern.propose(&mut tip); tip.slots };
        let alone: Vec<Slots> = headings.iter().map(|h| ask(*h)).collect();
        let together: Vec<Slots> = std::thread::scope(|scope| {
            let handles: Vec<_> = headings.iter().map(|h| scope.spawn(|| ask(*h))).collect();
            handles.into_iter().map(|handle| handle.join().expect("no panic")).collect()
        });
        prop_assert_eq!(alone, together);
        prop_assert!(faults.is_empty());
    }

    /// Whatever is written, the answer is a rule or a fault, never a panic.
    #[test]
    fn nonsense_is_survived(text in "(fn propose\\(tip, p\\) \\{)?[a-z0-9 .,;:#(){}\\[\\]+*/\"!=<>\n-]{0,80}") {
        match rule(&text) {
            Ok(rule) => drop(proposed(rule, 0.0)),
            Err(fault) => prop_assert!(!fault.message.is_empty()),
        }
        let _ = city(&text);
    }
}
