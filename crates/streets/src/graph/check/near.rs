//! Pairs of things that may be close: from a grid made for the purpose, so that a fault of the graph's own index
//! cannot hide one.

use super::{StreetGraph, Thing};
use geom::{Bounds, tolerance};

/// Entries that the grid may have for each thing, on the average.
const CELLS_PER_THING: i64 = 8;

/// Calls `f` once for every pair of things whose boxes come closer than the separation (and for some more).
pub(super) fn for_pairs(graph: &StreetGraph, mut f: impl FnMut(Thing, Thing)) {
    let things = things(graph);
    let size = cell_size(&things);
    let mut entries: Vec<((i64, i64), u32)> = Vec::new();
    for (i, (_, bounds)) in things.iter().enumerate() {
        let (from, to) = cells(bounds, size);
        entries.extend((from.0..=to.0).flat_map(|x| (from.1..=to.1).map(move |y| ((x, y), i as u32))));
    }
    entries.sort_unstable();
    for cell in entries.chunk_by(|a, b| a.0 == b.0) {
        for (slot, &(place, i)) in cell.iter().enumerate() {
            for &(_, j) in &cell[slot + 1..] {
                let ((a, a_bounds), (b, b_bounds)) = (things[i as usize], things[j as usize]);
                if a_bounds.overlaps(&b_bounds) && first_common_cell(&a_bounds, &b_bounds, size) == place {
                    f(a, b);
                }
            }
        }
    }
}

/// Calls `f` once for every pair of things.
pub(super) fn for_all_pairs(graph: &StreetGraph, mut f: impl FnMut(Thing, Thing)) {
    let things = things(graph);
    for (i, &(a, _)) in things.iter().enumerate() {
        for &(b, _) in &things[i + 1..] {
            f(a, b);
        }
    }
}

/// All nodes and segments with their boxes, grown by the separation.
fn things(graph: &StreetGraph) -> Vec<(Thing, Bounds)> {
    let nodes = graph.nodes_unsorted().map(|(key, node)| (Thing::Node(key), Bounds::between(node.at, node.at)));
    let segments = graph.segments_unsorted().map(|(key, _)| {
        let (a, b) = graph.line(key.forward());
        (Thing::Segment(key), Bounds::between(a, b))
    });
    nodes.chain(segments).map(|(thing, bounds)| (thing, bounds.grown(tolerance::SEPARATION))).collect()
}

/// The smallest power of two that keeps the grid within its allowance.
fn cell_size(things: &[(Thing, Bounds)]) -> i64 {
    let mut size = i64::from(tolerance::SEPARATION);
    let entries = |size: i64| {
        let count = |(_, bounds): &(Thing, Bounds)| {
            let (from, to) = cells(bounds, size);
            (to.0 - from.0 + 1) * (to.1 - from.1 + 1)
        };
        things.iter().map(count).fold(0, i64::saturating_add)
    };
    while entries(size) > CELLS_PER_THING * things.len() as i64 {
        size *= 2;
    }
    size
}

fn cells(bounds: &Bounds, size: i64) -> ((i64, i64), (i64, i64)) {
    let cell = |v: i32| i64::from(v).div_euclid(size);
    ((cell(bounds.min.x), cell(bounds.min.y)), (cell(bounds.max.x), cell(bounds.max.y)))
}

fn first_common_cell(a: &Bounds, b: &Bounds, size: i64) -> (i64, i64) {
    let (a, b) = (cells(a, size).0, cells(b, size).0);
    (a.0.max(b.0), a.1.max(b.1))
}
