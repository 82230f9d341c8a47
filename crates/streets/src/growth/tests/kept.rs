//! Random chains on random ground: what constraints promise of every street laid holds on the final graph (V25), measured
//! by brute force that shares no code with the kernel.

use super::support::{assert_planar, at, grid, least_angle, minors, never, shared, site, winding};
use crate::graph::CheckLevel;
use crate::growth::{
    Area, Bridge, Chain, Duplicate, Extend, Field, Fields, Growth, GrowthLog, GrowthRules, Legal, Length, Over, Slope,
    Step, TurnSearch, grow,
};
use crate::{Classes, Districts, PerDistrict, StreetGraph};
use geom::{Angle, Bounds, Point, Polygon, Raster, Vec2};
use proptest::prelude::*;
use std::sync::Arc;

/// Half the side of the site, and the size of a map's cell, in metres.
pub(super) const SIDE: f64 = 300.0;
const CELL: f64 = 10.0;
const CELLS: usize = 60;

/// How far, in metres, insertion may move an end onto what lies there.
pub(super) const MOVED: f64 = 0.08;

fn raster(values: Vec<f32>) -> Arc<Raster> {
    Arc::new(Raster::new(CELLS, CELLS, CELL, Vec2::splat(-SIDE), values).unwrap())
}

/// Smooth heights, drawn by chance: cells between coarse ones of 6 × 6.
fn hills(coarse: &[f64], height: f64) -> Arc<Raster> {
    let coarse = coarse.iter().map(|value| (value * height) as f32).collect();
    let coarse = Raster::new(6, 6, CELL * 10.0, Vec2::splat(-SIDE), coarse).unwrap();
    let centre = |i: usize| Vec2::new((i % CELLS) as f64 + 0.5, (CELLS - 1 - i / CELLS) as f64 + 0.5) * CELL - SIDE;
    raster((0..CELLS * CELLS).map(|i| coarse.bilinear(centre(i)) as f32).collect())
}

/// Land around ponds: cells within a radius of places are wet; the middle is dry.
fn ponds(places: &[(f64, f64, f64)], value: f32) -> Arc<Raster> {
    let centre = |i: usize| Vec2::new((i % CELLS) as f64 + 0.5, (CELLS - 1 - i / CELLS) as f64 + 0.5) * CELL - SIDE;
    let is_wet = |p: Vec2| p.length() > 40.0 && places.iter().any(|&(x, y, r)| (p - Vec2::new(x, y)).length() < r);
    raster((0..CELLS * CELLS).map(|i| if is_wet(centre(i)) { 1.0 - value } else { value }).collect())
}

fn step() -> impl Strategy<Value = Step> {
    let turns = (2.0f64..20.0, 0.0f64..120.0)
        .prop_map(|(step, most)| TurnSearch { step: Angle::degrees(step), most: Angle::degrees(most) });
    let bridge =
        (20.0f64..150.0, 0.0f64..100.0, any::<bool>(), any::<bool>()).prop_map(|(longest, spacing, any, is_first)| {
            Bridge { longest, spacing, over: if any { Over::Any } else { Over::Water }, is_first }
        });
    let legal = (0.0f64..1.0, turns.clone(), any::<bool>(), prop::option::of(bridge));
    let slope = (0.03f64..0.4, turns, any::<bool>(), prop_oneof![Just(0.0), 40.0f64..200.0]);
    let corners = vec![at(-250.0, -200.0), at(280.0, -260.0), at(200.0, 270.0), at(0.0, 120.0), at(-270.0, 220.0)];
    let polygon = Arc::new(Polygon::new(corners, Vec::new()));
    prop_oneof![
        (0.0f64..15.0, 40.0f64..150.0).prop_map(|(least, longest)| Step::Length(Length { least, longest })),
        legal.prop_map(|(prune, turns, turns_first, bridge)| Step::Legal(Legal { prune, turns, turns_first, bridge })),
        slope.prop_map(|(most, turns, has_hairpins, tunnel)| Step::Slope(Slope { most, turns, has_hairpins, tunnel })),
        Just(Step::Crossing),
        (0.0f64..15.0).prop_map(Step::Snap),
        (1.0f64..1.6, 5.0f64..60.0).prop_map(|(factor, most)| Step::Extend(Extend { factor, most })),
        (0.0f64..15.0).prop_map(Step::Join),
        (2.0f64..12.0).prop_map(|within| Step::Duplicate(Duplicate { within, is_whole: true })),
        (5.0f64..45.0).prop_map(|degrees| Step::Angle(Angle::degrees(degrees))),
        (3u32..6).prop_map(Step::Arms),
        prop_oneof![Just(Step::Mask(Area::Polygon(polygon))), Just(Step::Mask(Area::Map("mask".into())))],
    ]
}

