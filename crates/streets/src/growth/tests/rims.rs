//! Random chains in quarters that share a rim: what constraints promise holds on the final graph, at rims too (V25), measured
//! by brute force that shares no code with the kernel.

use super::kept::{MOVED, SIDE, chain, ground, is_inside, longest_run, steepest};
use super::support::{assert_planar, at, grid, minors, never, quarter_at, shared, street, winding};
use crate::graph::CheckLevel;
use crate::growth::{
    Chain, Constrain, Draft, Fields, GrowthRules, Keeps, Legal, MergeLog, Own, QuarterGrowth, QuarterSettings, Refused,
    Slope, Step, attach, grow_quarter,
};
use crate::{Classes, HalfKey, NodeId, NodeKey, StreetGraph, StreetId};
use geom::{Angle, Point, Vec2};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Two quarters whose common rim is a bent major.
fn two_quarters(bend: f64, slant: f64) -> StreetGraph {
    let far = SIDE - 15.0;
    let (a, b, c, d) = (at(-far, -far), at(far, -far), at(far, far), at(-far, far));
    let (foot, knee, head) = (at(0.0, -far), at(bend, 0.0), at(slant, far));
    let sides = [
        (1, a, foot),
        (1, foot, b),
        (2, b, c),
        (3, c, head),
        (3, head, d),
        (4, d, a),
        (5, foot, knee),
        (5, knee, head),
    ];
    let mut graph = StreetGraph::new(Classes::default());
    for (name, from, to) in sides {
        street(&mut graph, Classes::MAJOR, name, from, to);
    }
    graph
}

fn filled(
    graph: &StreetGraph,
    chains: [&Chain; 2],
    fields: &Arc<Fields>,
    rules: &dyn GrowthRules,
    chance: u64,
) -> Vec<QuarterGrowth> {
    let places = [at(-SIDE + 20.0, 0.0), at(SIDE - 20.0, 0.0)];
    let fill = |(place, chain): (_, &Chain)| {
        let mut settings = QuarterSettings::new(minors());
        settings.growth.constraints = chain.clone();
        (settings.growth.seed, settings.growth.limits.segments) = (geom::Seed(chance), 120);
        grow_quarter(graph, &quarter_at(graph, place), &settings, rules, fields, &never)
    };
    places.into_iter().zip(chains).map(fill).collect()
}

fn merged(graph: &StreetGraph, growths: &[QuarterGrowth]) -> (StreetGraph, MergeLog) {
    let mut merged = graph.clone();
    let log = attach(&mut merged, growths, &never);
    (merged, log)
}

/// Pieces of minor on the ground.
fn lines(graph: &StreetGraph) -> Vec<(Vec2, Vec2)> {
    let minors =
        graph.segments_unsorted().filter(|(_, segment)| segment.level == 0 && segment.class() == Classes::MINOR);
    minors.map(|(key, _)| graph.line(key.forward())).map(|(a, b)| (a.metres(), b.metres())).collect()
}

fn is_minor(graph: &StreetGraph, arm: HalfKey) -> bool {
    graph.segment(arm.segment()).class() == Classes::MINOR
}

/// The least angle at a node between a minor and any other street, in degrees.
fn least_angle_at(graph: &StreetGraph, node: NodeKey) -> f64 {
    let arms = graph.halves_ccw(node);
    let mut least = f64::INFINITY;
    for (i, &one) in arms.iter().enumerate() {
        for &other in arms[i + 1..].iter().filter(|&&other| is_minor(graph, one) || is_minor(graph, other)) {
            let [u, v] = [one, other].map(|arm| graph.line(arm)).map(|(a, b)| Angle::of(b.metres() - a.metres()));
            least = least.min((u - v).wrapped().abs().to_degrees());
        }
    }
    least
}

