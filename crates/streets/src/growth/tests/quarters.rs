//! Quarters: filled from their rims, independent of each other, lined up by the merge.

use super::support::{
    Rule, assert_planar, at, grid, least_angle, minors, never, quarter_at, shared, site, street, winding,
};
use crate::faces::{Face, FaceKind, Faces};
use crate::growth::{
    Chain, Constraints, Fields, Growth, GrowthRules, QuarterGrowth, QuarterSettings, Stopped, Tip, attach, grow,
    grow_quarter,
};
use crate::{Classes, StreetGraph};
use geom::polygon::Location;
use geom::{Angle, Point, Raster, Vec2, predicates};
use proptest::prelude::*;
use std::sync::Arc;

/// Two quarters side by side: 600 × 800 m each, their common rim at x = 600 + `slant` · y / 800.
fn two_quarters(slant: f64) -> (StreetGraph, [Face; 2]) {
    let (a, b, c) = (at(0.0, 0.0), at(600.0, 0.0), at(1200.0, 0.0));
    let (d, e, f) = (at(1200.0, 800.0), at(600.0 + slant, 800.0), at(0.0, 800.0));
    let sides = [(1, a, b), (2, b, c), (3, c, d), (4, d, e), (5, e, f), (6, f, a), (7, b, e)];
    let mut graph = StreetGraph::new(Classes::default());
    for (name, from, to) in sides {
        street(&mut graph, Classes::MAJOR, name, from, to);
    }
    let west = quarter_at(&graph, at(250.0, 400.0));
    let east = quarter_at(&graph, at(950.0, 400.0));
    (graph, [west, east])
}

fn settings() -> QuarterSettings {
    QuarterSettings::new(minors())
}

fn fill(graph: &StreetGraph, face: &Face, rules: &dyn GrowthRules) -> QuarterGrowth {
    fill_in(graph, face, rules, site(3000.0))
}

fn fill_in(graph: &StreetGraph, face: &Face, rules: &dyn GrowthRules, fields: Fields) -> QuarterGrowth {
    let growth = grow_quarter(graph, face, &settings(), rules, &shared(fields), &never);
    assert_eq!((growth.fault, growth.log.stopped), (None, None));
    growth
}

#[test]
fn a_raster_quarter_is_a_full_grid() {
    let (mut graph, [west, _]) = two_quarters(0.0);
    let growth = fill(&graph, &west, &grid(Angle::ZERO, 100.0, 200.0));
    let log = attach(&mut graph, &[growth], &never);
    assert_planar(&graph);
    assert_eq!((log.dropped.len(), log.moved), (0, 0));
    for x in 1..6 {
        for y in 1..4 {
            let node = graph.nearest_node(at(100.0 * f64::from(x), 200.0 * f64::from(y)), 1).expect("crossing").0;
            assert_eq!(graph.degree(node), 4);
        }
    }
    // 7 corners and rim ends of the raster: 5 below, 5 above, 3 left, 3 right; 15 inside; 6 corners of the rims.
    assert_eq!(graph.node_count(), 15 + 16 + 6);
    assert!(least_angle(&graph) > 89.9);
}

#[test]
fn rasters_line_up_across_a_rim() {
    for (heading, slant) in
        [(Angle::ZERO, 0.0), (Angle::ZERO, 37.0), (Angle::degrees(-29.0), 0.0), (Angle::degrees(12.0), 55.0)]
    {
        let (mut graph, faces) = two_quarters(slant);
        let rules = grid(heading, 150.0, 90.0);
        let growths = faces.map(|face| fill(&graph, &face, &rules));
        let log = attach(&mut graph, &growths, &never);
        assert_planar(&graph);
        assert_eq!(log.dropped, []);
        let on_rim = |p: Point| predicates::within(at(600.0, 0.0), at(600.0 + slant, 800.0), p, 8);
        let inner: Vec<_> = graph
            .nodes_unsorted()
            .filter(|(_, node)| on_rim(node.at) && node.at.y > 60 * 1024 && node.at.y < 740 * 1024)
            .map(|(key, node)| (graph.degree(key), node.at.metres()))
            .collect();
        let four_way = inner.iter().filter(|(degree, _)| *degree == 4).count();
        assert!(inner.len() >= 5 && four_way * 5 >= inner.len() * 4, "{heading:?} {slant}: {inner:?}");
    }
}

