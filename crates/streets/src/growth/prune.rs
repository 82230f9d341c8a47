//! What is taken back after growth: dead ends, which are the exception in traffic networks (PM01 §3.3.1), and streets that
//! lead to no others.

use crate::runs::{Run, runs};
use crate::{Class, NodeKey, SegmentKey, StreetGraph};
use rustc_hash::FxHashMap;

/// Removes streets of a class that end nowhere and are shorter than `shorter_than` metres, until there is none: what
/// was left at the end of a removed one may be next. Runs that `keep` admits stay. Returns how many were removed.
pub fn prune_dead_ends(
    graph: &mut StreetGraph,
    class: Class,
    shorter_than: f64,
    keep: &dyn Fn(&StreetGraph, &Run) -> bool,
) -> usize {
    let mut removed = 0;
    loop {
        let needless: Vec<Run> = runs(graph)
            .into_iter()
            .filter(|run| run.class == class && run.level == 0 && ends_nowhere(graph, run))
            .filter(|run| length(graph, run) < shorter_than && !keep(graph, run))
            .collect();
        let round = needless.iter().filter(|run| remove(graph, run)).count();
        if round == 0 {
            return removed;
        }
        removed += round;
    }
}

/// Removes networks (streets that hang together) shorter than so many metres in all, when all of their streets are of one
/// class and none is admitted by `keep`. Returns how many streets were removed.
pub fn prune_networks(
    graph: &mut StreetGraph,
    class: Class,
    shorter_than: f64,
    keep: &dyn Fn(&StreetGraph, &Run) -> bool,
) -> usize {
    let needless: Vec<Run> = networks(graph)
        .into_iter()
        .filter(|network| network.iter().all(|run| run.class == class && !keep(graph, run)))
        .filter(|network| network.iter().fold(0.0, |sum, run| sum + length(graph, run)) < shorter_than)
        .flatten()
        .collect();
    needless.iter().filter(|run| remove(graph, run)).count()
}

/// All runs, those that hang together in one list; lists and what is in them by id.
fn networks(graph: &StreetGraph) -> Vec<Vec<Run>> {
    let mut runs: Vec<Option<Run>> = runs(graph).into_iter().map(Some).collect();
    let mut at_node: FxHashMap<NodeKey, Vec<usize>> = FxHashMap::default();
    for (i, run) in runs.iter().enumerate() {
        for end in run.iter().flat_map(|run| [run.from(), run.to()]) {
            at_node.entry(end).or_default().push(i);
        }
    }
    let mut networks = Vec::new();
    for first in 0..runs.len() {
        let mut network = Vec::new();
        let mut open = vec![first];
        while let Some(next) = open.pop() {
            let Some(run) = runs[next].take() else { continue };
            open.extend([run.from(), run.to()].iter().flat_map(|end| &at_node[end]));
            network.push(run);
        }
        if !network.is_empty() {
            network.sort_unstable_by_key(|run| run.id);
            networks.push(network);
        }
    }
    networks
}

fn ends_nowhere(graph: &StreetGraph, run: &Run) -> bool {
    let is_end = |node: NodeKey| graph.degree(node) == 1;
    is_end(run.from()) || is_end(run.to())
}

fn length(graph: &StreetGraph, run: &Run) -> f64 {
    run.nodes.windows(2).map(|pair| graph.at(pair[0]).distance(graph.at(pair[1]))).sum()
}

/// Whether it was still there: the removal of another may have dissolved the crossing between the two.
fn remove(graph: &mut StreetGraph, run: &Run) -> bool {
    let mut streets: Vec<_> = pieces(graph, run)
        .into_iter()
        .flat_map(|key| graph.segment(key).claims().iter().map(|claim| claim.street))
        .collect();
    streets.sort_unstable();
    streets.dedup();
    let mut has_removed = false;
    for street in streets {
        // Asked for anew each time: to remove one street may join the pieces of another.
        has_removed |= graph.remove_pieces(street, &pieces(graph, run));
    }
    has_removed
}

/// The segments of a run, none when it is no longer what it was.
fn pieces(graph: &StreetGraph, run: &Run) -> Vec<SegmentKey> {
    if !run.nodes.iter().all(|&node| graph.is_live(node)) {
        return Vec::new();
    }
    let between = |pair: &[NodeKey]| graph.segment_between(pair[0], pair[1], run.level);
    run.nodes.windows(2).map(between).collect::<Option<_>>().unwrap_or_default()
}
