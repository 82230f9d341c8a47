//! Smoothing: curves keep their ends, stay planar and inside the corners they cut.

use super::support::{assert_planar, at, minors, site, street};
use crate::graph::CheckLevel;
use crate::growth::{Constraints, Field, Fields, Growth, Smoothed, Smoothing, smooth};
use crate::{Classes, StreetGraph, StreetId};
use geom::{Angle, Point, Raster, Vec2};
use proptest::prelude::*;
use std::sync::Arc;

fn polyline(graph: &mut StreetGraph, name: u128, points: &[Point]) -> StreetId {
    points.windows(2).map(|pair| street(graph, Classes::HIGHWAY, name, pair[0], pair[1])).last().expect("a piece")
}

fn smoothed(graph: &mut StreetGraph) -> Smoothed {
    smoothed_on(graph, &site(3000.0), &highways())
}

fn highways() -> Growth {
    Growth { class: Classes::HIGHWAY, ..minors() }
}

fn smoothed_on(graph: &mut StreetGraph, fields: &Fields, growth: &Growth) -> Smoothed {
    smooth(graph, growth, fields, &Smoothing::default(), &|_, _| true)
}

fn sharpest(graph: &StreetGraph, street: StreetId) -> f64 {
    let nodes = |key| graph.segment(key).ends;
    let ends: Vec<_> = graph.segments_of(street).into_iter().flat_map(nodes).collect();
    let bend = |&node: &crate::NodeKey| {
        let [a, b] = graph.halves_ccw(node) else { return 0.0 };
        let [a, b] = [a, b].map(|half| {
            let (x, y) = graph.direction(*half);
            Vec2::new(x as f64, y as f64)
        });
        (Angle::of(a) - Angle::of(-b)).wrapped().to_degrees().abs()
    };
    ends.iter().map(bend).fold(0.0, f64::max)
}

#[test]
fn a_bend_becomes_a_curve() {
    let mut graph = StreetGraph::new(Classes::default());
    let line = [at(0.0, 0.0), at(400.0, 0.0), at(750.0, 200.0), at(1100.0, 210.0)];
    let id = polyline(&mut graph, 1, &line);
    assert!(sharpest(&graph, id) > 27.0);
    assert_eq!(smoothed(&mut graph), Smoothed { runs: 1, kept: 0 });
    assert!(sharpest(&graph, id) < 10.0, "a third of the bend: {}", sharpest(&graph, id));
    assert_planar(&graph);
    for end in [line[0], line[3]] {
        let (node, distance) = graph.nearest_node(end, 10).expect("the end stays");
        assert_eq!((graph.degree(node), distance), (1, 0));
    }
}

#[test]
fn corners_crossings_and_other_classes_stay() {
    let mut graph = StreetGraph::new(Classes::default());
    polyline(&mut graph, 1, &[at(0.0, 0.0), at(400.0, 0.0), at(400.0, 400.0)]);
    let minor = street(&mut graph, Classes::MINOR, 2, at(1000.0, 0.0), at(1200.0, 0.0));
    street(&mut graph, Classes::MINOR, 2, at(1200.0, 0.0), at(1390.0, 60.0));
    let before = graph.digest();
    assert_eq!(smoothed(&mut graph), Smoothed::default(), "a right angle is a corner");
    assert_eq!(graph.digest(), before);
    assert_eq!(graph.segments_of(minor).len(), 2);
}

#[test]
fn a_curve_that_leaves_its_ground_is_not_laid() {
    let mut graph = StreetGraph::new(Classes::default());
    polyline(&mut graph, 1, &[at(0.0, 5.0), at(400.0, 5.0), at(750.0, 205.0)]);
    let before = graph.digest();
    // A pond in the crook of the bend.
    let pond = (0..10_000).map(|i| f32::from(!((35..45).contains(&(i % 100)) && (1..4).contains(&(99 - i / 100)))));
    let land = Raster::new(100, 100, 10.0, Vec2::ZERO, pond.collect()).unwrap();
    let fields = Fields { legal: vec![Arc::new(land)], ..site(3000.0) };
    assert_eq!(smoothed_on(&mut graph, &fields, &highways()), Smoothed { runs: 0, kept: 1 });
    assert_eq!(graph.digest(), before);
    // Ground that rises beside the street: the curve would climb it.
    let rise = (0..10_000).map(|i| 0.3 * ((99 - i / 100) as f32 * 10.0).min(30.0)).collect();
    let hill = Raster::new(100, 100, 10.0, Vec2::ZERO, rise).unwrap();
    let fields = Fields { elevation: Field::Map(Arc::new(hill)), ..site(3000.0) };
    let gentle = Growth { constraints: Constraints { max_slope: 0.02, ..Constraints::default() }.into(), ..highways() };
    assert_eq!(smoothed_on(&mut graph, &fields, &gentle), Smoothed { runs: 0, kept: 1 });
    assert_eq!(graph.digest(), before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever lies around: planar, every crossing and end where it was, and nothing of other streets moved.
    #[test]
    fn smoothing_keeps_the_contract(
        lines in prop::collection::vec(prop::collection::vec((-500.0..500.0_f64, -500.0..500.0_f64), 2..7), 1..6),
        is_minor in prop::collection::vec(any::<bool>(), 6),
    ) {
        let mut graph = StreetGraph::new(Classes::default());
        for (name, line) in lines.iter().enumerate() {
            let points: Vec<_> = line.iter().map(|&(x, y)| at(x, y)).collect();
            let class = if is_minor[name] { Classes::MINOR } else { Classes::HIGHWAY };
            for pair in points.windows(2) {
                let _ = super::support::try_street(&mut graph, class, name as u128 + 1, pair[0], pair[1]);
            }
        }
        let degrees = |graph: &StreetGraph| {
            let mut degrees: Vec<_> = graph
                .nodes_unsorted()
                .filter(|(key, _)| graph.degree(*key) != 2)
                .map(|(key, node)| (node.id, node.at, graph.degree(key)))
                .collect();
            degrees.sort();
            degrees
        };
        let before = degrees(&graph);
        smoothed(&mut graph);
        prop_assert_eq!(graph.check(CheckLevel::Brute), Vec::new());
        prop_assert_eq!(degrees(&graph), before);
    }

    /// An attempt that fails leaves no trace, whatever it did.
    #[test]
    fn failed_attempts_leave_no_trace(
        lines in prop::collection::vec(((-300.0..300.0_f64, -300.0..300.0_f64), (-300.0..300.0_f64, -300.0..300.0_f64)), 2..20),
        kept in 1..10_usize,
    ) {
        let mut graph = StreetGraph::new(Classes::default());
        let lay = |graph: &mut StreetGraph, i: usize| {
            let ((a, b), (c, d)) = lines[i];
            let _ = super::support::try_street(graph, Classes::MINOR, i as u128 + 1, at(a, b), at(c, d));
        };
        let kept = kept.min(lines.len() - 1);
        (0..kept).for_each(|i| lay(&mut graph, i));
        let before = graph.digest();
        let outcome: Option<()> = graph.attempt(|graph| {
            (kept..lines.len()).for_each(|i| lay(graph, i));
            graph.remove_street(StreetId(geom::Id(1)));
            graph.attempt(|graph| graph.remove_street(StreetId(geom::Id(2))).then_some(()));
            None
        });
        prop_assert_eq!(outcome, None);
        prop_assert_eq!(graph.digest(), before);
        prop_assert_eq!(graph.check(CheckLevel::Brute), Vec::new());
    }
}
