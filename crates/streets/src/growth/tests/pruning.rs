//! Dead ends that are too short go, and nothing else does.

use super::support::{assert_planar, at, minors, never, shared, site, street, winding};
use crate::growth::{grow, prune_dead_ends, prune_networks};
use crate::runs::{Run, runs};
use crate::{Classes, StreetGraph};
use geom::{Angle, Point};
use proptest::prelude::*;

fn length(graph: &StreetGraph, run: &Run) -> f64 {
    run.nodes.windows(2).map(|pair| graph.at(pair[0]).distance(graph.at(pair[1]))).sum()
}

fn dead_ends(graph: &StreetGraph) -> Vec<f64> {
    let ends = |run: &Run| graph.degree(run.from()) == 1 || graph.degree(run.to()) == 1;
    runs(graph).iter().filter(|run| ends(run)).map(|run| length(graph, run)).collect()
}

#[test]
fn what_is_left_at_the_end_of_a_removed_one_is_next() {
    let mut graph = StreetGraph::new(Classes::default());
    street(&mut graph, Classes::MAJOR, 1, at(0.0, -500.0), at(0.0, 500.0));
    street(&mut graph, Classes::MINOR, 2, at(0.0, 0.0), at(60.0, 0.0));
    street(&mut graph, Classes::MINOR, 3, at(60.0, 0.0), at(60.0, 30.0));
    street(&mut graph, Classes::MINOR, 4, at(60.0, 0.0), at(60.0, -40.0));
    street(&mut graph, Classes::MINOR, 5, at(0.0, 200.0), at(300.0, 200.0));
    assert_eq!(prune_dead_ends(&mut graph, Classes::MINOR, 100.0, &|_, _| false), 3);
    let mut left: Vec<i64> = dead_ends(&graph).iter().map(|length| length.round() as i64).collect();
    left.sort_unstable();
    // The two ends of the major, and the long minor.
    assert_eq!(left, [300, 300, 700]);
    assert_planar(&graph);
}

#[test]
fn short_networks_of_the_class_go_and_nothing_else_does() {
    let mut graph = StreetGraph::new(Classes::default());
    // 400 m of minors with a crossing, 600 m of them, 300 m with a major among them, 200 m that are kept.
    street(&mut graph, Classes::MINOR, 1, at(0.0, 0.0), at(200.0, 0.0));
    street(&mut graph, Classes::MINOR, 2, at(100.0, 0.0), at(100.0, 200.0));
    street(&mut graph, Classes::MINOR, 3, at(0.0, 1000.0), at(600.0, 1000.0));
    street(&mut graph, Classes::MAJOR, 4, at(0.0, 2000.0), at(200.0, 2000.0));
    street(&mut graph, Classes::MINOR, 5, at(100.0, 2000.0), at(100.0, 2100.0));
    street(&mut graph, Classes::MINOR, 6, at(1000.0, 0.0), at(1200.0, 0.0));
    let kept = runs(&graph).iter().find(|run| graph.at(run.from()).x > at(900.0, 0.0).x).map(|run| run.street);
    let before = graph.clone();
    assert_eq!(prune_networks(&mut graph, Classes::MINOR, 400.0, &|_, run| Some(run.street) == kept), 0);
    assert_eq!(graph.digest(), before.digest());
    assert_eq!(prune_networks(&mut graph, Classes::MINOR, 401.0, &|_, run| Some(run.street) == kept), 3);
    let mut left: Vec<i64> = runs(&graph).iter().map(|run| length(&graph, run).round() as i64).collect();
    left.sort_unstable();
    assert_eq!(left, [100, 100, 100, 200, 600]);
    assert_planar(&graph);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_short_dead_end_is_left(seed in any::<u64>(), least in 20.0..200.0_f64) {
        let mut graph = StreetGraph::new(Classes::default());
        let mut settings = minors();
        (settings.seed, settings.limits.segments) = (geom::Seed(seed), 300);
        let start = settings.seed_point(Point::new(0, 0), Angle::ZERO, 0);
        grow(&mut graph, &settings, &winding(), &shared(site(1500.0)), &[start], &never);
        let kept_id = runs(&graph).first().map(|run| run.street);
        prune_dead_ends(&mut graph, Classes::MINOR, least, &|_, run| Some(run.street) == kept_id);
        assert_planar(&graph);
        let is_dead = |run: &Run| graph.degree(run.from()) == 1 || graph.degree(run.to()) == 1;
        for run in runs(&graph).iter().filter(|run| is_dead(run) && Some(run.street) != kept_id) {
            prop_assert!(length(&graph, run) >= least);
        }
    }
}
