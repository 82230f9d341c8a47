//! The promises of the README on whole cities: the same bytes for any number of threads, identity, lining up.

use city::{City, Until};
use geom::point::units;
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

/// The quarter at a place.
fn quarter_at(city: &City, x: f64, y: f64) -> (Id, Polygon) {
    let place = geom::Point::from_metres(geom::Vec2::new(x, y));
    let quarter = city.quarters.iter().find(|quarter| quarter.polygon.contains(place)).expect("a quarter");
    (quarter.id, quarter.polygon.clone())
}

/// The quarter in the middle of the lattice: 800 m by 800 m, with others all around.
fn middle_quarter(city: &City) -> (Id, Polygon) {
    quarter_at(city, 1210.0, 1230.0)
}

/// How far a node of a rim may lie from the rim's straight sides, in metres: what rounding makes of splits.
const ON_RIM: f64 = 0.01;

/// All that is written of a city, by kind and id.
type Written = BTreeMap<(String, String), String>;

/// What is written of everything outside a closed quarter: not what lies in it or along its rim, nor crossings there.
fn outside(city: &City, written: &Written, quarter: Id, polygon: &Polygon) -> Written {
    let is_on_rim = |node: streets::NodeKey| polygon.distance_to_rim(city.graph.at(node).metres()) <= ON_RIM;
    let is_inside = |node: streets::NodeKey| {
        polygon.locate(city.graph.at(node)) == geom::polygon::Location::Inside && !is_on_rim(node)
    };
    let bounds = polygon.bounds().expect("a quarter has corners").grown(64);
    let is_near = |node: &streets::NodeKey| bounds.contains(city.graph.at(*node));
    let runs =
        city.runs.iter().filter(|run| run.nodes.iter().any(is_near)).filter(|run| {
            run.nodes.iter().any(|&node| is_inside(node)) || run.nodes.iter().all(|&node| is_on_rim(node))
        });
    let nodes = city.graph.nodes_unsorted().map(|(key, _)| key).filter(is_near);
    let nodes = nodes.filter(|&key| is_inside(key) || is_on_rim(key)).map(|key| city.graph.node(key).id.0);
    let blocks: BTreeSet<Id> =
        city.blocks.iter().filter(|block| block.quarter == Some(quarter)).map(|block| block.id).collect();
    let parcels: BTreeSet<Id> =
        city.parcels.iter().filter(|parcel| blocks.contains(&parcel.block)).map(|parcel| parcel.id).collect();
    let buildings = city.buildings.iter().filter(|building| parcels.contains(&building.parcel));
    let all = blocks.iter().copied().chain(parcels.iter().copied()).chain(buildings.map(|building| building.id));
    let inside: BTreeSet<String> = all.chain(runs.map(|run| run.id)).chain(nodes).map(|id| id.to_string()).collect();
    let mut rest = written.clone();
    rest.retain(|(_, id), _| !inside.contains(id));
    rest
}

/// What differs outside a quarter: kind and id of everything that came, went, or is written differently.
fn changed_outside(
    before: (&City, &Written),
    after: (&City, &Written),
    quarter: Id,
    polygon: &Polygon,
) -> Vec<(String, String)> {
    let [before, after] = [before, after].map(|(city, written)| outside(city, written, quarter, polygon));
    assert!(before.len() > 5_000, "there is something outside: {}", before.len());
    let keys: BTreeSet<_> = before.keys().chain(after.keys()).collect();
    keys.into_iter().filter(|key| before.get(*key) != after.get(*key)).cloned().collect()
}

fn assert_same_outside(before: &City, after: &City, quarter: Id, polygon: &Polygon) {
    let written = [before, after].map(features);
    assert_eq!(changed_outside((before, &written[0]), (after, &written[1]), quarter, polygon), []);
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
    for ((x, y), width) in [((1210.0, 1230.0), 160.0), ((500.0, 500.0), 60.0), ((2200.0, 2200.0), 85.0)] {
        let (quarter, polygon) = quarter_at(&before, x, y);
        let set = BTreeMap::from([("minors.pattern.block_width".to_owned(), Literal::Number(width).into())]);
        let after = lattice(|plan| drop(plan.quarters.insert(quarter, QuarterPlan { set, ..Default::default() })));
        let blocks = |city: &City| city.blocks.iter().filter(|block| block.quarter == Some(quarter)).count();
        assert_ne!(blocks(&before), blocks(&after));
        assert_same_outside(&before, &after, quarter, &polygon);
    }
}

#[test]
fn the_width_of_one_quarters_minors_changes_nothing_outside_it() {
    let before = lattice(|_| {});
    let (quarter, polygon) = middle_quarter(&before);
    let own = QuarterPlan { width: Some(8.0), ..Default::default() };
    let after = lattice(|plan| drop(plan.quarters.insert(quarter, own.clone())));
    let widths = |city: &City| -> BTreeSet<i32> {
        let minors = city.runs.iter().filter(|run| run.class == streets::Classes::MINOR);
        minors
            .filter(|run| {
                run.nodes.iter().any(|&node| polygon.locate(city.graph.at(node)) == geom::polygon::Location::Inside)
            })
            .map(|run| run.half_width)
            .collect()
    };
    assert_eq!((widths(&before), widths(&after)), ([units(7.0)].into(), [units(4.0)].into()));
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
fn in_manhattan_the_seed_or_a_parameter_of_a_quarter_changes_nothing_outside_it() {
    let build =
        |change: &dyn Fn(&mut Plan)| (*build_with(&shipped("manhattan"), 2, Until::Buildings, change).city).clone();
    let before = build(&|_| {});
    // As much as the city itself: it is not written anew for each change.
    let written = features(&before);
    let seed = || QuarterPlan { seed: Some(99), ..Default::default() };
    let set = |name: &str, value| QuarterPlan {
        set: BTreeMap::from([(format!("minors.pattern.{name}"), Literal::Number(value).into())]),
        ..Default::default()
    };
    // Quarters of the raster, of the old town, and where the two meet.
    let changes = [
        ((5000.0, 3950.0), seed()),
        ((4950.0, 7500.0), seed()),
        ((4950.0, 7500.0), set("grid.block_width", 95.0)),
        ((5000.0, 3950.0), set("organic.length", 170.0)),
    ];
    for ((x, y), quarter) in changes {
        let (id, polygon) = quarter_at(&before, x, y);
        let after = build(&|plan| drop(plan.quarters.insert(id, quarter.clone())));
        let written_after = features(&after);
        assert!(written != written_after);
        assert_eq!(changed_outside((&before, &written), (&after, &written_after), id, &polygon), []);
    }
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
