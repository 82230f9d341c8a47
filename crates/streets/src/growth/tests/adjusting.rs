//! Single constraints, each on a proposal of its own.

use super::support::{Rule, assert_planar, at, grid, minors, never, shared, site, slot, street, winding};
use crate::growth::{Accepted, Constraints, Field, Fields, Goal, Growth, GrowthLog, Outcome, Refused, Tip, grow};
use crate::{Classes, StreetGraph};
use geom::{Angle, Point, Raster, Vec2};
use std::sync::Arc;

/// Lets one street of `length` grow from the origin to the east, among given streets.
pub fn eastward(given: &[(Point, Point)], length: f64, fields: Fields, settings: &Growth) -> (StreetGraph, GrowthLog) {
    let mut graph = StreetGraph::new(Classes::default());
    for (name, &(a, b)) in given.iter().enumerate() {
        street(&mut graph, Classes::MAJOR, name as u128 + 1, a, b);
    }
    // Branches to the left of a seed that looks south: east.
    let rules = Rule(move |tip: &mut Tip| tip.slots.left = if tip.is_seed { slot(length) } else { None });
    let seed = settings.seed_point(at(0.0, 0.0), -Angle::RIGHT, 0);
    let log = grow(&mut graph, settings, &rules, &shared(fields), &[seed], &never);
    assert_planar(&graph);
    (graph, log)
}

pub fn only(log: &GrowthLog) -> (&Accepted, Outcome) {
    assert_eq!((log.accepted.len(), log.refusals.total()), (1, 0), "{log:?}");
    (&log.accepted[0], log.accepted[0].outcome)
}

pub fn refused(log: &GrowthLog) -> Refused {
    assert_eq!((log.accepted.len(), log.refusals.total()), (0, 1), "{log:?}");
    log.refusals.iter().next().unwrap().0
}

fn among(given: &[(Point, Point)], length: f64) -> GrowthLog {
    eastward(given, length, site(1000.0), &minors()).1
}

#[test]
fn cuts_at_the_first_crossing() {
    let log = among(&[(at(80.0, -50.0), at(80.0, 50.0)), (at(50.0, -50.0), at(50.0, 50.0))], 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(50.0, 0.0), Outcome::Crossed));
}

#[test]
fn snaps_to_a_crossing_near_the_cut_or_the_end() {
    let corner = [(at(50.0, 3.0), at(50.0, -60.0)), (at(50.0, 3.0), at(110.0, 60.0))];
    let log = among(&corner, 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(50.0, 3.0), Outcome::Snapped));
    let dead_end = [(at(102.0, 4.0), at(150.0, 60.0))];
    let log = among(&dead_end, 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(102.0, 4.0), Outcome::Snapped));
}

#[test]
fn goes_to_a_dead_end_that_it_would_pass() {
    let log = among(&[(at(60.0, 3.0), at(60.0, 80.0))], 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(60.0, 3.0), Outcome::Snapped));
    let log = among(&[(at(60.0, 6.0), at(60.0, 80.0))], 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(100.0, 0.0), Outcome::As));
}

#[test]
fn goes_on_to_a_street_ahead() {
    let ahead = |x: f64| [(at(x, -50.0), at(x, 50.0))];
    let log = among(&ahead(124.0), 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(124.0, 0.0), Outcome::Extended));
    let log = among(&ahead(126.0), 100.0);
    assert_eq!((only(&log).0.end(), only(&log).1), (at(100.0, 0.0), Outcome::As));
    // However long the proposal: where a block has room, a street ends.
    let log = among(&ahead(240.0), 200.0);
    assert_eq!(only(&log).1, Outcome::As);
}

#[test]
fn snaps_to_a_street_beside_its_end() {
    let log = among(&[(at(60.0, 40.0), at(104.0, 2.0))], 95.0);
    let (accepted, outcome) = only(&log);
    assert!(matches!(outcome, Outcome::Snapped | Outcome::Extended), "{outcome:?}");
    assert_eq!(accepted.end(), at(104.0, 2.0));
}

#[test]
fn refuses_duplicates_however_short_the_other_is() {
    assert_eq!(refused(&among(&[(at(-10.0, 5.5), at(200.0, 5.5))], 100.0)), Refused::Duplicate);
    // Beside the middle of a long proposal, both its ends far away.
    assert_eq!(refused(&among(&[(at(40.0, 5.5), at(52.0, 5.6))], 100.0)), Refused::Duplicate);
    assert_eq!(only(&among(&[(at(-10.0, 6.5), at(200.0, 6.5))], 100.0)).1, Outcome::As);
    // Less than half of the shorter lies beside it.
    assert_eq!(only(&among(&[(at(80.0, 5.5), at(300.0, 5.5))], 100.0)).1, Outcome::As);
}

