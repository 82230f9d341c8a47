//! Wishes for so many crossings per km², from the rule's parameter to the finished streets.

use crate::common::build::{faultless, try_build};
use city::Until;
use geom::Vec2;
use std::fs;
use streets::runs::crossings;

/// Crossings of more than two streets per km² inside a square of majors.
fn per_km2(rule: &str, options: &str) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let script = format!(
        "city(#{{
            site: site(#{{ size: [2200, 2200] }}),
            given: [line([[200, 200], [2000, 200], [2000, 2000], [200, 2000], [200, 200]])],
            minors: streets(#{{ pattern: rule(\"streets/{rule}\", #{{ {options} }}) }}),
        }});"
    );
    fs::write(folder.path().join("city.rhai"), script).expect("a script");
    let city = faultless(try_build(folder.path(), Until::Streets)).city;
    let (low, high) = (Vec2::splat(230.0), Vec2::splat(1970.0));
    let is_inside = |at: Vec2| at.cmpgt(low).all() && at.cmplt(high).all();
    let found = crossings(&city.runs);
    let counted = found.iter().filter(|&&node| city.graph.degree(node) > 2 && is_inside(city.graph.at(node).metres()));
    counted.count() as f64 / ((high.x - low.x) * (high.y - low.y) / 1e6)
}

#[test]
fn as_many_crossings_grow_as_are_wished_for() {
    for (rule, share) in
        [("grid", 0.05), ("quarter_grid", 0.15), ("loose_grid", 0.15), ("organic", 0.35), ("radial", 0.2)]
    {
        let mut before = 0.0;
        for wish in [60.0, 120.0, 240.0] {
            let found = per_km2(rule, &format!("crossings: {wish}"));
            assert!((found / wish - 1.0).abs() <= share, "{rule}: {found} per km² for {wish}");
            assert!(found > before, "{rule}: {found} after {before}");
            before = found;
        }
    }
}

#[test]
fn a_wish_keeps_the_proportions_of_blocks_and_none_keeps_their_size() {
    let (long, square) = ("block_length: 300, block_width: 75", "block_length: 150, block_width: 150");
    let [by_length, by_square] = [long, square].map(|sides| per_km2("grid", &format!("heading: 0, {sides}")));
    assert!((by_length / by_square - 1.0).abs() < 0.15, "{by_length} {by_square}");
    let wished = per_km2("grid", &format!("heading: 0, {long}, crossings: {}", 1e6 / (300.0 * 75.0)));
    assert!((wished - by_length).abs() < 1e-9, "the blocks are of the size that is wished for already");
}
