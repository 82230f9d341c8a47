//! Every place of `suite/`: built, checked, and compared with its snapshot. A new case is a new folder.

use city::{City, Until};
use geom::Id;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use streets::graph::CheckLevel;
use suite::{build_with, features};

fn folders(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

/// What a snapshot holds: counts, every street with its crossings, and a digest of all that is written.
fn summary(city: &City) -> String {
    let mut text = String::new();
    let (streets, blocks) = (city.runs.len(), city.blocks.len());
    let area: f64 = city.parcels.iter().map(|parcel| parcel.polygon.area()).sum();
    let _ = writeln!(text, "{streets} streets, {blocks} blocks, {} quarters", city.quarters.len());
    let _ = writeln!(text, "{} parcels of {area:.1} m2, {} buildings", city.parcels.len(), city.buildings.len());
    let mut lines: Vec<String> = Vec::new();
    for run in &city.runs {
        let points: Vec<String> = run.nodes.iter().map(|&node| city.graph.at(node).metres()).map(place).collect();
        let class = &city.graph.classes().info(run.class).name;
        lines.push(format!("{class} level {} : {}", run.level, points.join(" ")));
    }
    lines.sort();
    let digest =
        features(city).into_values().fold(Id::default(), |digest, line| digest.with(&[Id::of_text("", &line).0]));
    let _ = write!(text, "{}\nlayout {digest}", lines.join("\n"));
    text
}

fn place(at: geom::Vec2) -> String {
    format!("({:.2}, {:.2})", at.x, at.y)
}

#[test]
fn every_place_is_valid_and_as_it_was() {
    let suite = Path::new(env!("CARGO_MANIFEST_DIR")).join("suite");
    let cases: Vec<PathBuf> = folders(&suite).iter().flat_map(|kind| folders(kind)).collect();
    assert!(cases.len() >= 4, "the suite is there");
    for case in cases {
        let built = build_with(&case, 2, Until::Buildings, |_| {});
        assert!(!built.report.has_faults(), "{}: {:?}", case.display(), built.report.faults);
        assert_eq!(built.city.graph.check(CheckLevel::Brute), Vec::new(), "{}", case.display());
        let mut bytes = Vec::new();
        city::export::geojson::write_layout(&built.city, &mut bytes).expect("writing to memory does not fail");
        let layout = city::export::layout_file::parse_layout(&bytes, &case).expect("our own layout is readable");
        let until = if built.city.buildings.is_empty() { Until::Parcels } else { Until::Buildings };
        let report = city::validate::check(&layout, until);
        assert!(report.is_valid(), "{}: {report}", case.display());
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(&case);
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!("layout", summary(&built.city)));
    }
}
