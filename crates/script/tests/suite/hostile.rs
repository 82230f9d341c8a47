//! Hostile scripts: what somebody might write to reach out of the language, to hang the program or to bring it down. Each is
//! stopped with a fault in words at its line, and what is asked next works as if it had never been there.
//!
//! These tables are for whoever wants to know what a script from a stranger can do. `policy.rs` says the same of single
//! promises; `fuzz_rules.rs` looks for what nobody thought of.

use crate::common::{Folders, shelf, source, tip};
use script::{Fault, Faults, Host, Source, StreetPattern};
use std::sync::Arc;
use streets::growth::GrowthRules;

/// Files beside the script.
const FILES: [(&str, &str); 9] = [
    ("self.rhai", "import \"self\" as own;"),
    ("here.rhai", "import \"there\" as there;"),
    ("there.rhai", "import \"here\" as here;"),
    ("fails.rhai", "let i = 0;\nwhile i < 10_000 { i += 1; }\nthrow \"never\";"),
    ("endless.rhai", "loop { }"),
    ("holds.rhai", "fn f() { let n = 1; || n }"),
    // Each goes down as far as calls go, and imports the next from there.
    (
        "deep.rhai",
        "fn f(n) {\n  for i in 0..1 { for j in 0..1 { for k in 0..1 { if n == 0 { import \"deeper\" as d; print(n); } else { f(n - 1); } } } }\n}\nf(35);",
    ),
    (
        "deeper.rhai",
        "fn f(n) {\n  for i in 0..1 { for j in 0..1 { for k in 0..1 { if n == 0 { import \"deepest\" as d; print(n); } else { f(n - 1); } } } }\n}\nf(35);",
    ),
    ("deepest.rhai", "fn f(n) {\n  if n > 0 { f(n - 1); }\n}\nf(35);"),
];

