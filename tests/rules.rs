//! The tests of the rule library: those that `plat test rules` runs, with insta for their snapshots; and whether they would
//! notice a changed number.

use city::testing::{Ran, Settings, Suite};
use geom::Seed;
use script::{Host, Library, Source};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn rules() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../rules")
}

/// All files with tests of their own.
fn test_files() -> Vec<PathBuf> {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        let mut all: Vec<PathBuf> =
            fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
        all.sort();
        all
    };
    let folders = entries(&rules()).into_iter().filter(|path| path.is_dir());
    folders.flat_map(|folder| entries(&folder)).filter(|path| path.to_string_lossy().ends_with(".test.rhai")).collect()
}

fn told(ran: &Ran) -> String {
    let fault = ran.fault.as_ref().map(ToString::to_string).unwrap_or_default();
    let trial = ran.trial.as_ref().map(|trial| format!(" for the trial \"{trial}\"")).unwrap_or_default();
    format!("{}: {}{trial}\n{fault}", ran.rule, ran.test)
}

#[test]
fn the_tests_of_the_library_pass() {
    let settings = Settings::default();
    let suite = Suite::find(&[rules()], &settings).expect("the library can be read");
    assert!(suite.faults.is_empty(), "{:?}", suite.faults);
    let ran = suite.run(&settings).expect("threads");
    for ran in &ran {
        assert!(ran.fault.is_none(), "{}", told(ran));
        for compared in &ran.snapshots {
            let (folder, name) =
                (compared.path.parent().expect("a folder"), compared.path.file_stem().expect("a name"));
            insta::with_settings!({ snapshot_path => folder, prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!(name.to_string_lossy().into_owned(), compared.snapshot.text);
            });
        }
    }
    assert_eq!(suite.stale(&ran), Vec::<PathBuf>::new(), "no test takes these snapshots");
}

/// The code blocks of the manual with a given head.
fn snippets(head: &str) -> Vec<String> {
    let manual = include_str!("../rules/README.md");
    let blocks = manual.split("```").skip(1).step_by(2);
    blocks.filter_map(|block| block.strip_prefix(&format!("{head}\n")).map(str::to_owned)).collect()
}

/// Runs the tests in a script, whose rules a library knows besides.
fn assert_passes(path: PathBuf, text: String, libraries: Vec<Arc<dyn Library>>) {
    let mut suite = Suite::default();
    suite.add_script(&Host::new(libraries), path, text);
    assert!(suite.faults.is_empty() && !suite.is_empty(), "{:?}", suite.faults);
    for ran in suite.run(&Settings::default()).expect("threads") {
        assert!(ran.has_passed(), "{}", told(&ran));
    }
}

#[test]
fn the_tests_of_the_manual_pass() {
    let of_files = snippets("rhai test");
    assert_eq!(of_files.len(), 2);
    for text in of_files {
        let tested = text.lines().next().and_then(|line| line.strip_prefix("//! Tests of ")).expect("a headline");
        let path = rules().join(format!("{}.test.rhai", tested.trim_end_matches('.')));
        assert_passes(path, text, Vec::new());
    }
    let of_rules: Vec<String> = snippets("rhai").into_iter().filter(|text| text.contains("fn test_")).collect();
    assert_eq!(of_rules.len(), 1);
    for text in of_rules {
        let library: Arc<dyn Library> = Arc::new(Changed { name: "mine".into(), text: text.clone() });
        assert_passes(PathBuf::from("mine.rhai"), text, vec![library]);
    }
}

/// What the examples of a chapter stand in: a rule, and a test that asks it, or a test alone.
fn frame(title: &str, examples: &str) -> (String, String) {
    const SITE: &str = "site(#{ size: [600, 600], density: |x, y| 20 * x, zones: |x, y| 2, parks: |x, y| x > 500, old_town: |x, y| x < 300 })";
    let rule = |function: &str, end: &str| {
        format!("//! Mine.\nparams(#{{ map: map(\"density\") }});\nfn {function} {{ {examples} {end} }}\n")
    };
    let asked = |call: &str| format!("fn test_examples() {{ rule().{call}(#{{ on: {SITE} }}); }}\n");
    let plain = rule("propose(tip, p)", "tip.ahead(80);").replace(examples, "");
    let test = |given: &str| {
        format!(
            "fn test_examples({given}) {{ let site = {SITE}; let town = grow(rule(), #{{ site: site }}); {examples} }}\n"
        )
    };
    match title {
        "`segment`" => (rule("constrain(segment, p)", ""), asked("constrain")),
        "`block`" => (rule("subdivide(block, p)", ""), asked("subdivide")),
        "`parcel`" => (rule("assign(parcel, p)", "") + "fn subdivide(block, p) { block.whole(); }\n", asked("assign")),
        "`shape`" => (rule("build(shape, p)", ""), asked("build")),
        "In every script" | "A parameter" | "`tip`" | "A peak" => {
            (rule("propose(tip, p)", "tip.ahead(80);"), asked("propose"))
        }
        "A trial" => (plain, test("trial")),
        _ => (plain, test("")),
    }
}

/// Examples that need what a test does not have: a place at the top of a file, a colour map in a folder.
const ELSEWHERE: [&str; 3] = ["params", "districts", "library"];

#[test]
fn the_examples_of_the_reference_run() {
    let parcels = "fn subdivide(block, p) { block.whole(); }\nfn assign(parcel, p) { parcel.tag(\"shop\"); }\n";
    for chapter in script::reference::reference() {
        let words =
            chapter.words.iter().filter(|word| !ELSEWHERE.contains(&word.name.as_str()) && word.name != "snapshot");
        let examples: Vec<String> = words.map(|word| format!("{{ {}; }}", word.example)).collect();
        let (rule, tests) = frame(&chapter.title, &examples.join("\n"));
        let mine: Arc<dyn Library> = Arc::new(Changed { name: "streets/mine".into(), text: rule });
        let others: Arc<dyn Library> = Arc::new(Changed { name: "parcels/mine".into(), text: parcels.into() });
        assert_passes(PathBuf::from("streets/mine.test.rhai"), tests, vec![mine, others]);
    }
}