#[test]
fn a_small_quarter_with_a_street_to_its_middle_is_filled() {
    let square = [at(0.0, 0.0), at(260.0, 0.0), at(260.0, 260.0), at(0.0, 260.0)];
    let mut graph = StreetGraph::new(Classes::default());
    for side in 0..4 {
        street(&mut graph, Classes::MAJOR, side as u128 + 1, square[side], square[(side + 1) % 4]);
    }
    let alone = fill(&graph, &quarter_at(&graph, at(60.0, 60.0)), &grid(Angle::ZERO, 80.0, 80.0));
    street(&mut graph, Classes::MAJOR, 9, at(130.0, 0.0), at(130.0, 130.0));
    let spurred = fill(&graph, &quarter_at(&graph, at(60.0, 60.0)), &grid(Angle::ZERO, 80.0, 80.0));
    let laid = [&alone, &spurred].map(|growth| growth.log.accepted.len());
    assert!(laid[0] > 5 && laid[1] > 5, "{laid:?}");
}

#[test]
fn a_street_on_the_other_side_changes_no_byte() {
    let (graph, faces) = two_quarters(37.0);
    let before = fill(&graph, &faces[0], &winding());
    let mut changed = graph.clone();
    let foot = changed.nearest_segment(at(622.0, 481.3), 40 * 1024, 0).unwrap().1;
    street(&mut changed, Classes::MAJOR, 100, at(900.0, 500.0), foot);
    assert!(changed.segments_of(crate::StreetId(geom::Id(7))).len() > 1, "the rim was split");
    assert!(fill(&changed, &quarter_at(&changed, at(250.0, 400.0)), &winding()) == before);
    assert!(before.log.accepted.len() > 100 && before.attachments.len() > 10);
}

#[test]
fn merges_do_not_depend_on_the_order_of_quarters() {
    let (graph, faces) = two_quarters(37.0);
    let growths = faces.map(|face| fill(&graph, &face, &winding()));
    let digest = |growths: &[QuarterGrowth]| {
        let mut graph = graph.clone();
        let log = attach(&mut graph, growths, &never);
        assert_planar(&graph);
        (graph.digest(), log)
    };
    let [west, east] = growths;
    let one = digest(&[west.clone(), east.clone()]);
    assert!(one == digest(&[east, west]));
    let log = one.1;
    assert!(log.dropped.len() * 50 < log.laid, "{} of {} dropped", log.dropped.len(), log.laid);
}

#[test]
fn stubs_from_both_sides_share_a_crossing() {
    let (mut graph, faces) = two_quarters(37.0);
    let growths = faces.map(|face| fill(&graph, &face, &winding()));
    let constraints = Chain::default();
    let log = attach(&mut graph, &growths, &never);
    assert_eq!(log.moved, 0, "each came where it grew: {log:?}");
    let is_on_rim = |node: &crate::graph::Node| predicates::within(at(600.0, 0.0), at(637.0, 800.0), node.at, 8);
    let nodes = graph.nodes_unsorted().filter(|(_, node)| is_on_rim(node));
    let (keys, mut on_rim): (Vec<_>, Vec<_>) = nodes.map(|(key, node)| (key, node.at)).unzip();
    assert!(keys.into_iter().any(|key| graph.degree(key) == 4), "some meet");
    on_rim.sort_unstable_by_key(|p| p.y);
    let closest = on_rim.windows(2).map(|pair| pair[0].distance(pair[1])).fold(f64::INFINITY, f64::min);
    assert!(closest >= constraints.snap() - 0.1, "{closest}");
    assert!(least_angle(&graph) > 24.0, "{}", least_angle(&graph));
}

#[test]
fn everything_stays_inside() {
    let (graph, faces) = two_quarters(37.0);
    for rules in [&winding() as &dyn GrowthRules, &grid(Angle::degrees(33.0), 70.0, 110.0)] {
        let growth = fill(&graph, &faces[1], rules);
        for accepted in &growth.log.accepted {
            for p in [accepted.start(), accepted.end()] {
                let from_rim = predicates::orient(at(600.0, 0.0), at(637.0, 800.0), p);
                assert!(from_rim <= 0 || predicates::within(at(600.0, 0.0), at(637.0, 800.0), p, 3));
                assert!(p.x <= 1200 * 1024 + 2 && p.y >= -2 && p.y <= 800 * 1024 + 2);
            }
        }
        for stub in &growth.attachments {
            let accepted = &growth.log.accepted[stub.line];
            assert_eq!(accepted.end(), stub.at);
            assert!(accepted.outcome.ends_street());
        }
    }
}

