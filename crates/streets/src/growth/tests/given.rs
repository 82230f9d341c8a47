//! Growth from streets that are there: they keep their lines, their free ends go on, streets sprout along them.

use super::support::{Rule, assert_planar, at, grid, minors, never, shared, site, slot, street, winding};
use crate::graph::Crowding;
use crate::growth::{GrowthLog, GrowthRules, Tip, grow_from_streets};
use crate::{Classes, NodeId, StreetGraph, StreetId};
use geom::{Angle, Id, Point, predicates, tolerance};
use proptest::prelude::*;

fn grown(graph: &mut StreetGraph, rules: &dyn GrowthRules) -> GrowthLog {
    let mut settings = minors();
    settings.limits.segments = 400;
    grow_from_streets(graph, &settings, rules, &shared(site(2000.0)), &never)
}

/// The lines of a street, each as from and to with their ids.
fn lines(graph: &StreetGraph, street: StreetId) -> Vec<(NodeId, NodeId)> {
    let along = |key| {
        let claim = graph.segment(key).claims().iter().find(|claim| claim.street == street).expect("its claim");
        let half = if claim.forward { key.forward() } else { key.backward() };
        (graph.node(graph.origin(half)).id, graph.node(graph.target(half)).id)
    };
    graph.segments_of(street).into_iter().map(along).collect()
}

/// Whether the street still runs from one node to the other, straight to within the separation: where two given streets
/// nearly coincide, a crossing on one of them is a crossing of both.
fn still_runs(graph: &StreetGraph, street: StreetId, from: NodeId, to: NodeId) -> bool {
    let (Some(from), Some(to)) = (graph.find_node(from), graph.find_node(to)) else { return false };
    let (a, b) = (graph.at(from), graph.at(to));
    let now = lines(graph, street);
    let mut here = graph.node(from).id;
    for _ in 0..=now.len() {
        let at = graph.at(graph.find_node(here).expect("live"));
        if !predicates::within(a, b, at, tolerance::SEPARATION) {
            return false;
        }
        if here == graph.node(to).id {
            return true;
        }
        let next = now.iter().filter(|line| line.0 == here).find(|line| {
            let to = graph.at(graph.find_node(line.1).expect("live"));
            predicates::within(a, b, to, tolerance::SEPARATION)
        });
        let Some(next) = next else { return false };
        here = next.1;
    }
    false
}

#[test]
fn a_given_street_goes_on_at_both_ends_and_sprouts() {
    let mut graph = StreetGraph::new(Classes::default());
    let given = street(&mut graph, Classes::MINOR, 1, at(-300.0, 0.0), at(300.0, 0.0));
    let log = grown(&mut graph, &grid(Angle::ZERO, 100.0, 100.0));
    assert_planar(&graph);
    let xs: Vec<i64> = graph
        .segments_of(given)
        .iter()
        .flat_map(|&key| graph.segment(key).ends)
        .map(|n| graph.at(n).metres().x.round() as i64)
        .collect();
    assert!(xs.iter().any(|x| *x < -300) && xs.iter().any(|x| *x > 300), "both free ends go on");
    for x in [-200.0, -100.0, 0.0, 100.0, 200.0] {
        let (node, _) = graph.nearest_node(at(x, 0.0), 10).expect("a crossing on the given street");
        assert_eq!(graph.degree(node), 4, "at {x}");
    }
    assert!(log.accepted.len() > 20);
}

#[test]
fn other_classes_and_settled_streets_are_left_alone() {
    let mut graph = StreetGraph::new(Classes::default());
    street(&mut graph, Classes::MAJOR, 1, at(-300.0, 0.0), at(300.0, 0.0));
    let before = graph.digest();
    assert!(grown(&mut graph, &winding()).accepted.is_empty());
    let mut settings = minors();
    (settings.class, settings.sprouts) = (Classes::MAJOR, false);
    let log = grow_from_streets(&mut graph, &settings, &winding(), &shared(site(2000.0)), &never);
    assert!(log.accepted.is_empty());
    assert_eq!(graph.digest(), before);
}

#[test]
fn an_end_on_another_street_does_not_go_on() {
    let mut graph = StreetGraph::new(Classes::default());
    let given = street(&mut graph, Classes::MINOR, 1, at(0.0, 0.0), at(300.0, 0.0));
    street(&mut graph, Classes::MAJOR, 2, at(0.0, -500.0), at(0.0, 500.0));
    let only_ahead = Rule(|tip: &mut Tip| tip.slots.ahead = slot(90.0));
    grown(&mut graph, &only_ahead);
    let least = graph.segments_of(given).iter().flat_map(|&key| graph.segment(key).ends).map(|n| graph.at(n).x).min();
    assert_eq!(least, Some(0));
    assert!(lines(&graph, given).len() > 5, "the other end goes on");
}

/// A polyline of up to five points.
fn polyline() -> impl Strategy<Value = Vec<Point>> {
    let point = (-900.0..900.0_f64, -900.0..900.0_f64).prop_map(|(x, y)| at(x, y));
    prop::collection::vec(point, 2..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Given streets keep their lines, whatever grows from them.
    #[test]
    fn given_streets_keep_their_lines(streets in prop::collection::vec(polyline(), 1..6), raster in any::<bool>()) {
        let mut graph = StreetGraph::new(Classes::default());
        let mut given = Vec::new();
        for (name, points) in streets.iter().enumerate() {
            let id = StreetId(Id(name as u128 + 1));
            for (i, pair) in points.windows(2).enumerate() {
                let new = crate::graph::NewSegment {
                    from: pair[0],
                    to: pair[1],
                    from_id: NodeId(id.0.child(i as u64)),
                    to_id: NodeId(id.0.child(i as u64 + 1)),
                    claim: crate::Claim { street: id, class: Classes::MINOR, half_width: 2048, origin: 0, forward: true },
                    level: 0,
                };
                let _ = graph.insert(&new, Crowding::Join);
            }
            given.push(id);
        }
        let before: Vec<_> = given.iter().map(|&id| (id, lines(&graph, id))).collect();
        let grid = grid(Angle::degrees(17.0), 120.0, 80.0);
        let log = if raster { grown(&mut graph, &grid) } else { grown(&mut graph, &winding()) };
        prop_assert!(!log.accepted.is_empty());
        assert_planar(&graph);
        for (street, lines) in before {
            for (from, to) in lines {
                prop_assert!(still_runs(&graph, street, from, to), "{street} from {from} to {to}");
            }
        }
    }
}
