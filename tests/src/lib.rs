//! What the suite shares: places to build, and what to ask of them.

use city::{Built, Cancel, City, LoadError, Settings, Silent, Until, build, load};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folder of a city that comes with Plat.
pub fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(name)
}

/// Builds a city with changes to its plan. Panics where there is none: a suite city always builds.
pub fn build_with(folder: &Path, threads: usize, until: Until, change: impl FnOnce(&mut script::Plan)) -> Built {
    let mut loaded = load(folder, None).unwrap_or_else(|error: LoadError| panic!("{error}"));
    change(&mut loaded.plan);
    let sources = loaded.read().unwrap_or_else(|error| panic!("{error}"));
    build(&sources, Settings { threads, until, ..Settings::default() }, &Silent, &Cancel::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The layout of a city as it is written, feature by feature: kind and id, then the line.
pub fn features(city: &City) -> BTreeMap<(String, String), String> {
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(city, &mut bytes).expect("writing to memory does not fail");
    let text = String::from_utf8(bytes).expect("GeoJSON is UTF-8");
    let lines = text.lines().filter(|line| line.contains("\"kind\":"));
    lines
        .map(|line| {
            let feature: serde_json::Value =
                serde_json::from_str(line.trim_end_matches(',')).expect("each feature is one line of JSON");
            let text = |key: &str| feature["properties"][key].as_str().unwrap_or_default().to_owned();
            ((text("kind"), text("id")), line.trim_end_matches(',').to_owned())
        })
        .collect()
}

/// The share of crossings with four streets among those that `counts` admits.
pub fn four_way_share(city: &City, counts: impl Fn(geom::Vec2) -> bool) -> f64 {
    let crossings = streets::runs::crossings(&city.runs);
    let counted: Vec<usize> = crossings
        .iter()
        .filter(|&&node| counts(city.graph.at(node).metres()))
        .map(|&node| city.graph.degree(node))
        .collect();
    counted.iter().filter(|&&degree| degree == 4).count() as f64 / counted.len().max(1) as f64
}