#[test]
fn parts_cut_off_by_a_park_are_filled() {
    let (graph, faces) = two_quarters(0.0);
    let park = (0..120 * 80).map(|i| if (40..48).contains(&(i / 120)) { 1.0 } else { 0.0 }).collect();
    let mask = Raster::new(120, 80, 10.0, Vec2::ZERO, park).unwrap();
    let fields = Fields { barred: vec![Arc::new(mask)], ..site(3000.0) };
    let growth = fill_in(&graph, &faces[0], &winding(), fields);
    let (north, south): (Vec<_>, Vec<_>) =
        growth.log.accepted.iter().map(|a| a.end().metres().y).partition(|&y| y > 400.0);
    assert!(north.len() > 30 && south.len() > 30, "{} {}", north.len(), south.len());
    assert!(north.iter().all(|&y| y >= 400.0) && south.iter().all(|&y| y <= 320.5));
}

#[test]
fn given_streets_inside_are_met() {
    let (mut graph, faces) = two_quarters(0.0);
    street(&mut graph, Classes::MINOR, 50, at(150.0, 180.0), at(430.0, 330.0));
    let growth = fill(&graph, &faces[0], &winding());
    let mut merged = graph.clone();
    let log = attach(&mut merged, &[growth], &never);
    assert_planar(&merged);
    assert_eq!(log.dropped, []);
    assert!(merged.segments_of(crate::StreetId(geom::Id(50))).len() > 2, "grown streets end on it");
}

#[test]
fn a_narrow_quarter_stays_whole_and_a_cell_of_the_raster_too() {
    let narrow = rectangle(35.0);
    assert_eq!(fill(&narrow.0, &narrow.1, &winding()).log.accepted.len(), 0);
    let cell = rectangle(50.0);
    assert_eq!(fill(&cell.0, &cell.1, &grid(Angle::ZERO, 100.0, 100.0)).log.accepted.len(), 0);
    // One line of the raster runs through, x = 50, without a crossing.
    let growth = fill(&cell.0, &cell.1, &grid(Angle::ZERO, 50.0, 100.0));
    assert_eq!(growth.log.accepted.len(), 2, "{:?}", growth.log);
    assert!(growth.log.accepted.iter().all(|a| a.end().x == 50 * 1024 && a.outcome.ends_street()));
}

/// A quarter of 80 m × `depth` from (10, 10).
fn rectangle(depth: f64) -> (StreetGraph, Face) {
    let (a, b, c, d) = (at(10.0, 10.0), at(90.0, 10.0), at(90.0, 10.0 + depth), at(10.0, 10.0 + depth));
    let sides = [(1, a, b), (2, b, c), (3, c, d), (4, d, a)];
    let mut graph = StreetGraph::new(Classes::default());
    for (name, from, to) in sides {
        street(&mut graph, Classes::MAJOR, name, from, to);
    }
    let quarter = quarter_at(&graph, at(11.0, 11.0));
    (graph, quarter)
}

