//! The kernel in an open graph: rasters, termination, determinism, lineage.

use super::support::{Rule, assert_planar, at, grid, least_angle, minors, never, shared, site, slot, street, winding};
use crate::growth::{
    Branch, Constraints, Goal, GrowthLog, GrowthRules, Outcome, Refused, Slot, Steer, Stopped, Tip, grow,
};
use crate::growth::{Field, Fields, Growth};
use crate::{Classes, StreetGraph};
use geom::{Angle, Bounds, Point, Raster, Vec2};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Settings under which a raster keeps to itself: nothing is cut back or turned at the rim of the site.
fn strict() -> Growth {
    let mut settings = minors();
    settings.constraints = Constraints { prune: 1.0, turn_most: Angle::ZERO, ..Constraints::default() }.into();
    settings
}

fn grown(settings: &Growth, rules: &dyn GrowthRules, side: f64) -> (StreetGraph, GrowthLog) {
    let mut graph = StreetGraph::new(Classes::default());
    let seed = settings.seed_point(at(3.0, -2.0), Angle::degrees(20.0), 0);
    let log = grow(&mut graph, settings, rules, &shared(site(side)), &[seed], &never);
    (graph, log)
}

#[test]
fn raster_on_open_ground_is_whole() {
    for heading in [Angle::ZERO, Angle::degrees(-29.0), Angle::degrees(61.0)] {
        let settings = strict();
        let (graph, log) = grown(&settings, &grid(heading, 200.0, 80.0), 500.0);
        assert_planar(&graph);
        let (u, v) = (heading.unit(), heading.unit().perp());
        // Crossings of the raster whose four neighbours all lie within the site are 4-way.
        for (i, j) in (-3..=3).flat_map(|i| (-7..=7).map(move |j| (i, j))) {
            let place = |i: i32, j: i32| u * (200.0 * f64::from(i)) + v * (80.0 * f64::from(j));
            let is_inside = |p: Vec2| p.x.abs() < 499.0 && p.y.abs() < 499.0;
            let around = [(i, j), (i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)];
            if around.iter().all(|&(i, j)| is_inside(place(i, j))) {
                let node = graph.nearest_node(at(place(i, j).x, place(i, j).y), 3).expect("crossing").0;
                assert_eq!(graph.degree(node), 4, "{heading:?} {i} {j}");
            }
        }
        assert!(log.refusals[Refused::Sharp] == 0 && log.refusals[Refused::Crowded] == 0, "{:?}", log.refusals);
        assert!(least_angle(&graph) > 89.9);
    }
}

#[test]
fn winding_streets_are_planar_and_keep_their_angles() {
    let (graph, log) = grown(&minors(), &winding(), 600.0);
    assert!(log.accepted.len() > 300, "{}", log.accepted.len());
    assert_eq!(log.stopped, None);
    assert_planar(&graph);
    assert!(least_angle(&graph) > 24.9, "{}", least_angle(&graph));
    let least = graph.segments_unsorted().map(|(key, _)| graph.line(key.forward())).map(|(a, b)| a.distance(b));
    assert!(least.fold(f64::INFINITY, f64::min) > 0.06);
    assert!(log.accepted.iter().any(|a| a.outcome == Outcome::Extended));
    assert!(log.accepted.iter().any(|a| a.outcome == Outcome::Snapped));
    assert!(log.accepted.iter().any(|a| a.outcome == Outcome::Crossed));
}

#[test]
fn equal_settings_grow_equal_cities_and_seeds_differ() {
    let run = |seed| {
        let mut settings = minors();
        settings.seed = geom::Seed(seed);
        let (graph, log) = grown(&settings, &winding(), 400.0);
        (graph.digest(), log)
    };
    let (first, again, other) = (run(1), run(1), run(2));
    assert!(first == again);
    assert_ne!(first.0, other.0);
}

