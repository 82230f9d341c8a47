//! Shores and mountains: streets that follow a coast, bridges, tunnels, hairpins.

use super::adjusting::{eastward, land, only, refused};
use super::support::{Rule, assert_planar, at, minors, never, shared, site, slot};
use crate::growth::{
    Bridge, Chain, Constraints, Field, Fields, Growth, GrowthLog, Legal, Outcome, Over, Refused, Slope, Step, Tip,
    TurnSearch, grow,
};
use crate::{Classes, StreetGraph};
use geom::{Angle, Raster, Vec2};
use std::sync::Arc;

fn turns(step: f64, most: f64) -> TurnSearch {
    TurnSearch { step: Angle::degrees(step), most: Angle::degrees(most) }
}

fn with(changed: impl Fn(Step) -> Step) -> Growth {
    let steps = Chain::default().steps().iter().cloned().map(changed).collect();
    Growth { constraints: Chain::new(steps), ..minors() }
}

fn with_legal(legal: Legal) -> Growth {
    with(|step| if let Step::Legal(_) = step { Step::Legal(legal) } else { step })
}

fn with_slope(slope: Slope) -> Growth {
    with(|step| if let Step::Slope(_) = step { Step::Slope(slope) } else { step })
}

const BRIDGE: Bridge = Bridge { longest: 120.0, spacing: 150.0, over: Over::Water, is_first: true };

fn legal(bridge: Option<Bridge>) -> Legal {
    Legal { prune: 0.5, turns: turns(2.0, 80.0), turns_first: true, bridge }
}

/// The shore of a winding coast: water south of it.
fn shore(x: f64) -> f64 {
    60.0 * Angle::radians(x / 180.0).sin()
}

/// A site of 2 km × 2 km in cells of 5 m, whose sea lies south of the shore.
fn coast() -> Fields {
    let cell = |i: usize| ((i % 400) as f64 * 5.0 - 997.5, 997.5 - (i / 400) as f64 * 5.0);
    let values = (0..160_000).map(cell).map(|(x, y)| if y < shore(x) { 0.0 } else { 1.0 }).collect();
    let land = Arc::new(Raster::new(400, 400, 5.0, Vec2::splat(-1000.0), values).unwrap());
    Fields { legal: vec![land.clone()], land: Some(land), ..site(1000.0) }
}

/// A street that wants to go south-east, whatever it is turned to: it meets the coast and follows it.
fn along_the_coast(settings: &Growth) -> GrowthLog {
    let rules = Rule(|tip: &mut Tip| {
        if tip.age < 30 && !(tip.is_seed && tip.age > 0) {
            tip.slots.ahead = slot(60.0);
        }
    });
    let mut graph = StreetGraph::new(Classes::default());
    let seed = settings.seed_point(at(-800.0, 150.0), Angle::degrees(-40.0), 0);
    let log = grow(&mut graph, settings, &rules, &shared(coast()), &[seed], &never);
    assert_planar(&graph);
    log
}

#[test]
fn streets_follow_the_shore() {
    let log = along_the_coast(&with_legal(legal(None)));
    let (mut near, mut along) = (0.0, 0.0);
    for accepted in &log.accepted {
        let (a, b) = (accepted.start().metres(), accepted.end().metres());
        let middle = (a + b) / 2.0;
        if middle.y - shore(middle.x) > 150.0 || middle.x < -750.0 {
            continue;
        }
        near += (b - a).length();
        let tangent = Vec2::new(1.0, (shore(middle.x + 1.0) - shore(middle.x - 1.0)) / 2.0).normalize();
        let apart = (b - a).normalize().perp_dot(tangent).abs();
        along += if apart < Angle::degrees(20.0).sin() { (b - a).length() } else { 0.0 };
    }
    assert!(near > 900.0, "{near} m near the water");
    assert!(along >= 0.75 * near, "{along} m of {near} m follow the shore");
}

/// A river of 80 m from south to north through x = 40 … 120, and a road along each side of it would meet it head-on.
fn river() -> Fields {
    let fields = land(|x, _| (40.0..120.0).contains(&x));
    Fields { land: fields.legal.first().cloned(), ..fields }
}

/// Streets that go east from the west bank, one every 40 m.
fn eastbound(settings: &Growth, fields: Fields, length: f64) -> (StreetGraph, GrowthLog) {
    let rules = Rule(move |tip: &mut Tip| tip.slots.ahead = if tip.age < 5 { slot(length) } else { None });
    let mut graph = StreetGraph::new(Classes::default());
    let seeds: Vec<_> =
        (0..9u64).map(|i| settings.seed_point(at(-60.0, -160.0 + 40.0 * i as f64), Angle::ZERO, i)).collect();
    let log = grow(&mut graph, settings, &rules, &shared(fields), &seeds, &never);
    assert_planar(&graph);
    (graph, log)
}

