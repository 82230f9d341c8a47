//! The kernel knows no pattern and no city: everything particular is in rules and city scripts.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Words that a city happens to share with geometry.
const SHARED: [(&str, &str); 1] = [("lattice", "the lattice that points lie on")];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Names of files or folders in a folder, without endings.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    entries.flatten().filter_map(|entry| Some(entry.path().file_stem()?.to_str()?.to_lowercase())).collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())).flatten() {
        let path = entry.path();
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "tests") {
                sources(&path, found);
            }
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file: comments and its tests left out.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("source text");
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Lower-case words: `TwoRivers`, `two_rivers` and "two rivers" are all `two rivers`.
fn words(code: &str) -> String {
    let mut words = String::from(" ");
    let mut was_lower = false;
    for letter in code.chars() {
        if letter.is_uppercase() && was_lower {
            words.push(' ');
        }
        was_lower = letter.is_lowercase();
        words.extend(if letter.is_alphanumeric() { letter.to_lowercase().collect::<Vec<_>>() } else { vec![' '] });
    }
    words.push(' ');
    words
}

/// The particular names that some code uses.
fn used<'a>(code: &str, particular: &'a BTreeSet<String>) -> Vec<&'a str> {
    let words = words(code);
    let is_used = |name: &&String| words.contains(&format!(" {} ", name.replace('_', " ")));
    particular.iter().filter(is_used).map(String::as_str).collect()
}

#[test]
fn the_kernel_names_no_pattern_and_no_city() {
    let mut particular = names(&root().join("rules/streets"));
    particular.extend(names(&root().join("scripts")));
    assert!(particular.contains("grid") && particular.contains("manhattan"), "{particular:?}");
    particular.retain(|name| !SHARED.iter().any(|(shared, _)| shared == name));
    let mut files = Vec::new();
    sources(&root().join("crates/streets/src/growth"), &mut files);
    assert!(files.len() > 10);
    for file in files {
        let found = used(&code(&file), &particular);
        assert!(found.is_empty(), "{} names {found:?}", file.display());
    }
}

#[test]
fn names_are_found_however_they_are_written() {
    let particular: BTreeSet<String> = ["grid", "two_rivers"].map(String::from).into();
    assert_eq!(used("fn is_grid() {}", &particular), ["grid"]);
    assert_eq!(used("enum Pattern { TwoRivers, Gridlock }", &particular), ["two_rivers"]);
    assert_eq!(used("match name { \"two rivers\" => 1 }", &particular), ["two_rivers"]);
}