#[test]
fn ids_are_unique_and_come_from_lineage_only() {
    let ids = |seed| {
        let mut settings = minors();
        (settings.seed, settings.limits.steps) = (geom::Seed(seed), 20);
        let (_, log) = grown(&settings, &winding(), 2000.0);
        let ids: BTreeSet<_> = log.accepted.iter().map(|a| a.lineage.id).collect();
        assert_eq!(ids.len(), log.accepted.len());
        for accepted in &log.accepted {
            assert_eq!(accepted.lineage.id, accepted.lineage.parent.child(accepted.lineage.branch.slot()));
        }
        (ids, log)
    };
    let (one, _) = ids(1);
    let (other, log) = ids(2);
    // Other chance, other places and delays; but the same tip is the same tip.
    let ahead = |a: &&crate::growth::Accepted| a.lineage.branch.goes_on() && a.lineage.time == 1;
    assert!(log.accepted.iter().filter(ahead).all(|a| one.contains(&a.lineage.id)));
    assert!(one.intersection(&other).count() > 10);
}

#[test]
fn a_street_is_a_run_of_segments_in_one_direction() {
    let rules = Rule(|tip: &mut Tip| {
        tip.slots.ahead = (tip.age < 4).then(|| slot(60.0).unwrap());
        tip.slots.left = (tip.is_seed).then(|| slot(60.0).unwrap());
    });
    let (_, log) = grown(&minors(), &rules, 1000.0);
    let of_seed = log.accepted.iter().find(|a| a.lineage.branch == Branch::Back).unwrap().lineage.street;
    let mut main: Vec<_> = log.accepted.iter().filter(|a| a.lineage.street == of_seed).map(|a| a.line).collect();
    assert_eq!(main.len(), 8);
    main.sort_by_key(|line| line.from);
    let ends: Vec<_> =
        main.windows(2).map(|pair| (pair[0].to, pair[0].to_id) == (pair[1].from, pair[1].from_id)).collect();
    assert_eq!(ends, [true; 7], "one chain from start to end");
    let branches: BTreeSet<_> = log.accepted.iter().map(|a| a.lineage.street).collect();
    assert_eq!(branches.len(), 2);
}

#[test]
fn limits_and_cancelling_stop_it() {
    let mut settings = minors();
    settings.limits.segments = 25;
    let (graph, log) = grown(&settings, &winding(), 2000.0);
    assert_eq!((log.accepted.len(), log.stopped), (25, Some(Stopped::Limit)));
    assert_planar(&graph);
    settings.limits.segments = usize::MAX;
    settings.limits.steps = 5;
    let (_, log) = grown(&settings, &winding(), 2000.0);
    assert!(log.accepted.iter().all(|a| a.lineage.time <= 5));
    assert_eq!(log.stopped, Some(Stopped::Limit));
    let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let log = grow(&mut graph, &minors(), &winding(), &shared(site(500.0)), &[seed], &|| true);
    assert_eq!((log.accepted.len(), log.stopped), (0, Some(Stopped::Cancelled)));
}

#[test]
fn unusable_numbers_end_a_tip_and_harm_nothing() {
    for length in [f64::NAN, f64::INFINITY, -5.0, 0.0, 1e300] {
        for turn in [0.0, f64::NAN, f64::INFINITY, 1e300] {
            for pitch in [100.0, 0.0, f64::NAN, 1e-300] {
                let rules = Rule(move |tip: &mut Tip| {
                    let turn = Angle::radians(turn);
                    tip.slots.ahead = Some(Slot { length, turn, delay: i32::MAX, width: Some(f64::NAN) });
                    tip.slots.left = Some(Slot { length, turn, delay: 3, width: Some(-1.0) });
                    tip.steer(Steer::Raster { heading: turn, along: pitch, across: pitch, origin: Vec2::ZERO });
                });
                let (graph, _) = grown(&minors(), &rules, 300.0);
                assert_planar(&graph);
            }
        }
    }
}

#[test]
fn no_streets_grow_where_nobody_lives() {
    let values = (0..10_000).map(|cell| if cell % 100 < 50 { 900.0 } else { 10.0 }).collect();
    let density = Raster::new(100, 100, 10.0, Vec2::splat(-500.0), values).unwrap();
    let mut settings = minors();
    settings.goal = Goal::of(Field::Map(Arc::new(density)), 100.0, 4.0);
    let (graph, log) = grown(&settings, &grid(Angle::ZERO, 60.0, 60.0), 500.0);
    assert!(log.refusals[Refused::NoDemand] > 5 && log.accepted.len() > 50);
    let west = Bounds::between(at(-501.0, -501.0), at(61.0, 501.0));
    assert!(graph.nodes_unsorted().all(|(_, node)| west.contains(node.at)));
    // A goal that refuses and delays nothing changes nothing.
    settings.goal = Goal { least: 0.0.into(), pace: 0.0.into(), ..settings.goal };
    let without = grown(&minors(), &winding(), 300.0);
    assert!(grown(&settings, &winding(), 300.0).1 == without.1);
}