/// Steps in any order, each kind at most once.
pub(super) fn chain() -> impl Strategy<Value = Chain> {
    prop::collection::vec(step(), 0..14).prop_map(|steps| {
        let mut kept: Vec<Step> = Vec::new();
        for step in steps {
            if !kept.iter().any(|other| std::mem::discriminant(other) == std::mem::discriminant(&step)) {
                kept.push(step);
            }
        }
        Chain::new(kept)
    })
}

/// Another chain of the same kinds of steps, with values of others.
fn like(chain: &Chain, others: &[Step]) -> Chain {
    let same_kind =
        |step: &Step| others.iter().find(|other| std::mem::discriminant(*other) == std::mem::discriminant(step));
    let other = |step: &Step| if let Step::Mask(_) = step { None } else { same_kind(step).cloned() };
    Chain::new(chain.steps().iter().map(|step| other(step).unwrap_or_else(|| step.clone())).collect())
}

fn place() -> impl Strategy<Value = (f64, f64, f64)> {
    (-SIDE..SIDE, -SIDE..SIDE, 20.0f64..90.0)
}

pub(super) fn ground() -> impl Strategy<Value = Fields> {
    let heights = prop::collection::vec(0.0f64..1.0, 36);
    let places = || prop::collection::vec(place(), 0..5);
    (heights, 5.0f64..60.0, places(), places(), places()).prop_map(|(heights, height, water, parks, mask)| {
        let land = ponds(&water, 1.0);
        Fields {
            legal: vec![land.clone()],
            land: Some(land),
            barred: vec![ponds(&parks, 0.0)],
            elevation: Field::Map(hills(&heights, height)),
            maps: [("mask".to_owned(), Field::Map(ponds(&mask, 1.0)))].into(),
            ..site(SIDE)
        }
    })
}

fn grown(chain: Chain, fields: &Arc<Fields>, rules: &dyn GrowthRules, chance: u64) -> (StreetGraph, GrowthLog) {
    let mut graph = StreetGraph::new(Classes::default());
    let mut settings = Growth { constraints: chain, ..minors() };
    (settings.seed, settings.limits.segments) = (geom::Seed(chance), 160);
    let seed = settings.seed_point(at(1.0, -2.0), Angle::degrees(17.0), 0);
    let log = grow(&mut graph, &settings, rules, fields, &[seed], &never);
    (graph, log)
}

/// Lines on the ground, and those above or below it.
fn lines(graph: &StreetGraph, is_on_ground: bool) -> Vec<(Vec2, Vec2)> {
    let segments = graph.segments_unsorted().filter(|(_, segment)| (segment.level == 0) == is_on_ground);
    segments.map(|(key, _)| graph.line(key.forward())).map(|(a, b)| (a.metres(), b.metres())).collect()
}

/// Whether a place belongs to a mask.
pub(super) fn is_inside(area: &Area, fields: &Fields, p: Vec2) -> bool {
    match area {
        Area::Polygon(polygon) => polygon.contains(Point::from_metres(p)),
        Area::Map(name) => {
            fields.maps[&**name].at(p) > 0.5 || matches!(&fields.maps[&**name], Field::Map(map) if map.mask(p))
        }
    }
}