#[test]
fn bridges_start_at_the_shore_keep_apart_and_come_down_straight() {
    let (_, log) = eastbound(&with_legal(legal(Some(BRIDGE))), river(), 70.0);
    let bridges: Vec<_> = log.accepted.iter().filter(|accepted| accepted.line.level == 1).collect();
    assert_eq!(bridges.len(), 2, "360 m of shore, 150 m apart: {bridges:?}");
    for bridge in &bridges {
        let (a, b) = (bridge.start().metres(), bridge.end().metres());
        assert!((38.0..=40.0).contains(&a.x), "starts at {a}");
        assert!((126.0..=130.0).contains(&b.x) && (a.y - b.y).abs() < 0.01, "comes down at {b}");
    }
    let apart = (bridges[0].start().metres() - bridges[1].start().metres()).length();
    assert!(apart >= 150.0, "{apart}");
    let none = eastbound(&with_legal(legal(None)), river(), 70.0).1;
    assert!(none.accepted.iter().all(|accepted| accepted.line.level == 0));
}

#[test]
fn parks_are_bridged_only_when_asked() {
    let park = || {
        let fields = land(|x, _| (40.0..120.0).contains(&x));
        let park = fields.legal[0].map_values(|dry| 1.0 - dry).unwrap();
        Fields { legal: Vec::new(), barred: vec![Arc::new(park)], ..fields }
    };
    let bridged = |over| {
        let legal = Legal { turns: turns(2.0, 0.0), ..legal(Some(Bridge { over, ..BRIDGE })) };
        let log = eastbound(&with_legal(legal), park(), 70.0).1;
        log.accepted.iter().filter(|accepted| accepted.outcome == Outcome::Bridged).count()
    };
    assert_eq!(bridged(Over::Water), 0);
    assert!(bridged(Over::Any) >= 2);
}

/// 400 m × 400 m of 1 m cells with heights of x.
fn heights(height: impl Fn(f64) -> f64) -> Fields {
    let values = (0..160_000).map(|i| height(f64::from(i % 400) - 199.5) as f32).collect();
    let raster = Raster::new(400, 400, 1.0, Vec2::splat(-200.0), values).unwrap();
    Fields { elevation: Field::Map(Arc::new(raster)), ..site(200.0) }
}

#[test]
fn tunnels_go_through_ridges() {
    let ridge = || heights(|x: f64| (20.0 - (x - 60.0).abs() * 0.5).max(0.0));
    let slope = Slope { most: 0.1, turns: turns(5.0, 60.0), has_hairpins: false, tunnel: 0.0 };
    assert_eq!(refused(&eastward(&[], 70.0, ridge(), &with_slope(slope)).1), Refused::Steep);
    let tunnel = Slope { tunnel: 120.0, ..slope };
    // To the foot of the ridge first, at x = 20.
    let (accepted, outcome) = only_of(eastward(&[], 70.0, ridge(), &with_slope(tunnel)).1);
    assert!(outcome == Outcome::Shortened && (18.0..=20.0).contains(&accepted.x), "{accepted} {outcome:?}");
    let (_, log) = eastbound(&with_slope(tunnel), ridge(), 70.0);
    let tunnels: Vec<_> = log.accepted.iter().filter(|accepted| accepted.line.level == -1).collect();
    assert!(!tunnels.is_empty());
    for tunnel in tunnels {
        assert_eq!(tunnel.outcome, Outcome::Tunnelled);
        let (a, b) = (tunnel.start().metres(), tunnel.end().metres());
        let rise = (a.x.max(b.x) - 60.0).abs();
        assert!((b - a).length() <= 121.0 && rise < 50.0 && (a.x - 60.0).signum() != (b.x - 60.0).signum(), "{a} {b}");
    }
}

fn only_of(log: GrowthLog) -> (Vec2, Outcome) {
    let (accepted, outcome) = only(&log);
    (accepted.end().metres(), outcome)
}

#[test]
fn hairpins_climb_what_is_too_steep() {
    // A cone of 30 % all around but to the west: what comes up to it can only turn back.
    let wall = || heights(|x: f64| x.max(-150.0) * 0.3);
    let slope = Slope { most: 0.1, turns: turns(5.0, 60.0), has_hairpins: false, tunnel: 0.0 };
    // 0.3 · cos 60° = 0.15 is still too steep; 75° is the least turn that is not.
    assert_eq!(refused(&eastward(&[], 60.0, wall(), &with_slope(slope)).1), Refused::Steep);
    let (to, outcome) = only_of(eastward(&[], 60.0, wall(), &with_slope(Slope { has_hairpins: true, ..slope })).1);
    assert_eq!(outcome, Outcome::Turned);
    assert!((Angle::of(to).to_degrees().abs() - 75.0).abs() < 0.01, "{to}");
}

#[test]
fn the_map_of_values_bridges_over_water() {
    let standard = Constraints { bridge: 120.0, turn_most: Angle::ZERO, ..Constraints::default() };
    let settings = Growth { constraints: standard.into(), ..minors() };
    let (_, log) = eastbound(&settings, river(), 70.0);
    assert!(log.accepted.iter().any(|accepted| accepted.outcome == Outcome::Bridged));
}