#[test]
fn the_reference_is_what_the_program_knows() {
    for (file, text) in
        [("REFERENCE.md", script::reference::markdown()), ("plat.d.rhai", script::reference::definitions())]
    {
        let shipped = fs::read_to_string(rules().join(file)).unwrap_or_default();
        assert!(shipped == text, "rules/{file} is old: write it anew with `plat words --markdown` or `--definitions`");
    }
}

#[test]
fn every_rule_and_preset_has_tests() {
    let tested: Vec<String> = test_files().iter().map(|path| name_of(path)).collect();
    let host = Host::new(vec![]);
    let all: Vec<String> = host.names().into_iter().chain(host.preset_names()).collect();
    let missing: Vec<&String> = all.iter().filter(|name| !tested.contains(name)).collect();
    assert!(missing.is_empty(), "without tests: {missing:?}");
}

/// `streets/grid` for `…/streets/grid.test.rhai`.
fn name_of(tests: &Path) -> String {
    let below = tests.strip_prefix(rules()).expect("in the library").to_string_lossy().replace('\\', "/");
    below.trim_end_matches(".test.rhai").to_owned()
}

/// A rule with another text; all others are the library's own.
#[derive(Debug)]
struct Changed {
    name: String,
    text: String,
}

impl Library for Changed {
    fn read(&self, name: &str) -> Option<Result<Source, String>> {
        let is_it = name.strip_suffix(".rhai") == Some(&self.name);
        is_it.then(|| Ok(Source { text: self.text.clone(), path: format!("rules/{name}") }))
    }

    fn place(&self) -> String {
        "a changed rule".into()
    }

    fn names(&self) -> Vec<String> {
        vec![format!("{}.rhai", self.name)]
    }
}

/// The numbers of a script: where each stands. Texts and comments have none.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let rest = &text[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if bytes[at] == b'"' {
            at += 2 + rest[1..].find('"').expect("the text ends");
        } else if bytes[at].is_ascii_alphabetic() || bytes[at] == b'_' {
            at += rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        } else if bytes[at].is_ascii_digit() {
            let whole = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            let is_share =
                rest[whole..].strip_prefix('.').is_some_and(|tail| tail.starts_with(|c: char| c.is_ascii_digit()));
            let tail = if is_share { &rest[whole + 1..] } else { "" };
            let length =
                whole + if is_share { 1 + tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len()) } else { 0 };
            found.push(at..at + length);
            at += length;
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    found
}

/// Another number of the same kind: a quarter more, or one more where that is the same.
fn another(number: &str) -> String {
    match number.parse::<u64>() {
        Ok(0) => "1".into(),
        Ok(whole) => (whole + (whole / 4).max(1)).to_string(),
        Err(_) => {
            let value: f64 = number.parse().expect("a number");
            if value == 0.0 { "0.5".into() } else { format!("{:?}", value * 1.25) }
        }
    }
}

/// Whether the tests of a rule notice another text of it, and say in which rule and what.
fn is_noticed(tests: &Path, text: String) -> bool {
    let name = name_of(tests);
    let host = Host::new(vec![Arc::new(Changed { name: name.clone(), text }) as Arc<dyn Library>]);
    let mut suite = Suite::default();
    suite.add_script(&host, tests.to_path_buf(), fs::read_to_string(tests).expect("tests"));
    assert!(suite.faults.is_empty(), "{:?}", suite.faults);
    let ran = suite.run(&Settings { trials: 3, ..Settings::default() }).expect("threads");
    let failed: Vec<&Ran> = ran.iter().filter(|ran| !ran.has_passed()).collect();
    for ran in &failed {
        assert!(ran.rule == name && (ran.fault.is_some() || !ran.snapshots.is_empty()), "{ran:?} says nothing");
    }
    !failed.is_empty()
}

/// `PLAT_MUTANTS=all cargo test -p suite rules` changes every number of every rule; else a few of each are changed.
#[test]
fn a_changed_number_is_noticed() {
    let is_all = std::env::var("PLAT_MUTANTS").is_ok_and(|value| value == "all");
    let only = std::env::var("PLAT_MUTANTS_OF").ok();
    let (mut tried, mut missed) = (0, Vec::new());
    for tests in test_files() {
        let name = name_of(&tests);
        if only.as_ref().is_some_and(|only| *only != name) {
            continue;
        }
        let text = fs::read_to_string(rules().join(format!("{name}.rhai"))).expect("the rule");
        let numbers = numbers(&text);
        let chosen = |n: usize| is_all || Seed(n as u64).purpose(&name).unit(0) < 2.0 / numbers.len() as f64;
        for (n, place) in numbers.iter().enumerate().filter(|(n, _)| chosen(*n)) {
            let changed = format!("{}{}{}", &text[..place.start], another(&text[place.clone()]), &text[place.end..]);
            tried += 1;
            if !is_noticed(&tests, changed) {
                let line = text[..place.start].lines().count();
                missed.push(format!("{name}.rhai:{line}: number {n}, {}", &text[place.clone()]));
            }
        }
    }
    println!("{tried} numbers changed, {} not noticed:\n{}", missed.len(), missed.join("\n"));
    assert!(missed.len() * 20 <= tried, "{tried} numbers changed, not noticed:\n{}", missed.join("\n"));
}
