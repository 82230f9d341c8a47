//! The promises of the README on whole cities: the same bytes for any number of threads, identity, lining up.

use city::{City, Until};
use geom::{Id, Polygon};
use script::{Literal, Plan, QuarterPlan};
use std::collections::{BTreeMap, BTreeSet};
use streets::graph::CheckLevel;
use suite::{build_with, features, four_way_share, shipped};

fn lattice(change: impl FnOnce(&mut Plan)) -> City {
    let built = build_with(&shipped("lattice"), 2, Until::Buildings, change);
    assert!(!built.report.has_faults(), "{:?}", built.report.faults);
    (*built.city).clone()
}

/// Everything that is written of a city, file by file.
fn files(city: &City) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let written =
        city::export::write_all(city, b"{}", folder.path(), &city::Cancel::default()).expect("the city is written");
    let name = |path: &std::path::Path| path.file_name().expect("a name").to_string_lossy().into_owned();
    written.iter().map(|path| (name(path), std::fs::read(path).expect("what was written is there"))).collect()
}

#[test]
fn any_number_of_threads_and_any_repeat_give_the_same_bytes() {
    let build = |threads| (*build_with(&shipped("lattice"), threads, Until::Buildings, |_| {}).city).clone();
    let one = files(&build(1));
    assert_eq!(one.len(), 5);
    for threads in [1, 2, 8] {
        assert!(files(&build(threads)) == one, "{threads} threads give other bytes");
    }
}

#[test]
fn manhattan_grows_alike_on_one_and_eight_threads() {
    let build = |threads| build_with(&shipped("manhattan"), threads, Until::Streets, |_| {}).city;
    let (one, eight) = (build(1), build(8));
    assert_eq!(one.graph.digest(), eight.graph.digest());
    assert!(features(&one) == features(&eight));
    assert_eq!(one.graph.check(CheckLevel::Sweep), Vec::new());
}

#[test]
fn another_seed_gives_another_city() {
    let (one, two) = (lattice(|_| {}), lattice(|plan| plan.seed = 2));
    let ids = |city: &City| city.blocks.iter().map(|block| block.id).collect::<Vec<_>>();
    assert_eq!(ids(&one), ids(&two), "ids do not depend on the seed");
    assert!(features(&one) != features(&two));
}

#[test]
fn ids_are_unique_within_their_kind() {
    for place in ["lattice", "krems", "manhattan", "manhattan_real"] {
        let city = build_with(&shipped(place), 0, Until::Streets, |_| {}).city;
        let unique = |ids: Vec<Id>| ids.len() == ids.iter().collect::<BTreeSet<_>>().len();
        assert!(unique(city.runs.iter().map(|run| run.id).collect()), "{place}: streets");
        assert!(unique(city.blocks.iter().map(|block| block.id).collect()), "{place}: blocks");
        assert!(unique(city.quarters.iter().map(|quarter| quarter.id).collect()), "{place}: quarters");
        assert!(unique(city.graph.nodes_unsorted().map(|(_, node)| node.id.0).collect()), "{place}: crossings");
        assert_eq!(city.graph.check(CheckLevel::Sweep), Vec::new(), "{place}");
    }
}

/// The quarter in the middle of the lattice: 800 m by 800 m, with others all around.
fn middle_quarter(city: &City) -> (Id, Polygon) {
    let middle = geom::Point::from_metres(geom::Vec2::new(1210.0, 1230.0));
    let quarter = city.quarters.iter().find(|quarter| quarter.polygon.contains(middle)).expect("a quarter");
    (quarter.id, quarter.polygon.clone())
}

