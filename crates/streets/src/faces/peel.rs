//! The core of a rim: the simple cycles that are left when dead ends and bridges are taken away.

use crate::{HalfKey, NodeKey, SegmentKey, StreetGraph};

/// What a rim consists of.
#[derive(Default)]
pub(crate) struct Core {
    /// Its cycles, none of which meets a node twice; the face lies on their left.
    pub cycles: Vec<Vec<HalfKey>>,
    /// Nodes where two cycles touch.
    pub pinches: Vec<NodeKey>,
    /// Segments with the face on both sides.
    pub bridges: Vec<SegmentKey>,
}

/// Peels rims; keeps its table between them.
pub(crate) struct Peeler<'a> {
    graph: &'a StreetGraph,
    /// By node: its place on the path being walked. Entries of former paths are told by what lies at their place.
    place: Vec<u32>,
}

impl<'a> Peeler<'a> {
    /// A peeler for the rims of a graph.
    pub fn new(graph: &'a StreetGraph) -> Self {
        Self { graph, place: vec![0; graph.nodes.len()] }
    }

    /// Adds the cycles of a rim to a core. `is_bridge` answers whether a half's twin lies on the same rim.
    pub fn peel(&mut self, rim: &[HalfKey], is_bridge: impl Fn(HalfKey) -> bool, core: &mut Core) {
        if !rim.iter().any(|&half| is_bridge(half)) {
            return self.split_at_pinches(rim, core);
        }
        for walk in without_bridges(rim, is_bridge, &mut core.bridges) {
            self.split_at_pinches(&walk, core);
        }
    }

    /// Splits a closed walk without bridges where it comes back to a node. The visits of two nodes never interleave:
    /// a line inside the face from a node back to itself parts the plane, and the other node lies on one side.
    fn split_at_pinches(&mut self, walk: &[HalfKey], core: &mut Core) {
        let mut path: Vec<HalfKey> = Vec::with_capacity(walk.len());
        for &half in walk {
            let node = self.graph.origin(half);
            let place = self.place[node.0 as usize] as usize;
            if path.get(place).is_some_and(|&before| self.graph.origin(before) == node) {
                core.cycles.push(path.split_off(place));
                core.pinches.push(node);
            }
            self.place[node.0 as usize] = path.len() as u32;
            path.push(half);
        }
        core.cycles.push(path);
    }
}

/// The closed walks that a rim falls into without its bridges. A rim passes a bridge in both directions, and what it
/// walks between the two is a closed walk of its own.
fn without_bridges(
    rim: &[HalfKey],
    is_bridge: impl Fn(HalfKey) -> bool,
    bridges: &mut Vec<SegmentKey>,
) -> Vec<Vec<HalfKey>> {
    let mut walks = Vec::new();
    let mut open = vec![Vec::new()];
    let mut entered = Vec::new();
    for &half in rim {
        let segment = half.segment();
        if !is_bridge(half) {
            open.last_mut().expect("the walk that the rim started with stays open").push(half);
        } else if entered.last() == Some(&segment) {
            entered.pop();
            walks.extend(open.pop());
        } else {
            entered.push(segment);
            bridges.push(segment);
            open.push(Vec::new());
        }
    }
    walks.append(&mut open);
    walks.retain(|walk| !walk.is_empty());
    walks
}
