//! Dead ends taken back after growth: in traffic networks they are the exception (PM01 §3.3.1).

use crate::runs::{Run, runs};
use crate::{Class, NodeKey, SegmentKey, StreetGraph};

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