fn check(step: &Step, graph: &StreetGraph, fields: &Fields) {
    match step {
        Step::Legal(_) => {
            for line in lines(graph) {
                let run = longest_run(line, |p| !fields.is_legal(p));
                assert!(run <= 5.0 + MOVED, "{line:?}: {run} m off the legal area");
            }
        }
        Step::Mask(area) => {
            for line in lines(graph) {
                let run = longest_run(line, |p| !is_inside(area, fields, p));
                assert!(run <= 1.25 + MOVED, "{line:?}: {run} m outside the mask");
            }
        }
        Step::Slope(slope) => {
            for line in lines(graph).into_iter().filter(|(a, b)| (*b - *a).length() > 5.0) {
                let grade = steepest(line, &fields.elevation);
                assert!(grade <= slope.most + 0.02, "{line:?}: {grade} is steeper than {}", slope.most);
            }
        }
        Step::Angle(least) => {
            for (node, _) in graph.nodes_unsorted() {
                let angle = least_angle_at(graph, node);
                assert!(angle >= least.to_degrees() - 1.0, "{angle}° of {least:?} at {}", graph.at(node).metres());
            }
        }
        Step::Arms(most) => {
            for (key, node) in graph.nodes_unsorted() {
                let has_minor = graph.halves_ccw(key).iter().any(|&arm| is_minor(graph, arm));
                let arms = graph.degree(key);
                assert!(!has_minor || arms <= *most as usize, "{arms} arms at {}", node.at.metres());
            }
        }
        _ => {}
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn what_a_chain_holds_is_kept_at_rims(chain in chain(), fields in ground(), chance in any::<u64>(), is_raster in any::<bool>(),
                                          heading in 0.0f64..90.0, bend in -60.0f64..60.0, slant in -60.0f64..60.0) {
        let fields = shared(fields);
        let raster = grid(Angle::degrees(heading), 80.0, 50.0);
        let rules: &dyn GrowthRules = if is_raster { &raster } else { &winding() };
        let graph = two_quarters(bend, slant);
        let growths = filled(&graph, [&chain, &chain], &fields, rules, chance);
        let (merged, log) = merged(&graph, &growths);
        assert_planar(&merged);
        prop_assert_eq!(merged.check(CheckLevel::Sweep), Vec::new());
        for step in chain.steps() {
            check(step, &merged, &fields);
        }
        // Nothing is left out but what the log tells of.
        let grown: usize = growths.iter().map(|growth| growth.log.accepted.len()).sum();
        let left_out = log.dropped.iter().filter(|dropped| !dropped.is_shortened).count();
        prop_assert_eq!(log.laid + left_out, grown);
    }
}

/// A constraint of one's own that lets no street end in a band around the common rim but where it grew.
#[derive(Debug)]
struct Nowhere;

impl Constrain for Nowhere {
    fn constrain(&self, draft: &mut Draft) {
        if draft.to.y > 0.0 && draft.meets_street {
            draft.refuse("not here".into());
        }
    }
}

/// A constraint of one's own that agrees to all and keeps the length of the shortest it was asked of, in millimetres.
#[derive(Debug)]
struct Shortest(AtomicU64);

impl Constrain for Shortest {
    fn constrain(&self, draft: &mut Draft) {
        self.0.fetch_min((draft.length() * 1000.0) as u64, Ordering::Relaxed);
    }
}

#[test]
fn tests_before_a_rule_of_ones_own_are_made_before_it_is_asked() {
    let fields = shared(super::support::site(SIDE));
    let graph = two_quarters(20.0, 0.0);
    let (plain, least) = (Chain::default(), Chain::default().length().least);
    let shortest = |is_last: bool| {
        let own = Arc::new(Shortest(AtomicU64::new(u64::MAX)));
        let step = Step::Own(Own(own.clone()));
        let is_test =
            |step: &&Step| matches!(step, Step::Length(_) | Step::Duplicate(_) | Step::Angle(_) | Step::Arms(_));
        let (tests, others): (Vec<_>, Vec<_>) = plain.steps().iter().partition(is_test);
        let (first, then) = if is_last { (vec![], vec![step]) } else { (vec![step], vec![]) };
        let steps = others.into_iter().cloned().chain(first).chain(tests.into_iter().cloned()).chain(then);
        let chain = Chain::new(steps.collect());
        let growths = filled(&graph, [&chain, &chain], &fields, &winding(), 1);
        let shortest = own.0.load(Ordering::Relaxed) as f64 / 1000.0;
        (shortest, growths.into_iter().map(|growth| growth.log.accepted).collect::<Vec<_>>())
    };
    let ((last, laid), (first, same)) = (shortest(true), shortest(false));
    assert!(first < least && least <= last + 0.1, "{first} {least} {last}");
    assert!(!laid.is_empty() && laid == same, "what agrees to all lays the same");
}

/// What a chain says without streets over, under or across a rim, nor at angles below those of grown streets.
fn staying(chain: &Chain) -> Chain {
    let least = geom::tolerance::LEAST_GROWN_ANGLE_DEG;
    let at_least = |angle: Angle| Step::Angle(Angle::degrees(angle.to_degrees().max(least)));
    let staying = chain.steps().iter().cloned().map(|step| match step {
        Step::Legal(legal) => Step::Legal(Legal { bridge: None, ..legal }),
        Step::Slope(slope) => Step::Slope(Slope { tunnel: 0.0, ..slope }),
        Step::Angle(angle) => at_least(angle),
        step => step,
    });
    let mut steps = vec![Step::Crossing];
    steps.extend(staying.filter(|step| *step != Step::Crossing));
    if !steps.iter().any(|step| matches!(step, Step::Angle(_))) {
        steps.push(at_least(Angle::ZERO));
    }
    Chain::new(steps)
}

/// The pieces of the streets that grew in a quarter: whose, of what crossings, where.
fn pieces(graph: &StreetGraph, growth: &QuarterGrowth) -> BTreeSet<(StreetId, [(NodeId, Point); 2])> {
    let streets: BTreeSet<_> = growth.log.accepted.iter().map(|accepted| accepted.lineage.street).collect();
    let end = |node| (graph.node(node).id, graph.at(node));
    let all = graph.segments_unsorted().map(|(key, segment)| {
        let half = if segment.leading().forward { key.forward() } else { key.backward() };
        (segment.leading().street, [end(graph.origin(half)), end(graph.target(half))])
    });
    all.filter(|(street, _)| streets.contains(street)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever grows on the other side of a rim, by whatever rules, or nothing: no byte of a quarter's streets differs.
    #[test]
    fn no_quarter_feels_another(one in chain(), other in chain(), fields in ground(), chance in any::<u64>(), is_raster in any::<[bool; 2]>(),
                                heading in 0.0f64..90.0, bend in -60.0f64..60.0, slant in -60.0f64..60.0) {
        let fields = shared(fields);
        let (raster, winding) = (grid(Angle::degrees(heading), 80.0, 50.0), winding());
        let rules = |is_raster: bool| if is_raster { &raster as &dyn GrowthRules } else { &winding };
        let (one, other) = (staying(&one), staying(&other));
        let mut graph = two_quarters(bend, slant);
        // A major of the east that meets the rim, unseen from the west.
        let foot = graph.nearest_segment(at(bend / 2.0 + 1.0, -150.0), 100 * 1024, 0).unwrap().1;
        street(&mut graph, Classes::MAJOR, 9, at(110.0, -140.0), foot);
        let [west, _] = &filled(&graph, [&one, &one], &fields, rules(is_raster[0]), chance)[..] else { unreachable!() };
        let neighbours = [(&one, is_raster[0], chance), (&one, is_raster[0], chance ^ 1), (&other, is_raster[1], chance)];
        let mut neighbours: Vec<_> = neighbours
            .into_iter()
            .map(|(chain, is_raster, chance)| filled(&graph, [chain, chain], &fields, rules(is_raster), chance).swap_remove(1))
            .collect();
        let mut left = neighbours[0].clone();
        (left.log.accepted, left.attachments) = (Vec::new(), Vec::new());
        neighbours.push(left);
        let mut seen = neighbours.iter().map(|east| {
            let (merged, log) = merged(&graph, &[west.clone(), east.clone()]);
            let dropped: Vec<_> = log.dropped.into_iter().filter(|dropped| dropped.quarter == west.quarter).collect();
            (pieces(&merged, west), dropped)
        });
        let first = seen.next().unwrap();
        for other in seen {
            prop_assert_eq!(&first.1, &other.1);
            let differing: Vec<_> = first.0.symmetric_difference(&other.0).collect();
            prop_assert_eq!(differing, Vec::<&(StreetId, [(NodeId, Point); 2])>::new());
        }
    }
}

/// Streets of the west that come to the rim 3 m from where majors of the east do.
fn offset(chain: &Chain, fields: &Arc<Fields>) -> (StreetGraph, Vec<QuarterGrowth>) {
    let mut graph = two_quarters(0.0, 0.0);
    for (name, y) in [(6, -147.0), (7, -47.0), (8, 53.0), (9, 153.0)] {
        street(&mut graph, Classes::MAJOR, name, at(100.0, y), at(0.0, y));
    }
    let mut growths = filled(&graph, [chain, chain], fields, &grid(Angle::ZERO, 80.0, 50.0), 1);
    growths.truncate(1);
    (graph, growths)
}

#[test]
fn a_street_is_led_to_a_crossing_only_where_its_own_rules_agree() {
    let fields = shared(super::support::site(SIDE));
    let plain = Chain::default();
    let (graph, growths) = offset(&plain, &fields);
    let (_, free) = merged(&graph, &growths);
    assert!(free.moved >= 2 && free.dropped.is_empty(), "{free:?}");
    let own = plain.with(Step::Own(Own(Arc::new(Nowhere))));
    let forbidden = |growth: &QuarterGrowth| {
        let keeps = Keeps { constraints: own.clone(), ..growth.keeps.clone() };
        QuarterGrowth { keeps, ..growth.clone() }
    };
    let growths: Vec<_> = growths.iter().map(forbidden).collect();
    let (_, bound) = merged(&graph, &growths);
    assert!(bound.moved < free.moved && bound.moved > 0, "{} of {}", bound.moved, free.moved);
    assert_eq!(bound.laid, free.laid);
}

#[test]
fn a_street_that_would_be_one_too_many_stops_before_the_rim() {
    let fields = shared(super::support::site(SIDE));
    let chain = Chain::default().with(Step::Arms(3));
    let graph = two_quarters(0.0, 0.0);
    // Rasters line up: both sides come to the same places of the rim.
    let four = grid(Angle::ZERO, 80.0, 50.0);
    let growths = filled(&graph, [&chain, &chain], &fields, &four, 1);
    let (merged, log) = merged(&graph, &growths);
    check(&Step::Arms(3), &merged, &fields);
    let full: Vec<_> = log.dropped.iter().filter(|dropped| dropped.reason == Refused::Full).collect();
    assert!(!full.is_empty(), "{log:?}");
}