#[test]
fn wide_streets_need_wide_gaps() {
    let mut settings = minors();
    settings.half_width = 10 * 1024;
    let beside = |y: f64| eastward(&[(at(-10.0, y), at(200.0, y))], 100.0, site(500.0), &settings).1;
    assert_eq!(refused(&beside(11.9)), Refused::Duplicate);
    assert_eq!(only(&beside(12.1)).1, Outcome::As);
}

#[test]
fn refuses_sharp_angles_at_either_end() {
    let slanted = |degrees: f64| {
        let step = Angle::degrees(degrees).unit() * 100.0;
        [(at(70.0 - step.x, -step.y), at(70.0 + step.x, step.y))]
    };
    assert_eq!(refused(&among(&slanted(23.0), 100.0)), Refused::Sharp);
    assert_eq!(only(&among(&slanted(27.0), 100.0)).1, Outcome::Crossed);
    let at_start = |degrees: f64| {
        let step = Angle::degrees(degrees).unit() * 100.0;
        [(at(0.0, 0.0), at(step.x, step.y))]
    };
    assert_eq!(refused(&among(&at_start(-24.0), 100.0)), Refused::Sharp);
    assert_eq!(only(&among(&at_start(-26.0), 100.0)).1, Outcome::As);
}

#[test]
fn refuses_what_is_too_short() {
    assert_eq!(refused(&among(&[(at(7.5, -50.0), at(7.5, 50.0))], 100.0)), Refused::TooShort);
    assert_eq!(refused(&among(&[], 7.9)), Refused::TooShort);
    assert_eq!(only(&among(&[], 8.0)).1, Outcome::As);
}

/// Land of 1 m cells, wet where `wet` says so; x and y from -200 to 200.
pub fn land(wet: impl Fn(f64, f64) -> bool) -> Fields {
    let cell = |i: usize| ((i % 400) as f64 - 199.5, 199.5 - (i / 400) as f64);
    let values = (0..160_000).map(cell).map(|(x, y)| if wet(x, y) { 0.0 } else { 1.0 }).collect();
    let mask = Raster::new(400, 400, 1.0, Vec2::splat(-200.0), values).unwrap();
    Fields { legal: vec![Arc::new(mask)], ..site(200.0) }
}

#[test]
fn prunes_at_the_coast_or_turns_along_it() {
    let log = eastward(&[], 100.0, land(|x, _| x > 60.0), &minors()).1;
    let (accepted, outcome) = only(&log);
    assert_eq!(outcome, Outcome::Shortened);
    assert!((59.0..=60.0).contains(&accepted.end().metres().x), "{:?}", accepted.end());
    // Less than half would be left: turned by the least multiple of 10° that stays dry, 40° here.
    let log = eastward(&[], 100.0, land(|x, y| x > 40.0 && y < x * 0.8), &minors()).1;
    let (accepted, outcome) = only(&log);
    assert_eq!(outcome, Outcome::Turned);
    let heading = Angle::of(accepted.end().metres()).to_degrees();
    assert!((heading - 40.0).abs() < 1e-3, "{heading}");
    assert_eq!(refused(&eastward(&[], 100.0, land(|x, _| x > 40.0), &minors()).1), Refused::Illegal);
}

#[test]
fn bridges_where_it_may() {
    let river = || land(|x, _| (4.0..44.0).contains(&x));
    let mut settings = minors();
    let standard = Constraints { turn_most: Angle::ZERO, ..Constraints::default() };
    assert_eq!(refused(&eastward(&[], 60.0, river(), &settings).1), Refused::Illegal);
    settings.constraints = Constraints { bridge: 50.0, ..standard }.into();
    let (graph, log) = eastward(&[(at(20.0, -50.0), at(20.0, 50.0))], 60.0, river(), &settings);
    let (accepted, outcome) = only(&log);
    assert_eq!((outcome, accepted.line.level), (Outcome::Bridged, 1));
    assert!((51.0..=53.5).contains(&accepted.end().metres().x), "{:?}", accepted.end());
    assert_eq!(graph.segment_count(), 2, "it passes over the street below");
    settings.constraints = Constraints { bridge: 35.0, ..standard }.into();
    assert_eq!(refused(&eastward(&[], 60.0, river(), &settings).1), Refused::Illegal);
}

