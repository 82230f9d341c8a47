//! A graph as bytes: arenas as they are, so that one read back goes on as the one that was written would have.

use super::index::SegmentIndex;
use super::store::{NodeStreets, SegmentKey};
use super::{Node, NodeKey, Segment, StreetGraph};
use crate::{Classes, StreetId};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The segments of a street, in the order they were laid.
type Laid = SmallVec<[SegmentKey; 4]>;

/// What is kept of a graph; the rest is found from it.
#[derive(Serialize, Deserialize)]
struct Stored<'a> {
    classes: Cow<'a, Classes>,
    nodes: Cow<'a, [Option<Node>]>,
    node_streets: Cow<'a, [NodeStreets]>,
    segments: Cow<'a, [Option<Segment>]>,
    free_nodes: Cow<'a, [u32]>,
    free_segments: Cow<'a, [u32]>,
    streets: BTreeMap<StreetId, Laid>,
}

impl Serialize for StreetGraph {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        debug_assert!(self.log.is_empty() && self.attempts == 0, "no operation is under way");
        let stored = Stored {
            classes: Cow::Borrowed(&self.classes),
            nodes: Cow::Borrowed(&self.nodes),
            node_streets: Cow::Borrowed(&self.node_streets),
            segments: Cow::Borrowed(&self.segments),
            free_nodes: Cow::Borrowed(&self.free_nodes),
            free_segments: Cow::Borrowed(&self.free_segments),
            streets: self.street_segments.iter().map(|(street, laid)| (*street, laid.clone())).collect(),
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for StreetGraph {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = Stored::deserialize(deserializer)?;
        stored.check().map_err(Error::custom)?;
        let mut graph = Self::new(stored.classes.into_owned());
        graph.nodes = stored.nodes.into_owned();
        graph.node_streets = stored.node_streets.into_owned();
        graph.segments = stored.segments.into_owned();
        graph.free_nodes = stored.free_nodes.into_owned();
        graph.free_segments = stored.free_segments.into_owned();
        graph.node_ids = graph.nodes_unsorted().map(|(key, node)| (node.id, key)).collect();
        graph.street_segments = stored.streets.into_iter().collect();
        let mut index = SegmentIndex::default();
        for (key, segment) in graph.segments_unsorted() {
            let [a, b] = segment.ends.map(|end| graph.at(end));
            index.insert(key, a, b);
        }
        graph.index = index;
        Ok(graph)
    }
}

impl Stored<'_> {
    /// Whether all keys name something: a graph that does not hold that panics when it is asked.
    fn check(&self) -> Result<(), &'static str> {
        let node = |key: NodeKey| self.nodes.get(key.0 as usize).is_some_and(Option::is_some);
        let segment = |key: SegmentKey| self.segments.get(key.0 as usize).is_some_and(Option::is_some);
        let count =
            |free: &[u32], all: usize, gone: usize| free.len() == gone && free.iter().all(|&i| (i as usize) < all);
        let gone = self.nodes.iter().filter(|node| node.is_none()).count();
        let gone_segments = self.segments.iter().filter(|segment| segment.is_none()).count();
        let arms = self.nodes.iter().flatten().flat_map(|node| &node.arms);
        let is_whole = count(&self.free_nodes, self.nodes.len(), gone)
            && count(&self.free_segments, self.segments.len(), gone_segments)
            && self.node_streets.len() == self.nodes.len()
            && self.segments.iter().flatten().all(|segment| segment.ends.map(node) == [true; 2])
            && self.segments.iter().flatten().all(|segment| !segment.claims.is_empty())
            && arms.into_iter().all(|arm| segment(arm.segment()))
            && self.streets.values().flatten().all(|&key| segment(key));
        if is_whole { Ok(()) } else { Err("the graph is not whole") }
    }
}

#[cfg(test)]
mod tests {
    use crate::graph::{CheckLevel, Claim, Crowding, NewSegment};
    use crate::{Classes, NodeId, StreetGraph, StreetId};
    use geom::{Id, Point};
    use proptest::collection::vec;
    use proptest::prelude::*;

    type Line = ((i32, i32), (i32, i32));

    fn lines() -> impl Strategy<Value = Vec<Line>> {
        let place = || (0..600_000, 0..600_000);
        vec((place(), place()), 1..30)
    }

    fn lay(graph: &mut StreetGraph, lines: &[Line], first: u64) {
        for (i, &((ax, ay), (bx, by))) in lines.iter().enumerate() {
            let id = Id::root("line", &[]).child(first + i as u64);
            let claim =
                Claim { street: StreetId(id), class: Classes::MINOR, half_width: 4000, origin: 0, forward: true };
            let (from, to) = (Point::new(ax, ay), Point::new(bx, by));
            let (from_id, to_id) = (NodeId(id.child(0)), NodeId(id.child(1)));
            let _ = graph.insert(&NewSegment { from, to, from_id, to_id, claim, level: 0 }, Crowding::Join);
        }
    }

    /// All of a graph, keys included.
    fn arenas(graph: &StreetGraph) -> String {
        format!("{:?} {:?} {:?} {:?}", graph.nodes, graph.node_streets, graph.segments, graph.free_segments)
    }

    proptest! {
        #[test]
        fn one_read_back_goes_on_as_the_one_that_was_written(before in lines(), after in lines(), gone in vec(0usize..30, 0..8)) {
            let mut graph = StreetGraph::new(Classes::default());
            lay(&mut graph, &before, 0);
            for street in gone.iter().filter_map(|&i| graph.streets().get(i).copied()).collect::<Vec<_>>() {
                graph.remove_street(street);
            }
            let bytes = postcard::to_stdvec(&graph).expect("bytes");
            let mut other: StreetGraph = postcard::from_bytes(&bytes).expect("a graph");
            prop_assert_eq!(arenas(&graph), arenas(&other));
            prop_assert_eq!(other.check(CheckLevel::Sweep), Vec::new());
            for graph in [&mut graph, &mut other] {
                lay(graph, &after, 1000);
                for street in graph.streets().into_iter().step_by(3).collect::<Vec<_>>() {
                    graph.remove_street(street);
                }
            }
            prop_assert_eq!(arenas(&graph), arenas(&other));
        }

        #[test]
        fn bytes_that_are_no_graph_are_refused(before in lines(), at in any::<prop::sample::Index>(), byte: u8) {
            let mut graph = StreetGraph::new(Classes::default());
            lay(&mut graph, &before, 0);
            let mut bytes = postcard::to_stdvec(&graph).expect("bytes");
            let at = at.index(bytes.len());
            bytes[at] = byte;
            // Whatever comes out can be asked.
            if let Ok(graph) = postcard::from_bytes::<StreetGraph>(&bytes) {
                let _ = (graph.segments_by_id(), graph.streets(), graph.digest());
            }
        }
    }
}
