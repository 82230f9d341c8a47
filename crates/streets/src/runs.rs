//! Runs: the streets as files and pictures show them, one between two crossings.

use crate::{Class, HalfKey, NodeKey, Segment, SegmentKey, StreetGraph, StreetId};
use geom::Id;

/// What stands for the end at a rim is derived with.
const END: u128 = 0x0065_6e64;

/// A maximal chain of segments between two crossings: nodes of degree other than 2 (segments of all levels counted),
/// or where the most important street, its class, the width, the level or the origin change. A closed loop keeps one
/// crossing, its node of least id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// hash(street, first node, last node, second node, level), where the street of the rim stands for a node in which
    /// this one ends at the rim of its quarter: what streets of the other side lead it to there does not rename it.
    pub id: Id,
    /// The most important street that runs here.
    pub street: StreetId,
    /// Its class.
    pub class: Class,
    /// Half of the widest right-of-way, in LSB.
    pub half_width: i32,
    /// 0 on the ground.
    pub level: i8,
    /// Origin of the leading claim.
    pub origin: u16,
    /// From crossing to crossing, shape points between; the street runs forward from first to last.
    pub nodes: Vec<NodeKey>,
}

impl Run {
    /// The crossing it starts at.
    pub fn from(&self) -> NodeKey {
        self.nodes[0]
    }

    /// The crossing it ends at: `from` for a closed loop.
    pub fn to(&self) -> NodeKey {
        self.nodes[self.nodes.len() - 1]
    }
}

/// All runs of a graph, by id.
pub fn runs(graph: &StreetGraph) -> Vec<Run> {
    let mut seen = vec![false; graph.half_capacity() / 2];
    let mut runs = Vec::new();
    for (key, _) in graph.segments_unsorted() {
        if !seen[key.0 as usize] {
            let halves = chain_through(graph, key);
            for half in &halves {
                seen[half.segment().0 as usize] = true;
            }
            runs.push(run_of(graph, &halves));
        }
    }
    runs.sort_unstable_by_key(|run| run.id);
    make_ids_distinct(graph, &mut runs);
    runs
}

/// Runs of one street that lead between the same rims have their nodes in their ids after all.
fn make_ids_distinct(graph: &StreetGraph, runs: &mut [Run]) {
    let mut is_alike = false;
    for alike in runs.chunk_by_mut(|a, b| a.id == b.id).filter(|alike| alike.len() > 1) {
        is_alike = true;
        for run in alike {
            run.id = id_of(run, |node| graph.node(node).id.0);
        }
    }
    if is_alike {
        runs.sort_unstable_by_key(|run| run.id);
    }
}

