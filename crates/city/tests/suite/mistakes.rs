//! Mistakes that rule writers make, one in each file of `mistakes/`: what they are told, locked as a snapshot, and whether
//! it is told at the right place. A comment `//   ^` points at it from the line below (`// ^ column 1` where there is no
//! room for it, `// ^ end` for the end of the file); a file without one has a mistake of the whole file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn mistakes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mistakes");
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

/// A small city that asks a rule of that kind.
fn city_around(kind: &str) -> String {
    let minors = |more: &str| {
        let pattern = if more.contains("pattern") { "" } else { "pattern: rule(\"streets/grid\", #{ heading: 0 })," };
        format!("minors: streets(#{{ {pattern} {more} }}),")
    };
    let asked = match kind {
        "streets" => minors("pattern: rule(\"streets/own\")"),
        "goals" => minors("goals: rule(\"goals/own\")"),
        "constraints" => minors("constraints: rule(\"constraints/own\")"),
        "constrain" => minors("constraints: [rule(\"constraints/standard\"), rule(\"constrain/own\")]"),
        "parcels" => minors("") + "parcels: rule(\"parcels/own\"),",
        "buildings" => minors("") + "parcels: rule(\"parcels/recursive\"), buildings: rule(\"buildings/own\"),",
        other => panic!("no kind {other}"),
    };
    format!(
        "city(#{{\n    site: site(#{{ size: [700, 700] }}),\n    given: [line([[100, 100], [600, 100], [600, 600], \
         [100, 600], [100, 100]])],\n    {asked}\n}});\n"
    )
}

/// Lays out a folder with the mistake, and runs `plat` in it.
fn run(file: &Path, arguments: &[&str]) -> (TempDir, Output) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
    let kind = name.split('_').next().expect("a kind");
    let text = fs::read_to_string(file).expect("a script");
    if kind == "city" {
        fs::write(folder.path().join("city.rhai"), text).expect("written");
    } else {
        fs::create_dir(folder.path().join(kind)).expect("made");
        fs::write(folder.path().join(kind).join("own.rhai"), text).expect("written");
        fs::write(folder.path().join("city.rhai"), city_around(kind)).expect("written");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    let output = command.current_dir(folder.path()).args(arguments).output().expect("plat runs");
    (folder, output)
}

/// Where the comment in a mistake points: line and column.
fn pointed_at(text: &str) -> Option<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let at = lines.iter().position(|line| line.starts_with("//") && line.contains('^'))?;
    let caret = lines[at].find('^').expect("a caret");
    if lines[at].ends_with("end") {
        return Some((lines.len() + 1, 1));
    }
    let told = lines[at].split_once("column ").map(|(_, column)| column.trim().parse().expect("a column"));
    // The comment stands below what it is about.
    Some((at, told.unwrap_or(caret + 1)))
}

#[test]
fn what_is_told_is_right_and_helps() {
    let files = mistakes();
    assert!(files.len() >= 40, "{} mistakes", files.len());
    let mut wrong = Vec::new();
    for file in files {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let text = fs::read_to_string(&file).expect("a script");
        let (folder, output) = run(&file, &["build", ".", "-o", "out", "--quiet"]);
        let told = String::from_utf8_lossy(&output.stderr).replace('\\', "/");
        let status = output.status.code().expect("no signal");
        assert!(!told.contains("panicked") && !told.contains("failed inside"), "{name}: {told}");
        if !told.contains("hint: ") {
            wrong.push(format!("{name}: tells no way out"));
        }
        // A fault while it is built never hides the city; one before writes nothing.
        if folder.path().join("out/map.png").is_file() != (status < 2) {
            wrong.push(format!("{name}: status {status}, but a city is there or is not"));
        }
        if told.contains("at (") {
            let map = fs::read_to_string(folder.path().join("out/map.svg")).expect("a map");
            let mark = pointed_at(&text).map_or("own.rhai:".into(), |(line, _)| format!("own.rhai:{line}"));
            assert!(map.contains(&mark), "{name}: no mark on the map");
        }
        // Errors count, warnings where there is none.
        let first = told.find("error: ").map_or(&*told, |at| &told[at..]);
        let place = first.lines().find_map(|line| line.split_once("┌─ ./").map(|(_, place)| place.trim().to_owned()));
        let kind = name.split('_').next().expect("a kind");
        let own = if kind == "city" { "city.rhai".to_owned() } else { format!("{kind}/own.rhai") };
        let wanted = pointed_at(&text).map(|(line, column)| format!("{own}:{line}:{column}"));
        if place != wanted {
            wrong.push(format!("{name}: at {place:?}, not {wanted:?}"));
        }
        insta::with_settings!({ prepend_module_to_snapshot => false, snapshot_path => "snapshots/mistakes", omit_expression => true }, {
            insta::assert_snapshot!(name, format!("status {status}\n\n{told}"));
        });
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