/// Asserts that whatever does not touch a quarter is the same in both cities, byte for byte, and that blocks, parcels
/// and buildings on the other side of its rim are, too.
fn assert_same_outside(before: &City, after: &City, quarter: Id, polygon: &Polygon) {
    let inside = |city: &City| -> BTreeSet<String> {
        let blocks = city.blocks.iter().filter(|block| block.quarter == Some(quarter)).map(|block| block.id);
        let blocks: BTreeSet<Id> = blocks.collect();
        let parcels: BTreeSet<Id> =
            city.parcels.iter().filter(|parcel| blocks.contains(&parcel.block)).map(|parcel| parcel.id).collect();
        let buildings = city.buildings.iter().filter(|building| parcels.contains(&building.parcel));
        let touches = |nodes: &[streets::NodeKey]| {
            nodes.iter().any(|&node| polygon.locate(city.graph.at(node)) != geom::polygon::Location::Outside)
        };
        let runs = city.runs.iter().filter(|run| touches(&run.nodes)).map(|run| run.id);
        let nodes = city.graph.nodes_unsorted().filter(|(key, _)| touches(&[*key])).map(|(_, node)| node.id.0);
        let all = blocks.iter().copied().chain(parcels.iter().copied()).chain(buildings.map(|b| b.id));
        all.chain(runs).chain(nodes).map(|id| id.to_string()).collect()
    };
    let rest = |city: &City| {
        let inside = inside(city);
        let mut all = features(city);
        all.retain(|(_, id), _| !inside.contains(id));
        all
    };
    let (before, after) = (rest(before), rest(after));
    assert!(before.len() > 5_000, "there is something outside: {}", before.len());
    for (key, line) in &before {
        assert_eq!(after.get(key), Some(line), "{key:?}");
    }
    assert_eq!(before.len(), after.len());
}

#[test]
fn deleting_a_minor_changes_nothing_outside_its_quarter() {
    let before = lattice(|_| {});
    let (quarter, polygon) = middle_quarter(&before);
    let street = before.runs.iter().find(|run| {
        let middle = before.graph.at(run.nodes[0]);
        run.class == streets::Classes::MINOR && polygon.locate(middle) == geom::polygon::Location::Inside
    });
    let street = street.expect("a minor in the quarter").street;
    let after = lattice(|plan| plan.removed.push(street));
    assert!(after.runs.iter().all(|run| run.street != street));
    assert_same_outside(&before, &after, quarter, &polygon);
}

#[test]
fn a_parameter_of_one_quarter_changes_nothing_outside_it() {
    let before = lattice(|_| {});
    let (quarter, polygon) = middle_quarter(&before);
    let set = BTreeMap::from([("minors.pattern.block_width".to_owned(), Literal::Number(160.0).into())]);
    let after = lattice(|plan| drop(plan.quarters.insert(quarter, QuarterPlan { seed: None, set })));
    let blocks = |city: &City| city.blocks.iter().filter(|block| block.quarter == Some(quarter)).count();
    assert_ne!(blocks(&before), blocks(&after));
    assert_same_outside(&before, &after, quarter, &polygon);
}

#[test]
fn the_seed_of_one_quarter_changes_nothing_outside_it() {
    let before = lattice(|_| {});
    let (quarter, polygon) = middle_quarter(&before);
    let after =
        lattice(|plan| drop(plan.quarters.insert(quarter, QuarterPlan { seed: Some(99), ..Default::default() })));
    let parcels = |city: &City| {
        let blocks: BTreeSet<Id> =
            city.blocks.iter().filter(|block| block.quarter == Some(quarter)).map(|block| block.id).collect();
        city.parcels.iter().filter(|parcel| blocks.contains(&parcel.block)).cloned().collect::<Vec<_>>()
    };
    assert_ne!(parcels(&before), parcels(&after), "the seed of a quarter reaches its parcels");
    assert_same_outside(&before, &after, quarter, &polygon);
}

#[test]
fn minors_of_neighbouring_quarters_line_up() {
    let city = lattice(|_| {});
    // All but the outermost majors, where minors of the outside need not go on.
    let inner = |place: geom::Vec2| {
        let within = |c: f64| c > 210.0 && c < 2790.0;
        within(place.x) && within(place.y)
    };
    let share = four_way_share(&city, inner);
    assert!(share >= 0.95, "share of 4-way crossings {share}");
}