#[test]
fn a_hole_is_left_alone() {
    let mut graph = StreetGraph::new(Classes::default());
    let (a, b, c, d) = (at(0.0, 0.0), at(600.0, 0.0), at(600.0, 500.0), at(0.0, 500.0));
    let outer = [(1, a, b), (2, b, c), (3, c, d), (4, d, a)];
    let (e, f, g, h) = (at(200.0, 180.0), at(210.0, 330.0), at(400.0, 320.0), at(390.0, 170.0));
    let hole = [(5, e, f), (6, f, g), (7, g, h), (8, h, e)];
    for (name, from, to) in outer.into_iter().chain(hole) {
        street(&mut graph, Classes::MAJOR, name, from, to);
    }
    let quarter = quarter_at(&graph, at(1.0, 1.0));
    let growth = fill(&graph, &quarter, &winding());
    let inner = geom::Polygon::new(vec![e, f, g, h], Vec::new());
    // A place on the rim is rounded, by less than 2 mm.
    let is_deep = |p: Point| inner.locate(p) == Location::Inside && inner.distance_to_rim(p.metres()) > 0.002;
    assert!(!growth.log.accepted.iter().any(|a| is_deep(a.end())));
    assert!(growth.attachments.iter().any(|stub| stub.side >= 4), "streets end on the hole's rim");
    let log = attach(&mut graph, &[growth], &never);
    assert_planar(&graph);
    assert_eq!(log.dropped, []);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn random_quarters_merge_into_a_planar_graph(slant in -250.0f64..250.0, heading in 0.0f64..90.0, along in 45.0f64..220.0,
                                                 across in 45.0f64..220.0, chance in any::<u64>(), is_raster in any::<bool>()) {
        let (mut graph, faces) = two_quarters(slant);
        let mut settings = settings();
        settings.growth.seed = geom::Seed(chance);
        let raster = grid(Angle::degrees(heading), along, across);
        let rules: &dyn GrowthRules = if is_raster { &raster } else { &winding() };
        let growths = faces.map(|face| grow_quarter(&graph, &face, &settings, rules, &shared(site(3000.0)), &never));
        let log = attach(&mut graph, &growths, &never);
        assert_planar(&graph);
        prop_assert!(log.dropped.len() * 50 <= log.laid, "{:?}", log.dropped);
        prop_assert!(least_angle(&graph) > 24.0, "{}", least_angle(&graph));
        // What was laid is what grew, where it grew, but for the ends that were led to another crossing.
        let ends = growths.iter().flat_map(|growth| &growth.log.accepted).filter(|a| !a.outcome.ends_street());
        let lost = ends.filter(|a| graph.nearest_node(a.end(), 1).is_none()).count();
        prop_assert!(lost <= log.dropped.len(), "{lost}");
    }
}

#[test]
fn majors_then_minors_make_a_city() {
    let mut majors = Growth::new(Classes::MAJOR, 6 * 1024, geom::Seed(5), geom::Id::root("majors", &[]));
    majors.constraints = Constraints::majors().into();
    let longer = Rule(|tip: &mut Tip| {
        winding().propose(tip);
        let slots = &mut tip.slots;
        for slot in [&mut slots.ahead, &mut slots.left, &mut slots.right].into_iter().flatten() {
            slot.length *= 4.0;
        }
    });
    let mut graph = StreetGraph::new(Classes::default());
    let fields = shared(site(1200.0));
    let seed = majors.seed_point(at(0.0, 0.0), Angle::degrees(12.0), 0);
    grow(&mut graph, &majors, &longer, &fields, &[seed], &never);
    assert_planar(&graph);
    let quarters = Faces::of(&graph, FaceKind::Quarter).faces;
    assert!(quarters.len() > 15, "{}", quarters.len());
    for rules in [&winding() as &dyn GrowthRules, &grid(Angle::degrees(20.0), 120.0, 60.0)] {
        let grown = |quarter| grow_quarter(&graph, quarter, &settings(), rules, &fields, &never);
        let growths: Vec<_> = quarters.iter().map(grown).collect();
        assert!(growths.iter().all(|growth| growth.fault.is_none()));
        let mut city = graph.clone();
        let log = attach(&mut city, &growths, &never);
        assert_planar(&city);
        assert!(log.laid > 300 && log.dropped.len() * 50 < log.laid, "{} {:?}", log.laid, log.dropped);
        // The rims are where they were: the same quarters come out.
        let ids = |graph| Faces::of(graph, FaceKind::Quarter).faces.iter().map(|face| face.id).collect::<Vec<_>>();
        assert_eq!(ids(&city), ids(&graph));
    }
}

#[test]
fn cancelling_says_so() {
    let (graph, faces) = two_quarters(0.0);
    let growth = grow_quarter(&graph, &faces[0], &settings(), &winding(), &shared(site(3000.0)), &|| true);
    assert!(growth.is_cancelled() && growth.log.stopped == Some(Stopped::Cancelled));
    let whole = fill(&graph, &faces[0], &winding());
    let mut merged = graph.clone();
    assert_eq!(attach(&mut merged, &[whole], &|| true).laid, 0);
    assert_eq!(merged.digest(), graph.digest());
}