/// The longest stretch of a line, in metres, where something holds at every step of 25 cm.
pub(super) fn longest_run((a, b): (Vec2, Vec2), holds: impl Fn(Vec2) -> bool) -> f64 {
    let steps = ((b - a).length() / 0.25).ceil().max(1.0) as u32;
    let (mut run, mut longest) = (0u32, 0);
    for i in 0..=steps {
        run = if holds(a.lerp(b, f64::from(i) / f64::from(steps))) { run + 1 } else { 0 };
        longest = run.max(longest);
    }
    (f64::from(longest.max(1)) - 1.0) * 0.25
}

/// The steepest place of a line: over steps of 5 cm.
pub(super) fn steepest((a, b): (Vec2, Vec2), elevation: &Field) -> f64 {
    let steps = ((b - a).length() / 0.05).ceil().max(1.0) as u32;
    let height = |i: u32| elevation.at(a.lerp(b, f64::from(i) / f64::from(steps)));
    let rise = (0..steps).map(|i| (height(i + 1) - height(i)).abs()).fold(0.0, f64::max);
    rise / ((b - a).length() / f64::from(steps))
}

/// Whether two lines cut, by the cross products of floats.
fn is_cut((a, b): (Vec2, Vec2), (c, d): (Vec2, Vec2)) -> bool {
    let (u, v, w) = (b - a, d - c, c - a);
    let cross = u.perp_dot(v);
    let (s, t) = (w.perp_dot(v) / cross, w.perp_dot(u) / cross);
    (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)
}

/// How far a place lies from a line.
fn distance(p: Vec2, (a, b): (Vec2, Vec2)) -> f64 {
    let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    (p - a.lerp(b, share)).length()
}

fn check(step: &Step, graph: &StreetGraph, log: &GrowthLog, fields: &Fields) {
    let laid: Vec<(Vec2, Vec2, i8)> =
        log.accepted.iter().map(|a| (a.start().metres(), a.end().metres(), a.line.level)).collect();
    match step {
        Step::Length(length) => {
            for &(a, b, _) in &laid {
                assert!((b - a).length() >= length.least - 2.0 * MOVED, "{a} {b} is too short");
            }
        }
        // Samples lie 5 m apart at most: no longer stretch is off the legal area.
        Step::Legal(_) => {
            for line in lines(graph, true) {
                let run = longest_run(line, |p| !fields.is_legal(p));
                assert!(run <= 5.0 + MOVED, "{line:?}: {run} m off the legal area");
            }
            for (a, b) in lines(graph, false) {
                assert!(fields.is_legal(a) && fields.is_legal(b), "a bridge ends off the legal area");
            }
        }
        Step::Mask(area) => {
            for line in lines(graph, true) {
                let run = longest_run(line, |p| !is_inside(area, fields, p));
                assert!(run <= 1.25 + MOVED, "{line:?}: {run} m outside the mask");
            }
        }
        // Ends that insertion moves by up to 8 cm turn a street of 5 m by 0.9°, on slopes of at most 1.
        Step::Slope(slope) => {
            for line in lines(graph, true).into_iter().filter(|(a, b)| (*b - *a).length() > 5.0) {
                let grade = steepest(line, &fields.elevation);
                assert!(grade <= slope.most + 0.02, "{line:?}: {grade} is steeper than {}", slope.most);
            }
            for (a, b) in lines(graph, false) {
                let grade = (fields.elevation.at(b) - fields.elevation.at(a)).abs() / (b - a).length();
                assert!(grade <= slope.most + 0.02, "{a} {b}: {grade} is steeper than {}", slope.most);
            }
        }
        // A street that crosses another ends there: no two cut each other but at an end of one.
        Step::Crossing => {
            for (i, &(a, b, _)) in laid.iter().enumerate().filter(|(_, line)| line.2 == 0) {
                for &(c, d, _) in laid[..i].iter().filter(|line| line.2 == 0) {
                    if is_cut((a, b), (c, d)) {
                        let is_end = [a, b].iter().any(|&end| distance(end, (c, d)) < MOVED)
                            || [c, d].iter().any(|&end| distance(end, (a, b)) < MOVED);
                        assert!(is_end, "{a} {b} crosses {c} {d}");
                    }
                }
            }
        }
        Step::Duplicate(Duplicate { within, .. }) => {
            for (i, &(a, b, _)) in laid.iter().enumerate().filter(|(_, line)| line.2 == 0) {
                for &(c, d, _) in laid[..i].iter().filter(|line| line.2 == 0) {
                    let beside = beside((a, b), (c, d), within.max(4.0) - 2.0 * MOVED);
                    assert!(beside <= 0.51, "{a} {b} runs along {c} {d}: {beside}");
                }
            }
        }
        // Insertion leads what passes closer than 8 cm through a crossing.
        Step::Angle(least) => {
            assert!(least_angle(graph) >= least.to_degrees() - 1.0, "{} {least:?}", least_angle(graph));
        }
        Step::Arms(most) => {
            for (key, node) in graph.nodes_unsorted() {
                assert!(graph.degree(key) <= *most as usize, "{} arms at {}", graph.degree(key), node.at.metres());
            }
        }
        Step::Snap(_) | Step::Extend(_) | Step::Join(_) | Step::Own(_) => {}
    }
}

