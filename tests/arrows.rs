//! The crate arrows of crates/README.md, held against `cargo metadata`.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Each crate with the crates of ours that it may name.
const ARROWS: [(&str, &[&str]); 8] = [
    ("geom", &[]),
    ("streets", &["geom"]),
    ("layout", &["geom", "streets"]),
    ("buildings", &["geom"]),
    ("script", &["geom", "streets", "layout", "buildings"]),
    ("city", &["geom", "streets", "layout", "buildings", "script"]),
    ("viewer", &["geom", "streets", "layout", "buildings", "script", "city"]),
    ("suite", &["geom", "streets", "layout", "buildings", "script", "city"]),
];

/// Crates of others that only one crate of ours may name: rules are run in `script`, files and threads are `city`'s.
const RESERVED: [(&str, &[&str]); 5] = [
    ("rhai", &["script"]),
    ("rayon", &["city", "viewer"]),
    ("image", &["city", "viewer"]),
    ("osmpbf", &["city"]),
    ("tempfile", &["city", "suite"]),
];

fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let names = |package: &serde_json::Value| {
        let all = package["dependencies"].as_array().expect("a list of dependencies").iter();
        all.filter(|d| d["kind"].as_str() != Some("dev")).filter_map(|d| Some(d["name"].as_str()?.to_owned())).collect()
    };
    let packages = metadata["packages"].as_array().expect("a list of packages");
    packages.iter().map(|p| (p["name"].as_str().expect("a name").to_owned(), names(p))).collect()
}

#[test]
fn crates_name_only_what_lies_below_them() {
    let dependencies = dependencies();
    let ours: BTreeSet<&str> = ARROWS.iter().map(|(name, _)| *name).collect();
    assert_eq!(dependencies.keys().map(String::as_str).collect::<BTreeSet<_>>(), ours, "an unknown crate");
    for (name, allowed) in ARROWS {
        for dependency in dependencies[name].iter().filter(|d| ours.contains(d.as_str())) {
            assert!(allowed.contains(&dependency.as_str()), "{name} may not name {dependency}");
        }
    }
}

#[test]
fn reserved_crates_stay_in_their_rooms() {
    let dependencies = dependencies();
    for (reserved, rooms) in RESERVED {
        for (name, _) in dependencies.iter().filter(|(_, all)| all.contains(reserved)) {
            assert!(rooms.contains(&name.as_str()), "{name} may not name {reserved}");
        }
    }
}
