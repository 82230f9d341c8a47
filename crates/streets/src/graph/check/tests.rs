//! The checker is checked by corruption: each kind is found, by both levels alike, and nothing on valid graphs.

use super::*;
use crate::faces::samples::{Line, Sketch, draw, street};
use geom::{Id, Seed};
use proptest::prelude::*;
use smallvec::smallvec;

fn sample(seed: u64) -> StreetGraph {
    Sketch::random(Seed(seed), 6, 0.8, 700, 0).build(Seed(seed))
}

/// What is found, by both levels, which must agree.
fn breaches(graph: &StreetGraph) -> Vec<Breach> {
    let (sweep, brute) = (graph.check(CheckLevel::Sweep), graph.check(CheckLevel::Brute));
    assert_eq!(sweep, brute);
    sweep.into_iter().map(|violation| violation.breach).collect()
}

fn any_node(graph: &StreetGraph, seed: u64) -> NodeKey {
    let nodes: Vec<_> = graph.nodes_unsorted().filter(|(_, node)| node.arms.len() > 1).map(|(key, _)| key).collect();
    nodes[draw(Seed(seed), 77, nodes.len())]
}

fn any_segment(graph: &StreetGraph, seed: u64) -> SegmentKey {
    let segments: Vec<_> = graph.segments_unsorted().map(|(key, _)| key).collect();
    segments[draw(Seed(seed), 78, segments.len())]
}

fn node_mut(graph: &mut StreetGraph, key: NodeKey) -> &mut crate::graph::Node {
    graph.nodes[key.0 as usize].as_mut().unwrap()
}