#[test]
fn what_leads_over_water_is_wanted_for_its_far_end() {
    let river = || land(|x, _| (4.0..44.0).contains(&x));
    // Nobody lives on the river; on the far side some do, or none.
    let people = |far: f32| {
        let values = (0..160_000).map(|i| match i % 400 {
            0..204 => 100.0,
            244.. => far,
            _ => 0.0,
        });
        let raster = Raster::new(400, 400, 1.0, Vec2::splat(-200.0), values.collect()).unwrap();
        Goal::of(Field::Map(Arc::new(raster)), 50.0, 0.0)
    };
    let mut settings = minors();
    settings.constraints = Constraints { bridge: 50.0, turn_most: Angle::ZERO, ..Constraints::default() }.into();
    settings.goal = people(100.0);
    assert_eq!(only(&eastward(&[], 30.0, river(), &settings).1).1, Outcome::Bridged);
    settings.goal = people(0.0);
    assert_eq!(refused(&eastward(&[], 30.0, river(), &settings).1), Refused::NoDemand);
    // Without a bridge the end in the water is wanted by nobody.
    settings.goal = people(100.0);
    settings.constraints = Constraints { turn_most: Angle::ZERO, ..Constraints::default() }.into();
    assert!(eastward(&[], 30.0, river(), &settings).1.accepted.is_empty());
}

#[test]
fn keeps_off_steep_ground() {
    let values = (0..160_000).map(|i| ((i % 400) as f32 - 200.0).max(0.0) * 0.2).collect();
    let raster = Raster::new(400, 400, 1.0, Vec2::splat(-200.0), values).unwrap();
    let fields = || Fields { elevation: Field::Map(Arc::new(raster.clone())), ..site(200.0) };
    let mut settings = minors();
    settings.constraints = Constraints { max_slope: 0.21, ..Constraints::default() }.into();
    assert_eq!(only(&eastward(&[], 100.0, fields(), &settings).1).1, Outcome::As);
    settings.constraints = Constraints { max_slope: 0.15, ..Constraints::default() }.into();
    // 0.2 · cos 50° = 0.129 is gentle enough, 0.2 · cos 40° = 0.153 is not.
    let log = eastward(&[], 100.0, fields(), &settings).1;
    let heading = Angle::of(only(&log).0.end().metres()).to_degrees();
    assert!((heading - 50.0).abs() < 1e-3, "{heading}");
}

#[test]
fn nothing_grows_into_water() {
    let pond =
        |x: f64, y: f64| (x - 40.0) * (x - 40.0) + (y + 30.0) * (y + 30.0) < 70.0 * 70.0 || (y > 150.0 && x > 0.0);
    let fields = shared(land(pond));
    let settings = minors();
    let seed = settings.seed_point(at(-150.0, 20.0), Angle::ZERO, 0);
    for pattern in 0..2 {
        let mut graph = StreetGraph::new(Classes::default());
        let log = match pattern {
            0 => grow(&mut graph, &settings, &winding(), &fields, &[seed], &never),
            _ => grow(&mut graph, &settings, &grid(Angle::degrees(15.0), 60.0, 40.0), &fields, &[seed], &never),
        };
        assert!(log.accepted.len() > 15, "{}", log.accepted.len());
        assert_planar(&graph);
        for (key, _) in graph.segments_unsorted() {
            let (a, b) = graph.line(key.forward());
            let (a, b) = (a.metres(), b.metres());
            let wet = (0..=200).filter(|&i| !fields.is_legal(a.lerp(b, f64::from(i) / 200.0))).count();
            assert!(wet <= 4, "{a} {b}: {wet} of 200 samples are wet");
        }
    }
}

#[test]
fn refused_proposals_are_recorded_on_demand() {
    let mut settings = minors();
    settings.records_refusals = true;
    let log = eastward(&[(at(5.0, -50.0), at(5.0, 50.0))], 100.0, site(500.0), &settings).1;
    assert_eq!(log.refused.len(), 1);
    let refused = &log.refused[0];
    assert_eq!((refused.from, refused.to, refused.reason), (at(0.0, 0.0), at(100.0, 0.0), Refused::TooShort));
}
