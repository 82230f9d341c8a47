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