fn segment_mut(graph: &mut StreetGraph, key: SegmentKey) -> &mut Segment {
    graph.segments[key.0 as usize].as_mut().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn valid_graphs_are_clean(seed: u64, size in 1usize..8, keep in 0.1f64..1.0, names in 0usize..3) {
        let graph = Sketch::random(Seed(seed), size, keep, 700, names).build(Seed(seed));
        prop_assert_eq!(breaches(&graph), []);
        let nodes = graph.nodes_by_id();
        prop_assert_eq!(graph.check_touched(&nodes, &graph.segments_by_id()), []);
    }

    #[test]
    fn levels_agree_on_nodes_moved_anywhere(seed: u64, moves in prop::collection::vec((0usize..1000, -6000i32..6000, -6000i32..6000), 1..4)) {
        let mut graph = sample(seed);
        let nodes = graph.nodes_by_id();
        for (i, dx, dy) in moves {
            let node = node_mut(&mut graph, nodes[i % nodes.len()]);
            node.at = Point::new(node.at.x + dx, node.at.y + dy);
        }
        breaches(&graph);
    }

    #[test]
    fn a_node_near_another_is_found(seed: u64, dx in -40i32..40, dy in -40i32..40) {
        let mut graph = sample(seed);
        let (moved, other) = (any_node(&graph, seed), any_node(&graph, seed.wrapping_add(1)));
        prop_assume!(moved != other);
        let at = graph.at(other);
        node_mut(&mut graph, moved).at = Point::new(at.x + dx, at.y + dy);
        prop_assert!(breaches(&graph).contains(&Breach::NodesClose));
        prop_assert!(graph.check_touched(&[moved], &[]).iter().any(|v| v.breach == Breach::NodesClose && v.measured < 0.0625));
    }

    #[test]
    fn a_node_near_a_segment_is_found(seed: u64, off in 0i32..63) {
        let mut graph = sample(seed);
        let (a, b) = graph.line(any_segment(&graph, seed).forward());
        let (dx, dy) = a.to(b);
        let side = if dx.abs() > dy.abs() { (0, off) } else { (off, 0) };
        let at = Point::new((a.x + b.x) / 2 + side.0, (a.y + b.y) / 2 + side.1);
        let id = NodeId(Id::root("loose", &[]));
        let node = graph.add_node(id, at, street(0));
        let far = graph.add_node(NodeId(id.0.child(1)), Point::new(1 << 20, 1 << 20), street(0));
        graph.add_segment([node, far], 3, smallvec![*graph.segment(any_segment(&graph, seed)).leading()]);
        prop_assert_eq!(breaches(&graph), [Breach::NodeAtSegment], "the bridge is clear, its end is not");
        prop_assert_eq!(graph.check_touched(&[node], &[]).len(), 1);
    }

    #[test]
    fn a_segment_across_others_is_found(seed: u64) {
        let mut graph = sample(seed);
        let nodes = graph.nodes_by_id();
        let low = *nodes.iter().min_by_key(|&&key| graph.at(key)).unwrap();
        let high = *nodes.iter().max_by_key(|&&key| graph.at(key)).unwrap();
        let claim = *graph.segment(any_segment(&graph, seed)).leading();
        let (a, b) = (graph.at(low), graph.at(high));
        let lines: Vec<_> = graph.segments_unsorted().map(|(key, _)| graph.line(key.forward())).collect();
        prop_assume!(lines.iter().any(|&(c, d)| predicates::crosses_properly(a, b, c, d)));
        let key = graph.add_segment([low, high], 0, smallvec![claim]);
        prop_assert!(breaches(&graph).contains(&Breach::Crossing));
        prop_assert!(graph.check_touched(&[], &[key]).iter().any(|v| v.breach == Breach::Crossing));
        graph.kill_segment(key);
        graph.add_segment([low, high], 1, smallvec![claim]);
        prop_assert_eq!(breaches(&graph), [], "a bridge may pass over anything");
    }

    #[test]
    fn a_second_segment_between_two_nodes_is_found(seed: u64) {
        let mut graph = sample(seed);
        let key = any_segment(&graph, seed);
        let segment = graph.segment(key).clone();
        let twice = graph.add_segment(segment.ends, segment.level, segment.claims);
        let found = breaches(&graph);
        prop_assert!(found.contains(&Breach::Duplicate) && found.contains(&Breach::SegmentIdTwice) && found.contains(&Breach::ArmOrder));
        prop_assert!(graph.check_touched(&[], &[twice]).iter().any(|v| v.breach == Breach::Duplicate));
    }

    #[test]
    fn arms_out_of_order_or_missing_are_found(seed: u64) {
        let mut graph = sample(seed);
        let node = any_node(&graph, seed);
        node_mut(&mut graph, node).arms.swap(0, 1);
        prop_assert_eq!(breaches(&graph), [Breach::ArmOrder]);
        prop_assert_eq!(graph.check_touched(&[node], &[])[0].nodes.clone(), [graph.node(node).id]);
        let lost = node_mut(&mut graph, node).arms.remove(1);
        prop_assert!(breaches(&graph).contains(&Breach::ArmMissing));
        prop_assert!(graph.check_touched(&[], &[lost.segment()]).iter().any(|v| v.breach == Breach::ArmMissing));
    }

    #[test]
    fn what_is_not_there_is_found(seed: u64) {
        let mut graph = sample(seed);
        let (node, segment) = (any_node(&graph, seed), any_segment(&graph, seed));
        let mut other = graph.clone();
        graph.nodes[node.0 as usize] = None;
        prop_assert!(breaches(&graph).iter().all(|&breach| breach == Breach::Dangling));
        other.segments[segment.0 as usize] = None;
        prop_assert_eq!(breaches(&other), [Breach::Dangling, Breach::Dangling], "an arm at each end");
    }

    #[test]
    fn touched_keys_that_are_gone_are_passed_over(seed: u64) {
        let mut graph = sample(seed);
        let key = any_segment(&graph, seed);
        let ends = graph.segment(key).ends;
        graph.kill_segment(key);
        prop_assert_eq!(graph.check_touched(&ends, &[key]), []);
        prop_assert_eq!(graph.check_touched(&[NodeKey(u32::MAX)], &[SegmentKey(u32::MAX >> 1)]), []);
    }

    #[test]
    fn ids_twice_are_found(seed: u64) {
        let mut graph = sample(seed);
        let (a, b) = (any_node(&graph, seed), any_node(&graph, seed.wrapping_add(1)));
        prop_assume!(a != b);
        node_mut(&mut graph, b).id = graph.node(a).id;
        prop_assert_eq!(breaches(&graph), [Breach::Index, Breach::NodeIdTwice]);
    }

    #[test]
    fn a_segment_lost_from_the_index_is_found(seed: u64) {
        let mut graph = sample(seed);
        let key = any_segment(&graph, seed);
        let (a, b) = graph.line(key.forward());
        graph.index.remove(key, a, b);
        let violations = graph.check(CheckLevel::Sweep);
        prop_assert_eq!(violations.len(), 1);
        prop_assert_eq!((violations[0].breach, &violations[0].segments[..]), (Breach::Index, &[graph.witness(key)][..]));
    }

    #[test]
    fn claims_out_of_shape_are_found(seed: u64) {
        let mut graph = sample(seed);
        let key = any_segment(&graph, seed);
        let claim = *graph.segment(key).leading();
        segment_mut(&mut graph, key).claims.push(claim);
        prop_assert_eq!(breaches(&graph), [Breach::ClaimOrder], "a street claims twice");
        segment_mut(&mut graph, key).claims[1] = Claim { street: street(1 << 90), half_width: claim.half_width + 1, ..claim };
        prop_assert_eq!(breaches(&graph), [Breach::ClaimOrder], "the wider comes first");
        segment_mut(&mut graph, key).claims.swap(0, 1);
        prop_assert_eq!(breaches(&graph), []);
        segment_mut(&mut graph, key).claims.clear();
        prop_assert_eq!(breaches(&graph), [Breach::NoClaim]);
        prop_assert_eq!(graph.check_touched(&[], &[key])[0].rule, Rule::V13);
    }
}