#[test]
fn seeds_move_onto_the_raster() {
    let mut graph = StreetGraph::new(Classes::default());
    let settings = strict();
    let seed = settings.seed_point(at(37.0, 21.0), Angle::degrees(3.0), 0);
    let log = grow(&mut graph, &settings, &grid(Angle::ZERO, 100.0, 100.0), &shared(site(350.0)), &[seed], &never);
    assert!(
        log.accepted
            .iter()
            .all(|a| { [a.start(), a.end()].iter().all(|p| p.x % (100 * 1024) == 0 && p.y % (100 * 1024) == 0) })
    );
    assert_eq!(graph.node_count(), 49);
}

#[test]
fn growth_meets_what_is_given() {
    let mut graph = StreetGraph::new(Classes::default());
    let given = street(&mut graph, Classes::MAJOR, 1, at(-500.0, 130.0), at(500.0, 145.0));
    let settings = minors();
    let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
    let log = grow(&mut graph, &settings, &grid(Angle::ZERO, 100.0, 100.0), &shared(site(420.0)), &[seed], &never);
    assert_planar(&graph);
    let across = log.accepted.iter().filter(|a| a.start().y < 130 * 1024 && a.end().y > 145 * 1024).count();
    assert_eq!(across, 0, "what meets a street ends there");
    assert_eq!(graph.segments_of(given).len(), 10, "nine streets come from the south");
}

#[test]
fn seeds_may_lie_on_a_street_but_not_beside_one() {
    let mut graph = StreetGraph::new(Classes::default());
    street(&mut graph, Classes::MAJOR, 1, at(-500.0, 40.0), at(500.0, -63.0));
    let on = graph.nearest_segment(at(0.0, -10.0), 5 * 1024, 0).unwrap().1;
    let rules = Rule(|tip: &mut Tip| tip.slots.ahead = tip.is_seed.then(|| slot(60.0).unwrap()));
    let settings = minors();
    let mut log_of = |seed: Point, ordinal| {
        let seed = settings.seed_point(seed, Angle::RIGHT, ordinal);
        grow(&mut graph, &settings, &rules, &shared(site(800.0)), &[seed], &never)
    };
    let log = log_of(on, 0);
    assert_eq!((log.accepted.len(), log.refusals.total()), (2, 0), "{log:?}");
    let log = log_of(at(200.0, -29.0), 1);
    assert_eq!((log.accepted.len(), log.refusals[Refused::Crowded]), (0, 2), "{log:?}");
    assert_planar(&graph);
}

#[test]
fn highways_seek_people() {
    let peak = Vec2::new(700.0, 300.0);
    let place = |i: usize| Vec2::new((i % 200) as f64, 199.0 - (i / 200) as f64) * 10.0 - 995.0;
    let near = |p: Vec2| (1.0 - (p - peak).length() / 400.0).max(0.0) as f32;
    let density = Raster::new(200, 200, 10.0, Vec2::splat(-1000.0), (0..40_000).map(|i| near(place(i))).collect());
    let fields = Fields { density: Field::Map(Arc::new(density.unwrap())), ..site(1000.0) };
    let rules = Rule(|tip: &mut Tip| {
        let wanted = tip.seek_density((0.0, 1000.0), Angle::degrees(40.0), 8);
        tip.slots.ahead = slot(100.0).map(|s| Slot { turn: wanted - tip.heading, ..s });
    });
    let settings = minors();
    let seed = settings.seed_point(at(-600.0, -100.0), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let log = grow(&mut graph, &settings, &rules, &shared(fields), &[seed], &never);
    let closest = log.accepted.iter().map(|a| (a.end().metres() - peak).length()).fold(f64::INFINITY, f64::min);
    assert!(closest < 100.0, "passed the peak by {closest} m");
}
