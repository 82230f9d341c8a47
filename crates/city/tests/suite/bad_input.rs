//! What `plat` does with bad input: a message that names the place, the promised exit status, no panic, no file.

use image::{GrayImage, Luma};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A city folder of its own, and where it is built to.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new(script: &str) -> Self {
        let place = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        place.write("city.rhai", script.as_bytes());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &[u8]) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, content).expect("a file");
    }

    /// A mask of one grey with a sidecar.
    fn map(&self, name: &str, side: u32, grey: u8, sidecar: &str) {
        let path = self.path(&format!("maps/{name}.png"));
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        GrayImage::from_pixel(side, side, Luma([grey])).save(&path).expect("a picture");
        self.write(&format!("maps/{name}.json"), sidecar.as_bytes());
    }

    fn plat(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
        command.arg("build").arg(self.folder.path()).arg("-o").arg(self.path("out")).arg("--quiet");
        command.args(arguments).output().expect("plat runs")
    }

    /// Builds; asserts the status, that the message says all of `words`, and that nothing is written unless it is 0 or 1.
    fn expect(&self, status: i32, words: &[&str]) {
        let output = self.plat(&[]);
        check(&output, status, words);
        let written = fs::read_dir(self.path("out")).map_or(0, |entries| entries.count());
        assert_eq!(written > 0, status <= 1, "{written} files after status {status}");
        assert_eq!(self.path("out").exists(), status <= 1, "a folder after status {status}");
    }
}