#[test]
fn overlaps_and_ends_on_segments_are_crossings() {
    let mut sketch = Sketch::of_chains(&[&[(0, 0), (9000, 0)], &[(0, 0), (5000, 0)]]);
    assert!(breaches(&sketch.build(Seed(1))).contains(&Breach::Crossing), "overlap from a common end");
    sketch.lines[1].ends = [0, 1];
    assert!(breaches(&sketch.build(Seed(1))).contains(&Breach::Duplicate));
    let tee = Sketch::of_chains(&[&[(0, 0), (9000, 0)], &[(5000, 0), (5000, 3000)]]).build(Seed(1));
    assert_eq!(breaches(&tee), [Breach::Crossing, Breach::NodeAtSegment]);
}

#[test]
fn a_map_that_is_not_planar_is_found() {
    let square: &[(i32, i32)] = &[(0, 0), (9000, 0), (9000, 9000), (0, 9000), (0, 0)];
    let graph = Sketch::of_chains(&[square, &[(0, 0), (9000, 9000)], &[(9000, 0), (0, 9000)]]).build(Seed(1));
    let found = graph.check(CheckLevel::Sweep);
    let [crossing, euler] = &found[..] else { panic!("{found:?}") };
    assert_eq!((crossing.rule, crossing.breach, crossing.segments.len()), (Rule::V1, Breach::Crossing, 2));
    // 4 nodes, 6 segments, 2 rims, 1 component.
    assert_eq!((euler.rule, euler.breach, euler.measured), (Rule::V3, Breach::Euler, -2.0));
}

#[test]
fn a_segment_without_length_is_found() {
    let mut graph = Sketch::of_chains(&[&[(0, 0), (9000, 0), (9000, 9000)]]).build(Seed(1));
    let [first, ..] = graph.segments_by_id()[..] else { panic!("two segments") };
    let ends = graph.segment(first).ends;
    node_mut(&mut graph, ends[0]).at = graph.at(ends[1]);
    let found = breaches(&graph);
    assert!(found.contains(&Breach::ZeroLength) && found.contains(&Breach::NodesClose));
}

#[test]
fn bridges_concern_nodes_of_their_own_level_only() {
    let mut sketch = Sketch::of_chains(&[&[(0, 0), (9000, 0)], &[(4000, 30), (4000, 3000)]]);
    sketch.lines[0].level = 1;
    assert_eq!(breaches(&sketch.build(Seed(1))), []);
    let end = sketch.nodes.len();
    sketch.nodes.push(Point::new(6000, 3000));
    sketch.lines.push(Line { level: 1, ..Line::new([2, end], 7) });
    assert_eq!(breaches(&sketch.build(Seed(1))), [Breach::NodeAtSegment]);
}

#[test]
fn sharp_angles_are_flagged_not_refused() {
    let sketch = Sketch::of_chains(&[&[(0, 0), (90_000, 0)], &[(0, 0), (90_000, 7000)], &[(0, 0), (90_000, 20_000)]]);
    let graph = sketch.build(Seed(1));
    assert_eq!(breaches(&graph), []);
    let [flag] = &graph.sharp_angles()[..] else { panic!("one") };
    assert!((flag.degrees - 4.447).abs() < 0.001, "{}", flag.degrees);
    let mut bridged = sketch;
    bridged.lines[1].level = 1;
    assert_eq!(bridged.build(Seed(1)).sharp_angles(), [], "other levels do not count");
}
