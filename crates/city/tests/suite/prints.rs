//! What rules print stands in the report, and on the terminal unless that is to be quiet.

use serde_json::Value;
use std::fs;
use std::process::Command;

const CITY: &str = r#"
    city(#{ site: site(#{ size: [400, 400] }), parcels: rule("mine"),
            minors: streets(#{ pattern: rule("streets/grid", #{ block_length: 200, block_width: 200 }) }) });
"#;

/// A closure that is never called says nothing and does nothing.
const RULE: &str = r#"
    fn subdivide(block, p) {
        let never = |block| { print("never"); block.whole(); };
        if block.area < 1 { never.call(block); }
        print("asked");
        block.recursive(#{ least_area: 500 });
    }
"#;

#[test]
fn what_rules_print_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("town")).expect("a folder");
    fs::write(path("town/city.rhai"), CITY).expect("a file");
    fs::write(path("town/mine.rhai"), RULE).expect("a file");
    let build = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
        let output = command.arg("build").arg(path("town")).arg("-o").arg(path("out")).args(more).output();
        let output = output.expect("plat runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let told = build(&[]);
    let report = fs::read_to_string(path("out/report.json")).expect("a report");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    let [print] = &report["prints"].as_array().expect("prints")[..] else { panic!("{report}") };
    assert!(print["rule"].as_str().is_some_and(|rule| rule.ends_with("mine.rhai")), "{print}");
    assert_eq!(print["text"], "asked");
    // It is told where, so that one can ask what was decided there.
    let [x, y] = [0, 1].map(|i| print["place"][i].as_f64().expect("a place"));
    let mut why = Command::new(env!("CARGO_BIN_EXE_plat"));
    let why = why.arg("why").arg(path("out/layout.geojson")).arg(format!("{x},{y}")).output().expect("plat runs");
    assert!(String::from_utf8_lossy(&why.stdout).contains("line 5    print: asked"), "{why:?}");
    // A block that is all street is not asked.
    let (asked, blocks) = (print["count"].as_u64(), report["counts"]["blocks"].as_u64());
    assert!(asked > Some(1) && asked <= blocks, "{report}");
    assert!(report["counts"]["parcels"].as_u64() > report["counts"]["blocks"].as_u64(), "blocks are divided: {report}");
    assert!(
        told.contains(&format!("mine.rhai: asked ({} times, first at ({x:.1}, {y:.1}))", asked.unwrap_or(0)))
            && !told.contains("never"),
        "{told}"
    );
    assert!(!build(&["--quiet"]).contains("asked"));
}