fn check(output: &Output, status: i32, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is missing from: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

const MASK: &str = r#"{ "size_m": [1000, 1000], "value": { "scale": 1, "offset": 0, "units": "mask" } }"#;

/// A city of minors around a given cross of majors, on the maps of its folder.
const MAPPED: &str = r#"
    let site = site("maps");
    city(#{ site: site, given: [line([[0, 500], [1000, 500]]), line([[500, 0], [500, 1000]])],
            minors: streets(#{ pattern: rule("streets/grid") }), parcels: rule("parcels/recursive") });
"#;

/// A flat city whose minors follow the rule beside it.
const OWN_RULE: &str = r#"
    city(#{ site: site(#{ size: [1000, 1000] }),
            given: [line([[100, 100], [900, 100]]), line([[900, 100], [900, 900]]),
                    line([[900, 900], [100, 900]]), line([[100, 900], [100, 100]])],
            minors: streets(#{ pattern: rule("streets/own") }) });
"#;

fn with_rule(body: &str) -> Place {
    let place = Place::new(OWN_RULE);
    place.write("streets/own.rhai", format!("//! A rule.\n\nfn propose(tip, p) {{\n    {body}\n}}\n").as_bytes());
    place
}

#[test]
fn no_city_there() {
    let output = Command::new(env!("CARGO_BIN_EXE_plat")).args(["build", "no/such/city"]).output().expect("plat runs");
    check(&output, 2, &["no/such/city", "hint"]);
}

#[test]
fn a_missing_map_folder_and_a_missing_map() {
    Place::new(MAPPED).expect(3, &["maps", "city.rhai:2"]);
    let place = Place::new(r#"let s = site("maps"); city(#{ site: s, within: s.map("borugh") });"#);
    place.map("borough", 10, 255, MASK);
    place.expect(3, &["borugh", "did you mean `borough`"]);
}

#[test]
fn a_map_with_other_bounds() {
    let place = Place::new(MAPPED);
    place.map("land", 10, 255, MASK);
    place.map("density", 10, 255, &MASK.replace("[1000, 1000]", "[2000, 2000]"));
    place.expect(3, &["land.png", "density.png", "2000", "hint"]);
}

#[test]
fn a_sidecar_with_nan_or_zero_scale() {
    for wrong in ["\"scale\": NaN", "\"scale\": 0", "\"scale\": 1e999", "\"scale\": 1e-300", "\"scale\": \"one\""] {
        let place = Place::new(MAPPED);
        place.map("land", 10, 255, MASK);
        let numbers = MASK.replace("\"mask\"", "\"people/km2\"");
        place.map("density", 10, 255, &numbers.replace("\"scale\": 1", wrong));
        place.expect(3, &["density.json", "hint"]);
    }
    let place = Place::new(MAPPED);
    place.map("land", 10, 255, &MASK.replace("[1000, 1000]", "[0, 1000]"));
    place.expect(3, &["land.json", "hint"]);
}

#[test]
fn a_picture_cut_short() {
    let place = Place::new(MAPPED);
    place.map("land", 100, 255, MASK);
    let whole = fs::read(place.path("maps/land.png")).expect("the picture");
    place.write("maps/land.png", &whole[..whole.len() / 2]);
    place.expect(3, &["land.png", "hint"]);
}

#[test]
fn a_map_of_one_pixel_is_a_map() {
    let place = Place::new(MAPPED);
    place.map("land", 1, 255, MASK);
    place.expect(0, &[]);
}

#[test]
fn a_site_of_water() {
    let majors = "majors: streets(#{ pattern: rule(\"streets/grid\") })";
    let place = Place::new(&format!("city(#{{ site: site(\"maps\"), {majors} }});"));
    place.map("land", 10, 0, MASK);
    place.expect(3, &["no land", "hint"]);
}

#[test]
fn rules_that_never_end_or_want_too_much() {
    for (body, word) in [
        ("loop { }", "endless loop"),
        ("propose(tip, p)", "nested too deeply"),
        ("let a = []; a.pad(100000000, 0);", "list"),
        ("let t = \"x\"; loop { t += t; }", "text"),
    ] {
        with_rule(body).expect(1, &["own.rhai:4:", word, "hint"]);
    }
}

#[test]
fn a_rule_that_fails_before_anything_grows_is_named() {
    let place = Place::new(
        "city(#{ site: site(#{ size: [1000, 1000] }), minors: streets(#{ pattern: rule(\"streets/own\") }) });",
    );
    place.write("streets/own.rhai", b"fn propose(tip, p) {\n    loop { }\n}\n");
    place.expect(3, &["own.rhai:2:", "endless loop", "nothing to build"]);
    // Each fault with its line, its calls and its place, for people and for programs.
    let rule = b"fn helper(tip) {\n    tip.branch_left(\"80\");\n}\nfn propose(tip, p) {\n    helper(tip);\n}\n";
    place.write("streets/own.rhai", rule);
    place.expect(
        3,
        &[
            "own.rhai:2:",
            "tip.branch_left(\"80\")",
            "^^^^",
            "`helper` is called here",
            "nothing to build",
            "nothing was written",
        ],
    );
    let told = place.plat(&["--json"]);
    let error: serde_json::Value = serde_json::from_slice(&told.stdout).expect("one JSON value");
    let faults = error["error"]["faults"].as_array().expect("faults");
    let first = &faults[0];
    assert_eq!((first["line"].as_u64(), faults.len()), (Some(2), 2), "{error}");
    assert!(
        first["count"].as_u64() > Some(1) && first["calls"].as_array().is_some_and(|calls| !calls.is_empty()),
        "{first}"
    );
}

#[test]
fn a_rule_that_rests_in_some_quarters_is_not_said_to_propose_nothing() {
    let script = r#"
        city(#{
            site: site(#{ size: [1000, 1000], zones: |x, y| if x < 500 { 1 } else { 0 } }),
            given: [line([[10, 10], [990, 10], [990, 990], [10, 990], [10, 10]]), line([[500, 10], [500, 990]])],
            minors: streets(#{ pattern: rule("streets/own") }),
        });
    "#;
    let rule = "fn propose(tip, p) {\n    if tip.map(\"zones\") > LEAST {\n        tip.ahead(60);\n        tip.branch_left(60);\n        \
                tip.branch_right(60);\n    }\n}\n";
    for (least, is_told) in [("0.5", false), ("5", true)] {
        let place = Place::new(script);
        place.write("streets/own.rhai", rule.replace("LEAST", least).as_bytes());
        let output = place.plat(&[]);
        let told = String::from_utf8_lossy(&output.stderr);
        let is_warned = told.contains("this rule proposes nothing, anywhere");
        assert_eq!((output.status.code(), is_warned), (Some(0), is_told), "{told}");
    }
}

#[test]
fn a_script_that_is_no_text_and_one_with_a_byte_order_mark() {
    let place = Place::new("");
    place.write("city.rhai", &[0xff, 0xfe, 0x00, 0x80]);
    place.expect(3, &["city.rhai", "UTF-8"]);
    let place = Place::new("");
    place.write("city.rhai", b"\xef\xbb\xbfcity(#{ site: 7 });");
    place.expect(3, &["city.rhai:1:", "site"]);
}

#[test]
fn scripts_that_never_end() {
    Place::new("\nloop { }").expect(3, &["city.rhai:2:", "endless loop"]);
    Place::new("fn f(n) { f(n + 1) }\nf(1);").expect(3, &["city.rhai:", "nested too deeply"]);
}

#[test]
fn unknown_names_and_wrong_types() {
    with_rule("tip.ahed(100)").expect(3, &["own.rhai:4:", "ahead"]);
    with_rule("tip.ahead(lenght)").expect(3, &["own.rhai:4:", "lenght"]);
    with_rule("tip.ahead(\"far\")").expect(1, &["own.rhai:4:"]);
    with_rule("tip.ahead(-5)").expect(1, &["own.rhai:4:", "-5"]);
    Place::new("city(#{ site: site(#{ size: [10, 10] }), minros: 3 });").expect(3, &["city.rhai:1:", "minors"]);
    Place::new("city(#{ site: 7 });").expect(3, &["city.rhai:1:", "site"]);
    Place::new("let a = 1").expect(3, &["city.rhai", "without a city"]);
    Place::new("city(#{ site: site(#{ size: [10, 10] })").expect(3, &["city.rhai:1:"]);
}

#[test]
fn parameters_that_do_not_exist_or_suit() {
    let place = with_rule("tip.ahead(100)");
    check(&place.plat(&["--set", "minors.patern.x=1"]), 2, &["minors.patern.x"]);
    check(&place.plat(&["--set", "nonsense"]), 2, &["nonsense"]);
    check(&place.plat(&["--threads", "many"]), 2, &["many"]);
    check(&place.plat(&["--until", "noon"]), 2, &["noon"]);
}

#[test]
fn an_output_folder_that_cannot_be_written() {
    let place = with_rule("tip.ahead(100)");
    place.write("file", b"in the way");
    let output = Command::new(env!("CARGO_BIN_EXE_plat"))
        .arg("build")
        .arg(place.folder.path())
        .arg("-o")
        .arg(place.path("file/out"))
        .output()
        .expect("plat runs");
    check(&output, 3, &["file/out"]);
}

const LOOP: &str = r#"{"type": "FeatureCollection", "plat": {"units": "m"}, "features": [
    {"type": "Feature", "properties": {"class": "major"}, "geometry": {"type": "LineString",
     "coordinates": [[0, 0], [400, 400], [400, 0], [0, 400], [0, 0]]}}]}"#;

#[test]
fn an_import_that_crosses_itself_becomes_a_valid_city() {
    let place = Place::new(
        "city(#{ site: site(#{ size: [500, 500] }), imported: streets_from(\"loop.geojson\"), parcels: rule(\"parcels/recursive\") });",
    );
    place.write("loop.geojson", LOOP.as_bytes());
    place.expect(0, &[]);
    let layout = place.path("out/layout.geojson");
    let arguments = [Path::new("validate"), &layout, Path::new("--until"), Path::new("parcels")];
    let output = Command::new(env!("CARGO_BIN_EXE_plat")).args(arguments).output().expect("plat runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn street_files_that_are_broken() {
    let script = "city(#{ imported: streets_from(\"streets.osm.pbf\") });";
    let krems = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/krems/krems.osm.pbf");
    let whole = fs::read(krems).expect("the extract");
    for length in [0, 10, 1000, whole.len() / 2, whole.len() - 7] {
        let place = Place::new(script);
        place.write("streets.osm.pbf", &whole[..length]);
        let output = place.plat(&[]);
        assert_eq!(output.status.code(), Some(3), "{length} bytes: {}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8_lossy(&output.stderr).contains("streets.osm.pbf"));
    }
    Place::new(script).expect(3, &["streets.osm.pbf", "hint"]);
    let place = Place::new("city(#{ imported: streets_from(\"streets.geojson\") });");
    place.write("streets.geojson", &LOOP.as_bytes()[..150]);
    place.expect(3, &["streets.geojson", "hint"]);
}

#[test]
fn validate_says_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plat = |name: &str| {
        Command::new(env!("CARGO_BIN_EXE_plat"))
            .arg("validate")
            .arg(folder.path().join(name))
            .output()
            .expect("plat runs")
    };
    check(&plat("missing.geojson"), 3, &["missing.geojson"]);
    fs::write(folder.path().join("broken.geojson"), "{ \"type\": ").expect("a file");
    check(&plat("broken.geojson"), 3, &["broken.geojson"]);
}

#[test]
fn sidecars_are_told_in_the_words_of_the_file() {
    for (sidecar, words) in [
        ("7", &["land.json", "is the number 7, not a JSON object"][..]),
        ("{\n \"pixel_size_m\": \"ten\"}", &["land.json:2:2", "`pixel_size_m` must be a number, not the text \"ten\""]),
        (r#"{"size_m": [1]}"#, &["`size_m` must be two numbers, [width, height]"]),
        (r#"{"size_m": [1, 1], "value": {"scale": "a"}}"#, &["`value.scale` must be a number"]),
        (r#"{"size_m": [1, 1], "bounds_crs_m": {"minx": 1}}"#, &["`bounds_crs_m` lacks `miny`"]),
    ] {
        let place = Place::new(MAPPED);
        place.map("land", 10, 255, sidecar);
        let message = String::from_utf8_lossy(&place.plat(&[]).stderr).into_owned();
        assert!(!message.contains("struct") && !message.contains("f64"), "{message}");
        place.expect(3, words);
    }
}

#[test]
fn sites_beyond_any_memory_are_refused_before_they_are_built() {
    let city = |side: u32| {
        format!(
            "city(#{{ site: site(#{{ size: [{side}, {side}] }}), minors: streets(#{{ pattern: rule(\"streets/grid\") }}) }});"
        )
    };
    Place::new(&city(400_000)).expect(3, &["160000 km²", "metres", "within"]);
    // Large land on which nothing grows costs nothing.
    let given = "city(#{ site: site(#{ size: [400000, 400000] }), given: [line([[0, 0], [900, 0]])] });";
    Place::new(given).expect(0, &[]);
}

#[test]
fn streets_in_metres_may_be_said_in_the_script() {
    let streets = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},
        "geometry":{"type":"LineString","coordinates":[[100,100],[900,150]]}}]}"#;
    let city = |options: &str| {
        let place = Place::new(&format!(
            "city(#{{ site: site(#{{ size: [1000, 1000] }}), imported: streets_from(\"x.geojson\"{options}) }});"
        ));
        place.write("x.geojson", streets.as_bytes());
        place
    };
    let place = city(", #{ units: \"m\" }");
    place.expect(0, &[]);
    let layout = fs::read_to_string(place.path("out/layout.geojson")).expect("a layout");
    assert!(layout.contains("[[100,100],[900,150]]"), "{layout}");
    city("").expect(3, &["not longitude and latitude", "units"]);
    city(", #{ units: \"degrees\" }").expect(3, &["not longitude and latitude"]);
    city(", #{ units: \"feet\" }").expect(3, &["must be \"m\" or \"degrees\", not \"feet\""]);
    let osm = "city(#{ site: site(#{ size: [9, 9] }), imported: streets_from(\"x.osm\", #{ units: \"m\" }) });";
    Place::new(osm).expect(3, &["`units` is for .geojson files"]);
}

#[test]
fn what_a_terminal_would_hide_is_spelt_out() {
    for text in ["city(#{ site: \0 7 });", "let a = \u{1b}[31m;"] {
        let output = Place::new(text).plat(&[]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        check(&output, 3, &["U+00", "UTF-8"]);
        assert!(!message.contains(|letter: char| letter.is_control() && letter != '\n'), "{message:?}");
    }
}

#[test]
fn functions_with_other_arguments_are_told_by_line() {
    let place = Place::new(OWN_RULE);
    place.write("streets/own.rhai", b"//! A rule.\n\nfn propose(tip) {\n    tip.ahead(30);\n}\n");
    place.expect(
        3,
        &["own.rhai:3:4", "`fn propose` has 1 argument, but is called with 2", "write `fn propose(tip, p)`"],
    );
    place.write("streets/own.rhai", b"params(7);\nfn propose(tip, p) {\n    tip.ahead(30);\n}\n");
    place.expect(3, &["own.rhai:1:1", "params(#{ name: parameter"]);
}

#[test]
fn numbers_below_zero_are_no_options() {
    for (option, words) in [("--seed", "a seed is a whole number from 0"), ("--threads", "not in 0..=1024")] {
        let output = Place::new(OWN_RULE).plat(&[option, "-5"]);
        check(&output, 2, &[words]);
        assert!(!String::from_utf8_lossy(&output.stderr).contains("-- -5"));
    }
}