/// The nodes where runs start and end, by key, each once.
pub fn crossings(runs: &[Run]) -> Vec<NodeKey> {
    let mut nodes: Vec<_> = runs.iter().flat_map(|run| [run.from(), run.to()]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The halves of the run that a segment belongs to, in the direction of its street.
fn chain_through(graph: &StreetGraph, key: SegmentKey) -> Vec<HalfKey> {
    let start = along_street(graph, key);
    let mut halves = vec![start];
    while let Some(next) = continuation(graph, halves[halves.len() - 1]) {
        if next == start {
            rotate_loop(graph, &mut halves);
            return halves;
        }
        halves.push(next);
    }
    let mut back = Vec::new();
    let mut first = start.twin();
    while let Some(before) = continuation(graph, first) {
        back.push(before.twin());
        first = before;
    }
    back.reverse();
    back.append(&mut halves);
    back
}

/// The half of a segment that runs with its leading street.
fn along_street(graph: &StreetGraph, key: SegmentKey) -> HalfKey {
    if graph.segment(key).leading().forward { key.forward() } else { key.backward() }
}

/// What a run shows of a segment.
fn look(segment: &Segment) -> (StreetId, Class, i32, i8, u16) {
    let leading = segment.leading();
    (leading.street, leading.class, segment.half_width(), segment.level, leading.origin)
}

/// The half that continues the run of `half` beyond its target, unless that is a crossing.
fn continuation(graph: &StreetGraph, half: HalfKey) -> Option<HalfKey> {
    let &[a, b] = graph.halves_ccw(graph.target(half)) else { return None };
    let next = if a == half.twin() { b } else { a };
    let (here, there) = (graph.segment(half.segment()), graph.segment(next.segment()));
    let is_with = |half: HalfKey| along_street(graph, half.segment()) == half;
    (look(here) == look(there) && is_with(half) == is_with(next)).then_some(next)
}

/// Starts a closed loop at its node of least id.
fn rotate_loop(graph: &StreetGraph, halves: &mut [HalfKey]) {
    let id = |half: &HalfKey| graph.node(graph.origin(*half)).id;
    let least = (0..halves.len()).min_by_key(|&i| id(&halves[i])).unwrap_or(0);
    halves.rotate_left(least);
}

fn run_of(graph: &StreetGraph, halves: &[HalfKey]) -> Run {
    let (street, class, half_width, level, origin) = look(graph.segment(halves[0].segment()));
    let mut nodes = vec![graph.origin(halves[0])];
    nodes.extend(halves.iter().map(|&half| graph.target(half)));
    let mut run = Run { id: Id::default(), street, class, half_width, level, origin, nodes };
    run.id = id_of(&run, |node| name_of(graph, &run, node));
    run
}

fn id_of(run: &Run, name: impl Fn(NodeKey) -> Id) -> Id {
    let name = |node| name(node).0;
    run.street.0.with(&[name(run.from()), name(run.to()), name(run.nodes[1]), u128::from(run.level as u8)])
}

/// What the id of a run hangs on at one of its nodes.
fn name_of(graph: &StreetGraph, run: &Run, node: NodeKey) -> Id {
    let closes = |class| graph.classes().info(class).closes_quarters;
    let ends_here = || {
        let has_street = |arm: &&HalfKey| graph.segment(arm.segment()).claims().iter().any(|c| c.street == run.street);
        graph.halves_ccw(node).iter().filter(has_street).count() == 1
    };
    if closes(run.class) || !(node == run.from() || node == run.to()) || !ends_here() {
        return graph.node(node).id.0;
    }
    let arms = graph.halves_ccw(node).iter().map(|&arm| graph.segment(arm.segment()).leading());
    let mut rims = arms.filter(|claim| closes(claim.class)).map(|claim| claim.street);
    // Where several rims meet, their crossing does not hang on what ends there.
    match (rims.next(), rims.next()) {
        (Some(rim), other) if other.is_none_or(|other| other == rim) && rims.all(|more| more == rim) => {
            rim.0.with(&[END])
        }
        _ => graph.node(node).id.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faces::samples::{Sketch, street};
    use crate::{Claim, Classes};
    use geom::Seed;
    use proptest::prelude::*;

    /// The runs of a sketch as places, by street name.
    fn told(sketch: &Sketch, order: u64) -> Vec<(StreetId, Vec<(i32, i32)>)> {
        let graph = sketch.build(Seed(order));
        let place = |&key: &NodeKey| (graph.at(key).x, graph.at(key).y);
        let mut told: Vec<_> =
            runs(&graph).iter().map(|run| (run.street, run.nodes.iter().map(place).collect())).collect();
        told.sort_by_key(|(_, nodes): &(_, Vec<_>)| nodes.clone());
        told
    }

    const BENT: &[(i32, i32)] = &[(0, 0), (1000, 0), (2000, 500), (3000, 0)];

    /// A chain of one street whose segments all run forward.
    fn forward_graph(sketch: &Sketch) -> StreetGraph {
        let mut graph = sketch.build(Seed(1));
        for segment in graph.segments.iter_mut().flatten() {
            if !segment.claims[0].forward {
                segment.ends.swap(0, 1);
                segment.claims[0].forward = true;
            }
        }
        for i in 0..graph.nodes.len() {
            let node = NodeKey(i as u32);
            let arms: Vec<_> = graph.halves_ccw(node).to_vec();
            let fixed = arms.iter().map(|&arm| if graph.origin(arm) == node { arm } else { arm.twin() }).collect();
            graph.nodes[i].as_mut().unwrap().arms = fixed;
        }
        graph
    }

    #[test]
    fn a_run_goes_on_through_shape_points_and_ends_at_crossings() {
        let sketch = Sketch::of_chains(&[BENT, &[(2000, 500), (2000, 3000)]]);
        let expected = [
            (street(0), vec![(0, 0), (1000, 0), (2000, 500)]),
            (street(1), vec![(2000, 500), (2000, 3000)]),
            (street(0), vec![(2000, 500), (3000, 0)]),
        ];
        assert_eq!(told(&sketch, 1), expected);
        assert_eq!(told(&sketch, 2), expected, "keys do not matter");
    }

    #[test]
    fn a_run_ends_where_street_class_width_level_or_origin_change() {
        let sketch = Sketch::of_chains(&[BENT]);
        let changes: [fn(&mut Segment); 5] = [
            |segment| segment.claims[0].street = street(9),
            |segment| segment.claims[0].class = Classes::MINOR,
            |segment| segment.claims[0].half_width += 1,
            |segment| segment.level = 1,
            |segment| segment.claims[0].origin = 7,
        ];
        for change in changes {
            let mut graph = forward_graph(&sketch);
            assert_eq!(runs(&graph).len(), 1);
            let last =
                graph.segments_unsorted().find(|(_, s)| s.ends.map(|end| graph.at(end).x) == [2000, 3000]).unwrap().0;
            change(graph.segments[last.0 as usize].as_mut().unwrap());
            let runs = runs(&graph);
            assert_eq!(runs.iter().map(|run| run.nodes.len()).sum::<usize>(), 5);
            assert_eq!(crossings(&runs).len(), 3);
        }
    }

    #[test]
    fn bridge_ends_are_crossings() {
        let mut sketch = Sketch::of_chains(&[BENT]);
        sketch.lines[1].level = 1;
        let runs = runs(&sketch.build(Seed(4)));
        assert_eq!(runs.iter().map(|run| i32::from(run.level)).sum::<i32>(), 1);
        assert_eq!((runs.len(), crossings(&runs).len()), (3, 4));
    }

    #[test]
    fn a_lesser_street_beside_changes_nothing() {
        let mut graph = forward_graph(&Sketch::of_chains(&[BENT]));
        let claim = *graph.segments[0].as_ref().unwrap().leading();
        let lesser = Claim { street: street(5), class: Classes::MINOR, ..claim };
        graph.segments[0].as_mut().unwrap().claims.push(lesser);
        assert_eq!(runs(&graph).len(), 1);
    }

    #[test]
    fn a_closed_loop_keeps_its_node_of_least_id() {
        let square: &[(i32, i32)] = &[(0, 0), (2000, 0), (2000, 2000), (0, 2000), (0, 0)];
        let graph = Sketch::of_chains(&[square]).build(Seed(5));
        let [run] = &runs(&graph)[..] else { panic!("one run") };
        assert_eq!((run.nodes.len(), run.from()), (5, run.to()));
        assert_eq!(run.from(), graph.nodes_by_id()[0]);
        assert_eq!(crossings(std::slice::from_ref(run)), [run.from()]);
    }

    #[test]
    fn runs_of_one_street_between_the_same_crossings_differ() {
        // One street round two sides of a loop, from (0, 0) to (2000, 0) each time, and over a bridge.
        let mut sketch = Sketch::of_chains(&[
            &[(0, 0), (1000, 1000), (2000, 0)],
            &[(0, 0), (1000, -1000), (2000, 0)],
            &[(0, 0), (2000, 0)],
            &[(0, 0), (2000, 0)],
        ]);
        sketch.lines[5].level = 1;
        sketch.lines.iter_mut().for_each(|line| line.street = 0);
        let runs = runs(&sketch.build(Seed(6)));
        assert_eq!(runs.len(), 4);
        assert!(runs.windows(2).all(|pair| pair[0].id < pair[1].id));
    }

    proptest! {
        #[test]
        fn runs_partition_the_graph(seed: u64, size in 2usize..8, keep in 0.2f64..1.0, names in 0usize..4) {
            let graph = Sketch::random(Seed(seed), size, keep, 700, names).build(Seed(seed));
            let runs = runs(&graph);
            prop_assert!(runs.windows(2).all(|pair| pair[0].id < pair[1].id), "ids differ");
            let mut seen = vec![false; graph.half_capacity() / 2];
            for run in &runs {
                for pair in run.nodes.windows(2) {
                    let key = graph.segment_between(pair[0], pair[1], run.level).expect("a segment");
                    prop_assert!(!std::mem::replace(&mut seen[key.0 as usize], true));
                    let claim = graph.segment(key).leading();
                    prop_assert_eq!((claim.street, claim.class, claim.origin), (run.street, run.class, run.origin));
                    let start = graph.segment(key).ends[usize::from(!claim.forward)];
                    prop_assert_eq!(start, pair[0], "with the street");
                }
                prop_assert!(run.nodes[1..run.nodes.len() - 1].iter().all(|&node| graph.degree(node) == 2));
            }
            prop_assert_eq!(seen.iter().filter(|&&seen| seen).count(), graph.segment_count());
            let mut places: Vec<_> = crossings(&runs).iter().map(|&key| graph.at(key)).collect();
            places.sort_unstable();
            let busy = graph.nodes_unsorted().filter(|(_, node)| node.arms.len() != 2).map(|(_, node)| node.at);
            prop_assert!(busy.into_iter().all(|at| places.binary_search(&at).is_ok()));
        }
    }
}