/// The share of the shorter of two near-parallel lines that lies within a width of the other, at steps of 1 %.
fn beside(one: (Vec2, Vec2), other: (Vec2, Vec2), width: f64) -> f64 {
    let (u, v) = (one.1 - one.0, other.1 - other.0);
    if u.perp_dot(v).abs() >= 0.349 * u.length() * v.length() {
        return 0.0;
    }
    let (short, long) = if u.length() <= v.length() { (one, other) } else { (other, one) };
    let along = (long.1 - long.0).normalize();
    let lies_beside = |p: Vec2| {
        let (ahead, aside) = ((p - long.0).dot(along), along.perp_dot(p - long.0));
        ahead >= 0.0 && ahead <= (long.1 - long.0).length() && aside.abs() < width
    };
    let count = (0..=100).filter(|&i| lies_beside(short.0.lerp(short.1, f64::from(i) / 100.0))).count();
    count as f64 / 101.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn what_a_chain_holds_is_kept(chain in chain(), fields in ground(), chance in any::<u64>(), is_raster in any::<bool>(),
                                  heading in 0.0f64..90.0) {
        let fields = shared(fields);
        let raster = grid(Angle::degrees(heading), 90.0, 60.0);
        let rules: &dyn GrowthRules = if is_raster { &raster } else { &winding() };
        let (graph, log) = grown(chain.clone(), &fields, rules, chance);
        assert_planar(&graph);
        prop_assert_eq!(graph.check(CheckLevel::Sweep), Vec::new());
        for step in chain.steps() {
            check(step, &graph, &log, &fields);
        }
    }

    #[test]
    fn a_district_that_is_everywhere_is_as_none(chain in chain(), others in prop::collection::vec(step(), 30),
                                                fields in ground(), chance in any::<u64>()) {
        let fields = shared(fields);
        let other = like(&chain, &others);
        let all = Polygon::rectangle(Bounds::between(at(-SIDE - 9.0, -SIDE - 9.0), at(SIDE + 9.0, SIDE + 9.0)));
        let districts = Arc::new(Districts::of_areas(vec!["all".into()], vec![(0, all)]));
        let in_districts = PerDistrict::new(districts, |_| Some(other.clone()), chain.clone());
        let mixed = chain.in_districts(in_districts).expect("the same kinds of steps");
        let laid = |chain: Chain| -> Vec<(Point, Point, i8)> {
            let (_, log) = grown(chain, &fields, &winding(), chance);
            log.accepted.iter().map(|a| (a.start(), a.end(), a.line.level)).collect()
        };
        prop_assert_eq!(laid(mixed), laid(other));
    }

    #[test]
    fn any_order_is_as_valid(chain in chain(), fields in ground(), chance in any::<u64>(), rotation in 0usize..14) {
        let fields = shared(fields);
        let mut steps = chain.steps().to_vec();
        let count = steps.len().max(1);
        steps.rotate_left(rotation % count);
        steps.reverse();
        let (graph, log) = grown(Chain::new(steps), &fields, &winding(), chance);
        for step in chain.steps() {
            check(step, &graph, &log, &fields);
        }
    }
}