/// Bodies of `propose(tip, p)`, and how the message begins.
const BODIES: &[(&str, &str, &str)] = &[
    ("opens a file", r#"open("/etc/passwd");"#, "`open` does not take (a text)"),
    ("reads a file", r#"let text = read_file("city.rhai");"#, "there is no function `read_file`"),
    ("reads a file, as a type", r#"let f = File("x"); f.read_string();"#, "there is no function `File`"),
    ("writes a file", r#"write_file("x", "y");"#, "there is no function `write_file`"),
    ("asks for the clock", "let t = timestamp();", "there is no function `timestamp`"),
    ("sleeps", "sleep(1000);", "there is no function `sleep`"),
    ("asks for chance that is not keyed", "let r = rand();", "there is no function `rand`"),
    ("asks for chance of a list", "[1, 2, 3].shuffle();", "there is no function `shuffle`"),
    ("leaves the program", "exit(1);", "there is no function `exit`"),
    ("runs a program", r#"system("rm -rf /");"#, "there is no function `system`"),
    ("reads the environment", r#"env("HOME");"#, "there is no function `env`"),
    ("starts a thread", "spawn(|| 1);", "there is no `spawn`"),
    ("asks what functions there are", "get_fn_metadata_list();", "there is no function `get_fn_metadata_list`"),
    ("evaluates a text", r#"eval("1 + 1");"#, "there is no `eval`"),
    ("evaluates a text by another name", r#"Fn("eval").call("1 + 1");"#, "there is no `eval`"),
    ("raises to a power natively", "let x = 2 ** 3;", "there is no operator `**`"),
    ("makes bytes", "let b = blob(1000000000);", "there is no function `blob`"),
    ("reads JSON", r#"parse_json("{}");"#, "there is no function `parse_json`"),
    (
        "imports from above",
        r#"import "../secret" as x; x::f();"#,
        "cannot import `../secret`: names nothing inside a rule library",
    ),
    (
        "imports from the root",
        r#"import "/etc/passwd" as x; x::f();"#,
        "cannot import `/etc/passwd`: names nothing inside a rule library",
    ),
    (
        "imports from a drive",
        r#"import "C:/x" as x; x::f();"#,
        "cannot import `C:/x`: names nothing inside a rule library",
    ),
    (
        "imports over backslashes",
        r#"import "..\\..\\x" as x; x::f();"#,
        "cannot import `..\\..\\x`: names nothing inside a rule library",
    ),
    (
        "imports from the net",
        r#"import "https://example.com/x" as x; x::f();"#,
        "cannot import `https://example.com/x`: names nothing inside a rule",
    ),
    (
        "imports what is composed",
        r#"let up = ".."; import up + "/x" as x; x::f();"#,
        "cannot import `../x`: names nothing inside a rule library",
    ),
    ("imports itself", r#"import "self" as s; s::f();"#, "imports go in a circle: self → self"),
    ("imports in a circle", r#"import "here" as h; h::f();"#, "imports go in a circle: here → there → here"),
    (
        "imports what is not there",
        r#"import "nowhere" as n; n::f();"#,
        "cannot import `nowhere`: there is no rule of that name in the shelf,",
    ),
    ("imports what never ends", r#"import "endless" as e; e::f();"#, "stopped after 100000 operations"),
    (
        "imports what fails, again and again",
        r#"loop { try { import "fails" as f; f::x(); } catch { } }"#,
        "stopped after 100000 operations",
    ),
    ("imports from deep within calls", r#"import "deep" as d; d::f(0);"#, "calls are nested too deeply"),
    (
        "imports a closure that holds a variable",
        r#"import "holds" as h; h::f();"#,
        "a closure does not see the variable `n`",
    ),
    ("imports without an end", r#"for i in 0..100 { import "deepest" as d; print(i); }"#, "too many modules imported"),
    ("loops", "loop { }", "stopped after 100000 operations"),
    ("loops while", "while true { }", "stopped after 100000 operations"),
    ("loops until", "do { } until false;", "stopped after 100000 operations"),
    ("loops over all numbers", "for i in 0..9223372036854775807 { print(1); }", "stopped after 100000 operations"),
    (
        "loops over all numbers, downwards",
        "for i in range(9223372036854775807, -9223372036854775807, -1) { }",
        "stopped after 100000 operations",
    ),
    ("loops by steps of nothing", "for i in range(0, 10, 0) { }", "step value cannot be zero"),
    ("loops by tiny steps", "for i in range(0.0, 1.0, 1e-308) { }", "stopped after 100000 operations"),
    ("loops in what it catches", "try { loop { } } catch { }", "stopped after 100000 operations"),
    ("catches every error", "loop { try { throw 1; } catch { } }", "stopped after 100000 operations"),
    ("hides code behind a comment", "// nothing\rloop { }", "a carriage return stands within this line"),
    (
        "loops in callbacks of callbacks",
        "let l = []; l.pad(1000, 1); l.map(|x| { let l = []; l.pad(1000, 1); l.map(|x| { let l = []; l.pad(1000, 1); l.map(|x| x); }); });",
        "stopped after 100000 operations",
    ),
    (
        "fails in callbacks, and catches it",
        "loop { try { [1].map(|x| { for i in 0..10_000 { x += i; } throw x; }); } catch { } }",
        "stopped after 100000 operations",
    ),
    (
        "loops while it sorts",
        "let l = []; for i in 0..600 { l.push(i); } l.sort(|a, b| { loop { } }); l.dedup(|a, b| { loop { } }); tip.ahead(1);",
        "stopped after 100000 operations",
    ),
    ("lists a range", "let l = []; for i in 0..1000000000 { l.push(i); }", "a list grew too large"),
    ("doubles a list", "let l = [1]; loop { l += l; }", "a list grew too large"),
    ("nests a list", "let l = []; loop { l = [l, l]; }", "a list grew too large"),
    ("pushes a list into itself", "let l = [1]; loop { l.push(l); }", "a list grew too large"),
    ("pads a list", "let l = []; l.pad(9223372036854775807, 1);", "a list grew too large"),
    ("pads a list with lists", "let l = []; l.pad(1000, [1, 2, 3]);", "a list grew too large"),
    ("doubles a text", r#"let s = "x"; loop { s += s; }"#, "a text grew too large"),
    ("pads a text", r#"let s = ""; s.pad(9223372036854775807, 'x');"#, "a text grew too large"),
    ("interpolates a text", r#"let s = "x"; loop { s = `${s}${s}`; }"#, "a text grew too large"),
    ("replaces letters by the text", r#"let s = ""; s.pad(9999, 'x'); s.replace("x", s);"#, "a text grew too large"),
    (
        "makes a text of long texts",
        r#"let s = ""; s.pad(9000, 'x'); let t = [s, s].to_string();"#,
        "a text grew too large",
    ),
    ("doubles a map", "let m = #{}; loop { m[`${m.len()}`] = 1; }", "a map grew too large"),
    ("nests a map", "let m = #{}; loop { m = #{ a: m, b: m }; }", "a map grew too large"),
    ("calls itself", "propose(tip, p);", "calls are nested too deeply"),
    ("calls itself by a pointer", r#"Fn("propose").call(tip, p);"#, "calls are nested too deeply"),
    ("calls itself in a list", r#"[1].map(|x| Fn("propose").call(x, x));"#, "calls are nested too deeply"),
    ("curries without an end", "let f = |x| x; loop { f = f.curry(1); }", "expecting the name of a property"),
    ("nests closures", "let f = || 1; loop { let g = f; f = || g.call(); }", "a closure does not see the variable `g`"),
    ("holds itself in a closure", "let l = []; let f = || l; l.push(f);", "a closure does not see the variable `l`"),
    (
        "asks a list while it changes",
        "let l = [1]; loop { try { l.for_each(|x| l.push(x)); } catch { } }",
        "a closure does not see the variable `l`",
    ),
    (
        "changes what is around a closure",
        "let n = 0; [1, 2].for_each(|x| n += x);",
        "a closure does not see the variable `n`",
    ),
    ("looks at the shore without an end", "loop { tip.shore(2000); }", "the call looks at too many places"),
    (
        "looks for density without an end",
        "loop { tip.seek_density(100000, 180, 90); }",
        "the call looks at too many places",
    ),
    (
        "adds beyond the end of numbers",
        "let x = 9223372036854775807; x += 1;",
        "addition overflow: 9223372036854775807 + 1",
    ),
    (
        "subtracts beyond the end of numbers",
        "let x = -9223372036854775807; x -= 2;",
        "subtraction overflow: -9223372036854775807 - 2",
    ),
    (
        "multiplies beyond the end of numbers",
        "let x = 9223372036854775807; x *= 2;",
        "multiplication overflow: 9223372036854775807 * 2",
    ),
    ("negates the least number", "let x = -9223372036854775807 - 1; x = -x;", "integer overflow"),
    (
        "takes the least number without its sign",
        "let x = -9223372036854775807 - 1; abs(x);",
        "negation overflow: --9223372036854775808",
    ),
    (
        "divides the least number",
        "let x = -9223372036854775807 - 1; x / -1;",
        "division overflow: -9223372036854775808 / -1",
    ),
    (
        "takes the rest of the least number",
        "let x = -9223372036854775807 - 1; x % -1;",
        "modulo division by zero or overflow: -9223372036854775808 % -1",
    ),
    ("divides by nothing", "let x = 1 / 0;", "division by zero: 1 / 0"),
    ("takes the rest of nothing", "let x = 1 % 0;", "modulo division by zero or overflow: 1 % 0"),
    (
        "shifts too far",
        "tip.ahead(1 << 9223372036854775807);",
        "the length of a street must be above 0 and at most 10 km",
    ),
    ("makes a whole number of too much", "to_int(1e300);", "to_int: the number does not fit a whole number"),
    ("makes a whole number of none", "to_int(0.0 / 0.0);", "to_int: the number does not fit a whole number"),
    ("makes a number of a word", r#"parse_int("many");"#, "there is no function `parse_int`"),
    ("reads beyond a list", "let l = [1]; l[5];", "there is no item 5: the list has 1 item"),
    (
        "reads before a list",
        "let l = [1]; l[-9223372036854775807];",
        "there is no item -9223372036854775807: the list has 1 item",
    ),
    (
        "writes beyond a list",
        "let l = [1]; l[9223372036854775807] = 1;",
        "there is no item 9223372036854775807: the list has 1 item",
    ),
    (
        "reads beyond a text",
        r#"let s = "x"; s[9223372036854775807];"#,
        "string index 9223372036854775807 out of bounds: only 1 character in",
    ),
    ("sorts what has no order", r#"let l = [1, "a", ()]; l.sort();"#, "elements of different types cannot be sorted"),
    // What does no harm goes on, here to a street of no length.
    (
        "throws while it sorts",
        r#"let l = [3, 2, 1]; l.sort(|a, b| throw "no"); tip.ahead(0);"#,
        "the length of a street must be above 0 and at most 10 km",
    ),
    (
        "sorts without an order",
        "let l = []; for i in 0..600 { l.push(i * 7919 % 97); } l.sort(|a, b| if (a * b) % 3 == 1 { 1 } else { -1 }); tip.ahead(0);",
        "the length of a street must be above 0 and at most 10 km",
    ),
    (
        "takes parts that are not there",
        "let l = [1, 2]; l.splice(-9223372036854775807, 9223372036854775807, [3]); l.drain(9223372036854775807, -1); l.extract(-9223372036854775807); l.chop(-1); l.truncate(-1); l.insert(-9223372036854775807, 1); tip.ahead(0);",
        "the length of a street must be above 0 and at most 10 km",
    ),
    (
        "cuts texts beyond their ends",
        r#"let s = "äö"; s.sub_string(-9223372036854775807, 9223372036854775807); s.crop(9223372036854775807, -1); s.truncate(-1); tip.ahead(0);"#,
        "the length of a street must be above 0 and at most 10 km",
    ),
    ("goes an endless way", "tip.ahead(1.0 / 0.0);", "the length of a street must be a finite number"),
    ("goes no way at all", "tip.ahead(0.0 / 0.0);", "the length of a street must be a finite number"),
    ("writes to the tip", "tip.x = 0;", "tip cannot be given `x`"),
    ("changes a parameter", "p.length = 3;", "p cannot be given `length`"),
    ("throws the tip", "throw tip;", "the script throws a value without words"),
    ("throws nothing", "throw ();", "the script throws an empty text"),
    ("changes this", "this = 1;", "'this' not bound"),
    ("throws control characters", r#"throw "\x1b[2J";"#, "U+001B[2J"),
    ("changes what the whole file shares", "global::X = 1;", "there is no variable `global::X` here"),
];

/// Whole rules.
const RULES: &[(&str, &str, &str)] = &[
    (
        "redefines params in a function",
        "fn propose(tip, p) { params(#{ a: metres(1) }); }",
        "params(…) belongs at the top of the file, outside of functions",
    ),
    (
        "has params twice",
        "params(#{ a: metres(1) });
params(#{ a: metres(1) });
fn propose(tip, p) { }",
        "params(…) stands twice in this file",
    ),
    (
        "loops at the top",
        "loop { }
fn propose(tip, p) { }",
        "stopped after 100000 operations",
    ),
    (
        "keeps the tip",
        "const KEPT = [];
fn propose(tip, p) { global::KEPT.push(tip); global::KEPT.push(tip); tip.ahead(0); }",
        "non-pure method 'push' cannot be called on constant",
    ),
    (
        "goes through two functions without an end",
        "fn a(n) { b(n) }
fn b(n) { a(n) }
fn propose(tip, p) { a(1); }",
        "calls are nested too deeply",
    ),
    (
        "replaces a word of the tip",
        "fn ahead(x) { loop { } }
fn propose(tip, p) { tip.ahead(0); }",
        "stopped after 100000 operations",
    ),
    (
        "replaces a word by one that calls itself",
        "fn max(a, b) { max(b, a) }
fn propose(tip, p) { max(1, 2); }",
        "calls are nested too deeply",
    ),
    (
        "calls itself in deep loops",
        "fn f() { for a in 0..1 { for b in 0..1 { for c in 0..1 { for d in 0..1 { f() } } } } }
fn propose(tip, p) { f(); }",
        "calls are nested too deeply",
    ),
    (
        "calls itself in deep lists",
        "fn f() { [[[[[[[[[[f()]]]]]]]]]] }
fn propose(tip, p) { f(); }",
        "calls are nested too deeply",
    ),
    (
        "calls itself in callbacks",
        "fn f(n) { [[n]].map(|x| x.map(|y| f(y))) }
fn propose(tip, p) { f(1); }",
        "calls are nested too deeply",
    ),
    ("has no end", "fn propose(tip, p) {", "expecting '}' to terminate this block"),
    ("has a text without an end", r#"fn propose(tip, p) { ""#, "this text has no end"),
    ("has a comment without an end", "fn propose(tip, p) { /*", "expecting '}' to terminate this block"),
    ("names a word of the language", "fn propose(tip, p) { let if = 1; }", "expecting the name of a variable"),
];

/// City scripts.
const CITIES: &[(&str, &str, &str)] = &[
    ("loops without an end", "loop { }", "stopped after 1000000 operations"),
    ("reads a file", r#"let text = open("/etc/passwd");"#, "there is no function `open`"),
    ("takes maps from above", r#"let s = site("../maps");"#, "`../maps` is not a folder below this one"),
    (
        "takes streets from the root",
        r#"streets_from("/etc/passwd");"#,
        "`/etc/passwd` is not a file below the script's folder",
    ),
    (
        "takes streets from above",
        r#"streets_from("../../x.geojson");"#,
        "`../../x.geojson` is not a file below the script's folder",
    ),
    ("takes a rule from above", r#"rule("../x");"#, "rule \"../x\": names nothing inside a rule library"),
    (
        "takes a rule from the root",
        r#"rule("/etc/passwd");"#,
        "rule \"/etc/passwd\": names nothing inside a rule library",
    ),
    ("takes a rule that never ends", r#"rule("endless");"#, "stopped after 100000 operations"),
    (
        "takes districts from above",
        r#"districts_from("../x.geojson");"#,
        "`../x.geojson` is not a file below the script's folder",
    ),
    ("nests closures", "let f = || 1; loop { let g = f; f = || g.call(); }", "a closure does not see the variable `g`"),
    ("replaces letters by the text", r#"let s = ""; s.pad(99999, 'x'); s.replace("x", s);"#, "a text grew too large"),
    (
        "replaces letters by the text, letter by letter",
        r#"let s = ""; s.pad(99999, 'x'); s.replace('x', s);"#,
        "a text grew too large",
    ),
    ("lists all numbers", "let l = []; for i in 0..1000000000 { l.push(i); }", "a list grew too large"),
    ("calls itself", "fn f() { f() } f();", "calls are nested too deeply"),
    ("imports from above", r#"import "../x" as x;"#, "cannot import `../x`: names nothing inside a rule library"),
    ("imports from deep within calls", r#"import "deep" as d;"#, "calls are nested too deeply"),
    ("draws a line of endless points", "line([[1.0 / 0.0, 0], [1, 1]]);", "x must be a finite number"),
    ("draws a line beyond the world", "line([[1e300, 0], [1, 1]]);", "a point lies more than 500 km away"),
];

fn host() -> Host {
    Host::new(vec![shelf(&FILES)])
}

/// What a rule says when it is loaded, checked or asked.
fn told(host: &Host, text: &str) -> Option<Fault> {
    host.check_rule("mine", &source(text));
    let rule = match host.rule_of("mine", &source(text)) {
        Ok(rule) => rule,
        Err(fault) => return Some(fault),
    };
    let faults = Arc::new(Faults::default());
    StreetPattern::new(rule, 0, Arc::default(), faults.clone()).propose(&mut tip(0.0));
    faults.sorted().into_iter().next()
}

/// Whether an innocent rule still works on the same host.
fn is_well(host: &Host) -> bool {
    let rule = host.rule_of("good", &source("fn propose(tip, p) { tip.ahead(50); }")).expect("an innocent rule");
    let mut tip = tip(0.0);
    StreetPattern::new(rule, 0, Arc::default(), Arc::default()).propose(&mut tip);
    tip.slots.ahead.is_some_and(|slot| slot.length == 50.0)
}

/// Runs on as small a stack as any thread gets.
fn on_a_small_stack(work: impl FnOnce() + Send) {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(2 << 20).spawn_scoped(scope, work);
        thread.expect("a thread").join().expect("no panic");
    });
}

/// Holds a case against what was told of it.
fn judge(name: &str, fault: Option<Fault>, wanted: &str) {
    let fault = fault.unwrap_or_else(|| panic!("{name}: nothing is told"));
    assert!(fault.message.starts_with(wanted), "{name}: `{}`, not `{wanted}`", fault.message);
    assert!(fault.line > 0, "{name}: nobody knows where: {fault}");
    assert!(fault.hint.as_deref() != Some(""), "{name}: an empty hint");
}

#[test]
fn rules_are_stopped() {
    on_a_small_stack(|| {
        let host = host();
        for (name, body, wanted) in BODIES {
            judge(name, told(&host, &format!("fn propose(tip, p) {{\n{body}\n}}")), wanted);
            assert!(is_well(&host), "{name} leaves something behind");
        }
        for (name, text, wanted) in RULES {
            judge(name, told(&host, text), wanted);
            assert!(is_well(&host), "{name} leaves something behind");
        }
    });
}

#[test]
fn cities_are_stopped() {
    on_a_small_stack(|| {
        let host = host();
        for (name, text, wanted) in CITIES {
            let source = Source { text: (*text).to_owned(), path: "city.rhai".into() };
            judge(name, host.plan(&source, Arc::new(Folders)).err(), wanted);
            assert!(is_well(&host), "{name} leaves something behind");
        }
    });
}

/// A text so many times.
fn many(count: usize, text: impl Fn(usize) -> String) -> String {
    (0..count).map(text).collect()
}

#[test]
fn huge_scripts_are_stopped() {
    let propose = |body: String| format!("fn propose(tip, p) {{\n{body}\n}}");
    let nested = |open: &str, inner: &str, close: &str, count: usize| {
        propose(format!("{}{inner}{};", open.repeat(count), close.repeat(count)))
    };
    let cases = [
        ("brackets in brackets", nested("(", "1", ")", 2_000), "this expression is too deep or too long"),
        ("lists in lists", nested("[", "1", "]", 2_000), "this expression is too deep or too long"),
        ("maps in maps", nested("#{ a: ", "1", "}", 2_000), "this expression is too deep or too long"),
        ("blocks in blocks", nested("{ ", "1", "}", 2_000), "this expression is too deep or too long"),
        ("loops in loops", nested("for i in 0..2 { ", "print(1)", "}", 100), "this expression is too deep or too long"),
        (
            "branches of branches",
            propose(format!("if tip.is_seed {{ }}{}", " else if tip.is_seed { }".repeat(2_000))),
            "this expression is too deep or too long",
        ),
        ("signs before a number", nested("- ", "1", "", 2_000), "this expression is too deep or too long"),
        ("signs before a truth", nested("!", "true", "", 2_000), "this expression is too deep or too long"),
        (
            "a sum",
            propose(format!("let x = 1{};", " + tip.x".repeat(2_000))),
            "this expression is too deep or too long",
        ),
        (
            "a chain of calls",
            propose(format!("tip{};", ".peak()".repeat(2_000))),
            "this expression is too deep or too long",
        ),
        ("texts in texts", nested("`${", "1", "}`", 2_000), "this expression is too deep or too long"),
        ("closures in closures", nested("|x| ", "1", "", 2_000), "this expression is too deep or too long"),
        (
            "switches in switches",
            nested("switch 1 { _ => ", "1", "}", 2_000),
            "this expression is too deep or too long",
        ),
        ("comments in comments", propose("/*".repeat(2_000)), "expecting '}' to terminate this block"),
        (
            "variables",
            propose(many(1_000, |i| format!("let v{i} = {i};\n")) + "tip.ahead(0);"),
            "too many variables defined",
        ),
        (
            "functions",
            many(1_000, |i| format!("fn f{i}() {{ }}\n")) + "fn propose(tip, p) { tip.ahead(0); }",
            "number of functions defined exceeds maximum limit",
        ),
        ("arguments", propose(format!("f({});", many(1_000, |i| format!("{i}, ")))), "there is no function `f`"),
        (
            "parameters",
            format!("params(#{{ {} }});\nfn propose(tip, p) {{ }}", many(1_000, |i| format!("a{i}: metres(1), "))),
            "number of properties in object map literal exceeds the maximum limit",
        ),
        (
            "a long list",
            propose(format!("let l = [{}];", "1, ".repeat(2_000))),
            "size of array literal exceeds the maximum limit (1000)",
        ),
        (
            "a long map",
            propose(format!("let m = #{{ {} }};", many(1_000, |i| format!("a{i}: 1, ")))),
            "number of properties in object map literal exceeds the maximum limit",
        ),
        (
            "a long text",
            propose(format!("let s = \"{}\";", "x".repeat(50_000))),
            "length of string exceeds the maximum limit (10000)",
        ),
        (
            "two long names",
            propose(format!("let {0} = 1; {0}y + 1;", "x".repeat(20_000))),
            "there is no variable `xxxx",
        ),
        ("a long name", propose(format!("{}();", "x".repeat(50_000))), "there is no function `xxxx"),
        (
            "a long line",
            propose(format!("{}tip.ahead(0);", " ".repeat(1_000_000))),
            "the letters of a line are at most 60000",
        ),
        (
            "many lines",
            propose(format!("{}tip.ahead(0);", "\n".repeat(1_000_000))),
            "the lines of a script are at most 60000",
        ),
        (
            "a long number",
            propose(format!("tip.ahead({});", "9".repeat(2_000))),
            "the length of a street must be a finite number",
        ),
    ];
    on_a_small_stack(|| {
        let host = host();
        for (name, text, wanted) in &cases {
            #[allow(clippy::disallowed_methods)]
            let t0 = std::time::Instant::now();
            let f = told(&host, text);
            println!("TIME {name} {:?} {:?}", t0.elapsed(), f.map(|f| f.message.chars().take(60).collect::<String>()));
            judge(name, told(&host, text), wanted);
            assert!(is_well(&host), "{name} leaves something behind");
        }
    });
}
